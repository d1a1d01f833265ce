//! The approximate way through a turbid body: light leaves it somewhere near where it entered, by a diffusion profile.
//!
//! Points on the surface are found along lines that stand on a disk about the entry (`king2013`): along its normal or one of
//! two tangents, so that corners and far sides are reached; what any of the three, and any wavelength of the path, would
//! have found is weighed in.

use glam::DVec3;

use super::interface::Interface;
use super::path::Path;
use super::turbid::MediumLanes;
use super::{LANES, Lanes};
use crate::geometry::{Accelerator, Ray};
use crate::sampler::Turn;
use crate::scene::{Dipoles, Owner};
use crate::surface::{Crossing, Interior, cosine_hemisphere};

/// How often lines run along the normal and along each tangent: most surfaces are flat at the scale of the light below.
const CHANCES: [f64; 3] = [0.9, 0.05, 0.05];
/// Surfaces that a line may meet.
const MOST_MET: u32 = 1000;

/// A body entered from a side.
pub(super) struct Entry {
    body: u16,
    inside: MediumLanes,
    below: Dipoles,
}

/// A point where light may come out.
struct Exit {
    place: DVec3,
    /// Of the facet, away from the body.
    normal: DVec3,
    triangle: u32,
    outside: Interior,
    /// What leaves here per area, and the density with which it is found, for each wavelength.
    share: Lanes,
    density: Lanes,
    /// One over the other.
    weight: f64,
}

