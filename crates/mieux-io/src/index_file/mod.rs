//! Files of the refractiveindex.info database (`polyanskiy2024`): YAML with tables and formulas, wavelengths in um.

mod database;
mod yaml;

use std::io::Read;
use std::path::{Path, PathBuf};

use mieux_optics::substance::{Dispersion, DispersionError, Formula, Note, Piece, tables, without_gain};

pub use database::{IndexDatabase, Page};
use yaml::{Node, line_error};

use crate::text_error::TextError;

/// Largest file read, bytes.
pub const MAX_INDEX_FILE: u64 = 16 << 20;

/// Why a file gives no refractive index.
#[derive(Debug, thiserror::Error)]
pub enum IndexFileError {
    /// It cannot be read.
    #[error("`{}` cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It says something impossible, with the place.
    #[error(transparent)]
    Text(#[from] Box<TextError>),
    /// It is about something else.
    #[error("`{file}` {what}")]
    Other {
        /// The file.
        file: String,
        /// What it is instead.
        what: Instead,
    },
    /// A folder that is no such database.
    #[error("`{}` is no refractiveindex.info database: it has no catalog-nk.yml", path.display())]
    NoDatabase {
        /// The folder.
        path: PathBuf,
    },
    /// A page that the database does not have, or more than one.
    #[error("{message}")]
    Page {
        /// What is wrong.
        message: String,
        /// What to do instead.
        help: String,
    },
}

impl IndexFileError {
    /// What to do about it, where there is something to say.
    pub fn help(&self) -> Option<String> {
        match self {
            Self::Text(error) => error.help.clone(),
            Self::Page { help, .. } => Some(help.clone()),
            Self::NoDatabase { .. } => Some("give the folder that holds catalog-nk.yml and data".into()),
            _ => None,
        }
    }
}

/// What files of the database are that are no refractive index.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Instead {
    /// The description of a book.
    About,
    /// A catalogue.
    Catalogue,
    /// The nonlinear index.
    Nonlinear,
}

impl std::fmt::Display for Instead {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::About => "has no DATA: it describes a book of the database",
            Self::Catalogue => "is a catalogue; name a page of it",
            Self::Nonlinear => "gives the nonlinear index n2, not n and k",
        })
    }
}

/// Reads the refractive index in a file; what is short of an imaginary part stays so until it is said to be transparent
/// ([`Dispersion::assume_transparent`]).
///
/// # Errors
/// [`IndexFileError`].
pub fn read_index_file(path: &Path) -> Result<Dispersion, IndexFileError> {
    let name = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy();
    parse_index(&name, &path.to_string_lossy(), &read_text(path)?)
}

/// Reads a refractive index from its text; `file` names it in errors.
///
/// # Errors
/// [`IndexFileError::Text`] or [`IndexFileError::Other`].
pub fn parse_index(name: &str, file: &str, text: &str) -> Result<Dispersion, IndexFileError> {
    let source = Source { file, text };
    let root = yaml::read(file, text)?.ok_or_else(|| source.error(1, "the file is empty"))?;
    let other = |what| Err(IndexFileError::Other { file: file.into(), what });
    if root.list().is_some() {
        return other(Instead::Catalogue);
    }
    let Some(data) = root.get("DATA") else { return other(Instead::About) };
    let blocks = data.list().ok_or_else(|| source.error(data.line, "DATA must be a list of blocks"))?;
    let nonlinear = |block: &Node| block.text_of("type").is_some_and(|t| t == "tabulated n2" || t == "formula A");
    if !blocks.is_empty() && blocks.iter().all(nonlinear) {
        return other(Instead::Nonlinear);
    }
    let mut parts = Parts::default();
    for block in blocks {
        parts.add(source, block)?;
    }
    let dispersion = Dispersion::new(name, parts.real, parts.imaginary);
    let dispersion = dispersion.map_err(|error| source.error(data.line, error))?;
    Ok(dispersion.with_notes(parts.notes))
}

fn read_text(path: &Path) -> Result<String, IndexFileError> {
    let error = |source| IndexFileError::Read { path: path.into(), source };
    let mut text = String::new();
    let file = std::fs::File::open(path).map_err(error)?;
    file.take(MAX_INDEX_FILE + 1).read_to_string(&mut text).map_err(error)?;
    if text.len() as u64 > MAX_INDEX_FILE {
        return Err(error(std::io::Error::other("it is larger than 16 MiB, which no file of indices is")));
    }
    Ok(text)
}

