//! Light and one sphere: Lorenz-Mie theory, generalised to a host that absorbs.
//!
//! In an absorbing host the extinction cross section is relative to the host it displaces and may be negative
//! (`bohren1979`); the scattering cross section has no unique meaning there, and every result names the definition
//! it follows ([`ScatteringDefinition`]).

mod elementary;
mod host;
mod kernel;
mod lanes;
mod sphere;
mod sums;
mod weights;

pub use sphere::{Sphere, SphereScattering, scatter_sphere, scatter_spheres};

/// What "scattering cross section" means in an absorbing host; in a lossless one the definitions agree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ScatteringDefinition {
    /// Far-field power projected back to the surface of the particle, divided by the mean incident power on it:
    /// eq 23-24 of `frisvad2007`, after `mundy1974`.
    #[default]
    Frisvad2007,
}

/// Why a sphere could not be computed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum MieError {
    /// Radius or wavelength is not a positive finite length.
    #[error("{name} {value_m} m is not a positive finite length")]
    Length {
        /// `radius` or `wavelength`.
        name: &'static str,
        /// What was given, m.
        value_m: f64,
    },
    /// An index must have a positive real part and an imaginary part that is not negative.
    #[error(
        "refractive index {re}{im:+}i of the {name}: the real part must be positive, the imaginary part zero or more"
    )]
    Index {
        /// `host` or `particle`.
        name: &'static str,
        /// Real part.
        re: f64,
        /// Imaginary part.
        im: f64,
    },
    /// The size parameter (in the host or inside the particle) lies outside what double precision can carry.
    #[error("size parameter {modulus:e} is outside 1e-8 to 1e7")]
    SizeParameter {
        /// Modulus of the offending size parameter.
        modulus: f64,
    },
    /// The host absorbs so much over one particle that the extinction cross section leaves the range of numbers.
    #[error("the host absorbs exp(-{exponent:.0}) over one particle; its extinction cross section overflows")]
    HostAbsorption {
        /// Twice the imaginary part of the size parameter.
        exponent: f64,
    },
}
