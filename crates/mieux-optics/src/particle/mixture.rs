//! Sums of size distributions, as of several modes.

use super::{ParticleError, SizeDistribution, Weighting};

/// Several distributions together, each with its share.
#[derive(Debug, Clone, PartialEq)]
pub struct MixedSizes {
    /// Shares of the volume, which add up to 1.
    parts: Vec<(f64, SizeDistribution)>,
}

impl MixedSizes {
    /// From distributions and their shares, by number, surface or volume as the weighting says, in any unit.
    ///
    /// # Errors
    /// [`ParticleError::Shares`] unless all shares are finite and not negative and some are positive;
    /// [`ParticleError::Diverges`] when one has, say, no finite number for a share by number.
    pub fn new(weighting: Weighting, parts: Vec<(f64, SizeDistribution)>) -> Result<Self, ParticleError> {
        if let Some((value, _)) = parts.iter().find(|(share, _)| !(share.is_finite() && *share >= 0.0)) {
            return Err(ParticleError::Shares { value: *value });
        }
        let mut volumes = Vec::with_capacity(parts.len());
        for (share, sizes) in parts {
            if share > 0.0 {
                volumes.push((share / sizes.moment(weighting.power())?, sizes));
            }
        }
        let total: f64 = volumes.iter().map(|(volume, _)| volume).sum();
        if !(total > 0.0 && total.is_finite()) {
            return Err(ParticleError::Shares { value: total });
        }
        Ok(Self { parts: volumes.into_iter().map(|(volume, sizes)| (volume / total, sizes)).collect() })
    }

    /// Shares of the volume, which add up to 1, and what has them.
    pub fn parts(&self) -> &[(f64, SizeDistribution)] {
        &self.parts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_by_what_was_said() {
        let one = SizeDistribution::monodisperse(1e-6).unwrap();
        let two = SizeDistribution::monodisperse(2e-6).unwrap();
        for (weighting, factor) in [(Weighting::Number, 8.0), (Weighting::Surface, 2.0), (Weighting::Volume, 1.0)] {
            let mix = MixedSizes::new(weighting, vec![(1.0, one.clone()), (1.0, two.clone())]).unwrap();
            let expected = factor / (1.0 + factor);
            assert!((mix.parts()[1].0 - expected).abs() < 1e-12, "{weighting}");
        }
        let mix = MixedSizes::new(Weighting::Number, vec![(3.0, one.clone()), (1.0, two)]).unwrap();
        let nested =
            MixedSizes::new(Weighting::Volume, vec![(1.0, SizeDistribution::Mixture(mix)), (0.0, one)]).unwrap();
        let mean = SizeDistribution::Mixture(nested).mean_radius(1.0, 0.0).unwrap();
        assert!((mean / 1.25e-6 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn shares_must_add_up_to_something() {
        let one = SizeDistribution::monodisperse(1e-6).unwrap();
        for shares in [vec![], vec![(0.0, one.clone())], vec![(-1.0, one.clone())], vec![(f64::NAN, one)]] {
            assert!(matches!(MixedSizes::new(Weighting::Volume, shares), Err(ParticleError::Shares { .. })));
        }
    }
}
