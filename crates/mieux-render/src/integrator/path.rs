//! One path from the camera into the light.

use super::interface::Interface;
use super::throughput::{ROULETTE, Throughput};
use super::turbid::MediumLanes;
use super::walk::{Flight, WalkEnd, walk};
use super::{LANES, Lanes, Statistics, Transport};
use crate::geometry::{Accelerator, Hit, Ray};
use crate::sampler::PixelSampler;
use crate::scene::{Owner, Prepared};
use crate::surface::{Crossing, Interior, cosine_hemisphere};

/// What one path tells: wavelengths (m, the hero first) and an estimate of the radiance at each.
///
/// The mean over many paths of `radiance[k]`, gathered by wavelength over all `k`, is the radiance there. A single
/// one may be 0 for companions that ended; the others make up for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Wavelengths, m.
    pub wavelengths: Lanes,
    /// Radiance at each, relative as that of the [`crate::light::Environment`].
    pub radiance: Lanes,
}

/// Most surfaces one path may meet.
const MOST_SURFACES: u32 = 200_000;

/// Directions towards the light sampled at a diffuse surface: cheap beside a walk through milk.
const LIGHTS: u32 = 4;

/// Surfaces in a row, without scattering in between, at which smooth normals are believed. Mirrored between smooth
/// normals that differ from their facets, light can run in circles for ever; between facets it finds its way out.
const MOST_SMOOTH: u32 = 200;

/// Follows one path from a ray that starts where the scene's camera stands. The sampler's next number chooses the
/// wavelengths.
pub fn trace(
    scene: &Prepared,
    transport: &Transport,
    ray: Ray,
    sampler: &mut PixelSampler,
    statistics: &mut Statistics,
) -> Estimate {
    let wavelengths = scene.observer().wavelengths(sampler.uniform());
    let interior = scene.camera_interior();
    let mut path = Path {
        scene,
        transport,
        wavelengths,
        ray,
        exclude: Accelerator::NONE,
        interior,
        medium: MediumLanes::vacuum(),
        walked: 0.0,
        in_a_row: 0,
        throughput: Throughput::new(transport.companions),
        scattered: None,
        radiance: [0.0; LANES],
        sampler,
        statistics,
    };
    path.medium = path.medium_of(&interior);
    // The camera sees L = n^2 (L / n^2), with the index it stands in.
    let scale = path.medium.n_geometry.map(|n| n * n);
    path.statistics.paths += 1;
    path.run();
    let radiance = path.radiance;
    Estimate { wavelengths, radiance: std::array::from_fn(|k| radiance[k] * scale[k]) }
}

pub(super) struct Path<'a> {
    pub(super) scene: &'a Prepared,
    transport: &'a Transport,
    pub(super) wavelengths: Lanes,
    pub(super) ray: Ray,
    /// The triangle the ray has just left.
    pub(super) exclude: u32,
    pub(super) interior: Interior,
    pub(super) medium: MediumLanes,
    /// Distance walked in the present medium since it was entered, m.
    walked: f64,
    /// Surfaces met since the last scattering.
    pub(super) in_a_row: u32,
    pub(super) throughput: Throughput,
    /// Density of the last direction, where light could also have been sampled directly.
    pub(super) scattered: Option<f64>,
    radiance: Lanes,
    pub(super) sampler: &'a mut PixelSampler,
    pub(super) statistics: &'a mut Statistics,
}