impl Path<'_> {
    /// Whether a body is entered in which light diffuses.
    pub(super) fn diffusing(&self, next: &Interior, beyond: &MediumLanes) -> Option<Entry> {
        let top = |interior: &Interior| interior.top(|b| self.scene.priority(b));
        let body = top(next)?;
        let below = self.scene.dipoles(body, top(&self.interior), &self.wavelengths)?;
        Some(Entry { body, inside: *beyond, below })
    }

    /// From the entry to where light leaves, and out there. False if it does not get there.
    pub(super) fn emerge(&mut self, entry: &Entry, facet: DVec3) -> bool {
        let scale = self.medium.n_geometry;
        let Some(mut exit) = self.exit(entry, facet) else { return false };
        // Of what passes from outside, the same share as of what left at the entry: both are diffuse inside.
        let outside = self.medium_of(&exit.outside);
        let relative: Lanes =
            std::array::from_fn(|k| (outside.n_geometry[k] / scale[k]).powi(2) / entry.below.entering[k]);
        (0..LANES).for_each(|k| exit.share[k] *= relative[k]);
        self.throughput.jump(&exit.share, &exit.density);
        (self.ray.origin, self.exclude, self.in_a_row) = (exit.place, exit.triangle, 0);
        self.enter(exit.outside, outside);
        let (normal, inside) = (exit.normal, entry.inside);
        if outside.n_geometry[0] > inside.n_geometry[0] && !self.interior.is_empty() {
            return self.refracted_out(normal, &inside, &outside);
        }
        self.ray.direction = self.lit(normal, |direction| {
            let interface = Interface::new(-direction, (normal, normal), &outside, &inside);
            interface.reflectance.map(|r| 1.0 - r)
        });
        true
    }

    /// Into a denser medium: drawn inside and refracted, as from outside many directions see no light from below.
    fn refracted_out(&mut self, normal: DVec3, inside: &MediumLanes, outside: &MediumLanes) -> bool {
        let (direction, _) = cosine_hemisphere(normal, self.sampler.pair());
        let interface = Interface::new(direction, (normal, normal), inside, outside);
        let Some(direction) = interface.refracted() else { return false };
        self.throughput.absorb(&std::array::from_fn(|k| {
            (1.0 - interface.reflectance[k]) * (inside.n_geometry[k] / outside.n_geometry[k]).powi(2)
        }));
        (self.ray.direction, self.view) = (direction, None);
        true
    }

    fn exit(&mut self, entry: &Entry, normal: DVec3) -> Option<Exit> {
        let hero = &entry.below.dipoles[0];
        if hero.total() <= 0.0 {
            return None;
        }
        let (u, v) = normal.any_orthonormal_pair();
        let axes = [normal, u, v];
        let r = hero.sample(self.sampler.pair());
        let choice = self.sampler.uniform();
        let axis = usize::from(choice >= CHANCES[0]) + usize::from(choice >= CHANCES[0] + CHANCES[1]);
        let turn = (self.sampler.uniform() * 4_294_967_296.0) as u32;
        let (cosine, sine) = Turn::get().angle(turn);
        let aside = axes[(axis + 1) % 3] * cosine + axes[(axis + 2) % 3] * sine;
        let mut exits = self.along(entry, axes, self.ray.origin + aside * r, axes[axis]);
        let sum: f64 = exits.iter().map(|exit| exit.weight).sum();
        let mut left = self.sampler.uniform() * sum;
        let chosen = exits.iter().position(|exit| {
            left -= exit.weight;
            left < 0.0
        });
        let mut exit = exits.swap_remove(chosen.or_else(|| exits.len().checked_sub(1))?);
        let chance = exit.weight / sum;
        exit.density.iter_mut().for_each(|density| *density *= chance);
        (exit.density[0] > 0.0).then_some(exit)
    }

    /// All points of the body's surface on a line, from outside the scene through `through` along `-axis`.
    fn along(&mut self, entry: &Entry, axes: [DVec3; 3], through: DVec3, axis: DVec3) -> Vec<Exit> {
        let (low, high) = self.scene.accelerator().bounds();
        let reach = (high - low).length() + (through - self.ray.origin).length();
        let mut ray = Ray { origin: through + axis * reach, direction: -axis };
        let (mut exclude, mut interior) = (Accelerator::NONE, Interior::default());
        let mut found = Vec::new();
        for _ in 0..MOST_MET {
            let Some(hit) = self.scene.accelerator().intersect(&ray, f64::INFINITY, exclude) else { break };
            (ray.origin, exclude) = (ray.at(hit.t), hit.triangle);
            let Owner::Body(body) = self.scene.owner(hit.owner) else { continue };
            let facet = self.scene.accelerator().normals(&hit).0;
            let entering = ray.direction.dot(facet) < 0.0;
            match interior.cross(body, entering, |b| self.scene.priority(b)) {
                Crossing::Inconsistent => self.statistics.inconsistencies += 1,
                Crossing::Hidden(next) => interior = next,
                Crossing::Interface(next) => {
                    let is_within = |place: &Interior| place.top(|b| self.scene.priority(b)) == Some(entry.body);
                    let (before, after) = (is_within(&interior), is_within(&next));
                    if before != after {
                        let outside = if before { next } else { interior };
                        // Into the body the ray runs against its normal.
                        let sign = if before { 1.0 } else { -1.0 };
                        let normal = facet * (sign * ray.direction.dot(facet).signum());
                        let place = (ray.origin, normal, hit.triangle);
                        found.extend(weighed(entry, axes, self.ray.origin, place, outside));
                    }
                    interior = next;
                }
            }
        }
        found
    }
}

/// A point with what leaves there and how likely it is found; `None` where nothing does.
fn weighed(
    entry: &Entry,
    axes: [DVec3; 3],
    from: DVec3,
    (place, normal, triangle): (DVec3, DVec3, u32),
    outside: Interior,
) -> Option<Exit> {
    let apart = place - from;
    let d = apart.length();
    let reached = axes.map(|axis| (apart.reject_from_normalized(axis).length(), axis.dot(normal).abs()));
    let share: Lanes = std::array::from_fn(|k| entry.below.scales[k] * entry.below.dipoles[k].reflectance(d));
    let density: Lanes = std::array::from_fn(|k| {
        let dipole = &entry.below.dipoles[k];
        let total = dipole.total();
        if total <= 0.0 {
            return 0.0;
        }
        let sum: f64 =
            reached.iter().zip(CHANCES).map(|((r, cosine), chance)| chance * cosine * dipole.reflectance(*r)).sum();
        sum / total
    });
    let (shares, densities) = (share.iter().sum::<f64>(), density.iter().sum::<f64>());
    let weight = if densities > 0.0 { shares / densities } else { 0.0 };
    (weight > 0.0 && weight.is_finite()).then_some(Exit { place, normal, triangle, outside, share, density, weight })
}
