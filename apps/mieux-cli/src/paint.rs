//! `mieux paint`.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::PathBuf;

use clap::error::ErrorKind;
use clap::{Args, CommandFactory, Subcommand, ValueEnum};
use mieux::io::quantity::{Length, format_length, significant};
use mieux::jobs::{
    HoldOut, Job, PaintFit, PaintFitReport, PaintMatch, PaintMatchReport, PaintMix, PaintMixReport, PaintTarget, Shown,
};
use mieux::optics::spectrum::Lab;

use crate::args::{Cli, Format};
use crate::failure::Failure;
use crate::show::colour;

/// What can be asked about paints.
#[derive(Subcommand)]
pub enum PaintCommand {
    /// Find absorption and scattering of paints from measured reflectances of known recipes
    Fit(FitArgs),
    /// Show what a mixture of paints looks like
    Mix(MixArgs),
    /// Find the recipe that comes nearest to a wanted colour
    Match(MatchArgs),
}

#[derive(Args)]
pub struct FitArgs {
    /// Measurements of opaque samples: JSON as of the Kimera data (percent), or CSV with `wavelength_nm` and a column for each
    /// sample named by its recipe, as in `white:0.7+blue:0.3` (shares)
    #[arg(required = true)]
    measurements: Vec<PathBuf>,
    /// The paint whose scattering is the unit [default: the one that is mixed with most others]
    #[arg(long, value_name = "PAINT")]
    reference: Option<String>,
    /// Refractive index of the binder
    #[arg(long, default_value_t = PaintFit::DEFAULT_INDEX)]
    index: f64,
    /// How much of the specular component the instrument counts, 0 (excluded) to 1 (included) [default: fitted]
    #[arg(long, value_name = "SHARE")]
    specular: Option<f64>,
    /// Thickness at which the reference by itself hides a black and white chart, as in `80um`; gives K and S their unit
    #[arg(long, value_name = "LENGTH", value_parser = Length::parse_positive)]
    reference_hides: Option<Length>,
    /// What to foretell rather than fit
    #[arg(long, value_enum, default_value = "none")]
    hold_out: Held,
    /// How to print the result
    #[arg(long, value_enum, default_value = "table")]
    pub format: Format,
    /// Folder for paints.toml, residuals.csv and figures
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Held {
    /// Nothing
    None,
    /// All measurements of a mixture but its first
    Repeats,
}

#[derive(Args)]
pub struct MixArgs {
    /// Paints and their amounts, in any one unit, as in `white=0.7 'blue red shade=0.3'`
    #[arg(required = true, value_name = "PAINT=AMOUNT")]
    recipe: Vec<String>,
    /// The file of paints, as `mieux paint fit` writes it
    #[arg(long, value_name = "FILE")]
    paints: PathBuf,
    /// Thickness of the film, as in `50um` [default: opaque]
    #[arg(long, value_name = "LENGTH")]
    thickness: Option<Length>,
    /// Reflectance of what is below the film: `black`, `white` or a number from 0 to 1
    #[arg(long, default_value = "black", requires = "thickness", value_parser = backing)]
    backing: f64,
    /// How to print the result
    #[arg(long, value_enum, default_value = "table")]
    pub format: Format,
}

#[derive(Args)]
pub struct MatchArgs {
    /// A colour of screens (`#c04030`), CIE L*a*b* under D65 (`lab:50,40,30`), or a CSV file of `wavelength_nm` and a reflectance
    target: String,
    /// The file of paints, as `mieux paint fit` writes it
    #[arg(long, value_name = "FILE")]
    paints: PathBuf,
    /// At most so many paints
    #[arg(long, value_name = "N", default_value_t = PaintMatch::DEFAULT_AT_MOST as u8,
        value_parser = clap::value_parser!(u8).range(1..=6))]
    at_most: u8,
    /// How to print the result
    #[arg(long, value_enum, default_value = "table")]
    pub format: Format,
}

fn backing(text: &str) -> Result<f64, String> {
    match text {
        "black" => Ok(0.0),
        "white" => Ok(0.8),
        number => number
            .parse()
            .ok()
            .filter(|share| (0.0..=1.0).contains(share))
            .ok_or_else(|| "it is `black` (0), `white` (0.8) or a number from 0 to 1".into()),
    }
}

impl PaintCommand {
    /// The job, and how to print what it leaves.
    pub fn job(self) -> Result<(Job, Format), Failure> {
        Ok(match self {
            Self::Fit(args) => {
                let format = args.format;
                let hold_out = match args.hold_out {
                    Held::None => HoldOut::None,
                    Held::Repeats => HoldOut::Repeats,
                };
                let job = PaintFit {
                    reference: args.reference,
                    index: args.index,
                    specular: args.specular,
                    reference_hides: args.reference_hides,
                    hold_out,
                    output: args.output,
                    ..PaintFit::new(args.measurements)
                };
                (Job::PaintFit(job), format)
            }
            Self::Mix(args) => {
                let recipe = recipe(&args.recipe)?;
                let job = PaintMix { paints: args.paints, recipe, thickness: args.thickness, backing: args.backing };
                (Job::PaintMix(job), args.format)
            }
            Self::Match(args) => {
                let target: PaintTarget = args.target.parse().map_err(Failure::from)?;
                let job = PaintMatch { paints: args.paints, target, at_most: usize::from(args.at_most) };
                (Job::PaintMatch(job), args.format)
            }
        })
    }
}

