//! `mieux export`: what can be typed, and what is printed.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use mieux::io::export::{Errors, Format as Target, Kept};
use mieux::io::quantity::{Length, significant};
use mieux::io::recipe::parse_setting;
use mieux::jobs::{Export, ExportReport};

use crate::args::Format;
use crate::failure::Failure;

const EXAMPLES: &str = "\
Examples:
  mieux export whole-milk --to mitsuba -o out/milk
  mieux export whole-milk --to pbrt --set fat=1.5 --scale 0.01
  mieux export examples/emulsion.toml --to cycles --isotropic
  mieux export skim-milk --to eradiate --wavelengths 400nm:700nm:10nm

Every file says in its first lines which units it is in and how far it is from the spectra; docs/export.md says what
each format can hold.

JSON keys: material, format, files, metres_per_unit, form (words), wavelength_nm, sigma_s_per_m, sigma_a_per_m, g and n
(what is known), held_sigma_s_per_m, held_sigma_a_per_m and held_g (what a reader of the files gets back; null where no
channel of colour sees the wavelength), relative_error_of_reduced_scattering, relative_error_of_sigma_s,
relative_error_of_sigma_a and error_of_g (each with largest and rms over the wavelengths), wavelengths_in_no_channel,
phase_function (form, total_variation, relative_error_of_one_minus_g), remarks.";

/// Write a material for another renderer, and say what that renderer's format has lost of it
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct ExportArgs {
    /// A material (see `mieux materials`), or the path of a recipe such as `my.toml`
    material: String,
    /// For whom
    #[arg(long, value_enum, value_name = "FORMAT")]
    to: To,
    /// Set an input of the material, as in `fat=1.5`; may be given several times
    #[arg(long, value_name = "NAME=NUMBER")]
    set: Vec<String>,
    /// Wavelengths in vacuum, as in `400nm:700nm:25nm` or `450nm,550nm` [default: 375nm:775nm:25nm]
    #[arg(long, value_name = "WAVELENGTHS")]
    wavelengths: Option<String>,
    /// Length of a scene unit in metres
    #[arg(long, value_name = "METRES", default_value_t = 1.0, allow_hyphen_values = true)]
    scale: f64,
    /// What stays right where the format has one asymmetry for all wavelengths
    #[arg(long, value_enum, default_value = "reduced")]
    keep: Keep,
    /// Write reduced scattering and an isotropic phase function: far fewer scatterings, right deep inside
    #[arg(long)]
    isotropic: bool,
    /// Where a single phase function is taken: the wavelength nearest to this [default: 550nm]
    #[arg(long, value_name = "WAVELENGTH", value_parser = Length::parse_positive)]
    phase_at: Option<Length>,
    /// Write a format that is a draft (gltf)
    #[arg(long)]
    draft: bool,
    /// Relative tolerance of the integral over particle sizes and of phase functions
    #[arg(long, default_value_t = Export::DEFAULT_TOLERANCE, allow_hyphen_values = true)]
    tolerance: f64,
    /// How to print the result
    #[arg(long, value_enum, default_value = "table")]
    pub format: Format,
    /// Folder for the files [default: out/NAME-FORMAT]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

/// The formats.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "lower")]
enum To {
    /// Mitsuba 3: spectra, a table or two lobes
    Mitsuba,
    /// pbrt-v4: spectra, one g
    Pbrt,
    /// Cycles in Blender: a Python script
    Cycles,
    /// MaterialX: anisotropic_vdf
    MaterialX,
    /// OpenPBR in MaterialX: open_pbr_surface
    OpenPbr,
    /// glTF with drafts of volume scattering (with --draft)
    Gltf,
    /// OpenUSD with a MaterialX network
    Usd,
    /// NVIDIA's Material Definition Language
    Mdl,
    /// Eradiate: NetCDF with every phase function
    Eradiate,
}

impl From<To> for Target {
    fn from(to: To) -> Self {
        match to {
            To::Mitsuba => Self::Mitsuba,
            To::Pbrt => Self::Pbrt,
            To::Cycles => Self::Cycles,
            To::MaterialX => Self::MaterialX,
            To::OpenPbr => Self::OpenPbr,
            To::Gltf => Self::Gltf,
            To::Usd => Self::Usd,
            To::Mdl => Self::Mdl,
            To::Eradiate => Self::Eradiate,
        }
    }
}

/// What may stay right.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Keep {
    /// Reduced scattering sigma_s (1 - g), which dense bodies show
    Reduced,
    /// sigma_s, which decides what passes thin bodies unscattered
    Scattering,
}

impl ExportArgs {
    pub fn job(self) -> Result<Export, Failure> {
        let plain = Export::new(self.material, self.to.into());
        Ok(Export {
            set: self.set.iter().map(|s| parse_setting(s)).collect::<Result<_, _>>()?,
            wavelengths: self.wavelengths,
            metres_per_unit: self.scale,
            keep: match self.keep {
                Keep::Reduced => Kept::Reduced,
                Keep::Scattering => Kept::Scattering,
            },
            isotropic: self.isotropic,
            phase_at: self.phase_at.unwrap_or(plain.phase_at),
            draft: self.draft,
            tolerance: self.tolerance,
            output: self.output,
            ..plain
        })
    }
}

pub fn show(report: &ExportReport, format: Format) -> Result<(), Failure> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    match format {
        Format::Table => write!(out, "{}", summary(report))?,
        Format::Csv => report.sheet.table()?.write_csv(&mut out)?,
        Format::Json => writeln!(out, "{:#}", report.sheet.json(&report.files))?,
    }
    Ok(out.flush()?)
}

/// What was written and what was lost.
fn summary(report: &ExportReport) -> String {
    let (subject, written) = (&report.sheet.subject, &report.sheet.written);
    let mut text = format!("{} for {}\n", subject.title, report.sheet.format.name());
    text += &format!("{}\n\n", written.form);
    text += &format!("{:<12}{:>16}{:>14}\n", "", "largest error", "rms error");
    let percent = |name: &str, e: Errors| {
        let value = |v: f64| format!("{} %", significant(100.0 * v, 2));
        format!("{name:<12}{:>16}{:>14}\n", value(e.largest), value(e.rms))
    };
    text += &percent("sigma_s'", written.loss.reduced);
    text += &percent("sigma_s", written.loss.sigma_s);
    text += &percent("sigma_a", written.loss.sigma_a);
    let g = written.loss.asymmetry;
    text += &format!("{:<12}{:>16}{:>14}\n\n", "g", significant(g.largest, 2), significant(g.rms, 2));
    text += &format!("{}\n", written.phase.line());
    for remark in &written.remarks {
        text += &format!("{remark}\n");
    }
    if written.loss.unseen > 0 {
        text += &format!("{} of the wavelengths are in no channel and count nowhere\n", written.loss.unseen);
    }
    for file in &report.files {
        text += &format!("{}\n", file.display());
    }
    text
}
