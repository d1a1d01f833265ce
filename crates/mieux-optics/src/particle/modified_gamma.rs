//! Modified gamma sizes, by which fogs and clouds are described.

use super::smooth::{Smooth, clipped, even_knots};
use super::{ParticleError, check_limits, positive};

/// Number density `r^alpha exp(-(alpha / gamma) (r / mode)^gamma)`, cut off at optional limits.
///
/// | | |
/// |---|---|
/// | `mode_m` | radius of which there are most, m |
/// | `alpha` | slope towards small radii, positive |
/// | `gamma` | steepness towards large ones, positive; 1 is the gamma distribution |
///
/// Source: `deirmendjian1969`; written with the mode in place of its factor `b = alpha / (gamma mode^gamma)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModifiedGamma {
    mode_m: f64,
    alpha: f64,
    gamma: f64,
    minimum_m: f64,
    maximum_m: f64,
}

impl ModifiedGamma {
    /// From the mode radius (m) and the two exponents.
    ///
    /// # Errors
    /// [`ParticleError::NotPositive`].
    pub fn new(mode_m: f64, alpha: f64, gamma: f64) -> Result<Self, ParticleError> {
        let mode_m = positive("mode radius", mode_m)?;
        let (alpha, gamma) = (positive("alpha", alpha)?, positive("gamma", gamma)?);
        Ok(Self { mode_m, alpha, gamma, minimum_m: 0.0, maximum_m: f64::INFINITY })
    }

    /// Cuts the distribution off outside `minimum_m..maximum_m` (m).
    ///
    /// # Errors
    /// [`ParticleError::Limits`], or [`ParticleError::Empty`] when as good as nothing would be left.
    pub fn truncated(self, minimum_m: f64, maximum_m: f64) -> Result<Self, ParticleError> {
        check_limits(minimum_m, maximum_m)?;
        let cut = Self { minimum_m, maximum_m, ..self };
        let [from, to] = cut.range(3.0, 6.0);
        if from.max(minimum_m.ln()) < to.min(maximum_m.ln()) {
            Ok(cut)
        } else {
            Err(ParticleError::Empty { minimum_m, maximum_m })
        }
    }

    /// Radius of which there are most, m.
    pub fn mode(&self) -> f64 {
        self.mode_m
    }

    /// `alpha` and `gamma`.
    pub fn exponents(&self) -> (f64, f64) {
        (self.alpha, self.gamma)
    }

    /// Where in `ln r`, limits disregarded, the volume times `r^(power - 3)` is above about `exp(-50)` of its largest, for
    /// powers from `least` to `most`.
    fn range(&self, least: f64, most: f64) -> [f64; 2] {
        let Self { mode_m, alpha, gamma, .. } = *self;
        let slope = |power: f64| alpha + 1.0 + power;
        let peak = |power: f64| (slope(power) / alpha).ln() / gamma;
        let low = peak(least) - 60.0 / slope(least) - 12.0 / (slope(least) * gamma).sqrt();
        let high = ((slope(most) + 50.0) / alpha * (1.0 + gamma)).ln() / gamma;
        [mode_m.ln() + low, mode_m.ln() + high.max(peak(most))]
    }
}

impl Smooth for ModifiedGamma {
    fn measure(&self, u: f64) -> (f64, f64) {
        let Self { mode_m, alpha, gamma, .. } = *self;
        let relative = u - mode_m.ln();
        // Relative to the peak of the volume, which keeps the exponential in range.
        let power = alpha + 4.0;
        let exponent = |v: f64| power * v - alpha / gamma * (gamma * v).exp();
        let peak = (power / alpha).ln() / gamma;
        (u.exp(), (exponent(relative) - exponent(peak)).exp())
    }

    fn knots(&self, least: f64, most: f64) -> Option<Vec<f64>> {
        // The width of the peak in ln r, from its curvature there.
        let width = 2.0 / ((self.alpha + 4.0) * self.gamma).sqrt();
        let (from, to) = clipped(self.range(least, most), [self.minimum_m, self.maximum_m], width);
        Some(even_knots(from, to, width))
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;
    use crate::integrate::integrate;

    /// Moments have a closed form for `gamma = 1`: the gamma function of integers.
    #[test]
    fn moments_are_those_of_the_gamma_distribution() {
        let d = ModifiedGamma::new(2e-6, 4.0, 1.0).unwrap();
        let moment = |power: i32| {
            let f = |u: f64| {
                let (r, volume) = d.measure(u);
                Ok::<_, Infallible>([volume * (r / 1e-6).powi(power - 3)])
            };
            integrate(&d.knots(0.0, 7.0).unwrap(), 1e-12, [0.0], f).unwrap().unwrap().value[0]
        };
        // Mean of r^(k+1) over mean of r^k is (k + alpha + 1) mode / alpha.
        for k in 0..7 {
            let expected = f64::from(k + 5) * 2.0 / 4.0;
            assert!((moment(k + 1) / moment(k) / expected - 1.0).abs() < 1e-9, "{k}");
        }
    }

    #[test]
    fn what_is_no_distribution_is_refused() {
        assert!(ModifiedGamma::new(0.0, 4.0, 1.0).is_err());
        assert!(ModifiedGamma::new(1e-6, -1.0, 1.0).is_err());
        assert!(ModifiedGamma::new(1e-6, 4.0, f64::NAN).is_err());
        let d = ModifiedGamma::new(1e-6, 4.0, 1.77).unwrap();
        assert!(matches!(d.truncated(2e-6, 1e-6), Err(ParticleError::Limits { .. })));
        assert!(matches!(d.truncated(1.0, 2.0), Err(ParticleError::Empty { .. })));
    }
}
