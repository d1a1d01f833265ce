//! Matter spread by grids: tracking with null collisions against the most that each block of the grid holds (`woodcock1965`,
//! `novak2018`), at all wavelengths of a path at once (`miller2019`).

use super::fog::MOST_COLLISIONS;
use super::path::Path;
use super::throughput::Shadow;
use super::{LANES, Lanes};
use crate::geometry::{Hit, Ray};
use crate::medium::{MOST_PARTS, Matter};
use crate::sampler::PixelSampler;

/// Rays towards lights are ended by chance below this share.
const DIM: f64 = 0.05;

/// A real collision on the way.
struct Collision {
    at: f64,
    densities: [f64; MOST_PARTS],
}

impl Path<'_> {
    /// From collision to collision up to the next surface, if it gets there.
    pub(super) fn cloud(&mut self) -> Option<Hit> {
        let matter = self.matter?;
        for _ in 0..MOST_COLLISIONS {
            let hit = self.scene.accelerator().intersect(&self.ray, f64::INFINITY, self.exclude);
            let Some(hit) = hit else { break };
            let Some(collision) = self.track(&matter, hit.t) else { return Some(hit) };
            let sums = matter.sums(&collision.densities);
            self.ray.origin = self.ray.at(collision.at);
            self.exclude = Self::ANYWHERE;
            if self.looking {
                let forward = self.ray.direction;
                let start = self.interior;
                let xi = self.sampler.pair();
                // The share of scattered light and the density are the same but for the albedo.
                self.look(1, self.scene.lights().peaked(), xi, |direction| {
                    let values = matter.scattering(&collision.densities, forward.dot(direction));
                    let of = |by: &Lanes| std::array::from_fn(|k| if by[k] > 0.0 { values[k] / by[k] } else { 0.0 });
                    Some((of(&sums.sigma_t), of(&sums.sigma_s), start))
                });
            } else {
                self.throughput.forget();
                self.view = None;
            }
            self.collide(&matter, &collision.densities, &sums)?;
        }
        self.statistics.lost += 1;
        None
    }

    /// The next real collision within a length (m), if there is one.
    fn track(&mut self, matter: &Matter<'_>, length: f64) -> Option<Collision> {
        let mut found = None;
        let throughput = &mut self.throughput;
        events(matter, &self.ray, length, self.sampler, |event, sampler| {
            let Event { left, collision } = event;
            let Some(Tentative { at, densities, real, majorant }) = collision else {
                throughput.pass(&left, &left);
                return true;
            };
            if sampler.uniform() * majorant[0] < real[0] {
                throughput.pass(&std::array::from_fn(|k| left[k] * real[k]), &left);
                found = Some(Collision { at, densities });
                return false;
            }
            let null: Lanes = std::array::from_fn(|k| left[k] * (majorant[k] - real[k]).max(0.0));
            throughput.pass(&null, &std::array::from_fn(|k| left[k] * majorant[k]));
            true
        });
        found
    }

    /// Dims a ray towards a light by ratio tracking. False if nothing is left.
    pub(super) fn dims_by_grid(&mut self, shadow: &mut Shadow, ray: &Ray, length: f64, matter: &Matter<'_>) -> bool {
        let bright: f64 = shadow.f.iter().sum();
        let mut goes_on = true;
        events(matter, ray, length, self.sampler, |event, sampler| {
            let Event { left, collision } = event;
            let Some(Tentative { real, majorant, .. }) = collision else {
                shadow.track(&left, &left);
                return true;
            };
            let seen: Lanes = std::array::from_fn(|k| left[k] * (majorant[k] - real[k]).max(0.0));
            shadow.track(&seen, &std::array::from_fn(|k| left[k] * majorant[k]));
            let now: f64 = shadow.f.iter().sum();
            if now >= DIM * bright {
                return true;
            }
            let chance = now / (DIM * bright);
            goes_on = sampler.uniform() < chance;
            (0..LANES).for_each(|k| shadow.f[k] /= chance);
            goes_on
        });
        goes_on && shadow.f.iter().any(|f| *f > 0.0)
    }
}

/// A piece of the way on which the majorant is constant, and what ends it.
struct Event {
    /// Share that the majorant lets through the piece.
    left: Lanes,
    /// A collision that is real or null; `None` at the end of a block.
    collision: Option<Tentative>,
}

struct Tentative {
    at: f64,
    densities: [f64; MOST_PARTS],
    real: Lanes,
    majorant: Lanes,
}

/// All events along a ray up to a length (m), by the hero's majorants; ends early when `visit` says so.
fn events(
    matter: &Matter<'_>,
    ray: &Ray,
    length: f64,
    sampler: &mut PixelSampler,
    mut visit: impl FnMut(Event, &mut PixelSampler) -> bool,
) {
    let Some(grid) = matter.grid else { return };
    let (origin, direction) = grid.local_ray(ray);
    grid.blocks(ray, length, |start, end, block| {
        let most = block.map_or_else(|| matter.everywhere(), |block| matter.majorants(block));
        let majorant = matter.sums(&most).sigma_t;
        let mut at = start;
        loop {
            let step = if majorant[0] > 0.0 { -(1.0 - sampler.uniform()).ln() / majorant[0] } else { f64::INFINITY };
            if at + step >= end {
                let left = majorant.map(|m| (-m * (end - at)).exp());
                return visit(Event { left, collision: None }, sampler);
            }
            at += step;
            let densities = if block.is_some() { matter.densities(origin + direction * at) } else { most };
            let real = matter.sums(&densities).sigma_t;
            let left = majorant.map(|m| (-m * step).exp());
            let collision = Some(Tentative { at, densities, real, majorant });
            if !visit(Event { left, collision }, sampler) {
                return false;
            }
        }
    });
}
