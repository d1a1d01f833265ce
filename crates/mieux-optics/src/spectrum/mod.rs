//! Wavelength grids, sampled spectra, observers and illuminants, colour.

pub mod colour;
mod grid;
mod lab;
mod sampled;
mod table;
pub mod upsample;

mod observer;

pub use grid::WavelengthGrid;
pub use lab::Lab;
pub use observer::{ColourMatching, cie1931, d65, stiles_burch1959};
pub use sampled::Sampled;
pub(crate) use table::embedded_table;

/// A wavelength in nanometres as people write it: twelve significant digits at most, so that a round number stays round.
pub(crate) fn nanometres(wavelength_m: f64) -> f64 {
    format!("{:.11e}", wavelength_m * 1e9).parse().unwrap_or(f64::NAN)
}

/// What can be wrong with a grid or a sampled spectrum.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SpectrumError {
    /// A grid or spectrum needs at least one sample.
    #[error("a spectrum needs at least one wavelength")]
    Empty,
    /// A wavelength is not a positive finite number.
    #[error("wavelength {wavelength_m} m is not a positive finite length")]
    Wavelength {
        /// The offending wavelength, m.
        wavelength_m: f64,
    },
    /// Wavelengths must rise strictly.
    #[error(
        "wavelengths must increase, but {} nm follows {} nm",
        nanometres(*after_m),
        nanometres(*before_m)
    )]
    NotIncreasing {
        /// The earlier wavelength, m.
        before_m: f64,
        /// The one that should have been larger, m.
        after_m: f64,
    },
    /// A value is not finite.
    #[error("the value {value} at {} nm is not finite", nanometres(*wavelength_m))]
    Value {
        /// Where, m.
        wavelength_m: f64,
        /// What was found there.
        value: f64,
    },
    /// There are not as many values as wavelengths.
    #[error("{wavelengths} wavelengths but {values} values")]
    Length {
        /// Number of wavelengths.
        wavelengths: usize,
        /// Number of values.
        values: usize,
    },
    /// A regular grid with a step that is not positive, or with more than [`WavelengthGrid::MAX_LEN`] points.
    #[error(
        "no grid runs from {} nm to {} nm in steps of {} nm",
        nanometres(*start_m),
        nanometres(*stop_m),
        nanometres(*step_m)
    )]
    Regular {
        /// First wavelength, m.
        start_m: f64,
        /// Last wavelength, m.
        stop_m: f64,
        /// Step, m.
        step_m: f64,
    },
}
