//! From a scene as it was read to one that can be rendered.

mod media;
mod shapes;
mod spectra;

use std::sync::Arc;

use mieux_io::scene::description::{Camera, Description, EnvironmentImage, FovAxis, Light, Place};
use mieux_optics::spectrum::Sampled;
use mieux_optics::spectrum::upsample::primaries;
use mieux_render::camera::Pinhole;
use mieux_render::light::{Environment, Lamp, Pattern, SkyImage, constant, relative_d65};
use mieux_render::medium::Medium;
use mieux_render::scene::Scene;

use super::JobError;
use spectra::{Kind, sampled};

/// Shortest and longest wavelength rendered, m.
pub(super) const RANGE: (f64, f64) = (380e-9, 780e-9);

/// A scene that can be rendered, and what was assumed on the way.
pub(super) struct Staged {
    pub(super) scene: Scene,
    pub(super) notes: Vec<String>,
}

/// What a scene's file asks for that cannot be done, and where it does.
pub(super) fn fault(place: &Place, reason: impl Into<String>) -> JobError {
    JobError::Scene { file: place.file.clone(), line: place.line, column: place.column, reason: reason.into() }
}

/// Builds the scene. `materials` are those of the description, in its order; `size` is the picture's.
///
/// # Errors
/// [`JobError::Scene`] with the place, or what the renderer says.
pub(super) fn stage(description: &Description, materials: &[Medium], size: [u32; 2]) -> Result<Staged, JobError> {
    let mut notes = description.notes.clone();
    let solids = shapes::stage(description, materials, &mut notes)?;
    let (environment, lamps) = lights(&description.lights, &mut notes)?;
    let scene = Scene {
        camera: camera(&description.camera, size)?,
        environment,
        lamps,
        bodies: solids.bodies,
        surfaces: solids.surfaces,
        wavelength_range: RANGE,
    };
    Ok(Staged { scene, notes })
}

/// A pinhole camera; the principal point shifts the view.
fn camera(camera: &Camera, size: [u32; 2]) -> Result<Pinhole, JobError> {
    let to_world = &camera.to_world;
    let position = to_world.point([0.0; 3]);
    let forward = to_world.vector([0.0, 0.0, 1.0]);
    let target = std::array::from_fn(|k| position[k] + forward[k]);
    let up = to_world.vector([0.0, 1.0, 0.0]);
    let [width, height] = size.map(f64::from);
    let half = (0.5 * camera.fov).tan();
    let along_y = match camera.fov_axis {
        FovAxis::X => half * height / width,
        FovAxis::Y => half,
        FovAxis::Smaller => half * height / width.min(height),
        FovAxis::Larger => half * height / width.max(height),
        FovAxis::Diagonal => half * height / width.hypot(height),
    };
    let degrees = 2.0 * along_y.atan().to_degrees();
    let pinhole = Pinhole::new(position, target, up, degrees, size).map_err(mieux_render::scene::SceneError::from);
    Ok(pinhole.map_err(mieux_render::render::RenderError::from)?.shifted(camera.principal_point))
}

fn lights(lights: &[Light], notes: &mut Vec<String>) -> Result<(Environment, Vec<Lamp>), JobError> {
    let mut lamps = Vec::new();
    let mut surroundings = None;
    for light in lights {
        let around = match light {
            Light::Environment { radiance } => {
                let spectrum = sampled(radiance, Kind::Light)?;
                Some(Environment { spectrum, pattern: Pattern::Uniform })
            }
            Light::EnvironmentImage(image) => Some(picture(image)?),
            Light::Point { position, intensity, .. } => {
                lamps.push(Lamp::Point { position: *position, intensity: sampled(intensity, Kind::Light)? });
                None
            }
            Light::Spot { position, direction, intensity, cutoff, beam_width, .. } => {
                lamps.push(Lamp::Spot {
                    position: *position,
                    direction: *direction,
                    intensity: sampled(intensity, Kind::Light)?,
                    cutoff: *cutoff,
                    beam_width: *beam_width,
                });
                None
            }
            Light::Directional { direction, irradiance } => {
                lamps.push(Lamp::Directional { direction: *direction, irradiance: sampled(irradiance, Kind::Light)? });
                None
            }
            Light::Studio => Some(mieux_render::scene::studio().map_err(mieux_render::render::RenderError::from)?),
            Light::Sky(_) => {
                return Err(JobError::NotYet { what: "a sky computed from the height of the sun".into() });
            }
        };
        if let Some(around) = around
            && surroundings.replace(around).is_some()
        {
            notes.push("of several surroundings only the last is there".into());
        }
    }
    Ok((surroundings.map_or_else(dark, Ok)?, lamps))
}

fn dark() -> Result<Environment, JobError> {
    Ok(Environment { spectrum: flat(0.0)?, pattern: Pattern::Uniform })
}

/// The same at all wavelengths.
pub(super) fn flat(value: f64) -> Result<Sampled, JobError> {
    constant(value).ok_or(JobError::Value {
        name: "a spectrum",
        value: value.to_string(),
        allowed: "values are finite",
    })
}

/// The picture's own frame has +y up and its middle along +z; the renderer's has +z up and its middle along -x.
fn picture(image: &EnvironmentImage) -> Result<Environment, JobError> {
    let axes = [[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(|axis| image.to_world.vector(axis));
    let unit = |v: [f64; 3]| {
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        v.map(|x| x / length)
    };
    let data: Vec<f32> = image.rgb.iter().flatten().map(|v| (f64::from(*v) * image.scale) as f32).collect();
    let [width, height] = image.size.map(|n| n as usize);
    let picture = SkyImage::new([width, height], primaries().to_vec(), data, axes.map(unit))
        .map_err(mieux_render::scene::SceneError::from)
        .map_err(mieux_render::render::RenderError::from)?;
    Ok(Environment { spectrum: relative_d65(), pattern: Pattern::Image(Arc::new(picture)) })
}
