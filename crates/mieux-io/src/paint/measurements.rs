//! Measured reflectances: as JSON, in percent, or as comma-separated columns, as shares.

use std::collections::BTreeMap;
use std::path::Path;

use mieux_optics::paint::{Measurements, PaintError, Recipe, Sample};
use mieux_optics::spectrum::{Sampled, WavelengthGrid};
use serde::Deserialize;

use super::PaintFileError;
use crate::TextError;

/// An entry of the JSON form.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    #[serde(rename = "type")]
    kind: String,
    name: Option<String>,
    values: Option<Vec<f64>>,
    components: Option<BTreeMap<String, f64>>,
    reflectance: Option<Vec<f64>>,
}

/// Reads measurements of opaque samples, as JSON where the name of the file ends so, else as comma-separated values.
///
/// # Errors
/// [`PaintFileError`], with the place.
pub fn read_measurements(path: &Path) -> Result<Measurements, PaintFileError> {
    parse_measurements(&path.display().to_string(), &read(path)?)
}

/// Reads one reflectance from comma-separated values: `wavelength_nm` and one more column of shares.
///
/// # Errors
/// [`PaintFileError`], with the place.
pub fn read_spectrum(path: &Path) -> Result<Sampled, PaintFileError> {
    parse_spectrum(&path.display().to_string(), &read(path)?)
}

pub(super) fn read(path: &Path) -> Result<String, PaintFileError> {
    std::fs::read_to_string(path).map_err(|source| PaintFileError::Read { path: path.to_owned(), source })
}

/// As [`read_measurements`], from a text.
///
/// # Errors
/// [`PaintFileError`], with the place.
pub fn parse_measurements(name: &str, text: &str) -> Result<Measurements, PaintFileError> {
    if name.to_lowercase().ends_with(".json") { parse_json(name, text) } else { parse_csv(name, text) }
}

/// "white:0.7+blue:0.3", or the name of one paint by itself. Amounts are in any unit.
///
/// # Errors
/// [`PaintError`], or what is wrong with the text.
pub fn parse_recipe(text: &str) -> Result<Recipe, String> {
    let parts: Vec<&str> = text.split('+').map(str::trim).collect();
    if let [pure] = parts[..]
        && !pure.contains(':')
    {
        return if pure.is_empty() { Err("a recipe is missing".into()) } else { Ok(Recipe::pure(pure)) };
    }
    let part = |part: &&str| {
        let (name, amount) = part
            .rsplit_once(':')
            .ok_or_else(|| format!("`{part}` has no amount; a recipe is as `white:0.7+blue:0.3`"))?;
        let amount = amount.trim().parse().map_err(|_| format!("`{amount}` in `{part}` is not a number"))?;
        Ok::<_, String>((name.trim().to_owned(), amount))
    };
    let parts = parts.iter().map(part).collect::<Result<Vec<_>, _>>()?;
    Recipe::new(parts).map_err(|error| error.to_string())
}

fn parse_json(name: &str, text: &str) -> Result<Measurements, PaintFileError> {
    let entries: Vec<Entry> = serde_json::from_str(text).map_err(|error| {
        let start: usize = text.split_inclusive('\n').take(error.line().saturating_sub(1)).map(str::len).sum();
        let at = start + error.column().saturating_sub(1);
        let message = error.to_string();
        let message = message.split(" at line ").next().unwrap_or(&message).to_owned();
        TextError::new(name, text, at..at + 1, message).with_help(
            "a list of {\"type\": \"wavelengths\", \"values\": [nm]}, then {\"type\": \"masstone\" or \"mix\", \"name\", \
             \"components\" (of a mix), \"reflectance\": [percent]}",
        )
    })?;
    let wrong = |entry: usize, what: Option<&String>, problem: String| PaintFileError::Entry {
        name: name.into(),
        entry: entry + 1,
        what: what.cloned(),
        problem,
    };
    let mut grid = None;
    let mut samples = Vec::new();
    for (i, entry) in entries.into_iter().enumerate() {
        let what = entry.name.as_ref();
        if entry.kind == "wavelengths" {
            let values = entry.values.ok_or_else(|| wrong(i, what, "no `values`".into()))?;
            if grid.is_some() {
                return Err(wrong(i, what, "wavelengths are there twice".into()));
            }
            let metres = values.iter().map(|nm| nm * 1e-9).collect();
            grid = Some(WavelengthGrid::new(metres).map_err(|error| wrong(i, what, error.to_string()))?);
            continue;
        }
        let Some(sample) = what else { return Err(wrong(i, None, "no `name`".into())) };
        let recipe = match (entry.kind.as_str(), entry.components) {
            ("masstone", None) => Recipe::pure(sample),
            ("masstone", Some(_)) => return Err(wrong(i, what, "a masstone has no `components`".into())),
            ("mix", Some(parts)) => Recipe::new(parts).map_err(|error| wrong(i, what, error.to_string()))?,
            ("mix", None) => return Err(wrong(i, what, "a mix needs `components`".into())),
            (other, _) => {
                let problem = format!("`{other}` is no type of entry; `wavelengths`, `masstone` and `mix` are");
                return Err(wrong(i, what, problem));
            }
        };
        let percent = entry.reflectance.as_ref().ok_or_else(|| wrong(i, what, "no `reflectance`".into()))?;
        let Some(grid) = &grid else { return Err(wrong(i, what, "wavelengths must come first".into())) };
        let sample = Sample { name: sample.clone(), recipe, reflectance: percent.iter().map(|v| 0.01 * v).collect() };
        // Checked one by one, so that the entry can be named.
        Measurements::new(grid.clone(), vec![sample.clone()]).map_err(|error| wrong(i, what, error.to_string()))?;
        samples.push(sample);
    }
    let grid = grid.ok_or_else(|| TextError::new(name, text, 0..1, "there are no wavelengths"))?;
    Measurements::new(grid, samples).map_err(|source| PaintFileError::Paint { name: name.into(), source })
}

