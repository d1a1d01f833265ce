//! `mieux invert`: what can be typed, and what is printed.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use mieux::io::quantity::Length;
use mieux::jobs::{Invert, InvertReport, InvertSheet, Slabs};

use crate::args::Format;
use crate::failure::Failure;

const EXAMPLES: &str = "\
Examples:
  mieux invert liver.rxt --g 0.9 -o out/liver
  mieux invert liver.rxt --format csv
  mieux invert --reflectance 0.4 --transmittance 0.1 --unscattered 0.002 --thickness 1mm
  mieux invert --reflectance 0.4 --index 1.4

Light falls along the normal onto a sample that may lie between two slides. The reflectance is all
that comes back, the surface's own reflection included; the transmittance is all that passes,
unscattered light included. From the reflectance alone follows the ratio of absorption and
scattering of a sample that is thick enough; from both follow absorption and scattering, with
g taken for granted; with the unscattered transmittance g follows too.

FILE is an .rxt file of the inverse adding-doubling program: `IAD1`, seventeen numbers about
sample, beam and spheres, the number of measurements in a row or a letter for each column
(L r t u d n N g b c C), and the rows. Nothing is corrected for integrating spheres.

Where no slab has the shares that were measured, the nearest is given, flagged, and why.

With -o, DIR holds inversion.csv, inversion.json and the plot inversion.svg.

JSON keys: measurements, wavelength_nm (or row), mu_a_per_mm, mu_s_reduced_per_mm, mu_s_per_mm, g and
for each the same with _error (standard error; mu_a_error_per_mm), albedo, optical_thickness,
residual, flag (0: solved, 1: the nearest, 2: nothing), remarks, reflectance, transmittance,
transmittance_unscattered; arrays of one length.";

/// What measured slabs are made of.
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct InvertArgs {
    /// A file of measurements
    #[arg(required_unless_present = "one", conflicts_with = "one")]
    file: Option<PathBuf>,
    #[command(flatten)]
    one: One,
    /// Refractive index of the sample [default: that of FILE, or 1]
    #[arg(long, value_name = "INDEX", allow_hyphen_values = true)]
    index: Option<f64>,
    /// Refractive index of slides above and below [default: that of FILE, or none]
    #[arg(long, value_name = "INDEX", allow_hyphen_values = true)]
    slides: Option<f64>,
    /// Thickness of the sample, as in `1mm` [default: that of FILE, or 1mm]
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, value_parser = Length::parse_positive)]
    thickness: Option<Length>,
    /// Asymmetry that is taken for granted where it cannot be found [default: that of FILE, or 0]
    #[arg(long, allow_hyphen_values = true)]
    g: Option<f64>,
    /// Optical thickness that is taken for granted where it cannot be found
    #[arg(long, value_name = "TAU", allow_hyphen_values = true)]
    tau: Option<f64>,
    /// Standard error of reflectance and transmittance, as shares
    #[arg(long, default_value_t = Invert::DEFAULT_ERROR, allow_hyphen_values = true)]
    error: f64,
    /// Standard error of the unscattered transmittance, as a part of it
    #[arg(long, value_name = "PART", default_value_t = Invert::DEFAULT_UNSCATTERED_ERROR, allow_hyphen_values = true)]
    unscattered_error: f64,
    /// Streams of light that are followed: even, 2 to 256
    #[arg(long, default_value_t = Invert::DEFAULT_STREAMS)]
    streams: usize,
    /// Take measurements with integrating spheres for those of the sample
    #[arg(long)]
    corrected: bool,
    /// How to print the result
    #[arg(long, value_enum, default_value = "table")]
    pub format: Format,
    /// Folder for table and plot
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

/// One slab.
#[derive(Args)]
#[group(id = "one", multiple = true)]
struct One {
    /// Total reflectance, 0 to 1
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true)]
    reflectance: Option<f64>,
    /// Total transmittance, 0 to 1
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true)]
    transmittance: Option<f64>,
    /// Unscattered transmittance, 0 to 1
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true)]
    unscattered: Option<f64>,
}

impl InvertArgs {
    pub fn job(self) -> Invert {
        let One { reflectance, transmittance, unscattered } = self.one;
        let measured = match self.file {
            Some(file) => Slabs::File(file),
            None => Slabs::One { reflectance, transmittance, unscattered },
        };
        Invert {
            refractive_index: self.index,
            slide_index: self.slides,
            asymmetry: self.g,
            thickness: self.thickness,
            optical_thickness: self.tau,
            error: self.error,
            unscattered_error: self.unscattered_error,
            streams: self.streams,
            corrected: self.corrected,
            output: self.output,
            ..Invert::new(measured)
        }
    }
}

pub fn show(report: &InvertReport, format: Format) -> Result<(), Failure> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    let sheet = &report.sheet;
    match format {
        Format::Table => {
            let table = sheet.table()?;
            write!(out, "{}", table.to_text(4))?;
            for (key, value) in table.metadata().iter().filter(|(key, _)| key != "flag" && key != "source") {
                writeln!(out, "{key}: {value}")?;
            }
            write!(out, "{}", remarks(sheet))?;
            for file in &report.files {
                writeln!(out, "{}", file.display())?;
            }
        }
        Format::Csv => sheet.table()?.write_csv(&mut out)?,
        Format::Json => writeln!(out, "{:#}", sheet.json())?,
    }
    Ok(out.flush()?)
}

/// Why rows are flagged.
fn remarks(sheet: &InvertSheet) -> String {
    let mut text = String::new();
    for (i, slab) in sheet.rows.iter().enumerate() {
        if let Some(remark) = slab.remark() {
            let place = match slab.row.line {
                0 => "this slab".to_owned(),
                line => format!("row {} (line {line})", i + 1),
            };
            text += &format!("{place}: {remark}\n");
        }
    }
    text
}
