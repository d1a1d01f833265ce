//! Isotropic scattering: every direction alike. No natural scatterer does so; the yardstick of transfer theory.

use std::f64::consts::PI;
use std::fmt;

/// Scattering that forgets where the light came from. Source: `vandehulst1980`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Isotropic;

impl Isotropic {
    /// `1 / (4 pi)` per sr, whatever `mu` in [-1, 1]. Also the density of [`Self::sample`] per solid angle.
    pub fn value(&self, _mu: f64) -> f64 {
        0.25 / PI
    }

    /// Scattering cosine for a uniform `xi` in [0, 1], rising from -1 to 1.
    pub fn sample(&self, xi: f64) -> f64 {
        (2.0 * xi - 1.0).clamp(-1.0, 1.0)
    }

    /// Mean cosine: 0.
    pub fn asymmetry(&self) -> f64 {
        0.0
    }

    /// Moment of the Legendre polynomial of the given degree: 1 for degree 0, else 0.
    pub fn legendre_moment(&self, degree: u32) -> f64 {
        if degree == 0 { 1.0 } else { 0.0 }
    }
}

impl fmt::Display for Isotropic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("isotropic")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phase::testing;

    #[test]
    fn is_a_phase_function() {
        testing::check(&Isotropic.into());
        testing::check_inverse(&Isotropic.into(), &[]);
    }
}
