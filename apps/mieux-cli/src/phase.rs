//! `mieux phase`: what can be typed, and what is printed.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::error::ErrorKind;
use clap::{Args, CommandFactory};
use mieux::io::nearest_names;
use mieux::io::quantity::{Angles, Length, RefractiveIndex, significant};
use mieux::io::recipe::{MATERIALS, parse_setting};
use mieux::jobs::{Comparand, Compared, FitKind, Phase, PhaseModel, PhaseReport, PhaseSheet};

use crate::args::{Cli, Format};
use crate::failure::Failure;

const EXAMPLES: &str = "\
Functions, and the options that each takes:
  isotropic, rayleigh
  hg                --g
  double-hg         --weight (of the first lobe) --g1 --g2
  cornette-shanks   --g
  draine            --g --alpha
  fournier-forand   --index, and --slope or --backscatter
  fog               --diameter
  mie               --diameter [--wavelength] [--host] [--particle]
  MATERIAL          [--set] [--wavelength]

Examples:
  mieux phase fog --diameter 10um
  mieux phase mie --diameter 10um --wavelength 550nm --compare fog,hg,hg-draine -o out/droplet
  mieux phase whole-milk --wavelength 550nm --set fat=1.5 --compare hg,two-lobe-hg
  mieux phase fournier-forand --index 1.1 --backscatter 0.0183 --format json

With --compare, `hg`, `two-lobe-hg` and `hg-draine` are fitted to FUNCTION (least squares of the
logarithm over solid angle); any other word is a function of its own, with the options given.

With -o, DIR holds phase.csv, phase.json and the plot phase-function.svg.

JSON keys: phase (its name), title, parameters, source (a key of references.bib), asymmetry (mean
cosine), legendre_moments (from degree 0), angle_deg, phase_per_sr (1/sr; integrates to 1 over the
sphere), and comparisons, an array of objects with these keys and fitted, delta_asymmetry, rms_log10
(root mean square over solid angle of the difference of the decimal logarithms), max_log10,
total_variation (share of the light that goes elsewhere).";

/// Compute how scattered light spreads over angle (the phase function), by name and parameters, for one sphere, or for a
/// material
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct PhaseArgs {
    /// A phase function (listed below), a material (see `mieux materials`), or the path of a recipe
    pub function: String,
    #[command(flatten)]
    options: Options,
    /// Compare with these, as in `hg,fog,mie`
    #[arg(long, value_name = "FUNCTIONS", value_delimiter = ',')]
    compare: Vec<String>,
    /// Fits keep the mean cosine, at the price of shape
    #[arg(long, requires = "compare")]
    keep_asymmetry: bool,
    /// Scattering angles in degrees, 0 forward, as in `0:180:0.5` [default: 0:180:5]
    #[arg(long, value_name = "FROM:TO:STEP", allow_hyphen_values = true)]
    angles: Option<Angles>,
    /// The highest Legendre moment to give
    #[arg(long, value_name = "DEGREE", default_value_t = Phase::DEFAULT_MOMENTS,
        value_parser = clap::value_parser!(u32).range(0..=i64::from(Phase::MAX_MOMENTS)))]
    moments: u32,
    /// Relative tolerance of Lorenz-Mie results
    #[arg(long, default_value_t = Phase::DEFAULT_TOLERANCE, allow_hyphen_values = true)]
    tolerance: f64,
    /// How to print the result
    #[arg(long, value_enum, default_value = "table")]
    pub format: Format,
    /// Folder for table and plot
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

