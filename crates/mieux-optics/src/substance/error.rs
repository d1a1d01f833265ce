//! What can keep a substance from having an index.

use crate::spectrum::{SpectrumError, nanometres};

/// Why there is no such substance, or none under those conditions, or no index to offer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SubstanceError {
    /// The data does not reach that wavelength, and nothing is extrapolated.
    #[error(
        "wavelength {} nm is outside the data for {substance}, which covers {} nm to {} nm",
        nanometres(*wavelength_m),
        nanometres(range_m.0),
        nanometres(range_m.1)
    )]
    Wavelength {
        /// Name of the substance.
        substance: String,
        /// The wavelength asked for, m.
        wavelength_m: f64,
        /// The wavelengths covered, m.
        range_m: (f64, f64),
    },
    /// Nothing built in has that name.
    #[error("there is no substance called `{name}`")]
    Unknown {
        /// What was asked for.
        name: String,
    },
    /// A temperature or salinity for which nothing is known.
    #[error("{substance}: {condition} {value} {unit} is out of range: {} to {} {unit}", range.0, range.1)]
    Condition {
        /// Name of the substance.
        substance: String,
        /// `temperature` or `salinity`.
        condition: &'static str,
        /// Unit of what was given.
        unit: &'static str,
        /// What was given.
        value: f64,
        /// What may be.
        range: (f64, f64),
    },
    /// A source that gives the real part alone.
    #[error("{substance} comes without an imaginary part k: take another source, or say that it is transparent")]
    NoAbsorption {
        /// Name of the substance.
        substance: String,
    },
    /// A source that gives the imaginary part alone.
    #[error("{substance} comes without a real part n: take another source")]
    NoRealPart {
        /// Name of the substance.
        substance: String,
    },
    /// A real part that no light wave here can have.
    #[error(
        "{substance} has the real part {value} at {} nm; refraction needs a positive finite one",
        nanometres(*wavelength_m)
    )]
    RealPart {
        /// Name of the substance.
        substance: String,
        /// Where, m.
        wavelength_m: f64,
        /// What the source gives there; not a number if the formula has no root there.
        value: f64,
    },
    /// An amount of something dissolved that cannot be.
    #[error("the concentration {value} {unit} of {solute} must be zero or a positive finite number")]
    Concentration {
        /// Name of what is dissolved.
        solute: String,
        /// Unit of what was given.
        unit: &'static str,
        /// What was given.
        value: f64,
    },
    /// Nothing that can be dissolved has that name.
    #[error("there is no solute called `{name}`")]
    UnknownSolute {
        /// What was asked for.
        name: String,
    },
}

/// Why data makes no dispersion.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DispersionError {
    /// A number that names none of the formulas.
    #[error("there is no dispersion formula {number}; the formulas are 1 to 9")]
    Number {
        /// What was given.
        number: u32,
    },
    /// Not as many coefficients as the formula has.
    #[error("formula {number} takes {expected} coefficients, not {given}")]
    Coefficients {
        /// The formula.
        number: u32,
        /// What it takes.
        expected: &'static str,
        /// How many were given.
        given: usize,
    },
    /// A coefficient that is not finite.
    #[error("the coefficient {value} is not a finite number")]
    Coefficient {
        /// What was given.
        value: f64,
    },
    /// A range of wavelengths that is none.
    #[error(
        "the wavelengths {} nm to {} nm are no range of positive lengths",
        nanometres(range_m.0),
        nanometres(range_m.1)
    )]
    Range {
        /// What was given, m.
        range_m: (f64, f64),
    },
    /// A table that is none.
    #[error(transparent)]
    Table(#[from] SpectrumError),
    /// Neither part of the index is given.
    #[error("there is neither a real nor an imaginary part")]
    Empty,
}
