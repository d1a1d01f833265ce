//! Light and one sphere: Lorenz-Mie theory, generalised to a host that absorbs.
//!
//! In an absorbing host the extinction cross section is relative to the host it displaces and may be negative
//! (`bohren1979`); the scattering cross section has no unique meaning there, and every result names the definition
//! it follows ([`ScatteringDefinition`]).

mod amplitude;
mod coefficients;
mod downward;
mod elementary;
mod expansion;
mod gradient;
mod host;
mod kernel;

mod layered;
mod layered_sphere;
mod population;
mod recurrence;
mod sphere;
mod sums;
mod upward;
mod wave;
mod weights;

pub use amplitude::{Directions, Mueller};
pub use coefficients::Coefficients;
pub use expansion::Expansion;
pub use gradient::{Slope, SphereGradient};
pub use layered_sphere::{Layer, LayeredSphere, scatter_layered_spheres};
pub use population::{Population, PopulationError, PopulationScattering};
pub use sphere::{Sphere, scatter_sphere, scatter_spheres};
pub use wave::{PlaneWave, SphereScattering};

/// What "scattering cross section" means in an absorbing host; in a lossless one the definitions agree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ScatteringDefinition {
    /// Far-field power projected back to the surface of the particle, divided by the mean incident power on it:
    /// eq 23-24 of `frisvad2007`, after `mundy1974`.
    #[default]
    Frisvad2007,
    /// What a detector in the far field receives, referred to the incident intensity at the centre of the particle as if
    /// it were not there (`mishchenko2018`). Its extinction is `4 pi / Re(k) Re(S(0) / k)` in place of `4 pi Re(S(0) / k^2)`.
    MishchenkoYang2018,
}

/// Why a sphere could not be computed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum MieError {
    /// Radius or wavelength is not a length that numbers can carry.
    #[error("{name} {value_m} m is not a length between 1e-30 m and 1e30 m")]
    Length {
        /// `radius` or `wavelength`.
        name: &'static str,
        /// What was given, m.
        value_m: f64,
    },
    /// The real part of an index lies in 1e-6..=1e6, its imaginary part in 0..=1e6.
    #[error(
        "refractive index {re}{im:+}i of the {name}: the real part must lie between 1e-6 and 1e6, the imaginary part between 0 and 1e6"
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
    #[error("size parameter {modulus:e} in the {name} is outside {least:e} to {most:e}")]
    SizeParameter {
        /// `host` or `particle`.
        name: &'static str,
        /// Modulus of the offending size parameter.
        modulus: f64,
        /// Least that is possible.
        least: f64,
        /// Most that is possible.
        most: f64,
    },
    /// The host absorbs so much over one particle that the extinction cross section leaves the range of numbers.
    #[error("the host absorbs exp(-{exponent:.0}) over one particle; beyond exp(-{most:.0}) cross sections overflow")]
    HostAbsorption {
        /// Twice the imaginary part of the size parameter.
        exponent: f64,
        /// Largest exponent that is possible with the definition of scattering in use.
        most: f64,
    },
    /// A layered sphere has from 1 to 1 000 layers.
    #[error("{count} layers: a layered sphere has from 1 to 1000")]
    Layers {
        /// How many there were.
        count: usize,
    },
    /// Layers go from the core outward.
    #[error("layer {layer} has a radius of {radius_m:e} m, no more than the {inside_m:e} m of the one inside it")]
    LayerOrder {
        /// Which layer, the core being 1.
        layer: usize,
        /// Its outer radius, m.
        radius_m: f64,
        /// Outer radius of the layer inside it, m.
        inside_m: f64,
    },
    /// In a host that absorbs much over one particle, what is reflected off its face outweighs the light that gets
    /// through so far that the forward amplitude, in which reflections cancel, is lost to rounding.
    #[error(
        "the host absorbs exp(-{exponent:.0}) over one particle; extinction could only be given with a relative error of \
         {error:.0e}"
    )]
    Cancellation {
        /// Twice the imaginary part of the size parameter.
        exponent: f64,
        /// Relative error that rounding may cause.
        error: f64,
    },
}

/// Which of many spheres could not be computed, and why.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("sphere {index}: {source}")]
pub struct SphereError {
    /// Its place among the spheres given, from 0.
    pub index: usize,
    /// What was wrong.
    pub source: MieError,
}
