//! The plane wave that lights a particle, and the cross sections that sums of coefficients amount to in it.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::sums::SphereSums;
use super::{MieError, ScatteringDefinition};

/// Twice the imaginary part of a size parameter, above which cross sections leave the range of numbers.
const MAX_EXPONENT: f64 = 680.0;

/// Largest relative error of an extinction cross section that is let pass.
const MAX_ERROR: f64 = 1e-8;

/// A plane wave in a host that may absorb; everything in it has been checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneWave {
    wavelength: f64,
    /// Vacuum wave number, 1/m.
    k0: f64,
    host: Complex64,
    /// `wavelength^2 / (2 pi |host|^2)`, by which sums of coefficients are cross sections, m^2.
    area: f64,
    /// `conj(host) / host - 1`
    turn: Complex64,
    definition: ScatteringDefinition,
}

/// What one particle does to a plane wave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SphereScattering {
    /// Size parameter in the host, `2 pi r n_host / wavelength`; complex when the host absorbs.
    pub size_parameter: Complex64,
    /// Extinction cross section in m^2, relative to the host; negative where the particle takes the place of a host that
    /// would have absorbed more.
    pub extinction: f64,
    /// Scattering cross section in m^2, never negative, by `definition`.
    pub scattering: f64,
    /// Absorption cross section in m^2: extinction minus scattering; never negative in a lossless host.
    pub absorption: f64,
    /// Mean cosine of scattering, in (-1, 1) (eq 26 of `frisvad2007`); 0 where nothing is scattered.
    pub asymmetry: f64,
    /// `S(0) / k^2` in m^2, with the complex wave number `k` of the host: what shifts the refractive index of a medium.
    pub forward: Complex64,
    /// What scattering and extinction mean where the host absorbs.
    pub definition: ScatteringDefinition,
}

impl SphereScattering {
    /// By nothing at all.
    pub(super) const NONE: Self = Self {
        size_parameter: Complex64::ZERO,
        extinction: 0.0,
        scattering: 0.0,
        absorption: 0.0,
        asymmetry: 0.0,
        forward: Complex64::ZERO,
        definition: ScatteringDefinition::Frisvad2007,
    };
}

impl PlaneWave {
    /// A wave of the vacuum wavelength `wavelength` (m) in a host of refractive index `host`, whose scattering is to be
    /// understood by [`ScatteringDefinition::Frisvad2007`].
    ///
    /// # Errors
    /// [`MieError::Length`] or [`MieError::Index`].
    pub fn new(wavelength: f64, host: Complex64) -> Result<Self, MieError> {
        check_length("wavelength", wavelength)?;
        check_index("host", host)?;
        let square = host.norm_sqr();
        Ok(Self {
            wavelength,
            k0: 2.0 * PI / wavelength,
            host,
            area: wavelength * wavelength / (2.0 * PI * square),
            turn: Complex64::new(-2.0 * host.im * host.im, -2.0 * host.re * host.im) / square,
            definition: ScatteringDefinition::default(),
        })
    }

    /// The same wave, scattering understood otherwise.
    pub fn with_definition(self, definition: ScatteringDefinition) -> Self {
        Self { definition, ..self }
    }

    /// Vacuum wavelength, m.
    pub fn wavelength(&self) -> f64 {
        self.wavelength
    }

    /// Refractive index of the host.
    pub fn host(&self) -> Complex64 {
        self.host
    }

    /// What scattering means.
    pub fn definition(&self) -> ScatteringDefinition {
        self.definition
    }

    /// Complex wave number in the host, 1/m.
    pub fn wave_number(&self) -> Complex64 {
        self.host * self.k0
    }

    /// What turns sums of coefficients into cross sections, m^2.
    pub(super) fn area(&self) -> f64 {
        self.area
    }

    /// Vacuum wave number times a radius (m).
    pub(super) fn k0r(&self, radius: f64) -> f64 {
        self.k0 * radius
    }

    /// Checks that the host does not absorb too much over a particle of outer size `k0r`.
    pub(super) fn check_absorption(&self, k0r: f64) -> Result<(), MieError> {
        let exponent = 2.0 * self.host.im * k0r;
        let most = match self.definition {
            ScatteringDefinition::Frisvad2007 => MAX_EXPONENT,
            ScatteringDefinition::MishchenkoYang2018 => 0.5 * MAX_EXPONENT,
        };
        if exponent > most { Err(MieError::HostAbsorption { exponent, most }) } else { Ok(()) }
    }

