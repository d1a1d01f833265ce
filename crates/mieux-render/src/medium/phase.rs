//! How a medium scatters over angle, at the wavelengths of a path.

use std::sync::Arc;

use mieux_optics::phase::{HenyeyGreenstein, PhaseFunction, PhaseMixture, SpectralPhase};
use mieux_optics::spectrum::Sampled;

use super::{Dense, MediumError};
use crate::integrator::{LANES, Lanes};

/// A phase function over wavelength.
#[derive(Debug, Clone, PartialEq)]
pub enum Phase {
    /// Henyey-Greenstein of a mean cosine over wavelength, -1 < g < 1.
    HenyeyGreenstein(Sampled),
    /// The same at all wavelengths.
    Function(Arc<PhaseFunction>),
    /// One at each of many wavelengths, which must reach over those that are rendered.
    Spectral(Arc<SpectralPhase>),
}

/// A phase function that can be asked at any rendered wavelength.
#[derive(Debug, Clone)]
pub(crate) enum DensePhase {
    HenyeyGreenstein(Dense),
    Function(Arc<PhaseFunction>),
    Spectral(Arc<SpectralPhase>),
}

/// A phase function at the wavelengths of a path.
#[derive(Debug, Clone, Copy)]
pub(crate) enum PhaseLanes<'a> {
    HenyeyGreenstein(Lanes),
    Function(&'a PhaseFunction),
    Spectral([PhaseMixture<'a>; LANES]),
}

impl DensePhase {
    pub(crate) fn new(phase: &Phase, range: (f64, f64)) -> Result<Self, MediumError> {
        Ok(match phase {
            Phase::HenyeyGreenstein(g) => {
                let valid = |v| v > -1.0 && v < 1.0;
                Self::HenyeyGreenstein(Dense::new("g", g, range, "must lie between -1 and 1", valid)?)
            }
            Phase::Function(function) => Self::Function(function.clone()),
            Phase::Spectral(spectral) => {
                if spectral.at(range.0).is_none() || spectral.at(range.1).is_none() {
                    let known_m = spectral.grid().range();
                    return Err(MediumError::Range { what: "the phase function", known_m, asked_m: range });
                }
                Self::Spectral(spectral.clone())
            }
        })
    }

    /// The mean cosine at a wavelength (m).
    pub(crate) fn asymmetry(&self, wavelength: f64) -> f64 {
        match self {
            Self::HenyeyGreenstein(g) => g.at(wavelength),
            Self::Function(function) => function.asymmetry(),
            Self::Spectral(spectral) => spectral.asymmetry(wavelength).unwrap_or(0.0),
        }
    }

    pub(crate) fn lanes(&self, wavelengths: &Lanes) -> PhaseLanes<'_> {
        match self {
            Self::HenyeyGreenstein(g) => PhaseLanes::HenyeyGreenstein(g.lanes(wavelengths)),
            Self::Function(function) => PhaseLanes::Function(function),
            Self::Spectral(spectral) => {
                let at = wavelengths.map(|w| spectral.at(w));
                match at {
                    [Some(a), Some(b), Some(c), Some(d)] => PhaseLanes::Spectral([a, b, c, d]),
                    // Paths draw their wavelengths within the range that was checked.
                    _ => PhaseLanes::HenyeyGreenstein([0.0; LANES]),
                }
            }
        }
    }
}

impl PhaseLanes<'_> {
    /// Values per steradian at a scattering cosine.
    #[inline]
    pub(crate) fn values(&self, mu: f64) -> Lanes {
        match self {
            Self::HenyeyGreenstein(g) => g.map(|g| henyey_greenstein(g, mu)),
            Self::Function(function) => [function.value(mu); LANES],
            Self::Spectral(at) => std::array::from_fn(|k| at[k].value(mu)),
        }
    }

    /// A scattering cosine of the hero's, from a uniform number.
    #[inline]
    pub(crate) fn sample(&self, xi: f64) -> f64 {
        match self {
            Self::HenyeyGreenstein(g) => HenyeyGreenstein::new(g[0]).map_or(2.0 * xi - 1.0, |phase| phase.sample(xi)),
            Self::Function(function) => function.sample(xi),
            Self::Spectral(at) => at[0].sample(xi),
        }
    }
}

#[inline]
fn henyey_greenstein(g: f64, mu: f64) -> f64 {
    let base = 1.0 + g * g - 2.0 * g * mu;
    0.25 * std::f64::consts::FRAC_1_PI * (1.0 - g * g) / (base * base.sqrt())
}
