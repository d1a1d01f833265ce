//! The directional dipole: the source is a ray, and points into the medium as the refracted light does.

use std::f64::consts::PI;

use super::radial::area_integral;
use super::source::{decay, farther, potential_between};
use super::{Boundary, DiffusionMedium};
use crate::transfer::fresnel::dielectric_reflectance;

/// Diffuse reflectance of a ray source after `frisvad2014`, and the BSSRDF made of it, which knows the directions and the
/// normals on both ends. It holds all scattering from the first on.
///
/// An expansion that is good far from the entry: at a distance of a few transport mean free paths and at a reduced albedo
/// near 1. Near it there is too much of it: without absorption its total is 1.20 at index 1.5 and 1.34 without a surface
/// ([`super::Profile::normalised`] only spreads that). It does not know that light which is not scattered does not come
/// back, and returns 0.1 and more at albedo 0.1; without scattering it is taken for 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionalDipole {
    sigma_t: f64,
    sigma_tr: f64,
    diffusion: f64,
    /// The length that keeps sources from the surface, `2.131 D / sqrt(alpha')`, m; infinite without scattering.
    offset: f64,
    /// Height of the mirror image, `2 A` times that, m.
    height: f64,
    c_phi: f64,
    c_e: f64,
    eta: f64,
    /// `4 C_phi(1 / eta)`: share of diffuse light from outside that enters.
    entering: f64,
    total: f64,
}

/// Where light enters or leaves: positions in m, unit vectors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePoint {
    /// On the surface, m.
    pub position: [f64; 3],
    /// Outward unit normal.
    pub normal: [f64; 3],
    /// Unit vector in the air, away from the surface: to where light comes from, or goes.
    pub direction: [f64; 3],
}

impl DirectionalDipole {
    /// Of a medium.
    pub fn new(medium: &DiffusionMedium) -> Self {
        let diffusion = medium.diffusion_coefficient();
        let surface = medium.surface();
        let offset = 2.131 * diffusion / medium.reduced_albedo().sqrt();
        let mut dipole = Self {
            sigma_t: medium.sigma_t(),
            sigma_tr: medium.transport_coefficient(diffusion),
            diffusion,
            offset,
            height: 2.0 * medium.boundary(Boundary::Exact) * offset,
            c_phi: 0.25 * (1.0 - 2.0 * surface.c1),
            c_e: 0.5 * (1.0 - 3.0 * surface.c2),
            eta: medium.relative_index(),
            entering: 1.0 - surface.external,
            total: 0.0,
        };
        dipole.total = area_integral(|r| dipole.reflectance(r), diffusion, dipole.sigma_tr);
        dipole
    }

    /// Power that leaves per area at the distance `r` (m, from 0 up) from where light of power 1 has entered a flat surface
    /// along the normal, 1/m^2.
    pub fn reflectance(&self, r: f64) -> f64 {
        if !self.offset.is_finite() || r.is_infinite() {
            return 0.0;
        }
        let (sigma, diffusion, h) = (self.sigma_tr, self.diffusion, self.height);
        // The distance of the ray source, corrected near it: cos(beta) = -r / sqrt(r^2 + d_e^2).
        let away = (diffusion * (diffusion + 2.0 * self.offset * r / r.hypot(self.offset))).sqrt();
        let (near, far) = (r.hypot(away), r.hypot(h));
        let (below, above) = (decay(sigma * near) / near.powi(3), decay(sigma * far) / far.powi(3));
        let fluence = potential_between(near, farther(r, away, h), sigma) / diffusion + 3.0 * h * above;
        let x = sigma * far;
        let bent = 3.0 * decay(x) + x * x * (-x).exp();
        let curved = 3.0 * diffusion * (h / far).powi(2) * if bent > 0.0 { bent / far.powi(3) } else { 0.0 };
        let flux = 3.0 * diffusion * (below + above) + h * above - curved;
        (self.c_phi * fluence + self.c_e * flux) / (4.0 * PI)
    }

