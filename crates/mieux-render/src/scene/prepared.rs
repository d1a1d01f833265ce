//! A scene checked and laid out for rendering.

use glam::DVec3;

use super::diffusing::{Diffusing, Dipoles};
use super::finish::{DenseFinish, FinishLanes};
use super::{Body, Scene, SceneError, Surface};
use crate::camera::Pinhole;
use crate::film::Observer;
use crate::geometry::{Accelerator, Mesh, Ray};
use crate::integrator::{LANES, Lanes, MediumLanes};
use crate::light::{Emitter, Lights, Problem};
use crate::medium::{Dense, DenseMedium, Matter};
use crate::surface::{Interior, Microfacets, conductor_reflectance};

/// What a triangle belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Owner {
    /// The surface of a body, by index.
    Body(u16),
    /// A surface without an inside, by index.
    Surface(u16),
}

/// How light gets through a medium.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Way {
    /// Straight on.
    Straight,
    /// By the fast random walk, which looks for no lights.
    Walk,
    /// From collision to collision, looking for lights.
    Fog,
    /// The same through grids.
    Cloud,
}

/// A scene that can be rendered: meshes known to be closed, spectra known to reach, triangles sorted.
pub struct Prepared {
    camera: Pinhole,
    lights: Lights,
    media: Vec<DenseMedium>,
    /// How light gets through each body, whether light comes in straight, and its roughness.
    ways: Vec<Way>,
    lit: Vec<bool>,
    facets: Vec<Option<Microfacets>>,
    bends_everywhere: bool,
    priorities: Vec<i32>,
    finishes: Vec<DenseFinish>,
    /// For each surface its place among those that shine.
    emitters: Vec<Option<usize>>,
    accelerator: Accelerator,
    observer: Observer,
    camera_interior: Interior,
    diffusing: Diffusing,
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
        let named = |name: &str| {
            let name = name.to_owned();
            move |source| SceneError::Medium { name, source }
        };
        let medium = |body: &Body| DenseMedium::new(&body.medium, range).map_err(named(&body.name));
        let media: Vec<DenseMedium> = scene.bodies.iter().map(medium).collect::<Result<_, _>>()?;
        let finish = |s: &Surface| DenseFinish::new(&s.name, &s.finish, range);
        let facets = |b: &Body| roughness(&b.name, b.roughness);
        // What shines is sampled by its triangles, and met as such.
        let met = |s: &'_ Surface| (s.emission.is_some() && s.mesh.ball().is_some()).then(|| s.mesh.clone().faceted());
        let shiny: Vec<Option<Mesh>> = scene.surfaces.iter().map(met).collect();
        let surfaces = scene.surfaces.iter().zip(&shiny).map(|(s, faceted)| faceted.as_ref().unwrap_or(&s.mesh));
        let meshes = scene.bodies.iter().map(|b| &b.mesh).chain(surfaces);
        let mut shining = 0usize..;
        let mut prepared = Self {
            camera: scene.camera.clone(),
            lights: lights(scene)?,
            diffusing: Diffusing::new(&scene.bodies, &media, range),
            ways: Vec::new(),
            lit: Vec::new(),
            facets: scene.bodies.iter().map(facets).collect::<Result<_, _>>()?,
            bends_everywhere: media.iter().all(|medium| !medium.unbending),
            priorities: scene.bodies.iter().map(|b| b.priority).collect(),
            finishes: scene.surfaces.iter().map(finish).collect::<Result<_, _>>()?,
            emitters: scene.surfaces.iter().map(|s| s.emission.as_ref().and_then(|_| shining.next())).collect(),
            accelerator: Accelerator::new(meshes),
            observer,
            camera_interior: Interior::default(),
            media,
        };
        prepared.camera_interior = prepared.interior_at(scene.camera.position());
        prepared.find_ways();
        Ok(prepared)
    }

    /// Light comes straight into bodies that do not bend it, and into those that hold a light.
    fn find_ways(&mut self) {
        self.lit = self.media.iter().map(|medium| medium.unbending).collect();
        let places: Vec<DVec3> = self.lights.places().collect();
        for place in places {
            for &body in self.interior_at(place).bodies() {
                self.lit[usize::from(body)] = true;
            }
        }
        // A walk forgets where lights were looked for: where that can have been on the other side of an unseen surface, it
        // will not do.
        let looked_for = !self.finishes.is_empty() || self.facets.iter().any(Option::is_some);
        let way = |(medium, lit): (&DenseMedium, &bool)| match () {
            () if medium.clear => Way::Straight,
            () if medium.has_grids => Way::Cloud,
            () if medium.walkable && !(*lit && (looked_for || self.lights.worth_looking())) => Way::Walk,
            () => Way::Fog,
        };
        self.ways = self.media.iter().zip(&self.lit).map(way).collect();
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

    pub(crate) fn lights(&self) -> &Lights {
        &self.lights
    }

    /// What a surface does to light at the wavelengths of a path.
    pub(crate) fn finish(&self, surface: u16, wavelengths: &Lanes) -> FinishLanes {
        self.finishes[usize::from(surface)].lanes(wavelengths)
    }

    /// Share of light that a surface sends on when met at right angles.
    pub(crate) fn reflectance(&self, surface: u16, wavelengths: &Lanes) -> Lanes {
        match self.finish(surface, wavelengths) {
            FinishLanes::Diffuse { reflectance, .. } => reflectance,
            FinishLanes::Conductor { n, k, .. } => std::array::from_fn(|i| conductor_reflectance(1.0, n[i], k[i])),
            FinishLanes::ThinPane { .. } => [1.0; LANES],
        }
    }

    /// The place of a surface among those that shine.
    pub(crate) fn emitter(&self, surface: u16) -> Option<usize> {
        self.emitters[usize::from(surface)]
    }

    /// The facets of a body's surface if it is rough.
    pub(crate) fn roughness(&self, body: u16) -> Option<Microfacets> {
        self.facets[usize::from(body)]
    }

    /// How light gets through what fills a place.
    pub(crate) fn way(&self, body: Option<u16>) -> Way {
        body.map_or(Way::Straight, |body| self.ways[usize::from(body)])
    }

    /// Whether some light may come straight into a body, or into the air.
    pub(crate) fn is_lit(&self, body: Option<u16>) -> bool {
        body.is_none_or(|body| self.lit[usize::from(body)])
    }

    /// Whether lights are looked for from within a body.
    pub(crate) fn looks_from(&self, body: Option<u16>) -> bool {
        self.is_lit(body) && self.lights.worth_looking()
    }

    /// Whether rays go straight on from what fills one place into what fills another.
    pub(crate) fn goes_straight(&self, from: Option<u16>, to: Option<u16>) -> bool {
        let index = |body: Option<u16>| body.map(|body| &self.media[usize::from(body)]);
        match (index(from), index(to)) {
            (None, None) => true,
            (Some(one), None) | (None, Some(one)) => one.unbending,
            (Some(a), Some(b)) => a.unbending && b.unbending || a.n.is_same(&b.n),
        }
    }

    /// Whether every body bends light that comes from the air.
    pub(crate) fn bends_everywhere(&self) -> bool {
        self.bends_everywhere
    }

    /// What scatters in a body at the wavelengths of a path.
    pub(crate) fn matter(&self, body: u16, wavelengths: &Lanes) -> Matter<'_> {
        self.media[usize::from(body)].matter(wavelengths)
    }

    /// Extinction of what is everywhere in a body, 1/m.
    pub(crate) fn extinction(&self, body: u16, wavelengths: &Lanes) -> Lanes {
        let medium = &self.media[usize::from(body)];
        wavelengths.map(|w| medium.sigma_s.at(w) + medium.sigma_a.at(w))
    }

    /// How light diffuses under the surface between a body and another, or nothing; `None` where it has to be followed.
    pub(crate) fn dipoles(&self, body: u16, beyond: Option<u16>, wavelengths: &Lanes) -> Option<Dipoles> {
        self.diffusing.dipoles(&self.media, body, beyond, wavelengths)
    }

    pub(crate) fn medium(&self, body: Option<u16>, wavelengths: &Lanes, dispersion: bool) -> MediumLanes {
        let Some(body) = body else { return MediumLanes::vacuum() };
        let (medium, way) = (&self.media[usize::from(body)], self.ways[usize::from(body)]);
        let n = if medium.unbending { [1.0; LANES] } else { medium.n.lanes(wavelengths) };
        let n_geometry = if dispersion { n } else { [medium.n_design; LANES] };
        let at = |spectrum: &Dense| spectrum.lanes(wavelengths);
        match way {
            Way::Fog | Way::Cloud => return MediumLanes::unwalked([0.0; LANES], n, n_geometry),
            Way::Straight => return MediumLanes::unwalked(at(&medium.sigma_a), n, n_geometry),
            Way::Walk => {}
        }
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

pub(super) fn roughness(name: &str, alpha: f64) -> Result<Option<Microfacets>, SceneError> {
    if (0.0..=1.0).contains(&alpha) {
        Ok(Microfacets::new(alpha))
    } else {
        Err(SceneError::Roughness { name: name.into(), value: alpha })
    }
}

/// The lights of a scene.
fn lights(scene: &Scene) -> Result<Lights, SceneError> {
    let range = scene.wavelength_range;
    let mut emitters = Vec::new();
    for surface in &scene.surfaces {
        let Some(emission) = &surface.emission else { continue };
        let valid = |v: f64| v >= 0.0 && v.is_finite();
        let radiance = Dense::new("emission", emission, range, "must not be negative", valid)
            .map_err(|source| SceneError::Medium { name: surface.name.clone(), source })?;
        emitters.push(Emitter { mesh: &surface.mesh, radiance });
    }
    Lights::new(&scene.environment, &scene.lamps, emitters, range).map_err(|problem| match problem {
        Problem::Light(error) => error.into(),
        Problem::Spectrum(source) => SceneError::Medium { name: "a light".into(), source },
    })
}
