//! The better dipole: Grosjean's diffusion, and what leaves is taken from fluence and flux alike.

use std::f64::consts::PI;

use super::source::{farther, flux, potential_between, relative_loss};
use super::{Boundary, DiffusionMedium};

/// Diffuse reflectance after `deon2012`, meant for light scattered twice and more: [`super::SingleScattering`] is what it
/// leaves out.
///
/// With it the total is good where much is absorbed (within 5 % of what comes back up to albedo 0.7, isotropic), where the
/// classical dipole is not. But without absorption this part alone has a total of 1, so that single scattering comes on
/// top of all the light: by 15 % without a surface, 5 % at index 1.5, when scattering is isotropic. Where energy matters
/// [`super::Profile::normalised`] is needed. Its one source, a mean free path deep, knows nothing of the centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BetterDipole {
    albedo_squared: f64,
    sigma_tr: f64,
    depths: [f64; 2],
    exitance: Exitance,
}

/// What leaves through the surface: `C_phi` times the fluence and `C_E` times the flux towards it (`deon2011`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Exitance {
    /// `(1 - 2 C1) / 4`, over the diffusion coefficient, 1/m.
    pub fluence: f64,
    /// `(1 - 3 C2) / 2`.
    pub flux: f64,
}

impl Exitance {
    pub fn new(medium: &DiffusionMedium, diffusion: f64) -> Self {
        let surface = medium.surface();
        Self { fluence: 0.25 * (1.0 - 2.0 * surface.c1) / diffusion, flux: 0.5 * (1.0 - 3.0 * surface.c2) }
    }

    /// At a distance from the axis, of a source of power `4 pi` at one depth and its negative at one height, m.
    #[inline]
    pub fn at(&self, r: f64, [below, above]: [f64; 2], sigma: f64) -> f64 {
        let (near, by) = (r.hypot(below), farther(r, below, above));
        let sources = flux(below, near, sigma) + flux(above, near + by, sigma);
        self.fluence * potential_between(near, by, sigma) + self.flux * sources
    }

    /// The integral of [`Exitance::at`] over the plane, over `2 pi`.
    pub fn total(&self, [below, above]: [f64; 2], sigma: f64) -> f64 {
        let [near, far] = [below, above].map(|z| (-sigma * z).exp());
        let between = near * (above - below) * relative_loss(sigma * (above - below));
        self.fluence * between + self.flux * (near + far)
    }
}

impl BetterDipole {
    /// Of a medium.
    pub fn new(medium: &DiffusionMedium) -> Self {
        let diffusion = medium.diffusion_coefficient_grosjean();
        let depth = 1.0 / medium.reduced_extinction();
        Self {
            albedo_squared: medium.reduced_albedo().powi(2),
            sigma_tr: medium.transport_coefficient(diffusion),
            depths: [depth, depth + 4.0 * medium.boundary(Boundary::Exact) * diffusion],
            exitance: Exitance::new(medium, diffusion),
        }
    }

    /// Power that leaves per area at the distance `r` (m, from 0 up) from where light of power 1 has entered along the
    /// normal, single scattering left out, 1/m^2.
    pub fn reflectance(&self, r: f64) -> f64 {
        self.albedo_squared / (4.0 * PI) * self.exitance.at(r, self.depths, self.sigma_tr)
    }

    /// All that leaves: the integral of [`BetterDipole::reflectance`] over the surface.
    pub fn total(&self) -> f64 {
        0.5 * self.albedo_squared * self.exitance.total(self.depths, self.sigma_tr)
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
            let dipole = BetterDipole::new(&medium);
            testing::check_total(&medium, dipole.sigma_tr, |r| dipole.reflectance(r), dipole.total());
            testing::check_places(&medium, |r| dipole.reflectance(r));
        }
    }

    /// Without absorption fluence vanishes at the extrapolated height, and all that the source sends comes out: the two
    /// constants are partial currents of one radiance, so that the first factor makes up for the second.
    #[test]
    fn nothing_is_lost_without_absorption() {
        for eta in [0.7, 1.0, 1.3, 1.5, 2.0] {
            let medium = DiffusionMedium::new(0.0, 1e3, 0.3, eta).unwrap();
            assert!((BetterDipole::new(&medium).total() - 1.0).abs() < 1e-12, "{eta}");
        }
    }
}
