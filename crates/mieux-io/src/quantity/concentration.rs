//! How much of something is dissolved: "1.7 mg/L", "0.17 mg/100g", "4.5 umol/L".

use mieux_optics::substance::Concentration;

use super::{QuantityError, shifted, split_number};

/// Units of amount in a volume, and the power of ten that makes kg/m3 or mol/m3 of them.
const UNITS: [(&str, bool, i32); 12] = [
    ("g/L", false, 0),
    ("mg/L", false, -3),
    ("ug/L", false, -6),
    ("µg/L", false, -6),
    ("g/mL", false, 3),
    ("mg/mL", false, 0),
    ("kg/m^3", false, 0),
    ("mol/L", true, 3),
    ("mmol/L", true, 0),
    ("umol/L", true, -3),
    ("µmol/L", true, -3),
    ("mol/m^3", true, 0),
];
const UNIT_NAMES: &str = "mg/100g, g/L, mg/L, ug/L, mg/mL, kg/m^3, mol/L, mmol/L, umol/L, mol/m^3";
const EXAMPLE: &str = "1.7 mg/L";

/// Parses a concentration, zero or more.
///
/// # Errors
/// [`QuantityError`]: no number, no unit, another unit, or a negative number.
pub fn parse_concentration(text: &str) -> Result<Concentration, QuantityError> {
    let (number, unit) = split_number(text.trim());
    let unit = unit.trim_start();
    let parse = |exponent: i32| -> Result<f64, QuantityError> {
        let value = shifted(number, exponent)
            .ok_or_else(|| QuantityError::NotANumber { text: text.into(), example: EXAMPLE })?;
        if value >= 0.0 && value.is_finite() {
            return Ok(value);
        }
        Err(QuantityError::OutOfRange { text: text.into(), allowed: "a concentration is zero or more" })
    };
    if unit.is_empty() {
        return Err(QuantityError::MissingUnit { text: text.into(), units: UNIT_NAMES, example: EXAMPLE });
    }
    if unit == "mg/100g" || unit == "mg/100 g" {
        return Ok(Concentration::MilligramsPer100g(parse(0)?));
    }
    let Some((_, molar, exponent)) = UNITS.iter().find(|(name, ..)| *name == unit) else {
        return Err(QuantityError::UnknownUnit { text: text.into(), unit: unit.into(), units: UNIT_NAMES });
    };
    let value = parse(*exponent)?;
    Ok(if *molar { Concentration::MolesPerCubicMetre(value) } else { Concentration::KilogramsPerCubicMetre(value) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn concentrations_are_read() {
        for (text, concentration) in [
            ("1.7 mg/L", Concentration::KilogramsPerCubicMetre(1.7e-3)),
            ("0.17mg/100g", Concentration::MilligramsPer100g(0.17)),
            ("4.5 umol/L", Concentration::MolesPerCubicMetre(4.5e-3)),
            ("2 mol/L", Concentration::MolesPerCubicMetre(2000.0)),
            ("0 g/L", Concentration::KilogramsPerCubicMetre(0.0)),
        ] {
            assert_eq!(parse_concentration(text).unwrap(), concentration, "{text}");
        }
        for text in ["", "mg/L", "1.7", "1.7 mg", "-1 mg/L", "inf g/L", "1e999 g/L"] {
            assert!(parse_concentration(text).is_err(), "{text}");
        }
    }
}
