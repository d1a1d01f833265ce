//! Follows light backwards from the camera: a spectral volumetric path tracer.

mod cloud;
mod direct;
mod features;
mod finish;
mod fog;
mod interface;
mod path;
mod rough;
mod statistics;
mod subsurface;
mod throughput;
mod turbid;
mod walk;

pub use features::{Features, features};
pub use path::{Estimate, trace};
pub use statistics::Statistics;
pub(crate) use turbid::MediumLanes;
pub(crate) use walk::scattered;

/// Wavelengths per path: the hero and its companions.
pub const LANES: usize = 4;

/// One number per wavelength of a path; the hero comes first.
pub type Lanes = [f64; LANES];

/// How light is followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transport {
    /// Off: rays bend by each body's index at 587.56 nm whatever their wavelength, while the shares reflected and
    /// refracted follow each wavelength's own index; all wavelengths of a path stay together, and energy is
    /// conserved. On: rays bend by the hero's own index, and companions end where theirs differs. No rainbows without.
    pub dispersion: bool,
    /// After ten mean free paths in a body, scatter isotropically with `(1 - g) sigma_s` (frisvad2007, section 3):
    /// faster and slightly wrong. Measured on 2 mm of whole milk: reflectance +0.27 % +- 0.06 % without a change of
    /// index, -0.57 % +- 0.07 % with the index of milk against air.
    pub similarity: bool,
    /// Light that enters a dense turbid body leaves it elsewhere on its surface by a diffusion profile instead of a random
    /// walk (the classical dipole of `jensen2001`, its boundary and its energy made exact): approximate. Bodies that are not
    /// ten transport mean free paths thick, or absorb more than they scatter, are walked through as ever.
    pub diffusion: bool,
    /// Whether a hero has companions. Off: one wavelength per path; the same picture with more noise.
    pub companions: bool,
}

impl Default for Transport {
    /// No dispersion, the exact walk, companions.
    fn default() -> Self {
        Self { dispersion: false, similarity: false, diffusion: false, companions: true }
    }
}
