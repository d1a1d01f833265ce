//! Quantities as people type and read them: "550nm", "400nm:700nm:25nm", "2%", "640x480", "1.5+0.01i".
//!
//! Parsing asks for a unit wherever one could be mistaken, and shifts the decimal exponent of the text rather than
//! multiplying, so that "550nm" is the same number as `550e-9`.

mod amount;
mod angles;
mod concentration;
mod format;
mod index;
mod thickness;

use std::fmt;
use std::str::FromStr;

use mieux_optics::Complex64;
use mieux_optics::spectrum::{SpectrumError, WavelengthGrid};

pub use amount::{parse_mass_density, parse_number_density};
pub use angles::Angles;
pub use concentration::parse_concentration;
pub use format::{format_area, format_complex_index, format_duration, format_length, format_per_length, significant};
pub use index::RefractiveIndex;
pub use thickness::{OpticalThickness, Thickness};

/// Units of length and the power of ten that makes metres of them.
const LENGTH_UNITS: [(&str, i32); 9] = [
    ("nm", -9),
    ("um", -6),
    ("µm", -6),
    ("\u{3bc}m", -6), // the Greek letter looks like the micro sign
    ("mm", -3),
    ("cm", -2),
    ("dm", -1),
    ("m", 0),
    ("km", 3),
];
const LENGTH_UNIT_NAMES: &str = "nm, um (or µm), mm, cm, dm, m, km";

/// Units of time in seconds.
const TIME_UNITS: [(&str, f64); 6] =
    [("ms", 1e-3), ("s", 1.0), ("min", 60.0), ("h", 3600.0), ("d", 86_400.0), ("day", 86_400.0)];
const TIME_UNIT_NAMES: &str = "ms, s, min, h, d";

/// What can be wrong with a typed quantity. Every message names the text it is about and what would do.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum QuantityError {
    /// No number where one should be.
    #[error("`{text}` does not start with a number; write for example `{example}`")]
    NotANumber {
        /// What was typed.
        text: String,
        /// Something that would do.
        example: &'static str,
    },
    /// A bare number where a unit is needed.
    #[error("`{text}` has no unit; add one of {units}, as in `{example}`")]
    MissingUnit {
        /// What was typed.
        text: String,
        /// The units that would do.
        units: &'static str,
        /// Something that would do.
        example: &'static str,
    },
    /// A unit that is not known here.
    #[error("`{unit}` in `{text}` is not a unit known here; use one of {units}")]
    UnknownUnit {
        /// What was typed.
        text: String,
        /// The unit in it.
        unit: String,
        /// The units that would do.
        units: &'static str,
    },
    /// A number outside what is allowed.
    #[error("`{text}` is out of range; {allowed}")]
    OutOfRange {
        /// What was typed.
        text: String,
        /// What is allowed, in words.
        allowed: &'static str,
    },
    /// Not written the way such a quantity is.
    #[error("`{text}` is not understood; {expected}")]
    Form {
        /// What was typed.
        text: String,
        /// What it should look like.
        expected: &'static str,
    },
    /// Wavelengths that make no grid.
    #[error("`{text}` makes no set of wavelengths: {source}")]
    Grid {
        /// What was typed.
        text: String,
        /// Why.
        source: SpectrumError,
    },
}

/// A length in metres, zero or more and finite. Parses "550nm", "0.5 µm", "3 mm", "1e-6 m".
///
/// Printing chooses the unit and keeps every digit, so that what is printed parses to the same bits.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Length(f64);

impl Length {
    /// The wavelength of green light, 550 nm.
    pub const GREEN: Self = Self(550e-9);

    /// Takes a length in metres.
    ///
    /// # Errors
    /// [`QuantityError::OutOfRange`] unless it is zero or more and finite.
    pub fn from_metres(metres: f64) -> Result<Self, QuantityError> {
        if metres >= 0.0 && metres.is_finite() {
            return Ok(Self(metres.abs()));
        }
        Err(QuantityError::OutOfRange { text: format!("{metres} m"), allowed: "a length is zero or more and finite" })
    }

