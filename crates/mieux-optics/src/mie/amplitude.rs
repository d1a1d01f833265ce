//! Amplitudes over angle, several angles abreast.

use std::f64::consts::PI;

use num_complex::Complex64;
use pulp::{Simd, WithSimd};

use super::coefficients::Coefficients;
use super::lanes::{LaneArray, MAX_LANES, Re};

/// Scattering angles, prepared once for any number of particles. Angles that mirror each other about 90 degrees share
/// their work.
#[derive(Debug, Clone)]
pub struct Directions {
    cosines: Vec<f64>,
    /// Moduli of the cosines, each once, filled up to whole registers.
    folded: Vec<LaneArray>,
    /// For every cosine its place among the moduli.
    places: Vec<usize>,
}

/// Elements of the normalised Mueller matrix at one angle; `p22 = p11` and `p44 = p33` for spheres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mueller {
    /// Phase function, 1/sr: integrates to 1 over the sphere.
    pub p11: f64,
    /// Linear polarisation from unpolarised light is `-p12 / p11`, 1/sr.
    pub p12: f64,
    /// 1/sr
    pub p33: f64,
    /// 1/sr
    pub p34: f64,
}

impl Directions {
    /// Cosines of scattering angles, each in -1..=1 (others are drawn to the nearer end; NaN counts as 1), in any order.
    pub fn new(cosines: impl IntoIterator<Item = f64>) -> Self {
        let clean = |mu: f64| if mu.is_nan() { 1.0 } else { mu.clamp(-1.0, 1.0) };
        let cosines: Vec<f64> = cosines.into_iter().map(clean).collect();
        let mut moduli: Vec<f64> = cosines.iter().map(|mu| mu.abs()).collect();
        moduli.sort_unstable_by(f64::total_cmp);
        moduli.dedup();
        let place = |mu: &f64| moduli.partition_point(|m| *m < mu.abs());
        let places = cosines.iter().map(place).collect();
        let folded =
            moduli.chunks(MAX_LANES).map(|chunk| std::array::from_fn(|i| chunk[i.min(chunk.len() - 1)])).collect();
        Self { cosines, folded, places }
    }

    /// `count` angles in equal steps from 0 to 180 degrees, both included.
    pub fn uniform(count: usize) -> Self {
        let last = count.max(2) - 1;
        let cosine = |i: usize| (PI * i as f64 / last as f64).cos();
        // Mirrored exactly, so that the halves share their work.
        let fold = |i: usize| {
            if 2 * i == last {
                0.0
            } else if 2 * i < last {
                cosine(i)
            } else {
                -cosine(last - i)
            }
        };
        Self::new((0..count).map(fold))
    }

    /// The cosines, in the order given.
    pub fn cosines(&self) -> &[f64] {
        &self.cosines
    }
}

impl Coefficients {
    /// Amplitudes `[S1, S2]` (eq 4.74 of `bohren1983`, eq 11-12 of `frisvad2007`) for every direction.
    ///
    /// They overflow where the host absorbs more than `exp(-680)`, which no particle that can be made does.
    pub fn amplitudes(&self, directions: &Directions) -> Vec<[Complex64; 2]> {
        let factor = self.factor();
        self.stored_amplitudes(directions).into_iter().map(|s| s.map(|s| s * factor)).collect()
    }

    /// Mueller matrix elements for every direction, normalised so that `p11` is the phase function.
    pub fn mueller(&self, directions: &Directions) -> Vec<Mueller> {
        let norm = if self.norm() > 0.0 { 1.0 / (2.0 * PI * self.norm()) } else { 0.0 };
        let element = |[s1, s2]: [Complex64; 2]| {
            let cross = s2 * s1.conj();
            Mueller {
                p11: 0.5 * norm * (s1.norm_sqr() + s2.norm_sqr()),
                p12: 0.5 * norm * (s2.norm_sqr() - s1.norm_sqr()),
                p33: norm * cross.re,
                p34: norm * cross.im,
            }
        };
        self.stored_amplitudes(directions).into_iter().map(element).collect()
    }

    /// Phase function in 1/sr for every direction.
    pub fn phase_function(&self, directions: &Directions) -> Vec<f64> {
        self.mueller(directions).into_iter().map(|m| m.p11).collect()
    }

