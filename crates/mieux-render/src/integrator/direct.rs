//! Looking for light directly: a light is chosen, a point of it, and what is left of it on the straight way here.

use glam::DVec3;

use super::path::Path;
use super::throughput::Shadow;
use super::{LANES, Lanes};
use crate::geometry::{Accelerator, Ray};
use crate::light::{Segment, Viewpoint};
use crate::scene::{Owner, Prepared, Way};
use crate::surface::{Crossing, Interior};

/// Where, how often and how light was looked for.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    from: Viewpoint,
    /// Where along a segment the path was scattered, m.
    at: f64,
    count: f64,
}

impl View {
    pub(super) fn point(place: DVec3, surroundings: bool, count: u32) -> Self {
        Self { from: Viewpoint::Point { place, surroundings }, at: 0.0, count: f64::from(count) }
    }

    pub(super) fn segment(segment: Segment, at: f64) -> Self {
        Self { from: Viewpoint::Segment(segment), at, count: 1.0 }
    }

    fn place(&self) -> DVec3 {
        match self.from {
            Viewpoint::Point { place, .. } => place,
            Viewpoint::Segment(segment) => segment.origin + segment.direction * self.at,
        }
    }

    pub(super) fn density_of_surroundings(&self, scene: &Prepared, direction: DVec3) -> Lanes {
        scene.lights().density_of_surroundings(&self.from, self.at, direction).map(|d| d * self.count)
    }

    /// For a point of a shining surface and the cosine under which it is met.
    pub(super) fn density_of_emitter(&self, scene: &Prepared, emitter: usize, point: DVec3, cosine: f64) -> Lanes {
        let distance = (point - self.place()).length();
        scene.lights().density_of_emitter(emitter, &self.from, self.at, distance, cosine).map(|d| d * self.count)
    }
}

/// Surfaces through which a ray towards a light may go.
const MOST_MET: u32 = 1000;

/// What a place does to light from a direction: the share that goes on along the path, the density of that direction, and
/// where the ray towards the light starts.
pub(super) type Turned = Option<(Lanes, Lanes, Interior)>;

impl Path<'_> {
    /// Looks for light from a place, `count` times, and remembers it. A single draw, turned: the samples stratify the choice
    /// and the place of the light between them.
    pub(super) fn look(&mut self, count: u32, surroundings: bool, [u, v]: [f64; 2], turned: impl Fn(DVec3) -> Turned) {
        let place = self.ray.origin;
        let view = View::point(place, surroundings, count);
        let choice = if self.scene.lights().has_places() { self.sampler.uniform() } else { 0.0 };
        for k in 0..count {
            let turn = f64::from(k) / f64::from(count);
            let Some((light, chance)) = self.scene.lights().choose(&view.from, (choice + turn).fract()) else {
                continue;
            };
            let xi = [(u + turn).fract(), (v + turn).fract()];
            let Some(sample) = self.scene.lights().sample(light, place, xi, &self.wavelengths, &self.sky) else {
                continue;
            };
            let Some((share, density, start)) = turned(sample.direction) else { continue };
            let share = std::array::from_fn(|k| share[k] * sample.radiance[k]);
            let by_chance = if sample.point { [0.0; LANES] } else { density };
            let looked = [f64::from(count) * chance * sample.density; LANES];
            let shadow = self.throughput.towards(&share, &by_chance, &looked);
            self.add(shadow, Ray { origin: place, direction: sample.direction }, sample.distance, start);
        }
        self.view = Some(view);
        self.throughput.mark();
    }

    /// Adds the light at the end of a ray, as much as gets here.
    pub(super) fn add(&mut self, mut shadow: Shadow, ray: Ray, distance: f64, start: Interior) {
        if shadow.f.iter().all(|f| *f == 0.0) || !self.reaches(&mut shadow, ray, distance, start) {
            return;
        }
        let added = shadow.estimate();
        (0..LANES).for_each(|k| self.radiance[k] += added[k]);
    }

    /// Whether a light at a distance (m) is seen, through media that do not bend; dims what the ray carries.
    fn reaches(&mut self, shadow: &mut Shadow, mut ray: Ray, distance: f64, mut interior: Interior) -> bool {
        // The light itself is no obstacle.
        let mut left = distance * (1.0 - 1e-9);
        if self.scene.bends_everywhere() && interior.is_empty() {
            return !self.scene.accelerator().occluded(&ray, left, self.exclude);
        }
        let mut exclude = self.exclude;
        for _ in 0..MOST_MET {
            let hit = self.scene.accelerator().intersect(&ray, left, exclude);
            let length = hit.map_or(left, |hit| hit.t);
            if !self.dims(shadow, &ray, length, &interior) {
                return false;
            }
            let Some(hit) = hit else { return true };
            let Owner::Body(body) = self.scene.owner(hit.owner) else { return false };
            let entering = ray.direction.dot(self.scene.accelerator().normals(&hit).0) < 0.0;
            match interior.cross(body, entering, |b| self.scene.priority(b)) {
                Crossing::Inconsistent => self.statistics.inconsistencies += 1,
                Crossing::Hidden(next) => interior = next,
                Crossing::Interface(next) => {
                    let top = |interior: &Interior| interior.top(|b| self.scene.priority(b));
                    if !self.scene.goes_straight(top(&interior), top(&next)) {
                        return false;
                    }
                    interior = next;
                }
            }
            (ray.origin, exclude, left) = (ray.at(hit.t), hit.triangle, left - hit.t);
        }
        false
    }

    /// Dims a ray by what it goes through. False if nothing is left.
    fn dims(&mut self, shadow: &mut Shadow, ray: &Ray, length: f64, interior: &Interior) -> bool {
        let Some(body) = interior.top(|b| self.scene.priority(b)) else { return true };
        let way = self.scene.way(Some(body));
        if way == Way::Cloud {
            // Mostly it is what the path is in.
            let here = self.interior.top(|b| self.scene.priority(b)) == Some(body);
            let own = self.matter.filter(|_| here);
            let matter = own.unwrap_or_else(|| self.scene.matter(body, &self.wavelengths));
            return self.dims_by_grid(shadow, ray, length, &matter);
        }
        let extinction = self.scene.extinction(body, &self.wavelengths);
        let left = extinction.map(|s| if s > 0.0 { (-s * length).exp() } else { 1.0 });
        if way == Way::Straight {
            shadow.absorb(&left)
        } else {
            shadow.pass(&left)
        }
        shadow.f.iter().any(|f| *f > 0.0)
    }

    /// No triangle is left.
    pub(super) const ANYWHERE: u32 = Accelerator::NONE;
}
