//! Refractive indices given by formulas and tables, each over its own range.

mod formula;

use num_complex::Complex64;

pub use formula::Formula;

use super::error::{DispersionError, SubstanceError};
use crate::spectrum::{Sampled, WavelengthGrid};

/// One part of an index over a range of wavelengths.
#[derive(Debug, Clone, PartialEq)]
pub enum Piece {
    /// Samples, linear in between.
    Table(Sampled),
    /// A formula.
    Formula(Formula),
    /// A weighted sum of formulas, where all of them hold: the mean over the axes of a crystal.
    Mean(Vec<(f64, Formula)>),
}

impl Piece {
    fn at(&self, wavelength_m: f64) -> Option<f64> {
        match self {
            Self::Table(table) => table.at(wavelength_m),
            Self::Formula(formula) => formula.at(wavelength_m),
            Self::Mean(formulas) => formulas.iter().map(|(weight, f)| Some(weight * f.at(wavelength_m)?)).sum(),
        }
    }

    fn range(&self) -> (f64, f64) {
        match self {
            Self::Table(table) => table.grid().range(),
            Self::Formula(formula) => formula.range(),
            Self::Mean(formulas) => {
                formulas.iter().fold((0.0, f64::INFINITY), |(a, b), (_, f)| (a.max(f.range().0), b.min(f.range().1)))
            }
        }
    }
}

/// Something in the data that had to be put right.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Note {
    /// Negative imaginary parts, which would amplify light, were taken for zero.
    NegativeAbsorption {
        /// How many samples.
        samples: usize,
        /// The lowest of them.
        lowest: f64,
    },
    /// Samples at the same wavelength were replaced by their mean.
    Repeated {
        /// How many were too many.
        samples: usize,
    },
    /// The samples were not in the order of wavelength and were sorted.
    Unsorted,
}

impl std::fmt::Display for Note {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NegativeAbsorption { samples, lowest } => {
                write!(f, "{samples} negative imaginary part(s), the lowest {lowest}, taken for 0")
            }
            Self::Repeated { samples } => write!(f, "{samples} sample(s) at a wavelength given before, means taken"),
            Self::Unsorted => write!(f, "samples not in the order of wavelength, sorted"),
        }
    }
}

/// A complex refractive index over wavelength, as its source gives it.
///
/// Each part may come in several pieces; where two overlap, the first holds. Between samples parts are linear, hence
/// monotone; beyond its pieces nothing is known.
#[derive(Debug, Clone, PartialEq)]
pub struct Dispersion {
    name: String,
    real: Vec<Piece>,
    imaginary: Vec<Piece>,
    transparent: bool,
    notes: Vec<Note>,
}

impl Dispersion {
    /// Of a name and pieces of the real and of the imaginary part.
    ///
    /// # Errors
    /// [`DispersionError::Empty`] if there are no pieces at all.
    pub fn new(name: impl Into<String>, real: Vec<Piece>, imaginary: Vec<Piece>) -> Result<Self, DispersionError> {
        if real.is_empty() && imaginary.is_empty() {
            return Err(DispersionError::Empty);
        }
        Ok(Self { name: name.into(), real, imaginary, transparent: false, notes: Vec::new() })
    }

    /// Takes the imaginary part for zero wherever its source does not give one.
    #[must_use]
    pub fn assume_transparent(mut self) -> Self {
        self.transparent = true;
        self
    }

    /// Adds what had to be put right in the data.
    #[must_use]
    pub fn with_notes(mut self, notes: Vec<Note>) -> Self {
        self.notes.extend(notes);
        self
    }

    /// What people call it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What had to be put right in the data.
    pub fn notes(&self) -> &[Note] {
        &self.notes
    }

    /// Whether its source gives a real part, and whether it gives an imaginary one.
    pub fn has_parts(&self) -> (bool, bool) {
        (!self.real.is_empty(), !self.imaginary.is_empty())
    }

