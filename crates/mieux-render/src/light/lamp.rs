//! Lights without extent: seen by what they light, never themselves.

use glam::DVec3;
use mieux_optics::spectrum::Sampled;

use super::LightError;

/// A light without extent. Radiance is relative, as that of the [`super::Environment`]; intensity is radiance times m^2,
/// irradiance radiance times sr.
#[derive(Debug, Clone, PartialEq)]
pub enum Lamp {
    /// Shines the same in all directions.
    Point {
        /// Where, m.
        position: [f64; 3],
        /// Radiant intensity over wavelength.
        intensity: Sampled,
    },
    /// Shines into a cone.
    Spot {
        /// Where, m.
        position: [f64; 3],
        /// Where it shines to; any length.
        direction: [f64; 3],
        /// Radiant intensity along its axis over wavelength.
        intensity: Sampled,
        /// Half the angle of the cone, radians, above 0 and up to pi.
        cutoff: f64,
        /// Half the angle within which it is fully bright, radians; linear in the angle from here to the cone.
        beam_width: f64,
    },
    /// Shines from infinitely far away.
    Directional {
        /// Where it shines to; any length.
        direction: [f64; 3],
        /// Irradiance on a plane across it over wavelength.
        irradiance: Sampled,
    },
}

/// Where a lamp is, or where it shines to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Place {
    Near { position: DVec3, axis: DVec3, cutoff: f64, beam_width: f64 },
    Far { direction: DVec3 },
}

impl Lamp {
    /// Its spectrum.
    pub fn spectrum(&self) -> &Sampled {
        match self {
            Self::Point { intensity, .. } | Self::Spot { intensity, .. } => intensity,
            Self::Directional { irradiance, .. } => irradiance,
        }
    }

    pub(crate) fn place(&self) -> Result<Place, LightError> {
        let unit = |v: [f64; 3]| DVec3::from_array(v).try_normalize().ok_or(LightError::Direction { direction: v });
        let finite = |v: [f64; 3]| {
            let at = DVec3::from_array(v);
            if at.is_finite() { Ok(at) } else { Err(LightError::Position { position: v }) }
        };
        match self {
            Self::Point { position, .. } => Ok(Place::Near {
                position: finite(*position)?,
                axis: DVec3::Z,
                cutoff: std::f64::consts::PI,
                beam_width: std::f64::consts::PI,
            }),
            Self::Spot { position, direction, cutoff, beam_width, .. } => {
                let pi = std::f64::consts::PI;
                if !(*cutoff > 0.0 && *cutoff <= pi && *beam_width >= 0.0 && beam_width <= cutoff) {
                    return Err(LightError::Cone { cutoff: cutoff.to_degrees(), beam_width: beam_width.to_degrees() });
                }
                Ok(Place::Near {
                    position: finite(*position)?,
                    axis: unit(*direction)?,
                    cutoff: *cutoff,
                    beam_width: *beam_width,
                })
            }
            Self::Directional { direction, .. } => Ok(Place::Far { direction: unit(*direction)? }),
        }
    }
}

impl Place {
    /// Share of the full intensity that goes into a direction away from the lamp.
    pub(crate) fn profile(&self, away: DVec3) -> f64 {
        match self {
            Self::Far { .. } => 1.0,
            Self::Near { axis, cutoff, beam_width, .. } => {
                if *beam_width >= std::f64::consts::PI {
                    return 1.0;
                }
                let angle = away.dot(*axis).clamp(-1.0, 1.0).acos();
                if angle <= *beam_width {
                    1.0
                } else if angle >= *cutoff {
                    0.0
                } else {
                    (cutoff - angle) / (cutoff - beam_width)
                }
            }
        }
    }
}
