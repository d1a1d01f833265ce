//! Henyey-Greenstein: one parameter, the mean cosine. Fits measurements; has no physics of its own.

use std::f64::consts::PI;

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

    /// Scattering cosine in [-1, 1] for a uniform `xi` in [0, 1): the exact inverse of the cumulative distribution,
    /// rising from -1 to 1.
    ///
    /// The usual closed form divides by `g`; this arrangement of it does not, so small `g` loses no digits.
    pub fn sample(&self, xi: f64) -> f64 {
        let g = self.g;
        let s = 2.0 * xi - 1.0;
        let d = 1.0 + g * s;
        // (1 + g^2 - ((1 - g^2)/(1 + g s))^2) / (2 g), multiplied out.
        let mu = (s + g * (0.5 * s * s + 1.5 + g * s + 0.5 * g * g * (s * s - 1.0))) / (d * d);
        mu.clamp(-1.0, 1.0)
    }

    /// Moment of the Legendre polynomial of the given degree: `g^degree`; 1 for degree 0.
    pub fn legendre_moment(&self, degree: u32) -> f64 {
        self.g.powi(degree.min(i32::MAX as u32) as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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

    /// Chi-squared over 50 equal-probability bins, three seeds of a small counter-based generator.
    #[test]
    fn samples_pass_a_chi_squared_test() {
        for g in CORNERS {
            let phase = HenyeyGreenstein::new(g).unwrap();
            for seed in 1..=3u64 {
                let (n, bins) = (50_000usize, 50usize);
                let mut counts = vec![0u32; bins];
                let mut mean = 0.0;
                let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15);
                for _ in 0..n {
                    state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                    let xi = ((state ^ (state >> 31)).wrapping_mul(0xD6E8_FEB8_6659_FD93) >> 11) as f64 / 2f64.powi(53);
                    let mu = phase.sample(xi);
                    mean += mu;
                    counts[((cumulative(g, mu) * bins as f64) as usize).min(bins - 1)] += 1;
                }
                let expected = n as f64 / bins as f64;
                let chi2: f64 = counts.iter().map(|&c| (f64::from(c) - expected).powi(2) / expected).sum();
                // 49 degrees of freedom: 99.99 % lie below 96.
                assert!(chi2 < 96.0, "g {g} seed {seed}: chi2 {chi2}");
                let sd = ((1.0 + 2.0 * g * g) / 3.0 - g * g).sqrt() / (n as f64).sqrt();
                assert!((mean / n as f64 - g).abs() < 5.0 * sd + 1e-12, "g {g}");
            }
        }
    }

    #[test]
    fn the_ends_are_refused() {
        for g in [1.0, -1.0, 1.5, f64::NAN, f64::INFINITY] {
            assert!(HenyeyGreenstein::new(g).is_err());
        }
    }
}
