//! One triangle in double precision: where a ray meets it, how far a point is from it.

use glam::DVec3;

use super::Ray;

/// A corner and the two edges from it. The corners are exact `f32` numbers, so nothing is lost in `f64`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Triangle {
    corner: DVec3,
    edge1: DVec3,
    edge2: DVec3,
}

impl Triangle {
    pub(crate) fn new([a, b, c]: [DVec3; 3]) -> Self {
        Self { corner: a, edge1: b - a, edge2: c - a }
    }

    /// Normal towards the side from which the corners run counter-clockwise; its length is twice the area.
    pub(crate) fn normal(&self) -> DVec3 {
        self.edge1.cross(self.edge2)
    }

    /// Distance along the ray and the weights of the second and third corners (`moller1997`); only `t > 0` counts.
    #[inline]
    pub(crate) fn intersect(&self, ray: &Ray) -> Option<(f64, [f64; 2])> {
        let across = ray.direction.cross(self.edge2);
        let determinant = self.edge1.dot(across);
        let from = ray.origin - self.corner;
        let u = from.dot(across);
        let q = from.cross(self.edge1);
        let v = ray.direction.dot(q);
        let t = self.edge2.dot(q);
        // All compared before the division; a determinant of 0 (ray in the plane) fails the test on t.
        let inside = if determinant > 0.0 {
            u >= 0.0 && v >= 0.0 && u + v <= determinant && t > 0.0
        } else {
            u <= 0.0 && v <= 0.0 && u + v >= determinant && t < 0.0
        };
        if !inside {
            return None;
        }
        let inverse = 1.0 / determinant;
        let distance = t * inverse;
        distance.is_finite().then_some((distance, [u * inverse, v * inverse]))
    }

    /// Squared distance from a point to the nearest point of the triangle (`ericson2004`, section 5.1.5).
    pub(crate) fn distance_squared(&self, point: DVec3) -> f64 {
        let (e1, e2) = (self.edge1, self.edge2);
        let p = point - self.corner;
        let (d1, d2) = (e1.dot(p), e2.dot(p));
        if d1 <= 0.0 && d2 <= 0.0 {
            return p.length_squared();
        }
        let pb = p - e1;
        let (d3, d4) = (e1.dot(pb), e2.dot(pb));
        if d3 >= 0.0 && d4 <= d3 {
            return pb.length_squared();
        }
        let vc = d1 * d4 - d3 * d2;
        if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            return (p - e1 * (d1 / (d1 - d3))).length_squared();
        }
        let pc = p - e2;
        let (d5, d6) = (e1.dot(pc), e2.dot(pc));
        if d6 >= 0.0 && d5 <= d6 {
            return pc.length_squared();
        }
        let vb = d5 * d2 - d1 * d6;
        if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            return (p - e2 * (d2 / (d2 - d6))).length_squared();
        }
        let va = d3 * d6 - d5 * d4;
        if va <= 0.0 && d4 >= d3 && d5 >= d6 {
            let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
            return (pb - (e2 - e1) * w).length_squared();
        }
        let normal = self.normal();
        p.dot(normal).powi(2) / normal.length_squared()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;
    use proptest::prelude::*;

    fn unit() -> Triangle {
        Triangle::new([DVec3::ZERO, DVec3::X, DVec3::Y])
    }

    #[test]
    fn rays_meet_it_from_both_sides_and_only_ahead() {
        let down = Ray { origin: dvec3(0.2, 0.3, 2.0), direction: -DVec3::Z };
        let (t, [u, v]) = unit().intersect(&down).unwrap();
        assert!((t - 2.0).abs() < 1e-15 && (u - 0.2).abs() < 1e-15 && (v - 0.3).abs() < 1e-15);
        let up = Ray { origin: dvec3(0.2, 0.3, -2.0), direction: DVec3::Z };
        assert!((unit().intersect(&up).unwrap().0 - 2.0).abs() < 1e-15);
        assert!(unit().intersect(&Ray { direction: DVec3::Z, ..down }).is_none());
        assert!(unit().intersect(&Ray { origin: dvec3(0.6, 0.6, 1.0), ..down }).is_none());
        assert!(unit().intersect(&Ray { origin: dvec3(-1.0, 0.1, 0.0), direction: DVec3::X }).is_none());
    }

    proptest! {
        #[test]
        fn no_sampled_point_is_nearer_than_the_distance(
            corners in prop::array::uniform3(prop::array::uniform3(-1.0..1.0f64)),
            point in prop::array::uniform3(-2.0..2.0f64),
        ) {
            let [a, b, c] = corners.map(DVec3::from_array);
            let triangle = Triangle::new([a, b, c]);
            prop_assume!(triangle.normal().length() > 1e-3);
            let p = DVec3::from_array(point);
            let claimed = triangle.distance_squared(p).sqrt();
            let mut sampled = f64::INFINITY;
            for i in 0..=100 {
                for j in 0..=(100 - i) {
                    let (u, v) = (f64::from(i) / 100.0, f64::from(j) / 100.0);
                    sampled = sampled.min((a + (b - a) * u + (c - a) * v - p).length());
                }
            }
            prop_assert!(claimed <= sampled + 1e-9);
            prop_assert!(claimed >= sampled - 0.08);
        }
    }
}
