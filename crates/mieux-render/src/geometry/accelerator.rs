//! Finds the triangle a ray meets and the distance to the nearest one.

use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use obvhs::ray::RayHit;

use super::{Mesh, Ray, mesh::Ball, triangle::Triangle};

/// Where a ray meets a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Distance along the ray, m.
    pub t: f64,
    /// Which triangle, in the accelerator's own numbering; pass it as `exclude` to leave the surface.
    pub triangle: u32,
    /// Which of the meshes given to [`Accelerator::new`].
    pub owner: u32,
    /// Of the second and third corners of a triangle, or the normal of a sphere.
    weights: [f64; 3],
}

/// All triangles of a scene in a bounding volume hierarchy.
///
/// Boxes are `f32` and padded; triangles are tested in `f64`, so that steps of micrometres in a scene of decimetres
/// stay exact. A ray never meets the triangle it leaves (`exclude`); beyond that every `t > 0` counts.
pub struct Accelerator {
    bvh: Bvh2,
    triangles: Vec<Triangle>,
    owners: Vec<u32>,
    /// Corner normals, or none where the facet's own serves.
    normals: Vec<Option<[[f32; 3]; 3]>>,
    /// Spheres and their owners; in hits they come after the triangles. They are few: all are tried.
    balls: Vec<(Ball, u32)>,
    bounds: (DVec3, DVec3),
}

impl Accelerator {
    /// No triangle is left out when this is passed as `exclude`.
    pub const NONE: u32 = u32::MAX;

    /// Spheres that are tried one by one; further ones are their triangles.
    const MOST_BALLS: usize = 16;

    /// A distance found while descending may be this much too short.
    const SLACK: f32 = 0.7;

