//! Light that is scattered exactly once, of a pencil beam along the normal: no diffusion in it.

use std::convert::Infallible;
use std::f64::consts::{FRAC_PI_2, PI};

use super::DiffusionMedium;
use crate::integrate::integrate;
use crate::phase::HenyeyGreenstein;
use crate::transfer::TransferError;
use crate::transfer::fresnel::dielectric_reflectance;

/// What a pencil beam gives back after one scattering, by a Henyey-Greenstein phase function of the medium's `g`
/// (`habel2013`, with the integral over the beam turned into one over the angle at which light arrives at the surface):
///
/// `R(r) = sigma_s / r  Int exp(-sigma_t r cot(theta / 2)) p(-cos theta) (1 - F(theta)) cos(theta) d theta`.
///
/// Exact at every albedo. It falls as `1 / r` at the centre, where its value is infinite and its integral is not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SingleScattering {
    sigma_s: f64,
    sigma_t: f64,
    eta: f64,
    phase: HenyeyGreenstein,
}

/// One way out: cosine inside, sine inside, and the weight of an integral over `cos(theta) d theta`.
struct Ray {
    cosine: f64,
    sine: f64,
    weight: f64,
}

impl SingleScattering {
    /// # Errors
    /// None for a [`DiffusionMedium`]; the type is that of the phase function's.
    pub fn new(medium: &DiffusionMedium) -> Result<Self, TransferError> {
        let g = medium.asymmetry();
        let phase = HenyeyGreenstein::new(g).map_err(|_| TransferError::Asymmetry { g })?;
        Ok(Self { sigma_s: medium.sigma_s(), sigma_t: medium.sigma_t(), eta: medium.relative_index(), phase })
    }

    /// Power that leaves per area at the distance `r` (m, from 0 up) from where light of power 1 has entered, to 1e-10,
    /// 1/m^2; infinite at 0.
    pub fn reflectance(&self, r: f64) -> f64 {
        if self.sigma_s == 0.0 {
            return 0.0;
        }
        if r == 0.0 {
            return f64::INFINITY;
        }
        let length = self.sigma_t * r;
        let integral = self.over_rays(|ray| {
            let fade = (-length * (1.0 + ray.cosine) / ray.sine).exp();
            if fade > 0.0 { fade * ray.weight } else { 0.0 }
        });
        integral * self.sigma_s / r
    }

    /// All that leaves: the integral of [`SingleScattering::reflectance`] over the surface, to 1e-10.
    pub fn total(&self) -> f64 {
        let integral = self.over_rays(|ray| ray.weight * ray.sine / (1.0 + ray.cosine));
        2.0 * PI * self.sigma_s / self.sigma_t * integral
    }

    /// Over the angle on the side of the lower index, where Fresnel's share has no edge.
    fn over_rays(&self, of: impl Fn(Ray) -> f64) -> f64 {
        let found = integrate(&[0.0, 0.05, 0.5, FRAC_PI_2], 1e-10, [1e-200], |angle| {
            let (sine, cosine) = f64::sin_cos(angle);
            let (inside, outside) = if self.eta >= 1.0 {
                let sine = sine / self.eta;
                ([((1.0 - sine) * (1.0 + sine)).sqrt(), sine], cosine)
            } else {
                let beyond = sine * self.eta;
                ([cosine, sine], ((1.0 - beyond) * (1.0 + beyond)).sqrt())
            };
            // cos(theta) d(theta) is proportional to cos(theta_o) d(theta_o).
            let measure = if self.eta >= 1.0 { cosine / self.eta } else { cosine };
            let passes = 1.0 - dielectric_reflectance(outside, self.eta);
            let weight = measure * passes * self.phase.value(-inside[0]);
            Ok::<_, Infallible>([of(Ray { cosine: inside[0], sine: inside[1], weight })])
        });
        match found {
            Ok(found) => found.map_or(f64::NAN, |integral| integral.value[0]),
            Err(never) => match never {},
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::diffusion::testing;

    #[test]
    fn the_total_is_the_integral() {
        for medium in testing::media() {
            let single = SingleScattering::new(&medium).unwrap();
            testing::check_total(&medium, medium.sigma_t(), |r| single.reflectance(r), single.total());
        }
    }

    /// Without a surface and for isotropic scattering: `albedo / 2 (1 - ln 2)`.
    #[test]
    fn the_total_without_a_surface_is_known() {
        let medium = DiffusionMedium::new(3.0, 7.0, 0.0, 1.0).unwrap();
        let total = SingleScattering::new(&medium).unwrap().total();
        assert!((total - 0.35 * (1.0 - 2f64.ln())).abs() < 1e-12, "{total}");
    }

    /// Against the integral along the beam as it is published.
    #[test]
    fn the_angle_may_be_integrated_instead_of_the_depth() {
        for (g, eta) in [(0.0, 1.0), (0.6, 1.4), (-0.3, 0.8)] {
            let medium = DiffusionMedium::new(1.0, 4.0, g, eta).unwrap();
            let phase = HenyeyGreenstein::new(g).unwrap();
            let single = SingleScattering::new(&medium).unwrap();
            for r in [0.01f64, 0.2, 1.5] {
                let least = r * (eta * eta - 1.0f64).max(0.0).sqrt();
                let found =
                    integrate(&[least, least + 0.01, least + 0.1, least + 1.0, least + 12.0], 1e-9, [0.0], |t| {
                        let d = r.hypot(t);
                        let cosine = t / d;
                        let passes = 1.0 - dielectric_reflectance(cosine, 1.0 / eta);
                        Ok::<_, Infallible>([
                            4.0 * (-5.0 * (d + t)).exp() * phase.value(-cosine) * passes * cosine / (d * d)
                        ])
                    });
                let along = found.unwrap().unwrap().value[0];
                let ours = single.reflectance(r);
                assert!((ours / along - 1.0).abs() < 1e-7, "{g} {eta} {r}: {ours} for {along}");
            }
        }
    }
}
