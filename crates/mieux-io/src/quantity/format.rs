//! Numbers with their units, as a person wants to read them.

use mieux_optics::Complex64;

/// A length in metres with four significant digits and a fitting unit: "17.3 µm", "550 nm", "2.5 m".
pub fn format_length(metres: f64) -> String {
    with_length_unit(metres, |v| format!("{v:.3e}"))
}

/// As [`format_length`] with every digit, so that parsing it gives the same bits.
pub(super) fn exact_length(metres: f64) -> String {
    with_length_unit(metres, |v| format!("{v:e}"))
}

/// A coefficient in 1/m with four significant digits: "57840 /m", "0.0123 /m", "5.784e9 /m".
pub fn format_per_length(per_metre: f64) -> String {
    format!("{} /m", significant(per_metre, 4))
}

/// An area in m^2 with four significant digits and a fitting unit: "1.234 µm²", "-5e-4 nm²".
pub fn format_area(square_metres: f64) -> String {
    let (unit, size) = match square_metres.abs() {
        0.0 => ("m²", 1.0),
        a if a < 0.99995e-14 => ("nm²", 1e-18),
        a if a < 0.99995e-8 => ("µm²", 1e-12),
        a if a < 0.99995e-2 => ("mm²", 1e-6),
        _ => ("m²", 1.0),
    };
    format!("{} {unit}", significant(square_metres / size, 4))
}

/// Seconds for a person: "850 ms", "12.3 s", "2 min 5 s", "1 h 2 min", "3 d 4 h"; whole units from a minute on.
pub fn format_duration(seconds: f64) -> String {
    if !seconds.is_finite() || seconds < 0.0 {
        return format!("{seconds} s");
    }
    let pair = |big: u64, big_unit: &str, small: u64, small_unit: &str| match small {
        0 => format!("{big} {big_unit}"),
        _ => format!("{big} {big_unit} {small} {small_unit}"),
    };
    let whole = |unit: f64| (seconds / unit).round() as u64;
    match seconds {
        0.0 => "0 s".to_owned(),
        s if s < 0.9995 => format!("{} ms", significant(s * 1e3, 3)),
        s if s < 59.95 => format!("{} s", significant(s, 3)),
        _ if whole(1.0) < 3600 => pair(whole(1.0) / 60, "min", whole(1.0) % 60, "s"),
        _ if whole(60.0) < 24 * 60 => pair(whole(60.0) / 60, "h", whole(60.0) % 60, "min"),
        _ => pair(whole(3600.0) / 24, "d", whole(3600.0) % 24, "h"),
    }
}

/// A complex refractive index with every digit, in the form that parses back to the same bits: "1.33+1e-9i".
pub fn format_complex_index(index: Complex64) -> String {
    let part = |v: f64| if v != 0.0 && !(1e-4..1e6).contains(&v.abs()) { format!("{v:e}") } else { format!("{v}") };
    let (real, imaginary) = (part(index.re), part(index.im));
    match imaginary.as_str() {
        "0" | "-0" => real,
        negative if negative.starts_with('-') => format!("{real}{negative}i"),
        positive => format!("{real}+{positive}i"),
    }
}

/// A number with at most `digits` significant digits, plain between 0.001 and 1 million, else like "5.784e9".
/// Zeros that say nothing are left out.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{}", value + 0.0);
    }
    let scientific = format!("{value:.*e}", digits.max(1) - 1);
    let (mantissa, exponent) = mantissa_and_exponent(&scientific);
    if (-3..6).contains(&exponent) { decimal(mantissa, exponent) } else { with_exponent(mantissa, exponent) }
}

fn with_length_unit(metres: f64, scientific: impl Fn(f64) -> String) -> String {
    if metres == 0.0 || !metres.is_finite() {
        return format!("{} m", metres + 0.0);
    }
    // The unit is chosen after rounding: 999.96 nm is "1 µm".
    let text = scientific(metres);
    let (mantissa, exponent) = mantissa_and_exponent(&text);
    let (unit, power) = match exponent {
        -12..=-7 => ("nm", -9),
        -6..=-4 => ("µm", -6),
        -3..=-1 => ("mm", -3),
        0..=2 => ("m", 0),
        3..=8 => ("km", 3),
        _ => return format!("{} m", with_exponent(mantissa, exponent)),
    };
    format!("{} {unit}", decimal(mantissa, exponent - power))
}

/// The two halves of what `{:e}` prints.
fn mantissa_and_exponent(scientific: &str) -> (&str, i32) {
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((scientific, "0"));
    (mantissa, exponent.parse().unwrap_or(0))
}

fn with_exponent(mantissa: &str, exponent: i32) -> String {
    let mantissa = if mantissa.contains('.') { mantissa.trim_end_matches('0').trim_end_matches('.') } else { mantissa };
    format!("{mantissa}e{exponent}")
}

/// A mantissa "d.ddd" times a power of ten, written without an exponent, by moving the point.
fn decimal(mantissa: &str, exponent: i32) -> String {
    let (sign, unsigned) = match mantissa.strip_prefix('-') {
        Some(unsigned) => ("-", unsigned),
        None => ("", mantissa),
    };
    let digits = unsigned.replace('.', "");
    let digits = digits.trim_end_matches('0');
    let digits = if digits.is_empty() { "0" } else { digits };
    if exponent < 0 {
        let zeros = "0".repeat(exponent.unsigned_abs() as usize - 1);
        return format!("{sign}0.{zeros}{digits}");
    }
    let point = exponent as usize + 1;
    if digits.len() <= point {
        let zeros = "0".repeat(point - digits.len());
        return format!("{sign}{digits}{zeros}");
    }
    let (whole, part) = digits.split_at(point);
    format!("{sign}{whole}.{part}")
}
