//! A medium as diffusion theory sees it: a half-space behind a smooth surface.

use crate::transfer::fresnel::{DiffuseReflectance, dielectric_reflectance};
use crate::transfer::{DiscreteOrdinates, Ground, Incidence, Layer, Moments, Stack, TransferError};

/// A homogeneous turbid medium behind a smooth surface.
///
/// | | |
/// |---|---|
/// | `sigma_a`, `sigma_s` | coefficients of absorption and scattering, 1/m, from 0 up and not both 0 |
/// | `g` | mean cosine of scattering, -1 < g < 1 |
/// | `eta` | refractive index inside over that outside, 0.1 to 10 |
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiffusionMedium {
    sigma_a: f64,
    sigma_s: f64,
    g: f64,
    eta: f64,
    surface: DiffuseReflectance,
}

/// How the constant `A` of the extrapolated boundary follows from Fresnel's reflectance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Boundary {
    /// `(1 + 3 C2) / (1 - 2 C1)`: partial currents of a radiance that is linear in the cosine (`deon2011`).
    #[default]
    Exact,
    /// `(1 + r_int) / (1 - r_int)`, as in `groenhuis1983` and `jensen2001`: it takes the second moment of the reflectance
    /// for two thirds of the first. At index 1.3 it is 2.600 where the exact one is 2.340.
    Groenhuis,
}

impl DiffusionMedium {
    /// # Errors
    /// [`TransferError`] with the value that is out of range.
    pub fn new(sigma_a: f64, sigma_s: f64, g: f64, eta: f64) -> Result<Self, TransferError> {
        for (what, value) in [("absorption", sigma_a), ("scattering", sigma_s)] {
            if !(0.0..=1e15).contains(&value) {
                return Err(TransferError::Coefficient { what, value });
            }
        }
        if !(g > -1.0 && g < 1.0) {
            return Err(TransferError::Asymmetry { g });
        }
        if sigma_a + sigma_s * (1.0 - g) < 1e-100 {
            return Err(TransferError::Coefficient { what: "extinction", value: sigma_a + sigma_s });
        }
        let surface = (0.1..=10.0).contains(&eta).then(|| DiffuseReflectance::new(eta)).flatten();
        let surface = surface.ok_or(TransferError::RefractiveIndex { value: eta })?;
        Ok(Self { sigma_a, sigma_s, g, eta, surface })
    }

    /// Absorption coefficient, 1/m.
    pub fn sigma_a(&self) -> f64 {
        self.sigma_a
    }

    /// Scattering coefficient, 1/m.
    pub fn sigma_s(&self) -> f64 {
        self.sigma_s
    }

    /// Mean cosine of scattering.
    pub fn asymmetry(&self) -> f64 {
        self.g
    }

    /// Index inside over index outside.
    pub fn relative_index(&self) -> f64 {
        self.eta
    }

    /// Fresnel's moments of the surface, seen from inside.
    pub fn surface(&self) -> &DiffuseReflectance {
        &self.surface
    }

    /// Extinction coefficient, 1/m.
    pub fn sigma_t(&self) -> f64 {
        self.sigma_a + self.sigma_s
    }

    /// `(1 - g) sigma_s`, 1/m.
    pub fn reduced_scattering(&self) -> f64 {
        (1.0 - self.g) * self.sigma_s
    }

    /// `sigma_a + (1 - g) sigma_s`, 1/m, above 0; one over the transport mean free path.
    pub fn reduced_extinction(&self) -> f64 {
        self.sigma_a + self.reduced_scattering()
    }

    /// `sigma_s / sigma_t`.
    pub fn albedo(&self) -> f64 {
        self.sigma_s / self.sigma_t()
    }

    /// Reduced scattering over reduced extinction.
    pub fn reduced_albedo(&self) -> f64 {
        self.reduced_scattering() / self.reduced_extinction()
    }

    /// Diffusion coefficient of the first order, `1 / (3 sigma_t')`, m.
    pub fn diffusion_coefficient(&self) -> f64 {
        1.0 / (3.0 * self.reduced_extinction())
    }

    /// Diffusion coefficient of `grosjean1956`, `(2 sigma_a + sigma_s') / (3 sigma_t'^2)`, m: with it an infinite medium is
    /// described well at any albedo.
    pub fn diffusion_coefficient_grosjean(&self) -> f64 {
        let extinction = self.reduced_extinction();
        (1.0 + self.sigma_a / extinction) / (3.0 * extinction)
    }

