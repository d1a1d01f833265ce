//! Amplitudes over angle, several angles abreast.

use std::f64::consts::PI;

use num_complex::Complex64;
use pulp::{Simd, WithSimd};

use super::MieError;
use super::coefficients::Coefficients;
use crate::lanes::{MAX_LANES, Re, Wave};

/// Scattering angles, prepared once for any number of particles. Angles that mirror each other about 90 degrees share
/// their work.
#[derive(Debug, Clone)]
pub struct Directions {
    cosines: Vec<f64>,
    /// Moduli of cosines, ascending, each once; the last fills what tiles of any width leave.
    moduli: Vec<f64>,
    /// In the order of the moduli.
    uses: Vec<Use>,
}

/// A direction and the place of its modulus.
#[derive(Debug, Clone, Copy)]
struct Use {
    direction: usize,
    place: usize,
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
        let mut moduli: Vec<f64> = Vec::new();
        let mut uses = Vec::with_capacity(order.len());
        for direction in order {
            let mu = cosines[direction];
            if moduli.last() != Some(&mu.abs()) {
                moduli.push(mu.abs());
            }
            uses.push(Use { direction, place: moduli.len() - 1, backward: mu.is_sign_negative() });
        }
        let last = moduli.last().copied().unwrap_or(1.0);
        moduli.resize(moduli.len().next_multiple_of(TILE * MAX_LANES), last);
        Self { cosines, moduli, uses }
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

/// Registers of angles that go through the sums together: as many as let four sums of each stay in registers, which are
/// enough that none waits for its last step.
const TILE: usize = 2;

/// Orders that are gone through at a time, even: what is kept of them fits the nearest cache. Each block is added up by
/// itself, so that rounding does not grow with the number of orders.
const BLOCK: usize = 64;

/// One number per angle of a tile.
type Tile<S> = [Re<S>; TILE];

/// Sums over orders of one parity, with `pi_n` and with `tau_n`: of real and imaginary parts of `c_n a_n` and `c_n b_n`.
type Sums<S> = [[Tile<S>; 4]; 2];

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
        let Directions { cosines, moduli, uses } = self.directions;
        let mut amplitudes = vec![[Complex64::ZERO; 2]; cosines.len()];
        let mut kept = [[[Re::splat(simd, 0.0); TILE]; 2]; BLOCK];
        let mut rest = uses.as_slice();
        let width = TILE * S::F64_LANES;
        for (k, moduli) in moduli.chunks_exact(width).enumerate() {
            let first = k * width;
            if rest.is_empty() {
                break;
            }
            let mu = std::array::from_fn(|v| {
                let mut mu = [0.0; MAX_LANES];
                mu[..S::F64_LANES].copy_from_slice(&moduli[v * S::F64_LANES..][..S::F64_LANES]);
                Re::load(simd, &mu)
            });
            let found = unfold(&fold(&factors, mu, &mut kept));
            while let Some((Use { direction, place, backward }, others)) = rest.split_first() {
                let at = place - first;
                if at >= width {
                    break;
                }
                let [s1_re, s1_im, s2_re, s2_im] = &found[usize::from(*backward)];
                amplitudes[*direction] = [Complex64::new(s1_re[at], s1_im[at]), Complex64::new(s2_re[at], s2_im[at])];
                rest = others;
            }
        }
        amplitudes
    }
}

/// Sums over odd and over even orders at non-negative cosines.
///
/// Block by block first the functions of angle, whose every step waits for the one before, then the sums.
#[inline(always)]
fn fold<S: Simd>(factors: &[Factors], mu: Tile<S>, kept: &mut [[Tile<S>; 2]; BLOCK]) -> [Sums<S>; 2] {
    let zero = mu[0].same(0.0);
    let mut total = [[[[zero; TILE]; 4]; 2]; 2];
    let [mut first, mut second] = mu.map(Angular::new);
    for factors in factors.chunks(BLOCK) {
        for (f, kept) in factors.iter().zip(kept.iter_mut()) {
            let (one, two) = (first.next(f), second.next(f));
            *kept = [[one.0, two.0], [one.1, two.1]];
        }
        for (parity, total) in total.iter_mut().enumerate() {
            for (kind, total) in total.iter_mut().enumerate() {
                let sums = products(factors, kept, parity, kind);
                for k in 0..4 {
                    for v in 0..TILE {
                        total[k][v] = total[k][v] + sums[k][v];
                    }
                }
            }
        }
    }
    total
}

