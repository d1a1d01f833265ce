//! Finishes of surfaces with all spectra laid out.

use mieux_optics::spectrum::Sampled;

use super::{Finish, SceneError};
use crate::integrator::Lanes;
use crate::medium::Dense;
use crate::surface::Microfacets;

pub(super) enum DenseFinish {
    Diffuse { reflectance: Dense, both_sides: bool },
    Conductor { n: Dense, k: Dense, facets: Option<Microfacets> },
    ThinPane { n: Dense },
}

/// A finish at the wavelengths of a path.
pub(crate) enum FinishLanes {
    Diffuse { reflectance: Lanes, both_sides: bool },
    Conductor { n: Lanes, k: Lanes, facets: Option<Microfacets> },
    ThinPane { n: Lanes },
}

impl DenseFinish {
    pub(super) fn new(name: &str, finish: &Finish, range: (f64, f64)) -> Result<Self, SceneError> {
        let dense = |what, spectrum: &Sampled, rule, valid: fn(f64) -> bool| {
            Dense::new(what, spectrum, range, rule, valid)
                .map_err(|source| SceneError::Medium { name: name.into(), source })
        };
        Ok(match finish {
            Finish::Diffuse { reflectance, both_sides } => {
                let rule = "must lie between 0 and 1";
                let reflectance = dense("reflectance", reflectance, rule, |v| (0.0..=1.0).contains(&v))?;
                Self::Diffuse { reflectance, both_sides: *both_sides }
            }
            Finish::Conductor { n, k, roughness } => Self::Conductor {
                n: dense("n", n, "must lie above 0", |v| v > 0.0 && v.is_finite())?,
                k: dense("k", k, "must not be negative", |v| v >= 0.0 && v.is_finite())?,
                facets: super::prepared::roughness(name, *roughness)?,
            },
            Finish::ThinPane { n } => {
                Self::ThinPane { n: dense("n", n, "must lie between 0.1 and 10", |v| (0.1..=10.0).contains(&v))? }
            }
        })
    }

    pub(super) fn lanes(&self, wavelengths: &Lanes) -> FinishLanes {
        match self {
            Self::Diffuse { reflectance, both_sides } => {
                FinishLanes::Diffuse { reflectance: reflectance.lanes(wavelengths), both_sides: *both_sides }
            }
            Self::Conductor { n, k, facets } => {
                FinishLanes::Conductor { n: n.lanes(wavelengths), k: k.lanes(wavelengths), facets: *facets }
            }
            Self::ThinPane { n } => FinishLanes::ThinPane { n: n.lanes(wavelengths) },
        }
    }
}