    /// `sqrt(sigma_a / D)`, 1/m, for one of the two coefficients.
    pub fn transport_coefficient(&self, diffusion: f64) -> f64 {
        (self.sigma_a / diffusion).sqrt()
    }

    /// The `A` of the boundary: fluence vanishes `2 A D` above the surface.
    pub fn boundary(&self, boundary: Boundary) -> f64 {
        match boundary {
            Boundary::Exact => self.surface.extrapolation(),
            Boundary::Groenhuis => self.surface.extrapolation_groenhuis(),
        }
    }

    /// Share of light along the normal that passes the surface.
    pub fn entering(&self) -> f64 {
        1.0 - dielectric_reflectance(1.0, self.eta)
    }

    /// The share of the light that has entered along the normal which leaves through the surface again, from the transfer
    /// equation itself (discrete ordinates with 64 streams and a Henyey-Greenstein phase function of the medium's `g`): what
    /// the models of this room are rescaled to where energy is to be right.
    ///
    /// # Errors
    /// [`TransferError`] if the solver cannot take the medium.
    pub fn exact_total(&self) -> Result<f64, TransferError> {
        if self.sigma_s == 0.0 {
            return Ok(0.0);
        }
        if self.sigma_a == 0.0 {
            return Ok(1.0);
        }
        // Deep enough for nothing to come back, over more of the same with nothing in it.
        let decay = self.transport_coefficient(self.diffusion_coefficient());
        let depth = (50.0 * self.sigma_t() / decay).max(50.0);
        let layer = Layer::new(depth, self.albedo(), Moments::henyey_greenstein(self.g)?).with_index(self.eta);
        let stack = Stack { above: 1.0, layers: vec![layer], below: self.eta, ground: Ground::Black };
        let found = DiscreteOrdinates::with_streams(64)?.shares(&stack, Incidence::NORMAL)?;
        Ok((found.reflectance - found.reflectance_specular) / self.entering())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_is_refused() {
        let message = |a, s, g, n| DiffusionMedium::new(a, s, g, n).unwrap_err().to_string();
        assert!(message(-1.0, 1.0, 0.0, 1.3).contains("absorption coefficient -1"));
        assert!(message(1.0, f64::NAN, 0.0, 1.3).contains("scattering coefficient NaN"));
        assert!(message(0.0, 0.0, 0.0, 1.3).contains("extinction coefficient 0"));
        assert!(message(1.0, 1.0, 1.0, 1.3).contains("g = 1"));
        assert!(message(1.0, 1.0, 0.0, 0.0).contains("index 0"));
    }

    #[test]
    fn coefficients() {
        let medium = DiffusionMedium::new(2.0, 40.0, 0.75, 1.3).unwrap();
        assert_eq!((medium.reduced_scattering(), medium.reduced_extinction()), (10.0, 12.0));
        assert!((medium.diffusion_coefficient_grosjean() - 14.0 / (3.0 * 144.0)).abs() < 1e-16);
        assert!((medium.boundary(Boundary::Exact) - 2.3405).abs() < 1e-4);
        assert!((medium.boundary(Boundary::Groenhuis) - 2.600).abs() < 1e-3);
    }

    /// By adding-doubling with 32 points, itself good to 2e-4: index 1.5, albedo 0.9, isotropic, the reflection of the
    /// surface included.
    #[test]
    fn the_exact_total_is_that_of_the_transfer_equation() {
        for scale in [1e-3, 1e5] {
            let medium = DiffusionMedium::new(0.1 * scale, 0.9 * scale, 0.0, 1.5).unwrap();
            let all = 1.0 - medium.entering() * (1.0 - medium.exact_total().unwrap());
            assert!((all - 0.25994).abs() < 2e-4, "{all}");
        }
        assert_eq!(DiffusionMedium::new(0.0, 1.0, 0.5, 1.5).unwrap().exact_total().unwrap(), 1.0);
        assert_eq!(DiffusionMedium::new(1.0, 0.0, 0.5, 1.5).unwrap().exact_total().unwrap(), 0.0);
        let nearly = DiffusionMedium::new(1e-9, 1.0, 0.5, 1.5).unwrap().exact_total().unwrap();
        assert!(nearly < 1.0 && nearly > 0.999, "{nearly}");
    }
}
