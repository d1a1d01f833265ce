//! Amplitudes over angle, several angles abreast.

use std::f64::consts::PI;

use num_complex::Complex64;
use pulp::{Simd, WithSimd};

use super::MieError;
use super::coefficients::Coefficients;
use crate::lanes::{LaneArray, MAX_LANES, Re};

/// Scattering angles, prepared once for any number of particles. Angles that mirror each other about 90 degrees share
/// their work.
#[derive(Debug, Clone)]
pub struct Directions {
    cosines: Vec<f64>,
    folded: Vec<Folded>,
}

/// Moduli of cosines abreast, and which directions have them.
#[derive(Debug, Clone)]
struct Folded {
    moduli: LaneArray,
    uses: Vec<Use>,
}

/// A direction that has the modulus of one lane.
#[derive(Debug, Clone, Copy)]
struct Use {
    direction: usize,
    lane: usize,
    backward: bool,
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
        let mut order: Vec<usize> = (0..cosines.len()).collect();
        order.sort_by(|&i, &j| cosines[i].abs().total_cmp(&cosines[j].abs()));
        let mut folded: Vec<Folded> = Vec::new();
        let (mut lane, mut last) = (MAX_LANES, f64::NAN);
        for direction in order {
            let mu = cosines[direction];
            if mu.abs() != last {
                (lane, last) = (lane + 1, mu.abs());
                if lane >= MAX_LANES {
                    folded.push(Folded { moduli: [last; MAX_LANES], uses: Vec::new() });
                    lane = 0;
                }
            }
            if let Some(block) = folded.last_mut() {
                block.moduli[lane] = last;
                block.uses.push(Use { direction, lane, backward: mu.is_sign_negative() });
            }
        }
        Self { cosines, folded }
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
    /// # Errors
    /// [`MieError::Cancellation`] where the host absorbs so much that forward amplitudes are lost to rounding.
    pub fn amplitudes(&self, directions: &Directions) -> Result<Vec<[Complex64; 2]>, MieError> {
        let mut amplitudes = self.stored_amplitudes(directions)?;
        if self.scaled {
            let factor = self.factor();
            amplitudes.iter_mut().flatten().for_each(|s| *s *= factor);
        }
        Ok(amplitudes)
    }

    /// Mueller matrix elements for every direction, normalised so that `p11` is the phase function.
    ///
    /// # Errors
    /// As for [`Self::amplitudes`].
    pub fn mueller(&self, directions: &Directions) -> Result<Vec<Mueller>, MieError> {
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
        Ok(self.stored_amplitudes(directions)?.into_iter().map(element).collect())
    }

    /// Phase function in 1/sr for every direction.
    ///
    /// # Errors
    /// As for [`Self::amplitudes`].
    pub fn phase_function(&self, directions: &Directions) -> Result<Vec<f64>, MieError> {
        Ok(self.mueller(directions)?.into_iter().map(|m| m.p11).collect())
    }

    /// Amplitudes without the factor that the stored coefficients lack.
    pub(super) fn stored_amplitudes(&self, directions: &Directions) -> Result<Vec<[Complex64; 2]>, MieError> {
        if self.scaled {
            self.scattering()?;
        }
        Ok(pulp::Arch::new().dispatch(Fold { terms: &self.terms, directions }))
    }
}

/// What the sums over angle take from one order.
#[derive(Clone, Copy, Default)]
struct Factors {
    n: f64,
    /// `1 / n`
    inverse: f64,
    /// `c_n a_n` and `c_n b_n` with `c_n = (2n + 1) / (n (n + 1))`: real and imaginary parts.
    scaled: [f64; 4],
}

impl Factors {
    fn new((i, [a, b]): (usize, &[Complex64; 2])) -> Self {
        let n = i as f64 + 1.0;
        let c = (2.0 * n + 1.0) / (n * (n + 1.0));
        let scaled = [a.re * c, a.im * c, b.re * c, b.im * c];
        Self { n, inverse: 1.0 / n, scaled }
    }
}

/// Sums over orders of `c_n a_n pi_n` and `c_n b_n pi_n`, then of the same with `tau_n`: real and imaginary parts.
type Sums<T> = [T; 8];