    /// The real part at a wavelength in metres, and the imaginary one, each `None` where its source is silent. What was
    /// assumed is not in it.
    pub fn parts(&self, wavelength_m: f64) -> (Option<f64>, Option<f64>) {
        let first = |pieces: &[Piece]| pieces.iter().find_map(|piece| piece.at(wavelength_m));
        (first(&self.real), first(&self.imaginary))
    }

    /// From the shortest to the longest wavelength (m) of the real part, and of the imaginary one.
    pub fn part_ranges(&self) -> [Option<(f64, f64)>; 2] {
        let hull = |pieces: &[Piece]| pieces.iter().map(Piece::range).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)));
        [hull(&self.real), hull(&self.imaginary)]
    }

    /// The wavelengths (m) for which there is an index; first above second when there are none.
    pub fn wavelength_range(&self) -> (f64, f64) {
        let everywhere = (0.0, f64::INFINITY);
        let [real, imaginary] = self.part_ranges();
        let (a, b) = (real.unwrap_or(everywhere), imaginary.filter(|_| !self.transparent).unwrap_or(everywhere));
        (a.0.max(b.0), a.1.min(b.1))
    }

    /// Refractive index at a vacuum wavelength (m).
    ///
    /// # Errors
    /// [`SubstanceError`]: beyond the data, without one of the parts, or with a real part that is not positive.
    pub fn index(&self, wavelength_m: f64) -> Result<Complex64, SubstanceError> {
        let substance = || self.name.clone();
        let (real, imaginary) = self.parts(wavelength_m);
        let beyond =
            || SubstanceError::Wavelength { substance: substance(), wavelength_m, range_m: self.wavelength_range() };
        if self.real.is_empty() {
            return Err(SubstanceError::NoRealPart { substance: substance() });
        }
        if self.imaginary.is_empty() && !self.transparent {
            return Err(SubstanceError::NoAbsorption { substance: substance() });
        }
        let value = real.ok_or_else(beyond)?;
        let imaginary = imaginary.or(self.transparent.then_some(0.0)).ok_or_else(beyond)?;
        if !(value > 0.0 && value.is_finite()) {
            return Err(SubstanceError::RealPart { substance: substance(), wavelength_m, value });
        }
        Ok(Complex64::new(value, imaginary))
    }
}

/// Samples as sources give them made into a table for each of the columns: sorted, repeated wavelengths replaced by
/// means. Wavelengths in metres; a row is a wavelength and its values.
///
/// # Errors
/// [`DispersionError::Table`]: no samples, a wavelength that is no length, a value that is not finite.
pub fn tables<const COLUMNS: usize>(
    mut rows: Vec<(f64, [f64; COLUMNS])>,
) -> Result<([Sampled; COLUMNS], Vec<Note>), DispersionError> {
    let mut notes = Vec::new();
    if rows.windows(2).any(|pair| pair[1].0 < pair[0].0) {
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        notes.push(Note::Unsorted);
    }
    let given = rows.len();
    let mut wavelengths: Vec<f64> = Vec::with_capacity(given);
    let mut columns: [Vec<f64>; COLUMNS] = std::array::from_fn(|_| Vec::with_capacity(given));
    for same in rows.chunk_by(|a, b| a.0 == b.0) {
        wavelengths.push(same[0].0);
        for (i, column) in columns.iter_mut().enumerate() {
            column.push(same.iter().map(|row| row.1[i]).sum::<f64>() / same.len() as f64);
        }
    }
    if wavelengths.len() < given {
        notes.push(Note::Repeated { samples: given - wavelengths.len() });
    }
    let grid = WavelengthGrid::new(wavelengths)?;
    let mut tables = Vec::with_capacity(COLUMNS);
    for column in columns {
        tables.push(Sampled::new(grid.clone(), column)?);
    }
    let tables = tables.try_into().map_err(|_| DispersionError::Empty)?;
    Ok((tables, notes))
}

