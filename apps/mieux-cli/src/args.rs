//! What can be typed.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum};
use mieux::io::quantity::{Size, parse_duration, parse_fraction};
use mieux::io::recipe::{RecipeError, parse_setting};
use mieux::jobs::{Approximation, Compare, Optics, Render, Stop};

use crate::diff::DiffArgs;
use crate::export::ExportArgs;
use crate::invert::InvertArgs;
use crate::mie::MieArgs;
use crate::paint::PaintCommand;
use crate::phase::PhaseArgs;
use crate::sizes::SizesArgs;
use crate::slab::SlabArgs;
use crate::substances::SubstancesArgs;

/// What a material looks like, from what it is made of.
#[derive(Parser)]
#[command(name = "mieux", version, about, arg_required_else_help = true)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Subcommand)]
pub enum Command {
    /// List the materials that are known, or show one with its inputs, ranges and defaults
    Materials(MaterialsArgs),
    /// List the substances that are known, or show the refractive index of one over wavelength
    Substances(SubstancesArgs),
    /// List the scenes that are known
    Scenes,
    /// Compute the optical properties of a material over wavelength
    Optics(OpticsArgs),
    /// Put two materials, or a material and measurements, side by side
    Compare(CompareArgs),
    /// Render a picture of a material in a glass, or of a scene
    Render(RenderArgs),
    /// Put the parts of a picture together that were rendered with `--shard`: the same bits as one run
    Merge(MergeArgs),
    /// Tell whether two rendered pictures differ by more than their noise
    ///
    /// The exit code is 0 when they agree, 3 when they differ, 4 when they are more alike than independent pictures can be, and
    /// 1 or 2 when they cannot be compared.
    Diff(DiffArgs),
    /// Compute what one particle does to light, or a table of them
    ///
    /// Cross sections, efficiencies and asymmetry, and with `--angles` amplitudes and Mueller matrix, of a sphere, or with
    /// `--layer` a sphere with layers around it, in any host (Lorenz-Mie theory).
    Mie(MieArgs),
    /// Show a size distribution in every weighting: means, medians, effective radius
    Sizes(SizesArgs),
    /// Compute how scattered light spreads over angle, and compare phase functions
    Phase(PhaseArgs),
    /// Compute how much light comes back from a slab or layers, passes, and stays
    ///
    /// Of a material, wavelength by wavelength, or of an abstract medium: reflectance, transmittance, absorptance, and the
    /// colours they make.
    Slab(Box<SlabArgs>),
    /// Fit paints to measurements, mix them, and find recipes for colours
    #[command(subcommand)]
    Paint(PaintCommand),
    /// Find absorption, scattering and asymmetry from measured reflectance and transmittance
    Invert(InvertArgs),
    /// Write a material for another renderer, and say what that renderer's format has lost of it
    Export(ExportArgs),
    /// Print a completion script for a shell
    Completions {
        /// Shell to complete for
        shell: clap_complete::Shell,
    },
}

/// How results are printed.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// A table to read
    Table,
    /// Comma-separated values, all digits
    Csv,
    /// JSON, arrays of one length
    Json,
}

#[derive(Args)]
pub struct MaterialsArgs {
    /// A material, or the path of a recipe, to be shown with its inputs and what it is made of
    pub material: Option<String>,
    /// Print the recipe itself, to begin one of your own with: `mieux materials fog --recipe > my.toml`
    #[arg(long, requires = "material")]
    pub recipe: bool,
}