impl Path<'_> {
    fn run(&mut self) {
        for _ in 0..MOST_SURFACES {
            let met = match self.medium.turbid {
                None => self.straight(),
                Some(_) => self.scatter(),
            };
            let Some(hit) = met else { return };
            self.statistics.surfaces += 1;
            let goes_on = match self.scene.owner(hit.owner) {
                Owner::Body(body) => self.cross(&hit, body),
                Owner::Surface(surface) => self.diffuse(&hit, surface),
            };
            if !goes_on || !self.throughput.survives(ROULETTE, || self.sampler.uniform()) {
                return;
            }
        }
        self.statistics.lost += 1;
    }

    /// Goes straight to the next surface; gathers the light if there is none.
    fn straight(&mut self) -> Option<Hit> {
        let hit = self.scene.accelerator().intersect(&self.ray, f64::INFINITY, self.exclude);
        match hit {
            Some(hit) if self.medium.absorbs => self.throughput.absorb(&self.medium.transmittance(hit.t)),
            Some(_) => {}
            None => self.escape(),
        }
        hit
    }

    /// Walks at random to the next surface, if it gets there.
    fn scatter(&mut self) -> Option<Hit> {
        let turbid = self.medium.turbid?;
        self.in_a_row = 0;
        let limit = turbid.similarity_length();
        let (mut end, mut medium) = (WalkEnd::Length, turbid);
        while let WalkEnd::Length = end {
            let reduce = self.transport.similarity && self.walked > limit;
            if reduce {
                medium = turbid.reduced(&self.medium.sigma_a);
            }
            let left = if self.transport.similarity && !reduce { limit - self.walked } else { f64::INFINITY };
            let length;
            let flight = Flight { ray: &mut self.ray, exclude: &mut self.exclude, throughput: &mut self.throughput };
            let generator = self.sampler.generator();
            (end, length) = walk(self.scene.accelerator(), &medium, flight, left, generator, self.statistics);
            self.walked += length;
        }
        match end {
            WalkEnd::Hit(hit) => Some(hit),
            WalkEnd::Lost => {
                self.statistics.lost += 1;
                None
            }
            WalkEnd::Absorbed | WalkEnd::Length => None,
        }
    }

    /// The ray leaves the scene: the light of that direction, weighed against having been sampled directly.
    fn escape(&mut self) {
        if !self.interior.is_empty() {
            self.statistics.lost += 1;
            return;
        }
        let light = self.scene.light(&self.wavelengths);
        let pattern = self.scene.pattern();
        let weight = self
            .scattered
            .map_or(1.0, |density| density / (density + f64::from(LIGHTS) * pattern.density(self.ray.direction)));
        self.gather(&light, weight * pattern.value(self.ray.direction));
    }

    fn gather(&mut self, light: &Lanes, factor: f64) {
        let added = self.throughput.estimate(light);
        (0..LANES).for_each(|k| self.radiance[k] += added[k] * factor);
    }

    /// The surface of a body: through, or reflected, or refracted.
    fn cross(&mut self, hit: &Hit, body: u16) -> bool {
        self.scattered = None;
        let mut normals = self.scene.accelerator().normals(hit);
        self.in_a_row += 1;
        if self.in_a_row > MOST_SMOOTH {
            normals.1 = normals.0;
        }
        let entering = self.ray.direction.dot(normals.0) < 0.0;
        self.ray.origin = self.ray.at(hit.t);
        self.exclude = hit.triangle;
        match self.interior.cross(body, entering, |b| self.scene.priority(b)) {
            Crossing::Inconsistent => self.statistics.inconsistencies += 1,
            Crossing::Hidden(next) => self.interior = next,
            Crossing::Interface(next) => return self.interface(normals, next),
        }
        true
    }

    fn interface(&mut self, normals: (glam::DVec3, glam::DVec3), next: Interior) -> bool {
        let beyond = self.medium_of(&next);
        let interface = Interface::new(self.ray.direction, normals, &self.medium, &beyond);
        let xi = self.sampler.uniform();
        if xi < interface.reflectance[0] {
            self.throughput.choose(&interface.reflectance);
            self.ray.direction = interface.reflected();
            return true;
        }
        self.throughput.choose(&interface.reflectance.map(|r| 1.0 - r));
        if self.transport.diffusion
            && beyond.turbid.is_some()
            && let Some(entry) = self.diffusing(&next, &beyond)
        {
            let facet = normals.0 * -self.ray.direction.dot(normals.0).signum();
            return self.emerge(&entry, facet);
        }
        let Some(direction) = interface.refracted() else {
            // A smooth normal promised what its facet cannot keep: stay inside.
            self.ray.direction = interface.reflected();
            return true;
        };
        self.throughput.keep(|lane| interface.bends_alike(lane));
        self.ray.direction = direction;
        self.interior = next;
        self.medium = beyond;
        self.walked = 0.0;
        true
    }

    /// An opaque diffuse surface: gathers light sampled directly, then goes on in a random direction. Only the facet's own
    /// normal counts here: with a smooth one in its place a white surface would lose a little light at every bend.
    fn diffuse(&mut self, hit: &Hit, surface: u16) -> bool {
        let facet = self.scene.accelerator().normals(hit).0;
        let normal = if self.ray.direction.dot(facet) > 0.0 { -facet } else { facet };
        self.ray.origin = self.ray.at(hit.t);
        self.exclude = hit.triangle;
        self.in_a_row = 0;
        self.throughput.absorb(&self.scene.reflectance(surface, &self.wavelengths));
        let direction = self.lit(normal, |_| [1.0; LANES]);
        self.ray.direction = direction;
        true
    }

    /// At a point that sends light diffusely about `normal`, the given share of it: gathers the light sampled directly, and
    /// draws the direction in which the path goes on.
    pub(super) fn lit(&mut self, normal: glam::DVec3, share: impl Fn(glam::DVec3) -> Lanes) -> glam::DVec3 {
        // From inside a body the light is only reached by refraction, which no straight line finds.
        let open = self.interior.is_empty();
        let ([u, v], for_direction) = (self.sampler.pair(), self.sampler.pair());
        if open {
            for k in 0..LIGHTS {
                // One draw, turned: the samples stratify the choice and the place of the light between them.
                let turn = f64::from(k) / f64::from(LIGHTS);
                self.direct(normal, [(u + turn).fract(), (v + turn).fract()], &share);
            }
        }
        let (direction, density) = cosine_hemisphere(normal, for_direction);
        self.scattered = open.then_some(density);
        self.throughput.absorb(&share(direction));
        direction
    }

    /// Next-event estimation: one direction sampled by the light's brightness.
    fn direct(&mut self, normal: glam::DVec3, xi: [f64; 2], share: impl Fn(glam::DVec3) -> Lanes) {
        let pattern = self.scene.pattern();
        let (direction, density) = pattern.sample(xi);
        let cosine = direction.dot(normal);
        if !(cosine > 0.0 && density > 0.0) {
            return;
        }
        let shadow = Ray { origin: self.ray.origin, direction };
        if self.scene.accelerator().occluded(&shadow, f64::INFINITY, self.exclude) {
            return;
        }
        let diffuse = cosine * std::f64::consts::FRAC_1_PI;
        let (light, share) = (self.scene.light(&self.wavelengths), share(direction));
        let light = std::array::from_fn(|k| light[k] * share[k]);
        self.gather(&light, pattern.value(direction) * diffuse / (f64::from(LIGHTS) * density + diffuse));
    }

    pub(super) fn medium_of(&self, interior: &Interior) -> MediumLanes {
        let top = interior.top(|b| self.scene.priority(b));
        self.scene.medium(top, &self.wavelengths, self.transport.dispersion)
    }
}
