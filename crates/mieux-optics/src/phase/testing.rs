//! What every phase function must pass. Everything is judged against numerical integrals of `value`, never against a
//! sampler's own cumulative distribution.

pub(crate) mod sphere;

use std::convert::Infallible;
use std::f64::consts::PI;

use super::{PhaseFunction, quadrature};
use crate::integrate::integrate;

/// Uniform numbers in [0, 1): splitmix64 (`steele2014`).
pub(crate) struct Uniform(u64);

impl Uniform {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / 2f64.powi(53)
    }
}

/// Share of light within each panel of the phase function's own edges.
fn panel_shares(phase: &PhaseFunction) -> (Vec<f64>, Vec<f64>) {
    let edges = phase.edges();
    let mut shares = vec![0.0; edges.len() - 1];
    quadrature::visit(&edges, 0, |panel, away, weight| shares[panel] += weight * phase.value_away(away));
    (edges, shares)
}

/// Edges in `1 - mu` of bins of equal probability, by integrating `value` and halving inside a panel.
fn equal_bins(phase: &PhaseFunction, bins: usize) -> Vec<f64> {
    let (edges, shares) = panel_shares(phase);
    let rule = crate::integrate::gauss_legendre(12);
    let part = |from: f64, to: f64| -> f64 {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        rule.iter().map(|(x, w)| 2.0 * PI * half * w * phase.value_away(middle + half * x)).sum()
    };
    let (mut panel, mut below) = (0, 0.0);
    (1..bins)
        .map(|k| {
            let wanted = k as f64 / bins as f64;
            while below + shares[panel] < wanted && panel + 1 < shares.len() {
                below += shares[panel];
                panel += 1;
            }
            let (mut low, mut high) = (edges[panel], edges[panel + 1]);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if below + part(edges[panel], middle) < wanted { low = middle } else { high = middle }
            }
            0.5 * (low + high)
        })
        .collect()
}

/// Normalisation, moments, chi-squared, sampled mean.
pub(crate) fn check(phase: &PhaseFunction) {
    let (_, shares) = panel_shares(phase);
    let total: f64 = shares.iter().sum();
    assert!((total - 1.0).abs() < 1e-10, "{phase}: integrates to 1 + {:e}", total - 1.0);
    let edges = phase.edges();
    let moments = quadrature::moments(&edges, 30, |_, away| phase.value_away(away));
    for (l, quadrature) in moments.iter().enumerate() {
        let own = phase.legendre_moment(l as u32);
        assert!((own - quadrature).abs() < 2e-10, "{phase}: moment {l} is {own}, by quadrature {quadrature}");
    }
    assert!((phase.asymmetry() - phase.legendre_moment(1)).abs() < 1e-12, "{phase}");
    for mu in [-1.0, -0.6, 0.0, 0.3, 0.75, 1.0] {
        let (value, again) = (phase.value(mu), phase.value_away(1.0 - mu));
        assert!((value - again).abs() <= 1e-14 * value, "{phase} at {mu}");
        assert_eq!(phase.value(mu), phase.pdf(mu));
    }
    let bins = equal_bins(phase, 50);
    for seed in 1..=3 {
        chi_squared(phase, &bins, seed);
    }
}

fn chi_squared(phase: &PhaseFunction, edges: &[f64], seed: u64) {
    let samples = 50_000;
    let bins = edges.len() + 1;
    let mut uniform = Uniform::new(seed);
    let mut counts = vec![0u32; bins];
    let mut mean = 0.0;
    for _ in 0..samples {
        let mu = phase.sample(uniform.next());
        assert!((-1.0..=1.0).contains(&mu), "{phase}: {mu}");
        mean += mu / f64::from(samples);
        counts[edges.partition_point(|&edge| edge <= 1.0 - mu)] += 1;
    }
    let expected = f64::from(samples) / bins as f64;
    let chi2: f64 = counts.iter().map(|&count| (f64::from(count) - expected).powi(2) / expected).sum();
    // 49 degrees of freedom: 99.99 % lie below 96.
    assert!(chi2 < 96.0, "{phase} seed {seed}: chi-squared {chi2}");
    let (g, square) = (phase.asymmetry(), (1.0 + 2.0 * phase.legendre_moment(2)) / 3.0);
    let deviation = (square - g * g).max(0.0).sqrt() / f64::from(samples).sqrt();
    assert!((mean - g).abs() < 5.0 * deviation + 1e-12, "{phase} seed {seed}: mean {mean}, g {g}");
}

/// The mean of `sample(xi)` over `xi`, integrated numerically, is the mean cosine; `breaks` are the places in (0, 1)
/// where `xi` passes from one lobe to the next.
pub(crate) fn check_inverse(phase: &PhaseFunction, breaks: &[f64]) {
    let mut breaks: Vec<f64> = breaks.iter().copied().filter(|b| *b > 0.0 && *b < 1.0).collect();
    breaks.extend([0.0, 1.0]);
    breaks.sort_by(f64::total_cmp);
    // Halving towards the ends of every lobe, where the inverse is steep.
    let mut knots = Vec::new();
    for pair in breaks.windows(2) {
        knots.extend(quadrature::graded_edges().iter().map(|edge| pair[0] + 0.5 * (pair[1] - pair[0]) * edge));
    }
    knots.dedup();
    let mean = integrate::<1, Infallible>(&knots, 1e-10, [1.0], |xi| Ok([phase.sample(xi)])).unwrap();
    let mean = mean.unwrap_or_else(|| panic!("{phase}: no convergence")).value[0];
    let g = phase.asymmetry();
    assert!((mean - g).abs() < 1e-9, "{phase}: the samples' mean is {mean}, g is {g}");
}
