//! A refractive index as a value that can be written down.

use std::fmt;
use std::str::FromStr;

use mieux_optics::Complex64;

use super::{QuantityError, format_complex_index, parse_complex_index};

/// A complex refractive index, `n + k i` with `n > 0` and `k >= 0` (absorbing). Parses "1.33", "1.5+0.01i".
///
/// What is printed parses to the same bits.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct RefractiveIndex(Complex64);

impl RefractiveIndex {
    /// Of empty space.
    pub const VACUUM: Self = Self(Complex64::ONE);

    /// The number.
    pub fn value(self) -> Complex64 {
        self.0
    }
}

impl FromStr for RefractiveIndex {
    type Err = QuantityError;

    fn from_str(text: &str) -> Result<Self, QuantityError> {
        parse_complex_index(text).map(Self)
    }
}

impl fmt::Display for RefractiveIndex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&format_complex_index(self.0))
    }
}

impl TryFrom<String> for RefractiveIndex {
    type Error = QuantityError;

    fn try_from(text: String) -> Result<Self, QuantityError> {
        text.parse()
    }
}

impl From<RefractiveIndex> for String {
    fn from(index: RefractiveIndex) -> Self {
        index.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_index_is_written_down_as_it_is_typed() {
        let index: RefractiveIndex = "1.5 + 1e-3i".parse().unwrap();
        assert_eq!(index.value(), Complex64::new(1.5, 1e-3));
        let json = serde_json::to_string(&index).unwrap();
        assert_eq!(json, "\"1.5+0.001i\"");
        assert_eq!(serde_json::from_str::<RefractiveIndex>(&json).unwrap(), index);
        assert!(serde_json::from_str::<RefractiveIndex>("\"1.5-0.1i\"").is_err());
        assert_eq!(RefractiveIndex::VACUUM.to_string(), "1");
    }
}
