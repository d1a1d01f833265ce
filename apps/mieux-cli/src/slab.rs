//! `mieux slab`: what can be typed, and what is printed.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::error::ErrorKind;
use clap::{Args, CommandFactory, Subcommand};
use mieux::io::quantity::{OpticalThickness, Thickness, format_duration, significant};
use mieux::io::recipe::parse_setting;
use mieux::jobs::{
    Backing, Job, PhaseName, Sample, Slab, SlabCompare, SlabCompareReport, SlabCompareSheet, SlabLight, SlabReport,
    SlabSheet, Solver, Trial,
};

use crate::args::{Cli, Format};
use crate::failure::Failure;
use crate::show::colour;

const EXAMPLES: &str = "\
Examples:
  mieux slab --albedo 0.9 --g 0.75 --tau 2
  mieux slab --albedo 0.9 --phase isotropic --tau inf --index 1.5
  mieux slab whole-milk --thickness 1mm,1cm,10cm --backing white -o out/milk
  mieux slab whole-milk --set fat=1.5 --thickness 1mm --slides 1.52 --format json
  mieux slab skim-milk --thickness 1mm --layers cuvette.toml
  mieux slab whole-milk --thickness 1mm --solver monte-carlo --photons 1000000
  mieux slab compare whole-milk --thickness 1mm

Light falls onto the top from the medium outside. Planes between different indices reflect and refract
(Fresnel, unpolarised). A material has the refractive index of its host, and scatters as Lorenz-Mie
theory says of its particles. A backing lies behind a gap of the medium outside unless it is in
--contact. A thickness or optical thickness of `inf` is a half-space.

--phase FILE is a CSV file with the columns angle_deg,phase (0 to 180 degrees, any scale: it is
divided by its integral), as `mieux phase --format csv` writes it, or degree,moment (Legendre moments
from degree 0).

--layers FILE is a TOML file of layers, from top to bottom:
  [[layer]]
  pane = 1.52                 # clear, of this index; `tau` if it absorbs
  [[layer]]
  material = \"whole-milk\"     # or a recipe beside the file; `*` is MATERIAL, as thick as --thickness
  set = { fat = 1.5 }
  thickness = \"1mm\"
  [[layer]]
  albedo = 0.9                # an abstract medium
  g = 0.75                    # or `phase`: isotropic, rayleigh, a file beside this one
  tau = 2
  index = 1.4

With -o, DIR holds slab.csv, slab.json and the plot slab.svg (of `compare`, slab-compare.csv and
slab-compare.json).

