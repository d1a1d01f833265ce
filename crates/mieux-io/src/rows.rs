//! Tables too long for memory: comma-separated rows read a block at a time, and written with columns added.
//!
//! The first line that is no `#` remark names the columns, which may come in any order. Every field is carried through;
//! remarks and empty lines are not.

use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

pub use csv::ByteRecord;
use csv::{ErrorKind, Reader, ReaderBuilder};

use crate::nearest_names;

/// What can be wrong with a long table.
#[derive(Debug, thiserror::Error)]
pub enum RowsError {
    /// It cannot be read.
    #[error("`{}` cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// There is no line of column names.
    #[error("`{}` has no line of column names", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// A column that is needed is not there.
    #[error("`{}` has no column `{column}`", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
        /// The column.
        column: &'static str,
        /// What would do.
        help: String,
    },
    /// A column is there twice.
    #[error("`{}` has two columns `{column}`", path.display())]
    Twice {
        /// The file.
        path: PathBuf,
        /// The column.
        column: String,
    },
    /// A column that is to be added is there already.
    #[error("`{}` has a column `{column}` already; rename it or leave it out", path.display())]
    Taken {
        /// The file.
        path: PathBuf,
        /// The column.
        column: String,
    },
    /// A row with more or fewer fields than there are columns.
    #[error("{}, line {line}: {found} fields where there are {expected} columns", path.display())]
    Ragged {
        /// The file.
        path: PathBuf,
        /// Line in the file, from 1.
        line: u64,
        /// Fields in the row.
        found: u64,
        /// Columns of the table.
        expected: u64,
    },
    /// A value that will not do.
    #[error("{}, line {line}, column `{column}`: `{value}` {problem}", path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// Line in the file, from 1.
        line: u64,
        /// The column.
        column: &'static str,
        /// What is there.
        value: String,
        /// What is wrong with it: "is not a number".
        problem: String,
    },
}

/// Where the columns that are needed are found, and how to speak of a place in the file.
#[derive(Debug, Clone)]
pub struct Columns {
    path: PathBuf,
    /// Names of the columns that are needed, and their places among the fields of a row.
    wanted: Vec<(&'static str, usize)>,
}

impl Columns {
    fn find(path: &Path, header: &ByteRecord, wanted: &[&'static str], added: &[&str]) -> Result<Self, RowsError> {
        let path = path.to_owned();
        let names: Vec<String> = header.iter().map(|name| String::from_utf8_lossy(name).trim().to_owned()).collect();
        if names.iter().all(String::is_empty) {
            return Err(RowsError::Empty { path });
        }
        if let Some(column) = names.iter().find(|name| added.contains(&name.as_str())) {
            return Err(RowsError::Taken { column: column.clone(), path });
        }
        let mut places = Vec::new();
        for &column in wanted {
            let mut found = names.iter().enumerate().filter(|(_, name)| *name == column);
            match (found.next(), found.next()) {
                (Some((place, _)), None) => places.push((column, place)),
                (None, _) => {
                    return Err(RowsError::Missing { help: missing_help(column, &names, wanted), column, path });
                }
                _ => return Err(RowsError::Twice { column: column.to_owned(), path }),
            }
        }
        Ok(Self { path, wanted: places })
    }

    /// The numbers in the columns that are needed, in the order in which they were asked for.
    ///
    /// # Errors
    /// [`RowsError::Value`] for what is no finite number.
    pub fn numbers<const N: usize>(&self, row: &ByteRecord) -> Result<[f64; N], RowsError> {
        let mut numbers = [0.0; N];
        for (i, (number, (_, place))) in numbers.iter_mut().zip(&self.wanted).enumerate() {
            let field = std::str::from_utf8(row[*place].trim_ascii()).ok();
            *number = field
                .and_then(|field| field.parse().ok())
                .filter(|v: &f64| v.is_finite())
                .ok_or_else(|| self.error(row, i, "is not a number"))?;
        }
        Ok(numbers)
    }

    /// The error for the value of a row in the column that was asked for as number `wanted`.
    pub fn error(&self, row: &ByteRecord, wanted: usize, problem: impl Into<String>) -> RowsError {
        let (column, place) = self.wanted[wanted];
        let value = String::from_utf8_lossy(&row[place]).trim().to_owned();
        RowsError::Value {
            path: self.path.clone(),
            line: line(&self.path, row.position()),
            column,
            value,
            problem: problem.into(),
        }
    }
}

fn missing_help(column: &str, names: &[String], wanted: &[&str]) -> String {
    let needed = format!("the columns needed are {}", wanted.join(", "));
    if names.len() == 1 && names[0].contains([';', '\t']) {
        return format!("columns are separated by commas; {needed}");
    }
    let others = || names.iter().map(String::as_str).filter(|name| !wanted.contains(name));
    let same = others().find(|name| name.eq_ignore_ascii_case(column));
    match same.or_else(|| nearest_names(column, others()).first().copied()) {
        Some(near) => format!("there is a column `{near}`; {needed}"),
        None => needed,
    }
}

/// Reads the rows of a table, a block at a time.
#[derive(Debug)]
pub struct RowReader {
    reader: Reader<File>,
    header: ByteRecord,
    columns: Columns,
    size: Option<u64>,
}

/// Rows of a table, and how far in the file they end; holds on to its memory when it is filled again.
#[derive(Debug, Default)]
pub struct Rows {
    rows: Vec<ByteRecord>,
    count: usize,
    end: u64,
}

impl Rows {
    /// The rows.
    pub fn as_slice(&self) -> &[ByteRecord] {
        &self.rows[..self.count]
    }

