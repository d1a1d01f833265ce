//! The coefficients of one particle, kept, and what only they can tell.

use std::f64::consts::PI;

use num_complex::Complex64;
use pulp::Simd;

use super::MieError;
use super::kernel::{Sink, Term};
use super::sums::{SphereSums, Sums};
use super::wave::{PlaneWave, SphereScattering};
use super::weights::Weight;
use crate::lanes::Re;

/// Lorenz-Mie coefficients `a_n` and `b_n` of one spherical particle in a plane wave, `n` from 1, in the signs of
/// `bohren1983`: what [`Sphere::coefficients`](super::Sphere::coefficients) and
/// [`LayeredSphere::coefficients`](super::LayeredSphere::coefficients) give.
#[derive(Debug, Clone)]
pub struct Coefficients {
    pub(super) wave: PlaneWave,
    pub(super) k0r: f64,
    /// Whether all of them lack a factor of `exp(-2 i x)`, which may be as large as `exp(680)`.
    pub(super) scaled: bool,
    pub(super) terms: Vec<[Complex64; 2]>,
    pub(super) sums: SphereSums,
}

impl Coefficients {
    /// The wave that the particle is in.
    pub fn wave(&self) -> &PlaneWave {
        &self.wave
    }

    /// Size parameter in the host.
    pub fn size_parameter(&self) -> Complex64 {
        self.wave.host() * self.k0r
    }

    /// `[a_n, b_n]` for `n = 1, 2, ...`, as many as count.
    pub fn terms(&self) -> impl ExactSizeIterator<Item = [Complex64; 2]> {
        let factor = self.factor();
        self.terms.iter().map(move |term| term.map(|c| c * factor))
    }

    /// What every stored coefficient lacks.
    pub(super) fn factor(&self) -> Complex64 {
        if self.scaled { (-2.0 * Complex64::I * self.size_parameter()).exp() } else { Complex64::ONE }
    }

    /// Sum of `(2n + 1)(|a_n|^2 + |b_n|^2)` as stored, which is the integral of the phase function before normalisation.
    pub(super) fn norm(&self) -> f64 {
        self.sums.scattering
    }

    /// Cross sections, asymmetry and forward amplitude.
    ///
    /// # Errors
    /// [`MieError::Cancellation`] where the host absorbs so much that extinction is lost to rounding.
    pub fn scattering(&self) -> Result<SphereScattering, MieError> {
        self.wave.cross_sections(self.k0r, &self.sums, self.scaled)
    }

    /// Backscattering cross section in m^2 as radars have it: `4 pi |S(180 deg) / k|^2`, which is 4 pi times the
    /// differential one (section 4.6 of `bohren1983`). The factor `exp(2 alpha)` of an absorbing host is in it.
    pub fn backscattering(&self) -> f64 {
        let sum: Complex64 = self
            .terms
            .iter()
            .enumerate()
            .map(|(i, [a, b])| (a - b) * if i % 2 == 0 { (2 * i + 3) as f64 } else { -((2 * i + 3) as f64) })
            .sum();
        let amplitude = 0.5 * sum * self.factor();
        4.0 * PI * (amplitude / self.wave.wave_number()).norm_sqr()
    }
}

/// Keeps the coefficients of the first lane while all are summed.
pub(super) struct Keep<S: Simd, const SCALED: bool> {
    pub sums: Sums<S, SCALED>,
    pub terms: Vec<[Complex64; 2]>,
}

impl<S: Simd, const SCALED: bool> Keep<S, SCALED> {
    #[inline(always)]
    pub fn new(simd: S, order: usize) -> Self {
        Self { sums: Sums::new(simd), terms: Vec::with_capacity(order) }
    }
}

impl<S: Simd, const SCALED: bool> Sink<S> for Keep<S, SCALED> {
    #[inline(always)]
    fn take(&mut self, weight: &Weight, term: Term<S>) {
        let first = |re: Re<S>| re.lanes()[0];
        self.terms.push([
            Complex64::new(first(term.a.re), first(term.a.im)),
            Complex64::new(first(term.b.re), first(term.b.im)),
        ]);
        self.sums.take(weight, term);
    }

    #[inline(always)]
    fn pause(&mut self) {
        self.sums.pause();
    }
}
