//! The rough surface of a body (`walter2007`): light is reflected or refracted once by a facet that is seen. What facets
//! would throw at each other is lost, a few per cent of the light where they are steep.

use glam::DVec3;

use super::Lanes;
use super::interface::Interface;
use super::path::Path;
use super::turbid::MediumLanes;
use crate::surface::{Interior, Microfacets};

/// A rough interface as one path meets it.
struct Rough<'a> {
    before: &'a MediumLanes,
    beyond: &'a MediumLanes,
    facets: Microfacets,
    /// Towards where the path comes from.
    view: DVec3,
    /// Of the smooth surface and of the triangle, on the side of `view`.
    normal: DVec3,
    triangle: DVec3,
}

impl Rough<'_> {
    /// The share of light from a direction that goes on along the path, and the density with which the path goes there.
    fn turned(&self, direction: DVec3) -> Option<(Lanes, Lanes)> {
        let out = direction.dot(self.normal);
        let reflected = out > 0.0;
        if out == 0.0 || (direction.dot(self.triangle) > 0.0) != reflected {
            return None;
        }
        let (a, b) = (self.before.n_geometry[0], self.beyond.n_geometry[0]);
        let half = if reflected { self.view + direction } else { self.view * a + direction * b };
        let half = half.try_normalize()?;
        let half = if half.dot(self.normal) < 0.0 { -half } else { half };
        let (seen, turned) = (self.view.dot(half), direction.dot(half));
        if seen <= 0.0 || (turned > 0.0) != reflected {
            return None;
        }
        let interface = Interface::new(-self.view, (half, half), self.before, self.beyond);
        let stretch = if reflected {
            0.25 / seen
        } else {
            let sum = a * seen + b * turned;
            turned.abs() * b * b / (sum * sum)
        };
        let density = self.facets.density(self.normal, self.view, half) * stretch;
        if !density.is_finite() {
            return None;
        }
        let chance: Lanes = std::array::from_fn(|k| {
            let r = interface.reflectance[k];
            let alike = reflected || interface.bends_alike(k);
            if alike { density * if reflected { r } else { 1.0 - r } } else { 0.0 }
        });
        let visible = self.facets.shadowing(out);
        Some((chance.map(|c| c * visible), chance))
    }
}

impl Path<'_> {
    /// Reflected or refracted at a rough surface between the present medium and `beyond`. False if the path ends.
    pub(super) fn rough(
        &mut self,
        (triangle, smooth): (DVec3, DVec3),
        next: Interior,
        beyond: &MediumLanes,
        facets: Microfacets,
    ) -> bool {
        let view = -self.ray.direction;
        let side = if view.dot(triangle) > 0.0 { 1.0 } else { -1.0 };
        let (triangle, smooth) = (triangle * side, smooth * side);
        let normal = if view.dot(smooth) > 0.0 { smooth } else { triangle };
        let before = self.medium;
        let rough = Rough { before: &before, beyond, facets, view, normal, triangle };
        self.in_a_row = 0;
        let (xi, for_light) = (self.sampler.pair(), self.sampler.pair());
        let lit = |interior: &Interior| self.scene.is_lit(interior.top(|b| self.scene.priority(b)));
        let (here, there) = (lit(&self.interior), lit(&next));
        if here || there {
            let start = self.interior;
            self.look(1, true, for_light, |direction| {
                let (share, density) = rough.turned(direction)?;
                let from = if direction.dot(normal) > 0.0 { start } else { next };
                Some((share, density, from))
            });
        } else {
            self.view = None;
            self.throughput.forget();
        }
        let half = facets.sample(normal, view, xi);
        let interface = Interface::new(self.ray.direction, (half, half), &before, beyond);
        let reflected = self.sampler.uniform() < interface.reflectance[0];
        let direction = if reflected { Some(interface.reflected()) } else { interface.refracted() };
        let Some(direction) = direction else { return false };
        let Some((share, chance)) = rough.turned(direction) else { return false };
        if chance[0] <= 0.0 || (direction.dot(normal) > 0.0) != reflected {
            return false;
        }
        self.throughput.choose(&chance);
        self.throughput.absorb(&std::array::from_fn(|k| if chance[k] > 0.0 { share[k] / chance[k] } else { 0.0 }));
        self.ray.direction = direction;
        if !reflected {
            self.enter(next, *beyond);
        }
        true
    }
}
