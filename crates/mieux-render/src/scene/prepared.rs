//! A scene checked and laid out for rendering.

use glam::DVec3;

use super::diffusing::{Diffusing, Dipoles};
use super::{Body, Scene, SceneError};
use crate::camera::Pinhole;
use crate::film::Observer;
use crate::geometry::{Accelerator, Ray};
use crate::integrator::{Lanes, MediumLanes};
use crate::light::Pattern;
use crate::medium::{DESIGN_WAVELENGTH, Dense, MediumError};
use crate::surface::Interior;

/// What a triangle belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Owner {
    /// The surface of a body, by index.
    Body(u16),
    /// An opaque surface, by index.
    Surface(u16),
}

/// A scene that can be rendered: meshes known to be closed, spectra known to reach, triangles sorted.
pub struct Prepared {
    camera: Pinhole,
    pattern: Pattern,
    light: Dense,
    media: Vec<DenseMedium>,
    priorities: Vec<i32>,
    reflectances: Vec<Dense>,
    accelerator: Accelerator,
    observer: Observer,
    camera_interior: Interior,
    diffusing: Diffusing,
}

pub(super) struct DenseMedium {
    pub(super) sigma_s: Dense,
    pub(super) sigma_a: Dense,
    pub(super) g: Dense,
    pub(super) n: Dense,
    n_design: f64,
}

impl Prepared {
    /// Checks a scene and sorts its triangles.
    ///
    /// # Errors
    /// [`SceneError`] naming what is wrong and where.
    pub fn new(scene: &Scene) -> Result<Self, SceneError> {
        let range = scene.wavelength_range;
        let observer = Observer::new(range)?;
        for (what, count) in [("bodies", scene.bodies.len()), ("surfaces", scene.surfaces.len())] {
            if count > usize::from(u16::MAX) {
                return Err(SceneError::TooMany { what, count });
            }
        }
        scene.bodies.iter().try_for_each(check_closed)?;
        let media: Vec<DenseMedium> =
            scene.bodies.iter().map(|b| DenseMedium::new(b, range)).collect::<Result<_, _>>()?;
        let reflectance = |surface: &super::Surface| {
            let valid = |v| (0.0..=1.0).contains(&v);
            Dense::new("reflectance", &surface.reflectance, range, "must lie between 0 and 1", valid)
                .map_err(|source| SceneError::Medium { name: surface.name.clone(), source })
        };
        let light = Dense::new("radiance", &scene.environment.spectrum, range, "must not be negative", |v| v >= 0.0)
            .map_err(|source| SceneError::Medium { name: "environment".into(), source })?;
        let meshes = scene.bodies.iter().map(|b| &b.mesh).chain(scene.surfaces.iter().map(|s| &s.mesh));
        let mut prepared = Self {
            camera: scene.camera.clone(),
            pattern: scene.environment.pattern.clone(),
            light,
            diffusing: Diffusing::new(&scene.bodies, &media, range),
            media,
            priorities: scene.bodies.iter().map(|b| b.priority).collect(),
            reflectances: scene.surfaces.iter().map(reflectance).collect::<Result<_, _>>()?,
            accelerator: Accelerator::new(meshes),
            observer,
            camera_interior: Interior::default(),
        };
        prepared.camera_interior = prepared.interior_at(scene.camera.position());
        Ok(prepared)
    }

    /// The bodies a point (m) lies in: those that a ray from it leaves more often than it enters.
    pub fn interior_at(&self, point: DVec3) -> Interior {
        let mut depth = vec![0i32; self.media.len()];
        // An odd direction, so that it hardly runs along an edge of anything made by hand.
        let mut ray = Ray { origin: point, direction: DVec3::new(0.137, 0.2913, 0.9467).normalize() };
        let mut exclude = Accelerator::NONE;
        while let Some(hit) = self.accelerator.intersect(&ray, f64::INFINITY, exclude) {
            if let Owner::Body(body) = self.owner(hit.owner) {
                let leaving = self.accelerator.normals(&hit).0.dot(ray.direction) > 0.0;
                depth[usize::from(body)] += if leaving { 1 } else { -1 };
            }
            ray.origin = ray.at(hit.t);
            exclude = hit.triangle;
        }
        let inside = (0..self.media.len()).filter(|&b| depth[b] > 0);
        inside.fold(Interior::default(), |i, b| i.with(b as u16).unwrap_or(i))
    }

