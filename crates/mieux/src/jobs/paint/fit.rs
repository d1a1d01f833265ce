//! Paints from measurements.

use std::path::PathBuf;

use mieux_io::output::OutputDir;
use mieux_io::paint::{paints_to_toml, read_measurements, write_residuals};
use mieux_io::plot::{Figure, Panel, Scale, Series, swatch_figure};
use mieux_io::quantity::Length;
use mieux_optics::paint::{self, FitOptions, Leftover, Measurements, PaintError, PaintSet, Recipe, Surface};
use mieux_optics::spectrum::Lab;
use mieux_optics::spectrum::colour::xyz_to_linear_srgb;
use mieux_optics::transfer::kubelka_munk::{Chart, Saunderson};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::jobs::{Context, Event, JobError, Stage};

/// K and S of paints, from opaque samples of known recipes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaintFit {
    /// Files of measurements at the same wavelengths.
    pub measurements: Vec<PathBuf>,
    /// The paint whose S is the unit; the one that is mixed with most others when left out.
    #[serde(default)]
    pub reference: Option<String>,
    /// Refractive index of the binder, from 1.
    #[serde(default = "default_index")]
    pub index: f64,
    /// How much of the specular component the instrument counts, 0 to 1; fitted when left out.
    #[serde(default)]
    pub specular: Option<f64>,
    /// Thickness at which the reference by itself hides a black and white chart, which gives K and S their unit.
    #[serde(default)]
    pub reference_hides: Option<Length>,
    /// What is foretold rather than fitted.
    #[serde(default)]
    pub hold_out: HoldOut,
    /// Folder for paints, residuals and figures.
    #[serde(default)]
    pub output: Option<PathBuf>,
}

fn default_index() -> f64 {
    PaintFit::DEFAULT_INDEX
}

/// What is left out of a fit to be foretold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HoldOut {
    /// Nothing.
    #[default]
    None,
    /// Of mixtures that are measured several times, all measurements but the first.
    Repeats,
}

/// How well one sample is met.
#[derive(Debug, Clone, PartialEq)]
pub struct SampleFit {
    /// Colours and differences.
    pub leftover: Leftover,
    /// Whether it was held out.
    pub held_out: bool,
}

/// What [`PaintFit`] leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct PaintFitReport {
    /// The paints.
    pub paints: PaintSet,
    /// Every sample, in the order of the files.
    pub samples: Vec<SampleFit>,
    /// Standard error of the share of the specular component; 0 when it was given.
    pub specular_error: f64,
    /// Paints of which nothing but K/S is known.
    pub ratio_only: Vec<String>,
    /// The files written.
    pub files: Vec<PathBuf>,
}

impl PaintFitReport {
    /// Mean CIEDE2000 of the samples that were fitted, or held out; `None` without any.
    pub fn mean_ciede2000(&self, held_out: bool) -> Option<f64> {
        let of: Vec<f64> =
            self.samples.iter().filter(|s| s.held_out == held_out).map(|s| s.leftover.ciede2000).collect();
        (!of.is_empty()).then(|| of.iter().sum::<f64>() / of.len() as f64)
    }

    /// All but the paints themselves, which have a file of their own.
    pub fn json(&self) -> Value {
        let surface = self.paints.surface();
        let lab = |lab: Lab| json!([lab.l, lab.a, lab.b]);
        let sample = |s: &SampleFit| {
            json!({
                "name": s.leftover.name,
                "held_out": s.held_out,
                "lab_measured": lab(s.leftover.measured),
                "lab_predicted": lab(s.leftover.predicted),
                "ciede2000": s.leftover.ciede2000,
                "rms_reflectance": s.leftover.rms,
            })
        };
        json!({
            "reference": self.paints.reference(),
            "reference_scattering_per_m": self.paints.scattering(),
            "paints": self.paints.paints().iter().map(|paint| paint.name.clone()).collect::<Vec<_>>(),
            "surface": {"external": surface.external, "internal": surface.internal, "specular": surface.specular},
            "specular_error": self.specular_error,
            "ratio_only": self.ratio_only,
            "mean_ciede2000_fitted": self.mean_ciede2000(false),
            "mean_ciede2000_held_out": self.mean_ciede2000(true),
            "samples": self.samples.iter().map(sample).collect::<Vec<_>>(),
        })
    }
}

impl PaintFit {
    /// Of usual binders.
    pub const DEFAULT_INDEX: f64 = 1.5;

    /// From these files, and nothing written.
    pub fn new(measurements: Vec<PathBuf>) -> Self {
        Self {
            measurements,
            reference: None,
            index: Self::DEFAULT_INDEX,
            specular: None,
            reference_hides: None,
            hold_out: HoldOut::None,
            output: None,
        }
    }

    fn read(&self) -> Result<Measurements, JobError> {
        let mut all: Option<Measurements> = None;
        for path in &self.measurements {
            let more = read_measurements(path)?;
            all = Some(match all {
                Some(before) => before.and(more)?,
                None => more,
            });
        }
        Ok(all.ok_or(PaintError::NothingToFit { why: "no file of measurements was given" })?)
    }