/// A text under its name.
#[derive(Clone, Copy)]
struct Source<'a> {
    file: &'a str,
    text: &'a str,
}

impl Source<'_> {
    fn error(&self, line: usize, message: impl ToString) -> Box<TextError> {
        line_error(self.file, self.text, line, message.to_string())
    }

    /// What a block says under a key, as text, and its line.
    fn text_of<'n>(&self, block: &'n Node, key: &str) -> Result<(&'n str, usize), Box<TextError>> {
        let node = block.get(key).ok_or_else(|| self.error(block.line, format!("this block has no `{key}`")))?;
        let text = node.text().ok_or_else(|| self.error(node.line, format!("`{key}` must be text")))?;
        Ok((text, node.line))
    }

    fn numbers(&self, text: &str, line: usize) -> Result<Vec<f64>, Box<TextError>> {
        let number = |word: &str| match word.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(self.error(line, format!("`{word}` is not a finite number"))),
        };
        text.split_whitespace().map(number).collect()
    }
}

/// Pieces of both parts of an index, and what had to be put right.
#[derive(Default)]
struct Parts {
    real: Vec<Piece>,
    imaginary: Vec<Piece>,
    notes: Vec<Note>,
}

impl Parts {
    fn add(&mut self, source: Source<'_>, block: &Node) -> Result<(), Box<TextError>> {
        let (kind, line) = source.text_of(block, "type")?;
        match kind.split_whitespace().collect::<Vec<_>>()[..] {
            ["tabulated", "n"] => {
                let ([n], notes) = table(source, block)?;
                self.real.push(Piece::Table(n));
                self.notes.extend(notes);
            }
            ["tabulated", "k"] => {
                let ([k], notes) = table(source, block)?;
                self.notes.extend(notes);
                self.absorption(source, line, &k)?;
            }
            ["tabulated", "nk"] => {
                let ([n, k], notes) = table(source, block)?;
                self.real.push(Piece::Table(n));
                self.notes.extend(notes);
                self.absorption(source, line, &k)?;
            }
            ["formula", number] if number.parse::<u32>().is_ok() => {
                self.real.push(Piece::Formula(formula(source, block, number.parse().unwrap_or_default(), line)?));
            }
            _ => {
                let message = format!("`{kind}` is no kind of data known here");
                let help = "kinds: tabulated n, tabulated k, tabulated nk, formula 1 to formula 9";
                return Err(source.error(line, message).with_help(help));
            }
        }
        Ok(())
    }

    fn absorption(
        &mut self,
        source: Source<'_>,
        line: usize,
        k: &mieux_optics::spectrum::Sampled,
    ) -> Result<(), Box<TextError>> {
        let (k, note) = without_gain(k).map_err(|error| source.error(line, error))?;
        self.imaginary.push(Piece::Table(k));
        self.notes.extend(note);
        Ok(())
    }
}

type Columns<const COLUMNS: usize> = ([mieux_optics::spectrum::Sampled; COLUMNS], Vec<Note>);

/// The rows of a table: wavelength in um and one value for each column.
fn table<const COLUMNS: usize>(source: Source<'_>, block: &Node) -> Result<Columns<COLUMNS>, Box<TextError>> {
    let (text, first) = source.text_of(block, "data")?;
    let mut rows = Vec::new();
    for (i, row) in text.lines().enumerate().filter(|(_, row)| !row.trim().is_empty()) {
        let line = first + i;
        let numbers = source.numbers(row, line)?;
        let [wavelength, values @ ..] = &numbers[..] else { continue };
        let values: [f64; COLUMNS] = values.try_into().map_err(|_| {
            let message = format!("{} number(s) where a wavelength in um and {COLUMNS} value(s) belong", numbers.len());
            source.error(line, message)
        })?;
        if *wavelength <= 0.0 {
            return Err(source.error(line, format!("the wavelength {wavelength} um is not positive")));
        }
        rows.push((wavelength * 1e-6, values));
    }
    tables(rows).map_err(|error| source.error(first, error))
}

