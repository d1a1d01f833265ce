//! What is dissolved absorbs in proportion to its concentration (Beer and Lambert) and does not refract.

use std::borrow::Cow;
use std::f64::consts::{LN_10, PI};
use std::sync::{Arc, LazyLock};

use num_complex::Complex64;

use super::Substance;
use super::error::SubstanceError;
use crate::spectrum::{Sampled, embedded_table};

/// Riboflavin in cow's milk, mg per 100 g (`fox1998`).
pub const NATURAL_RIBOFLAVIN_MG_PER_100G: f64 = 0.17;

/// How much of a solute there is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Concentration {
    /// Milligrams in 100 g of solution.
    MilligramsPer100g(f64),
    /// Kilograms in a cubic metre of solution: grams per litre.
    KilogramsPerCubicMetre(f64),
    /// Moles in a cubic metre of solution: millimoles per litre.
    MolesPerCubicMetre(f64),
}

impl Concentration {
    fn value_and_unit(self) -> (f64, &'static str) {
        match self {
            Self::MilligramsPer100g(value) => (value, "mg/100g"),
            Self::KilogramsPerCubicMetre(value) => (value, "kg/m^3"),
            Self::MolesPerCubicMetre(value) => (value, "mol/m^3"),
        }
    }
}

/// In which logarithm a molar absorption is given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Logarithm {
    /// `log10(I0/I) = epsilon c d`, as chemists tabulate: L/(mol cm) is 0.1 m2/mol.
    Decadic,
    /// `ln(I0/I) = kappa c d`.
    Napierian,
}

/// Absorption by what is dissolved.
#[derive(Debug, Clone, PartialEq)]
enum Absorption {
    /// Imaginary part that it adds to the index, times a factor.
    Index(&'static Sampled, f64),
    /// Napierian molar absorption (m2/mol), times moles in a cubic metre.
    Molar(Sampled, f64),
}

/// Something dissolved, and how much of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Solute {
    name: String,
    concentration: Concentration,
    absorption: Absorption,
}

impl Solute {
    /// Names of the solutes that come with the program; [`Self::named`] knows them all.
    pub const NAMES: [&'static str; 1] = ["riboflavin"];

    /// Molar mass of riboflavin, kg/mol.
    const RIBOFLAVIN: f64 = 0.376_36;
    /// Density (kg/m3) at which amounts by mass of solution are converted: that of water at 20 degrees Celsius.
    const WATER: f64 = 998.2;

    /// The solute of that name: `riboflavin` (vitamin B2; `du1998` as table 4.2 of `frisvad2012`, 375-775 nm).
    ///
    /// # Errors
    /// [`SubstanceError::UnknownSolute`] or [`SubstanceError::Concentration`].
    pub fn named(name: &str, concentration: Concentration) -> Result<Self, SubstanceError> {
        if name != "riboflavin" {
            return Err(SubstanceError::UnknownSolute { name: name.into() });
        }
        Self::check(name, concentration)?;
        let mg_per_100g = match concentration {
            Concentration::MilligramsPer100g(value) => value,
            // A milligram in 100 g is a hundred-thousandth of the mass.
            Concentration::KilogramsPerCubicMetre(value) => value / Self::WATER * 1e5,
            Concentration::MolesPerCubicMetre(value) => value * Self::RIBOFLAVIN / Self::WATER * 1e5,
        };
        let absorption = Absorption::Index(riboflavin(), mg_per_100g / NATURAL_RIBOFLAVIN_MG_PER_100G);
        Ok(Self { name: name.into(), concentration, absorption })
    }

    /// A solute of your own: its molar absorption (m2/mol) over wavelength, which logarithm that is of, and moles in a
    /// cubic metre of solution.
    ///
    /// # Errors
    /// [`SubstanceError::Concentration`].
    pub fn from_molar_absorption(
        name: impl Into<String>,
        molar_absorption: Sampled,
        logarithm: Logarithm,
        moles_per_cubic_metre: f64,
    ) -> Result<Self, SubstanceError> {
        let (name, concentration) = (name.into(), Concentration::MolesPerCubicMetre(moles_per_cubic_metre));
        Self::check(&name, concentration)?;
        let factor = match logarithm {
            Logarithm::Decadic => LN_10,
            Logarithm::Napierian => 1.0,
        };
        let absorption = Absorption::Molar(molar_absorption, factor * moles_per_cubic_metre);
        Ok(Self { name, concentration, absorption })
    }

    fn check(name: &str, concentration: Concentration) -> Result<(), SubstanceError> {
        let (value, unit) = concentration.value_and_unit();
        if value >= 0.0 && value.is_finite() {
            return Ok(());
        }
        Err(SubstanceError::Concentration { solute: name.into(), unit, value })
    }

    /// What people call it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How much of it there is, and the unit.
    pub fn amount(&self) -> (f64, &'static str) {
        self.concentration.value_and_unit()
    }

    /// What it adds to the imaginary part of the index at a wavelength in metres; `None` beyond its data unless there is
    /// none of it.
    pub fn absorption_index(&self, wavelength_m: f64) -> Option<f64> {
        match &self.absorption {
            Absorption::Index(_, 0.0) | Absorption::Molar(_, 0.0) => Some(0.0),
            Absorption::Index(table, amount) => Some(table.at(wavelength_m)? * amount),
            Absorption::Molar(table, amount) => Some(table.at(wavelength_m)? * amount * wavelength_m / (4.0 * PI)),
        }
    }

    fn wavelength_range(&self) -> Option<(f64, f64)> {
        match &self.absorption {
            Absorption::Index(_, 0.0) | Absorption::Molar(_, 0.0) => None,
            Absorption::Index(table, _) => Some(table.grid().range()),
            Absorption::Molar(table, _) => Some(table.grid().range()),
        }
    }
}

/// A solvent with things dissolved in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    solvent: Substance,
    solutes: Vec<Solute>,
}

