//! Optical properties as others have measured or computed them: a table over wavelength.
//!
//! Comma-separated values with a line of names. One column is the wavelength (`wavelength_nm`, `wavelength_um`); the others
//! are any of `sigma_s`, `sigma_a`, `sigma_t`, `reduced_scattering` with a unit (`_per_m`, `_per_cm`, `_per_mm`), `g`,
//! `n_real` and `n_imag`. Other columns, lines that start with `#`, and empty cells are passed over; what `mieux optics`
//! writes is such a file.

use std::io::Read;
use std::ops::Range;
use std::path::{Path, PathBuf};

use mieux_optics::spectrum::WavelengthGrid;

use crate::cells::{Cell, rows};
use crate::text_error::TextError;

/// Largest file read, bytes.
const MAX_TEXT: u64 = 16 << 20;

/// What can stand in a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Property {
    /// Scattering coefficient, 1/m.
    Scattering,
    /// Reduced scattering coefficient, 1/m.
    ReducedScattering,
    /// Absorption coefficient, 1/m.
    Absorption,
    /// Extinction coefficient, 1/m.
    Extinction,
    /// Mean cosine of scattering.
    Asymmetry,
    /// Real part of the refractive index.
    IndexReal,
    /// Imaginary part of the refractive index.
    IndexImaginary,
}

impl Property {
    /// All of them, in the order in which they are shown.
    pub const ALL: [Self; 7] = [
        Self::Scattering,
        Self::ReducedScattering,
        Self::Absorption,
        Self::Extinction,
        Self::Asymmetry,
        Self::IndexReal,
        Self::IndexImaginary,
    ];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scattering => "sigma_s",
            Self::ReducedScattering => "reduced_scattering",
            Self::Absorption => "sigma_a",
            Self::Extinction => "sigma_t",
            Self::Asymmetry => "g",
            Self::IndexReal => "n_real",
            Self::IndexImaginary => "n_imag",
        }
    }

    /// Its unit; empty for plain numbers.
    pub fn unit(self) -> &'static str {
        if self < Self::Asymmetry { "1/m" } else { "" }
    }

    /// What a column of that name holds, and by what to multiply it.
    fn of_column(name: &str) -> Option<(Self, f64)> {
        let units: &[(&str, f64)] = &[("_per_m", 1.0), ("_per_cm", 1e2), ("_per_mm", 1e3)];
        Self::ALL.into_iter().find_map(|property| {
            let unit = name.strip_prefix(property.name())?;
            match property.unit() {
                "" => unit.is_empty().then_some((property, 1.0)),
                _ => units.iter().find(|(known, _)| *known == unit).map(|(_, factor)| (property, *factor)),
            }
        })
    }
}

/// Properties at some wavelengths; a NaN is a missing value.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// The wavelengths, m.
    pub grid: WavelengthGrid,
    /// What is known, one value per wavelength, in 1/m or plain.
    pub properties: Vec<(Property, Vec<f64>)>,
}

/// Why there are no measurements.
#[derive(Debug, thiserror::Error)]
pub enum MeasuredError {
    /// A file that cannot be read.
    #[error("the measurements `{}` cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file that says something impossible, with the place.
    #[error(transparent)]
    Text(#[from] Box<TextError>),
}

impl Measured {
    /// Reads a file.
    ///
    /// # Errors
    /// [`MeasuredError`], with line and column for a row that cannot be.
    pub fn read(path: &Path) -> Result<Self, MeasuredError> {
        let error = |source| MeasuredError::Read { path: path.into(), source };
        let mut text = String::new();
        let file = std::fs::File::open(path).map_err(error)?;
        file.take(MAX_TEXT + 1).read_to_string(&mut text).map_err(error)?;
        if text.len() as u64 > MAX_TEXT {
            return Err(error(std::io::Error::other("it is larger than 16 MiB")));
        }
        Ok(Self::parse(&path.to_string_lossy(), &text)?)
    }

