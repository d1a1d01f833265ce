//! What can be wrong with measurements of a slab.

use super::super::TransferError;

/// Why a measurement could not be inverted at all. Carries the offending value.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InverseError {
    /// A share lies in [0, 1].
    #[error("the {quantity} {value} is not a share between 0 and 1")]
    Share {
        /// What was measured.
        quantity: &'static str,
        /// The offending value.
        value: f64,
    },
    /// A standard error is finite and not negative.
    #[error("the standard error {value} of the {quantity} is not a finite number from 0 up")]
    StandardError {
        /// What was measured.
        quantity: &'static str,
        /// The offending value.
        value: f64,
    },
    /// Too little was measured.
    #[error("{given} cannot tell absorption from scattering: measure the total reflectance as well")]
    TooLittle {
        /// What was measured.
        given: &'static str,
    },
    /// An assumed optical thickness is more than 0.
    #[error("the assumed optical thickness {value} is not a finite number above 0")]
    OpticalThickness {
        /// The offending value.
        value: f64,
    },
    /// A fraction lies in [0, 1].
    #[error(
        "the fraction {value} of the unscattered light that is measured with the {quantity} is not between 0 and 1"
    )]
    Fraction {
        /// With what.
        quantity: &'static str,
        /// The offending value.
        value: f64,
    },
    /// The sample.
    #[error(transparent)]
    Transfer(#[from] TransferError),
}

/// Why no slab has what was measured, and what is given is the nearest.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Misfit {
    /// More comes out than falls in.
    #[error("reflectance and transmittance add up to {sum:.4}, more than falls in")]
    MoreThanFallsIn {
        /// Reflectance plus transmittance.
        sum: f64,
    },
    /// The surfaces alone reflect more than was measured.
    #[error("the surface alone reflects {least}, more than was measured")]
    ReflectanceBelowSurface {
        /// Reflectance of the upper surface.
        least: f64,
    },
    /// A clear slab between the same surfaces passes less.
    #[error("the surfaces alone let no more than {most} pass unscattered")]
    UnscatteredAboveSurfaces {
        /// What a clear slab transmits.
        most: f64,
    },
    /// Less in all than is unscattered.
    #[error("the transmittance is less than the {unscattered} that pass unscattered")]
    TransmittanceBelowUnscattered {
        /// Unscattered transmittance.
        unscattered: f64,
    },
    /// None of these, and yet no slab.
    #[error("no slab of this index has these shares; the nearest misses them by {residual:.1e}")]
    NoSuchSlab {
        /// Root of the sum of the squares by which the nearest misses.
        residual: f64,
    },
}
