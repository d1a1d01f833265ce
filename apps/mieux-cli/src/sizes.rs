//! `mieux sizes`: what can be typed, and what is printed.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use mieux::io::quantity::{format_length, significant};
use mieux::jobs::{Population, Sizes, SizesReport};

use crate::args::Format;
use crate::failure::Failure;

const EXAMPLES: &str = "\
Examples:
  mieux sizes log-normal weighting=number median=0.4um geometric_deviation=1.5
  mieux sizes gamma effective_radius=10um effective_variance=0.1 -o out/cloud
  mieux sizes table weighting=intensity file=dls.csv
  mieux sizes whole-milk fat=1.5

Kinds and keys are those of recipes (docs/recipes.md): monodisperse, log-normal, gamma, modified-gamma,
power-law, rosin-rammler, transformed-log-normal, table, sum. Sizes are radii.

Weightings: by number, surface (r^2), volume (r^3), and by the light that particles much smaller than
the wavelength scatter (intensity, r^6). The z-average is what dynamic light scattering reports for such
particles: the harmonic mean by intensity. `none` stands where too many particles are vanishingly small.

With -o, DIR holds sizes.csv (a density over radius by number, surface and volume, and what lies below
in --weighting; a numbered file each if there are several), sizes.json and sizes.svg.";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct SizesArgs {
    /// A kind of distribution, a material (see `mieux materials`), or the path of a recipe
    pub of: String,
    /// What the distribution needs, as in `median=0.4um`; or inputs of the material
    #[arg(value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// What the table counts up: number, surface, volume or intensity [default: volume]
    #[arg(long, value_name = "WEIGHTING")]
    pub weighting: Option<String>,
    /// How to print the result
    #[arg(long, value_enum, default_value = "table")]
    pub format: Format,
    /// Also write tables and a plot to this folder
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

impl SizesArgs {
    pub fn job(self) -> Result<Sizes, Failure> {
        Ok(Sizes { set: self.set, weighting: self.weighting, output: self.output, ..Sizes::new(self.of) })
    }
}

pub fn show(report: &SizesReport, format: Format) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match format {
        Format::Table => {
            for population in &report.populations {
                write!(out, "{}", summary(population))?;
            }
            if report.populations.is_empty() {
                writeln!(out, "{}: no particles", report.title)?;
            }
            for file in &report.files {
                writeln!(out, "{}", file.display())?;
            }
        }
        Format::Csv => {
            for population in &report.populations {
                population.table(report.weighting)?.write_csv(&mut out)?;
            }
        }
        Format::Json => writeln!(out, "{:#}", report.json())?,
    }
    Ok(())
}

fn summary(population: &Population) -> String {
    let what = if population.radii { "radius" } else { "length" };
    let length = |value: Option<f64>| value.map_or("none".into(), format_length);
    let mut text = format!("{}, {what}\n", population.name);
    text += &format!("{:<14}", "  by");
    for head in ["mean", "deviation", "10 % below", "median", "90 % below", "mode"] {
        text += &format!("{head:>12}");
    }
    text += "\n";
    for w in &population.summary.weighted {
        let [low, median, high] = [0, 1, 2].map(|i| w.quantiles.map(|q| q[i]));
        text += &format!("  {:<12}", w.weighting.name());
        for value in [w.mean, w.deviation, low, median, high, w.mode] {
            text += &format!("{:>12}", length(value));
        }
        text += "\n";
    }
    let s = &population.summary;
    let number = |value: Option<f64>, unit: &str| {
        value.map_or("none".into(), |v| format!("{} {unit}", significant(v, 5)).trim_end().to_owned())
    };
    text += &format!("  effective {what} {}", length(s.effective_radius));
    text += &format!(", effective variance {}\n", number(s.effective_variance, ""));
    text += &format!("  z-average {what} {}\n", length(s.z_average));
    if population.radii {
        text += &format!("  mean volume {}", number(s.mean_volume.map(|v| v * 1e18), "um^3"));
        text += &format!(", surface per volume {}\n", number(s.specific_surface, "1/m"));
    }
    text
}