    /// The integral of [`DirectionalDipole::reflectance`] over the surface, to 1e-10.
    pub fn total(&self) -> f64 {
        self.total
    }

    /// Radiance that leaves at `exit` into its direction, per power that falls in at `entry` from its direction, 1/(m^2 sr):
    /// Fresnel's shares on both ends included, the light that is not scattered left out. Never below 0, where the
    /// expansion is.
    pub fn bssrdf(&self, entry: &SurfacePoint, exit: &SurfacePoint) -> f64 {
        let [cos_i, cos_o] = [entry, exit].map(|end| dot(end.direction, end.normal));
        if !(cos_i > 0.0 && cos_o > 0.0 && self.offset.is_finite()) {
            return 0.0;
        }
        let Some(inside) = self.refracted(entry, cos_i) else { return 0.0 };
        let passes = |cosine: f64| 1.0 - dielectric_reflectance(cosine.min(1.0), self.eta);
        passes(cos_i) * self.diffusive(entry, inside, exit).max(0.0) * passes(cos_o)
    }

    /// The direction of the refracted light; `None` where none enters.
    fn refracted(&self, entry: &SurfacePoint, cosine: f64) -> Option<[f64; 3]> {
        let sine2 = (1.0 - cosine * cosine).max(0.0) / (self.eta * self.eta);
        let beyond = (sine2 < 1.0).then(|| (1.0 - sine2).sqrt())?;
        let along = cosine / self.eta - beyond;
        Some(std::array::from_fn(|k| -entry.direction[k] / self.eta + entry.normal[k] * along))
    }

    /// Between Fresnel's shares: the ray source less its mirror image.
    fn diffusive(&self, entry: &SurfacePoint, inside: [f64; 3], exit: &SurfacePoint) -> f64 {
        let apart: [f64; 3] = std::array::from_fn(|k| exit.position[k] - entry.position[k]);
        let (r2, mu) = (dot(apart, apart), -dot(exit.normal, inside));
        let corrected = if mu > 0.0 {
            let along = dot(apart, inside);
            let squared = r2 + self.offset * self.offset;
            let cosine = -((r2 - along * along).max(0.0) / squared).sqrt();
            let shift = self.diffusion * mu;
            r2 + shift * (shift - 2.0 * self.offset * cosine)
        } else {
            r2 + 1.0 / (3.0 * self.sigma_t).powi(2)
        };
        // The mirror stands upright on the line between the two points.
        let normal = upright(entry.normal, apart, r2);
        let mirrored = 2.0 * dot(inside, normal);
        let image: [f64; 3] = std::array::from_fn(|k| inside[k] - mirrored * normal[k]);
        let from_image: [f64; 3] = std::array::from_fn(|k| apart[k] - self.height * normal[k]);
        self.ray(apart, inside, exit.normal, corrected.sqrt())
            - self.ray(from_image, image, exit.normal, dot(from_image, from_image).sqrt())
    }

    /// What leaves of a ray source, 1/(m^2 sr).
    fn ray(&self, x: [f64; 3], ray: [f64; 3], normal: [f64; 3], r: f64) -> f64 {
        let (sigma, diffusion) = (self.sigma_tr, self.diffusion);
        let (along, sr) = (dot(x, ray), sigma * r);
        let fade = (-sr).exp() / (r * r * r);
        if !(fade > 0.0 && fade.is_finite()) {
            return 0.0;
        }
        let one = 1.0 + sr;
        let fluence = r * r / diffusion + 3.0 * one * along;
        let bent = one + 3.0 * diffusion * (3.0 * one + sr * sr) / (r * r) * along;
        let flux = 3.0 * diffusion * one * dot(ray, normal) - bent * dot(x, normal);
        fade * (self.c_phi * fluence - self.c_e * flux) / (4.0 * PI * PI * self.entering)
    }

    pub(super) fn sigma_tr(&self) -> f64 {
        self.sigma_tr
    }
}