/// What single functions take.
#[derive(Args, Clone)]
struct Options {
    /// Diameter of the sphere, as in `10um`
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, value_parser = Length::parse_positive)]
    diameter: Option<Length>,
    /// Wavelength in vacuum [default: 550nm]
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, value_parser = Length::parse_positive)]
    wavelength: Option<Length>,
    /// Refractive index around the sphere [default: 1]
    #[arg(long, value_name = "INDEX", allow_hyphen_values = true)]
    host: Option<RefractiveIndex>,
    /// Refractive index of the sphere, as in `1.5+0.01i` [default: that of water]
    #[arg(long, value_name = "INDEX", allow_hyphen_values = true)]
    particle: Option<RefractiveIndex>,
    /// Set an input of the material, as in `fat=1.5`; may be given several times
    #[arg(long, value_name = "NAME=NUMBER")]
    set: Vec<String>,
    /// Asymmetry, between -1 and 1
    #[arg(long, allow_hyphen_values = true)]
    g: Option<f64>,
    /// Draine's second parameter, 0 or more
    #[arg(long, allow_hyphen_values = true)]
    alpha: Option<f64>,
    /// Share of the first lobe, 0 to 1
    #[arg(long, allow_hyphen_values = true)]
    weight: Option<f64>,
    /// Asymmetry of the first lobe
    #[arg(long, allow_hyphen_values = true)]
    g1: Option<f64>,
    /// Asymmetry of the second lobe
    #[arg(long, allow_hyphen_values = true)]
    g2: Option<f64>,
    /// Refractive index of the particles relative to water
    #[arg(long, value_name = "INDEX", allow_hyphen_values = true)]
    index: Option<f64>,
    /// Slope of the size distribution, between 3 and 5
    #[arg(long, allow_hyphen_values = true)]
    slope: Option<f64>,
    /// Share of the light scattered by more than 90 degrees
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true, conflicts_with = "slope")]
    backscatter: Option<f64>,
}

/// The functions by their names.
const FUNCTIONS: [&str; 9] =
    ["isotropic", "rayleigh", "hg", "double-hg", "cornette-shanks", "draine", "fournier-forand", "fog", "mie"];

fn usage(kind: ErrorKind, message: String) -> Failure {
    let mut cli = Cli::command();
    cli.build();
    match cli.find_subcommand_mut("phase") {
        Some(phase) => phase.error(kind, message),
        None => cli.error(kind, message),
    }
    .into()
}

impl PhaseArgs {
    pub fn job(self) -> Result<Phase, Failure> {
        let mut unused = self.options.names();
        let mut model = |word: &str| {
            let mut options = self.options.clone();
            let model = options.take_model(word)?;
            let left = options.names();
            unused.retain(|name| left.contains(name));
            Ok::<_, Failure>(model)
        };
        let function = model(&self.function)?;
        let mut compare = Vec::new();
        for word in &self.compare {
            compare.push(match FitKind::ALL.into_iter().find(|kind| kind.name() == word) {
                Some(kind) => Comparand::Fit(kind),
                None => Comparand::Model(model(word)?),
            });
        }
        if let Some(name) = unused.first() {
            let message = format!("`--{name}` means nothing to `{}`", self.function);
            return Err(usage(ErrorKind::ArgumentConflict, message));
        }
        Ok(Phase {
            compare,
            keep_asymmetry: self.keep_asymmetry,
            angles: self.angles,
            moments: self.moments,
            tolerance: self.tolerance,
            output: self.output,
            ..Phase::new(function)
        })
    }
}