    /// Sorts the triangles of all meshes; the position of a mesh becomes the `owner` of its hits.
    pub fn new<'a>(meshes: impl IntoIterator<Item = &'a Mesh>) -> Self {
        let (mut triangles, mut owners, mut normals, mut boxes) = (vec![], vec![], vec![], vec![]);
        let mut bounds = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let mut balls = vec![];
        for (owner, mesh) in meshes.into_iter().enumerate() {
            if let Some(ball) = mesh.ball().filter(|_| balls.len() < Self::MOST_BALLS) {
                bounds = (bounds.0.min(ball.centre - ball.radius), bounds.1.max(ball.centre + ball.radius));
                balls.push((ball, owner as u32));
                continue;
            }
            for (t, indices) in mesh.triangles().iter().enumerate() {
                let corners = mesh.corners(t);
                bounds = corners.iter().fold(bounds, |(low, high), &c| (low.min(c), high.max(c)));
                triangles.push(Triangle::new(corners));
                owners.push(owner as u32);
                normals.push(mesh.normals().map(|n| indices.map(|i| n[i as usize])));
                boxes.push(Aabb::from_points(&corners.map(|c| c.as_vec3a())));
            }
        }
        // Rounding of the f32 ray moves it by a few units in the last place of the largest coordinate.
        let pad = 1e-6 * bounds.0.abs().max(bounds.1.abs()).max_element() as f32;
        boxes.iter_mut().for_each(|b| {
            b.min -= Vec3A::splat(pad);
            b.max += Vec3A::splat(pad);
        });
        let bvh = build(&boxes);
        let order = |i: &u32| *i as usize;
        Self {
            triangles: bvh.primitive_indices.iter().map(|i| triangles[order(i)]).collect(),
            owners: bvh.primitive_indices.iter().map(|i| owners[order(i)]).collect(),
            normals: bvh.primitive_indices.iter().map(|i| normals[order(i)]).collect(),
            bvh,
            balls,
            bounds: (bounds.0 - f64::from(pad), bounds.1 + f64::from(pad)),
        }
    }

    /// Smallest and largest coordinates of all triangles, m, with a padding of a millionth.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.bounds
    }

    /// The nearest triangle met at `0 < t < t_max` (m), leaving out the triangle `exclude`.
    pub fn intersect(&self, ray: &Ray, t_max: f64, exclude: u32) -> Option<Hit> {
        let mut best = t_max;
        let mut round = None;
        for (i, (ball, owner)) in self.balls.iter().enumerate() {
            let index = (self.triangles.len() + i) as u32;
            if let Some(t) = ball.intersect(ray, index == exclude)
                && t > 0.0
                && t < best
            {
                best = t;
                round = Some((ball, index, *owner));
            }
        }
        let mut found = None;
        self.traverse(ray, best, |node, bound| {
            for k in node.first_index..node.first_index + node.prim_count {
                if k != exclude
                    && let Some((t, weights)) = self.triangles[k as usize].intersect(ray)
                    && t < best
                {
                    best = t;
                    found = Some((k, weights));
                    *bound = round_up(t);
                }
            }
            true
        });
        if let Some((k, [u, v])) = found {
            return Some(Hit { t: best, triangle: k, owner: self.owners[k as usize], weights: [u, v, 0.0] });
        }
        let (ball, index, owner) = round?;
        Some(Hit { t: best, triangle: index, owner, weights: ball.normal(ray.at(best)).to_array() })
    }

    /// Whether any triangle but `exclude` is met at `0 < t < t_max` (m).
    pub fn occluded(&self, ray: &Ray, t_max: f64, exclude: u32) -> bool {
        let round = |(i, (ball, _)): (usize, &(Ball, u32))| {
            let t = ball.intersect(ray, (self.triangles.len() + i) as u32 == exclude);
            t.is_some_and(|t| t > 0.0 && t < t_max)
        };
        if self.balls.iter().enumerate().any(round) {
            return true;
        }
        let mut met = false;
        self.traverse(ray, t_max, |node, _| {
            met = (node.first_index..node.first_index + node.prim_count)
                .any(|k| k != exclude && self.triangles[k as usize].intersect(ray).is_some_and(|(t, _)| t < t_max));
            !met
        });
        met
    }

    fn traverse(&self, ray: &Ray, t_max: f64, mut leaf: impl FnMut(&Bvh2Node, &mut f32) -> bool) {
        if self.triangles.is_empty() {
            return;
        }
        let narrow = obvhs::ray::Ray::new(ray.origin.as_vec3a(), ray.direction.as_vec3a(), 0.0, round_up(t_max));
        let visit = |node: &Bvh2Node, narrow: &mut obvhs::ray::Ray, _: &mut RayHit| leaf(node, &mut narrow.tmax);
        let mut nothing = RayHit::none();
        obvhs::fast_stack!(u32, (48, 96, 192), self.bvh.max_depth, stack, {
            self.bvh.ray_traverse_dynamic(&mut stack, narrow, &mut nothing, visit)
        });
    }

    /// Unit normal of the facet and of the smooth surface it stands for, both outward.
    pub fn normals(&self, hit: &Hit) -> (DVec3, DVec3) {
        if hit.triangle as usize >= self.triangles.len() {
            let normal = DVec3::from_array(hit.weights);
            return (normal, normal);
        }
        let facet = self.triangles[hit.triangle as usize].normal().normalize();
        let Some(corners) = self.normals[hit.triangle as usize] else { return (facet, facet) };
        let [a, b, c] = corners.map(|n| glam::Vec3::from_array(n).as_dvec3());
        let [u, v, _] = hit.weights;
        let smooth = a * (1.0 - u - v) + b * u + c * v;
        (facet, smooth.try_normalize().unwrap_or(facet))
    }

    /// A distance (m) within which no triangle lies; at least 70 % of the true distance, less a padding of a
    /// millionth of the scene's largest coordinate. Infinite without triangles.
    pub fn distance_lower_bound(&self, point: DVec3) -> f64 {
        self.clearance(point, 0.0, f64::INFINITY)
    }

    /// As [`Self::distance_lower_bound`], but 0 once a triangle is known to be nearer than `useful`, and never much
    /// above `enough`: both spare a search.
    pub(crate) fn clearance(&self, point: DVec3, useful: f64, enough: f64) -> f64 {
        let round = self.balls.iter().fold(f64::INFINITY, |d, (ball, _)| d.min(ball.clearance(point)));
        let nodes = &self.bvh.nodes;
        if nodes.is_empty() || round < useful {
            return if round < useful { 0.0 } else { round };
        }
        let at = point.as_vec3a();
        let useful = (useful * useful) as f32;
        let (mut nearest, mut skipped) = (((enough * enough) as f32), f32::INFINITY);
        let mut stack = [(0u32, 0.0f32); 64];
        let mut depth = 1;
        stack[0] = (0, box_distance_squared(&nodes[0], at));
        while depth > 0 {
            depth -= 1;
            let (index, gap) = stack[depth];
            if gap >= nearest * (Self::SLACK * Self::SLACK) {
                skipped = skipped.min(gap);
                continue;
            }
            let node = &nodes[index as usize];
            if node.prim_count > 0 {
                let leaf = node.first_index as usize..(node.first_index + node.prim_count) as usize;
                nearest = self.triangles[leaf].iter().fold(nearest, |d, t| d.min(t.distance_squared(point) as f32));
                if nearest < useful {
                    return 0.0;
                }
                continue;
            }
            if depth + 2 > stack.len() {
                // Deeper than any real tree: the box itself is a valid bound.
                skipped = skipped.min(gap);
                continue;
            }
            let (a, b) = (node.first_index, node.first_index + 1);
            let near = (a, box_distance_squared(&nodes[a as usize], at));
            let far = (b, box_distance_squared(&nodes[b as usize], at));
            let (near, far) = if near.1 <= far.1 { (near, far) } else { (far, near) };
            stack[depth] = far;
            stack[depth + 1] = near;
            depth += 2;
        }
        // A millionth covers the rounding of squares and roots to f32; the boxes' padding covers the point's.
        round.min(f64::from(nearest.min(skipped).sqrt()) * (1.0 - 1e-6))
    }
}

