//! Henyey-Greenstein: one parameter, the mean cosine. Fits measurements; has no physics of its own.

use std::f64::consts::PI;
use std::fmt;

use super::PhaseError;

/// Angular distribution of scattered light with mean cosine `g`.
///
/// | | |
/// |---|---|
/// | `g` | asymmetry, -1 < g < 1; 0 is isotropic, towards 1 is forward |
///
/// Source: `henyey1941`, eq 2 of `jendersie2023s`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HenyeyGreenstein {
    g: f64,
}

impl HenyeyGreenstein {
    /// # Errors
    /// [`PhaseError::Asymmetry`] unless `-1 < g < 1`.
    pub fn new(g: f64) -> Result<Self, PhaseError> {
        if g > -1.0 && g < 1.0 { Ok(Self { g }) } else { Err(PhaseError::Asymmetry { g }) }
    }

    /// Mean cosine.
    pub fn asymmetry(&self) -> f64 {
        self.g
    }

    /// Value in 1/sr at the scattering cosine `mu` in [-1, 1]; integrates to 1 over the sphere. Also the density of
    /// [`Self::sample`] per solid angle.
    pub fn value(&self, mu: f64) -> f64 {
        let g = self.g;
        // (1 - |g|)^2 + 2 |g| (1 - |mu towards the peak|): no cancellation where the peak is.
        let away = 1.0 - mu * g.signum();
        let base = (1.0 - g.abs()).powi(2) + 2.0 * g.abs() * away;
        (1.0 - g * g) / (4.0 * PI * base * base.sqrt())
    }

    /// Scattering cosine in [-1, 1] for a uniform `xi` in [0, 1]: the exact inverse of the cumulative distribution,
    /// rising from -1 to 1.
    ///
    /// The usual closed form divides by `g` and cancels opposite the peak; this arrangement does neither.
    pub fn sample(&self, xi: f64) -> f64 {
        let xi = xi.clamp(0.0, 1.0);
        if self.g < 0.0 { away_at(-self.g, xi).1 - 1.0 } else { 1.0 - away_at(self.g, 1.0 - xi).1 }.clamp(-1.0, 1.0)
    }

    /// Moment of the Legendre polynomial of the given degree: `g^degree`; 1 for degree 0.
    pub fn legendre_moment(&self, degree: u32) -> f64 {
        self.g.powi(degree.min(i32::MAX as u32) as i32)
    }
}

/// Where a lobe of asymmetry `g >= 0` has scattered the share `u` of its light, counted from the peak: `1 - mu` there,
/// after the `e` of which it is `e (1 - g) + g e^2 / 2`, and `u = (1 + g) e / (2 (1 - g + g e))`.
#[inline]
pub(super) fn away_at(g: f64, u: f64) -> (f64, f64) {
    let h = 1.0 - g;
    let e = 2.0 * u * h / (h + 2.0 * g * (1.0 - u));
    (e, e * (h + 0.5 * g * e))
}

impl fmt::Display for HenyeyGreenstein {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Henyey-Greenstein (g = {})", self.g)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phase::testing;

    const CORNERS: [f64; 9] = [-0.999, -0.9, -1e-3, 0.0, 1e-9, 1e-3, 0.5, 0.95, 0.999];

    /// The cumulative distribution in closed form, with a series where it cancels.
    fn cumulative(g: f64, mu: f64) -> f64 {
        if g.abs() < 1e-4 {
            return 0.5 * (1.0 + mu) - 0.75 * g * (1.0 - mu * mu);
        }
        (1.0 - g * g) / (2.0 * g) * ((1.0 + g * g - 2.0 * g * mu).powf(-0.5) - 1.0 / (1.0 + g))
    }

    #[test]
    fn the_sample_inverts_the_cumulative_distribution() {
        for g in CORNERS {
            let phase = HenyeyGreenstein::new(g).unwrap();
            for i in 0..=1000 {
                let xi = f64::from(i) / 1000.0;
                let mu = phase.sample(xi);
                assert!((-1.0..=1.0).contains(&mu));
                assert!((cumulative(g, mu) - xi).abs() < 2e-9, "g {g} xi {xi}: {} ", cumulative(g, mu));
            }
        }
    }

    #[test]
    fn the_value_is_the_derivative_of_the_cumulative_distribution() {
        for g in CORNERS {
            let phase = HenyeyGreenstein::new(g).unwrap();
            for i in 1..400 {
                let (a, b) = (f64::from(i) / 200.0 - 1.005, f64::from(i) / 200.0 - 0.995);
                let (a, b) = (a.max(-1.0), b.min(1.0));
                // Boole's rule on a narrow bin against the exact bin probability.
                let h = (b - a) / 4.0;
                let v = |k: f64| 2.0 * PI * phase.value(a + k * h);
                let bin =
                    2.0 * h / 45.0 * (7.0 * v(0.0) + 32.0 * v(1.0) + 12.0 * v(2.0) + 32.0 * v(3.0) + 7.0 * v(4.0));
                let exact = cumulative(g, b) - cumulative(g, a);
                let smooth = 2.0 * g.abs() * h
                    < 0.2
                        * ((1.0 - g.abs()).powi(2) + 2.0 * g.abs() * (1.0 - a * g.signum()).min(1.0 - b * g.signum()));
                if smooth {
                    assert!((bin / exact - 1.0).abs() < 1e-4, "g {g} at {a}: {bin} {exact}");
                }
            }
        }
    }

    #[test]
    fn is_a_phase_function_at_its_corners() {
        for g in CORNERS {
            let phase = HenyeyGreenstein::new(g).unwrap().into();
            testing::check(&phase);
            testing::check_inverse(&phase, &[]);
        }
    }

    #[test]
    fn the_ends_are_refused() {
        for g in [1.0, -1.0, 1.5, f64::NAN, f64::INFINITY] {
            assert!(HenyeyGreenstein::new(g).is_err());
        }
    }
}