    /// Cross sections of a particle of outer size `k0r`; `scaled` says that every coefficient lacks a factor of
    /// `exp(-2 i x)`.
    ///
    /// # Errors
    /// [`MieError::Cancellation`].
    pub(super) fn cross_sections(
        &self,
        k0r: f64,
        sums: &SphereSums,
        scaled: bool,
    ) -> Result<SphereScattering, MieError> {
        if scaled { self.scaled_cross_sections(k0r, sums) } else { Ok(self.plain_cross_sections(k0r, sums)) }
    }

    /// From coefficients that lack nothing: extinction is put together from scattering and absorption, each known without
    /// cancellation.
    #[inline(always)]
    pub(super) fn plain_cross_sections(&self, k0r: f64, sums: &SphereSums) -> SphereScattering {
        let x = self.host * k0r;
        let turned = sums.forward * self.turn;
        let excess = if x.im == 0.0 { 0.0 } else { self.excess(2.0 * x.im) };
        let scattering = sums.scattering * (1.0 + excess);
        let absorption = sums.loss + self.displaced(sums.forward, turned) - excess * sums.scattering;
        self.scattered(x, sums, [scattering, absorption, scattering + absorption], sums.forward + turned)
    }

    /// From coefficients that are scaled.
    ///
    /// # Errors
    /// [`MieError::Cancellation`].
    pub(super) fn scaled_cross_sections(&self, k0r: f64, sums: &SphereSums) -> Result<SphereScattering, MieError> {
        let x = self.host * k0r;
        let amplitude = sums.forward * (-2.0 * Complex64::I * x).exp();
        let turned = amplitude * self.turn;
        let extinction = amplitude.re + self.displaced(amplitude, turned);
        let scattering = sums.scattering * self.surface(2.0 * x.im, true).0;
        let error = f64::EPSILON * sums.size * (2.0 * x.im).exp() / extinction.abs();
        if error > MAX_ERROR {
            return Err(MieError::Cancellation { exponent: 2.0 * x.im, error });
        }
        Ok(self.scattered(x, sums, [scattering, extinction - scattering, extinction], amplitude + turned))
    }

    /// What extinction has besides the real part of the forward amplitude, for the host that the particle displaces.
    #[inline(always)]
    fn displaced(&self, amplitude: Complex64, turned: Complex64) -> f64 {
        match self.definition {
            ScatteringDefinition::Frisvad2007 => turned.re,
            ScatteringDefinition::MishchenkoYang2018 => self.host.im / self.host.re * amplitude.im,
        }
    }

    #[inline(always)]
    fn scattered(
        &self,
        size_parameter: Complex64,
        sums: &SphereSums,
        [scattering, absorption, extinction]: [f64; 3],
        forward: Complex64,
    ) -> SphereScattering {
        SphereScattering {
            size_parameter,
            extinction: self.area * extinction,
            scattering: self.area * scattering,
            absorption: self.area * absorption,
            asymmetry: if sums.scattering > 0.0 { 2.0 * sums.asymmetry / sums.scattering } else { 0.0 },
            forward: forward * (self.area / (4.0 * PI)),
            definition: self.definition,
        }
    }

    /// The factor between the sum of squared moduli and the scattering, and the derivative of what it is without scaling,
    /// by `alpha`, twice the imaginary part of the size parameter. Both with `exp(2 alpha)` when `scaled`.
    pub(super) fn surface(&self, alpha: f64, scaled: bool) -> (f64, f64) {
        let decay = if scaled { 1.0 } else { (-2.0 * alpha).exp() };
        match self.definition {
            ScatteringDefinition::MishchenkoYang2018 => (decay * (2.0 * alpha).exp(), 0.0),
            ScatteringDefinition::Frisvad2007 => {
                let h = 1.0 + surface_excess(alpha);
                (decay * h, decay * (surface_slope(alpha) - 2.0 * h))
            }
        }
    }

