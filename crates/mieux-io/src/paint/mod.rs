//! Measurements of paints, and paints whose K and S are known, as files. `docs/paints.md` shows their form.

mod file;
mod measurements;

pub use file::{load_paints, paints_to_toml, parse_paints, write_residuals};
pub use measurements::{parse_measurements, parse_recipe, parse_spectrum, read_measurements, read_spectrum};

use std::io;
use std::path::PathBuf;

use mieux_optics::paint::PaintError;

use crate::TextError;

/// What can be wrong with a file of paints.
#[derive(Debug, thiserror::Error)]
pub enum PaintFileError {
    /// It cannot be read.
    #[error("`{}` cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Something at a place in its text.
    #[error(transparent)]
    Text(Box<TextError>),
    /// Something in an entry of a list of measurements.
    #[error("{name}, entry {entry}{}: {problem}", what.as_ref().map(|what| format!(" (`{what}`)")).unwrap_or_default())]
    Entry {
        /// Name of the file.
        name: String,
        /// Number of the entry, from 1.
        entry: usize,
        /// What the entry is called.
        what: Option<String>,
        /// What is wrong.
        problem: String,
    },
    /// A cell of a table.
    #[error("{name}, line {line}, column {column}: {problem}")]
    Cell {
        /// Name of the file.
        name: String,
        /// Line, from 1.
        line: u64,
        /// Column among those of the table, from 1.
        column: usize,
        /// What is wrong.
        problem: String,
    },
    /// A file that holds what no paint can have.
    #[error("{name}: {source}")]
    Paint {
        /// Name of the file.
        name: String,
        /// What is wrong.
        source: PaintError,
    },
}

impl From<Box<TextError>> for PaintFileError {
    fn from(error: Box<TextError>) -> Self {
        Self::Text(error)
    }
}