/// Sums over one block.
#[inline(always)]
fn products<S: Simd>(factors: &[Factors], kept: &[[Tile<S>; 2]; BLOCK], parity: usize, kind: usize) -> [Tile<S>; 4] {
    let zero = kept[0][0][0].same(0.0);
    let mut sums = [[zero; TILE]; 4];
    for (pair, kept) in factors.chunks_exact(2).zip(kept.chunks_exact(2)) {
        let (factors, angular) = (&pair[parity].scaled, kept[parity][kind]);
        for k in 0..4 {
            let factor = zero.same(factors[k]);
            for v in 0..TILE {
                sums[k][v] = factor.mul_add(angular[v], sums[k][v]);
            }
        }
    }
    sums
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
    fn new(mu: Re<S>) -> Self {
        Self { mu, twice: mu + mu, before: mu.same(0.0), pi: mu.same(1.0) }
    }

    /// `pi_n` and `tau_n`.
    #[inline(always)]
    fn next(&mut self, f: &Factors) -> (Re<S>, Re<S>) {
        let Self { mu, twice, before, pi } = *self;
        let t = mu.mul_sub(pi, before);
        let s = twice.mul_sub(pi, before);
        let tau = mu.same(f.n).mul_sub(t, before);
        // s + t / n, which unlike (2n + 1)/n and (n + 1)/n is not biased by the rounding of a factor.
        (self.before, self.pi) = (pi, mu.same(f.inverse).mul_add(t, s));
        (pi, tau)
    }
}

/// Real and imaginary parts of `S1` and `S2` forward and backward, by the symmetries `pi_n(-mu) = (-1)^(n+1) pi_n(mu)` and
/// `tau_n(-mu) = (-1)^n tau_n(mu)`.
#[inline(always)]
fn unfold<S: Simd>([odd, even]: &[Sums<S>; 2]) -> [[[f64; TILE * MAX_LANES]; 4]; 2] {
    let mut found = [[[0.0; TILE * MAX_LANES]; 4]; 2];
    for v in 0..TILE {
        let mut put = |backward: usize, component: usize, value: Re<S>| {
            found[backward][component][v * S::F64_LANES..][..S::F64_LANES]
                .copy_from_slice(&value.lanes()[..S::F64_LANES]);
        };
        let sum = |kind: usize, k: usize| odd[kind][k][v] + even[kind][k][v];
        let difference = |kind: usize, k: usize| odd[kind][k][v] - even[kind][k][v];
        // Of a, and of b.
        for (a, b) in [(0, 2), (1, 3)] {
            put(0, a, sum(0, a) + sum(1, b));
            put(0, b, sum(1, a) + sum(0, b));
            put(1, a, difference(0, a) - difference(1, b));
            put(1, b, difference(0, b) - difference(1, a));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::{PlaneWave, Sphere};
    use super::*;

    /// Angles in no order, some twice and some mirrored; orders that fill no block, one and several.
    #[test]
    fn amplitudes_are_sums_over_orders() {
        let mut cosines: Vec<f64> = (0..83).map(|i| (f64::from(i * 37 % 83) * 0.0379).cos()).collect();
        cosines.extend([1.0, -1.0, 0.0, -0.0, cosines[5], -cosines[7]]);
        let directions = Directions::new(cosines.iter().copied());
        for x in [1e-3, 2.0, 46.0, 150.0] {
            let wave = PlaneWave::new(2.0 * PI, Complex64::new(1.0, 0.0)).unwrap();
            let coefficients = Sphere::new(wave, x, Complex64::new(1.5, 0.01)).unwrap().coefficients();
            let amplitudes = coefficients.amplitudes(&directions).unwrap();
            assert_eq!(amplitudes.len(), cosines.len());
            for (mu, [s1, s2]) in cosines.iter().zip(amplitudes) {
                let (mut before, mut pi, mut expected, mut size) = (0.0, 1.0, [Complex64::ZERO; 2], 0.0);
                for (i, [a, b]) in coefficients.terms().enumerate() {
                    let n = i as f64 + 1.0;
                    let tau = n * mu * pi - (n + 1.0) * before;
                    let c = (2.0 * n + 1.0) / (n * (n + 1.0));
                    expected[0] += c * (a * pi + b * tau);
                    expected[1] += c * (a * tau + b * pi);
                    size += c * (a.norm() + b.norm()) * n * (pi.abs() + before.abs());
                    (before, pi) = (pi, ((2.0 * n + 1.0) * mu * pi - (n + 1.0) * before) / n);
                }
                assert!((s1 - expected[0]).norm() < 1e-15 * size, "{x} {mu}");
                assert!((s2 - expected[1]).norm() < 1e-15 * size, "{x} {mu}");
            }
        }
    }

    #[test]
    fn no_angles_are_no_amplitudes() {
        let wave = PlaneWave::new(2.0 * PI, Complex64::new(1.0, 0.0)).unwrap();
        let coefficients = Sphere::new(wave, 3.0, Complex64::new(1.5, 0.01)).unwrap().coefficients();
        assert!(coefficients.amplitudes(&Directions::new([])).unwrap().is_empty());
    }
}