    /// By what the sum of squared moduli grows to be the scattering, less 1; `alpha` is twice the imaginary part of the
    /// size parameter.
    fn excess(&self, alpha: f64) -> f64 {
        match self.definition {
            ScatteringDefinition::MishchenkoYang2018 => 0.0,
            ScatteringDefinition::Frisvad2007 => {
                let surface = surface_excess(alpha);
                surface + (1.0 + surface) * (-2.0 * alpha).exp_m1()
            }
        }
    }
}

pub(super) fn check_length(name: &'static str, value_m: f64) -> Result<(), MieError> {
    if (1e-30..=1e30).contains(&value_m) { Ok(()) } else { Err(MieError::Length { name, value_m }) }
}

pub(super) fn check_index(name: &'static str, n: Complex64) -> Result<(), MieError> {
    let possible = (1e-6..=1e6).contains(&n.re) && (0.0..=1e6).contains(&n.im);
    if possible { Ok(()) } else { Err(MieError::Index { name, re: n.re, im: n.im }) }
}

/// Size parameter in the host and inside the particle.
pub(super) fn check_size_parameters(x: Complex64, y: Complex64) -> Result<(), MieError> {
    for (name, z, least, most) in [("host", x, 1e-8, 1e7), ("particle", y, 1e-10, 1e9)] {
        let square = z.norm_sqr();
        if !(least * least..=most * most).contains(&square) {
            return Err(MieError::SizeParameter { name, modulus: square.sqrt(), least, most });
        }
    }
    Ok(())
}

/// `1 / k` from `k = 3` on: divisions would take longer than all else.
const INVERSES: [f64; 12] = [
    1.0 / 3.0,
    1.0 / 4.0,
    1.0 / 5.0,
    1.0 / 6.0,
    1.0 / 7.0,
    1.0 / 8.0,
    1.0 / 9.0,
    1.0 / 10.0,
    1.0 / 11.0,
    1.0 / 12.0,
    1.0 / 13.0,
    1.0 / 14.0,
];

/// `exp(alpha) / gamma(alpha) - 1` with `gamma = 2 (1 + (alpha - 1) exp(alpha)) / alpha^2` (eq 24), that is
/// `alpha^2 / (2 (exp(-alpha) - 1 + alpha)) - 1`; 0 at `alpha = 0`.
fn surface_excess(alpha: f64) -> f64 {
    if alpha < 0.5 {
        // 2 (exp(-alpha) - 1 + alpha) / alpha^2 is 1 plus this series; twelve terms leave less than 1e-17.
        let (mut term, mut rest) = (1.0, 0.0);
        for inverse in INVERSES {
            term *= -alpha * inverse;
            rest += term;
            if term.abs() < 1e-17 * rest.abs() {
                break;
            }
        }
        -rest / (1.0 + rest)
    } else {
        alpha * alpha / (2.0 * ((-alpha).exp() - 1.0 + alpha)) - 1.0
    }
}
/// Derivative of [`surface_excess`].
fn surface_slope(alpha: f64) -> f64 {
    let h = 1.0 + surface_excess(alpha);
    if alpha < 0.5 {
        // The series of 1/h, term by term: alpha^k over (k + 2)!/2 with alternating signs.
        let mut term = -1.0 / 3.0;
        let mut slope = term;
        for k in 2..14 {
            let k = f64::from(k);
            term *= -alpha * k / ((k - 1.0) * (k + 2.0));
            slope += term;
        }
        -h * h * slope
    } else {
        let decay = (-alpha).exp();
        h * (2.0 / alpha - (1.0 - decay) / (decay - 1.0 + alpha))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_surface_excess_joins_its_series() {
        let gamma = |a: f64| 2.0 * (1.0 + (a - 1.0) * a.exp()) / (a * a);
        for a in [0.3f64, 0.4999, 0.5001, 2.0, 20.0] {
            assert!(((1.0 + surface_excess(a)) * gamma(a) / a.exp() - 1.0).abs() < 1e-12);
        }
        for a in [1e-3, 0.2, 0.4999, 0.5001, 3.0] {
            let difference = (surface_excess(a + 1e-4) - surface_excess(a - 1e-4)) / 2e-4;
            assert!((surface_slope(a) / difference - 1.0).abs() < 1e-7, "{a}");
        }
        assert_eq!(surface_excess(0.0), 0.0);
        assert!(surface_excess(1e6).is_finite());
    }
}
