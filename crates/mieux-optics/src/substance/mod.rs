//! Complex refractive index of one homogeneous substance, over wavelength, temperature and salinity.
//!
//! [`Substance::named`] knows what comes with the program; [`Dispersion`] holds tables and formulas of your own;
//! [`Solute`] stains a solvent.

mod brine;
mod builtin;
mod catalogue;
mod dispersion;
mod error;
mod glass;
mod milk;
mod solution;
mod water;

use std::borrow::Cow;
use std::sync::Arc;

use num_complex::Complex64;

pub use brine::{BRINE_TEMPERATURES, brine_salinity};
pub use catalogue::{Conditions, SubstanceEntry};
pub use dispersion::{Dispersion, Formula, Note, Piece, tables, without_gain};
pub use error::{DispersionError, SubstanceError};
pub use solution::{Concentration, Logarithm, NATURAL_RIBOFLAVIN_MG_PER_100G, Solute, Solution};
pub use water::{Water, WaterAbsorption, quan_fry_index};

/// A substance with a refractive index `n' + i n''`, `n'' >= 0` absorbing. Cheap to clone.
#[derive(Debug, Clone, PartialEq)]
pub enum Substance {
    /// The same index at every wavelength, as given by the user.
    Constant(Complex64),
    /// Air, taken as vacuum: index 1.
    Air,
    /// Water, fresh or salt.
    Water(Water),
    /// Brine in equilibrium with ice ([`brine_salinity`]).
    SeaIceBrine {
        /// Temperature, degrees Celsius, within [`BRINE_TEMPERATURES`].
        temperature_c: f64,
    },
    /// Milk fat (`walstra1984`, absorption `michalski2001`).
    MilkFat {
        /// Temperature, degrees Celsius.
        temperature_c: f64,
    },
    /// Casein micelles: 1.503, no absorption (`attaie2000`).
    Casein,
    /// Low-iron soda-lime glass (`rubin1985`).
    SodaLimeGlass,
    /// Tables and formulas.
    Dispersive(Arc<Dispersion>),
    /// A solvent with things dissolved in it.
    Solution(Arc<Solution>),
}

impl From<Dispersion> for Substance {
    fn from(dispersion: Dispersion) -> Self {
        Self::Dispersive(Arc::new(dispersion))
    }
}

impl Substance {
    /// Names under which a recipe can ask for a substance, in alphabetical order; [`Self::named`] knows them all, and
    /// [`SubstanceEntry`] says what they are.
    pub const NAMES: [&'static str; SubstanceEntry::ALL.len()] = {
        let mut names = [""; SubstanceEntry::ALL.len()];
        let mut i = 0;
        while i < names.len() {
            names[i] = SubstanceEntry::ALL[i].name;
            i += 1;
        }
        names
    };

    /// The substance of that name under conditions; those that do not act on it may be anything.
    ///
    /// # Errors
    /// [`SubstanceError::Unknown`], or [`SubstanceError::Condition`] where nothing is known.
    pub fn named(name: &str, conditions: Conditions) -> Result<Self, SubstanceError> {
        let entry = SubstanceEntry::named(name).ok_or_else(|| SubstanceError::Unknown { name: name.into() })?;
        entry.substance(conditions)
    }

    /// This substance with things dissolved in it.
    #[must_use]
    pub fn with_solutes(self, solutes: Vec<Solute>) -> Self {
        Solution::of(self, solutes)
    }

    /// What people call it.
    pub fn name(&self) -> Cow<'_, str> {
        match self {
            Self::Constant(_) => "a constant index".into(),
            Self::Air => "air".into(),
            Self::Water(water) if water.salinity() > 0.0 => "salt water".into(),
            Self::Water(_) => "water".into(),
            Self::SeaIceBrine { .. } => "brine".into(),
            Self::MilkFat { .. } => "milk fat".into(),
            Self::Casein => "casein".into(),
            Self::SodaLimeGlass => "soda-lime glass".into(),
            Self::Dispersive(dispersion) => dispersion.name().into(),
            Self::Solution(solution) => solution.name(),
        }
    }

    /// What it is, with the amounts of what is dissolved in it.
    pub fn describe(&self) -> String {
        match self {
            Self::Solution(solution) => solution.describe(),
            other => other.name().into_owned(),
        }
    }

    /// What had to be put right in its data.
    pub fn notes(&self) -> &[Note] {
        match self {
            Self::Dispersive(dispersion) => dispersion.notes(),
            Self::Solution(solution) => solution.solvent().notes(),
            _ => &[],
        }
    }

    /// Refractive index at a vacuum wavelength (m).
    ///
    /// # Errors
    /// [`SubstanceError::Wavelength`] where the data ends; with data of one's own also [`SubstanceError::NoAbsorption`],
    /// [`SubstanceError::NoRealPart`] and [`SubstanceError::RealPart`].
    pub fn index(&self, wavelength_m: f64) -> Result<Complex64, SubstanceError> {
        let index = match self {
            Self::Constant(index) => Some(*index),
            Self::Air => Some(Complex64::ONE),
            Self::Water(water) => water.index(wavelength_m),
            Self::SeaIceBrine { temperature_c } => brine::index(wavelength_m, *temperature_c),
            Self::MilkFat { temperature_c } => milk::fat_index(wavelength_m, *temperature_c),
            Self::Casein => Some(Complex64::new(1.503, 0.0)),
            Self::SodaLimeGlass => glass::soda_lime_index(wavelength_m),
            Self::Dispersive(dispersion) => return dispersion.index(wavelength_m),
            Self::Solution(solution) => solution.index(wavelength_m).transpose()?,
        };
        index.ok_or_else(|| SubstanceError::Wavelength {
            substance: self.name().into_owned(),
            wavelength_m,
            range_m: self.wavelength_range().unwrap_or((0.0, f64::INFINITY)),
        })
    }

    /// The wavelengths (m) for which there is data; `None` when every wavelength will do, an empty range (first above
    /// second) when there is none.
    pub fn wavelength_range(&self) -> Option<(f64, f64)> {
        match self {
            Self::Constant(_) | Self::Air | Self::Casein => None,
            Self::Water(water) => Some(water.wavelength_range()),
            Self::SeaIceBrine { .. } => Some(water::pure_absorption().grid().range()),
            Self::MilkFat { .. } => Some(milk::fat_absorption().grid().range()),
            Self::SodaLimeGlass => Some(glass::soda_lime()[0].grid().range()),
            Self::Dispersive(dispersion) => Some(dispersion.wavelength_range()),
            Self::Solution(solution) => solution.wavelength_range(),
        }
    }
}

/// The error for a condition outside its range; `name` is who says so.
fn within(
    name: impl FnOnce() -> String,
    condition: &'static str,
    unit: &'static str,
    value: f64,
    range: (f64, f64),
) -> Result<(), SubstanceError> {
    if value >= range.0 && value <= range.1 {
        return Ok(());
    }
    Err(SubstanceError::Condition { substance: name(), condition, unit, value, range })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_extrapolated() {
        let water = Substance::named("water", Conditions::default()).unwrap();
        let error = water.index(900e-9).unwrap_err();
        assert_eq!(error.to_string(), "wavelength 900 nm is outside the data for water, which covers 375 nm to 775 nm");
        assert!(water.index(374e-9).is_err());
        assert!(water.index(375e-9).is_ok() && water.index(775e-9).is_ok());
    }
}
