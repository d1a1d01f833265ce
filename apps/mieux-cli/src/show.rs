//! What is printed.

use std::collections::BTreeMap;
use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;

use clap::CommandFactory;
use mieux::io::plot::{srgb_bytes, srgb_hex};
use mieux::io::quantity::{format_duration, format_length, format_per_length};
use mieux::io::recipe::{MATERIALS, Recipe};
use mieux::io::scene::{SCENES, SceneFile};
use mieux::io::table::Table;
use mieux::jobs::{CompareReport, OpticsReport, OpticsSheet, RenderReport, made_of};

use crate::args::{Cli, Format, MaterialsArgs};
use crate::failure::Failure;

/// A colour (linear sRGB) as `#rrggbb`, with a patch of it where standard output is a terminal.
pub fn colour(linear: [f64; 3]) -> String {
    let hex = srgb_hex(linear);
    if !io::stdout().is_terminal() {
        return hex;
    }
    let [r, g, b] = srgb_bytes(linear);
    format!("{hex} \x1b[48;2;{r};{g};{b}m      \x1b[0m")
}

pub fn materials(args: &MaterialsArgs) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    let Some(name) = &args.material else {
        for (name, _) in MATERIALS {
            let recipe = Recipe::find(name)?;
            writeln!(out, "{name:<20} {}", recipe.about())?;
            let inputs: Vec<&str> = recipe.inputs().iter().map(|(input, _)| &*input.name).collect();
            if !inputs.is_empty() {
                writeln!(out, "{:<20} inputs: {}", "", inputs.join(", "))?;
            }
        }
        let more = "`mieux materials NAME` says what the inputs mean. A recipe of your own is a file: `mieux optics my.toml`. Its \
                    form is in docs/recipes.md; `mieux materials NAME --recipe` prints one to begin with.";
        writeln!(out, "\n{more}")?;
        return Ok(());
    };
    let recipe = Recipe::find(name)?;
    if args.recipe {
        write!(out, "{}", recipe.text())?;
        return Ok(());
    }
    writeln!(out, "{}\n{}", recipe.title(), recipe.about())?;
    for (input, value) in recipe.inputs() {
        writeln!(
            out,
            "    --set {:<12} {} ({} to {}): {}",
            input.name,
            input.shown(*value),
            input.minimum,
            input.shown(input.maximum),
            input.about
        )?;
    }
    let material = recipe.material(&BTreeMap::new())?;
    for made in made_of(&material.medium) {
        writeln!(
            out,
            "    {:>10} vol.-%  {}",
            mieux::io::quantity::significant(100.0 * made.volume_fraction, 4),
            made.what
        )?;
    }
    if let Some((from, to)) = material.medium.wavelength_range() {
        writeln!(out, "    known from {} to {}", format_length(from), format_length(to))?;
    }
    Ok(())
}

pub fn scenes() -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    for (name, _) in SCENES {
        let Some(scene) = SceneFile::built_in(name) else { continue };
        let scene = scene.map_err(mieux::io::recipe::RecipeError::from)?;
        writeln!(out, "{name:<16} {} Size: {}.", scene.about, scene.size)?;
    }
    Ok(())
}

pub fn completions(shell: clap_complete::Shell) {
    clap_complete::generate(shell, &mut Cli::command(), "mieux", &mut io::stdout());
}

pub fn optics(report: &OpticsReport, format: Format) -> Result<(), Failure> {
    let table = report.sheet.table().map_err(Failure::from)?;
    tabulated(&table, &report.sheet.json(), &report.files, format)?;
    if format == Format::Table {
        let mut out = io::stdout().lock();
        for warning in report.sheet.warnings() {
            writeln!(out, "warning: {warning}")?;
        }
    }
    Ok(())
}

pub fn compare(report: &CompareReport, format: Format) -> Result<(), Failure> {
    let table = report.sheet.table().map_err(Failure::from)?;
    if format == Format::Table {
        let mut out = io::stdout().lock();
        for (key, value) in table.metadata() {
            writeln!(out, "{key}: {value}")?;
        }
    }
    tabulated(&table, &report.sheet.json(), &report.files, format)
}

/// A table for people with the files written, or one of its other forms.
fn tabulated(table: &Table, json: &dyn std::fmt::Display, files: &[PathBuf], format: Format) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match format {
        Format::Table => {
            write!(out, "{}", table.to_text(5))?;
            for file in files {
                writeln!(out, "{}", file.display())?;
            }
        }
        Format::Csv => table.write_csv(&mut out)?,
        Format::Json => writeln!(out, "{json:#}")?,
    }
    Ok(())
}

#[allow(clippy::print_stdout)]
pub fn render(report: &RenderReport, again: &str) {
    let mut text = String::new();
    for sheet in &report.sheets {
        text += &summary(sheet);
    }
    let (least, most) = report.samples;
    let samples = if least == most { format!("{least}") } else { format!("{least} to {most}") };
    text += &format!(
        "{}: {samples} samples per pixel in {}, mean relative error per pixel {}",
        if report.interrupted { "stopped" } else { "picture" },
        format_duration(report.seconds),
        percent(report.noise)
    );
    if report.worst_noise.is_finite() {
        text += &format!(", {} in the worst tile", percent(report.worst_noise));
    }
    text += "\n";
    if let Some((k, n)) = report.shard {
        text += &format!("part {k} of {n}: `mieux merge` puts the parts together\n");
    }
    if report.approximate.is_some() {
        text += "approximate: in bodies at least ten transport mean free paths thick light diffuses instead of being \
                 followed (docs/diffusion.md)\n";
    }
    for note in &report.notes {
        text += &format!("{note}\n");
    }
    let lost = report.statistics.lost;
    if lost > 0 {
        text += &format!("{lost} of {} paths were given up; they count as dark\n", report.statistics.paths);
    }
    text += &format!("in {}:", report.folder.display());
    for file in &report.files {
        text += &format!(" {}", file.file_name().unwrap_or(file.as_os_str()).to_string_lossy());
    }
    text += "\n";
    if report.interrupted {
        text += &format!("to go on: {again}\n");
    }
    print!("{text}");
}

/// A relative error in percent; pixels with fewer than eight samples have none to give.
fn percent(noise: f64) -> String {
    if noise.is_finite() { format!("{:.1} %", 100.0 * noise) } else { "unknown (it takes 8 samples)".into() }
}

/// What a material is made of, and its properties at three wavelengths.
fn summary(sheet: &OpticsSheet) -> String {
    let made: Vec<String> = sheet
        .made_of()
        .iter()
        .map(|m| format!("{} {} vol.-%", m.what, mieux::io::quantity::significant(100.0 * m.volume_fraction, 3)))
        .collect();
    let mut text = format!("{}: {}\n", sheet.material.title, made.join(", "));
    for wavelength in [450e-9, 550e-9, 650e-9] {
        let [wavelength, reduced, absorption, g, extinction] = sheet.nearest(wavelength);
        let path = if extinction > 0.0 { format_length(1.0 / extinction) } else { "endless".into() };
        text += &format!(
            "  {:>6}  sigma_s' {:>10}  sigma_a {:>10}  g {g:.4}  mean free path {path}\n",
            format_length(wavelength),
            format_per_length(reduced),
            format_per_length(absorption),
        );
    }
    text
}
