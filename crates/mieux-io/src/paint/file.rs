//! Paints whose K and S are known, as TOML.

use std::io::{self, Write};
use std::path::Path;

use mieux_optics::paint::{Leftover, Paint, PaintError, PaintSet};
use mieux_optics::spectrum::WavelengthGrid;
use mieux_optics::transfer::kubelka_munk::Saunderson;
use serde::{Deserialize, Serialize};

use super::PaintFileError;
use super::measurements::read;
use crate::TextError;
use crate::table::exact;

/// Written first, so that other files are told apart.
const FORMAT: &str = "mieux paints 1";

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    reference: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    reference_scattering_per_m: Option<f64>,
    wavelengths_nm: Vec<f64>,
    surface: Surface,
    #[serde(rename = "paint")]
    paints: Vec<Entry>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Surface {
    external: f64,
    internal: f64,
    specular: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: String,
    k: Vec<f64>,
    s: Vec<f64>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    k_error: Vec<f64>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    s_error: Vec<f64>,
}

/// The text of a file that [`load_paints`] reads back to the same bits.
///
/// # Errors
/// [`PaintFileError::Paint`] never for a set as it comes from a fit; a number that TOML cannot hold.
pub fn paints_to_toml(set: &PaintSet) -> Result<String, PaintFileError> {
    let surface = set.surface();
    let entry = |paint: &Paint| Entry {
        name: paint.name.clone(),
        k: paint.k.clone(),
        s: paint.s.clone(),
        k_error: paint.k_error.clone(),
        s_error: paint.s_error.clone(),
    };
    let file = File {
        format: FORMAT.into(),
        reference: set.reference().into(),
        reference_scattering_per_m: set.scattering(),
        // Without what the change of unit has added.
        wavelengths_nm: set.grid().iter().map(|metres| (metres * 1e15).round() / 1e6).collect(),
        surface: Surface { external: surface.external, internal: surface.internal, specular: surface.specular },
        paints: set.paints().iter().map(entry).collect(),
    };
    let body = toml::to_string(&file).map_err(|error| {
        PaintFileError::Text(TextError::new("the paints", "", 0..0, format!("they cannot be written: {error}")))
    })?;
    let reference = set.reference();
    Ok(format!(
        "# Paints by the two constants of Kubelka and Munk over wavelength, relative to S of `{reference}`;\n\
         # k_error and s_error are standard errors of their logarithms.\n{body}"
    ))
}

/// Reads paints from a file.
///
/// # Errors
/// [`PaintFileError`], with the place.
pub fn load_paints(path: &Path) -> Result<PaintSet, PaintFileError> {
    parse_paints(&path.display().to_string(), &read(path)?)
}

/// As [`load_paints`], from a text.
///
/// # Errors
/// [`PaintFileError`], with the place.
pub fn parse_paints(name: &str, text: &str) -> Result<PaintSet, PaintFileError> {
    let help = "a file of paints is what `mieux paint fit` writes as paints.toml";
    let file: File = toml::from_str(text).map_err(|error| TextError::from_toml(name, text, &error).with_help(help))?;
    if file.format != FORMAT {
        let at = text.find(&file.format).unwrap_or(0);
        let message = format!("`{}` is not a format of paints that is known; `{FORMAT}` is", file.format);
        return Err(TextError::new(name, text, at..at + file.format.len(), message).with_help(help).into());
    }
    let wrong = |source: PaintError| PaintFileError::Paint { name: name.into(), source };
    let grid = WavelengthGrid::new(file.wavelengths_nm.iter().map(|nm| nm * 1e-9).collect());
    let grid = grid.map_err(|error| wrong(error.into()))?;
    let Surface { external, internal, specular } = file.surface;
    let paint = |Entry { name, k, s, k_error, s_error }| Paint { name, k, s, k_error, s_error };
    let paints = file.paints.into_iter().map(paint).collect();
    let set =
        PaintSet::new(grid, Saunderson { external, internal, specular }, file.reference, paints).map_err(wrong)?;
    match file.reference_scattering_per_m {
        Some(scattering) => set.with_scattering(scattering).map_err(wrong),
        None => Ok(set),
    }
}

