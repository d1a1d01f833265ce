//! Diffuse surfaces.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

/// A direction about the unit `normal` with density `cos(theta) / pi` per solid angle, and that density, from two
/// uniform numbers in [0, 1).
pub fn cosine_hemisphere(normal: DVec3, [u, v]: [f64; 2]) -> (DVec3, f64) {
    let (sin_phi, cos_phi) = (TAU * v).sin_cos();
    let radius = u.sqrt();
    let cosine = (1.0 - u).max(0.0).sqrt();
    let (a, b) = normal.any_orthonormal_pair();
    let direction = (a * (radius * cos_phi) + b * (radius * sin_phi) + normal * cosine).normalize();
    (direction, cosine / PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_density_is_the_one_sampled() {
        let normal = DVec3::new(0.3, -0.5, 0.8).normalize();
        let n = 200;
        let mut mean = DVec3::ZERO;
        for i in 0..n {
            for j in 0..n {
                let xi = [(f64::from(i) + 0.5) / f64::from(n), (f64::from(j) + 0.5) / f64::from(n)];
                let (direction, density) = cosine_hemisphere(normal, xi);
                assert!((direction.dot(normal) / PI - density).abs() < 1e-12);
                mean += direction;
            }
        }
        // The mean of a cosine-weighted direction is 2/3 of the normal.
        assert!((mean / f64::from(n * n) - normal * 2.0 / 3.0).length() < 1e-4);
    }
}
