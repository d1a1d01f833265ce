//! Diffusion: what turbid media do to light when it has been scattered so often that only its fluence counts.
//!
//! Two questions have closed answers. How far from where a pencil beam enters a half-space (or a slab) does light leave:
//! the dipoles and their kin, a file each, under one roof as [`Profile`]. And where does the light go that falls onto a
//! stack of layers: [`shares`], with the same meaning as [`crate::transfer::DiscreteOrdinates::shares`].
//!
//! Profiles are of light of power 1 that *has entered* a flat surface along the normal; of what falls in, the share that
//! the surface reflects is not in them. What each is worth against photons is measured in docs/diffusion.md.
//!
//! ```
//! use mieux_optics::transfer::diffusion::{DiffusionMedium, DiffusionModel, Profile};
//!
//! // Whole milk in green light.
//! let milk = DiffusionMedium::new(6.08, 57_837.0, 0.954, 1.347)?;
//! let profile = Profile::new(DiffusionModel::PhotonBeam, &milk)?.normalised()?;
//! assert!((profile.total() - milk.exact_total()?).abs() < 1e-12);
//! assert!(profile.reflectance(1e-3) > profile.reflectance(2e-3));
//! # Ok::<(), mieux_optics::transfer::TransferError>(())
//! ```

mod better_dipole;
mod dipole;
mod directional_dipole;
mod layers;
mod medium;
mod multipole;
mod photon_beam;
mod profile;
mod radial;
mod single_scattering;
mod source;

pub use better_dipole::BetterDipole;
pub use dipole::Dipole;
pub use directional_dipole::{DirectionalDipole, SurfacePoint};
pub use layers::shares;
pub use medium::{Boundary, DiffusionMedium};
pub use multipole::Multipole;
pub use photon_beam::PhotonBeam;
pub use profile::{DiffusionModel, Profile};
pub use radial::RadialSampler;
pub use single_scattering::SingleScattering;

#[cfg(test)]
mod testing;