/// What a fit leaves of each sample, and whether it was held out, as comma-separated values: colours in CIE L*a*b* under D65.
///
/// # Errors
/// Those of `out`.
pub fn write_residuals(out: impl Write, rows: &[(&Leftover, bool)]) -> io::Result<()> {
    let mut csv = csv::Writer::from_writer(out);
    csv.write_record([
        "sample",
        "held_out",
        "l_measured",
        "a_measured",
        "b_measured",
        "l_predicted",
        "a_predicted",
        "b_predicted",
        "ciede2000",
        "rms_reflectance",
    ])?;
    for (left, held_out) in rows {
        let (m, p) = (left.measured, left.predicted);
        let numbers = [m.l, m.a, m.b, p.l, p.a, p.b, left.ciede2000, left.rms].map(exact);
        let words = [left.name.clone(), held_out.to_string()];
        csv.write_record(words.iter().chain(&numbers))?;
    }
    csv.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set() -> PaintSet {
        let grid = WavelengthGrid::new(vec![400e-9, 550e-9, 700e-9]).unwrap();
        let paint = |name: &str, k: f64| Paint {
            name: name.into(),
            k: vec![k, k / 3.0, 1e-12],
            s: vec![1.0; 3],
            k_error: vec![0.1; 3],
            s_error: vec![],
        };
        let surface = Saunderson { external: 0.04, internal: 0.596, specular: 0.13 };
        let paints = vec![paint("white", 0.004), paint("blue red \"shade\"", 3.0)];
        PaintSet::new(grid, surface, "white".into(), paints).unwrap().with_scattering(6e4).unwrap()
    }

    #[test]
    fn what_is_written_is_read_back() {
        let text = paints_to_toml(&set()).unwrap();
        let back = parse_paints("p.toml", &text).unwrap();
        assert_eq!(back.paints(), set().paints());
        assert_eq!((back.surface(), back.scattering(), back.reference()), (set().surface(), Some(6e4), "white"));
        let again = parse_paints("p.toml", &paints_to_toml(&back).unwrap()).unwrap();
        assert!(again.grid().iter().zip(set().grid().iter()).all(|(a, b)| (a / b - 1.0).abs() < 1e-15));
    }

    #[test]
    fn residuals_are_a_table() {
        let lab = mieux_optics::spectrum::Lab { l: 50.0, a: 1.5, b: -2.0 };
        let left = Leftover { name: "a, b".into(), measured: lab, predicted: lab, ciede2000: 0.25, rms: 1e-3 };
        let mut bytes = Vec::new();
        write_residuals(&mut bytes, &[(&left, true)]).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        assert!(text.ends_with("\n\"a, b\",true,50,1.5,-2,50,1.5,-2,0.25,0.001\n"), "{text}");
    }

    #[test]
    fn mistakes_are_named_with_their_place() {
        let text = paints_to_toml(&set()).unwrap();
        for (from, to, expected) in [
            ("mieux paints 1", "mieux paints 9", "line 3, column"),
            ("external", "outer", "unknown field `outer`"),
            ("reference = \"white\"", "reference = \"grey\"", "no paint called `grey`"),
            ("0.004", "-0.004", "the value -0.004 at 400 nm"),
            ("s = [1.0, 1.0, 1.0]", "s = [1.0, 1.0]", "has 2 reflectances for 3 wavelengths"),
            ("internal = 0.596", "internal = 1.5", "1.5 is not between 0 and 1"),
            ("k = [", "k = 3 [", "p.toml, line"),
        ] {
            let error = parse_paints("p.toml", &text.replacen(from, to, 1)).unwrap_err().to_string();
            assert!(error.contains(expected), "{to}: {error}");
        }
    }
}
