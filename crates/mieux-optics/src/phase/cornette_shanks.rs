//! Cornette and Shanks: Henyey-Greenstein's peak with Rayleigh's `1 + mu^2`, so that small `g` means small particles.

use std::fmt;

use super::{Draine, PhaseError};

/// `3/(8 pi) (1 - g^2)/(2 + g^2) (1 + mu^2)/(1 + g^2 - 2 g mu)^(3/2)`: [`Draine`] with `alpha = 1`.
///
/// | | |
/// |---|---|
/// | `g` | parameter of the peak, -1 < g < 1; not the mean cosine, which is [`Self::asymmetry`] |
///
/// Source: `cornette1992`; sampled as `jendersie2023s` shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CornetteShanks(Draine);

impl CornetteShanks {
    /// # Errors
    /// [`PhaseError::Asymmetry`] unless `-1 < g < 1`.
    pub fn new(g: f64) -> Result<Self, PhaseError> {
        Draine::new(g, 1.0).map(Self)
    }

    /// The parameter `g`.
    pub fn parameter(&self) -> f64 {
        self.0.parameters().0
    }

    /// Value in 1/sr at the scattering cosine `mu` in [-1, 1]. Also the density of [`Self::sample`] per solid angle.
    pub fn value(&self, mu: f64) -> f64 {
        self.0.value(mu)
    }

    /// Scattering cosine in [-1, 1] for a uniform `xi` in [0, 1]: the exact inverse of the cumulative distribution,
    /// rising from -1 to 1.
    pub fn sample(&self, xi: f64) -> f64 {
        self.0.sample(xi)
    }

    /// Mean cosine, `3 g (4 + g^2) / (5 (2 + g^2))`.
    pub fn asymmetry(&self) -> f64 {
        self.0.asymmetry()
    }

    /// Moment of the Legendre polynomial of the given degree, in closed form.
    pub fn legendre_moment(&self, degree: u32) -> f64 {
        self.0.legendre_moment(degree)
    }
}

impl fmt::Display for CornetteShanks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Cornette-Shanks (g = {})", self.parameter())
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::phase::testing;

    #[test]
    fn is_a_phase_function_at_its_corners() {
        for g in [-0.999, -0.3, 0.0, 1e-9, 0.5, 0.9, 0.999] {
            let phase = CornetteShanks::new(g).unwrap();
            testing::check(&phase.into());
            testing::check_inverse(&phase.into(), &[]);
        }
    }

    #[test]
    fn has_the_value_and_the_mean_cosine_of_the_paper() {
        for g in [-0.7f64, 0.0, 0.3, 0.85] {
            let phase = CornetteShanks::new(g).unwrap();
            for mu in [-1.0, -0.4, 0.0, 0.7, 1.0] {
                let printed = 3.0 / (8.0 * PI) * (1.0 - g * g) / (2.0 + g * g) * (1.0 + mu * mu)
                    / (1.0 + g * g - 2.0 * g * mu).powf(1.5);
                assert!((phase.value(mu) / printed - 1.0).abs() < 1e-13);
            }
            assert!((phase.asymmetry() - 0.6 * g * (4.0 + g * g) / (2.0 + g * g)).abs() < 1e-15);
        }
        assert!(CornetteShanks::new(f64::NAN).is_err());
    }
}
