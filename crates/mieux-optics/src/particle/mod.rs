//! How large the particles of an inclusion are, and of what shape.

mod gamma;
mod log_normal;
mod mixture;
mod modified_gamma;
mod moments;
mod power_law;
mod rosin_rammler;
mod shape;
mod smooth;
mod tabulated;
mod transformed_log_normal;
mod weighting;

use std::f64::consts::PI;

pub use gamma::Gamma;
pub use log_normal::LogNormal;
pub use mixture::MixedSizes;
pub use modified_gamma::ModifiedGamma;
pub use moments::{Summary, WeightedSummary};
pub use power_law::PowerLaw;
pub use rosin_rammler::RosinRammler;
pub use shape::{AspectRatio, Equivalence, Form, Shape};
pub(crate) use smooth::Smooth;
pub use tabulated::TabulatedSizes;
pub use transformed_log_normal::TransformedLogNormal;
pub use weighting::Weighting;

/// What can be wrong with a size distribution or a shape. All lengths in metres.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ParticleError {
    /// A radius or a width must be a positive finite number.
    #[error("{name} {value} must be positive and finite")]
    NotPositive {
        /// Which parameter.
        name: &'static str,
        /// What was given, SI.
        value: f64,
    },
    /// A geometric standard deviation is a ratio above 1.
    #[error("geometric standard deviation {value} must be above 1")]
    GeometricDeviation {
        /// What was given.
        value: f64,
    },
    /// An effective variance lies between 0 and 0.5.
    #[error("effective variance {value} must lie between 0 and 0.5, or the distribution cannot be normalised")]
    EffectiveVariance {
        /// What was given.
        value: f64,
    },
    /// An exponent that no power law of this world has.
    #[error("exponent {value} must lie between -100 and 100")]
    Exponent {
        /// What was given.
        value: f64,
    },
    /// Too many particles are vanishingly small for the integral of a power of the radius.
    #[error(
        "the distribution cannot be normalised by {}: too many particles are vanishingly small; a minimum radius would do",
        quantity(*power)
    )]
    Diverges {
        /// The power.
        power: f64,
    },
    /// The smallest radius must lie below the largest.
    #[error("radii from {minimum_m:e} m to {maximum_m:e} m: the minimum must be at least 0 and below the maximum")]
    Limits {
        /// Lower limit, m.
        minimum_m: f64,
        /// Upper limit, m.
        maximum_m: f64,
    },
    /// Nothing of the distribution lies between its limits, so it cannot be normalised.
    #[error("no particles between {minimum_m:e} m and {maximum_m:e} m: the distribution cannot be normalised")]
    Empty {
        /// Lower limit, m.
        minimum_m: f64,
        /// Upper limit, m.
        maximum_m: f64,
    },
    /// A table with nothing in it.
    #[error("every density or count is 0: the distribution cannot be normalised")]
    EmptyTable,
    /// A row of a table that makes no sense.
    #[error("row {} of the size distribution, {value}: {problem}", row + 1)]
    Table {
        /// Which row, from 0.
        row: usize,
        /// What was given.
        value: f64,
        /// What would do.
        problem: &'static str,
    },
    /// A table whose columns do not go together.
    #[error(
        "{radii} radii with {values} values: {}",
        if *bins { "bins have one edge more than counts" } else { "at least two rows, and as many of one as of the other" }
    )]
    TableLength {
        /// Number of radii or edges.
        radii: usize,
        /// Number of densities or counts.
        values: usize,
        /// Whether it is a table of bins.
        bins: bool,
    },
    /// Shares of a sum that do not add up to anything.
    #[error("share {value} of a sum of size distributions: shares must not be negative, and some must be positive")]
    Shares {
        /// The share, or their sum.
        value: f64,
    },
}

/// What the integral of a power of the radius stands for.
fn quantity(power: f64) -> String {
    match Weighting::ALL.into_iter().find(|w| w.power() == power) {
        Some(weighting) => weighting.to_string(),
        None => format!("the power {power} of the radius"),
    }
}

/// The sizes of one kind of particle: radii of spheres, or lengths along the axis where they have another [`Shape`].
#[derive(Debug, Clone, PartialEq)]
pub enum SizeDistribution {
    /// One radius for all, m.
    Monodisperse {
        /// Radius, m.
        radius_m: f64,
    },
    /// Logarithm of the radius normally distributed.
    LogNormal(LogNormal),
    /// Gamma distribution by effective radius and variance.
    Gamma(Gamma),
    /// Modified gamma distribution, as found for fogs and clouds.
    ModifiedGamma(ModifiedGamma),
    /// Power law between two radii.
    PowerLaw(PowerLaw),
    /// Weibull's distribution by volume, as of powders and sprays.
    RosinRammler(RosinRammler),
    /// `r / (r_max - r)` log-normally distributed, as found for casein micelles.
    TransformedLogNormal(TransformedLogNormal),
    /// As measured.
    Tabulated(TabulatedSizes),
    /// Several together.
    Mixture(MixedSizes),
}

/// A part of a distribution, and its share of the volume.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part<'a> {
    pub share: f64,
    pub sizes: Spread<'a>,
}

/// One radius (m), or a density.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Spread<'a> {
    One(f64),
    Smooth(&'a dyn Smooth),
}

impl SizeDistribution {
    /// All particles of one radius (m).
    ///
    /// # Errors
    /// [`ParticleError::NotPositive`].
    pub fn monodisperse(radius_m: f64) -> Result<Self, ParticleError> {
        Ok(Self::Monodisperse { radius_m: positive("radius", radius_m)? })
    }

    /// The parts that it is put together of; their shares add up to 1.
    pub(crate) fn parts(&self) -> Vec<Part<'_>> {
        let smooth: &dyn Smooth = match self {
            Self::Monodisperse { radius_m } => return vec![Part { share: 1.0, sizes: Spread::One(*radius_m) }],
            Self::Mixture(mix) => {
                let parts = mix.parts().iter().map(|(share, sizes)| (share, sizes.parts()));
                return parts
                    .flat_map(|(share, parts)| parts.into_iter().map(move |p| Part { share: share * p.share, ..p }))
                    .collect();
            }
            Self::LogNormal(d) => d,
            Self::Gamma(d) => d,
            Self::ModifiedGamma(d) => d,
            Self::PowerLaw(d) => d,
            Self::RosinRammler(d) => d,
            Self::TransformedLogNormal(d) => d,
            Self::Tabulated(d) => d,
        };
        vec![Part { share: 1.0, sizes: Spread::Smooth(smooth) }]
    }
}

fn positive(name: &'static str, value: f64) -> Result<f64, ParticleError> {
    if value > 0.0 && value.is_finite() { Ok(value) } else { Err(ParticleError::NotPositive { name, value }) }
}

fn check_limits(minimum_m: f64, maximum_m: f64) -> Result<(), ParticleError> {
    if minimum_m >= 0.0 && maximum_m > minimum_m { Ok(()) } else { Err(ParticleError::Limits { minimum_m, maximum_m }) }
}

/// Volume of a sphere of the given radius (m), m^3.
pub fn sphere_volume(radius_m: f64) -> f64 {
    4.0 / 3.0 * PI * radius_m.powi(3)
}
