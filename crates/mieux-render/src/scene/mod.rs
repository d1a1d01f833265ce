//! What is to be rendered.

mod diffusing;
mod milk_glass;
mod prepared;

pub(crate) use diffusing::Dipoles;
pub use milk_glass::{GlassScene, glasses};
pub use prepared::{Owner, Prepared};

use mieux_optics::spectrum::Sampled;

use crate::camera::{CameraError, Pinhole};
use crate::film::ObserverError;
use crate::geometry::{GeometryError, Mesh};
use crate::light::{Environment, LightError};
use crate::medium::{Medium, MediumError};

/// A body: a closed mesh filled with a medium. Where bodies overlap, the one of highest priority is there.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// What it is called in messages.
    pub name: String,
    /// Its closed surface, facing outward.
    pub mesh: Mesh,
    /// What fills it.
    pub medium: Medium,
    /// Higher wins; among equals the earlier body.
    pub priority: i32,
}

/// An opaque diffuse (Lambertian) surface, seen from both sides. Vertex normals of its mesh are not used.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// What it is called in messages.
    pub name: String,
    /// Its surface; need not be closed.
    pub mesh: Mesh,
    /// Share of light reflected over wavelength, 0 to 1.
    pub reflectance: Sampled,
}

/// Everything a camera can see, and the camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Where it is seen from.
    pub camera: Pinhole,
    /// The light around it.
    pub environment: Environment,
    /// Bodies that refract, absorb and scatter.
    pub bodies: Vec<Body>,
    /// Opaque surfaces.
    pub surfaces: Vec<Surface>,
    /// Shortest and longest wavelength rendered, m: within 380 to 780 nm, and every spectrum must reach over it.
    pub wavelength_range: (f64, f64),
}

/// Why a scene cannot be rendered.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// The mesh around a medium has a hole, or edges that do not match.
    #[error("the mesh of body '{name}' is not closed: every edge must be shared by two triangles")]
    NotClosed {
        /// The body.
        name: String,
    },
    /// The triangles face inward.
    #[error("the mesh of body '{name}' is inside out: its volume is {volume} m^3")]
    InsideOut {
        /// The body.
        name: String,
        /// Its signed volume, m^3.
        volume: f64,
    },
    /// Too many bodies or surfaces.
    #[error("{count} {what} are more than 65535")]
    TooMany {
        /// Bodies or surfaces.
        what: &'static str,
        /// How many.
        count: usize,
    },
    /// A spectrum of a body or surface.
    #[error("'{name}': {source}")]
    Medium {
        /// Whose.
        name: String,
        /// What is wrong.
        source: MediumError,
    },
    /// No liquids were given to fill glasses with.
    #[error("no liquid to fill a glass with")]
    NoLiquids,
    /// The wavelengths.
    #[error(transparent)]
    Observer(#[from] ObserverError),
    /// A shape.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// A light.
    #[error(transparent)]
    Light(#[from] LightError),
    /// The camera.
    #[error(transparent)]
    Camera(#[from] CameraError),
}
