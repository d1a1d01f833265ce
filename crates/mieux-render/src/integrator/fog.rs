//! Homogeneous matter that light comes into straight: fog. Every piece of the path through it looks for light at a place of
//! its own, drawn by the transmittance or by the angle under which a lamp sees it (`kulla2012`); what chance finds and what
//! looking finds are weighed against each other at every wavelength.

use super::direct::View;
use super::path::Path;
use super::throughput::{Throughput, WALK_ROULETTE};
use super::walk::scattered;
use super::{LANES, Lanes};
use crate::geometry::{Accelerator, Hit, Ray};
use crate::light::{Segment, Viewpoint};
use crate::medium::{MOST_PARTS, Matter};
use crate::sampler::Turn;

/// Longest way between two surfaces, in collisions.
pub(super) const MOST_COLLISIONS: u64 = 10_000_000;

impl Path<'_> {
    /// From collision to collision up to the next surface, if it gets there.
    pub(super) fn fog(&mut self) -> Option<Hit> {
        let matter = self.matter?;
        let densities = matter.everywhere();
        let sums = matter.sums(&densities);
        for _ in 0..MOST_COLLISIONS {
            let step = -(1.0 - self.sampler.uniform()).ln() / sums.sigma_t[0];
            let limit = if self.looking { f64::INFINITY } else { step };
            let hit = self.scene.accelerator().intersect(&self.ray, limit, self.exclude);
            let segment = Segment {
                origin: self.ray.origin,
                direction: self.ray.direction,
                length: hit.map_or(limit, |hit| hit.t),
                sigma_t: sums.sigma_t,
            };
            if !segment.length.is_finite() {
                break;
            }
            let before = self.throughput;
            if self.looking {
                self.look_along(&before, &segment, &matter, &densities, &sums.sigma_s);
            }
            if let Some(hit) = hit
                && hit.t <= step
            {
                let left = sums.sigma_t.map(|s| (-s * hit.t).exp());
                self.throughput.pass(&left, &[1.0; LANES]);
                return Some(hit);
            }
            let chance: Lanes = std::array::from_fn(|k| sums.sigma_t[k] * (-sums.sigma_t[k] * step).exp());
            self.throughput = before;
            if self.looking {
                self.throughput.mark();
                self.view = Some(View::segment(segment, step));
            } else {
                self.throughput.forget();
                self.view = None;
            }
            self.throughput.pass(&chance, &[1.0; LANES]);
            self.ray.origin = self.ray.at(step);
            self.collide(&matter, &densities, &sums)?;
        }
        self.statistics.lost += 1;
        None
    }

    /// What happens at a collision: light is sent out and absorbed, the rest scattered. `None` if the path ends.
    pub(super) fn collide(
        &mut self,
        matter: &Matter<'_>,
        densities: &[f64; MOST_PARTS],
        sums: &crate::medium::Sums,
    ) -> Option<()> {
        self.statistics.collisions += 1;
        (self.exclude, self.in_a_row) = (Accelerator::NONE, 0);
        let share = |of: &Lanes| std::array::from_fn(|k| if of[k] > 0.0 { of[k] / sums.sigma_t[k] } else { 0.0 });
        if matter.shines {
            let added = self.throughput.estimate(&share(&sums.emitted));
            (0..LANES).for_each(|k| self.radiance[k] += added[k]);
        }
        if sums.sigma_s[0] <= 0.0 {
            return None;
        }
        self.throughput.absorb(&share(&sums.sigma_s));
        let mu = matter.sample(densities, self.sampler.uniform());
        let turn = (self.sampler.uniform() * 4_294_967_296.0) as u32;
        let values = matter.scattering(densities, mu);
        let chance: Lanes =
            std::array::from_fn(|k| if sums.sigma_s[k] > 0.0 { values[k] / sums.sigma_s[k] } else { 0.0 });
        if chance[0] <= 0.0 {
            return None;
        }
        self.throughput.choose(&chance);
        self.ray.direction = scattered(self.ray.direction, mu, Turn::get().angle(turn)).normalize();
        self.throughput.survives(WALK_ROULETTE, || self.sampler.uniform()).then_some(())
    }

    fn look_along(
        &mut self,
        before: &Throughput,
        segment: &Segment,
        matter: &Matter<'_>,
        densities: &[f64; MOST_PARTS],
        sigma_s: &Lanes,
    ) {
        let (lights, from) = (self.scene.lights(), Viewpoint::Segment(*segment));
        let choice = if lights.has_places() { self.sampler.uniform() } else { 0.0 };
        let Some((light, chance)) = lights.choose(&from, choice) else { return };
        let t = lights.place_along(light, segment, self.sampler.pair());
        let place = segment.origin + segment.direction * t;
        let Some(sample) = lights.sample(light, place, self.sampler.pair(), &self.wavelengths, &self.sky) else {
            return;
        };
        let values = matter.scattering(densities, segment.direction.dot(sample.direction));
        let left = segment.sigma_t.map(|s| (-s * t).exp());
        let by_chance = |k: usize| {
            if sample.point || sigma_s[k] <= 0.0 { 0.0 } else { left[k] * segment.sigma_t[k] * values[k] / sigma_s[k] }
        };
        let density = lights.density_along(light, segment, t);
        let shadow = before.towards(
            &std::array::from_fn(|k| left[k] * values[k] * sample.radiance[k]),
            &std::array::from_fn(by_chance),
            &density.map(|d| d * chance * sample.density),
        );
        let exclude = std::mem::replace(&mut self.exclude, Self::ANYWHERE);
        self.add(shadow, Ray { origin: place, direction: sample.direction }, sample.distance, self.interior);
        self.exclude = exclude;
    }
}