    /// Bytes of the file up to the end of the last row.
    pub fn end(&self) -> u64 {
        self.end
    }
}

impl RowReader {
    /// Opens a table that has the columns `wanted`, and none of those to be `added`.
    ///
    /// # Errors
    /// [`RowsError`].
    pub fn open(path: &Path, wanted: &[&'static str], added: &[&str]) -> Result<Self, RowsError> {
        let read = |source| RowsError::Read { path: path.to_owned(), source };
        let file = File::open(path).map_err(read)?;
        let metadata = file.metadata().map_err(read)?;
        let mut reader = ReaderBuilder::new().comment(Some(b'#')).buffer_capacity(1 << 18).from_reader(file);
        let header = reader.byte_headers().map_err(|e| table_error(path, e))?.clone();
        let columns = Columns::find(path, &header, wanted, added)?;
        Ok(Self { reader, header, columns, size: metadata.is_file().then_some(metadata.len()) })
    }

    /// Where the columns are.
    pub fn columns(&self) -> &Columns {
        &self.columns
    }

    /// The line of column names, those that were read.
    pub fn header(&self) -> &ByteRecord {
        &self.header
    }

    /// Size of the file in bytes; `None` for what is no file, as a pipe.
    pub fn size(&self) -> Option<u64> {
        self.size
    }

    /// Takes the next rows, at most `most`, in place of those in `rows`; there are none left when there are none.
    ///
    /// # Errors
    /// [`RowsError::Read`] or [`RowsError::Ragged`]; `rows` then holds those before it.
    pub fn read(&mut self, rows: &mut Rows, most: usize) -> Result<(), RowsError> {
        rows.count = 0;
        while rows.count < most {
            if rows.count == rows.rows.len() {
                rows.rows.push(ByteRecord::new());
            }
            match self.reader.read_byte_record(&mut rows.rows[rows.count]) {
                Ok(true) => rows.count += 1,
                Ok(false) => break,
                Err(error) => return Err(table_error(&self.columns.path, error)),
            }
        }
        rows.end = self.reader.position().byte();
        Ok(())
    }
}

fn table_error(path: &Path, error: csv::Error) -> RowsError {
    let path = path.to_owned();
    match error.into_kind() {
        ErrorKind::UnequalLengths { pos, expected_len, len } => {
            RowsError::Ragged { line: line(&path, pos.as_ref()), path, found: len, expected: expected_len }
        }
        ErrorKind::Io(source) => RowsError::Read { path, source },
        other => RowsError::Read { path, source: io::Error::other(format!("{other:?}")) },
    }
}

/// The line (from 1) of the row that begins at or after a position: what the reader counts leaves out the remarks and
/// empty lines before a row. Where the file cannot be read once more, the reader's count must do.
fn line(path: &Path, position: Option<&csv::Position>) -> u64 {
    let Some(position) = position else { return 0 };
    let is_file = fs::metadata(path).is_ok_and(|m| m.is_file());
    is_file.then(|| counted_line(path, position.byte()).ok()).flatten().unwrap_or(position.line())
}

fn counted_line(path: &Path, start: u64) -> io::Result<u64> {
    let mut file = BufReader::new(File::open(path)?);
    let (mut line, mut before) = (1, file.by_ref().take(start));
    loop {
        let buffer = before.fill_buf()?;
        if buffer.is_empty() {
            break;
        }
        line += buffer.iter().filter(|b| **b == b'\n').count() as u64;
        let length = buffer.len();
        before.consume(length);
    }
    let mut text = Vec::new();
    while file.read_until(b'\n', &mut text)? > 0 {
        if !(text.starts_with(b"#") || text.trim_ascii().is_empty()) {
            break;
        }
        line += 1;
        text.clear();
    }
    Ok(line)
}

/// Appends the fields of a row to `out`, quoted where they must be, without an end of line.
pub fn append_fields(out: &mut Vec<u8>, row: &ByteRecord) {
    let special = |b: &u8| matches!(b, b',' | b'"' | b'\n' | b'\r');
    let plain = !row.as_slice().iter().any(special);
    for (i, field) in row.iter().enumerate() {
        if i > 0 {
            out.push(b',');
        }
        // A row that began with `#` would be a remark.
        if (plain || !field.iter().any(special)) && !(i == 0 && field.starts_with(b"#")) {
            out.extend_from_slice(field);
            continue;
        }
        out.push(b'"');
        for &byte in field {
            out.extend_from_slice(if byte == b'"' { b"\"\"" } else { std::slice::from_ref(&byte) });
        }
        out.push(b'"');
    }
}

/// Appends numbers to `out`, a comma before each, with as many digits as it takes to read the same bits back.
pub fn append_numbers(out: &mut Vec<u8>, numbers: &[f64]) {
    let mut buffer = zmij::Buffer::new();
    for &number in numbers {
        out.push(b',');
        out.extend_from_slice(buffer.format(number).as_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn opened(text: &[u8]) -> (tempfile::TempDir, Result<RowReader, RowsError>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("in.csv");
        fs::write(&path, text).unwrap();
        let reader = RowReader::open(&path, &["x", "y"], &["sum"]);
        (folder, reader)
    }

    /// Reads to the end and returns what goes out, or the first error.
    fn through(text: &[u8]) -> Result<String, RowsError> {
        let (_folder, reader) = opened(text);
        let mut reader = reader?;
        let columns = reader.columns().clone();
        let (mut rows, mut out) = (Rows::default(), Vec::new());
        loop {
            reader.read(&mut rows, 2)?;
            if rows.as_slice().is_empty() {
                return Ok(String::from_utf8(out).unwrap());
            }
            for row in rows.as_slice() {
                let [x, y] = columns.numbers(row)?;
                append_fields(&mut out, row);
                append_numbers(&mut out, &[x + y]);
                out.push(b'\n');
            }
        }
    }

    #[test]
    fn columns_come_in_any_order_and_the_others_are_carried_through() {
        let text = b"\xef\xbb\xbfname,y, x \n\"a, \"\"b\"\"\",1,2\n\n# remark\n\"# c\",0.5, 1e-3 \nd,1,1\n";
        assert_eq!(through(text).unwrap(), "\"a, \"\"b\"\"\",1,2,3.0\n\"# c\",0.5, 1e-3 ,0.501\nd,1,1,2.0\n");
        assert_eq!(through(b"x,y\r\n1,2\r\n").unwrap(), "1,2,3.0\n");
        assert_eq!(through(b"x,y\n").unwrap(), "");
    }

    #[test]
    fn places_are_those_an_editor_shows() {
        for end in ["\n", "\r\n"] {
            let head = ["# a remark", "", "x,y,t", "1,2,t", "# another", "", "3,4,\"two", "lines\"", "5,6,t"].join(end);
            for (row, part) in [
                ("7,z,t", "line 10, column `y`: `z` is not a number"),
                ("7,,t", "line 10, column `y`: `` is not a number"),
                ("nan,1,t", "line 10, column `x`: `nan` is not a number"),
                ("1,inf,t", "`inf` is not a number"),
                ("1,2", "line 10: 2 fields where there are 3 columns"),
                ("#\n\n\n1,1e999,t", "line 13, column `y`: `1e999` is not a number"),
            ] {
                let error = through([&head, row].join(end).as_bytes()).unwrap_err().to_string();
                assert!(error.contains(part), "{end:?} {row}: {error}");
            }
        }
    }

    #[test]
    fn tables_that_will_not_do_are_refused() {
        assert!(matches!(through(b""), Err(RowsError::Empty { .. })));
        assert!(matches!(through(b"x,y,y\n"), Err(RowsError::Twice { column, .. }) if column == "y"));
        assert!(matches!(through(b"x,y,sum\n"), Err(RowsError::Taken { column, .. }) if column == "sum"));
        assert!(matches!(RowReader::open(Path::new("/no/such"), &[], &[]), Err(RowsError::Read { .. })));
        let help = |text: &[u8]| match through(text) {
            Err(RowsError::Missing { help, .. }) => help,
            other => panic!("{other:?}"),
        };
        assert_eq!(help(b"X,y\n"), "there is a column `X`; the columns needed are x, y");
        assert_eq!(help(b"y,radius\n"), "the columns needed are x, y");
        assert_eq!(help(b"x;y\n"), "columns are separated by commas; the columns needed are x, y");
    }
}