/// A table of imaginary parts with the negative ones taken for zero, and the note that says so.
///
/// # Errors
/// [`DispersionError::Table`], never for a table that was one.
pub fn without_gain(table: &Sampled) -> Result<(Sampled, Option<Note>), DispersionError> {
    let negative = || table.values().iter().copied().filter(|&k| k < 0.0);
    let samples = negative().count();
    if samples == 0 {
        return Ok((table.clone(), None));
    }
    let clamped = table.values().iter().map(|k| k.max(0.0)).collect();
    let note = Note::NegativeAbsorption { samples, lowest: negative().fold(0.0, f64::min) };
    Ok((Sampled::new(table.grid().clone(), clamped)?, Some(note)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampled(rows: &[(f64, f64)]) -> Piece {
        let rows = rows.iter().map(|&(w, v)| (w * 1e-9, [v])).collect();
        let ([table], _) = tables(rows).unwrap();
        Piece::Table(table)
    }

    fn cauchy(n: f64, range_nm: (f64, f64)) -> Piece {
        Piece::Formula(Formula::new(5, vec![n], (range_nm.0 * 1e-9, range_nm.1 * 1e-9)).unwrap())
    }

    #[test]
    fn parts_have_ranges_of_their_own() {
        let k = sampled(&[(450.0, 1e-3), (550.0, 3e-3)]);
        let d = Dispersion::new("x", vec![cauchy(1.5, (400.0, 600.0)), cauchy(1.6, (500.0, 800.0))], vec![k]).unwrap();
        let n = d.index(500e-9).unwrap();
        assert!((n - Complex64::new(1.5, 2e-3)).norm() < 1e-12);
        let SubstanceError::Wavelength { range_m, .. } = d.index(430e-9).unwrap_err() else { panic!() };
        assert!((range_m.0 / 450e-9 - 1.0).abs() < 1e-12 && (range_m.1 / 550e-9 - 1.0).abs() < 1e-12);
        let clear = d.clone().assume_transparent();
        assert_eq!(clear.index(430e-9).unwrap(), Complex64::new(1.5, 0.0));
        assert_eq!(clear.index(700e-9).unwrap(), Complex64::new(1.6, 0.0));
        assert_eq!(clear.index(500e-9).unwrap(), n);
        assert!(clear.index(810e-9).is_err());
    }

    #[test]
    fn a_part_that_is_missing_is_asked_for() {
        let real = Dispersion::new("x", vec![cauchy(1.5, (400.0, 600.0))], vec![]).unwrap();
        assert!(matches!(real.index(500e-9), Err(SubstanceError::NoAbsorption { .. })));
        assert!(real.assume_transparent().index(500e-9).is_ok());
        let imaginary = Dispersion::new("x", vec![], vec![sampled(&[(400.0, 0.1), (600.0, 0.1)])]).unwrap();
        assert!(matches!(imaginary.index(500e-9), Err(SubstanceError::NoRealPart { .. })));
        assert_eq!(Dispersion::new("x", vec![], vec![]), Err(DispersionError::Empty));
        let meta = Dispersion::new("x", vec![cauchy(-0.5, (400.0, 600.0))], vec![]).unwrap().assume_transparent();
        assert!(matches!(meta.index(500e-9), Err(SubstanceError::RealPart { value: -0.5, .. })));
    }

    #[test]
    fn samples_are_put_in_order() {
        let rows = vec![(5e-7, [2.0]), (4e-7, [1.0]), (5e-7, [4.0]), (6e-7, [-1.0])];
        let ([table], notes) = tables(rows).unwrap();
        assert_eq!(table.values(), [1.0, 3.0, -1.0]);
        assert_eq!(notes, [Note::Unsorted, Note::Repeated { samples: 1 }]);
        let (clamped, note) = without_gain(&table).unwrap();
        assert_eq!(clamped.values(), [1.0, 3.0, 0.0]);
        assert_eq!(note, Some(Note::NegativeAbsorption { samples: 1, lowest: -1.0 }));
        assert_eq!(without_gain(&clamped).unwrap().1, None);
        assert!(matches!(tables(vec![(-1.0, [1.0])]), Err(DispersionError::Table(_))));
        assert!(matches!(tables(Vec::<(f64, [f64; 1])>::new()), Err(DispersionError::Table(_))));
    }
}