/// Names of the columns behind the first, wavelengths (m), and the values by columns with the lines they are from.
struct Columns {
    names: Vec<String>,
    grid: WavelengthGrid,
    values: Vec<Vec<f64>>,
}

fn columns(name: &str, text: &str) -> Result<Columns, PaintFileError> {
    let cell =
        |line: u64, column: usize, problem: String| PaintFileError::Cell { name: name.into(), line, column, problem };
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true)
        .has_headers(false)
        .from_reader(text.as_bytes());
    let mut names: Option<Vec<String>> = None;
    let (mut metres, mut values, mut last) = (Vec::new(), Vec::new(), 1);
    for record in reader.records() {
        let record =
            record.map_err(|error| cell(error.position().map_or(last, csv::Position::line), 1, error.to_string()))?;
        let line = record.position().map_or(last, csv::Position::line);
        last = line;
        let Some(names) = &names else {
            if record.get(0) != Some("wavelength_nm") || record.len() < 2 {
                let problem = "the first line names the columns: `wavelength_nm`, then one for each reflectance";
                return Err(cell(line, 1, problem.into()));
            }
            values = vec![Vec::new(); record.len() - 1];
            names = Some(record.iter().skip(1).map(str::to_owned).collect());
            continue;
        };
        if record.len() != names.len() + 1 {
            let problem = format!("{} fields where there are {} columns", record.len(), names.len() + 1);
            return Err(cell(line, record.len(), problem));
        }
        for (column, field) in record.iter().enumerate() {
            let value: f64 = field.parse().map_err(|_| cell(line, column + 1, format!("`{field}` is not a number")))?;
            if column == 0 {
                metres.push(value * 1e-9);
            } else if value > 0.0 && value < 1.0 {
                values[column - 1].push(value);
            } else {
                let problem = format!("the reflectance {value} is not between 0 and 1 (both excluded), as shares are");
                return Err(cell(line, column + 1, problem));
            }
        }
    }
    let Some(names) = names else { return Err(cell(1, 1, "the file is empty".into())) };
    let grid = WavelengthGrid::new(metres).map_err(|error| cell(last, 1, error.to_string()))?;
    Ok(Columns { names, grid, values })
}

fn parse_csv(name: &str, text: &str) -> Result<Measurements, PaintFileError> {
    let Columns { names, grid, values } = columns(name, text)?;
    let sample = |(i, (header, reflectance)): (usize, (String, Vec<f64>))| {
        let recipe = parse_recipe(&header).map_err(|problem| PaintFileError::Cell {
            name: name.into(),
            line: 1,
            column: i + 2,
            problem,
        })?;
        Ok::<_, PaintFileError>(Sample { name: header, recipe, reflectance })
    };
    let samples = names.into_iter().zip(values).enumerate().map(sample).collect::<Result<_, _>>()?;
    Measurements::new(grid, samples).map_err(|source: PaintError| PaintFileError::Paint { name: name.into(), source })
}