    /// The camera.
    pub fn camera(&self) -> &Pinhole {
        &self.camera
    }

    /// The observer of the rendered wavelengths.
    pub fn observer(&self) -> &Observer {
        &self.observer
    }

    /// All triangles.
    pub fn accelerator(&self) -> &Accelerator {
        &self.accelerator
    }

    /// The bodies in which the camera stands.
    pub fn camera_interior(&self) -> Interior {
        self.camera_interior
    }

    pub(crate) fn owner(&self, mesh: u32) -> Owner {
        let bodies = self.media.len();
        if (mesh as usize) < bodies {
            Owner::Body(mesh as u16)
        } else {
            Owner::Surface((mesh as usize - bodies) as u16)
        }
    }

    pub(crate) fn priority(&self, body: u16) -> i32 {
        self.priorities[usize::from(body)]
    }

    pub(crate) fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    pub(crate) fn light(&self, wavelengths: &Lanes) -> Lanes {
        self.light.lanes(wavelengths)
    }

    pub(crate) fn reflectance(&self, surface: u16, wavelengths: &Lanes) -> Lanes {
        self.reflectances[usize::from(surface)].lanes(wavelengths)
    }

    /// How light diffuses under the surface between a body and another, or nothing; `None` where it has to be followed.
    pub(crate) fn dipoles(&self, body: u16, beyond: Option<u16>, wavelengths: &Lanes) -> Option<Dipoles> {
        self.diffusing.dipoles(&self.media, body, beyond, wavelengths)
    }

    pub(crate) fn medium(&self, body: Option<u16>, wavelengths: &Lanes, dispersion: bool) -> MediumLanes {
        let Some(body) = body else { return MediumLanes::vacuum() };
        let medium = &self.media[usize::from(body)];
        let n = medium.n.lanes(wavelengths);
        let n_geometry = if dispersion { n } else { [medium.n_design; 4] };
        let at = |spectrum: &Dense| spectrum.lanes(wavelengths);
        MediumLanes::new(at(&medium.sigma_s), at(&medium.sigma_a), at(&medium.g), n, n_geometry)
    }
}

fn check_closed(body: &Body) -> Result<(), SceneError> {
    let name = || body.name.clone();
    if !body.mesh.is_closed() {
        return Err(SceneError::NotClosed { name: name() });
    }
    let volume = body.mesh.signed_volume();
    if volume > 0.0 { Ok(()) } else { Err(SceneError::InsideOut { name: name(), volume }) }
}

impl DenseMedium {
    fn new(body: &Body, range: (f64, f64)) -> Result<Self, SceneError> {
        let medium = &body.medium;
        let coefficient = |v: f64| (0.0..=1e12).contains(&v);
        let rule = "must lie between 0 and 1e12 per metre";
        let build = || -> Result<Self, MediumError> {
            let n = Dense::new("n", &medium.n, range, "must lie between 0.1 and 10", |v| (0.1..=10.0).contains(&v))?;
            let n = n.rounded();
            Ok(Self {
                sigma_s: Dense::new("sigma_s", &medium.sigma_s, range, rule, coefficient)?,
                sigma_a: Dense::new("sigma_a", &medium.sigma_a, range, rule, coefficient)?,
                g: Dense::new("g", &medium.g, range, "must lie between -1 and 1", |v| v > -1.0 && v < 1.0)?,
                n_design: n.at(DESIGN_WAVELENGTH),
                n,
            })
        };
        build().map_err(|source| SceneError::Medium { name: body.name.clone(), source })
    }
}
