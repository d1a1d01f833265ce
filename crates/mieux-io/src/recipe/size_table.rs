//! Measured sizes from a file: comma-separated values with a line of names.
//!
//! Either a density per size at sizes, `radius_um,density`, or what was counted in bins, `radius_from_um,radius_to_um,count`;
//! `diameter` in place of `radius`, and `nm`, `um`, `mm` or `m` for the unit. Lines that start with `#` are passed over.

use std::ops::Range;
use std::path::Path;

use mieux_optics::particle::{ParticleError, TabulatedSizes, Weighting};

use super::read_text;
use crate::cells::{Cell, rows};
use crate::text_error::TextError;

const HELP: &str = "either `radius_um,density`, or `radius_from_um,radius_to_um,count`; `diameter` for `radius`, and nm, um, mm or m \
                    for the unit, will do as well";

/// Why there are no sizes in a file: a message, or a place in it.
pub(crate) enum SizeTableError {
    Read(String),
    Text(Box<TextError>),
}

/// Reads a file, whose densities or counts have the given weighting.
pub(crate) fn read(path: &Path, weighting: Weighting) -> Result<TabulatedSizes, SizeTableError> {
    let text =
        read_text(path).map_err(|e| SizeTableError::Read(e.to_string().replace("recipe", "size distribution")))?;
    parse(&path.to_string_lossy(), &text, weighting).map_err(SizeTableError::Text)
}

fn parse(file: &str, text: &str, weighting: Weighting) -> Result<TabulatedSizes, Box<TextError>> {
    let error = |span: Range<usize>, message: String| TextError::new(file, text, span, message);
    let mut lines = rows(text);
    let Some(names) = lines.next() else {
        return Err(error(0..0, "the file has no line of names".into()).with_help(HELP));
    };
    let bins = names.len() == 3;
    let factor = match (&names[..], bins) {
        ([(size, _), ("density", _)], _) => unit(size, &["radius_", "diameter_"]),
        ([(from, _), (to, _), ("count", _)], _) => unit(from, &["radius_from_", "diameter_from_"])
            .filter(|factor| unit(to, &["radius_to_", "diameter_to_"]) == Some(*factor)),
        _ => None,
    };
    let Some(factor) = factor else {
        let span = names[0].1.start..names[names.len() - 1].1.end;
        return Err(error(span, "these columns are no size distribution".into()).with_help(HELP));
    };
    let (mut sizes, mut values, mut places): (Vec<f64>, Vec<f64>, Vec<[Range<usize>; 2]>) = Default::default();
    for row in lines {
        let whole = row[0].1.start..row[row.len() - 1].1.end;
        if row.len() != names.len() {
            return Err(error(whole, format!("{} values under {} names", row.len(), names.len())));
        }
        let number = |(cell, span): &Cell<'_>| match cell.parse::<f64>() {
            Ok(value) => Ok(value),
            Err(_) => Err(error(span.clone(), format!("`{cell}` is no number"))),
        };
        let size = factor * number(&row[0])?;
        if bins {
            match sizes.last() {
                None => sizes.push(size),
                Some(last) if (size - last).abs() > 1e-9 * last.abs() => {
                    return Err(error(row[0].1.clone(), "a bin must begin where the one before it ends".into()));
                }
                Some(_) => {}
            }
            sizes.push(factor * number(&row[1])?);
        } else {
            sizes.push(size);
        }
        let last = &row[row.len() - 1];
        values.push(number(last)?);
        places.push([row[usize::from(bins)].1.clone(), last.1.clone()]);
    }
    let table = if bins {
        TabulatedSizes::from_bins(weighting, &sizes, &values)
    } else {
        TabulatedSizes::from_density(weighting, &sizes, &values)
    };
    table.map_err(|e| match e {
        ParticleError::Table { row, value, problem } => {
            let is_value = values.get(row).is_some_and(|v| v.to_bits() == value.to_bits());
            let row = if bins && !is_value { row.saturating_sub(1) } else { row };
            let [size, count] = &places[row.min(places.len() - 1)];
            error(if is_value { count.clone() } else { size.clone() }, problem.to_string())
        }
        other => error(0..text.trim_end().len().min(1), other.to_string()),
    })
}

/// By what to multiply a column to have radii in m.
fn unit(name: &str, kinds: &[&str]) -> Option<f64> {
    let (i, unit) = kinds.iter().enumerate().find_map(|(i, kind)| Some((i, name.strip_prefix(kind)?)))?;
    let units = [("nm", 1e-9), ("um", 1e-6), ("mm", 1e-3), ("m", 1.0)];
    let (_, metres) = units.into_iter().find(|(known, _)| *known == unit)?;
    Some(if i == 0 { metres } else { 0.5 * metres })
}

#[cfg(test)]
mod tests {
    use super::*;
    use mieux_optics::particle::SizeDistribution;

    fn mean(text: &str) -> f64 {
        let table = parse("my.csv", text, Weighting::Number).unwrap();
        SizeDistribution::Tabulated(table).mean_radius(1.0, 0.0).unwrap()
    }

    #[test]
    fn densities_and_bins_in_radii_and_diameters() {
        for text in [
            "# beads\nradius_um,density\n1,1\n3,1\n",
            "diameter_um, density\n2, 5\n6, 5\n",
            "radius_from_nm,radius_to_nm,count\n1000,2000,7\n2000,3000,7\n",
            "diameter_from_mm,diameter_to_mm,count\n0.002,0.006,1\n",
        ] {
            assert!((mean(text) / 2e-6 - 1.0).abs() < 1e-8, "{text}");
        }
    }

    #[test]
    fn mistakes_are_pointed_at() {
        let line = |text: &str| parse("my.csv", text, Weighting::Volume).unwrap_err().to_string();
        for (text, place) in [
            ("radius_um,density\n1,1\n3,x\n", "my.csv, line 3, column 3"),
            ("radius_um,density\n1,1\n0.5,1\n", "my.csv, line 3, column 1"),
            ("radius_um,density\n1,1\n3,-1\n", "my.csv, line 3, column 3"),
            ("radius_um,density\n1,1,4\n", "my.csv, line 2, column 1"),
            ("radius,density\n1,1\n", "my.csv, line 1, column 1"),
            ("radius_from_um,radius_to_um,count\n1,2,1\n3,4,1\n", "my.csv, line 3, column 1"),
            ("radius_from_um,radius_to_um,count\n1,2,1\n2,1.5,1\n", "my.csv, line 3, column 3"),
            ("radius_um,density\n1,0\n2,0\n", "cannot be normalised"),
            ("", "no line of names"),
        ] {
            let message = line(text);
            assert!(message.contains(place), "{text}: {message}");
        }
    }
}
