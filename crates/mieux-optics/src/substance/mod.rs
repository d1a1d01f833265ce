//! Complex refractive index of one homogeneous substance, over wavelength and temperature.

mod glass;
mod milk;
mod water;

use num_complex::Complex64;

pub use milk::{NATURAL_RIBOFLAVIN_MG_PER_100G, riboflavin_absorption_index};
pub use water::quan_fry_index;

use crate::spectrum::{Sampled, nanometres};

/// A substance with a refractive index `n' + i n''`, `n'' >= 0` absorbing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Substance {
    /// The same index at every wavelength, as given by the user.
    Constant(Complex64),
    /// Air, taken as vacuum: index 1.
    Air,
    /// Pure water (`quan1995`; absorption `pope1997`, `hale1973`), with riboflavin dissolved in it if wanted.
    Water {
        /// Temperature, degrees Celsius, 0 to 30; acts on the real part.
        temperature_c: f64,
        /// Riboflavin, mg per 100 g of solution; acts on the imaginary part (`du1998`).
        riboflavin_mg_per_100g: f64,
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
}

/// Why a substance has no index to offer.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
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
        substance: &'static str,
        /// The wavelength asked for, m.
        wavelength_m: f64,
        /// The wavelengths covered, m.
        range_m: (f64, f64),
    },
}

impl Substance {
    /// Names under which a recipe can ask for a substance, in alphabetical order; [`Self::named`] knows them all.
    pub const NAMES: [&'static str; 5] = ["air", "casein", "milk-fat", "soda-lime-glass", "water"];

    /// The substance of that name at a temperature in degrees Celsius, or `None` if there is no such name.
    pub fn named(name: &str, temperature_c: f64) -> Option<Self> {
        Some(match name {
            "air" => Self::Air,
            "casein" => Self::Casein,
            "milk-fat" => Self::MilkFat { temperature_c },
            "soda-lime-glass" => Self::SodaLimeGlass,
            "water" => Self::Water { temperature_c, riboflavin_mg_per_100g: 0.0 },
            _ => return None,
        })
    }

    /// What people call it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Constant(_) => "a constant index",
            Self::Air => "air",
            Self::Water { riboflavin_mg_per_100g: 0.0, .. } => "water",
            Self::Water { .. } => "water with riboflavin",
            Self::MilkFat { .. } => "milk fat",
            Self::Casein => "casein",
            Self::SodaLimeGlass => "soda-lime glass",
        }
    }

    /// Refractive index at a vacuum wavelength (m).
    ///
    /// # Errors
    /// [`SubstanceError::Wavelength`] where the data ends.
    pub fn index(&self, wavelength_m: f64) -> Result<Complex64, SubstanceError> {
        let index = match *self {
            Self::Constant(index) => Some(index),
            Self::Air => Some(Complex64::ONE),
            Self::Water { temperature_c, riboflavin_mg_per_100g } => water::index(wavelength_m, temperature_c)
                .and_then(|pure| {
                    let dissolved = riboflavin_absorption_index(wavelength_m, riboflavin_mg_per_100g)?;
                    Some(pure + Complex64::new(0.0, dissolved))
                }),
            Self::MilkFat { temperature_c } => milk::fat_index(wavelength_m, temperature_c),
            Self::Casein => Some(Complex64::new(1.503, 0.0)),
            Self::SodaLimeGlass => glass::soda_lime_index(wavelength_m),
        };
        index.ok_or_else(|| SubstanceError::Wavelength {
            substance: self.name(),
            wavelength_m,
            range_m: self.wavelength_range().unwrap_or((0.0, f64::INFINITY)),
        })
    }

    /// The wavelengths (m) for which there is data; `None` when every wavelength will do.
    pub fn wavelength_range(&self) -> Option<(f64, f64)> {
        let table: &Sampled = match self {
            Self::Constant(_) | Self::Air | Self::Casein => return None,
            Self::Water { .. } => water::absorption(),
            Self::MilkFat { .. } => milk::fat_absorption(),
            Self::SodaLimeGlass => &glass::soda_lime()[0],
        };
        Some(table.grid().range())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_known_and_has_an_index_in_the_visible() {
        for name in Substance::NAMES {
            let substance = Substance::named(name, 20.0).unwrap();
            let n = substance.index(550e-9).unwrap();
            assert!(n.re >= 1.0 && n.im >= 0.0, "{name}: {n}");
        }
        assert_eq!(Substance::named("unobtainium", 20.0), None);
    }

    #[test]
    fn nothing_is_extrapolated() {
        let water = Substance::named("water", 20.0).unwrap();
        let error = water.index(900e-9).unwrap_err();
        assert_eq!(error.to_string(), "wavelength 900 nm is outside the data for water, which covers 375 nm to 775 nm");
        assert!(water.index(374e-9).is_err());
        assert!(water.index(375e-9).is_ok() && water.index(775e-9).is_ok());
    }
}
