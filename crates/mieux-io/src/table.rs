//! Columns of numbers with their units: aligned for reading, or comma-separated with every digit for other programs.

#[cfg(feature = "parquet")]
mod parquet;

use std::io::{self, Write};

#[cfg(feature = "parquet")]
pub use ::parquet::errors::ParquetError;

use crate::quantity::significant;

/// One column: a name, a unit (empty for a plain number) and its values. A NaN is a missing value.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// The quantity in the field's words, `sigma_s`.
    pub name: String,
    /// The unit as written after a number, `1/m`, `nm`; empty where there is none.
    pub unit: String,
    /// One value per row.
    pub values: Vec<f64>,
}

impl Column {
    /// The name with the unit as a suffix that suits a column of a data frame: `wavelength_nm`, `sigma_s_per_m`.
    pub fn header(&self) -> String {
        let mut unit = String::new();
        let mut spelled = self.unit.replace("1/", "per ").replace('/', " per ").replace('%', "percent");
        spelled = spelled.replace(['µ', '\u{3bc}'], "u");
        for part in spelled.split(|c: char| !c.is_ascii_alphanumeric()).filter(|part| !part.is_empty()) {
            unit.push('_');
            unit.push_str(part);
        }
        format!("{}{unit}", self.name)
    }
}

/// Columns do not hold the same number of values.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("column `{column}` has {found} values where the first column has {expected}")]
pub struct TableError {
    /// The name of the column.
    pub column: String,
    /// How many values it has.
    pub found: usize,
    /// How many it should have.
    pub expected: usize,
}

/// A title, remarks about where the numbers come from, and columns of one length.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    title: String,
    metadata: Vec<(String, String)>,
    columns: Vec<Column>,
}

impl Table {
    /// A table without columns.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), metadata: Vec::new(), columns: Vec::new() }
    }

    /// Adds a remark, "material: milk, fat 2%".
    pub fn with_metadata(mut self, key: impl Into<String>, value: impl Into<String>) -> Self {
        self.metadata.push((key.into(), value.into()));
        self
    }

    /// Adds a column. Its `unit` is empty for a plain number.
    ///
    /// # Errors
    /// [`TableError`] when it does not have as many values as the columns before it.
    pub fn with_column(
        mut self,
        name: impl Into<String>,
        unit: impl Into<String>,
        values: Vec<f64>,
    ) -> Result<Self, TableError> {
        let column = Column { name: name.into(), unit: unit.into(), values };
        let expected = self.columns.first().map_or(column.values.len(), |first| first.values.len());
        if column.values.len() != expected {
            return Err(TableError { found: column.values.len(), column: column.name, expected });
        }
        self.columns.push(column);
        Ok(self)
    }

    /// The same table without its title.
    pub fn without_title(self) -> Self {
        Self { title: String::new(), ..self }
    }

    /// The title.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// The remarks, in the order they were added.
    pub fn metadata(&self) -> &[(String, String)] {
        &self.metadata
    }

    /// The columns, in the order they were added.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// How many rows there are.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }

    /// The table for a terminal: the title, a line of names, a line of units, then the rows, aligned on the right, with
    /// `digits` significant digits (at least 1). A missing value is `-`.
    pub fn to_text(&self, digits: usize) -> String {
        let mut cells: Vec<Vec<String>> = Vec::new();
        for column in &self.columns {
            let mut lines = vec![column.name.clone(), column.unit.clone()];
            lines.extend(
                column.values.iter().map(|v| if v.is_nan() { "-".to_owned() } else { significant(*v, digits) }),
            );
            let width = lines.iter().map(|cell| cell.chars().count()).max().unwrap_or(0);
            cells.push(lines.into_iter().map(|cell| format!("{cell:>width$}")).collect());
        }
        let has_units = self.columns.iter().any(|column| !column.unit.is_empty());
        let mut text = String::new();
        if !self.title.is_empty() {
            text.push_str(&self.title);
            text.push('\n');
        }
        for line in (0..self.rows() + 2).filter(|line| !self.columns.is_empty() && (has_units || *line != 1)) {
            let row: Vec<&str> = cells.iter().map(|column| column[line].as_str()).collect();
            text.push_str(row.join("  ").trim_end());
            text.push('\n');
        }
        text
    }

    /// Comma-separated values (RFC 4180): `#` lines with the title and the remarks, a header of [`Column::header`]s, then
    /// every value with as many digits as it takes to read the same bits back. A missing value is an empty cell.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write_csv(&self, mut out: impl Write) -> io::Result<()> {
        if !self.title.is_empty() {
            comment(&mut out, &self.title)?;
        }
        for (key, value) in &self.metadata {
            comment(&mut out, &format!("{key}: {value}"))?;
        }
        if self.columns.is_empty() {
            return Ok(());
        }
        let mut csv = csv::Writer::from_writer(out);
        csv.write_record(self.columns.iter().map(Column::header))?;
        for row in 0..self.rows() {
            csv.write_record(self.columns.iter().map(|column| exact(column.values[row])))?;
        }
        csv.flush()
    }
}

