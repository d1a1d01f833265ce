//! Cow's milk from what stands on the carton: fat and protein in weight percent.
//!
//! Fat globules and casein micelles in water with riboflavin; `frisvad2007` section 4.1 and `frisvad2012` section 4.4.
//! The arithmetic mean of the fat's volume frequency is taken to be `r_vs`, the casein's mean of `r/(r_max - r)`
//! is `43/107` with a standard deviation of 0.23, both left open there and settled by the published fit
//! ([`published_fit`]).

pub mod published_fit;

use std::borrow::Cow;

use super::{Input, MaterialError};
use crate::medium::{Inclusion, Medium, MediumError};
use crate::particle::{LogNormal, SizeDistribution, TransformedLogNormal, Weighting};
use crate::substance::{Concentration, Conditions, NATURAL_RIBOFLAVIN_MG_PER_100G, Solute, Substance};

/// Density of milk, g/mL, at 20 C (`walstra1984`).
const MILK_DENSITY: f64 = 1.03;
/// Density of milk fat, g/mL.
const FAT_DENSITY: f64 = 0.915;
/// Density of milk protein, g/mL.
const PROTEIN_DENSITY: f64 = 1.11;
/// Part of the protein volume that casein micelles take up (`fox1998`).
const CASEIN_SHARE: f64 = 0.76;
/// Ratio of standard deviation to mean of the fat globules' volume frequency (`walstra1975`).
const FAT_VARIATION: f64 = 0.6;
/// Smallest and largest fat globule, m.
const FAT_RADII: (f64, f64) = (0.005e-6, 10e-6);
/// Largest casein micelle, m (`schmidt1973`).
const CASEIN_MAXIMUM: f64 = 150e-9;
/// Mean radius of casein micelles, m (`schmidt1973`).
const CASEIN_MEAN: f64 = 43e-9;
/// Standard deviation of `r/(r_max - r)` of casein micelles.
const CASEIN_DEVIATION: f64 = 0.23;

/// Milk with its inputs checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Milk {
    fat: f64,
    protein: f64,
    temperature: f64,
    riboflavin: f64,
}

impl Milk {
    /// The inputs, in the order in which [`Self::new`] takes them.
    pub const INPUTS: [Input; 4] = [
        Input {
            name: Cow::Borrowed("fat"),
            unit: Cow::Borrowed("wt.-%"),
            default: 3.5,
            minimum: 0.0,
            maximum: 60.0,
            about: Cow::Borrowed("milk fat, g per 100 g; the size of the globules follows from it"),
        },
        Input {
            name: Cow::Borrowed("protein"),
            unit: Cow::Borrowed("wt.-%"),
            default: 3.4,
            minimum: 0.0,
            maximum: 30.0,
            about: Cow::Borrowed("milk protein, g per 100 g; 76 % of its volume is casein micelles"),
        },
        Input {
            name: Cow::Borrowed("temperature"),
            unit: Cow::Borrowed("degC"),
            default: 20.0,
            minimum: 0.0,
            maximum: 30.0,
            about: Cow::Borrowed("acts on the refractive indices of water and fat"),
        },
        Input {
            name: Cow::Borrowed("riboflavin"),
            unit: Cow::Borrowed("mg/100g"),
            default: NATURAL_RIBOFLAVIN_MG_PER_100G,
            minimum: 0.0,
            maximum: 10.0,
            about: Cow::Borrowed("vitamin B2 dissolved in the water, which absorbs blue"),
        },
    ];

    /// From fat and protein (weight percent), temperature (degrees Celsius) and riboflavin (mg per 100 g).
    ///
    /// # Errors
    /// [`MaterialError::InputRange`] when a value is outside its range in [`Self::INPUTS`].
    pub fn new([fat, protein, temperature, riboflavin]: [f64; 4]) -> Result<Self, MaterialError> {
        for (input, value) in Self::INPUTS.iter().zip([fat, protein, temperature, riboflavin]) {
            input.check(value)?;
        }
        Ok(Self { fat, protein, temperature, riboflavin })
    }

    /// The medium: host, fat globules, casein micelles.
    ///
    /// # Errors
    /// [`MaterialError`] when more fat and protein is asked for than there is room.
    pub fn medium(&self) -> Result<Medium, MaterialError> {
        let water = Substance::named("water", Conditions::at(self.temperature)).map_err(MediumError::from)?;
        let host = if self.riboflavin > 0.0 {
            let amount = Concentration::MilligramsPer100g(self.riboflavin);
            water.with_solutes(vec![Solute::named("riboflavin", amount).map_err(MediumError::from)?])
        } else {
            water
        };
        let mut inclusions = Vec::new();
        if self.fat > 0.0 {
            let fat = Substance::MilkFat { temperature_c: self.temperature };
            let fraction = self.fat / FAT_DENSITY * MILK_DENSITY / 100.0;
            inclusions.push(Inclusion::new("fat globules", fat, fat_sizes(self.fat)?, fraction));
        }
        if self.protein > 0.0 {
            let fraction = CASEIN_SHARE * self.protein / PROTEIN_DENSITY * MILK_DENSITY / 100.0;
            inclusions.push(Inclusion::new("casein micelles", Substance::Casein, casein_sizes()?, fraction));
        }
        Ok(Medium::new(host, inclusions)?)
    }
}

