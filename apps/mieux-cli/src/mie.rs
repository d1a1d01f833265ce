//! `mieux mie`: what can be typed, and what is printed.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use mieux::io::quantity::{Angles, Length, RefractiveIndex, format_area, format_duration, significant};
use mieux::jobs::{Coat, Definition, Job, Mie, MieBatch, MieBatchReport, MieReport, MieSheet};

use crate::args::Format;
use crate::failure::Failure;

const EXAMPLES: &str = "\
Examples:
  mieux mie --radius 0.5um --wavelength 550nm --host 1.33 --particle 1.5+0.01i
  mieux mie --radius 0.5um --wavelength 550nm --particle 1.33 --angles 0:180:0.5 --format csv
  mieux mie --radius 80nm --wavelength 550nm --particle 0.4+2.4i --layer 100nm:1.45 -o out/coated
  mieux mie --batch spheres.csv -o results.csv

Lengths need a unit: nm, um, mm, cm, m. Indices are n+ki, and k > 0 absorbs.

With --format csv there is one row; with --angles one row per angle, below the rest as # remarks.
With -o, DIR holds mie.csv (one row), angles.csv (with --angles, one row per angle), mie.json
and the plots efficiencies.svg (over size), phase-function.svg and polarisation.svg.

JSON keys: size_parameter (a number; [re, im] where the host absorbs), c_ext_m2, c_sca_m2,
c_abs_m2, q_ext, q_sca, q_abs, q_back (cross section over pi r^2 of the whole particle), g,
scattering_definition, and with --angles the arrays angle_deg, s1, s2 (each number as [re, im])
and phase_per_sr, p11, p12, p21, p22, p33, p34, p43, p44 (1/sr; p11 is the phase function, which
integrates to 1 over the sphere).

A batch is a file of comma-separated values with the columns radius_um, wavelength_um, host_re,
host_im, particle_re, particle_im, in any order; every other column is carried through. Added are
c_ext_m2, c_sca_m2, c_abs_m2, q_ext, q_sca, q_abs and g. A row that cannot be computed ends the
run with its line and column, and OUT is left as it was. Files may be larger than memory.";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct MieArgs {
    /// Radius of the sphere, or of the core where there are layers, as in `0.5um`
    #[arg(long, value_name = "LENGTH", required_unless_present = "batch", conflicts_with = "batch",
        allow_hyphen_values = true, value_parser = Length::parse_positive)]
    pub radius: Option<Length>,
    /// Wavelength in vacuum, as in `550nm`
    #[arg(long, value_name = "LENGTH", required_unless_present = "batch", conflicts_with = "batch",
        allow_hyphen_values = true, value_parser = Length::parse_positive)]
    pub wavelength: Option<Length>,
    /// Refractive index of the sphere or core, as in `1.5` or `1.5+0.01i`; a positive imaginary part absorbs
    #[arg(
        long,
        value_name = "INDEX",
        required_unless_present = "batch",
        conflicts_with = "batch",
        allow_hyphen_values = true
    )]
    pub particle: Option<RefractiveIndex>,
    /// Refractive index of what is around the particle [default: 1]
    #[arg(long, value_name = "INDEX", conflicts_with = "batch", allow_hyphen_values = true)]
    pub host: Option<RefractiveIndex>,
    /// Add a layer around the core that `--radius` and `--particle` give. RADIUS is the outer radius of the layer from the
    /// centre of the particle; may be given several times, from the inside outward
    #[arg(long = "layer", value_name = "RADIUS:INDEX", conflicts_with = "batch", allow_hyphen_values = true)]
    pub layers: Vec<Coat>,
    /// Scattering angles in degrees, 0 forward, as in `0:180:0.5`
    #[arg(long, value_name = "FROM:TO:STEP", conflicts_with = "batch", allow_hyphen_values = true)]
    pub angles: Option<Angles>,
    /// What scattering means where the host absorbs; in a lossless host it makes no difference
    #[arg(long, value_name = "NAME", default_value = Definition::default().name(), value_parser = definition())]
    pub definition: Definition,
    /// How to print the result
    #[arg(long, value_enum, default_value = "table", conflicts_with = "batch")]
    pub format: Format,
    /// Compute a table of homogeneous spheres, a row each (see below); needs `-o`
    #[arg(long, value_name = "IN.csv", requires = "output")]
    pub batch: Option<PathBuf>,
    /// How many threads a batch uses [default: one per core]; does not change the result
    #[arg(long, requires = "batch", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Folder for tables and plots; with `--batch`, the file to write
    #[arg(short, long, value_name = "DIR|OUT.csv")]
    pub output: Option<PathBuf>,
}

