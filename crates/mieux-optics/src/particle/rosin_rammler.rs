//! Rosin-Rammler sizes (Weibull's distribution by volume), as of what has been ground or sprayed.

use super::smooth::{Smooth, clipped, even_knots};
use super::{ParticleError, check_limits, positive};

/// Volume below the radius `r` proportional to `1 - exp(-(r / scale)^spread)`, cut off at optional limits.
///
/// Source: `rosin1933`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RosinRammler {
    scale_m: f64,
    spread: f64,
    minimum_m: f64,
    maximum_m: f64,
}

impl RosinRammler {
    /// From the radius (m) below which lies 63.2 % of the volume, and the exponent: the larger, the narrower.
    ///
    /// # Errors
    /// [`ParticleError::NotPositive`].
    pub fn new(scale_m: f64, spread: f64) -> Result<Self, ParticleError> {
        let (scale_m, spread) = (positive("scale radius", scale_m)?, positive("spread", spread)?);
        Ok(Self { scale_m, spread, minimum_m: 0.0, maximum_m: f64::INFINITY })
    }

    /// Cuts the distribution off outside `minimum_m..maximum_m` (m).
    ///
    /// # Errors
    /// [`ParticleError::Limits`], or [`ParticleError::Empty`] when as good as nothing would be left.
    pub fn truncated(self, minimum_m: f64, maximum_m: f64) -> Result<Self, ParticleError> {
        check_limits(minimum_m, maximum_m)?;
        let [from, to] = self.range(self.spread, 3.0);
        if from.max(minimum_m.ln()) < to.min(maximum_m.ln()) {
            Ok(Self { minimum_m, maximum_m, ..self })
        } else {
            Err(ParticleError::Empty { minimum_m, maximum_m })
        }
    }

    /// Radius below which lies 63.2 % of the volume, m, limits disregarded.
    pub fn scale(&self) -> f64 {
        self.scale_m
    }

    /// The exponent.
    pub fn spread(&self) -> f64 {
        self.spread
    }

    /// From where `y^(slope / spread) exp(-y)`, `y = (r / scale)^spread`, has risen, to where it has fallen.
    fn range(&self, slope: f64, most: f64) -> [f64; 2] {
        let powers = (most - 3.0).max(0.0) / self.spread;
        [
            self.scale_m.ln() - 45.0 / slope,
            self.scale_m.ln() + (50.0 + powers + 12.0 * powers.sqrt()).ln() / self.spread,
        ]
    }
}

impl Smooth for RosinRammler {
    fn measure(&self, u: f64) -> (f64, f64) {
        let y = (self.spread * (u - self.scale_m.ln())).exp();
        (u.exp(), y * (-y).exp())
    }

    fn knots(&self, least: f64, most: f64) -> Option<Vec<f64>> {
        let slope = self.spread + least - 3.0;
        let [from, to] = if slope > 0.0 {
            self.range(slope, most)
        } else if self.minimum_m > 0.0 {
            [self.minimum_m.ln(), self.range(1.0, most)[1]]
        } else {
            return None;
        };
        let (from, to) = clipped([from, to], [self.minimum_m, self.maximum_m], 2.0 / self.spread);
        Some(even_knots(from, to, 2.0 / self.spread))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particle::{SizeDistribution, Weighting};

    #[test]
    fn the_quantiles_are_those_of_the_definition() {
        for spread in [0.8, 1.5, 3.5] {
            let sizes = SizeDistribution::RosinRammler(RosinRammler::new(20e-6, spread).unwrap());
            for share in [0.1, 0.5, 0.632_120_558_8, 0.9] {
                let expected = 20e-6 * (-(1.0f64 - share).ln()).powf(1.0 / spread);
                let found = sizes.quantile(Weighting::Volume, share).unwrap();
                assert!((found / expected - 1.0).abs() < 1e-6, "{spread} {share}: {found:e} {expected:e}");
            }
        }
    }

    #[test]
    fn too_many_small_ones_have_no_mean_by_number() {
        let sizes = |d: RosinRammler| SizeDistribution::RosinRammler(d);
        let d = RosinRammler::new(20e-6, 1.5).unwrap();
        assert!(matches!(sizes(d).mean_volume(), Err(ParticleError::Diverges { .. })));
        assert!(sizes(d.truncated(1e-7, 1.0).unwrap()).mean_volume().is_ok());
        assert!(sizes(RosinRammler::new(20e-6, 3.5).unwrap()).mean_volume().is_ok());
        assert!(matches!(d.truncated(1.0, 0.5), Err(ParticleError::Limits { .. })));
        assert!(matches!(d.truncated(1.0, 2.0), Err(ParticleError::Empty { .. })));
        assert!(RosinRammler::new(-1.0, 1.0).is_err() && RosinRammler::new(1.0, 0.0).is_err());
    }
}