fn recipe(words: &[String]) -> Result<BTreeMap<String, f64>, Failure> {
    let usage = |message: String| -> Failure {
        let mut cli = Cli::command();
        cli.build();
        let mix = cli.find_subcommand_mut("paint").and_then(|paint| paint.find_subcommand_mut("mix"));
        mix.map(|mix| mix.error(ErrorKind::InvalidValue, &message))
            .unwrap_or_else(|| clap::Error::new(ErrorKind::InvalidValue))
            .into()
    };
    let mut recipe = BTreeMap::new();
    for word in words {
        let (name, amount) = word
            .rsplit_once('=')
            .ok_or_else(|| usage(format!("`{word}` is no part of a recipe; write `white=0.7`")))?;
        let value = amount.trim().parse().map_err(|_| usage(format!("`{amount}` in `{word}` is not a number")))?;
        if recipe.insert(name.trim().to_owned(), value).is_some() {
            return Err(usage(format!("`{}` is there twice", name.trim())));
        }
    }
    Ok(recipe)
}

pub fn show_fit(report: &PaintFitReport, format: Format) -> Result<(), Failure> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    match format {
        Format::Table => write!(out, "{}", fit_text(report))?,
        Format::Csv => {
            let rows: Vec<_> = report.samples.iter().map(|s| (&s.leftover, s.held_out)).collect();
            mieux::io::paint::write_residuals(&mut out, &rows)?;
        }
        Format::Json => writeln!(out, "{:#}", report.json())?,
    }
    Ok(out.flush()?)
}

fn fit_text(report: &PaintFitReport) -> String {
    let surface = report.paints.surface();
    let width = report.samples.iter().map(|s| s.leftover.name.chars().count()).max().unwrap_or(0).max(6);
    let mut text = format!("{:<width$}  CIEDE2000  rms reflectance\n", "sample");
    for sample in &report.samples {
        let left = &sample.leftover;
        let held = if sample.held_out { "  held out" } else { "" };
        text += &format!("{:<width$}  {:9.2}  {:15.4}{held}\n", left.name, left.ciede2000, left.rms);
    }
    for (held_out, what) in [(false, "fitted"), (true, "held out")] {
        if let Some(mean) = report.mean_ciede2000(held_out) {
            text += &format!("{:<width$}  {mean:9.2}\n", format!("mean, {what}"));
        }
    }
    text += &format!(
        "\nsurface: k1 = {} outside, k2 = {} inside; {} of what it reflects is counted{}\n",
        significant(surface.external, 3),
        significant(surface.internal, 4),
        significant(surface.specular, 3),
        match report.specular_error {
            0.0 => String::new(),
            error if error < 0.5 => format!(" (fitted, standard error {})", significant(error, 2)),
            _ => " (a guess: these samples do not tell)".into(),
        }
    );
    text += &format!("K and S are relative to S of {}", report.paints.reference());
    text += &match report.paints.scattering() {
        Some(per_metre) => format!(", which is {} 1/mm\n", significant(per_metre * 1e-3, 4)),
        None => "\n".into(),
    };
    if !report.ratio_only.is_empty() {
        text += &format!(
            "only K/S is known of {}: no measured mixture joins it to {}, and its S is a guess\n",
            report.ratio_only.join(", "),
            report.paints.reference()
        );
    }
    for file in &report.files {
        text += &format!("{}\n", file.display());
    }
    text
}

pub fn show_mix(report: &PaintMixReport, format: Format) -> Result<(), Failure> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    match format {
        Format::Table => {
            write!(out, "{}", colour_text(&report.shown))?;
            if let Some(thickness) = report.hiding_thickness {
                writeln!(out, "hides        at {} (contrast ratio 0.98)", format_length(thickness))?;
            }
            write!(out, "\n{}", report.shown.table()?.without_title().to_text(4))?;
        }
        Format::Csv => report.shown.table()?.write_csv(&mut out)?,
        Format::Json => writeln!(out, "{:#}", report.json())?,
    }
    Ok(out.flush()?)
}

pub fn show_match(report: &PaintMatchReport, format: Format) -> Result<(), Failure> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    match format {
        Format::Table => {
            for (name, share) in report.shown.recipe.parts() {
                writeln!(out, "{:>8.3} %  {name}", 100.0 * share)?;
            }
            writeln!(out, "\nwanted       {}", lab_text(report.wanted, report.wanted_linear_srgb))?;
            write!(out, "{}", colour_text(&report.shown))?;
            writeln!(out, "CIEDE2000    {:.2}{}", report.ciede2000, verdict(report.ciede2000))?;
            if let Some(rms) = report.rms {
                writeln!(out, "reflectance  rms {}", significant(rms, 3))?;
            }
        }
        Format::Csv => report.shown.table()?.write_csv(&mut out)?,
        Format::Json => writeln!(out, "{:#}", report.json())?,
    }
    Ok(out.flush()?)
}

fn verdict(difference: f64) -> &'static str {
    match difference {
        d if d < 1.0 => ", not to be told apart",
        d if d < 3.0 => ", seen side by side",
        _ => "; these paints come no nearer",
    }
}

fn colour_text(shown: &Shown) -> String {
    let gamut = if shown.in_gamut() { "" } else { ", beyond what a screen shows" };
    let mut text = format!(
        "mixture      {}{gamut}\n             {}\n",
        lab_text(shown.lab, shown.linear_srgb),
        shown.recipe.describe()
    );
    if let Some((from, to)) = shown.lacks_visible() {
        text += &format!("             colours are of light from {from} to {to} nm only\n");
    }
    text
}

/// A colour in numbers, with a patch of it where standard output is a terminal.
fn lab_text(lab: Lab, linear: [f64; 3]) -> String {
    format!("L* {:.1}  a* {:.1}  b* {:.1}  {}", lab.l, lab.a, lab.b, colour(linear))
}
