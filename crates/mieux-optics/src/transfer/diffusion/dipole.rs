//! The classical dipole: one source one transport mean free path below the surface, and its image above.

use std::f64::consts::PI;

use super::source::flux;
use super::{Boundary, DiffusionMedium};

/// Diffuse reflectance after `farrell1992` and `jensen2001`. It holds all scattering from the first on: single scattering
/// must not be added.
///
/// Good from about two transport mean free paths outward and at a reduced albedo near 1. Nearer it does not know that
/// light enters along a line, and so is too low at the centre; at reduced albedo 0.5 its total has little to do with the
/// truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dipole {
    albedo: f64,
    sigma_tr: f64,
    /// Depth of the source and height of the image, m.
    depths: [f64; 2],
}

impl Dipole {
    /// Of a medium, with either boundary.
    pub fn new(medium: &DiffusionMedium, boundary: Boundary) -> Self {
        Self::with_boundary(medium.sigma_a(), medium.reduced_scattering(), medium.boundary(boundary))
    }

    /// From coefficients of absorption and of reduced scattering (1/m, from 0 up and not both 0) and the constant `A` of
    /// the boundary, where that is known already.
    pub fn with_boundary(sigma_a: f64, reduced_scattering: f64, a: f64) -> Self {
        let extinction = sigma_a + reduced_scattering;
        let depth = 1.0 / extinction;
        Self {
            albedo: reduced_scattering / extinction,
            // sqrt(sigma_a / D) with D = 1 / (3 sigma_t').
            sigma_tr: (3.0 * sigma_a * extinction).sqrt(),
            depths: [depth, depth * (1.0 + 4.0 / 3.0 * a)],
        }
    }

    /// Power that leaves per area at the distance `r` (m, from 0 up) from where light of power 1 has entered along the
    /// normal, 1/m^2.
    pub fn reflectance(&self, r: f64) -> f64 {
        let of = |z: f64| flux(z, r.hypot(z), self.sigma_tr);
        self.albedo / (4.0 * PI) * (of(self.depths[0]) + of(self.depths[1]))
    }

    /// All that leaves: the integral of [`Dipole::reflectance`] over the surface.
    pub fn total(&self) -> f64 {
        let of = |z: f64| (-self.sigma_tr * z).exp();
        0.5 * self.albedo * (of(self.depths[0]) + of(self.depths[1]))
    }

    /// A distance (m) with the density `reflectance / total` per area, for two uniform numbers in [0, 1): exact, as the sum
    /// of two sources each of which is inverted.
    pub fn sample(&self, [choice, xi]: [f64; 2]) -> f64 {
        let [near, far] = self.depths.map(|z| (-self.sigma_tr * z).exp());
        let z = self.depths[usize::from(choice * (near + far) >= near)];
        // Beyond d there is the share (z / d) exp(-sigma (d - z)): solved for the logarithm of d / z.
        let wanted = -(1.0 - xi.clamp(0.0, 1.0)).max(f64::MIN_POSITIVE).ln();
        let x = self.sigma_tr * z;
        let mut y = wanted / (1.0 + x);
        // Convex and rising: from above, Newton's method comes down to the root.
        for _ in 0..60 {
            let step = (y + x * y.exp_m1() - wanted) / (1.0 + x * y.exp());
            y -= step;
            if step.abs() <= 1e-15 * (1.0 + y) {
                break;
            }
        }
        let y = y.max(0.0);
        // r^2 = d^2 - z^2
        z * (2.0 * y).exp_m1().max(0.0).sqrt()
    }

    pub(super) fn sigma_tr(&self) -> f64 {
        self.sigma_tr
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::diffusion::testing;

    #[test]
    fn the_total_is_the_integral() {
        for medium in testing::media() {
            for boundary in [Boundary::Exact, Boundary::Groenhuis] {
                let dipole = Dipole::new(&medium, boundary);
                testing::check_total(&medium, dipole.sigma_tr, |r| dipole.reflectance(r), dipole.total());
            }
        }
    }

    #[test]
    fn the_sample_inverts_the_cumulative_distribution() {
        for medium in testing::media() {
            let dipole = Dipole::new(&medium, Boundary::Exact);
            let [near, far] = dipole.depths.map(|z| (-dipole.sigma_tr * z).exp());
            for (first, z) in [(0.0, dipole.depths[0]), (1.0 - 1e-12, dipole.depths[1])] {
                if first > 0.0 && far < 1e-9 * near {
                    continue;
                }
                for xi in [0.0, 1e-12, 1e-3, 0.1, 0.5, 0.9, 0.999, 1.0 - 1e-9] {
                    let r = dipole.sample([first, xi]);
                    let d = r.hypot(z);
                    let beyond = z / d * (-dipole.sigma_tr * (d - z)).exp();
                    assert!((beyond - (1.0 - xi)).abs() < 1e-9 * (1.0 - xi) + 1e-12, "{medium:?} {xi}: {beyond}");
                }
            }
        }
    }

    #[test]
    fn awkward_places() {
        for medium in testing::media() {
            let dipole = Dipole::new(&medium, Boundary::Exact);
            testing::check_places(&medium, |r| dipole.reflectance(r));
        }
    }
}
