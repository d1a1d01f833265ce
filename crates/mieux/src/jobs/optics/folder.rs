//! What `mieux optics` writes into a folder: tables for every reader, spectra, phase functions, colours.

use std::f64::consts::PI;
use std::path::PathBuf;

use mieux_io::netcdf::{NetCdf, Variable};
use mieux_io::output::OutputDir;
use mieux_io::plot::{comparison_figure, swatch_figure};
use mieux_io::quantity::format_length;
use mieux_io::table::Table;
use mieux_optics::phase::PhaseFunction;
use serde_json::{Value, json};

use super::super::slab::Look;
use super::super::{JobError, OpticsSheet};

/// Most curves in the figure of phase functions.
const CURVES: usize = 5;

/// Writes all files and names them.
pub(super) fn write(dir: &OutputDir, sheet: &OpticsSheet, look: &Look) -> Result<Vec<PathBuf>, JobError> {
    let mut files = sheet.write(dir, "optics")?;
    let json = json(sheet, look);
    files.push(dir.write("optics.json", |out| Ok(serde_json::to_writer_pretty(out, &json)?))?);
    #[cfg(feature = "parquet")]
    {
        let bytes = sheet.table()?.to_parquet()?;
        files.push(dir.write("optics.parquet", |out| out.write_all(&bytes))?);
    }
    let bytes = netcdf(sheet, look)?.to_bytes()?;
    files.push(dir.write("optics.nc", |out| out.write_all(&bytes))?);
    let (table, svg) = (phase_table(sheet, look)?, phase_svg(sheet, look)?);
    files.push(dir.write("phase.csv", |out| table.write_csv(out))?);
    files.push(dir.write("phase.svg", |out| out.write_all(svg.as_bytes()))?);
    if !look.colours.is_empty() {
        let svg = swatch_svg(sheet, look)?;
        files.push(dir.write("swatches.svg", |out| out.write_all(svg.as_bytes()))?);
    }
    Ok(files)
}

/// As [`OpticsSheet::json`], with the colours.
fn json(sheet: &OpticsSheet, look: &Look) -> Value {
    let mut json = sheet.json();
    if let (Value::Object(json), false) = (&mut json, look.colours.is_empty()) {
        json.insert("phase_functions".into(), json!(kind(look)));
        json.insert("layer_colours".into(), json!(look.colours.iter().map(|c| c.json()).collect::<Vec<_>>()));
    }
    json
}

/// By the CF conventions as far as these have names for it: SI units, wavelength and scattering angle as coordinates.
fn netcdf(sheet: &OpticsSheet, look: &Look) -> Result<NetCdf, JobError> {
    let (b, angles) = (&sheet.bulk, angles());
    let (wavelengths, directions) = (b.grid().as_slice().to_vec(), angles.len());
    let spectrum = |name: &str, units: &str, what: &str, values: Vec<f64>| {
        Variable::new(name, &["wavelength"], values).with("units", units).with("long_name", what)
    };
    let phase: Vec<f64> = look
        .functions
        .iter()
        .flat_map(|f| angles.iter().map(|angle| f.value(cosine(*angle))).collect::<Vec<_>>())
        .collect();
    let settings =
        sheet.material.inputs.iter().map(|(input, value)| format!("{} = {}", input.name, input.shown(*value)));
    let data = NetCdf::new()
        .with_attribute("Conventions", "CF-1.11")
        .with_attribute("title", format!("Optical properties of {}", sheet.material.title))
        .with_attribute("source", format!("mieux {}, Lorenz-Mie theory", env!("CARGO_PKG_VERSION")))
        .with_attribute("comment", settings.collect::<Vec<_>>().join("; "))
        .with_dimension("wavelength", wavelengths.len())
        .with_dimension("scattering_angle", directions)
        .with_variable(
            spectrum("wavelength", "m", "wavelength in vacuum", wavelengths)
                .with("standard_name", "radiation_wavelength"),
        )?
        .with_variable(
            Variable::new("scattering_angle", &["scattering_angle"], angles)
                .with("units", "degree")
                .with("standard_name", "scattering_angle")
                .with("long_name", "angle between the directions before and after, 0 is forward"),
        )?
        .with_variable(spectrum("sigma_s", "m-1", "scattering coefficient", b.sigma_s().to_vec()))?
        .with_variable(spectrum("sigma_a", "m-1", "absorption coefficient", b.sigma_a().to_vec()))?
        .with_variable(spectrum("sigma_t", "m-1", "extinction coefficient", b.sigma_t()))?
        .with_variable(spectrum("reduced_scattering", "m-1", "(1 - g) times scattering", b.reduced_scattering()))?
        .with_variable(spectrum("g", "1", "mean cosine of scattering", b.asymmetry().to_vec()))?
        .with_variable(spectrum("n_real", "1", "real part of the refractive index", b.n_real().to_vec()))?
        .with_variable(spectrum("n_imag", "1", "imaginary part of the refractive index", b.n_imag()))?
        .with_variable(
            Variable::new("phase_function", &["wavelength", "scattering_angle"], phase)
                .with("units", "sr-1")
                .with("long_name", "phase function, integrates to 1 over the sphere"),
        )?;
    Ok(data)
}

