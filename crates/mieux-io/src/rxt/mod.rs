//! Measured slabs in the format of inverse adding-doubling (`prahl1993`): `.rxt` files.
//!
//! The text starts with `IAD1`; what follows `#` on a line is a remark. Seventeen numbers describe sample, beam and
//! integrating spheres; then comes either the number of measurements in a row (1: reflectance, 2: and transmittance, 3: and
//! unscattered transmittance, 4 to 7: and reflectances of walls and standards), with or without a wavelength in front of
//! each row, or one letter for each column. A row is a line.

mod columns;
mod words;

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use columns::Columns;
use words::{Word, Words};

use crate::text_error::TextError;

/// Longest file that is read, bytes.
const MAX_BYTES: u64 = 64 << 20;

/// What can be wrong with an `.rxt` file.
#[derive(Debug, thiserror::Error)]
pub enum RxtError {
    /// It cannot be read.
    #[error("`{}` cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// It is too long.
    #[error("`{}` is longer than 64 MiB", path.display())]
    Long {
        /// The file.
        path: PathBuf,
    },
    /// Its text.
    #[error(transparent)]
    Text(#[from] Box<TextError>),
}

/// A file of measurements.
#[derive(Debug, Clone, PartialEq)]
pub struct Rxt {
    /// How many integrating spheres were used at a time: 0, 1 or 2. Their dimensions are read but not kept.
    pub spheres: u32,
    /// At least one.
    pub rows: Vec<RxtRow>,
}

/// A row of measurements with all that is said about its sample.
#[derive(Debug, Clone, PartialEq)]
pub struct RxtRow {
    /// Line in the file, from 1.
    pub line: usize,
    /// Wavelength in vacuum, m.
    pub wavelength: Option<f64>,
    /// Total reflectance.
    pub reflectance: Option<f64>,
    /// Total transmittance.
    pub transmittance: Option<f64>,
    /// Unscattered transmittance.
    pub unscattered: Option<f64>,
    /// Refractive index of the sample.
    pub refractive_index: f64,
    /// Of the slides above and below; 1 where there are none.
    pub slide_index: f64,
    /// Of the sample, m.
    pub thickness: f64,
    /// The asymmetry that the file takes for granted.
    pub asymmetry: Option<f64>,
    /// The optical thickness that the file takes for granted.
    pub optical_thickness: Option<f64>,
    /// The fraction of the unscattered reflection that is measured with the reflectance.
    pub specular_in_reflectance: f64,
    /// The fraction of the unscattered transmission that is measured with the transmittance.
    pub unscattered_in_transmittance: f64,
}

/// What the numbers of the header are, in order.
const HEADER: [&str; 17] = [
    "the refractive index of the sample",
    "the refractive index of the slides",
    "the thickness of the sample in mm",
    "the thickness of the slides in mm",
    "the diameter of the beam in mm",
    "the reflectance of the calibration standard",
    "the number of spheres",
    "the diameter of the reflection sphere in mm",
    "the diameter of its sample port in mm",
    "the diameter of its entrance port in mm",
    "the diameter of its detector port in mm",
    "the reflectance of its wall",
    "the diameter of the transmission sphere in mm",
    "the diameter of its sample port in mm",
    "the diameter of its exit port in mm",
    "the diameter of its detector port in mm",
    "the reflectance of its wall",
];

impl Rxt {
    /// What is in a file.
    ///
    /// # Errors
    /// [`RxtError`]; for what is wrong in the text, with line and column.
    pub fn read(path: &Path) -> Result<Self, RxtError> {
        let error = |source| RxtError::Read { path: path.to_owned(), source };
        let mut bytes = Vec::new();
        File::open(path).map_err(error)?.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(error)?;
        if bytes.len() as u64 > MAX_BYTES {
            return Err(RxtError::Long { path: path.to_owned() });
        }
        // Remarks may be in any encoding.
        let text = String::from_utf8_lossy(&bytes);
        Ok(Self::parse(&path.display().to_string(), &text)?)
    }

    /// What is in a text, which errors call by `name`.
    ///
    /// # Errors
    /// [`TextError`] with line and column.
    pub fn parse(name: &str, text: &str) -> Result<Self, Box<TextError>> {
        let mut words = Words::new(name, text)?;
        let mut header = [0.0; HEADER.len()];
        for (i, (value, what)) in header.iter_mut().zip(HEADER).enumerate() {
            let Some(word) = words.next_word() else {
                let message = format!("the file ends after {i} of the 17 numbers of its header");
                return Err(words.at_end(message).with_help(format!("next comes {what}")));
            };
            *value = words.number(&word, what)?;
        }
        let [index, slide, thickness, slide_thickness, ..] = header;
        // A slide of no thickness is none.
        let slide = if slide_thickness == 0.0 || slide == 0.0 { 1.0 } else { slide };
        let spheres = header[6];
        if ![0.0, 1.0, 2.0].contains(&spheres) {
            let message = format!("{spheres} spheres: 0, 1 or 2 are used at a time");
            return Err(words.at_end(message).with_help("the seventh number of the header is their number"));
        }
        let pattern = RxtRow {
            line: 0,
            wavelength: None,
            reflectance: None,
            transmittance: None,
            unscattered: None,
            refractive_index: index,
            slide_index: slide,
            thickness: thickness * 1e-3,
            asymmetry: None,
            optical_thickness: None,
            specular_in_reflectance: 1.0,
            unscattered_in_transmittance: 1.0,
        };
        let mut file = Self { spheres: spheres as u32, rows: Vec::new() };
        let legend = words.rest_of_line();
        let columns = Columns::parse(&words, &legend)?;
        loop {
            let row = words.rest_of_line();
            let Some(first) = row.first() else { break };
            file.rows.push(columns.row(
                &words,
                &row,
                RxtRow { line: first.line, ..pattern.clone() },
                &mut file.spheres,
            )?);
        }
        if file.rows.is_empty() {
            return Err(words.at_end("the file has no measurements".into()));
        }
        Ok(file)
    }
}

#[cfg(test)]
mod tests;
