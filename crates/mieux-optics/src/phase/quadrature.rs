//! Legendre polynomials, Gauss-Legendre rules, and integrals over the sphere that see a forward peak.
//!
//! Integrals run over `away = 1 - cos(theta)` in [0, 2], so that a narrow forward peak keeps its digits.

use std::f64::consts::PI;

use crate::integrate::gauss_legendre;

/// The Legendre polynomial of a degree at `x` in [-1, 1], by the upward recurrence (stable there).
pub(super) fn legendre(degree: u32, x: f64) -> f64 {
    let (mut before, mut now) = (1.0, x);
    if degree == 0 {
        return 1.0;
    }
    for l in 1..degree {
        (before, now) = (now, next_legendre(l, x, before, now));
    }
    now
}

/// `P_{l+1}` from `P_{l-1}` and `P_l`.
fn next_legendre(l: u32, x: f64, before: f64, now: f64) -> f64 {
    let l = f64::from(l);
    ((2.0 * l + 1.0) * x * now - l * before) / (l + 1.0)
}

/// Edges in `away` that halve towards forward and towards backward: peaks of any width fall into some panel.
pub(super) fn graded_edges() -> Vec<f64> {
    const HALVINGS: i32 = 52;
    let forward = (1..=HALVINGS).rev().map(|k| 2f64.powi(1 - k));
    let backward = (2..HALVINGS).map(|k| 2.0 - 2f64.powi(1 - k));
    std::iter::once(0.0).chain(forward).chain(backward).chain(std::iter::once(2.0)).collect()
}

/// Ascending union of two sets of edges.
pub(super) fn merge_edges(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut edges: Vec<f64> = a.iter().chain(b).copied().collect();
    edges.sort_by(f64::total_cmp);
    edges.dedup();
    edges
}

/// Visits Gauss nodes of every panel between `edges` (in `away`), enough of them that a function that is smooth over
/// a panel, times a Legendre polynomial of `degree`, is integrated to rounding: `f(panel, away, weight)`, where the
/// weight is `2 pi d away`, a solid angle.
pub(super) fn visit(edges: &[f64], degree: u32, mut f: impl FnMut(usize, f64, f64)) {
    let smooth = 12 + degree / 2;
    let mut rules: Vec<Vec<(f64, f64)>> = Vec::new();
    for (panel, pair) in edges.windows(2).enumerate() {
        let (middle, half) = (0.5 * (pair[0] + pair[1]), 0.5 * (pair[1] - pair[0]));
        // The polynomial turns through degree * (angle of the panel); a wave needs pi nodes, and a few to settle.
        let turn = f64::from(degree) * (polar(pair[1]) - polar(pair[0]));
        let nodes = (14.0 + 0.6 * turn).min(f64::from(smooth)) as usize;
        if rules.len() <= nodes {
            rules.resize(nodes + 1, Vec::new());
        }
        if rules[nodes].is_empty() {
            rules[nodes] = gauss_legendre(nodes);
        }
        for &(x, w) in &rules[nodes] {
            f(panel, middle + half * x, 2.0 * PI * half * w);
        }
    }
}

/// `<P_degree>` of a density in 1/sr given by panel and `away`.
pub(super) fn moment(edges: &[f64], degree: u32, mut density: impl FnMut(usize, f64) -> f64) -> f64 {
    let mut sum = 0.0;
    visit(edges, degree, |panel, away, weight| sum += weight * density(panel, away) * legendre(degree, 1.0 - away));
    sum
}

/// All `<P_l>` for l from 0 to `max_degree` in one pass.
pub(super) fn moments(edges: &[f64], max_degree: u32, mut density: impl FnMut(usize, f64) -> f64) -> Vec<f64> {
    let mut sums = vec![0.0; max_degree as usize + 1];
    visit(edges, max_degree, |panel, away, weight| {
        let (part, x) = (weight * density(panel, away), 1.0 - away);
        let (mut now, mut next) = (1.0, x);
        for (l, sum) in sums.iter_mut().enumerate() {
            *sum += part * now;
            (now, next) = (next, next_legendre(l as u32 + 1, x, now, next));
        }
    });
    sums
}

/// The angle theta whose `1 - cos(theta)` is `away`, without cancellation near forward.
pub(super) fn polar(away: f64) -> f64 {
    2.0 * (0.5 * away).clamp(0.0, 1.0).sqrt().asin()
}

/// `1 - cos(theta)` without cancellation near forward.
pub(super) fn away_of(theta: f64) -> f64 {
    let s = (0.5 * theta).sin();
    2.0 * s * s
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_rules_integrate_their_degree_exactly() {
        for n in [1u32, 2, 5, 16, 40] {
            let rule = gauss_legendre(n as usize);
            for power in 0..2 * n {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(power as i32)).sum();
                let exact = if power % 2 == 1 { 0.0 } else { 2.0 / f64::from(power + 1) };
                assert!((sum - exact).abs() < 1e-13, "{n} nodes, power {power}: {sum}");
            }
        }
    }

    #[test]
    fn legendre_polynomials_are_orthogonal_over_the_graded_sphere() {
        let edges = graded_edges();
        assert!(edges.windows(2).all(|p| p[0] < p[1]) && edges[0] == 0.0 && edges[edges.len() - 1] == 2.0);
        for (l, k) in [(0, 0), (1, 1), (3, 5), (7, 7), (60, 60), (60, 58), (200, 200)] {
            let mut sum = 0.0;
            visit(&edges, l + k, |_, a, w| sum += w * legendre(l, 1.0 - a) * legendre(k, 1.0 - a) / (2.0 * PI));
            let exact = if l == k { 2.0 / (2.0 * f64::from(l) + 1.0) } else { 0.0 };
            assert!((sum - exact).abs() < 1e-12, "{l} {k}: {sum} {exact}");
        }
    }

    #[test]
    fn the_angle_and_its_distance_from_forward_invert_each_other() {
        for theta in [0.0, 1e-9, 1e-3, 1.0, 3.0, PI] {
            assert!((polar(away_of(theta)) - theta).abs() <= 1e-7 * theta);
        }
        assert!((polar(away_of(1e-9)) / 1e-9 - 1.0).abs() < 1e-14);
    }
}
