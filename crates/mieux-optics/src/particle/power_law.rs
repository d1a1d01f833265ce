//! Sizes by a power law, as minerals and algae in the sea and bubbles in ice.

use super::smooth::{Smooth, even_knots};
use super::{ParticleError, check_limits, positive};

/// Decades of `e` below the largest radius after which a power law from 0 holds nothing more.
const DEPTH: f64 = 40.0;

/// Number density `r^-exponent` between two radii; any real exponent, 1, 3 and 4 among them, where an integral is a logarithm.
///
/// Source: appendix A of `frisvad2007`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PowerLaw {
    exponent: f64,
    minimum_m: f64,
    maximum_m: f64,
}

impl PowerLaw {
    /// From the exponent and the smallest and largest radius (m). The smallest may be 0 while the volume of all particles
    /// stays finite, that is for exponents below 4.
    ///
    /// # Errors
    /// [`ParticleError::Limits`], [`ParticleError::Exponent`], or [`ParticleError::Diverges`].
    pub fn new(exponent: f64, minimum_m: f64, maximum_m: f64) -> Result<Self, ParticleError> {
        if !(-100.0..=100.0).contains(&exponent) {
            return Err(ParticleError::Exponent { value: exponent });
        }
        check_limits(minimum_m, maximum_m)?;
        let maximum_m = positive("maximum radius of a power law", maximum_m)?;
        if minimum_m == 0.0 && exponent >= 4.0 {
            return Err(ParticleError::Diverges { power: 3.0 });
        }
        Ok(Self { exponent, minimum_m, maximum_m })
    }

    /// The exponent.
    pub fn exponent(&self) -> f64 {
        self.exponent
    }

    /// Smallest and largest radius, m.
    pub fn limits(&self) -> (f64, f64) {
        (self.minimum_m, self.maximum_m)
    }
}

impl Smooth for PowerLaw {
    fn measure(&self, u: f64) -> (f64, f64) {
        // Relative to the end where most of the volume is, which keeps the exponential in range.
        let slope = 4.0 - self.exponent;
        let end = if slope >= 0.0 { self.maximum_m } else { self.minimum_m };
        (u.exp(), (slope * (u - end.ln())).exp())
    }

    fn knots(&self, least: f64, most: f64) -> Option<Vec<f64>> {
        let slope = |power: f64| power + 1.0 - self.exponent;
        let (mut from, mut to) = (self.minimum_m.ln(), self.maximum_m.ln());
        // A steep law keeps to one end; without a limit below, that is the upper.
        if slope(least) > 0.0 {
            from = from.max(to - DEPTH / slope(least));
        } else if self.minimum_m == 0.0 {
            return None;
        }
        if slope(most) < 0.0 {
            to = to.min(from - DEPTH / slope(most));
        }
        Some(even_knots(from, to, 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particle::SizeDistribution;

    /// `integral of r^power r^-exponent dr` in closed form, logarithms included.
    fn moment(power: f64, exponent: f64, [from, to]: [f64; 2]) -> f64 {
        let p = power + 1.0 - exponent;
        if p == 0.0 { (to / from).ln() } else { (to.powf(p) - from.powf(p)) / p }
    }

    #[test]
    fn moments_are_in_closed_form_for_every_exponent() {
        let limits = [0.1, 40.0];
        for exponent in [-2.0, 0.0, 1.0, 1.24, 2.0, 3.0, 3.4, 4.0, 5.0, 7.5] {
            let law = PowerLaw::new(exponent, limits[0] * 1e-6, limits[1] * 1e-6).unwrap();
            let sizes = SizeDistribution::PowerLaw(law);
            for (p, q) in [(1, 0), (3, 2), (4, 3), (3, 0)].map(|(p, q)| (f64::from(p), f64::from(q))) {
                let ratio = moment(p, exponent, limits) / moment(q, exponent, limits);
                let expected = ratio.powf(1.0 / (p - q)) * 1e-6;
                let found = sizes.mean_radius(p, q).unwrap();
                assert!((found / expected - 1.0).abs() < 1e-8, "{exponent}: D[{p},{q}] {found:e} {expected:e}");
            }
        }
    }

    /// The constants of the sea and ice models of `frisvad2007` (sections 4.2 and 4.3) are volume integrals of unit power
    /// laws; those of minerals and algae are in diameters.
    #[test]
    fn volume_constants_of_the_papers_follow() {
        use std::f64::consts::PI;
        let cases = [
            (3.4, 2f64.powf(-3.4), [0.01, 100.0], 10.440),
            (3.6, 2f64.powf(-3.6), [0.225, 100.0], 4.9735),
            (1.24, 1.0, [0.1, 2.0], 10.278),
        ];
        for (exponent, factor, limits, printed) in cases {
            // Number per volume is 1 over the mean volume; the law's own constant is that over its number integral.
            let law = PowerLaw::new(exponent, limits[0], limits[1]).unwrap();
            let mean = SizeDistribution::PowerLaw(law).mean_volume().unwrap();
            let constant = mean * moment(0.0, exponent, limits) * factor;
            assert!((constant / printed - 1.0).abs() < 2e-4, "{exponent}: {constant} {printed}");
            let closed = 4.0 / 3.0 * PI * moment(3.0, exponent, limits) * factor;
            assert!((constant / closed - 1.0).abs() < 1e-8);
        }
    }

    #[test]
    fn what_cannot_be_normalised_is_refused() {
        assert!(matches!(PowerLaw::new(2.0, 2e-6, 1e-6), Err(ParticleError::Limits { .. })));
        assert!(matches!(PowerLaw::new(2.0, 1e-6, f64::INFINITY), Err(ParticleError::NotPositive { .. })));
        assert!(matches!(PowerLaw::new(f64::NAN, 1e-6, 2e-6), Err(ParticleError::Exponent { .. })));
        assert!(matches!(PowerLaw::new(4.0, 0.0, 2e-6), Err(ParticleError::Diverges { .. })));
        // Their volume is finite, their number is not.
        let law = SizeDistribution::PowerLaw(PowerLaw::new(1.96, 0.0, 14.6e-3).unwrap());
        assert!((law.mean_radius(4.0, 3.0).unwrap() / (14.6e-3 * 2.04 / 3.04) - 1.0).abs() < 1e-8);
        assert!(matches!(law.mean_volume(), Err(ParticleError::Diverges { power }) if power == 0.0));
    }
}
