//! What fills a body: a homogeneous medium, clear or turbid.

mod dense;

pub(crate) use dense::Dense;

use mieux_optics::spectrum::Sampled;

use crate::light::constant;

/// The refractive index by which geometry is traced when dispersion is off is taken at the helium d line, m.
pub const DESIGN_WAVELENGTH: f64 = 587.56e-9;

/// What can be wrong with a medium, or with any spectrum of a scene.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MediumError {
    /// A spectrum does not reach over all wavelengths that are rendered.
    #[error(
        "{what} is known from {:.1} to {:.1} nm, but {:.1} to {:.1} nm are rendered",
        known_m.0 * 1e9, known_m.1 * 1e9, asked_m.0 * 1e9, asked_m.1 * 1e9
    )]
    Range {
        /// Which spectrum.
        what: &'static str,
        /// Where it is known, m.
        known_m: (f64, f64),
        /// Where it is needed, m.
        asked_m: (f64, f64),
    },
    /// A value has no physical meaning.
    #[error("{what} = {value} at {:.1} nm; it {rule}", wavelength_m * 1e9)]
    Value {
        /// Which spectrum.
        what: &'static str,
        /// Where, m.
        wavelength_m: f64,
        /// The offending value.
        value: f64,
        /// What is asked of it.
        rule: &'static str,
    },
}

/// A homogeneous medium with a Henyey-Greenstein phase function.
///
/// | | |
/// |---|---|
/// | `sigma_s`, `sigma_a` | coefficients of scattering and absorption, 1/m, at least 0 |
/// | `g` | asymmetry, -1 < g < 1 |
/// | `n` | refractive index (real part), 0.1 to 10 |
#[derive(Debug, Clone, PartialEq)]
pub struct Medium {
    /// Scattering coefficient over wavelength, 1/m.
    pub sigma_s: Sampled,
    /// Absorption coefficient over wavelength, 1/m.
    pub sigma_a: Sampled,
    /// Mean cosine of scattering over wavelength.
    pub g: Sampled,
    /// Real refractive index over wavelength.
    pub n: Sampled,
}

impl Medium {
    /// A medium that scatters nothing, such as glass: absorption in 1/m and refractive index.
    ///
    /// `None` never happens for the finite constants used; the signature spares callers a panic.
    pub fn clear(sigma_a: Sampled, n: Sampled) -> Option<Self> {
        Some(Self { sigma_s: constant(0.0)?, sigma_a, g: constant(0.0)?, n })
    }

    /// A medium that is the same at all wavelengths from 100 nm to 10 um; `None` if a value is not finite.
    pub fn grey(sigma_s: f64, sigma_a: f64, g: f64, n: f64) -> Option<Self> {
        Some(Self { sigma_s: constant(sigma_s)?, sigma_a: constant(sigma_a)?, g: constant(g)?, n: constant(n)? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grey_is_the_same_everywhere() {
        let medium = Medium::grey(1.0, 2.0, 0.3, 1.4).unwrap();
        assert!((medium.n.at(500e-9).unwrap() - 1.4).abs() < 1e-15);
        assert!(Medium::grey(f64::NAN, 0.0, 0.0, 1.0).is_none());
    }
}