impl Options {
    /// Names of those that are given.
    fn names(&self) -> Vec<&'static str> {
        let given = [
            ("diameter", self.diameter.is_some()),
            ("wavelength", self.wavelength.is_some()),
            ("host", self.host.is_some()),
            ("particle", self.particle.is_some()),
            ("set", !self.set.is_empty()),
            ("g", self.g.is_some()),
            ("alpha", self.alpha.is_some()),
            ("weight", self.weight.is_some()),
            ("g1", self.g1.is_some()),
            ("g2", self.g2.is_some()),
            ("index", self.index.is_some()),
            ("slope", self.slope.is_some()),
            ("backscatter", self.backscatter.is_some()),
        ];
        given.into_iter().filter(|(_, given)| *given).map(|(name, _)| name).collect()
    }

    /// The function of that name, made of the options that it needs, which are taken away.
    fn take_model(&mut self, word: &str) -> Result<PhaseModel, Failure> {
        let missing = |option: &str| {
            let message = format!("`{word}` needs `--{option}`");
            usage(ErrorKind::MissingRequiredArgument, message)
        };
        Ok(match word {
            "isotropic" => PhaseModel::Isotropic {},
            "rayleigh" => PhaseModel::Rayleigh {},
            "hg" => PhaseModel::Hg { g: self.g.take().ok_or_else(|| missing("g"))? },
            "double-hg" => PhaseModel::DoubleHg {
                weight: self.weight.take().ok_or_else(|| missing("weight"))?,
                g1: self.g1.take().ok_or_else(|| missing("g1"))?,
                g2: self.g2.take().ok_or_else(|| missing("g2"))?,
            },
            "cornette-shanks" => PhaseModel::CornetteShanks { g: self.g.take().ok_or_else(|| missing("g"))? },
            "draine" => PhaseModel::Draine {
                g: self.g.take().ok_or_else(|| missing("g"))?,
                alpha: self.alpha.take().ok_or_else(|| missing("alpha"))?,
            },
            "fournier-forand" => PhaseModel::FournierForand {
                refractive_index: self.index.take().ok_or_else(|| missing("index"))?,
                slope: self.slope.take(),
                backscatter: self.backscatter.take(),
            },
            "fog" => PhaseModel::Fog { diameter: self.diameter.take().ok_or_else(|| missing("diameter"))? },
            "mie" => PhaseModel::Mie {
                diameter: self.diameter.take().ok_or_else(|| missing("diameter"))?,
                wavelength: self.wavelength.take().unwrap_or(Length::GREEN),
                host: self.host.take().unwrap_or(RefractiveIndex::VACUUM),
                particle: self.particle.take(),
            },
            _ => self.take_material(word)?,
        })
    }

    fn take_material(&mut self, word: &str) -> Result<PhaseModel, Failure> {
        let names = || MATERIALS.iter().map(|(name, _)| *name);
        let file = word.ends_with(".toml") || word.contains(['/', '\\']);
        if !file && !names().any(|name| name == word) {
            let near = nearest_names(word, FUNCTIONS.into_iter().chain(names()));
            let help = match near.first() {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("the functions are {}; `mieux materials` lists the materials", FUNCTIONS.join(", ")),
            };
            return Err(usage(
                ErrorKind::InvalidValue,
                format!("no phase function or material called `{word}`; {help}"),
            ));
        }
        Ok(PhaseModel::Material {
            material: word.to_owned(),
            set: std::mem::take(&mut self.set).iter().map(|s| parse_setting(s)).collect::<Result<_, _>>()?,
            wavelength: self.wavelength.take().unwrap_or(Length::GREEN),
        })
    }
}

pub fn show(report: &PhaseReport, format: Format) -> Result<(), Failure> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    let sheet = &report.sheet;
    match format {
        Format::Table => {
            write!(out, "{}", summary(sheet))?;
            write!(out, "\n{}", sheet.table()?.without_title().to_text(5))?;
            for file in &report.files {
                writeln!(out, "{}", file.display())?;
            }
        }
        Format::Csv => sheet.table()?.write_csv(&mut out)?,
        Format::Json => writeln!(out, "{:#}", sheet.json())?,
    }
    Ok(out.flush()?)
}

/// The function, its moments, and how far the others are.
fn summary(sheet: &PhaseSheet) -> String {
    let phase = &sheet.function.phase;
    let moments: Vec<String> = sheet.legendre_moments(phase).iter().map(|m| significant(tidy(*m), 4)).collect();
    let mut text = format!("{}\n", sheet.function.title);
    text += &format!("{:<18}{}\n", "asymmetry g", significant(tidy(phase.asymmetry()), 5));
    text += &format!("{:<18}{}\n", "Legendre moments", moments.join(" "));
    if !sheet.compared.is_empty() {
        let width = sheet.compared.iter().map(|c| c.other.name.chars().count() + 4).max().unwrap_or(0).max(12);
        text += &format!(
            "\n{:<width$}{:>10}{:>10}{:>14}{:>14}{:>18}\n",
            "", "g", "delta g", "rms log10 p", "max log10 p", "light elsewhere"
        );
        for Compared { other, fitted, comparison: c } in &sheet.compared {
            let name = if *fitted { format!("{} fit", other.name) } else { other.name.clone() };
            text += &format!(
                "{name:<width$}{:>10}{:>10}{:>14}{:>14}{:>16} %\n",
                significant(tidy(other.phase.asymmetry()), 5),
                significant(tidy(c.delta_asymmetry), 3),
                significant(c.rms_log10, 3),
                significant(c.max_log10, 3),
                significant(100.0 * c.total_variation, 3)
            );
        }
        for compared in &sheet.compared {
            text += &format!("{}: {}\n", compared.other.name, compared.other.title);
        }
    }
    text
}

/// Without what rounding left of zero.
fn tidy(value: f64) -> f64 {
    if value.abs() < 1e-12 { 0.0 } else { value }
}
