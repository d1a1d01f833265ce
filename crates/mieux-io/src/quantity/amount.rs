//! How much of something: densities, concentrations and numbers per volume.

use super::QuantityError;

const MASS_UNITS: [(&str, f64); 17] = [
    ("kg/m3", 1.0),
    ("kg/m^3", 1.0),
    ("g/L", 1.0),
    ("g/l", 1.0),
    ("mg/mL", 1.0),
    ("mg/ml", 1.0),
    ("kg/L", 1e3),
    ("g/cm3", 1e3),
    ("g/cm^3", 1e3),
    ("g/mL", 1e3),
    ("g/ml", 1e3),
    ("mg/L", 1e-3),
    ("g/m3", 1e-3),
    ("g/m^3", 1e-3),
    ("mg/m3", 1e-6),
    ("mg/m^3", 1e-6),
    ("ug/m3", 1e-9),
];
const MASS_UNIT_NAMES: &str = "kg/m3, g/cm3, g/mL, g/L, mg/L, g/m3, mg/m3, ug/m3";

const NUMBER_UNITS: [(&str, f64); 10] = [
    ("/m3", 1.0),
    ("/m^3", 1.0),
    ("/L", 1e3),
    ("/l", 1e3),
    ("/cm3", 1e6),
    ("/cm^3", 1e6),
    ("/mL", 1e6),
    ("/ml", 1e6),
    ("/mm3", 1e9),
    ("/um3", 1e18),
];
const NUMBER_UNIT_NAMES: &str = "/m3, /L, /cm3, /mL, /mm3, /um3";

/// A mass per volume, "1.05 g/mL", in kg/m^3, zero or more.
///
/// # Errors
/// [`QuantityError`] that says what would do.
pub fn parse_mass_density(text: &str) -> Result<f64, QuantityError> {
    per_volume(text, &MASS_UNITS, MASS_UNIT_NAMES, "1.05 g/mL")
}

/// A number per volume, "1e9/cm3", in 1/m^3, zero or more.
///
/// # Errors
/// [`QuantityError`] that says what would do.
pub fn parse_number_density(text: &str) -> Result<f64, QuantityError> {
    per_volume(text, &NUMBER_UNITS, NUMBER_UNIT_NAMES, "1e9/cm3")
}

fn per_volume(
    text: &str,
    known: &[(&str, f64)],
    units: &'static str,
    example: &'static str,
) -> Result<f64, QuantityError> {
    let typed = text.trim();
    // The longest beginning that is a number: an exponent looks like the start of a unit.
    let ends = (1..=typed.len()).rev().filter(|end| typed.is_char_boundary(*end));
    let number = ends.filter_map(|end| Some((typed[..end].trim_end().parse::<f64>().ok()?, end))).next();
    let Some((value, end)) = number else {
        return Err(QuantityError::NotANumber { text: typed.into(), example });
    };
    let unit = typed[end..].trim().trim_start_matches('1').trim_start();
    if unit.is_empty() {
        return Err(QuantityError::MissingUnit { text: typed.into(), units, example });
    }
    let Some((_, factor)) = known.iter().find(|(name, _)| *name == unit) else {
        return Err(QuantityError::UnknownUnit { text: typed.into(), unit: unit.into(), units });
    };
    let value = value * factor;
    if value >= 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(QuantityError::OutOfRange { text: typed.into(), allowed: "it must be zero or more and finite" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_come_to_si() {
        assert_eq!(parse_mass_density("1.05 g/mL"), Ok(1050.0));
        assert_eq!(parse_mass_density("2 g/L"), Ok(2.0));
        assert_eq!(parse_number_density("1e9/cm3"), Ok(1e15));
        assert_eq!(parse_number_density("5 1/m3"), Ok(5.0));
    }

    #[test]
    fn what_is_no_density_is_refused() {
        assert!(matches!(parse_mass_density("heavy"), Err(QuantityError::NotANumber { .. })));
        assert!(matches!(parse_mass_density("1000"), Err(QuantityError::MissingUnit { .. })));
        assert!(matches!(parse_mass_density("3 g"), Err(QuantityError::UnknownUnit { .. })));
        assert!(matches!(parse_number_density("-3/cm3"), Err(QuantityError::OutOfRange { .. })));
        assert!(matches!(parse_number_density("inf/cm3"), Err(QuantityError::OutOfRange { .. })));
    }
}