fn definition() -> impl TypedValueParser<Value = Definition> {
    let names = Definition::ALL.map(|d| PossibleValue::new(d.name()).help(d.about()));
    PossibleValuesParser::new(names)
        .map(|name| Definition::ALL.into_iter().find(|d| d.name() == name).unwrap_or_default())
}

impl MieArgs {
    pub fn job(self) -> Job {
        let definition = self.definition;
        match (self.batch, self.radius, self.wavelength, self.particle) {
            (None, Some(radius), Some(wavelength), Some(particle)) => Job::Mie(Mie {
                host: self.host.unwrap_or(RefractiveIndex::VACUUM),
                layers: self.layers,
                angles: self.angles,
                definition,
                output: self.output,
                ..Mie::new(radius, wavelength, particle)
            }),
            // The parser has seen to it that there is an input and an output.
            (input, ..) => Job::MieBatch(MieBatch {
                definition,
                threads: self.threads.map(usize::from),
                ..MieBatch::new(input.unwrap_or_default(), self.output.unwrap_or_default())
            }),
        }
    }
}

pub fn show(report: &MieReport, format: Format) -> Result<(), Failure> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    let sheet = &report.sheet;
    let angles = sheet.angle_table()?;
    match format {
        Format::Table => {
            write!(out, "{}", summary(sheet))?;
            if let Some(table) = angles {
                write!(out, "\n{}", table.without_title().to_text(5))?;
            }
            for file in &report.files {
                writeln!(out, "{}", file.display())?;
            }
        }
        Format::Csv => angles.map_or_else(|| sheet.table(), Ok)?.write_csv(&mut out)?,
        Format::Json => sheet.write_json(&mut out)?,
    }
    Ok(out.flush()?)
}

/// The particle and its numbers, each with its unit.
fn summary(sheet: &MieSheet) -> String {
    let (s, job) = (&sheet.scattering, &sheet.job);
    let mut text = format!("{}\n", sheet.title().replacen('s', "S", 1));
    if job.layers.len() > 1 {
        for layer in &job.layers {
            text += &format!("  layer to {}, n = {}\n", layer.radius, layer.index);
        }
    }
    text += &format!("{:<16}{:>14}{:>14}\n", "", "cross section", "efficiency");
    for (name, c) in [
        ("extinction", s.extinction),
        ("scattering", s.scattering),
        ("absorption", s.absorption),
        ("backscattering", sheet.backscattering),
    ] {
        text += &format!("{name:<16}{:>14}{:>14}\n", format_area(c), significant(sheet.efficiency(c), 5));
    }
    text += &format!("{:<16}{:>28}\n", "asymmetry g", significant(s.asymmetry, 5));
    let x = s.size_parameter;
    let complex = |re: f64, im: f64| format!("{}+{}i", significant(re, 5), significant(im, 3));
    let size = if x.im == 0.0 { significant(x.re, 5) } else { complex(x.re, x.im) };
    text += &format!("{:<16}{size:>28}\n", "size parameter");
    if x.im != 0.0 {
        text += &format!("The host absorbs; what scattering means is defined by {}.\n", job.definition.name());
    }
    text
}

pub fn show_batch(report: &MieBatchReport) -> Result<(), Failure> {
    let rate = report.rows as f64 / report.seconds;
    writeln!(
        io::stdout().lock(),
        "{} particles in {}, {} per second: {}",
        report.rows,
        format_duration(report.seconds),
        significant(rate, 3),
        report.output.display()
    )?;
    Ok(())
}