impl Solution {
    pub(super) fn of(solvent: Substance, solutes: Vec<Solute>) -> Substance {
        if solutes.is_empty() { solvent } else { Substance::Solution(Arc::new(Self { solvent, solutes })) }
    }

    /// What they are dissolved in.
    pub fn solvent(&self) -> &Substance {
        &self.solvent
    }

    /// What is dissolved.
    pub fn solutes(&self) -> &[Solute] {
        &self.solutes
    }

    pub(super) fn name(&self) -> Cow<'_, str> {
        let names: Vec<&str> = self.solutes.iter().map(Solute::name).collect();
        format!("{} with {}", self.solvent.name(), names.join(" and ")).into()
    }

    pub(super) fn describe(&self) -> String {
        let solutes = self.solutes.iter().map(|solute| {
            let (amount, unit) = solute.amount();
            format!("{amount} {unit} {}", solute.name())
        });
        format!("{} with {}", self.solvent.describe(), solutes.collect::<Vec<_>>().join(" and "))
    }

    pub(super) fn wavelength_range(&self) -> Option<(f64, f64)> {
        let solutes = self.solutes.iter().filter_map(Solute::wavelength_range);
        self.solvent.wavelength_range().into_iter().chain(solutes).reduce(|a, b| (a.0.max(b.0), a.1.min(b.1)))
    }

    pub(super) fn index(&self, wavelength_m: f64) -> Option<Result<Complex64, SubstanceError>> {
        let dissolved: f64 =
            self.solutes.iter().map(|solute| solute.absorption_index(wavelength_m)).sum::<Option<_>>()?;
        Some(self.solvent.index(wavelength_m).map(|pure| pure + Complex64::new(0.0, dissolved)))
    }
}

/// What [`NATURAL_RIBOFLAVIN_MG_PER_100G`] adds to the imaginary part of the index of water.
fn riboflavin() -> &'static Sampled {
    static TABLE: LazyLock<Sampled> = LazyLock::new(|| {
        let [n_imag] = embedded_table(include_str!("../../../../data/substances/riboflavin-absorption.csv"));
        n_imag
    });
    &TABLE
}