/// Sizes of the fat globules at a fat content in weight percent, above 0 (eq 37-38 of `frisvad2007`, from `olson2004`).
fn fat_sizes(fat: f64) -> Result<SizeDistribution, MaterialError> {
    let r_43 = if fat < 2.0 { -0.2528 * fat * fat + 1.419 * fat } else { 1.456 * fat.powf(0.36) } * 1e-6;
    let r_vs = r_43 / (FAT_VARIATION * FAT_VARIATION + 1.0);
    let sizes = LogNormal::from_mean(Weighting::Volume, r_vs, FAT_VARIATION * r_vs)?;
    Ok(SizeDistribution::LogNormal(sizes.truncated(FAT_RADII.0, FAT_RADII.1)?))
}

/// Sizes of the casein micelles.
fn casein_sizes() -> Result<SizeDistribution, MaterialError> {
    let mean = CASEIN_MEAN / (CASEIN_MAXIMUM - CASEIN_MEAN);
    let sizes = TransformedLogNormal::new(CASEIN_MAXIMUM, mean, CASEIN_DEVIATION)?;
    Ok(SizeDistribution::TransformedLogNormal(sizes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::BulkOptics;
    use crate::spectrum::{WavelengthGrid, stiles_burch1959};

    fn optics(fat: f64, protein: f64, grid: &WavelengthGrid) -> BulkOptics {
        let medium = Milk::new([fat, protein, 20.0, 0.17]).unwrap().medium().unwrap();
        medium.bulk_optics(grid, 1e-5).unwrap()
    }

    /// Reference values at 550 nm, 20 C.
    ///
    /// The absorption of whole milk is what 40-digit arithmetic gives (`benches/oracle/milk_absorption.py`): it is the
    /// difference of extinction and scattering five digits down, where the closed form of eq 24 in double precision is
    /// noise of up to 0.3 per metre (6.08 per metre has been published for it).
    #[test]
    fn whole_and_skimmed_milk_at_550_nm() {
        let grid = WavelengthGrid::new(vec![550e-9]).unwrap();
        for (fat, [sigma_s, sigma_a, g]) in [(3.5, [57837.0, 6.3866, 0.95441]), (0.1, [1282.9, 1.4665, 0.20260])] {
            let b = optics(fat, 3.4, &grid);
            for (value, expected) in [(b.sigma_s()[0], sigma_s), (b.sigma_a()[0], sigma_a), (b.asymmetry()[0], g)] {
                assert!((value / expected - 1.0).abs() < 5e-4, "fat {fat}: {value} against {expected}");
            }
        }
    }

    /// Largest relative differences from the published fit in `sigma_s`, `sigma_a` and `g`, over its three bands.
    fn worst_difference(fat: f64, protein: f64) -> [f64; 3] {
        let grid = WavelengthGrid::frisvad2007();
        let b = optics(fat, protein, &grid);
        let fit = published_fit::published_fit(fat, protein).unwrap();
        let observer = stiles_burch1959();
        let rgb =
            |values: &[f64], weight: &dyn Fn(usize) -> f64| observer.average(&b.spectrum(values).unwrap(), weight);
        let one = |_: usize| 1.0;
        let pairs = [
            (rgb(b.sigma_s(), &one), fit.sigma_s),
            (rgb(b.sigma_a(), &one), fit.sigma_a),
            (rgb(b.asymmetry(), &|i| b.sigma_s()[i]), fit.asymmetry),
        ];
        pairs.map(|(ours, theirs)| (0..3).map(|c| (ours[c] / theirs[c] - 1.0).abs()).fold(0.0, f64::max))
    }

    #[test]
    fn the_published_fit_is_met() {
        for fat in [0.1, 0.3, 0.5, 1.0, 1.5, 2.0, 2.5, 3.5, 5.0, 8.0] {
            let worst = worst_difference(fat, 3.4);
            for (difference, bound) in worst.into_iter().zip([0.045, 0.035, 0.042]) {
                assert!(difference < bound, "fat {fat}: {worst:?}");
            }
        }
        let worst = worst_difference(0.0, 3.4);
        assert!(worst.iter().all(|&d| d < 0.028), "protein alone: {worst:?}");
    }

    #[test]
    fn warm_milk_scatters_less() {
        // Fat loses index faster than water does as milk warms, so the contrast falls.
        let grid = WavelengthGrid::new(vec![550e-9]).unwrap();
        let sigma_s = |temperature| {
            let medium = Milk::new([3.5, 3.4, temperature, 0.17]).unwrap().medium().unwrap();
            medium.bulk_optics(&grid, 1e-4).unwrap().sigma_s()[0]
        };
        assert!(sigma_s(5.0) > sigma_s(30.0));
    }

    #[test]
    fn impossible_cartons_are_refused() {
        for fat in [-1.0, 101.0, f64::NAN] {
            assert!(matches!(Milk::new([fat, 3.4, 20.0, 0.17]), Err(MaterialError::InputRange { .. })), "{fat}");
        }
        let error = Milk::new([-1.0, 3.4, 20.0, 0.17]).unwrap_err();
        assert_eq!(error.to_string(), "fat = -1 wt.-% is out of range: 0 to 60 wt.-%");
    }

    #[test]
    fn milk_without_anything_is_water() {
        let medium = Milk::new([0.0, 0.0, 20.0, 0.0]).unwrap().medium().unwrap();
        assert!(medium.inclusions().is_empty());
        let b = medium.bulk_optics(&WavelengthGrid::frisvad2007(), 1e-4).unwrap();
        assert!(b.sigma_s().iter().all(|&s| s == 0.0) && b.asymmetry().iter().all(|&g| g == 0.0));
    }
}
