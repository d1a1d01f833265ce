//! Paints by two constants: K and S of each over wavelength, mixed in proportion to their amounts (`duncan1940`).
//!
//! # What can be known
//! An opaque sample shows K/S alone. Of one paint by itself nothing more follows; of its mixture with another, how its S
//! compares with that of the other. So opaque samples never tell the unit of S: one paint, the *reference*, usually white, has
//! S = 1 at every wavelength, and all K and S are relative to that. Where a paint by itself is so dark that the surface is
//! all that is seen, even K/S is known within a factor only. [`fit`] says how well each number is known.
//!
//! Amounts are what the recipes count, by volume or by weight, as long as all count the same.

mod chain;
mod fit;
mod matching;
mod set;

pub use fit::{FitOptions, Leftover, PaintFit, Surface, fit};
pub use matching::{Match, Target, find_recipe};
pub use set::{Paint, PaintSet};

use crate::spectrum::{SpectrumError, WavelengthGrid};
use crate::transfer::kubelka_munk::KubelkaMunkError;

/// Why measurements, a recipe or a target were refused. Carries the offending value.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PaintError {
    /// A reflectance that cannot be.
    #[error("sample `{sample}`: the reflectance {value} at {wavelength_nm} nm is not between 0 and 1 (both excluded)")]
    Reflectance {
        /// Name of the sample.
        sample: String,
        /// Where, nm.
        wavelength_nm: f64,
        /// The offending value.
        value: f64,
    },
    /// A sample without a value for every wavelength.
    #[error("sample `{sample}` has {found} reflectances for {expected} wavelengths")]
    Length {
        /// Name of the sample.
        sample: String,
        /// How many it has.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// Measurements at other wavelengths.
    #[error(
        "`{sample}` and those after it are not measured at the wavelengths of those before; measure or resample all alike"
    )]
    Wavelengths {
        /// Name of the first sample that differs.
        sample: String,
    },
    /// An amount that cannot be.
    #[error("the amount {value} of `{paint}` is not a finite number from 0 up")]
    Amount {
        /// Name of the paint.
        paint: String,
        /// The offending value.
        value: f64,
    },
    /// A recipe of nothing.
    #[error("a recipe needs an amount above 0 of at least one paint")]
    Nothing,
    /// A paint twice in one recipe.
    #[error("`{paint}` is there twice")]
    Twice {
        /// Name of the paint.
        paint: String,
    },
    /// A paint that is not known.
    #[error("no paint called `{paint}`")]
    Unknown {
        /// Its name.
        paint: String,
    },
    /// The reference is not among the paints, or nothing was measured.
    #[error("there is nothing to fit: {why}")]
    NothingToFit {
        /// Why.
        why: &'static str,
    },
    /// A sample that its surface does not allow.
    #[error("sample `{sample}` at {wavelength_nm} nm: {source}")]
    Surface {
        /// Name of the sample.
        sample: String,
        /// Where, nm.
        wavelength_nm: f64,
        /// What is wrong.
        source: KubelkaMunkError,
    },
    /// Number of paints in a recipe that is looked for.
    #[error("a recipe of at most {value} paints: between 1 and 6 can be looked for")]
    AtMost {
        /// The offending number.
        value: usize,
    },
    /// A fit whose equations cannot be solved.
    #[error("the fit fails: the equations of {unknowns} unknowns at a wavelength have no solution")]
    Singular {
        /// How many.
        unknowns: usize,
    },
    /// A thickness where S has no unit.
    #[error("K and S of these paints are relative to `{reference}`, so a film of some thickness cannot be told")]
    Relative {
        /// The reference.
        reference: String,
    },
    /// A film or a surface.
    #[error(transparent)]
    Film(#[from] KubelkaMunkError),
    /// A spectrum.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
}

/// Paints and their amounts, as shares of the whole: not negative, and 1 together.
#[derive(Debug, Clone, PartialEq)]
pub struct Recipe(Vec<(String, f64)>);

impl Recipe {
    /// From names and amounts in any unit, in order; amounts of 0 are left out.
    ///
    /// # Errors
    /// [`PaintError::Amount`], [`PaintError::Twice`] or [`PaintError::Nothing`].
    pub fn new(parts: impl IntoIterator<Item = (String, f64)>) -> Result<Self, PaintError> {
        let mut kept: Vec<(String, f64)> = Vec::new();
        for (paint, value) in parts {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(PaintError::Amount { paint, value });
            }
            if kept.iter().any(|(name, _)| *name == paint) {
                return Err(PaintError::Twice { paint });
            }
            kept.push((paint, value));
        }
        kept.retain(|(_, amount)| *amount > 0.0);
        let total: f64 = kept.iter().map(|(_, amount)| amount).sum();
        if !(total > 0.0 && total.is_finite()) {
            return Err(PaintError::Nothing);
        }
        kept.iter_mut().for_each(|(_, amount)| *amount /= total);
        Ok(Self(kept))
    }

    /// Of one paint by itself.
    pub fn pure(paint: impl Into<String>) -> Self {
        Self(vec![(paint.into(), 1.0)])
    }

    /// Names and shares.
    pub fn parts(&self) -> &[(String, f64)] {
        &self.0
    }

    /// "70 % white + 30 % blue".
    pub fn describe(&self) -> String {
        let part = |(name, share): &(String, f64)| {
            let percent = 100.0 * share;
            let digits = if percent < 10.0 { 2 } else { 1 };
            let text = format!("{percent:.digits$}");
            format!(
                "{} % {name}",
                if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text }
            )
        };
        self.0.iter().map(part).collect::<Vec<_>>().join(" + ")
    }
}