    /// Amplitudes without the factor that the stored coefficients lack.
    pub(super) fn stored_amplitudes(&self, directions: &Directions) -> Vec<[Complex64; 2]> {
        pulp::Arch::new().dispatch(Fold { terms: &self.terms, directions })
    }
}

/// `c_n (a_n + b_n)` and `c_n (a_n - b_n)` with `c_n = (2n + 1) / (n (n + 1))`, and `n`.
struct Factors {
    n: f64,
    /// `(n + 1) / n`
    rise: f64,
    plus: Complex64,
    minus: Complex64,
}

struct Fold<'a> {
    terms: &'a [[Complex64; 2]],
    directions: &'a Directions,
}

/// `S1 + S2` and `S1 - S2` at `mu`, then at `-mu`: real and imaginary parts.
type Folded<T> = [T; 8];

impl WithSimd for Fold<'_> {
    type Output = Vec<[Complex64; 2]>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let factors: Vec<Factors> = self
            .terms
            .iter()
            .enumerate()
            .map(|(i, [a, b])| {
                let n = i as f64 + 1.0;
                let c = (2.0 * n + 1.0) / (n * (n + 1.0));
                Factors { n, rise: (n + 1.0) / n, plus: (a + b) * c, minus: (a - b) * c }
            })
            .collect();
        let mut folded: Vec<Folded<LaneArray>> = Vec::with_capacity(self.directions.folded.len());
        for lanes in &self.directions.folded {
            let mut out = [[0.0; MAX_LANES]; 8];
            // A register at a time; on a machine with narrow ones several times per array.
            for first in (0..MAX_LANES).step_by(S::F64_LANES) {
                let mut mu = [0.0; MAX_LANES];
                mu[..S::F64_LANES].copy_from_slice(&lanes[first..first + S::F64_LANES]);
                let sums = fold(&factors, Re::load(simd, &mu));
                for (out, sum) in out.iter_mut().zip(sums) {
                    out[first..first + S::F64_LANES].copy_from_slice(&sum.lanes()[..S::F64_LANES]);
                }
            }
            folded.push(out);
        }
        let unfold = |(mu, place): (&f64, &usize)| {
            let lane = |k: usize| folded[place / MAX_LANES][k][place % MAX_LANES];
            let k = if mu.is_sign_negative() { 4 } else { 0 };
            let (plus, minus) = (Complex64::new(lane(k), lane(k + 1)), Complex64::new(lane(k + 2), lane(k + 3)));
            [0.5 * (plus + minus), 0.5 * (plus - minus)]
        };
        self.directions.cosines.iter().zip(&self.directions.places).map(unfold).collect()
    }
}

/// With `s = pi_n + tau_n` and `d = pi_n - tau_n`, which trade places with the sign `(-1)^(n+1)` as `mu` changes its own,
/// `S1 + S2` is the sum of `c_n (a_n + b_n) s` and `S1 - S2` that of `c_n (a_n - b_n) d`.
#[inline(always)]
fn fold<S: Simd>(factors: &[Factors], mu: Re<S>) -> Folded<Re<S>> {
    let zero = mu.same(0.0);
    let mut out = [zero; 8];
    let (mut before, mut pi) = (zero, mu.same(1.0));
    let mut odd = true;
    for f in factors {
        let s = mu * pi;
        let t = s - before;
        let tau = mu.same(f.n).mul_add(t, zero - before);
        let (sum, difference) = (pi + tau, pi - tau);
        for (k, c) in [f.plus.re, f.plus.im].into_iter().enumerate() {
            out[k] = mu.same(c).mul_add(sum, out[k]);
            out[k + 4] = mu.same(if odd { c } else { -c }).mul_add(difference, out[k + 4]);
        }
        for (k, c) in [f.minus.re, f.minus.im].into_iter().enumerate() {
            out[k + 2] = mu.same(c).mul_add(difference, out[k + 2]);
            out[k + 6] = mu.same(if odd { c } else { -c }).mul_add(sum, out[k + 6]);
        }
        (before, pi) = (pi, mu.same(f.rise).mul_add(t, s));
        odd = !odd;
    }
    out
}
