//! A phase function as a table: over angle, or of Legendre moments.
//!
//! Comma-separated values with a line of names: `angle_deg,phase` (also `phase_per_sr`, as `mieux phase` writes it) with
//! angles from 0 to 180 degrees, or `degree,moment` with degrees from 0 up. Other columns, and lines that start with `#`,
//! are passed over.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::{SlabFileError, read_text};
use crate::cells::{Cell, rows};
use crate::text_error::TextError;

/// Which phase function an abstract medium has.
#[derive(Debug, Clone, PartialEq)]
pub enum PhaseChoice {
    /// Henyey and Greenstein's.
    Hg {
        /// Mean cosine, between -1 and 1.
        g: f64,
    },
    /// Into all directions alike.
    Isotropic,
    /// Of particles much smaller than the wavelength.
    Rayleigh,
    /// What is in a file ([`read`]).
    File(PathBuf),
}

/// What a file says about a phase function, checked row by row.
#[derive(Debug, Clone, PartialEq)]
pub enum PhaseTable {
    /// Angles in degrees, rising from 0 to 180, and values in any unit, from 0 up.
    Angles {
        /// Degrees.
        degrees: Vec<f64>,
        /// At each angle.
        values: Vec<f64>,
    },
    /// Legendre moments by degree from 0, the first being 1 after division by what it was.
    Moments {
        /// By degree.
        moments: Vec<f64>,
        /// What the first was.
        first: f64,
    },
}

/// Reads a file.
///
/// # Errors
/// [`SlabFileError`], with line and column for a row that cannot be.
pub fn read(path: &Path) -> Result<PhaseTable, SlabFileError> {
    let text = read_text("phase function", path)?;
    Ok(parse(&path.to_string_lossy(), &text)?)
}

/// What the two columns are.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Angles,
    Moments,
}

impl Kind {
    fn names(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Self::Angles => ("angle_deg", &["phase", "phase_per_sr"]),
            Self::Moments => ("degree", &["moment"]),
        }
    }
}

/// Reads a text; `file` names it in errors.
///
/// # Errors
/// [`TextError`] with the place.
pub fn parse(file: &str, text: &str) -> Result<PhaseTable, Box<TextError>> {
    let error = |span: Range<usize>, message: String| TextError::new(file, text, span, message);
    let mut rows = rows(text);
    let help = "columns: angle_deg,phase or degree,moment";
    let Some(header) = rows.next() else {
        return Err(error(0..0, "there is nothing in it".to_owned()).with_help(help));
    };
    let place = |names: &[&str]| header.iter().position(|(cell, _)| names.contains(cell));
    let found = [Kind::Angles, Kind::Moments].into_iter().find_map(|kind| {
        let (x, y) = kind.names();
        Some((kind, place(&[x])?, place(y)?))
    });
    let Some((kind, x, y)) = found else {
        let [start, end] = [header.first(), header.last()].map(|cell| cell.map_or(0..0, |(_, span)| span.clone()));
        return Err(error(start.start..end.end, "these are not the names of the columns of a phase function".into())
            .with_help(help));
    };
    let number = |row: &[Cell<'_>], place: usize| -> Result<(f64, Range<usize>), Box<TextError>> {
        let end = row.last().map_or(0, |(_, span)| span.end);
        let Some((cell, span)) = row.get(place) else {
            return Err(error(end..end, format!("this row has {} of {} columns", row.len(), header.len())));
        };
        match cell.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok((value, span.clone())),
            _ => Err(error(span.clone(), format!("`{cell}` is not a finite number"))),
        }
    };
    let mut points: Vec<[f64; 2]> = Vec::new();
    let mut last = header.last().map_or(0..0, |(_, span)| span.clone());
    for row in rows {
        let ((a, at_a), (b, at_b)) = (number(&row, x)?, number(&row, y)?);
        let before = points.last().map(|point| point[0]);
        match kind {
            Kind::Angles => check_angle(before, a).map_err(|message| error(at_a, message))?,
            Kind::Moments => check_degree(points.len(), a).map_err(|message| error(at_a, message))?,
        }
        match kind {
            Kind::Angles if b < 0.0 => return Err(error(at_b, format!("the value {b} is negative"))),
            Kind::Moments
                if b.abs() > points.first().map_or(b, |first| first[1]) || (points.is_empty() && b <= 0.0) =>
            {
                let message = format!("{b} cannot be a moment: the first is positive and no other beyond it");
                return Err(error(at_b, message));
            }
            _ => {}
        }
        last = row[x].1.clone();
        points.push([a, b]);
    }
    finish(kind, &points).map_err(|message| error(last, message))
}

