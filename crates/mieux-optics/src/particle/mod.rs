//! How large the particles of an inclusion are.

mod log_normal;
mod modified_gamma;
mod transformed_log_normal;

use std::f64::consts::PI;

use crate::integrate::integrate;

pub use log_normal::{LogNormal, Weighting};
pub use modified_gamma::ModifiedGamma;
pub use transformed_log_normal::TransformedLogNormal;

/// What can be wrong with a size distribution. All lengths in metres.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ParticleError {
    /// A radius or a width must be a positive finite number.
    #[error("{name} {value} must be positive and finite")]
    NotPositive {
        /// Which parameter.
        name: &'static str,
        /// What was given, SI.
        value: f64,
    },
    /// A geometric standard deviation is a ratio above 1.
    #[error("geometric standard deviation {value} must be above 1")]
    GeometricDeviation {
        /// What was given.
        value: f64,
    },
    /// Too many particles are vanishingly small for a mean over their number.
    #[error("the particles have no mean volume: too many of them are vanishingly small")]
    NoMeanVolume,
    /// The smallest radius must lie below the largest.
    #[error("radii from {minimum_m:e} m to {maximum_m:e} m: the minimum must be at least 0 and below the maximum")]
    Limits {
        /// Lower limit, m.
        minimum_m: f64,
        /// Upper limit, m.
        maximum_m: f64,
    },
    /// Nothing of the distribution lies between its limits, so it cannot be normalised.
    #[error("no particles between {minimum_m:e} m and {maximum_m:e} m: the distribution cannot be normalised")]
    Empty {
        /// Lower limit, m.
        minimum_m: f64,
        /// Upper limit, m.
        maximum_m: f64,
    },
}

/// The sizes of one kind of particle, all spheres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SizeDistribution {
    /// One radius for all, m.
    Monodisperse {
        /// Radius, m.
        radius_m: f64,
    },
    /// Logarithm of the radius normally distributed.
    LogNormal(LogNormal),
    /// Modified gamma distribution, as found for fogs and clouds.
    ModifiedGamma(ModifiedGamma),
    /// `r / (r_max - r)` log-normally distributed, as found for casein micelles.
    TransformedLogNormal(TransformedLogNormal),
}

impl SizeDistribution {
    /// All particles of one radius (m).
    ///
    /// # Errors
    /// [`ParticleError::NotPositive`].
    pub fn monodisperse(radius_m: f64) -> Result<Self, ParticleError> {
        Ok(Self::Monodisperse { radius_m: positive("radius", radius_m)? })
    }

    /// Mean volume of a particle, m^3: times the number of particles per volume, the volume fraction.
    ///
    /// # Errors
    /// [`ParticleError::NoMeanVolume`] when so many particles are vanishingly small that there is no such mean.
    pub fn mean_volume(&self) -> Result<f64, ParticleError> {
        let Some(knots) = self.knots() else { return Ok(sphere_volume(self.volume_measure(0.0).0)) };
        let unit = sphere_volume(self.volume_measure(0.5 * (knots[0] + knots[knots.len() - 1])).0);
        let integral = integrate(&knots, 1e-10, [0.0; 2], |u| {
            let (radius, volume) = self.volume_measure(u);
            Ok::<_, ParticleError>([volume, volume * unit / sphere_volume(radius)])
        })?;
        match integral {
            Some(integral) if integral.value[1] > 0.0 => Ok(unit * integral.value[0] / integral.value[1]),
            _ => Err(ParticleError::NoMeanVolume),
        }
    }

    /// Where to integrate: knots in an internal variable `u` for [`Self::volume_measure`]. `None` when monodisperse.
    pub(crate) fn knots(&self) -> Option<Vec<f64>> {
        match self {
            Self::Monodisperse { .. } => None,
            Self::LogNormal(d) => Some(d.knots()),
            Self::ModifiedGamma(d) => Some(d.knots()),
            Self::TransformedLogNormal(d) => Some(d.knots()),
        }
    }

    /// Radius (m) at `u`, and the volume of particles per unit of `u` there, up to a constant factor.
    pub(crate) fn volume_measure(&self, u: f64) -> (f64, f64) {
        match self {
            Self::Monodisperse { radius_m } => (*radius_m, 1.0),
            Self::LogNormal(d) => d.volume_measure(u),
            Self::ModifiedGamma(d) => d.volume_measure(u),
            Self::TransformedLogNormal(d) => d.volume_measure(u),
        }
    }
}

fn positive(name: &'static str, value: f64) -> Result<f64, ParticleError> {
    if value > 0.0 && value.is_finite() { Ok(value) } else { Err(ParticleError::NotPositive { name, value }) }
}

/// Volume of a sphere of the given radius (m), m^3.
pub fn sphere_volume(radius_m: f64) -> f64 {
    4.0 / 3.0 * PI * radius_m.powi(3)
}

/// Evenly spaced knots from `from` to `to`, no further apart than `step`.
fn even_knots(from: f64, to: f64, step: f64) -> Vec<f64> {
    let panels = ((to - from) / step).ceil().clamp(1.0, 64.0);
    (0..=panels as usize).map(|i| from + (to - from) * i as f64 / panels).collect()
}
