//! NetCDF files (classic NetCDF-3, which every reader of NetCDF reads): dimensions, variables with units, remarks.
//!
//! The format is `rew1990`. A data set is put together with every name and length checked, and written in one go.

use std::cell::RefCell;
use std::io::{self, Cursor, Seek, SeekFrom, Write};
use std::rc::Rc;

use netcdf3::{DataSet, FileWriter, InvalidDataSet, Version, WriteError};

/// What keeps a data set from being written.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NetCdfError {
    /// A variable along a dimension that is not there.
    #[error("the variable `{variable}` lies along `{dimension}`, which is no dimension of the data set")]
    NoSuchDimension {
        /// Name of the variable.
        variable: String,
        /// Name of the dimension.
        dimension: String,
    },
    /// A variable with another number of values than its dimensions have places.
    #[error("the variable `{variable}` has {found} values where its dimensions have {expected} places")]
    Length {
        /// Name of the variable.
        variable: String,
        /// How many values it has.
        found: usize,
        /// How many it should have.
        expected: usize,
    },
    /// What the format does not hold: a name with a space or a slash, one that is taken, an empty dimension.
    #[error("no NetCDF file holds this: {reason}")]
    Definition {
        /// What is wrong.
        reason: String,
    },
}

/// What a remark says.
#[derive(Debug, Clone, PartialEq)]
pub enum Attribute {
    /// Words.
    Text(String),
    /// A number.
    Number(f64),
}

impl From<&str> for Attribute {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}

impl From<String> for Attribute {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f64> for Attribute {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

/// Values along dimensions, the last of which runs fastest. A variable named like its only dimension is its coordinate.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    name: String,
    dimensions: Vec<String>,
    attributes: Vec<(String, Attribute)>,
    values: Values,
}

#[derive(Debug, Clone, PartialEq)]
enum Values {
    Numbers(Vec<f64>),
    /// As rows of characters, along a further dimension.
    Words(Vec<String>),
}

impl Variable {
    /// Double-precision values along dimensions; along none a single value.
    pub fn new(name: impl Into<String>, dimensions: &[&str], values: Vec<f64>) -> Self {
        Self::with_values(name.into(), dimensions, Values::Numbers(values))
    }

    /// Words along dimensions.
    pub fn words(name: impl Into<String>, dimensions: &[&str], values: &[&str]) -> Self {
        let values = Values::Words(values.iter().map(|word| (*word).to_owned()).collect());
        Self::with_values(name.into(), dimensions, values)
    }

    fn with_values(name: String, dimensions: &[&str], values: Values) -> Self {
        let dimensions = dimensions.iter().map(|name| (*name).to_owned()).collect();
        Self { name, dimensions, attributes: Vec::new(), values }
    }

    /// Adds a remark: `units`, `long_name`, `standard_name` and the like, by the CF conventions (`cf2022`).
    pub fn with(mut self, name: impl Into<String>, value: impl Into<Attribute>) -> Self {
        self.attributes.push((name.into(), value.into()));
        self
    }
}

/// A data set in memory.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NetCdf {
    dimensions: Vec<(String, usize)>,
    attributes: Vec<(String, Attribute)>,
    variables: Vec<Variable>,
}

impl NetCdf {
    /// With nothing in it.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a remark about the whole: `title`, `source`, `Conventions`.
    pub fn with_attribute(mut self, name: impl Into<String>, value: impl Into<Attribute>) -> Self {
        self.attributes.push((name.into(), value.into()));
        self
    }

    /// Adds a dimension.
    pub fn with_dimension(mut self, name: impl Into<String>, length: usize) -> Self {
        self.dimensions.push((name.into(), length));
        self
    }

    /// Adds a variable, after the dimensions it lies along.
    ///
    /// # Errors
    /// [`NetCdfError::NoSuchDimension`] or [`NetCdfError::Length`].
    pub fn with_variable(mut self, variable: Variable) -> Result<Self, NetCdfError> {
        let mut expected = 1usize;
        for name in &variable.dimensions {
            let Some((_, length)) = self.dimensions.iter().find(|(known, _)| known == name) else {
                return Err(NetCdfError::NoSuchDimension { variable: variable.name, dimension: name.clone() });
            };
            expected = expected.saturating_mul(*length);
        }
        let found = match &variable.values {
            Values::Numbers(values) => values.len(),
            Values::Words(words) => words.len(),
        };
        if found != expected {
            return Err(NetCdfError::Length { variable: variable.name, found, expected });
        }
        self.variables.push(variable);
        Ok(self)
    }

    /// The bytes of the file.
    ///
    /// # Errors
    /// [`NetCdfError::Definition`] for names that the format does not hold or that are there twice.
    pub fn to_bytes(&self) -> Result<Vec<u8>, NetCdfError> {
        let definition = self.definition().map_err(|e| NetCdfError::Definition { reason: format!("{e:?}") })?;
        let bytes = Memory::default();
        self.fill(&definition, bytes.clone()).map_err(|e| NetCdfError::Definition { reason: format!("{e:?}") })?;
        Ok(bytes.0.take().into_inner())
    }