    /// Reads a text; `file` names it in errors.
    ///
    /// # Errors
    /// [`TextError`] with the place.
    pub fn parse(file: &str, text: &str) -> Result<Self, Box<TextError>> {
        let error = |span: Range<usize>, message: String| TextError::new(file, text, span, message);
        let mut rows = rows(text);
        let header = rows.next().ok_or_else(|| error(0..0, "there is nothing in it".into()))?;
        let whole = header.first().map_or(0, |c| c.1.start)..header.last().map_or(0, |c| c.1.end);
        let wavelength =
            |name: &str| [("wavelength_nm", 1e-9), ("wavelength_um", 1e-6)].into_iter().find(|w| w.0 == name);
        let place = header.iter().enumerate().find_map(|(i, (name, _))| Some((i, wavelength(name)?.1)));
        let Some((x, metres)) = place else {
            let message = "no column of wavelengths: `wavelength_nm` or `wavelength_um`";
            return Err(error(whole, message.into()));
        };
        let columns = header.iter().enumerate().filter_map(|(i, (name, _))| Some((i, Property::of_column(name)?)));
        let columns: Vec<(usize, (Property, f64))> = columns.collect();
        if columns.is_empty() {
            let help = "columns: sigma_s, sigma_a, sigma_t, reduced_scattering with _per_m, _per_cm or _per_mm; g, n_real, n_imag";
            return Err(error(whole, "no column holds an optical property".into()).with_help(help));
        }
        let mut wavelengths = Vec::new();
        let mut properties: Vec<(Property, Vec<f64>)> = columns.iter().map(|(_, (p, _))| (*p, Vec::new())).collect();
        for row in rows {
            let cell = |i: usize| -> Result<(f64, &Cell<'_>), Box<TextError>> {
                let end = row.last().map_or(0, |c| c.1.end);
                let cell = row.get(i).ok_or_else(|| {
                    error(end..end, format!("this row has {} of {} columns", row.len(), header.len()))
                })?;
                match cell.0.parse::<f64>() {
                    _ if cell.0.is_empty() => Ok((f64::NAN, cell)),
                    Ok(value) if value.is_finite() => Ok((value, cell)),
                    _ => Err(error(cell.1.clone(), format!("`{}` is not a finite number", cell.0))),
                }
            };
            let (w, place) = cell(x)?;
            wavelengths.push(w * metres);
            // The grid knows what wavelengths may follow each other.
            let last = wavelengths[wavelengths.len().saturating_sub(2)..].to_vec();
            WavelengthGrid::new(last).map_err(|e| error(place.1.clone(), e.to_string()))?;
            for ((i, (property, factor)), (_, values)) in columns.iter().zip(&mut properties) {
                let (value, place) = cell(*i)?;
                let impossible = match property {
                    Property::Asymmetry => value.abs() > 1.0,
                    _ => value < 0.0,
                };
                if impossible {
                    return Err(error(place.1.clone(), format!("{} = {value} cannot be", property.name())));
                }
                values.push(value * factor);
            }
        }
        let grid = WavelengthGrid::new(wavelengths).map_err(|e| error(whole, e.to_string()))?;
        Ok(Self { grid, properties })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_with_units_reads() {
        let text = "# a spectrophotometer\nwavelength_nm,reduced_scattering_per_mm,sigma_a_per_cm,lot,g\n450,1.5,,a,0.9\n550,1.2,0.02,b,\n";
        let measured = Measured::parse("m.csv", text).unwrap();
        assert_eq!(measured.grid.as_slice(), [450.0 * 1e-9, 550.0 * 1e-9]);
        assert_eq!(measured.properties[0], (Property::ReducedScattering, vec![1500.0, 1200.0]));
        assert!(measured.properties[1].1[0].is_nan() && measured.properties[1].1[1] == 2.0);
        assert_eq!(measured.properties[2].1[0], 0.9);
    }

    #[test]
    fn mistakes_are_pointed_at() {
        for (text, line, part) in [
            ("", 1, "nothing"),
            ("a,b\n1,2\n", 1, "wavelengths"),
            ("wavelength_nm,sigma_s\n1,2\n", 1, "no column holds"),
            ("wavelength_nm,g\n450,x\n", 2, "`x`"),
            ("wavelength_nm,g\n450,1.1\n", 2, "cannot be"),
            ("wavelength_nm,sigma_a_per_m\n450,-1\n", 2, "cannot be"),
            ("wavelength_nm,g\n450,0.1\n440,0.1\n", 3, "increase"),
            ("wavelength_nm,g\n,0.1\n", 2, "positive"),
            ("wavelength_nm,g\n450\n", 2, "1 of 2"),
            ("wavelength_nm,g\n", 1, "at least one"),
        ] {
            let error = Measured::parse("m.csv", text).unwrap_err();
            assert!(error.line == line && error.message.contains(part), "{text}: {error}");
        }
    }
}
