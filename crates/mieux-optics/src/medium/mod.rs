//! A host with populations of particles in it, and the bulk optical properties that follow.

mod bulk;
mod phase;

use num_complex::Complex64;

pub use bulk::{BulkOptics, DEFAULT_TOLERANCE, OpticsAt};

use crate::mie::MieError;
use crate::particle::SizeDistribution;
use crate::phase::PhaseError;
use crate::spectrum::{SpectrumError, nanometres};
use crate::substance::{Substance, SubstanceError};

/// One kind of particle: of what, how large, how much.
#[derive(Debug, Clone, PartialEq)]
pub struct Inclusion {
    /// What people call it; used in messages and summaries.
    pub name: String,
    /// What it is made of.
    pub substance: Substance,
    /// How large its particles are.
    pub sizes: SizeDistribution,
    /// Volume of particles per volume of medium, 0 to 1.
    pub volume_fraction: f64,
}

/// A homogeneous host with any number of inclusions that scatter independently.
#[derive(Debug, Clone, PartialEq)]
pub struct Medium {
    host: Substance,
    inclusions: Vec<Inclusion>,
}

/// Why a medium is impossible, or its properties could not be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MediumError {
    /// A volume fraction outside 0..=1.
    #[error("volume fraction {value} of {inclusion} must lie between 0 and 1")]
    VolumeFraction {
        /// Name of the inclusion.
        inclusion: String,
        /// What was given.
        value: f64,
    },
    /// More inclusions than there is room for.
    #[error("the volume fractions of the inclusions add up to {total}, more than 1")]
    Overfull {
        /// Sum of the volume fractions.
        total: f64,
    },
    /// A wavelength outside the data of one of the substances.
    #[error(transparent)]
    Substance(#[from] SubstanceError),
    /// A particle that Lorenz-Mie theory could not compute.
    #[error("{inclusion}: {source}")]
    Mie {
        /// Name of the inclusion.
        inclusion: String,
        /// What was wrong.
        source: MieError,
    },
    /// The integral over radius did not settle.
    #[error("the size integral of {inclusion} did not converge to {tolerance} at {} nm", nanometres(*wavelength_m))]
    NotConverged {
        /// Name of the inclusion.
        inclusion: String,
        /// Relative tolerance asked for.
        tolerance: f64,
        /// Wavelength, m.
        wavelength_m: f64,
    },
    /// The tolerance is not a number between 1e-12 and 1.
    #[error("tolerance {tolerance} must lie between 1e-12 and 1")]
    Tolerance {
        /// What was given.
        tolerance: f64,
    },
    /// Computed values that are no spectrum; says where.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// A phase function that cannot be tabulated.
    #[error("phase function: {0}")]
    Phase(#[from] PhaseError),
}

impl Medium {
    /// Puts inclusions into a host. Inclusions with a volume fraction of zero are left out.
    ///
    /// # Errors
    /// [`MediumError::VolumeFraction`] or [`MediumError::Overfull`].
    pub fn new(host: Substance, inclusions: Vec<Inclusion>) -> Result<Self, MediumError> {
        for inclusion in &inclusions {
            let value = inclusion.volume_fraction;
            if !(0.0..=1.0).contains(&value) {
                return Err(MediumError::VolumeFraction { inclusion: inclusion.name.clone(), value });
            }
        }
        let total: f64 = inclusions.iter().map(|i| i.volume_fraction).sum();
        if total > 1.0 {
            return Err(MediumError::Overfull { total });
        }
        let inclusions = inclusions.into_iter().filter(|i| i.volume_fraction > 0.0).collect();
        Ok(Self { host, inclusions })
    }

    /// The host.
    pub fn host(&self) -> &Substance {
        &self.host
    }

    /// The inclusions, none of them empty.
    pub fn inclusions(&self) -> &[Inclusion] {
        &self.inclusions
    }

    /// The wavelengths (m) for which every substance has data; `None` when every wavelength will do, an empty range
    /// (first above second) when there is none.
    pub fn wavelength_range(&self) -> Option<(f64, f64)> {
        let substances = std::iter::once(&self.host).chain(self.inclusions.iter().map(|i| &i.substance));
        substances.filter_map(Substance::wavelength_range).reduce(|a, b| (a.0.max(b.0), a.1.min(b.1)))
    }
}

/// Absorption coefficient (1/m) of a substance with imaginary index `n.im` at a vacuum wavelength (m): eq 6 of
/// `frisvad2007`.
pub fn absorption_coefficient(n: Complex64, wavelength_m: f64) -> f64 {
    4.0 * std::f64::consts::PI * n.im / wavelength_m
}