    fn definition(&self) -> Result<DataSet, InvalidDataSet> {
        let mut set = DataSet::new();
        for (name, length) in &self.dimensions {
            set.add_fixed_dim(name, *length)?;
        }
        for (name, value) in &self.attributes {
            match value {
                Attribute::Text(text) => set.add_global_attr_string(name, text)?,
                Attribute::Number(number) => set.add_global_attr_f64(name, vec![*number])?,
            }
        }
        for variable in &self.variables {
            let name = &variable.name;
            let mut along = variable.dimensions.clone();
            match &variable.values {
                Values::Numbers(_) => set.add_var_f64(name, &along)?,
                Values::Words(words) => {
                    let letters = format!("{name}_letters");
                    set.add_fixed_dim(&letters, longest(words))?;
                    along.push(letters);
                    set.add_var_u8(name, &along)?;
                }
            }
            for (key, value) in &variable.attributes {
                match value {
                    Attribute::Text(text) => set.add_var_attr_string(name, key, text)?,
                    Attribute::Number(number) => set.add_var_attr_f64(name, key, vec![*number])?,
                }
            }
        }
        Ok(set)
    }

    fn fill(&self, definition: &DataSet, out: Memory) -> Result<(), WriteError> {
        let mut writer = FileWriter::open_seek_write("memory", Box::new(out))?;
        // Classic files end at 2 GiB; the other kind has wider offsets and is as widely read.
        let numbers: usize =
            self.variables.iter().map(|v| if let Values::Numbers(v) = &v.values { v.len() } else { 0 }).sum();
        let version = if numbers < 1 << 27 { Version::Classic } else { Version::Offset64Bit };
        writer.set_def(definition, version, 0)?;
        for variable in &self.variables {
            match &variable.values {
                Values::Numbers(values) => writer.write_var_f64(&variable.name, values)?,
                Values::Words(words) => {
                    let width = longest(words);
                    let letters = words.iter().flat_map(|word| {
                        let padding = std::iter::repeat_n(0, width - word.len());
                        word.bytes().chain(padding)
                    });
                    writer.write_var_u8(&variable.name, &letters.collect::<Vec<u8>>())?;
                }
            }
        }
        writer.close()
    }
}

/// Bytes of the longest word; at least one, as no dimension is empty.
fn longest(words: &[String]) -> usize {
    words.iter().map(String::len).max().unwrap_or(0).max(1)
}

/// Bytes that outlive the writer they are lent to.
#[derive(Debug, Clone, Default)]
struct Memory(Rc<RefCell<Cursor<Vec<u8>>>>);

impl Write for Memory {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Memory {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.borrow_mut().seek(to)
    }
}

#[cfg(test)]
mod tests {
    use netcdf3::FileReader;

    use super::*;

    fn two_by_three() -> NetCdf {
        NetCdf::new()
            .with_attribute("title", "A table")
            .with_attribute("tolerance", 1e-4)
            .with_dimension("w", 2)
            .with_dimension("mu", 3)
            .with_variable(Variable::new("w", &["w"], vec![400.0, 500.0]).with("units", "nm"))
            .unwrap()
            .with_variable(Variable::new("phase", &["w", "mu"], vec![0.1, 0.2, 0.3, f64::MIN_POSITIVE, -5.0, 1e300]))
            .unwrap()
            .with_variable(Variable::words("element", &["w"], &["11", "a-b"]))
            .unwrap()
            .with_variable(Variable::new("scalar", &[], vec![7.0]).with("limit", 2.5))
            .unwrap()
    }

    #[test]
    fn what_was_written_is_read_back() {
        let bytes = two_by_three().to_bytes().unwrap();
        assert_eq!(&bytes[..4], b"CDF\x01");
        let mut reader = FileReader::open_seek_read("memory", Box::new(Cursor::new(bytes))).unwrap();
        let set = reader.data_set();
        assert_eq!(set.get_global_attr_as_string("title").unwrap(), "A table");
        assert_eq!(set.get_global_attr_f64("tolerance"), Some(&[1e-4][..]));
        assert_eq!(set.get_var_attr_as_string("w", "units").unwrap(), "nm");
        assert_eq!(set.get_var_attr_f64("scalar", "limit"), Some(&[2.5][..]));
        assert_eq!(
            (set.dim_size("w"), set.dim_size("mu"), set.dim_size("element_letters")),
            (Some(2), Some(3), Some(3))
        );
        assert_eq!(reader.read_var_f64("w").unwrap(), [400.0, 500.0]);
        assert_eq!(reader.read_var_f64("phase").unwrap(), [0.1, 0.2, 0.3, f64::MIN_POSITIVE, -5.0, 1e300]);
        assert_eq!(reader.read_var_f64("scalar").unwrap(), [7.0]);
        assert_eq!(reader.read_var_u8("element").unwrap(), b"11\0a-b");
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let error = two_by_three().with_variable(Variable::new("x", &["w"], vec![1.0])).unwrap_err();
        assert_eq!(error, NetCdfError::Length { variable: "x".into(), found: 1, expected: 2 });
        let error = two_by_three().with_variable(Variable::new("x", &["z"], vec![1.0])).unwrap_err();
        assert!(error.to_string().contains("`z`"), "{error}");
        let twice = two_by_three().with_variable(Variable::new("w", &["w"], vec![1.0, 2.0])).unwrap();
        assert!(matches!(twice.to_bytes(), Err(NetCdfError::Definition { .. })));
        let slash = NetCdf::new().with_dimension("a/b", 1);
        assert!(matches!(slash.to_bytes(), Err(NetCdfError::Definition { .. })));
    }
}
