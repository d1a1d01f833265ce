//! Phase functions: how scattered light spreads over angle. `cos(theta) = 1` is forward; the integral over the sphere
//! is 1.
//!
//! [`PhaseFunction`] holds any of them. [`Tabulated`] is how Lorenz-Mie results and measurements enter,
//! [`SpectralPhase`] holds one function per wavelength, [`fit`] turns any function into one of a few parameters, and
//! [`compare`] says how far two are apart.
//!
//! ```
//! use mieux_optics::phase::{AngleGrid, PhaseFunction, TableRule, Tabulated, WaterDroplet, fit};
//!
//! // A function of the scattering angle, here of a droplet of size parameter 57, becomes a table ...
//! let droplet = WaterDroplet::new(10e-6)?;
//! let grid = AngleGrid::graded(57.0, 2.0)?;
//! let table = Tabulated::from_fn(grid, TableRule::Integrated, |theta| droplet.value(theta.cos()))?;
//! assert!(table.one_minus_asymmetry_error() < 1e-4);
//! // ... and the table a function of three parameters with the same mean cosine.
//! let options = fit::Options { keep_asymmetry: true, ..fit::Options::default() };
//! let lobes = fit::double_henyey_greenstein(&table.into(), &options)?;
//! assert!((lobes.phase.asymmetry() - droplet.asymmetry()).abs() < 1e-4);
//! let mu = PhaseFunction::from(lobes.phase).sample(0.25);
//! assert!((-1.0..=1.0).contains(&mu));
//! # Ok::<(), mieux_optics::phase::PhaseError>(())
//! ```

mod compare;
mod cornette_shanks;
mod double_henyey_greenstein;
mod draine;
mod error;
pub mod fit;
mod fournier_forand;
mod function;
mod henyey_greenstein;
mod henyey_greenstein_draine;
mod henyey_greenstein_mixture;
mod isotropic;
mod quadrature;
mod rayleigh;
mod spectral;
mod tabulated;
#[cfg(test)]
mod testing;
mod water_droplet;

pub use compare::{Comparison, compare};
pub use cornette_shanks::CornetteShanks;
pub use double_henyey_greenstein::DoubleHenyeyGreenstein;
pub use draine::Draine;
pub use error::PhaseError;
pub use fournier_forand::FournierForand;
pub use function::PhaseFunction;
pub use henyey_greenstein::HenyeyGreenstein;
pub use henyey_greenstein_draine::HenyeyGreensteinDraine;
pub use henyey_greenstein_mixture::HenyeyGreensteinMixture;
pub use isotropic::Isotropic;
pub use rayleigh::Rayleigh;
pub use spectral::{PhaseMixture, SpectralPhase};
pub use tabulated::{AngleGrid, TableRule, Tabulated};
pub use water_droplet::WaterDroplet;