#[derive(Args)]
pub struct OpticsArgs {
    /// A material (see `mieux materials`), or the path of a recipe such as `my.toml`
    pub material: String,
    /// Set an input of the material, as in `fat=1.5`; may be given several times
    #[arg(long, value_name = "NAME=NUMBER")]
    pub set: Vec<String>,
    /// Wavelengths in vacuum, as in `400nm:700nm:25nm` or `450nm,550nm` [default: 375nm:775nm:25nm]
    #[arg(long, value_name = "WAVELENGTHS")]
    pub wavelengths: Option<String>,
    /// How to print the result
    #[arg(long, value_enum, default_value = "table")]
    pub format: Format,
    /// Relative tolerance of the integral over particle sizes
    #[arg(long, default_value = "1e-4")]
    pub tolerance: f64,
    /// Also write tables (csv, json, parquet, nc), plots, phase functions and colours of layers to this folder
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

impl OpticsArgs {
    pub fn job(self) -> Result<Optics, RecipeError> {
        Ok(Optics {
            set: self.set.iter().map(|s| parse_setting(s)).collect::<Result<_, _>>()?,
            wavelengths: self.wavelengths,
            tolerance: self.tolerance,
            output: self.output,
            ..Optics::new(self.material)
        })
    }
}

#[derive(Args)]
pub struct CompareArgs {
    /// A material (see `mieux materials`), or the path of a recipe
    pub material: String,
    /// Another
    #[arg(required_unless_present = "measured")]
    pub other: Option<String>,
    /// Set an input of the first material, as in `fat=1.5`; may be given several times
    #[arg(long, value_name = "NAME=NUMBER")]
    pub set: Vec<String>,
    /// Set an input of the other material
    #[arg(long, value_name = "NAME=NUMBER", requires = "other")]
    pub set_other: Vec<String>,
    /// Measurements: a CSV file with `wavelength_nm` and any of `sigma_s_per_m`, `reduced_scattering_per_mm`,
    /// `sigma_a_per_cm`, `g`, ...
    #[arg(long, value_name = "FILE")]
    pub measured: Option<PathBuf>,
    /// Wavelengths in vacuum [default: those of the measurements, or 375nm:775nm:25nm]
    #[arg(long, value_name = "WAVELENGTHS")]
    pub wavelengths: Option<String>,
    /// How to print the result
    #[arg(long, value_enum, default_value = "table")]
    pub format: Format,
    /// Relative tolerance of the integral over particle sizes
    #[arg(long, default_value = "1e-4")]
    pub tolerance: f64,
    /// Also write compare.csv, compare.json and compare.svg to this folder
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

impl CompareArgs {
    pub fn job(self) -> Result<Compare, RecipeError> {
        Ok(Compare {
            other: self.other,
            set: self.set.iter().map(|s| parse_setting(s)).collect::<Result<_, _>>()?,
            set_other: self.set_other.iter().map(|s| parse_setting(s)).collect::<Result<_, _>>()?,
            measured: self.measured,
            wavelengths: self.wavelengths,
            tolerance: self.tolerance,
            output: self.output,
            ..Compare::new(self.material)
        })
    }
}

#[derive(Args)]
pub struct RenderArgs {
    /// A material or scene (see `mieux materials` and `mieux scenes`), or the path of a recipe or scene file
    pub subject: String,
    /// Set an input of the material, as in `fat=1.5`; may be given several times
    #[arg(long, value_name = "NAME=NUMBER")]
    pub set: Vec<String>,
    /// Size of the picture in pixels, as in `640x480` [default: the scene's own]
    #[arg(long, value_name = "WIDTHxHEIGHT")]
    pub size: Option<Size>,
    #[command(flatten)]
    pub stop: StopArgs,
    /// The same seed gives the same picture, to the bit
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// How many threads to use [default: one per core]; does not change the picture
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Scatter isotropically after ten mean free paths: faster, slightly wrong (see docs/similarity.md)
    #[arg(long)]
    pub similarity: bool,
    /// Let light diffuse through dense bodies instead of following it: fast and approximate (see docs/diffusion.md)
    #[arg(long, value_enum, value_name = "HOW")]
    pub approximate: Option<Approximate>,
    /// Let rays bend by each wavelength's own refractive index: rainbows, and more noise in colour
    #[arg(long)]
    pub dispersion: bool,
    /// Write radiance in bins of wavelength to the EXR as well [16 unless said otherwise]
    #[arg(long, value_name = "BINS", num_args = 0..=1, default_missing_value = "16", require_equals = true,
        value_parser = clap::value_parser!(u16).range(1..=40))]
    pub spectral: Option<u16>,
    /// Reconstruction filter: how rays are spread around pixels [default: box]
    #[arg(long, value_parser = ["box", "tent", "gaussian", "mitchell", "blackman-harris"])]
    pub filter: Option<String>,
    /// Render a window of the picture, in pixels from its top left corner: the same bits as in the whole
    #[arg(long, value_name = "X,Y,W,H", value_parser = crop)]
    pub crop: Option<[u32; 4]>,
    /// Render part k of n, with `--spp`; `mieux merge` puts the parts together
    #[arg(long, value_name = "K/N", value_parser = shard)]
    pub shard: Option<(u32, u32)>,
    /// Tone curve of the PNG [default: srgb]
    #[arg(long, value_parser = ["srgb", "filmic", "reinhard"])]
    pub tone: Option<String>,
    /// Exposure of the PNG in stops: 1 doubles the light, -1 halves it
    #[arg(long, value_name = "EV", default_value_t = 0.0, allow_negative_numbers = true)]
    pub exposure: f64,
    /// Show the picture in the viewer tev while it is made, and refresh the PNG every second
    #[arg(long, value_name = "HOST:PORT", num_args = 0..=1, require_equals = true,
        default_missing_value = mieux::io::tev::DEFAULT_ADDRESS)]
    pub preview: Option<String>,
    /// Time between checkpoints [default: 30s]
    #[arg(long, value_name = "TIME", value_parser = |s: &str| parse_duration(s))]
    pub checkpoint: Option<f64>,
    /// Go on with the render that was interrupted in the same folder
    #[arg(long)]
    pub resume: bool,
    /// Folder for the results [default: out/NAME]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// Numbers with separators in between.
