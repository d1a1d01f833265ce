//! Spheres as rays meet them: exactly.

use glam::DVec3;

use super::Ray;
use super::mesh::Ball;

impl Ball {
    /// Distance at which a ray meets the sphere; `leaving` for a ray that starts on it.
    #[inline]
    pub(super) fn intersect(&self, ray: &Ray, leaving: bool) -> Option<f64> {
        let from = ray.origin - self.centre;
        let along = from.dot(ray.direction);
        if leaving {
            // The far end of the chord: the near one is where the ray is.
            return (along < 0.0).then_some(-2.0 * along);
        }
        let aside = from - ray.direction * along;
        let squared = self.radius * self.radius - aside.length_squared();
        if squared < 0.0 {
            return None;
        }
        let half = squared.sqrt();
        let (near, far) = (-along - half, -along + half);
        if near > 0.0 { Some(near) } else { (far > 0.0).then_some(far) }
    }

    /// The outward normal at a point.
    pub(super) fn normal(&self, point: DVec3) -> DVec3 {
        (point - self.centre).normalize_or_zero()
    }

    /// Distance of a point from the surface, m, less what rounding may do.
    #[inline]
    pub(super) fn clearance(&self, point: DVec3) -> f64 {
        let from = (point - self.centre).length();
        ((from - self.radius).abs() - 1e-12 * (from + self.radius)).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn rays_meet_the_sphere_where_it_is() {
        let ball = Ball { centre: DVec3::new(0.3, -0.2, 0.1), radius: 0.7 };
        proptest!(|(origin in prop::array::uniform3(-2.0..2.0f64), towards in prop::array::uniform3(-1.0..1.0f64))| {
            let Some(direction) = DVec3::from_array(towards).try_normalize() else { return Ok(()) };
            let ray = Ray { origin: DVec3::from_array(origin), direction };
            if let Some(t) = ball.intersect(&ray, false) {
                let at = ray.at(t);
                prop_assert!(((at - ball.centre).length() - ball.radius).abs() < 1e-9);
                prop_assert!(t >= ball.clearance(ray.origin));
                // From there it leaves, or meets the other end of its chord.
                let next = ball.intersect(&Ray { origin: at, direction }, true);
                let inside = (ray.origin - ball.centre).length() < ball.radius;
                prop_assert_eq!(next.is_some_and(|t| t > 1e-6), !inside && ball.normal(at).dot(direction) < -1e-6);
            }
        });
    }
}