    /// As [`str::parse`], and more than zero.
    ///
    /// # Errors
    /// [`QuantityError`] that says what would do.
    pub fn parse_positive(text: &str) -> Result<Self, QuantityError> {
        let length: Self = text.parse()?;
        if length.0 > 0.0 {
            return Ok(length);
        }
        Err(QuantityError::OutOfRange { text: text.trim().to_owned(), allowed: "it must be more than zero" })
    }

    /// The length in metres.
    pub fn metres(self) -> f64 {
        self.0
    }
}

impl FromStr for Length {
    type Err = QuantityError;

    fn from_str(text: &str) -> Result<Self, QuantityError> {
        let text = text.trim();
        let example = "550nm";
        let (number, unit) = split_number(text);
        if number.is_empty() {
            return Err(QuantityError::NotANumber { text: text.to_owned(), example });
        }
        let unit = unit.trim();
        if unit.is_empty() {
            return Err(QuantityError::MissingUnit { text: text.to_owned(), units: LENGTH_UNIT_NAMES, example });
        }
        let Some(&(_, power)) = LENGTH_UNITS.iter().find(|(name, _)| *name == unit) else {
            let (text, unit) = (text.to_owned(), unit.to_owned());
            return Err(QuantityError::UnknownUnit { text, unit, units: LENGTH_UNIT_NAMES });
        };
        let metres =
            shifted(number, power).ok_or_else(|| QuantityError::NotANumber { text: text.to_owned(), example })?;
        Self::from_metres(metres).map_err(|_| QuantityError::OutOfRange {
            text: text.to_owned(),
            allowed: "a length is zero or more and finite",
        })
    }
}

impl fmt::Display for Length {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&format::exact_length(self.0))
    }
}

impl TryFrom<String> for Length {
    type Error = QuantityError;

    fn try_from(text: String) -> Result<Self, QuantityError> {
        text.parse()
    }
}

impl From<Length> for String {
    fn from(length: Length) -> Self {
        length.to_string()
    }
}

/// Vacuum wavelengths from "550nm", "450nm,550nm,650nm" (any order, repeats dropped) or "400nm:700nm:25nm"
/// (start : stop : step, both ends included where the step allows).
///
/// # Errors
/// [`QuantityError`]: a part that is no positive length, or a range that no grid follows.
pub fn parse_wavelengths(text: &str) -> Result<WavelengthGrid, QuantityError> {
    let text = text.trim();
    let grid_error = |source| QuantityError::Grid { text: text.to_owned(), source };
    if text.contains(':') {
        let parts = text.split(':').collect::<Vec<_>>();
        let &[start, stop, step] = parts.as_slice() else {
            let expected = "a range of wavelengths is start:stop:step, as in `400nm:700nm:25nm`";
            return Err(QuantityError::Form { text: text.to_owned(), expected });
        };
        let [start, stop, step] =
            [Length::parse_positive(start)?, Length::parse_positive(stop)?, Length::parse_positive(step)?];
        let grid = WavelengthGrid::regular(start.0, stop.0, step.0).map_err(grid_error)?;
        return WavelengthGrid::new(grid.iter().map(snapped).collect()).map_err(grid_error);
    }
    let mut wavelengths = Vec::new();
    for part in text.split(',') {
        wavelengths.push(Length::parse_positive(part)?.metres());
    }
    wavelengths.sort_by(f64::total_cmp);
    wavelengths.dedup();
    WavelengthGrid::new(wavelengths).map_err(grid_error)
}

/// The wavelength as it would be typed in femtometres, when adding up steps has moved it by rounding alone.
fn snapped(wavelength_m: f64) -> f64 {
    let typed = (wavelength_m * 1e15).round() / 1e15;
    if ((typed - wavelength_m) / wavelength_m).abs() < 1e-12 { typed } else { wavelength_m }
}

/// Width and height of an image in pixels, "640x480": each 1 to 16 384, and no more than 100 million pixels in all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Size {
    width: u32,
    height: u32,
}

