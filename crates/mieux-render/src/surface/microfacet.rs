//! Rough surfaces as mirrors too small to be seen: the distribution of Trowbridge and Reitz (GGX), isotropic, with
//! uncorrelated heights (`walter2007`), sampled by what is visible (`heitz2018`).

use std::f64::consts::{PI, TAU};

use glam::DVec3;

/// Roughness of a surface: `alpha` of the distribution, the slope at which its profile has fallen to a quarter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Microfacets {
    alpha: f64,
}

impl Microfacets {
    /// Smoother than this counts as smooth.
    pub const SMOOTHEST: f64 = 1e-3;

    /// `alpha` between [`Self::SMOOTHEST`] and 1; `None` for a smooth surface.
    pub fn new(alpha: f64) -> Option<Self> {
        (alpha >= Self::SMOOTHEST).then_some(Self { alpha: alpha.min(1.0) })
    }

    /// Density of facet normals per solid angle and area, for the cosine between a facet's normal and the surface's.
    pub fn distribution(&self, cosine: f64) -> f64 {
        if cosine <= 0.0 {
            return 0.0;
        }
        let a2 = self.alpha * self.alpha;
        let base = 1.0 + cosine * cosine * (a2 - 1.0);
        a2 / (PI * base * base)
    }

    /// Share of facets seen from a direction of that cosine to the surface's normal that are not hidden by others.
    pub fn shadowing(&self, cosine: f64) -> f64 {
        let c2 = (cosine * cosine).clamp(1e-300, 1.0);
        let tan2 = (1.0 - c2) / c2;
        2.0 / (1.0 + (1.0 + self.alpha * self.alpha * tan2).sqrt())
    }

    /// Density of [`Self::sample`] per solid angle of facet normals; `view` and `facet` on the side of `normal`.
    pub fn density(&self, normal: DVec3, view: DVec3, facet: DVec3) -> f64 {
        let cosine = view.dot(normal).abs().max(1e-12);
        self.shadowing(cosine) * view.dot(facet).max(0.0) * self.distribution(facet.dot(normal)) / cosine
    }

    /// A facet normal seen from `view` (a unit vector away from the surface, on the side of `normal`).
    pub fn sample(&self, normal: DVec3, view: DVec3, [u, v]: [f64; 2]) -> DVec3 {
        let (a, b) = normal.any_orthonormal_pair();
        let local = DVec3::new(view.dot(a), view.dot(b), view.dot(normal).max(1e-9));
        let stretched = DVec3::new(self.alpha * local.x, self.alpha * local.y, local.z).normalize();
        let flat = stretched.x * stretched.x + stretched.y * stretched.y;
        let t1 = if flat > 0.0 { DVec3::new(-stretched.y, stretched.x, 0.0) / flat.sqrt() } else { DVec3::X };
        let t2 = stretched.cross(t1);
        let (sin, cos) = (TAU * v).sin_cos();
        let radius = u.sqrt();
        let (p1, mut p2) = (radius * cos, radius * sin);
        let share = 0.5 * (1.0 + stretched.z);
        p2 = (1.0 - share) * (1.0 - p1 * p1).max(0.0).sqrt() + share * p2;
        let height = (1.0 - p1 * p1 - p2 * p2).max(0.0).sqrt();
        let m = t1 * p1 + t2 * p2 + stretched * height;
        let m = DVec3::new(self.alpha * m.x, self.alpha * m.y, m.z.max(1e-9)).normalize();
        (a * m.x + b * m.y + normal * m.z).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seen facets, projected on the view, cover exactly what the surface shows; and samples follow the density.
    #[test]
    fn visible_facets_are_normalised_and_sampled_as_said() {
        let normal = DVec3::new(0.3, -0.2, 0.9).normalize();
        for alpha in [0.05, 0.3, 1.0] {
            let facets = Microfacets::new(alpha).unwrap();
            for tilt in [0.1f64, 0.8, 1.4] {
                let view = (normal * tilt.cos() + normal.any_orthonormal_vector() * tilt.sin()).normalize();
                // The mean of any function over samples equals its integral over the density: here of the cosine squared.
                let n = 500;
                let (mut mean, mut integral, mut total) = (0.0, 0.0, 0.0);
                for i in 0..n {
                    for j in 0..n {
                        let xi = [(f64::from(i) + 0.5) / f64::from(n), (f64::from(j) + 0.5) / f64::from(n)];
                        mean += facets.sample(normal, view, xi).dot(normal).powi(2) / f64::from(n * n);
                        // Facets by the tangent of their angle, which spreads them evenly; more of the steepest.
                        let left = (1.0 - xi[0]).powi(2);
                        let tan2 = alpha * alpha * (1.0 - left) / left;
                        let cosine = 1.0 / (1.0 + tan2).sqrt();
                        let (a, b) = normal.any_orthonormal_pair();
                        let (sin, cos) = (TAU * xi[1]).sin_cos();
                        let facet = normal * cosine + (a * cos + b * sin) * (1.0 - cosine * cosine).sqrt();
                        let drawn = facets.distribution(cosine) * cosine;
                        let weight =
                            facets.density(normal, view, facet) / drawn / f64::from(n * n) * 2.0 * (1.0 - xi[0]);
                        total += weight;
                        integral += weight * cosine * cosine;
                    }
                }
                assert!((total - 1.0).abs() < 5e-3, "{alpha} {tilt} {total}");
                assert!((mean - integral).abs() < 5e-3, "{alpha} {tilt} {mean} {integral}");
            }
        }
        assert!(Microfacets::new(0.0).is_none());
    }
}
