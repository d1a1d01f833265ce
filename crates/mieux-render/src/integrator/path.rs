//! One path from the camera into the light.

use super::direct::View;
use super::interface::Interface;
use super::throughput::{ROULETTE, Throughput};
use super::turbid::MediumLanes;
use super::walk::{Flight, WalkEnd, walk};
use super::{LANES, Lanes, Statistics, Transport};
use crate::geometry::{Accelerator, Hit, Ray};
use crate::light::SkyLanes;
use crate::medium::Matter;
use crate::sampler::PixelSampler;
use crate::scene::{Owner, Prepared, Way};
use crate::surface::{Crossing, Interior};

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
        matter: None,
        way: Way::Straight,
        looking: false,
        sky: scene.lights().sky(&wavelengths),
        walked: 0.0,
        in_a_row: 0,
        throughput: Throughput::new(transport.companions),
        view: None,
        radiance: [0.0; LANES],
        sampler,
        statistics,
    };
    path.enter(interior, path.medium_of(&interior));
    // The camera sees L = n^2 (L / n^2), with the index it stands in.
    let scale = path.medium.n_geometry.map(|n| n * n);
    path.statistics.paths += 1;
    path.run();
    let radiance = path.radiance;
    Estimate { wavelengths, radiance: std::array::from_fn(|k| radiance[k] * scale[k]) }
}

pub(super) struct Path<'a> {
    pub(super) scene: &'a Prepared,
    pub(super) transport: &'a Transport,
    pub(super) wavelengths: Lanes,
    pub(super) ray: Ray,
    /// The triangle the ray has just left.
    pub(super) exclude: u32,
    pub(super) interior: Interior,
    pub(super) medium: MediumLanes,
    /// What scatters in the present medium, where it takes more than a walk.
    pub(super) matter: Option<Matter<'a>>,
    /// How light gets through the present medium.
    way: Way,
    /// Whether lights are looked for from within the present medium.
    pub(super) looking: bool,
    /// Spectra of the surroundings.
    pub(super) sky: SkyLanes,
    /// Distance walked in the present medium since it was entered, m.
    walked: f64,
    /// Surfaces met since the last scattering.
    pub(super) in_a_row: u32,
    pub(super) throughput: Throughput,
    /// Where light was last looked for directly.
    pub(super) view: Option<View>,
    pub(super) radiance: Lanes,
    pub(super) sampler: &'a mut PixelSampler,
    pub(super) statistics: &'a mut Statistics,
}

impl Path<'_> {
    fn run(&mut self) {
        for _ in 0..MOST_SURFACES {
            let met = match self.way {
                Way::Straight => self.straight(),
                Way::Walk => self.scatter(),
                Way::Fog => self.fog(),
                Way::Cloud => self.cloud(),
            };
            let Some(hit) = met else { return };
            self.statistics.surfaces += 1;
            let goes_on = match self.scene.owner(hit.owner) {
                Owner::Body(body) => self.cross(&hit, body),
                Owner::Surface(surface) => self.meet(&hit, surface),
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
        self.view = None;
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

    /// The ray leaves the scene: the light of that direction, weighed against having been looked for directly.
    fn escape(&mut self) {
        if !self.interior.is_empty() {
            self.statistics.lost += 1;
            return;
        }
        let light = self.scene.lights().surroundings(self.ray.direction, &self.sky);
        let looked =
            self.view.map_or([0.0; LANES], |view| view.density_of_surroundings(self.scene, self.ray.direction));
        self.gather(&light, &looked);
    }

    /// Light met by chance, that would have been looked for with the density `looked`.
    pub(super) fn gather(&mut self, light: &Lanes, looked: &Lanes) {
        let added = self.throughput.estimate_beside(light, looked);
        (0..LANES).for_each(|k| self.radiance[k] += added[k]);
    }

    /// The surface of a body: through, or reflected, or refracted.
    fn cross(&mut self, hit: &Hit, body: u16) -> bool {
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
            Crossing::Interface(next) => {
                let beyond = self.medium_of(&next);
                let top = |interior: &Interior| interior.top(|b| self.scene.priority(b));
                if self.scene.goes_straight(top(&self.interior), top(&next))
                    && !(self.transport.diffusion && self.diffusing(&next, &beyond).is_some())
                {
                    self.enter(next, beyond);
                    return true;
                }
                if let Some(facets) = self.scene.roughness(body) {
                    return self.rough(normals, next, &beyond, facets);
                }
                return self.interface(normals, next, &beyond);
            }
        }
        true
    }

    fn interface(&mut self, normals: (glam::DVec3, glam::DVec3), next: Interior, beyond: &MediumLanes) -> bool {
        self.view = None;
        self.throughput.forget();
        let interface = Interface::new(self.ray.direction, normals, &self.medium, beyond);
        let xi = self.sampler.uniform();
        if xi < interface.reflectance[0] {
            self.throughput.choose(&interface.reflectance);
            self.ray.direction = interface.reflected();
            return true;
        }
        self.throughput.choose(&interface.reflectance.map(|r| 1.0 - r));
        if self.transport.diffusion
            && let Some(entry) = self.diffusing(&next, beyond)
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
        self.enter(next, *beyond);
        true
    }

    /// The path goes on in another medium.
    pub(super) fn enter(&mut self, next: Interior, medium: MediumLanes) {
        let top = next.top(|b| self.scene.priority(b));
        (self.interior, self.medium, self.walked) = (next, medium, 0.0);
        (self.way, self.looking) = (self.scene.way(top), self.scene.looks_from(top));
        self.matter = match (self.way, top) {
            (Way::Fog | Way::Cloud, Some(body)) => Some(self.scene.matter(body, &self.wavelengths)),
            _ => None,
        };
        if self.way == Way::Walk && self.medium.turbid.is_none() {
            self.way = Way::Straight;
        }
    }

    pub(super) fn medium_of(&self, interior: &Interior) -> MediumLanes {
        let top = interior.top(|b| self.scene.priority(b));
        self.scene.medium(top, &self.wavelengths, self.transport.dispersion)
    }
}