impl Size {
    /// The longest side allowed, pixels.
    pub const MAX_SIDE: u32 = 16_384;
    /// The most pixels allowed.
    pub const MAX_PIXELS: u64 = 100_000_000;
    const ALLOWED: &str = "each side is 1 to 16384 pixels, and there are at most 100 million pixels";

    /// Takes a width and a height in pixels.
    ///
    /// # Errors
    /// [`QuantityError::OutOfRange`] when a side or the product is out of range.
    pub fn new(width: u32, height: u32) -> Result<Self, QuantityError> {
        let side = 1..=Self::MAX_SIDE;
        let pixels = u64::from(width) * u64::from(height);
        if side.contains(&width) && side.contains(&height) && pixels <= Self::MAX_PIXELS {
            return Ok(Self { width, height });
        }
        Err(QuantityError::OutOfRange { text: format!("{width}x{height}"), allowed: Self::ALLOWED })
    }

    /// Pixels in a row.
    pub fn width(self) -> u32 {
        self.width
    }

    /// Rows of pixels.
    pub fn height(self) -> u32 {
        self.height
    }

    /// Width times height.
    pub fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }
}

impl FromStr for Size {
    type Err = QuantityError;

    fn from_str(text: &str) -> Result<Self, QuantityError> {
        let text = text.trim();
        let form =
            || QuantityError::Form { text: text.to_owned(), expected: "a size is width x height, as in `640x480`" };
        let (width, height) = text.split_once(['x', 'X', '×']).ok_or_else(form)?;
        let side = |part: &str| {
            let part = part.trim();
            if part.is_empty() || !part.bytes().all(|b| b.is_ascii_digit()) {
                return Err(form());
            }
            // Too many digits for an integer is too many pixels.
            part.parse::<u32>().map_err(|_| QuantityError::OutOfRange { text: text.to_owned(), allowed: Self::ALLOWED })
        };
        Self::new(side(width)?, side(height)?)
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

impl TryFrom<String> for Size {
    type Error = QuantityError;

    fn try_from(text: String) -> Result<Self, QuantityError> {
        text.parse()
    }
}

impl From<Size> for String {
    fn from(size: Size) -> Self {
        size.to_string()
    }
}

/// Seconds from "60s", "2min", "1.5h", or several together as in "1h 30min".
///
/// # Errors
/// [`QuantityError`]: no number, no unit, an unknown unit, or a total that is not more than zero and finite.
pub fn parse_duration(text: &str) -> Result<f64, QuantityError> {
    let text = text.trim();
    let example = "2min";
    let mut seconds = 0.0;
    let mut rest = text;
    loop {
        let (number, after) = split_number(rest);
        let value: f64 = number.parse().map_err(|_| QuantityError::NotANumber { text: text.to_owned(), example })?;
        let after = after.trim_start();
        let end = after.find(|c: char| !c.is_alphabetic()).unwrap_or(after.len());
        let (unit, next) = after.split_at(end);
        if unit.is_empty() {
            return Err(QuantityError::MissingUnit { text: text.to_owned(), units: TIME_UNIT_NAMES, example });
        }
        let Some(&(_, unit_s)) = TIME_UNITS.iter().find(|(name, _)| *name == unit) else {
            let (text, unit) = (text.to_owned(), unit.to_owned());
            return Err(QuantityError::UnknownUnit { text, unit, units: TIME_UNIT_NAMES });
        };
        // A part that is negative must not hide behind one that is not.
        seconds += if value >= 0.0 { value * unit_s } else { f64::NAN };
        rest = next.trim_start();
        if rest.is_empty() {
            break;
        }
    }
    if seconds > 0.0 && seconds.is_finite() {
        return Ok(seconds);
    }
    Err(QuantityError::OutOfRange { text: text.to_owned(), allowed: "a duration is more than zero and finite" })
}

/// A part of a whole, in (0, 1], from "2%" or "0.02".
///
/// # Errors
/// [`QuantityError`]: no number, another sign than `%` after it, or a value outside (0, 1].
pub fn parse_fraction(text: &str) -> Result<f64, QuantityError> {
    let text = text.trim();
    let not_a_number = || QuantityError::NotANumber { text: text.to_owned(), example: "2%" };
    let (number, unit) = split_number(text);
    let value = match unit.trim() {
        "" => shifted(number, 0),
        "%" => shifted(number, -2),
        _ if number.is_empty() => None,
        unit => {
            let unit = unit.to_owned();
            return Err(QuantityError::UnknownUnit { text: text.to_owned(), unit, units: "% or nothing at all" });
        }
    };
    let value = value.ok_or_else(not_a_number)?;
    if value > 0.0 && value <= 1.0 {
        return Ok(value);
    }
    let allowed = "a fraction is more than 0 and at most 1 (100%)";
    Err(QuantityError::OutOfRange { text: text.to_owned(), allowed })
}

/// A complex refractive index from "1.33", "1.5+0.01i" or "1.33 + 1e-9i": the real part is more than 0, the imaginary
/// part 0 (transparent) or more (absorbing).
///
/// # Errors
/// [`QuantityError`]: not of that form, or a part out of range.
pub fn parse_complex_index(text: &str) -> Result<Complex64, QuantityError> {
    let text = text.trim();
    let form = || QuantityError::Form {
        text: text.to_owned(),
        expected: "a refractive index is a number, or two as in `1.5+0.01i`",
    };
    let (real, rest) = split_number(text);
    let rest = rest.trim();
    if real.is_empty() {
        return Err(QuantityError::NotANumber { text: text.to_owned(), example: "1.5+0.01i" });
    }
    let real: f64 = real.parse().map_err(|_| form())?;
    let imaginary = if rest.is_empty() { 0.0 } else { imaginary_part(rest).ok_or_else(form)? };
    let out_of_range = |allowed| Err(QuantityError::OutOfRange { text: text.to_owned(), allowed });
    if !(real > 0.0 && real.is_finite()) {
        return out_of_range("the real part of a refractive index is more than 0 and finite");
    }
    if !(imaginary >= 0.0 && imaginary.is_finite()) {
        return out_of_range(
            "the imaginary part of a refractive index is 0 or more: here a positive one absorbs, \
             so write `n+ki` where others write `n-ki`",
        );
    }
    Ok(Complex64::new(real, imaginary))
}

/// The number in "+ 0.01i" or "-3j"; `None` where it is not of that form.
fn imaginary_part(text: &str) -> Option<f64> {
    let (sign, rest) = match text.strip_prefix('+') {
        Some(rest) => (1.0, rest),
        None => (-1.0, text.strip_prefix(['-', '\u{2212}'])?),
    };
    let (number, unit) = split_number(rest.trim_start());
    let unsigned = !number.starts_with(['+', '-']);
    (matches!(unit.trim(), "i" | "j") && unsigned).then(|| number.parse::<f64>().ok().map(|v| sign * v + 0.0))?
}

/// The number a text starts with, and what follows it. The number is empty where there is none.
fn split_number(text: &str) -> (&str, &str) {
    let bytes = text.as_bytes();
    let digits_from = |from: usize| from + bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
    let start = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    let mut end = digits_from(start);
    let mut digits = end - start;
    if bytes.get(end) == Some(&b'.') {
        let after = digits_from(end + 1);
        digits += after - (end + 1);
        end = after;
    }
    if digits == 0 {
        return ("", text);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let after = digits_from(end + 1 + sign);
        if after > end + 1 + sign {
            end = after;
        }
    }
    text.split_at(end)
}

/// The value of a decimal number times a power of ten, rounded once. `None` when it is no number.
fn shifted(number: &str, power: i32) -> Option<f64> {
    let (digits, exponent) = match number.split_once(['e', 'E']) {
        Some((digits, exponent)) => (digits, exponent.parse::<i32>().ok()?),
        None => (number, 0),
    };
    format!("{digits}e{}", exponent.checked_add(power)?).parse().ok()
}

#[cfg(test)]
mod tests;
