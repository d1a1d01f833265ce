//! Log-normal sizes, in any weighting.

use super::smooth::{Smooth, clipped, even_knots};
use super::{ParticleError, Weighting, check_limits, positive};

/// Log-normal distribution of radius, cut off at optional limits.
///
/// In weighting `w` the density in `r` is `exp(-(ln(r/median))^2 / (2 s^2)) / (r s sqrt(2 pi))`, `s` the standard
/// deviation of `ln r`. Limits cut all weightings alike; amounts refer to what is left between them.
///
/// Source: `frisvad2007` eq 49-50; conversion between weightings: `hatch1929`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LogNormal {
    weighting: Weighting,
    /// Median radius in this weighting, m.
    median_m: f64,
    /// Standard deviation of `ln r`.
    log_deviation: f64,
    minimum_m: f64,
    maximum_m: f64,
}

impl LogNormal {
    /// From the arithmetic mean and standard deviation of the radius (m) in the given weighting.
    ///
    /// # Errors
    /// [`ParticleError::NotPositive`].
    pub fn from_mean(weighting: Weighting, mean_m: f64, deviation_m: f64) -> Result<Self, ParticleError> {
        let mean = positive("mean radius", mean_m)?;
        let cv = positive("standard deviation", deviation_m)? / mean;
        let variance = (cv * cv).ln_1p();
        Self::new(weighting, mean * (-0.5 * variance).exp(), variance.sqrt())
    }

    /// From the median radius (m) and geometric standard deviation (above 1) in the given weighting.
    ///
    /// # Errors
    /// [`ParticleError`].
    pub fn from_median(weighting: Weighting, median_m: f64, geometric_deviation: f64) -> Result<Self, ParticleError> {
        if !(geometric_deviation > 1.0 && geometric_deviation.is_finite()) {
            return Err(ParticleError::GeometricDeviation { value: geometric_deviation });
        }
        Self::new(weighting, positive("median radius", median_m)?, geometric_deviation.ln())
    }

    fn new(weighting: Weighting, median_m: f64, log_deviation: f64) -> Result<Self, ParticleError> {
        let median_m = positive("median radius", median_m)?;
        let log_deviation = positive("width", log_deviation)?;
        Ok(Self { weighting, median_m, log_deviation, minimum_m: 0.0, maximum_m: f64::INFINITY })
    }

    /// Cuts the distribution off outside `minimum_m..maximum_m` (m).
    ///
    /// # Errors
    /// [`ParticleError::Limits`], or [`ParticleError::Empty`] when less than about 1e-23 of the volume would be left.
    pub fn truncated(self, minimum_m: f64, maximum_m: f64) -> Result<Self, ParticleError> {
        check_limits(minimum_m, maximum_m)?;
        let cut = Self { minimum_m, maximum_m, ..self };
        let (from, to) = cut.volume_range();
        if from < to { Ok(cut) } else { Err(ParticleError::Empty { minimum_m, maximum_m }) }
    }

    /// The same particles counted another way.
    pub fn in_weighting(self, weighting: Weighting) -> Self {
        let shift = (weighting.power() - self.weighting.power()) * self.log_deviation.powi(2);
        Self { weighting, median_m: self.median_m * shift.exp(), ..self }
    }

    /// How this value counts.
    pub fn weighting(&self) -> Weighting {
        self.weighting
    }

    /// Median radius in this weighting, m, limits disregarded.
    pub fn median(&self) -> f64 {
        self.median_m
    }

    /// Arithmetic mean radius in this weighting, m, limits disregarded.
    pub fn mean(&self) -> f64 {
        self.median_m * (0.5 * self.log_deviation.powi(2)).exp()
    }

    /// Geometric standard deviation, above 1; the same in every weighting.
    pub fn geometric_deviation(&self) -> f64 {
        self.log_deviation.exp()
    }

