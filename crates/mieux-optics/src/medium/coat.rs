//! Coats of spherical particles.

use crate::particle::ParticleError;
use crate::substance::Substance;

/// A layer around a core or around another coat.
#[derive(Debug, Clone, PartialEq)]
pub struct Coat {
    substance: Substance,
    extent: CoatExtent,
}

/// How thick a coat is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CoatExtent {
    /// The same on every particle, m.
    Thickness(f64),
    /// Radius of what is inside the coat, over that of its outer face: between 0 and 1.
    RadiusRatio(f64),
    /// Volume of the coat, over that of all within its outer face: between 0 and 1.
    VolumeShare(f64),
}

/// Which radius of a coated sphere a size distribution is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SizedBy {
    /// That of the outermost face. A coat thicker than a particle is all of it.
    #[default]
    Outside,
    /// That of the core.
    Core,
}

impl Coat {
    /// Of what, and how thick.
    ///
    /// # Errors
    /// [`ParticleError::NotPositive`] for a thickness, [`CoatError`] for a ratio or share.
    pub fn new(substance: Substance, extent: CoatExtent) -> Result<Self, CoatError> {
        let (name, value, possible) = match extent {
            CoatExtent::Thickness(value) => {
                if !(value > 0.0 && value.is_finite()) {
                    return Err(ParticleError::NotPositive { name: "thickness of a coat", value }.into());
                }
                return Ok(Self { substance, extent });
            }
            CoatExtent::RadiusRatio(value) => ("radius ratio", value, value > 0.0 && value < 1.0),
            CoatExtent::VolumeShare(value) => ("volume share", value, value > 0.0 && value < 1.0),
        };
        if possible { Ok(Self { substance, extent }) } else { Err(CoatError::Share { name, value }) }
    }

    /// What it is made of.
    pub fn substance(&self) -> &Substance {
        &self.substance
    }

    /// How thick it is.
    pub fn extent(&self) -> CoatExtent {
        self.extent
    }
}

/// What can be wrong with a coat.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum CoatError {
    /// A share that is none.
    #[error("{name} {value} of a coat must lie between 0 and 1")]
    Share {
        /// Which parameter.
        name: &'static str,
        /// What was given.
        value: f64,
    },
    /// No length.
    #[error(transparent)]
    Particle(#[from] ParticleError),
}

impl CoatExtent {
    /// Radius of the outer face around an inner one, m.
    pub(super) fn outer(self, inner: f64) -> f64 {
        match self {
            Self::Thickness(thickness) => inner + thickness,
            Self::RadiusRatio(ratio) => inner / ratio,
            Self::VolumeShare(share) => inner / (1.0 - share).cbrt(),
        }
    }

    /// Radius of the inner face within an outer one, m; 0 where the coat is all.
    pub(super) fn inner(self, outer: f64) -> f64 {
        match self {
            Self::Thickness(thickness) => (outer - thickness).max(0.0),
            Self::RadiusRatio(ratio) => outer * ratio,
            Self::VolumeShare(share) => outer * (1.0 - share).cbrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outward_and_inward_are_one() {
        for extent in [CoatExtent::Thickness(2e-8), CoatExtent::RadiusRatio(0.7), CoatExtent::VolumeShare(0.4)] {
            assert!((extent.inner(extent.outer(1e-7)) / 1e-7 - 1.0).abs() < 1e-12);
        }
        assert!((CoatExtent::VolumeShare(0.875).inner(2.0) - 1.0).abs() < 1e-12);
        assert_eq!(CoatExtent::Thickness(2.0).inner(1.0), 0.0);
    }

    #[test]
    fn impossible_coats_are_refused() {
        for extent in [
            CoatExtent::Thickness(0.0),
            CoatExtent::Thickness(f64::NAN),
            CoatExtent::RadiusRatio(1.0),
            CoatExtent::VolumeShare(0.0),
            CoatExtent::VolumeShare(f64::NAN),
        ] {
            assert!(Coat::new(Substance::Air, extent).is_err(), "{extent:?}");
        }
    }
}