fn build(boxes: &[Aabb]) -> Bvh2 {
    let mut bvh = PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::Medium,
        boxes,
        (0..boxes.len() as u32).collect(),
        SortPrecision::U64,
        3,
    );
    let mut optimizer = ReinsertionOptimizer::default();
    optimizer.run(&mut bvh, 0.05, None);
    collapse(&mut bvh, 4, 3.0);
    optimizer.run(&mut bvh, 0.1, None);
    bvh
}

#[inline]
fn box_distance_squared(node: &Bvh2Node, point: Vec3A) -> f32 {
    let gap = (node.aabb.min - point).max(point - node.aabb.max).max(Vec3A::ZERO);
    gap.dot(gap)
}

/// An `f32` no smaller than a non-negative `t`, with room for the rounding of box distances.
fn round_up(t: f64) -> f32 {
    (t * (1.0 + 1e-6)) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{DrinkingGlass, cuboid, sphere};
    use proptest::prelude::*;

    fn scene() -> Vec<Mesh> {
        let glass = DrinkingGlass::default();
        vec![
            glass.glass().unwrap(),
            glass.liquid(0.08).unwrap(),
            sphere([0.06, 0.02, 0.03], 0.02, 12).unwrap().faceted(),
            cuboid([-0.3, -0.3, -0.02], [0.3, 0.3, -0.01]).unwrap(),
        ]
    }

    fn direction(v: [f64; 3]) -> Option<DVec3> {
        DVec3::from_array(v).try_normalize()
    }

    #[test]
    fn nothing_is_far_away() {
        let none = Accelerator::new([]);
        assert_eq!(none.distance_lower_bound(DVec3::ZERO), f64::INFINITY);
        let ray = Ray { origin: DVec3::ZERO, direction: DVec3::X };
        assert!(none.intersect(&ray, f64::INFINITY, Accelerator::NONE).is_none());
    }

    #[test]
    fn finds_what_brute_force_finds() {
        let accelerator = Accelerator::new(&scene());
        let points = prop::array::uniform3(-0.15..0.15f64);
        let directions = prop::array::uniform3(-1.0..1.0f64);
        proptest!(|(origin in points, towards in directions, t_max in prop::sample::select(vec![2e-5, 1e-2, f64::INFINITY]))| {
            let Some(direction) = direction(towards) else { return Ok(()) };
            let ray = Ray { origin: DVec3::from_array(origin), direction };
            let brute = accelerator.triangles.iter().filter_map(|t| t.intersect(&ray)).map(|(t, _)| t)
                .filter(|&t| t < t_max).fold(f64::INFINITY, f64::min);
            let found = accelerator.intersect(&ray, t_max, Accelerator::NONE).map_or(f64::INFINITY, |h| h.t);
            prop_assert_eq!(brute, found);
            prop_assert_eq!(brute.is_finite(), accelerator.occluded(&ray, t_max, Accelerator::NONE));
            if let Some(hit) = accelerator.intersect(&ray, t_max, Accelerator::NONE) {
                let next = accelerator.intersect(&ray, t_max, hit.triangle).map_or(f64::INFINITY, |h| h.t);
                prop_assert!(next >= hit.t);
                let (facet, smooth) = accelerator.normals(&hit);
                prop_assert!(facet.dot(smooth) > 0.5);
            }
        });
    }

    #[test]
    fn the_bound_is_below_the_distance_and_not_far_below() {
        let accelerator = Accelerator::new(&scene());
        let pad = 1e-6 * 0.3;
        proptest!(|(point in prop::array::uniform3(-0.15..0.15f64))| {
            let point = DVec3::from_array(point);
            let brute = accelerator.triangles.iter().map(|t| t.distance_squared(point))
                .fold(f64::INFINITY, f64::min).sqrt();
            let bound = accelerator.distance_lower_bound(point);
            prop_assert!(bound <= brute, "{} {}", bound, brute);
            prop_assert!(bound >= 0.69 * brute - 2.0 * pad, "{} {}", bound, brute);
        });
    }
}