/// An opaque sample of known recipe.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// What it is called.
    pub name: String,
    /// What it is made of.
    pub recipe: Recipe,
    /// Its reflectance at every wavelength of the [`Measurements`], between 0 and 1.
    pub reflectance: Vec<f64>,
}

/// Opaque samples measured at the same wavelengths. A sample may be there several times.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurements {
    grid: WavelengthGrid,
    samples: Vec<Sample>,
}

impl Measurements {
    /// # Errors
    /// [`PaintError::Length`] or [`PaintError::Reflectance`].
    pub fn new(grid: WavelengthGrid, samples: Vec<Sample>) -> Result<Self, PaintError> {
        for sample in &samples {
            let (found, expected) = (sample.reflectance.len(), grid.len());
            if found != expected {
                return Err(PaintError::Length { sample: sample.name.clone(), found, expected });
            }
            let bad = grid.iter().zip(&sample.reflectance).find(|(_, value)| !(**value > 0.0 && **value < 1.0));
            if let Some((wavelength, &value)) = bad {
                let (sample, wavelength_nm) = (sample.name.clone(), crate::spectrum::nanometres(wavelength));
                return Err(PaintError::Reflectance { sample, wavelength_nm, value });
            }
        }
        Ok(Self { grid, samples })
    }

    /// The wavelengths, m.
    pub fn grid(&self) -> &WavelengthGrid {
        &self.grid
    }

    /// The samples.
    pub fn samples(&self) -> &[Sample] {
        &self.samples
    }

    /// Those samples that `keep` keeps, by their place and themselves.
    pub fn filtered(&self, keep: impl Fn(usize, &Sample) -> bool) -> Self {
        let samples = self.samples.iter().enumerate().filter(|(i, sample)| keep(*i, sample));
        Self { grid: self.grid.clone(), samples: samples.map(|(_, sample)| sample.clone()).collect() }
    }

    /// These and others at the same wavelengths.
    ///
    /// # Errors
    /// [`PaintError::Wavelengths`] when they differ (by more than 1e-9 of themselves).
    pub fn and(mut self, others: Self) -> Result<Self, PaintError> {
        let alike = |(a, b): (f64, f64)| (a - b).abs() <= 1e-9 * a;
        if self.grid.len() != others.grid.len() || !self.grid.iter().zip(others.grid.iter()).all(alike) {
            let sample = others.samples.first().map(|sample| sample.name.clone()).unwrap_or_default();
            return Err(PaintError::Wavelengths { sample });
        }
        self.samples.extend(others.samples);
        Ok(self)
    }

    /// Names of all paints, in the order in which they first appear.
    pub fn paints(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for (name, _) in self.samples.iter().flat_map(|sample| sample.recipe.parts()) {
            if !names.contains(&name.as_str()) {
                names.push(name);
            }
        }
        names
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recipes_are_shares_of_one() {
        let recipe = Recipe::new([("white".into(), 2.1), ("blue".into(), 0.9), ("red".into(), 0.0)]).unwrap();
        assert_eq!(recipe.parts().len(), 2);
        assert!((recipe.parts()[0].1 - 0.7).abs() < 1e-15);
        assert_eq!(recipe.describe(), "70 % white + 30 % blue");
        assert_eq!(Recipe::new([("a".into(), 0.0)]), Err(PaintError::Nothing));
        assert!(matches!(Recipe::new([("a".into(), -1.0)]), Err(PaintError::Amount { .. })));
        assert!(matches!(Recipe::new([("a".into(), 1.0), ("a".into(), 1.0)]), Err(PaintError::Twice { .. })));
        assert!(Recipe::new([]).is_err());
    }

    #[test]
    fn measurements_that_cannot_be_are_refused() {
        let grid = WavelengthGrid::new(vec![5e-7, 6e-7]).unwrap();
        let sample = |reflectance: Vec<f64>| Sample { name: "s".into(), recipe: Recipe::pure("a"), reflectance };
        assert!(matches!(Measurements::new(grid.clone(), vec![sample(vec![0.5])]), Err(PaintError::Length { .. })));
        for value in [0.0, 1.0, 44.0, -0.1, f64::NAN] {
            let found = Measurements::new(grid.clone(), vec![sample(vec![0.5, value])]);
            assert!(matches!(found, Err(PaintError::Reflectance { wavelength_nm: 600.0, .. })), "{found:?}");
        }
        let good = Measurements::new(grid, vec![sample(vec![0.5, 0.6])]).unwrap();
        let other = WavelengthGrid::new(vec![5e-7, 6.1e-7]).unwrap();
        let other = Measurements::new(other, vec![sample(vec![0.5, 0.6])]).unwrap();
        assert_eq!(good.clone().and(other), Err(PaintError::Wavelengths { sample: "s".into() }));
        assert_eq!(good.clone().and(good).unwrap().paints(), ["a"]);
    }
}
