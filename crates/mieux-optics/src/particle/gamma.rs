//! Gamma sizes by effective radius and variance, as clouds and aerosols are retrieved.

use super::smooth::{Smooth, clipped, even_knots};
use super::{ParticleError, check_limits, positive};

/// Number density `r^((1 - 3 b) / b) exp(-r / (a b))`, with the effective radius `a` and the effective variance `b`, cut off at
/// optional limits (of which `a` and `b` know nothing).
///
/// Source: eq 2.56 of `hansen1974`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gamma {
    effective_radius_m: f64,
    effective_variance: f64,
    minimum_m: f64,
    maximum_m: f64,
}

impl Gamma {
    /// From the effective radius (m) and the effective variance, between 0 and 0.5.
    ///
    /// # Errors
    /// [`ParticleError::NotPositive`], or [`ParticleError::EffectiveVariance`]: from 0.5 on the number is infinite.
    pub fn new(effective_radius_m: f64, effective_variance: f64) -> Result<Self, ParticleError> {
        let effective_radius_m = positive("effective radius", effective_radius_m)?;
        if !(effective_variance > 0.0 && effective_variance < 0.5) {
            return Err(ParticleError::EffectiveVariance { value: effective_variance });
        }
        Ok(Self { effective_radius_m, effective_variance, minimum_m: 0.0, maximum_m: f64::INFINITY })
    }

    /// Cuts the distribution off outside `minimum_m..maximum_m` (m).
    ///
    /// # Errors
    /// [`ParticleError::Limits`], or [`ParticleError::Empty`] when as good as nothing would be left.
    pub fn truncated(self, minimum_m: f64, maximum_m: f64) -> Result<Self, ParticleError> {
        check_limits(minimum_m, maximum_m)?;
        let [from, to] = self.range(3.0, 6.0);
        if from.max(minimum_m.ln()) < to.min(maximum_m.ln()) {
            Ok(Self { minimum_m, maximum_m, ..self })
        } else {
            Err(ParticleError::Empty { minimum_m, maximum_m })
        }
    }

    /// Effective radius, m, limits disregarded.
    pub fn effective_radius(&self) -> f64 {
        self.effective_radius_m
    }

    /// Effective variance, limits disregarded.
    pub fn effective_variance(&self) -> f64 {
        self.effective_variance
    }

    /// Exponent of `r^power N(r) r`, per unit of `ln r`; positive for powers from 0 on.
    fn slope(&self, power: f64) -> f64 {
        1.0 / self.effective_variance - 2.0 + power
    }

    fn scale(&self) -> f64 {
        self.effective_radius_m * self.effective_variance
    }

    fn range(&self, least: f64, most: f64) -> [f64; 2] {
        let (low, high) = (self.slope(least), self.slope(most));
        let from = low.ln() - 60.0 / low - 12.0 / low.sqrt();
        // r^high exp(-r) is exp(-50) of its peak there, or less.
        let to = (high + 50.0 + 12.0 * high.sqrt()).ln();
        [self.scale().ln() + from, self.scale().ln() + to]
    }
}

impl Smooth for Gamma {
    fn measure(&self, u: f64) -> (f64, f64) {
        let slope = self.slope(3.0);
        let relative = u - (self.scale() * slope).ln();
        (u.exp(), (slope * (relative - relative.exp_m1())).exp())
    }

    fn knots(&self, least: f64, most: f64) -> Option<Vec<f64>> {
        let width = 2.0 / self.slope(3.0).sqrt();
        let (from, to) = clipped(self.range(least, most), [self.minimum_m, self.maximum_m], width);
        Some(even_knots(from, to, width))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particle::SizeDistribution;

    #[test]
    fn effective_radius_and_variance_are_what_was_asked() {
        for (a, b) in [(10e-6, 0.1), (1e-6, 0.02), (2e-7, 0.3), (5e-6, 0.4), (5e-6, 0.45)] {
            let sizes = SizeDistribution::Gamma(Gamma::new(a, b).unwrap());
            assert!((sizes.effective_radius().unwrap() / a - 1.0).abs() < 1e-8, "{a} {b}");
            assert!((sizes.effective_variance().unwrap() / b - 1.0).abs() < 1e-7, "{a} {b}");
            // Mean by number: (1 - 2b) a.
            assert!((sizes.mean_radius(1.0, 0.0).unwrap() / ((1.0 - 2.0 * b) * a) - 1.0).abs() < 1e-7, "{a} {b}");
        }
    }

    #[test]
    fn what_is_no_distribution_is_refused() {
        assert!(matches!(Gamma::new(0.0, 0.1), Err(ParticleError::NotPositive { .. })));
        for b in [0.0, 0.5, -1.0, f64::NAN] {
            assert!(matches!(Gamma::new(1e-6, b), Err(ParticleError::EffectiveVariance { .. })), "{b}");
        }
        let d = Gamma::new(1e-6, 0.1).unwrap();
        assert!(matches!(d.truncated(2e-6, 1e-6), Err(ParticleError::Limits { .. })));
        assert!(matches!(d.truncated(1.0, 2.0), Err(ParticleError::Empty { .. })));
    }
}
