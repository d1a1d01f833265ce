//! What fills a body: any number of parts, each clear or turbid, each the same everywhere or spread by a grid.

mod dense;
mod grid;
mod matter;
mod phase;

pub(crate) use dense::Dense;
pub use grid::{Filter, Grid, GridError, Placement};
pub(crate) use matter::{DenseMedium, Matter, Sums};
pub use phase::Phase;

use std::sync::Arc;

use mieux_optics::spectrum::Sampled;

use crate::light::constant;

/// The refractive index by which geometry is traced when dispersion is off is taken at the helium d line, m.
pub const DESIGN_WAVELENGTH: f64 = 587.56e-9;

/// Most parts of one medium.
pub const MOST_PARTS: usize = 6;

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
    /// Too many parts, or none.
    #[error("a medium of {count} parts; between 1 and {MOST_PARTS} are possible")]
    Parts {
        /// How many.
        count: usize,
    },
    /// The grids of one medium lie differently.
    #[error("the grids of one medium must have the same place and the same numbers of cells")]
    Grids,
}

/// One kind of matter in a medium.
///
/// | | |
/// |---|---|
/// | `sigma_s`, `sigma_a` | coefficients of scattering and absorption, 1/m, at least 0 |
/// | `phase` | how it scatters over angle |
/// | `emission` | radiance of the light it sends out, as that of a thick layer of it that does not scatter; at least 0 |
/// | `density` | factor of both coefficients over place; 1 everywhere when left out |
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Scattering coefficient over wavelength, 1/m, where the density is 1.
    pub sigma_s: Sampled,
    /// Absorption coefficient over wavelength, 1/m, where the density is 1.
    pub sigma_a: Sampled,
    /// How it scatters over angle.
    pub phase: Phase,
    /// Source function of its absorption: emitted are `sigma_a` times this, per solid angle and length.
    pub emission: Option<Sampled>,
    /// How much of it is where.
    pub density: Option<Arc<Grid>>,
}

/// A medium: a refractive index (real part, 0.1 to 10) and what absorbs and scatters in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Medium {
    /// Real refractive index over wavelength.
    pub n: Sampled,
    /// At least one and at most [`MOST_PARTS`]; their coefficients add up. Their grids share one place and size.
    pub parts: Vec<Part>,
}

impl Medium {
    /// A homogeneous medium of Henyey-Greenstein scattering: coefficients of scattering and absorption (1/m), mean cosine
    /// and refractive index over wavelength.
    pub fn new(sigma_s: Sampled, sigma_a: Sampled, g: Sampled, n: Sampled) -> Self {
        let part = Part { sigma_s, sigma_a, phase: Phase::HenyeyGreenstein(g), emission: None, density: None };
        Self { n, parts: vec![part] }
    }

    /// A medium that scatters nothing, such as glass: absorption in 1/m and refractive index.
    ///
    /// `None` never happens for the finite constants used; the signature spares callers a panic.
    pub fn clear(sigma_a: Sampled, n: Sampled) -> Option<Self> {
        Some(Self::new(constant(0.0)?, sigma_a, constant(0.0)?, n))
    }

    /// A medium that is the same at all wavelengths from 100 nm to 10 um; `None` if a value is not finite.
    pub fn grey(sigma_s: f64, sigma_a: f64, g: f64, n: f64) -> Option<Self> {
        Some(Self::new(constant(sigma_s)?, constant(sigma_a)?, constant(g)?, constant(n)?))
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