JSON keys, each an array with an entry for every thickness and wavelength (a number for one abstract
slab): thickness_m (null for a half-space or where there is none), optical_thickness (null for a
half-space), wavelength_nm, reflectance (all that comes back, the surface's share included),
transmittance (all that passes and does not come back), absorptance (what stays in the layers),
reflectance_specular and transmittance_unscattered (the parts of these that were never scattered), and
with monte-carlo each of the five with _se (standard error) and photons; then solver, streams, light,
backing, and swatches: an object for every thickness with the colours under D65 for the CIE 1931
observer, reflected and transmitted as sRGB (#rrggbb) and reflected_linear_srgb and
transmitted_linear_srgb. Spectra are taken as constant beyond their ends: ask for 400 to 700 nm at
least where colour matters.";

const COMPARE: &str = "\
Examples:
  mieux slab compare --albedo 0.9 --g 0.75 --tau 2
  mieux slab compare whole-milk --thickness 1mm --photons 1000000 --format json

Every solver that applies is run on the same slabs and compared with discrete ordinates of 64 streams:
the largest differences of reflectance, transmittance and absorptance over all thicknesses and
wavelengths, in standard errors where photons were counted, and the time each took.

JSON keys: those of `mieux slab`, with the answers of 64 streams; reference and solvers, objects with
solver, streams, wall_s, processor_s, the five shares as arrays, and of each solver difference_NAME,
and with monte-carlo NAME_se and deviation_NAME (in standard errors); not_applicable, objects with
solver and reason.";

#[derive(Args)]
#[command(after_help = EXAMPLES, args_conflicts_with_subcommands = true, disable_help_subcommand = true)]
pub struct SlabArgs {
    #[command(subcommand)]
    command: Option<SlabCommand>,
    #[command(flatten)]
    slab: SlabOptions,
    /// How light is followed
    #[arg(long, value_name = "SOLVER", default_value = Solver::default().name(), value_parser = solver())]
    solver: Solver,
}

#[derive(Subcommand)]
enum SlabCommand {
    /// Run all solvers and tabulate how far they are from each other, and their times
    #[command(after_help = COMPARE)]
    Compare(SlabOptions),
}

/// What both take.
#[derive(Args)]
struct SlabOptions {
    /// A material (see `mieux materials`), or the path of a recipe
    material: Option<String>,
    /// Set an input of the material, as in `fat=1.5`; may be given several times
    #[arg(long, value_name = "NAME=NUMBER")]
    set: Vec<String>,
    /// How thick the material is, as in `1mm` or `1mm,1cm,inf`
    #[arg(long, value_name = "LENGTHS", value_delimiter = ',', allow_hyphen_values = true)]
    thickness: Vec<Thickness>,
    /// Wavelengths in vacuum, as in `400nm:700nm:25nm` or `450nm,550nm` [default: 375nm:775nm:25nm]
    #[arg(long, value_name = "WAVELENGTHS")]
    wavelengths: Option<String>,
    /// A file of layers (see below)
    #[arg(long, value_name = "FILE")]
    layers: Option<PathBuf>,
    /// Single-scattering albedo of an abstract medium, 0 to 1
    #[arg(long, allow_hyphen_values = true)]
    albedo: Option<f64>,
    /// Its asymmetry, between -1 and 1
    #[arg(long, allow_hyphen_values = true)]
    g: Option<f64>,
    /// Its optical thickness, as in `2` or `0.5,1,inf`
    #[arg(long, value_name = "NUMBERS", value_delimiter = ',', allow_hyphen_values = true)]
    tau: Vec<OpticalThickness>,
    /// Its phase function: hg, isotropic, rayleigh, or a file (see below) [default: hg]
    #[arg(long, value_name = "NAME|FILE")]
    phase: Option<PhaseName>,
    /// Refractive index of the medium [default: 1] or material [default: that of its host]
    #[arg(long, allow_hyphen_values = true)]
    index: Option<f64>,
    /// Put it between clear slides of this refractive index
    #[arg(long, value_name = "INDEX", allow_hyphen_values = true)]
    slides: Option<f64>,
    /// Refractive index of the medium outside
    #[arg(long, value_name = "INDEX", default_value_t = 1.0, allow_hyphen_values = true)]
    index_outside: f64,
    /// Angle of incidence in degrees, against the normal [default: 0]
    #[arg(long, value_name = "DEGREES", conflicts_with = "diffuse", allow_hyphen_values = true)]
    angle: Option<f64>,
    /// Let light fall in from all directions alike
    #[arg(long)]
    diffuse: bool,
    /// What lies below: black, white, a reflectance, or `mirror:` and a reflectance
    #[arg(long, value_name = "BACKING", default_value_t = Backing::default(), allow_hyphen_values = true)]
    backing: Backing,
    /// The backing is in optical contact, without a gap
    #[arg(long)]
    contact: bool,
    /// Streams of solvers that have some: even, 2 to 256 [default: 32]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    streams: Option<usize>,
    /// Photons for each thickness and wavelength, of monte-carlo [default: 100000]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    photons: Option<u64>,
    /// The same seed gives the same result, to the bit [default: 0]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Relative tolerance of the integral over particle sizes
    #[arg(long, default_value = "1e-4", allow_hyphen_values = true)]
    tolerance: f64,
    /// How to print the result
    #[arg(long, value_enum, default_value = "table")]
    format: Format,
    /// Folder for tables and plot
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

fn solver() -> impl TypedValueParser<Value = Solver> {
    PossibleValuesParser::new(Solver::ALL.map(Solver::name)).try_map(|name| name.parse::<Solver>())
}

impl SlabArgs {
    pub fn format(&self) -> Format {
        match &self.command {
            Some(SlabCommand::Compare(options)) => options.format,
            None => self.slab.format,
        }
    }

    pub fn job(self) -> Result<Job, Failure> {
        Ok(match self.command {
            Some(SlabCommand::Compare(options)) => Job::SlabCompare(SlabCompare { slab: options.job()? }),
            None => Job::Slab(Slab { solver: self.solver, ..self.slab.job()? }),
        })
    }
}

impl SlabOptions {
    fn job(self) -> Result<Slab, Failure> {
        self.check_kind()?;
        let light = if self.diffuse { SlabLight::Diffuse } else { SlabLight::Angle(self.angle.unwrap_or(0.0)) };
        let (wavelengths, output) = (self.wavelengths.clone(), self.output.clone());
        let slab = Slab {
            wavelengths,
            light,
            backing: self.backing,
            contact: self.contact,
            index_outside: self.index_outside,
            slides: self.slides,
            solver: Solver::Auto,
            streams: self.streams,
            photons: self.photons,
            seed: self.seed,
            tolerance: self.tolerance,
            output,
            ..Slab::new(Sample::Layers { layers: PathBuf::new(), material: None, set: [].into(), thickness: vec![] })
        };
        Ok(Slab { sample: self.sample()?, ..slab })
    }

    /// That the options belong to one kind of sample.
    fn check_kind(&self) -> Result<(), Failure> {
        let given = |options: &[(&'static str, bool)]| options.iter().find(|(_, given)| *given).map(|(name, _)| *name);
        let abstract_only = given(&[
            ("--albedo", self.albedo.is_some()),
            ("--g", self.g.is_some()),
            ("--tau", !self.tau.is_empty()),
            ("--phase", self.phase.is_some()),
        ]);
        let material_only = given(&[
            ("a material", self.material.is_some()),
            ("--layers", self.layers.is_some()),
            ("--thickness", !self.thickness.is_empty()),
            ("--set", !self.set.is_empty()),
            ("--wavelengths", self.wavelengths.is_some()),
        ]);
        let conflict = |message: String| Err(usage(ErrorKind::ArgumentConflict, message));
        match (abstract_only, material_only) {
            (Some(one), Some(other)) => conflict(format!(
                "`{one}` describes an abstract medium, and {other} has no meaning with one; a material needs \
                 `--thickness`, an abstract medium `--albedo` and `--tau`"
            )),
            (None, None) => Err(usage(
                ErrorKind::MissingRequiredArgument,
                "a slab of what? Name a material and its `--thickness`, or give `--albedo` and `--tau`, or `--layers`"
                    .into(),
            )),
            (Some(_), None) => {
                let missing = [("--albedo", self.albedo.is_none()), ("--tau", self.tau.is_empty())];
                missing.into_iter().find(|(_, missing)| *missing).map_or(Ok(()), |(name, _)| {
                    let message = format!("an abstract medium needs `{name}`");
                    Err(usage(ErrorKind::MissingRequiredArgument, message))
                })
            }
            (None, Some(_)) if self.layers.is_some() && self.index.is_some() => {
                conflict("`--index` has no meaning with `--layers`, where each layer has its own".into())
            }
            (None, Some(option)) if self.material.is_none() && self.layers.is_none() => {
                let message = format!("`{option}` has no meaning without a material");
                Err(usage(ErrorKind::MissingRequiredArgument, message))
            }
            (None, Some(_)) => match (&self.material, self.thickness.is_empty()) {
                (Some(_), true) => Err(usage(
                    ErrorKind::MissingRequiredArgument,
                    "how thick is it? Give `--thickness`, as in `1mm`, or `inf` for a half-space".into(),
                )),
                (None, false) => conflict("`--thickness` has no meaning without a material".into()),
                (None, true) if !self.set.is_empty() => conflict("`--set` has no meaning without a material".into()),
                _ => Ok(()),
            },
        }
    }

    fn sample(self) -> Result<Sample, Failure> {
        if let Some(albedo) = self.albedo {
            let phase = self.phase.unwrap_or_default();
            return Ok(Sample::Medium { albedo, g: self.g, phase, tau: self.tau, index: self.index });
        }
        let set = self.set.iter().map(|s| parse_setting(s)).collect::<Result<_, _>>()?;
        let (material, thickness) = (self.material, self.thickness);
        Ok(match (self.layers, material) {
            (None, Some(material)) => Sample::Material { material, set, thickness, index: self.index },
            (layers, material) => Sample::Layers { layers: layers.unwrap_or_default(), material, set, thickness },
        })
    }
}

fn usage(kind: ErrorKind, message: String) -> Failure {
    let mut cli = Cli::command();
    cli.build();
    match cli.find_subcommand_mut("slab") {
        Some(slab) => slab.error(kind, message),
        None => cli.error(kind, message),
    }
    .into()
}

pub fn show(report: &SlabReport, format: Format) -> Result<(), Failure> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    let sheet = &report.sheet;
    match format {
        Format::Table => {
            writeln!(out, "{}\n{}", sheet.title, sheet.summary())?;
            for note in &sheet.notes {
                writeln!(out, "{note}")?;
            }
            write!(out, "\n{}\n{}", sheet.table()?.without_title().to_text(6), colours(sheet))?;
            for file in &report.files {
                writeln!(out, "{}", file.display())?;
            }
        }
        Format::Csv => sheet.table()?.write_csv(&mut out)?,
        Format::Json => writeln!(out, "{:#}", sheet.json())?,
    }
    Ok(out.flush()?)
}

/// A line for each slab with its colours.
fn colours(sheet: &SlabSheet) -> String {
    let patches = sheet.patches();
    let names: Vec<String> = sheet.cases.iter().map(SlabSheet::name_of).collect();
    let width = names.iter().map(|name| name.chars().count()).max().unwrap_or(0);
    let lines = patches.iter().zip(&names).map(|(patch, name)| {
        let (reflected, transmitted) = (colour(patch.reflected), colour(patch.transmitted));
        let name = if width == 0 { String::new() } else { format!(" {name:<width$} ") };
        format!("colour{name} reflected {reflected}  transmitted {transmitted}\n")
    });
    lines.collect()
}

pub fn show_comparison(report: &SlabCompareReport, format: Format) -> Result<(), Failure> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    let sheet = &report.sheet;
    match format {
        Format::Table => {
            write!(out, "{}", comparison(sheet))?;
            for file in &report.files {
                writeln!(out, "{}", file.display())?;
            }
        }
        Format::Csv => sheet.table()?.write_csv(&mut out)?,
        Format::Json => writeln!(out, "{:#}", sheet.json())?,
    }
    Ok(out.flush()?)
}

/// One row for each solver.
fn comparison(sheet: &SlabCompareSheet) -> String {
    let count = sheet.reference.answers.len();
    let mut text = format!(
        "{}\n{count} {}; differences from discrete ordinates with {} streams, the largest of each\n\n",
        sheet.basis.title,
        if count == 1 { "slab" } else { "slabs and wavelengths" },
        sheet.reference.streams.unwrap_or_default(),
    );
    let header = ["solver", "streams", "dR", "dT", "dA", "std errors", "wall", "processors"];
    let mut rows: Vec<[String; 8]> = vec![header.map(str::to_owned)];
    for trial in std::iter::once(&sheet.reference).chain(&sheet.trials) {
        rows.push(row(sheet, trial));
    }
    let widths: [usize; 8] = std::array::from_fn(|i| rows.iter().map(|row| row[i].chars().count()).max().unwrap_or(0));
    for row in rows {
        let cells: Vec<String> = row.iter().zip(widths).map(|(cell, width)| format!("{cell:>width$}")).collect();
        text += &format!("{}\n", cells.join("  "));
    }
    for (solver, reason) in &sheet.refused {
        text += &format!("{solver} does not apply: {reason}\n");
    }
    text
}

fn row(sheet: &SlabCompareSheet, trial: &Trial) -> [String; 8] {
    let or_none = |text: Option<String>| text.unwrap_or_else(|| "-".into());
    let [r, t, a] = sheet.largest_differences(trial).map(|difference| significant(difference, 2));
    let deviation = trial.largest_deviation(&sheet.reference);
    [
        trial.solver.to_string(),
        or_none(trial.streams.map(|streams| streams.to_string())),
        r,
        t,
        a,
        or_none(deviation.map(|deviation| significant(deviation, 3))),
        format_duration(trial.wall_s),
        or_none(trial.processor_s.map(format_duration)),
    ]
}