#[inline]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The part of a normal that stands on a line, as a unit vector; the normal itself where there is no line or it runs along
/// it.
fn upright(normal: [f64; 3], along: [f64; 3], squared: f64) -> [f64; 3] {
    if squared <= 0.0 {
        return normal;
    }
    let part = dot(normal, along) / squared;
    let rest: [f64; 3] = std::array::from_fn(|k| normal[k] - part * along[k]);
    let length = dot(rest, rest).sqrt();
    if length > 1e-9 { rest.map(|v| v / length) } else { normal }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::gauss_legendre;
    use crate::transfer::diffusion::testing;

    const UP: [f64; 3] = [0.0, 0.0, 1.0];

    fn point(x: f64, y: f64, polar: f64, azimuth: f64) -> SurfacePoint {
        let direction = [polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()];
        SurfacePoint { position: [x, y, 0.0], normal: UP, direction }
    }

    /// Radiance times the cosine, over all directions, is what the profile gives of light that has entered.
    #[test]
    fn the_bssrdf_of_a_flat_surface_is_the_profile() {
        for medium in testing::media().into_iter().filter(|m| m.reduced_albedo() > 0.3) {
            let dipole = DirectionalDipole::new(&medium);
            let length = 1.0 / medium.reduced_extinction();
            // From a denser outside not all directions are reached.
            let least = (1.0 - medium.relative_index().powi(2)).max(0.0).sqrt();
            for r in [0.0, 0.3, 2.0, 9.0] {
                let entry = point(0.0, 0.0, 0.0, 0.0);
                let sum: f64 = gauss_legendre(200)
                    .iter()
                    .map(|(x, w)| {
                        let cosine = least + 0.5 * (1.0 - least) * (1.0 + x);
                        let exit = point(r * length, 0.0, cosine.acos(), 0.7);
                        PI * w * (1.0 - least) * cosine * dipole.bssrdf(&entry, &exit)
                    })
                    .sum();
                let wanted = medium.entering() * dipole.reflectance(r * length);
                assert!((sum / wanted - 1.0).abs() < 2e-4, "{medium:?} {r}: {sum} for {wanted}");
            }
        }
    }

    #[test]
    fn light_goes_where_its_ray_points() {
        let medium = DiffusionMedium::new(0.1, 100.0, 0.5, 1.3).unwrap();
        let dipole = DirectionalDipole::new(&medium);
        let entry = point(0.0, 0.0, 1.0, PI);
        let (ahead, behind) = (point(0.05, 0.0, 0.3, 0.0), point(-0.05, 0.0, 0.3, 0.0));
        assert!(dipole.bssrdf(&entry, &ahead) > 1.2 * dipole.bssrdf(&entry, &behind));
        // From below the horizon nothing comes, and nothing goes there.
        assert_eq!(dipole.bssrdf(&point(0.0, 0.0, 2.0, 0.0), &ahead), 0.0);
        assert_eq!(dipole.bssrdf(&entry, &point(0.05, 0.0, 2.0, 0.0)), 0.0);
    }

    /// Through a thin sheet: the exit looks the other way.
    #[test]
    fn a_back_lit_point_is_finite() {
        let medium = DiffusionMedium::new(1.0, 100.0, 0.5, 1.3).unwrap();
        let dipole = DirectionalDipole::new(&medium);
        for depth in [0.0, 1e-6, 0.01, 0.1] {
            let exit =
                SurfacePoint { position: [0.0, 0.0, -depth], normal: [0.0, 0.0, -1.0], direction: [0.0, 0.0, -1.0] };
            let found = dipole.bssrdf(&point(0.0, 0.0, 0.0, 0.0), &exit);
            assert!(found.is_finite() && found >= 0.0, "{depth}: {found}");
        }
    }

    #[test]
    fn awkward_places() {
        for medium in testing::media() {
            let dipole = DirectionalDipole::new(&medium);
            testing::check_total(&medium, dipole.sigma_tr, |r| dipole.reflectance(r), dipole.total());
            testing::check_places(&medium, |r| dipole.reflectance(r));
        }
    }
}
