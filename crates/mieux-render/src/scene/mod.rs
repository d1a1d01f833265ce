//! What is to be rendered.

mod diffusing;
mod finish;
mod milk_glass;
mod prepared;

pub(crate) use diffusing::Dipoles;
pub(crate) use finish::FinishLanes;
pub use milk_glass::{GlassScene, glasses, studio};
pub(crate) use prepared::Way;
pub use prepared::{Owner, Prepared};

use mieux_optics::spectrum::Sampled;

use crate::camera::{CameraError, Pinhole};
use crate::film::ObserverError;
use crate::geometry::{GeometryError, Mesh};
use crate::light::{Environment, Lamp, LightError};
use crate::medium::{Medium, MediumError};

/// A body: a closed mesh filled with a medium. Where bodies overlap, the one of highest priority is there. A body with the
/// index of what is around it has no visible surface: fog, or a cloud.
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
    /// Roughness `alpha` of its surface ([`crate::surface::Microfacets`]), 0 to 1; 0 is smooth.
    pub roughness: f64,
}

/// What a surface without an inside does to light.
#[derive(Debug, Clone, PartialEq)]
pub enum Finish {
    /// Opaque, diffuse (Lambertian); vertex normals are not used.
    Diffuse {
        /// Share of light reflected over wavelength, 0 to 1.
        reflectance: Sampled,
        /// Whether its back is like its front; black if not.
        both_sides: bool,
    },
    /// A metal, the same on both sides.
    Conductor {
        /// Real refractive index over wavelength, above 0.
        n: Sampled,
        /// Imaginary refractive index over wavelength, at least 0.
        k: Sampled,
        /// Roughness `alpha`, 0 to 1.
        roughness: f64,
    },
    /// A thin pane: reflects and lets through, and does not bend.
    ThinPane {
        /// Refractive index over wavelength.
        n: Sampled,
    },
}

/// A surface without an inside.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    /// What it is called in messages.
    pub name: String,
    /// Its surface; need not be closed.
    pub mesh: Mesh,
    /// What it does to light.
    pub finish: Finish,
    /// Radiance it sends out over wavelength, from its front (the side from which corners run counter-clockwise).
    pub emission: Option<Sampled>,
}

impl Surface {
    /// An opaque diffuse surface, the same on both sides, that does not shine.
    pub fn diffuse(name: impl Into<String>, mesh: Mesh, reflectance: Sampled) -> Self {
        Self { name: name.into(), mesh, finish: Finish::Diffuse { reflectance, both_sides: true }, emission: None }
    }
}

/// Everything a camera can see, and the camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Where it is seen from.
    pub camera: Pinhole,
    /// The light around it.
    pub environment: Environment,
    /// Lights without extent.
    pub lamps: Vec<Lamp>,
    /// Bodies that refract, absorb and scatter.
    pub bodies: Vec<Body>,
    /// Surfaces without an inside.
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
    /// Roughness of a body or surface.
    #[error("the roughness of '{name}' is {value}; it lies between 0 and 1")]
    Roughness {
        /// Whose.
        name: String,
        /// The offending value.
        value: f64,
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