    /// Ratio of standard deviation to mean; the same in every weighting.
    pub fn coefficient_of_variation(&self) -> f64 {
        self.log_deviation.powi(2).exp_m1().sqrt()
    }

    /// The range of `ln r` that matters to the volume.
    fn volume_range(&self) -> (f64, f64) {
        let s = self.log_deviation;
        let centre = self.in_weighting(Weighting::Volume).median_m.ln();
        ((centre - 10.0 * s).max(self.minimum_m.ln()), (centre + 10.0 * s + 3.0 * s * s).min(self.maximum_m.ln()))
    }
}

impl Smooth for LogNormal {
    fn measure(&self, u: f64) -> (f64, f64) {
        let z = (u - self.in_weighting(Weighting::Volume).median_m.ln()) / self.log_deviation;
        (u.exp(), (-0.5 * z * z).exp())
    }

    /// Ten deviations about the medians that the powers shift.
    fn knots(&self, least: f64, most: f64) -> Option<Vec<f64>> {
        let s = self.log_deviation;
        let centre = |power: f64| self.in_weighting(Weighting::Volume).median_m.ln() + (power - 3.0) * s * s;
        let (from, to) =
            clipped([centre(least) - 10.0 * s, centre(most) + 10.0 * s], [self.minimum_m, self.maximum_m], 10.0 * s);
        Some(even_knots(from, to, 2.0 * s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::integrate;
    use std::convert::Infallible;

    /// Moment of the number distribution by quadrature: integral of `r^power N(r) dr` up to one constant for all powers.
    fn number_moment(d: &LogNormal, power: i32) -> f64 {
        let integral = integrate::<1, Infallible>(&d.knots(0.0, 7.0).unwrap(), 1e-12, [0.0], |u| {
            let (r, volume) = d.measure(u);
            Ok([volume * (r / 1e-6).powi(power - 3)])
        });
        integral.unwrap().unwrap().value[0]
    }

    #[test]
    fn weightings_convert_and_agree_with_moments() {
        let number = LogNormal::from_median(Weighting::Number, 0.4e-6, 1.5).unwrap();
        for weighting in Weighting::ALL {
            let d = number.in_weighting(weighting);
            let k = weighting.power() as i32;
            // The mean in a weighting is a ratio of number moments, found here by quadrature.
            let mean = number_moment(&number, k + 1) / number_moment(&number, k) * 1e-6;
            assert!((d.mean() / mean - 1.0).abs() < 1e-9, "{weighting:?}: {} {mean}", d.mean());
            let back = d.in_weighting(Weighting::Number);
            assert!((back.median() / number.median() - 1.0).abs() < 1e-14);
            assert!((d.geometric_deviation() - 1.5).abs() < 1e-14);
        }
    }

    #[test]
    fn mean_and_deviation_are_what_was_asked() {
        let d = LogNormal::from_mean(Weighting::Volume, 1e-6, 0.6e-6).unwrap();
        assert!((d.mean() / 1e-6 - 1.0).abs() < 1e-14);
        assert!((d.coefficient_of_variation() - 0.6).abs() < 1e-14);
    }

    #[test]
    fn what_is_no_distribution_is_refused() {
        assert!(LogNormal::from_mean(Weighting::Volume, -1e-6, 1e-7).is_err());
        assert!(LogNormal::from_mean(Weighting::Volume, 1e-6, 0.0).is_err());
        assert!(LogNormal::from_median(Weighting::Number, 1e-6, 1.0).is_err());
        assert!(LogNormal::from_median(Weighting::Number, f64::NAN, 1.5).is_err());
        let d = LogNormal::from_median(Weighting::Number, 1e-6, 1.1).unwrap();
        assert!(matches!(d.truncated(2e-6, 1e-6), Err(ParticleError::Limits { .. })));
        assert!(matches!(d.truncated(1e-3, 1e-2), Err(ParticleError::Empty { .. })));
        assert!(d.truncated(0.0, 2e-6).is_ok());
    }
}
