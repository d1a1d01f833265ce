//! Rayleigh scattering of unpolarised light by spheres much smaller than the wavelength.

use std::f64::consts::PI;
use std::fmt;

/// `3 (1 + mu^2) / (16 pi)`, without depolarisation. Source: `bohren1983`, section 5.2.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rayleigh;

impl Rayleigh {
    /// Value in 1/sr at the scattering cosine `mu` in [-1, 1]. Also the density of [`Self::sample`] per solid angle.
    pub fn value(&self, mu: f64) -> f64 {
        3.0 / (16.0 * PI) * (1.0 + mu * mu)
    }

    /// Scattering cosine in [-1, 1] for a uniform `xi` in [0, 1]: the exact inverse of the cumulative distribution,
    /// rising from -1 to 1.
    ///
    /// The cubic `mu^3 + 3 mu = 8 xi - 4` has one real root. Cardano's two cube roots cancel where it is near 0; a step
    /// of Newton's method from there restores the digits.
    pub fn sample(&self, xi: f64) -> f64 {
        let right = 8.0 * xi.clamp(0.0, 1.0) - 4.0;
        let half = 0.5 * right.abs();
        let root = (half + (half * half + 1.0).sqrt()).cbrt();
        let mu = (root - 1.0 / root).copysign(right);
        (mu - (mu * (mu * mu + 3.0) - right) / (3.0 * (mu * mu + 1.0))).clamp(-1.0, 1.0)
    }

    /// Mean cosine: 0.
    pub fn asymmetry(&self) -> f64 {
        0.0
    }

    /// Moment of the Legendre polynomial of the given degree: 1 for degree 0, 1/10 for degree 2, else 0.
    pub fn legendre_moment(&self, degree: u32) -> f64 {
        match degree {
            0 => 1.0,
            2 => 0.1,
            _ => 0.0,
        }
    }
}

impl fmt::Display for Rayleigh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Rayleigh")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phase::testing;

    #[test]
    fn is_a_phase_function() {
        testing::check(&Rayleigh.into());
        testing::check_inverse(&Rayleigh.into(), &[]);
    }

    #[test]
    fn the_sample_solves_the_cubic_to_rounding_everywhere() {
        for i in -4000..=4000 {
            // Dense about xi = 1/2, where the textbook root loses its digits.
            let offset = (f64::from(i) / 4000.0).powi(5) / 2.0;
            let mu = Rayleigh.sample(0.5 + offset);
            let wanted = 8.0 * ((0.5 + offset) - 0.5);
            let found = mu * (mu * mu + 3.0);
            assert!((found - wanted).abs() <= 4e-15 * wanted.abs(), "offset {offset}: {found} {wanted}");
        }
    }
}