/// As [`read_spectrum`], from a text.
///
/// # Errors
/// [`PaintFileError`], with the place.
pub fn parse_spectrum(name: &str, text: &str) -> Result<Sampled, PaintFileError> {
    let Columns { names, grid, mut values } = columns(name, text)?;
    if names.len() != 1 {
        let problem = format!("{} reflectances where one is needed", names.len());
        return Err(PaintFileError::Cell { name: name.into(), line: 1, column: 3, problem });
    }
    Sampled::new(grid, values.remove(0))
        .map_err(|error| PaintFileError::Paint { name: name.into(), source: error.into() })
}

#[cfg(test)]
mod tests {
    use super::*;

    const JSON: &str = r#"[
  {"type": "wavelengths", "values": [400, 500.5]},
  {"type": "masstone", "name": "white", "reflectance": [90, 95.5]},
  {"type": "mix", "name": "tint", "components": {"blue": 1, "white": 3}, "reflectance": [50, 40]}
]"#;

    #[test]
    fn json_and_csv_say_the_same() {
        let json = parse_measurements("a.json", JSON).unwrap();
        let csv = "# by hand\nwavelength_nm, white, blue:1 + white:3\n400,0.9,0.5\n500.5,0.955,0.4\n";
        let csv = parse_measurements("a.csv", csv).unwrap();
        assert_eq!(json.grid(), csv.grid());
        for (a, b) in json.samples().iter().zip(csv.samples()) {
            assert_eq!(a.recipe, b.recipe);
            assert!(a.reflectance.iter().zip(&b.reflectance).all(|(a, b)| (a - b).abs() < 1e-15));
        }
        assert_eq!(json.samples()[1].recipe.parts(), [("blue".into(), 0.25), ("white".into(), 0.75)]);
    }

    #[test]
    fn mistakes_in_json_are_named_with_their_place() {
        for (from, to, expected) in [
            ("95.5", "195.5", "entry 2 (`white`): sample `white`: the reflectance 1.955 at 500.5 nm"),
            ("95.5", "0", "the reflectance 0 at"),
            ("[50, 40]", "[50]", "entry 3 (`tint`): sample `tint` has 1 reflectances for 2 wavelengths"),
            ("\"components\"", "\"parts\"", "line 4, column"),
            ("\"mix\"", "\"blend\"", "`blend` is no type of entry"),
            ("\"components\": {\"blue\": 1, \"white\": 3}, ", "", "a mix needs `components`"),
            ("\"white\": 3", "\"white\": -3", "entry 3 (`tint`): the amount -3 of `white`"),
            ("[400, 500.5]", "[400, 300]", "wavelengths must increase"),
            ("\"values\"", "\"reflectance\"", "entry 1: no `values`"),
            ("500.5]},", "500.5]}", "line 3, column"),
        ] {
            let error = parse_measurements("m.json", &JSON.replacen(from, to, 1)).unwrap_err().to_string();
            assert!(error.starts_with("m.json, ") && error.contains(expected), "{to}: {error}");
        }
        assert!(parse_measurements("m.json", "[]").unwrap_err().to_string().contains("no wavelengths"));
    }

    #[test]
    fn mistakes_in_tables_are_named_with_their_place() {
        for (text, expected) in [
            ("wavelength_nm,a\n400,0.5\n500,1.2\n", "m.csv, line 3, column 2: the reflectance 1.2"),
            ("wavelength_nm,a\n400,0.5\n500,0\n", "line 3, column 2"),
            ("wavelength_nm,a\n400,x\n", "line 2, column 2: `x` is not a number"),
            ("wavelength_nm,a\n400,0.5,0.6\n", "line 2, column 3: 3 fields where there are 2 columns"),
            ("nm,a\n400,0.5\n", "line 1, column 1: the first line names the columns"),
            ("wavelength_nm,a:x\n400,0.5\n", "line 1, column 2: `x` in `a:x` is not a number"),
            ("wavelength_nm,a,a:1+b\n400,0.5,0.5\n", "line 1, column 3: `b` has no amount"),
            ("wavelength_nm,a\n500,0.5\n400,0.5\n", "line 3, column 1: wavelengths must increase"),
            ("", "the file is empty"),
        ] {
            let error = parse_measurements("m.csv", text).unwrap_err().to_string();
            assert!(error.contains(expected), "{text:?}: {error}");
        }
        assert!(parse_spectrum("t.csv", "wavelength_nm,a,b\n400,0.5,0.5\n").is_err());
        assert_eq!(parse_spectrum("t.csv", "wavelength_nm,R\n400,0.5\n").unwrap().values(), [0.5]);
        let missing = read_measurements(Path::new("not/there.json")).unwrap_err();
        assert!(matches!(missing, PaintFileError::Read { .. }));
    }
}