#[cfg(test)]
mod tests {
    use super::super::Water;
    use super::*;
    use crate::spectrum::WavelengthGrid;

    fn with(concentration: Concentration) -> Solute {
        Solute::named("riboflavin", concentration).unwrap()
    }

    #[test]
    fn riboflavin_is_proportional_to_its_concentration() {
        let natural = with(Concentration::MilligramsPer100g(0.17)).absorption_index(450e-9).unwrap();
        assert!((natural - 4.096e-7).abs() < 1e-20);
        let twice = with(Concentration::MilligramsPer100g(0.34)).absorption_index(450e-9).unwrap();
        assert!((twice - 2.0 * natural).abs() < 1e-20);
        assert_eq!(with(Concentration::MilligramsPer100g(0.0)).absorption_index(900e-9), Some(0.0));
        assert_eq!(with(Concentration::MilligramsPer100g(0.1)).absorption_index(900e-9), None);
        // 1.7 mg/L is 4.52 umol/L; in water that is 0.1703 mg per 100 g.
        for same in [Concentration::KilogramsPerCubicMetre(1.7e-3), Concentration::MolesPerCubicMetre(4.517e-3)] {
            let ratio = with(same).absorption_index(450e-9).unwrap() / natural;
            assert!((ratio - 1.0018).abs() < 2e-4, "{same:?}: {ratio}");
        }
    }

    #[test]
    fn riboflavin_absorbs_as_chemists_say() {
        // 12 200 L/(mol cm), decadic, at 445 nm (`fox1998` has it near 450); the table is within 20 %.
        let index = with(Concentration::MolesPerCubicMetre(1.0)).absorption_index(445e-9).unwrap();
        let decadic = 4.0 * PI * index / 445e-9 / LN_10 * 10.0;
        assert!((decadic / 12_200.0 - 1.0).abs() < 0.2, "{decadic}");
    }

    #[test]
    fn solutes_of_your_own_absorb_by_beer_and_lambert() {
        let grid = WavelengthGrid::new(vec![400e-9, 600e-9]).unwrap();
        let table = Sampled::new(grid, vec![100.0, 100.0]).unwrap();
        // 1000 L/(mol cm) decadic is 100 m2/mol; 1 mmol/L then absorbs ln(10) * 100 per metre.
        let dye = Solute::from_molar_absorption("dye", table.clone(), Logarithm::Decadic, 1.0).unwrap();
        let absorption = 4.0 * PI * dye.absorption_index(500e-9).unwrap() / 500e-9;
        assert!((absorption - 230.258_509_3).abs() < 1e-6);
        let same = Solute::from_molar_absorption("dye", table, Logarithm::Napierian, 1.0).unwrap();
        assert!(
            (same.absorption_index(500e-9).unwrap() * LN_10 / dye.absorption_index(500e-9).unwrap() - 1.0).abs()
                < 1e-12
        );

        let solution = Solution::of(Substance::Water(Water::ROOM), vec![dye]);
        let pure = Substance::Water(Water::ROOM).index(500e-9).unwrap();
        let stained = solution.index(500e-9).unwrap();
        assert_eq!(stained.re, pure.re);
        let added = 230.258_509_3 * 500e-9 / (4.0 * PI);
        assert!(((stained.im - pure.im) / added - 1.0).abs() < 1e-9);
        assert_eq!(solution.describe(), "water with 1 mol/m^3 dye");
        let error = solution.index(380e-9).unwrap_err().to_string();
        assert_eq!(error, "wavelength 380 nm is outside the data for water with dye, which covers 400 nm to 600 nm");
    }

    #[test]
    fn impossible_amounts_are_refused() {
        for value in [-1.0, f64::NAN, f64::INFINITY] {
            let error = Solute::named("riboflavin", Concentration::MilligramsPer100g(value)).unwrap_err();
            assert!(matches!(error, SubstanceError::Concentration { .. }));
        }
        let unknown = Solute::named("ink", Concentration::MilligramsPer100g(1.0));
        assert!(matches!(unknown, Err(SubstanceError::UnknownSolute { .. })));
    }
}