fn check_angle(before: Option<f64>, angle: f64) -> Result<(), String> {
    match before {
        None if angle != 0.0 => Err(format!("the first angle is {angle}; it must be 0, which is forward")),
        Some(before) if angle <= before => Err(format!("the angle {angle} follows {before}; angles rise")),
        _ if angle > 180.0 => Err(format!("the angle {angle} lies beyond 180 degrees, which is backward")),
        _ => Ok(()),
    }
}

fn check_degree(expected: usize, degree: f64) -> Result<(), String> {
    if degree == expected as f64 {
        return Ok(());
    }
    Err(format!("the degree {degree} stands where {expected} should; degrees run from 0 without a gap"))
}

fn finish(kind: Kind, points: &[[f64; 2]]) -> Result<PhaseTable, String> {
    let column = |i: usize| points.iter().map(|point| point[i]).collect::<Vec<f64>>();
    match (kind, points) {
        (Kind::Moments, [[_, first], ..]) => {
            let moments = points.iter().map(|point| point[1] / first).collect();
            Ok(PhaseTable::Moments { moments, first: *first })
        }
        (Kind::Moments, []) => Err("there are no moments".into()),
        (Kind::Angles, [.., [end, _]]) if *end != 180.0 || points.len() < 2 => {
            Err(format!("the last angle is {end}; it must be 180, which is backward"))
        }
        (Kind::Angles, []) => Err("there are no angles".into()),
        (Kind::Angles, _) if points.iter().all(|point| point[1] == 0.0) => {
            Err("all values are 0: nothing is scattered anywhere".into())
        }
        (Kind::Angles, _) => Ok(PhaseTable::Angles { degrees: column(0), values: column(1) }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_kinds_read() {
        let table = parse("p.csv", "# a remark\nangle_deg,other,phase\n0, x, 3\n90,,1\n180,,0.5\n").unwrap();
        assert_eq!(table, PhaseTable::Angles { degrees: vec![0.0, 90.0, 180.0], values: vec![3.0, 1.0, 0.5] });
        let table = parse("p.csv", "degree,moment\r\n0,2\r\n1,1.5\r\n").unwrap();
        assert_eq!(table, PhaseTable::Moments { moments: vec![1.0, 0.75], first: 2.0 });
    }

    #[test]
    fn mistakes_are_pointed_at() {
        for (text, line, column, part) in [
            ("", 1, 1, "nothing"),
            ("angle,phase\n0,1\n", 1, 1, "columns"),
            ("angle_deg,phase\n1,1\n180,1\n", 2, 1, "forward"),
            ("angle_deg,phase\n0,1\n90,x\n180,1\n", 3, 4, "`x`"),
            ("angle_deg,phase\n0,1\n90\n180,1\n", 3, 3, "1 of 2"),
            ("angle_deg,phase\n0,1\n90,-1\n180,1\n", 3, 4, "negative"),
            ("angle_deg,phase\n0,1\n90,1\n80,1\n", 4, 1, "rise"),
            ("angle_deg,phase\n0,1\n90,inf\n", 3, 4, "finite"),
            ("angle_deg,phase\n0,1\n90,1\n", 3, 1, "180"),
            ("angle_deg,phase\n0,1\n190,1\n", 3, 1, "beyond"),
            ("angle_deg,phase\n0,0\n180,0\n", 3, 1, "nothing is scattered"),
            ("angle_deg,phase\n", 1, 11, "no angles"),
            ("degree,moment\n", 1, 8, "no moments"),
            ("degree,moment\n0,1\n2,0.5\n", 3, 1, "gap"),
            ("degree,moment\n0,1\n1,1.5\n", 3, 3, "1.5"),
            ("degree,moment\n0,-1\n", 2, 3, "positive"),
        ] {
            let error = parse("p.csv", text).unwrap_err();
            assert_eq!((error.line, error.column), (line, column), "{text}: {error}");
            assert!(error.message.contains(part), "{text}: {error}");
        }
    }

    #[test]
    fn a_file_that_is_not_there_is_named() {
        let error = read(Path::new("nowhere.csv")).unwrap_err().to_string();
        assert!(error.contains("nowhere.csv") && error.contains("phase function"), "{error}");
    }
}