/// One `#` line for every line of the text.
fn comment(out: &mut impl Write, text: &str) -> io::Result<()> {
    text.split(['\n', '\r']).filter(|line| !line.is_empty()).try_for_each(|line| writeln!(out, "# {line}"))
}

/// The shortest decimal number that reads back as `value`; nothing for NaN.
pub fn exact(value: f64) -> String {
    match value.abs() {
        _ if value.is_nan() => String::new(),
        0.0 => "0".to_owned(),
        size if size.is_infinite() || (1e-4..1e15).contains(&size) => format!("{value}"),
        _ => format!("{value:e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn milk() -> Table {
        Table::new("milk")
            .with_metadata("material", "milk, fat 2%\n# not a line of its own")
            .with_column("wavelength", "nm", vec![450.0, 550.0])
            .unwrap()
            .with_column("sigma_s", "1/m", vec![57_837.26, 4.2e-9])
            .unwrap()
            .with_column("asymmetry", "", vec![0.9, f64::NAN])
            .unwrap()
    }

    #[test]
    fn a_terminal_shows_names_units_and_aligned_numbers() {
        let expected = "\
milk
wavelength  sigma_s  asymmetry
        nm      1/m
       450    57840        0.9
       550   4.2e-9          -
";
        assert_eq!(milk().to_text(4), expected);
    }

    #[test]
    fn csv_carries_its_history_and_every_digit() {
        let mut bytes = Vec::new();
        milk().write_csv(&mut bytes).unwrap();
        let expected = "\
# milk
# material: milk, fat 2%
# # not a line of its own
wavelength_nm,sigma_s_per_m,asymmetry
450,57837.26,0.9
550,4.2e-9,
";
        assert_eq!(String::from_utf8(bytes).unwrap(), expected);
        let mut bytes = Vec::new();
        Table::new("").write_csv(&mut bytes).unwrap();
        assert!(bytes.is_empty() && Table::new("").to_text(4).is_empty());
    }

    #[test]
    fn columns_have_one_length() {
        let error = milk().with_column("short", "", vec![1.0]).unwrap_err();
        assert_eq!(error.to_string(), "column `short` has 1 values where the first column has 2");
    }

    #[test]
    fn units_become_suffixes() {
        for (unit, header) in [
            ("", "x"),
            ("nm", "x_nm"),
            ("1/m", "x_per_m"),
            ("W/m2/sr", "x_W_per_m2_per_sr"),
            ("µm", "x_um"),
            ("%", "x_percent"),
        ] {
            assert_eq!(Column { name: "x".into(), unit: unit.into(), values: vec![] }.header(), header);
        }
    }

    proptest! {
        #[test]
        fn csv_reads_back_the_same_bits(values in prop::collection::vec(prop::num::f64::ANY, 1..20)) {
            let mut bytes = Vec::new();
            Table::new("t").with_column("x", "m", values.clone()).unwrap()
                .with_column("y", "", vec![0.0; values.len()]).unwrap().write_csv(&mut bytes).unwrap();
            let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(bytes.as_slice());
            for (record, value) in reader.records().zip(&values) {
                let cell = record.unwrap()[0].to_owned();
                if value.is_nan() {
                    prop_assert_eq!(cell, "");
                } else {
                    prop_assert_eq!(cell.parse::<f64>().unwrap(), *value);
                }
            }
        }
    }
}