    pub(in crate::jobs) fn run(&self, context: &Context<'_>) -> Result<PaintFitReport, JobError> {
        let dir = self.output.as_deref().map(OutputDir::create).transpose()?;
        let all = self.read()?;
        context.say(Event::Begin(Stage::Paints));
        let held: Vec<bool> = (0..all.samples().len()).map(|i| self.is_held(&all, i)).collect();
        let surface = Saunderson::directional(self.index, 1.0).map_err(PaintError::from)?;
        let surface = match self.specular {
            Some(specular) => Surface::Given(surface.with_specular(specular)),
            None => Surface::FitSpecular(surface),
        };
        let options = FitOptions { reference: self.reference.clone(), ..FitOptions::new(surface) };
        let found = paint::fit(&all.filtered(|i, _| !held[i]), &options)?;
        let leftovers = found.predict(&all)?;
        let paints = self.with_unit(found.paints)?;
        context.say(Event::End(Stage::Paints));
        if context.is_cancelled() {
            return Err(JobError::Cancelled);
        }
        let samples: Vec<SampleFit> =
            leftovers.into_iter().zip(held).map(|(leftover, held_out)| SampleFit { leftover, held_out }).collect();
        let mut files = Vec::new();
        if let Some(dir) = dir {
            context.say(Event::Begin(Stage::Write));
            let toml = paints_to_toml(&paints)?;
            let (figure, swatches) = (coefficients(&paints).to_svg()?, swatches(&paints, &samples).to_svg()?);
            files.push(dir.write("paints.toml", |out| out.write_all(toml.as_bytes()))?);
            let rows: Vec<(&Leftover, bool)> = samples.iter().map(|s| (&s.leftover, s.held_out)).collect();
            files.push(dir.write("residuals.csv", |out| write_residuals(out, &rows))?);
            files.push(dir.write("coefficients.svg", |out| out.write_all(figure.as_bytes()))?);
            files.push(dir.write("swatches.svg", |out| out.write_all(swatches.as_bytes()))?);
            dir.commit();
            context.say(Event::End(Stage::Write));
        }
        let (specular_error, ratio_only) = (found.specular_error, found.ratio_only);
        Ok(PaintFitReport { paints, samples, specular_error, ratio_only, files })
    }

    fn is_held(&self, all: &Measurements, index: usize) -> bool {
        let sample = &all.samples()[index];
        let again = || all.samples()[..index].iter().any(|other| other.recipe == sample.recipe);
        self.hold_out == HoldOut::Repeats && sample.recipe.parts().len() > 1 && again()
    }

    /// With the unit of K and S, where it is known how thick a film of the reference hides: thickness goes with 1/S.
    fn with_unit(&self, set: PaintSet) -> Result<PaintSet, JobError> {
        let Some(thickness) = self.reference_hides else { return Ok(set) };
        let recipe = Recipe::pure(set.reference());
        let set = set.with_scattering(1.0)?;
        let hides = set.hiding_thickness(&recipe, Chart::default(), Chart::COMPLETE)?;
        Ok(set.with_scattering(hides / thickness.metres())?)
    }
}

/// K and S of all paints over wavelength.
fn coefficients(set: &PaintSet) -> Figure {
    let nanometres: Vec<f64> = set.grid().iter().map(|w| w * 1e9).collect();
    let unit = format!("relative to S of {}", set.reference());
    let panel = |title: String, letter: &str| {
        Panel::new(title, "Wavelength in vacuum (nm)", format!("{letter}, {unit}"))
            .with_scales(Scale::Linear, Scale::Log)
    };
    let mut figure = Figure::new("Absorption K and scattering S of paints", 2);
    // More lines than that cannot be told apart.
    for (number, paints) in set.paints().chunks(5).enumerate() {
        let (mut k, mut s) =
            (panel(format!("Absorption ({})", number + 1), "K"), panel(format!("Scattering ({})", number + 1), "S"));
        for paint in paints {
            let points = |values: &[f64]| nanometres.iter().copied().zip(values.to_vec()).collect::<Vec<_>>();
            k = k.with_series(Series::new(&paint.name, points(&paint.k)));
            s = s.with_series(Series::new(&paint.name, points(&paint.s)));
        }
        figure = figure.with_panel(k).with_panel(s);
    }
    figure
}

/// Every sample as measured and, beside it, as the fit has it; of repeats the first.
fn swatches(set: &PaintSet, samples: &[SampleFit]) -> Figure {
    let white = set.daylight().white();
    let mut patches: Vec<(String, [f64; 3])> = Vec::new();
    for (i, SampleFit { leftover, .. }) in samples.iter().enumerate() {
        if samples[..i].iter().any(|other| other.leftover.name == leftover.name) {
            continue;
        }
        let rgb = |lab: Lab| xyz_to_linear_srgb(lab.to_xyz(white));
        // Recipes may be broken into lines.
        patches.push((leftover.name.replace('+', " + "), rgb(leftover.measured)));
        patches.push((format!("as fitted, ΔE {:.2}", leftover.ciede2000), rgb(leftover.predicted)));
    }
    swatch_figure("Samples as measured, and as fitted (D65, CIEDE2000)", &patches)
}
