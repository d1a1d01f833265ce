//! Surfaces without an inside: diffuse, metal, thin pane; and those that shine.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::path::Path;
use super::{LANES, Lanes};
use crate::geometry::Hit;
use crate::scene::FinishLanes;
use crate::surface::{Microfacets, conductor_reflectance, cosine_hemisphere, dielectric_reflectance, reflect};

/// Directions towards the light sampled at a diffuse surface: cheap beside a walk through milk.
const LIGHTS: u32 = 4;

impl Path<'_> {
    /// A surface without an inside. False if the path ends.
    pub(super) fn meet(&mut self, hit: &Hit, surface: u16) -> bool {
        let (facet, smooth) = self.scene.accelerator().normals(hit);
        let cosine = self.ray.direction.dot(facet);
        let point = self.ray.at(hit.t);
        if let Some(emitter) = self.scene.emitter(surface)
            && cosine < 0.0
        {
            let light = self.scene.lights().emitted(emitter, &self.wavelengths);
            let looked = |view: super::direct::View| view.density_of_emitter(self.scene, emitter, point, cosine);
            let looked = self.view.map_or([0.0; LANES], looked);
            self.gather(&light, &looked);
        }
        (self.ray.origin, self.exclude) = (point, hit.triangle);
        let side = if cosine > 0.0 { -1.0 } else { 1.0 };
        match self.scene.finish(surface, &self.wavelengths) {
            FinishLanes::Diffuse { both_sides: false, .. } if cosine > 0.0 => false,
            FinishLanes::Diffuse { reflectance, .. } => self.diffuse(facet * side, &reflectance),
            FinishLanes::Conductor { n, k, facets } => self.metal(facet * side, smooth * side, &n, &k, facets),
            FinishLanes::ThinPane { n } => self.pane(smooth * side, &n),
        }
    }

    /// An opaque diffuse surface: looks for light, then goes on in a random direction. Only the facet's own normal counts
    /// here: with a smooth one in its place a white surface would lose a little light at every bend.
    fn diffuse(&mut self, normal: DVec3, reflectance: &Lanes) -> bool {
        if reflectance.iter().all(|r| *r == 0.0) {
            return false;
        }
        self.in_a_row = 0;
        self.throughput.absorb(reflectance);
        self.ray.direction = self.lit(normal, |_| [1.0; LANES]);
        true
    }

    /// At a point that sends light diffusely about `normal`, the given share of it: looks for light, and draws the direction
    /// in which the path goes on.
    pub(super) fn lit(&mut self, normal: DVec3, share: impl Fn(DVec3) -> Lanes) -> DVec3 {
        let (for_light, for_direction) = (self.sampler.pair(), self.sampler.pair());
        // From inside a body the light is mostly reached by refraction, which no straight line finds.
        let open = self.scene.is_lit(self.interior.top(|b| self.scene.priority(b)));
        if open {
            let start = self.interior;
            self.look(LIGHTS, true, for_light, |direction| {
                let cosine = direction.dot(normal);
                let density = cosine * FRAC_1_PI;
                (cosine > 0.0).then(|| (share(direction).map(|s| s * density), [density; LANES], start))
            });
        } else {
            self.throughput.forget();
            self.view = None;
        }
        let (direction, density) = cosine_hemisphere(normal, for_direction);
        self.throughput.choose(&[density; LANES]);
        self.throughput.absorb(&share(direction));
        direction
    }

    /// A metal, smooth or rough.
    fn metal(&mut self, facet: DVec3, smooth: DVec3, n: &Lanes, k: &Lanes, roughness: Option<Microfacets>) -> bool {
        let view = -self.ray.direction;
        let normal = if view.dot(smooth) > 0.0 { smooth } else { facet };
        let index = self.medium.n;
        let reflectance = |cosine: f64| -> Lanes {
            std::array::from_fn(|lane| conductor_reflectance(cosine, n[lane] / index[lane], k[lane] / index[lane]))
        };
        let Some(facets) = roughness else {
            self.view = None;
            self.throughput.forget();
            self.throughput.absorb(&reflectance(view.dot(normal)));
            let mirrored = reflect(self.ray.direction, normal);
            self.ray.direction = if mirrored.dot(facet) > 0.0 { mirrored } else { reflect(self.ray.direction, facet) };
            return true;
        };
        self.in_a_row = 0;
        let (xi, for_light) = (self.sampler.pair(), self.sampler.pair());
        if self.scene.is_lit(self.interior.top(|b| self.scene.priority(b))) {
            let start = self.interior;
            self.look(1, true, for_light, |direction| {
                let half = (view + direction).try_normalize()?;
                let (out, aside) = (direction.dot(normal), direction.dot(facet));
                if out <= 0.0 || aside <= 0.0 || view.dot(half) <= 0.0 {
                    return None;
                }
                let density = facets.density(normal, view, half) / (4.0 * view.dot(half));
                let share = reflectance(view.dot(half)).map(|r| r * density * facets.shadowing(out));
                Some((share, [density; LANES], start))
            });
        } else {
            self.view = None;
            self.throughput.forget();
        }
        let half = facets.sample(normal, view, xi);
        let direction = reflect(self.ray.direction, half);
        let density = facets.density(normal, view, half) / (4.0 * view.dot(half));
        let out = direction.dot(normal);
        if out <= 0.0 || direction.dot(facet) <= 0.0 || !(density > 0.0 && density.is_finite()) {
            return false;
        }
        self.throughput.choose(&[density; LANES]);
        self.throughput.absorb(&reflectance(view.dot(half)).map(|r| r * facets.shadowing(out)));
        self.ray.direction = direction;
        true
    }

    /// A thin pane: all reflections between its sides at once.
    fn pane(&mut self, normal: DVec3, n: &Lanes) -> bool {
        self.view = None;
        self.throughput.forget();
        let cosine = -self.ray.direction.dot(normal);
        let reflectance: Lanes = std::array::from_fn(|k| {
            let once = dielectric_reflectance(cosine.clamp(0.0, 1.0), n[k] / self.medium.n[k]);
            2.0 * once / (1.0 + once)
        });
        if self.sampler.uniform() < reflectance[0] {
            self.throughput.choose(&reflectance);
            self.ray.direction = reflect(self.ray.direction, normal);
        } else {
            self.throughput.choose(&reflectance.map(|r| 1.0 - r));
        }
        true
    }
}
