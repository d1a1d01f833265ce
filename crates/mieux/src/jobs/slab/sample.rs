//! What the slab is made of, as it is written down.

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use mieux_io::quantity::{OpticalThickness, Thickness};
use mieux_io::slab_file::phase::PhaseChoice;
use serde::{Deserialize, Serialize};

use super::SlabError;

/// What the slab is made of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Sample {
    /// An abstract medium, alike at all wavelengths.
    Medium {
        /// Single-scattering albedo, 0 to 1.
        albedo: f64,
        /// Asymmetry of the phase function `hg`; the others have none to be set.
        #[serde(default)]
        g: Option<f64>,
        /// Phase function.
        #[serde(default)]
        phase: PhaseName,
        /// Optical thicknesses, a slab for each.
        tau: Vec<OpticalThickness>,
        /// Refractive index; 1 when left out.
        #[serde(default)]
        index: Option<f64>,
    },
    /// A material, spectrally.
    Material {
        /// A built-in material, or the path of a recipe.
        material: String,
        /// Inputs that differ from the recipe's.
        #[serde(default)]
        set: BTreeMap<String, f64>,
        /// Thicknesses, a slab for each.
        thickness: Vec<Thickness>,
        /// Real refractive index; that of the host, wavelength by wavelength, when left out.
        #[serde(default)]
        index: Option<f64>,
    },
    /// Layers on each other.
    Layers {
        /// A file of layers.
        layers: PathBuf,
        /// The material that the file calls `*`.
        #[serde(default)]
        material: Option<String>,
        /// Its inputs that differ from the recipe's.
        #[serde(default)]
        set: BTreeMap<String, f64>,
        /// Its thicknesses, a slab for each.
        #[serde(default)]
        thickness: Vec<Thickness>,
    },
}

/// A phase function by its name, or a file with one. Parses "hg", "isotropic", "rayleigh"; anything else is a path.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(from = "String", into = "String")]
pub enum PhaseName {
    /// Henyey and Greenstein's.
    #[default]
    Hg,
    /// Into all directions alike.
    Isotropic,
    /// Of particles much smaller than the wavelength.
    Rayleigh,
    /// A table over angle or of Legendre moments ([`mieux_io::slab_file::phase`]).
    File(PathBuf),
}

impl PhaseName {
    pub(super) fn with_asymmetry(&self, g: Option<f64>) -> Result<PhaseChoice, SlabError> {
        match (self, g) {
            (Self::Hg, Some(g)) => Ok(PhaseChoice::Hg { g }),
            (Self::Hg, None) => Err(SlabError::Missing {
                what: "g",
                wanted: "the phase function hg has an asymmetry between -1 and 1; isotropic and rayleigh need none",
            }),
            (other, Some(_)) => {
                Err(SlabError::Meaningless { what: "g", with: format!("the phase function {other}, which needs none") })
            }
            (Self::Isotropic, None) => Ok(PhaseChoice::Isotropic),
            (Self::Rayleigh, None) => Ok(PhaseChoice::Rayleigh),
            (Self::File(path), None) => Ok(PhaseChoice::File(path.clone())),
        }
    }
}

impl FromStr for PhaseName {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(text.to_owned().into())
    }
}

impl From<String> for PhaseName {
    fn from(text: String) -> Self {
        match text.as_str() {
            "hg" => Self::Hg,
            "isotropic" => Self::Isotropic,
            "rayleigh" => Self::Rayleigh,
            _ => Self::File(text.into()),
        }
    }
}

impl From<PhaseName> for String {
    fn from(name: PhaseName) -> Self {
        name.to_string()
    }
}

impl fmt::Display for PhaseName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Hg => f.write_str("hg"),
            Self::Isotropic => f.write_str("isotropic"),
            Self::Rayleigh => f.write_str("rayleigh"),
            Self::File(path) => write!(f, "{}", path.display()),
        }
    }
}
