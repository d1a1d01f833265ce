//! How thick a slab is: a length or an optical thickness, either of which may have no end.

use std::fmt;
use std::str::FromStr;

use super::{Length, QuantityError, shifted, split_number};

/// Words for what has no end.
const ENDLESS: [&str; 4] = ["inf", "infinite", "infinity", "∞"];

/// The thickness of a layer: a length from zero up, or endless. Parses "1mm", "0.2 cm", "inf".
///
/// What is printed parses to the same bits.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Thickness {
    /// Between two planes.
    Finite(Length),
    /// A half-space.
    Infinite,
}

impl Thickness {
    /// In metres; infinite for a half-space.
    pub fn metres(self) -> f64 {
        match self {
            Self::Finite(length) => length.metres(),
            Self::Infinite => f64::INFINITY,
        }
    }
}

impl FromStr for Thickness {
    type Err = QuantityError;

    fn from_str(text: &str) -> Result<Self, QuantityError> {
        if ENDLESS.contains(&text.trim()) { Ok(Self::Infinite) } else { text.parse().map(Self::Finite) }
    }
}

impl fmt::Display for Thickness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Finite(length) => length.fmt(f),
            Self::Infinite => f.write_str("inf"),
        }
    }
}

impl TryFrom<String> for Thickness {
    type Error = QuantityError;

    fn try_from(text: String) -> Result<Self, QuantityError> {
        text.parse()
    }
}

impl From<Thickness> for String {
    fn from(thickness: Thickness) -> Self {
        thickness.to_string()
    }
}

/// Extinction coefficient times thickness: a number from zero up, or endless. Parses "2", "1e-3", "inf".
///
/// What is printed parses to the same bits.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct OpticalThickness(f64);

impl OpticalThickness {
    /// The number; infinite for a half-space.
    pub fn value(self) -> f64 {
        self.0
    }
}

impl FromStr for OpticalThickness {
    type Err = QuantityError;

    fn from_str(text: &str) -> Result<Self, QuantityError> {
        let text = text.trim();
        if ENDLESS.contains(&text) {
            return Ok(Self(f64::INFINITY));
        }
        let (number, rest) = split_number(text);
        if number.is_empty() {
            return Err(QuantityError::NotANumber { text: text.to_owned(), example: "2" });
        }
        if !rest.trim().is_empty() {
            let expected = "an optical thickness is a number without a unit, or `inf`";
            return Err(QuantityError::Form { text: text.to_owned(), expected });
        }
        match shifted(number, 0) {
            Some(value) if value >= 0.0 && value.is_finite() => Ok(Self(value.abs())),
            _ => Err(QuantityError::OutOfRange {
                text: text.to_owned(),
                allowed: "an optical thickness is a finite number from 0 up, or `inf`",
            }),
        }
    }
}

impl fmt::Display for OpticalThickness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0)
    }
}

impl TryFrom<String> for OpticalThickness {
    type Error = QuantityError;

    fn try_from(text: String) -> Result<Self, QuantityError> {
        text.parse()
    }
}

impl From<OpticalThickness> for String {
    fn from(thickness: OpticalThickness) -> Self {
        thickness.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_and_numbers_may_have_no_end() {
        assert_eq!("1mm".parse::<Thickness>().unwrap().metres(), 1e-3);
        assert_eq!(" inf ".parse::<Thickness>().unwrap(), Thickness::Infinite);
        assert_eq!("0.25".parse::<OpticalThickness>().unwrap().value(), 0.25);
        assert_eq!("inf".parse::<OpticalThickness>().unwrap().value(), f64::INFINITY);
        for text in ["1mm", "17.5 µm", "inf"] {
            let thickness: Thickness = text.parse().unwrap();
            assert_eq!(thickness.to_string().parse::<Thickness>().unwrap(), thickness);
        }
        for text in ["0", "2e-9", "1e300", "inf"] {
            let thickness: OpticalThickness = text.parse().unwrap();
            assert_eq!(thickness.to_string().parse::<OpticalThickness>().unwrap(), thickness);
        }
    }

    #[test]
    fn what_is_no_thickness_says_why() {
        for (text, part) in [("-1mm", "zero or more"), ("1", "no unit"), ("thick", "number"), ("", "number")] {
            let error = text.parse::<Thickness>().unwrap_err().to_string();
            assert!(error.contains(part), "{text}: {error}");
        }
        for (text, part) in [("-1", "from 0 up"), ("1mm", "without a unit"), ("nan", "number"), ("1e999", "from 0 up")]
        {
            let error = text.parse::<OpticalThickness>().unwrap_err().to_string();
            assert!(error.contains(part), "{text}: {error}");
        }
    }
}
