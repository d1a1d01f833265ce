//! A host with populations of particles in it, and the bulk optical properties that follow.

mod amount;
mod bulk;
mod coat;
mod doubts;
mod effective_index;
mod inclusion;
mod packing;
mod phase;
mod scatterer;
mod sizes;

use num_complex::Complex64;

pub use amount::{Amount, AmountError, Portion, volume_fractions};
pub use bulk::{BulkOptics, DEFAULT_TOLERANCE, OpticsAt, RelativeError};
pub use coat::{Coat, CoatError, CoatExtent, SizedBy};
pub use doubts::Doubt;
pub use effective_index::EffectiveIndex;
pub use inclusion::Inclusion;
pub use packing::{HardSpheres, Packing, clearance};
pub use phase::ScatteringAt;

use crate::mie::MieError;
use crate::phase::PhaseError;
use crate::spectrum::{SpectrumError, nanometres};
use crate::substance::{Substance, SubstanceError};

/// A homogeneous host with any number of inclusions.
#[derive(Debug, Clone, PartialEq)]
pub struct Medium {
    host: Substance,
    inclusions: Vec<Inclusion>,
    effective_index: EffectiveIndex,
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
    /// Spheres of the same area as the particles that take up more room than there is.
    #[error(
        "spheres of the same area as the particles would take up {total} of the volume, more than 1; volume-to-area spheres take up no more than the particles"
    )]
    OverfullSpheres {
        /// The share of the volume.
        total: f64,
    },
    /// Something that only spheres have.
    #[error("{inclusion}: {what} can only be had with spheres")]
    NotSpheres {
        /// Name of the inclusion.
        inclusion: String,
        /// Coats, or a correction for packing.
        what: &'static str,
    },
    /// Spheres too dense for a structure factor of a fluid.
    #[error(
        "volume fraction {value} of {inclusion} is above 0.5, where hard spheres are no fluid any more and Percus and Yevick's structure factor does not hold"
    )]
    Packing {
        /// Name of the inclusion.
        inclusion: String,
        /// Its volume fraction.
        value: f64,
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
    /// [`MediumError`]: a volume fraction out of range, or all together; coats or a correction for packing on what are no spheres; too
    /// dense a packing for its correction.
    pub fn new(host: Substance, inclusions: Vec<Inclusion>) -> Result<Self, MediumError> {
        inclusions.iter().try_for_each(Inclusion::check)?;
        let total: f64 = inclusions.iter().map(|i| i.volume_fraction).sum();
        if total > 1.0 {
            return Err(MediumError::Overfull { total });
        }
        let total: f64 = inclusions.iter().map(Inclusion::fraction_of_spheres).sum();
        if total > 1.0 {
            return Err(MediumError::OverfullSpheres { total });
        }
        let inclusions = inclusions.into_iter().filter(|i| i.volume_fraction > 0.0).collect();
        Ok(Self { host, inclusions, effective_index: EffectiveIndex::default() })
    }

    /// The same medium, its effective refractive index understood otherwise.
    pub fn with_effective_index(self, effective_index: EffectiveIndex) -> Self {
        Self { effective_index, ..self }
    }

    /// How its effective refractive index is understood.
    pub fn effective_index(&self) -> EffectiveIndex {
        self.effective_index
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
        let particles = self
            .inclusions
            .iter()
            .flat_map(|i| std::iter::once(&i.substance).chain(i.coats.iter().map(Coat::substance)));
        let substances = std::iter::once(&self.host).chain(particles);
        substances.filter_map(Substance::wavelength_range).reduce(|a, b| (a.0.max(b.0), a.1.min(b.1)))
    }
}

/// Absorption coefficient (1/m) of a substance with imaginary index `n.im` at a vacuum wavelength (m): eq 6 of
/// `frisvad2007`.
pub fn absorption_coefficient(n: Complex64, wavelength_m: f64) -> f64 {
    4.0 * std::f64::consts::PI * n.im / wavelength_m
}