struct Fold<'a> {
    terms: &'a [[Complex64; 2]],
    directions: &'a Directions,
}

impl WithSimd for Fold<'_> {
    type Output = Vec<[Complex64; 2]>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let mut factors: Vec<Factors> = self.terms.iter().enumerate().map(Factors::new).collect();
        if factors.len() % 2 == 1 {
            factors.push(Factors::default());
        }
        let mut amplitudes = vec![[Complex64::ZERO; 2]; self.directions.cosines.len()];
        for Folded { moduli, uses } in &self.directions.folded {
            let mut sums = [[[0.0; MAX_LANES]; 8]; 2];
            // A register at a time; on a machine with narrow ones several times per array.
            for first in (0..MAX_LANES).step_by(S::F64_LANES) {
                let mut mu = [0.0; MAX_LANES];
                mu[..S::F64_LANES].copy_from_slice(&moduli[first..first + S::F64_LANES]);
                for (sums, folded) in sums.iter_mut().zip(fold(&factors, Re::load(simd, &mu))) {
                    for (sum, folded) in sums.iter_mut().zip(folded) {
                        sum[first..first + S::F64_LANES].copy_from_slice(&folded.lanes()[..S::F64_LANES]);
                    }
                }
            }
            for Use { direction, lane, backward } in uses {
                amplitudes[*direction] = unfold(&sums, *lane, *backward);
            }
        }
        amplitudes
    }
}

/// Orders that are added up by themselves, so that rounding does not grow with their number; even.
const RUN: usize = 512;

/// Sums over odd and over even orders at non-negative cosines.
#[inline(always)]
fn fold<S: Simd>(factors: &[Factors], mu: Re<S>) -> [Sums<Re<S>>; 2] {
    let zero = mu.same(0.0);
    let mut total = [[zero; 8]; 2];
    let mut wave = Angular { mu, twice: mu + mu, before: zero, pi: mu.same(1.0) };
    for run in factors.chunks(RUN) {
        let (mut odd, mut even) = ([zero; 8], [zero; 8]);
        for pair in run.chunks_exact(2) {
            wave.add(&pair[0], &mut odd);
            wave.add(&pair[1], &mut even);
        }
        for k in 0..8 {
            total[0][k] = total[0][k] + odd[k];
            total[1][k] = total[1][k] + even[k];
        }
    }
    total
}

/// `pi_{n-1}` and `pi_n` on their way up.
struct Angular<S: Simd> {
    mu: Re<S>,
    twice: Re<S>,
    before: Re<S>,
    pi: Re<S>,
}

impl<S: Simd> Angular<S> {
    #[inline(always)]
    fn add(&mut self, f: &Factors, sums: &mut Sums<Re<S>>) {
        let Self { mu, twice, before, pi } = *self;
        let minus = mu.same(0.0) - before;
        let t = mu.mul_add(pi, minus);
        let s = twice.mul_add(pi, minus);
        let tau = mu.same(f.n).mul_add(t, minus);
        for k in 0..4 {
            let factor = mu.same(f.scaled[k]);
            sums[k] = factor.mul_add(pi, sums[k]);
            sums[k + 4] = factor.mul_add(tau, sums[k + 4]);
        }
        // s + t / n, which unlike (2n + 1)/n and (n + 1)/n is not biased by the rounding of a factor.
        (self.before, self.pi) = (pi, mu.same(f.inverse).mul_add(t, s));
    }
}

/// `S1` and `S2`, by the symmetries `pi_n(-mu) = (-1)^(n+1) pi_n(mu)` and `tau_n(-mu) = (-1)^n tau_n(mu)`.
fn unfold([odd, even]: &[Sums<LaneArray>; 2], lane: usize, backward: bool) -> [Complex64; 2] {
    let at = |sums: &Sums<LaneArray>, k: usize| Complex64::new(sums[k][lane], sums[k + 1][lane]);
    let sum = |k: usize| if backward { at(odd, k) - at(even, k) } else { at(odd, k) + at(even, k) };
    let (a_pi, b_pi, a_tau, b_tau) = (sum(0), sum(2), sum(4), sum(6));
    if backward { [a_pi - b_tau, b_pi - a_tau] } else { [a_pi + b_tau, a_tau + b_pi] }
}