fn formula(source: Source<'_>, block: &Node, number: u32, line: usize) -> Result<Formula, Box<TextError>> {
    let (coefficients, at) = source.text_of(block, "coefficients")?;
    let coefficients = source.numbers(coefficients, at)?;
    let range = if block.get("range").is_some() { "range" } else { "wavelength_range" };
    let (range, range_line) = source.text_of(block, range)?;
    let [first, last] = source.numbers(range, range_line)?[..] else {
        return Err(source.error(range_line, "a range is two wavelengths in um"));
    };
    Formula::new(number, coefficients, (first * 1e-6, last * 1e-6)).map_err(|error| {
        let line = match error {
            DispersionError::Range { .. } => range_line,
            DispersionError::Number { .. } => line,
            _ => at,
        };
        source.error(line, error)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const GLASS: &str = "\
# this file has the form of those of the database
REFERENCES: \"somebody <i>et al.</i>\"
DATA:
  - type: formula 5
    wavelength_range: 0.40 0.80
    coefficients: 1.5 0.01 -2
  - type: tabulated k
    data: |
        0.4 1e-6
        0.5 -2e-6
        0.9 3e-6
";

    #[test]
    fn blocks_make_an_index() {
        let glass = parse_index("glass", "glass.yml", GLASS).unwrap();
        let n = glass.index(450e-9).unwrap();
        assert!((n.re - (1.5 + 0.01 / 0.2025)).abs() < 1e-12 && (n.im - 0.5e-6).abs() < 1e-12, "{n}");
        assert_eq!(glass.notes(), [Note::NegativeAbsorption { samples: 1, lowest: -2e-6 }]);
        assert!(glass.index(850e-9).is_err() && glass.index(390e-9).is_err());
    }

    #[test]
    fn a_table_of_both_parts_reads() {
        let text = "DATA:\n- type: tabulated nk\n  data: \"0.5 1.3 1e-3\\n0.4 1.4 0\"\n";
        let both = parse_index("x", "x.yml", text).unwrap();
        assert!((both.index(450e-9).unwrap().re - 1.35).abs() < 1e-12);
        assert_eq!(both.notes(), [Note::Unsorted]);
    }

    #[test]
    fn mistakes_are_pointed_at() {
        for (text, line, part) in [
            (GLASS.replace("0.5 -2e-6", "0.5 x"), 10, "`x` is not a finite number"),
            (GLASS.replace("0.5 -2e-6", "0.5"), 10, "1 number(s)"),
            (GLASS.replace("0.5 -2e-6", "0.5 1 2"), 10, "3 number(s)"),
            (GLASS.replace("0.5 -2e-6", "-0.5 1"), 10, "-0.5 um is not positive"),
            (GLASS.replace("formula 5", "formula 12"), 4, "no dispersion formula 12"),
            (GLASS.replace("formula 5", "formula five"), 4, "`formula five` is no kind of data"),
            (GLASS.replace("1.5 0.01 -2", "1.5 0.01"), 6, "takes one and pairs of coefficients, not 2"),
            (GLASS.replace("0.40 0.80", "0.80 0.40"), 5, "no range of positive lengths"),
            (GLASS.replace("0.40 0.80", "0.80"), 5, "a range is two wavelengths"),
            (GLASS.replace("coefficients", "coefs"), 4, "no `coefficients`"),
            (GLASS.replace("DATA:\n", "DATA: 1\nMORE:\n"), 3, "must be a list"),
            (GLASS.replace("DATA:\n", "DATA: [\n"), 4, ""),
            (String::new(), 1, "empty"),
        ] {
            let error = parse_index("x", "x.yml", &text).unwrap_err();
            let IndexFileError::Text(error) = error else { panic!("{error}") };
            assert!(error.message.contains(part), "{error}");
            assert!(error.line == line || part.is_empty() && error.line >= line, "{error}: line {line}");
        }
        for (text, what) in [
            ("NAMES: [a]\n", Instead::About),
            ("- SHELF: main\n", Instead::Catalogue),
            ("DATA:\n- type: tabulated n2\n  data: |\n    1 1e-20\n", Instead::Nonlinear),
        ] {
            let error = parse_index("x", "x.yml", text).unwrap_err();
            assert!(matches!(error, IndexFileError::Other { what: w, .. } if w == what), "{error}");
        }
    }
}
