//! The distribution found for casein micelles: a log-normal in `r / (r_max - r)`, which ends at a largest radius.

use super::smooth::{Smooth, even_knots};
use super::{ParticleError, positive};

/// Volume frequency `r^3 N(r)` proportional to the log-normal density evaluated at `t = r / (r_max - r)`, as a function
/// of `r` and *without* the factor `dt/dr`: how `frisvad2007` (section 4.1) reads `schmidt1973`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransformedLogNormal {
    maximum_m: f64,
    /// Median of `t`.
    median: f64,
    /// Standard deviation of `ln t`.
    log_deviation: f64,
}

impl TransformedLogNormal {
    /// From the largest radius (m) and the arithmetic mean and standard deviation of `t`.
    ///
    /// # Errors
    /// [`ParticleError::NotPositive`].
    pub fn new(maximum_m: f64, mean: f64, deviation: f64) -> Result<Self, ParticleError> {
        let maximum_m = positive("maximum radius", maximum_m)?;
        let mean = positive("mean of r/(r_max - r)", mean)?;
        let cv = positive("standard deviation of r/(r_max - r)", deviation)? / mean;
        let variance = (cv * cv).ln_1p();
        Ok(Self { maximum_m, median: mean * (-0.5 * variance).exp(), log_deviation: variance.sqrt() })
    }

    /// The largest radius, m.
    pub fn maximum(&self) -> f64 {
        self.maximum_m
    }
}

impl Smooth for TransformedLogNormal {
    /// Here `u` is `ln t`.
    fn measure(&self, u: f64) -> (f64, f64) {
        let t = u.exp();
        let radius = self.maximum_m * t / (1.0 + t);
        let z = (u - self.median.ln()) / self.log_deviation;
        // Density in t, 1/t exp(-z^2/2); times dr/du, proportional to t / (1 + t)^2.
        (radius, (-0.5 * z * z).exp() / (1.0 + t).powi(2))
    }

    fn knots(&self, least: f64, most: f64) -> Option<Vec<f64>> {
        let (centre, s) = (self.median.ln(), self.log_deviation);
        // While t is small the radius is proportional to it.
        let shift = |power: f64| (power - 3.0) * s * s;
        Some(even_knots(centre - 10.0 * s + shift(least).min(0.0), centre + 10.0 * s + shift(most).max(0.0), 2.0 * s))
    }

    fn place(&self, radius_m: f64) -> (f64, f64) {
        if radius_m >= self.maximum_m {
            return (f64::INFINITY, 0.0);
        }
        let rest = 1.0 - radius_m / self.maximum_m;
        ((radius_m / self.maximum_m / rest).ln(), 1.0 / rest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radii_stay_below_the_maximum() {
        let d = TransformedLogNormal::new(150e-9, 43.0 / 107.0, 0.23).unwrap();
        for u in d.knots(0.0, 6.0).unwrap() {
            let (r, density) = d.measure(u);
            assert!((d.place(r).0 - u).abs() < 1e-6);
            assert!(r > 0.0 && r < d.maximum() && density >= 0.0);
        }
        assert!(TransformedLogNormal::new(0.0, 1.0, 1.0).is_err());
        assert!(TransformedLogNormal::new(1e-7, 1.0, f64::NAN).is_err());
    }
}