/// Angles in degrees: as fine towards forward as the peaks of millimetre particles ask for, single degrees later on.
fn angles() -> Vec<f64> {
    let peak = (0..=60).map(|i| 1e-3 * 10f64.powf(f64::from(i) / 20.0));
    std::iter::once(0.0).chain(peak).chain((2..=180).map(f64::from)).collect()
}

/// Rounded as sines are not: 180 degrees is exactly backward.
fn cosine(degrees: f64) -> f64 {
    if degrees == 180.0 { -1.0 } else { (degrees * PI / 180.0).cos() }
}

fn phase_table(sheet: &OpticsSheet, look: &Look) -> Result<Table, JobError> {
    let angles = angles();
    let mut table = Table::new(format!("{}: phase functions", sheet.material.title))
        .with_metadata("material", sheet.material.name.clone())
        .with_metadata("value", "per sr; integrates to 1 over the sphere; 0 deg is forward")
        .with_metadata("kind", kind(look))
        .with_column("angle", "deg", angles.clone())?;
    for (wavelength, function) in sheet.bulk.grid().iter().zip(&look.functions) {
        let values = angles.iter().map(|angle| function.value(cosine(*angle))).collect();
        table = table.with_column(format!("phase_{}", format_length(wavelength).replace(' ', "")), "1/sr", values)?;
    }
    Ok(table)
}

/// What the phase functions are.
fn kind(look: &Look) -> &'static str {
    let stands_in = |function: &PhaseFunction| matches!(function, PhaseFunction::HenyeyGreenstein(_));
    match look.functions.iter().filter(|function| stands_in(function)).count() {
        0 => "by Lorenz-Mie theory over all sizes, 1 - g right to 1 %",
        _ => "Henyey-Greenstein of the exact asymmetry where particles are too large for exact phase functions",
    }
}

fn phase_svg(sheet: &OpticsSheet, look: &Look) -> Result<String, JobError> {
    let angles = angles();
    let count = look.functions.len();
    let shown = CURVES.min(count);
    let curve = |i: usize| {
        let at = if shown > 1 { i * (count - 1) / (shown - 1) } else { 0 };
        let values = angles.iter().map(|angle| look.functions[at].value(cosine(*angle))).collect();
        (format_length(sheet.bulk.grid().as_slice()[at]), values)
    };
    let curves: Vec<(String, Vec<f64>)> = (0..shown).map(curve).collect();
    Ok(comparison_figure(&format!("{}: phase functions", sheet.material.title), &angles, &curves).to_svg()?)
}

fn swatch_svg(sheet: &OpticsSheet, look: &Look) -> Result<String, JobError> {
    let with = look.colours.iter().map(|c| (format!("{}, with the surface", c.label()), c.with_surface));
    let without = look.colours.iter().map(|c| (format!("{}, without", c.label()), c.without_surface));
    let patches: Vec<(String, [f64; 3])> = with.chain(without).collect();
    let title = format!("{}: layers in daylight, with and without the reflection on the surface", sheet.material.title);
    Ok(swatch_figure(&title, &patches).to_svg()?)
}