fn numbers<const N: usize>(text: &str, separator: char) -> Option<[u32; N]> {
    let parts: Vec<u32> = text.split(separator).map(|n| n.trim().parse().ok()).collect::<Option<_>>()?;
    parts.try_into().ok()
}

fn crop(text: &str) -> Result<[u32; 4], String> {
    numbers(text, ',').ok_or_else(|| format!("`{text}` is not a window: left,top,width,height, as in `100,50,64,64`"))
}

fn shard(text: &str) -> Result<(u32, u32), String> {
    let form = || format!("`{text}` is not a part: k/n with k from 1 to n, as in `2/4`");
    let [k, n] = numbers(text, '/').ok_or_else(form)?;
    if k >= 1 && k <= n { Ok((k, n)) } else { Err(form()) }
}

#[derive(Args)]
pub struct MergeArgs {
    /// The folders in which the parts were rendered, in any order
    #[arg(required = true)]
    pub parts: Vec<PathBuf>,
    /// Folder for the results
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
}

/// What may stand in for the walk of light through dense bodies.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Approximate {
    /// A diffusion profile around where light enters
    Diffusion,
}

/// When a picture is done; at most one of these.
#[derive(Args)]
#[group(multiple = false)]
pub struct StopArgs {
    /// Stop at this many samples per pixel
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1 << 40))]
    pub spp: Option<u64>,
    /// Stop after this time, as in `60s` or `5min`
    #[arg(long, value_name = "TIME", value_parser = |s: &str| parse_duration(s))]
    pub time: Option<f64>,
    /// Stop when the mean relative error per pixel is down to this in every tile of 16 x 16 pixels, as in `2%` [default: 5%]
    #[arg(long, value_name = "NOISE", value_parser = |s: &str| parse_fraction(s))]
    pub noise: Option<f64>,
}

impl StopArgs {
    fn stop(&self) -> Stop {
        match (self.spp, self.time, self.noise) {
            (Some(samples), _, _) => Stop::Samples(samples),
            (_, Some(seconds), _) => Stop::Seconds(seconds),
            (_, _, Some(noise)) => Stop::Noise(noise),
            _ => Stop::default(),
        }
    }
}

impl RenderArgs {
    pub fn job(self) -> Result<Render, RecipeError> {
        Ok(Render {
            set: self.set.iter().map(|s| parse_setting(s)).collect::<Result<_, _>>()?,
            size: self.size,
            stop: self.stop.stop(),
            seed: self.seed,
            threads: self.threads.map(usize::from),
            similarity: self.similarity,
            approximate: self.approximate.map(|Approximate::Diffusion| Approximation::Diffusion),
            dispersion: self.dispersion,
            filter: self.filter.filter(|f| f != "box"),
            crop: self.crop,
            spectral_bins: self.spectral.map_or(0, usize::from),
            shard: self.shard,
            tone: self.tone,
            exposure: self.exposure,
            preview: self.preview,
            checkpoint_seconds: self.checkpoint,
            resume: self.resume,
            output: self.output,
            ..Render::new(self.subject)
        })
    }

    /// What to type to go on after an interruption.
    pub fn resume_command(&self) -> String {
        let mut words: Vec<String> = std::env::args().skip(1).map(|word| quoted(&word)).collect();
        if !self.resume {
            words.push("--resume".into());
        }
        format!("mieux {}", words.join(" "))
    }
}

/// A word as a shell takes it back.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,%+@".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}
