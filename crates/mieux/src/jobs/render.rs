//! The job behind `mieux render`.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use mieux_io::checkpoint::{read_checkpoint, write_checkpoint};
use mieux_io::image::{Film as ExrFilm, write_exr, write_png_srgb8};
use mieux_io::output::OutputDir;
use mieux_io::quantity::{Size, format_length};
use mieux_io::recipe::{Material, Recipe};
use mieux_io::scene::{SceneFile, Subject};
use mieux_optics::medium::{DEFAULT_TOLERANCE, Medium as OpticsMedium};
use mieux_optics::spectrum::{Sampled, SpectrumError, WavelengthGrid};
use mieux_optics::substance::Substance;
use mieux_render::film::Film;
use mieux_render::integrator::{Statistics, Transport};
use mieux_render::medium::Medium;
use mieux_render::render::{Flow, Outcome, Progress, RenderSettings, Rendered, StopRule, render};
use mieux_render::scene::{GlassScene, Scene, glasses};
use serde::{Deserialize, Serialize};

use super::{Context, Event, JobError, OpticsSheet, Stage, wavelengths};

/// The file that an interrupted render goes on from.
const CHECKPOINT: &str = "render.checkpoint";

/// A picture of a material in a glass, or of a scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Render {
    /// A built-in material or scene, or the path of a recipe or scene.
    pub subject: String,
    /// Inputs that differ from the recipe's; in a scene, of every material that has them.
    #[serde(default)]
    pub set: BTreeMap<String, f64>,
    /// Size of the picture; the scene's own when left out.
    #[serde(default)]
    pub size: Option<Size>,
    /// When it is done.
    #[serde(default)]
    pub stop: Stop,
    /// The same seed gives the same bits.
    #[serde(default)]
    pub seed: u64,
    /// Threads; all cores when left out. Does not change the picture.
    #[serde(default)]
    pub threads: Option<usize>,
    /// Isotropic scattering after ten mean free paths (frisvad2007 section 3): faster and slightly wrong.
    #[serde(default)]
    pub similarity: bool,
    /// How light gets through dense turbid bodies, if not by a walk: fast and approximate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub approximate: Option<Approximation>,
    /// Rays bend by each wavelength's own index.
    #[serde(default)]
    pub dispersion: bool,
    /// Go on with the render that was interrupted in the same folder.
    #[serde(default)]
    pub resume: bool,
    /// Folder for the results; `out/NAME` when left out.
    #[serde(default)]
    pub output: Option<PathBuf>,
}

/// What may stand in for the walk of light through dense turbid bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Approximation {
    /// A diffusion profile around where light enters (docs/diffusion.md).
    Diffusion,
}

/// When a render is done.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stop {
    /// At this many samples per pixel.
    Samples(u64),
    /// After this many seconds of rendering.
    Seconds(f64),
    /// When the mean relative standard error per pixel is down to this.
    Noise(f64),
}

impl Default for Stop {
    /// A mean relative error of 5 %.
    fn default() -> Self {
        Self::Noise(0.05)
    }
}

impl Stop {
    fn check(self) -> Result<Self, JobError> {
        let error = |name, value: String, allowed| Err(JobError::Value { name, value, allowed });
        match self {
            Self::Samples(0) => error("spp", "0".into(), "a picture needs at least one sample per pixel"),
            Self::Seconds(s) if !(s > 0.0 && s.is_finite()) => {
                error("time", format!("{s} s"), "a picture needs a time above zero")
            }
            Self::Noise(n) if !(n > 0.0 && n.is_finite()) => {
                error("noise", n.to_string(), "the noise to reach must be above zero")
            }
            stop => Ok(stop),
        }
    }
}

/// What [`Render`] leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct RenderReport {
    /// What is shown.
    pub title: String,
    /// The materials in it, from left to right.
    pub sheets: Vec<OpticsSheet>,
    /// Whether it was stopped before its end; it can be taken up again.
    pub interrupted: bool,
    /// What stood in for the walk of light.
    pub approximate: Option<Approximation>,
    /// What was assumed of materials that are not known at all wavelengths of a picture.
    pub notes: Vec<String>,
    /// Least and most samples per pixel.
    pub samples: (u64, u64),
    /// Mean relative standard error per pixel.
    pub noise: f64,
    /// Seconds spent following light in this run.
    pub seconds: f64,
    /// What happened on the way in this run.
    pub statistics: Statistics,
    /// Where the results are.
    pub folder: PathBuf,
    /// The files written.
    pub files: Vec<PathBuf>,
}

impl Render {
    /// A picture with everything left to its default.
    pub fn new(subject: impl Into<String>) -> Self {
        Self {
            subject: subject.into(),
            set: BTreeMap::new(),
            size: None,
            stop: Stop::default(),
            seed: 0,
            threads: None,
            similarity: false,
            approximate: None,
            dispersion: false,
            resume: false,
            output: None,
        }
    }

    pub(super) fn run(&self, context: &Context<'_>) -> Result<RenderReport, JobError> {
        let stop = self.stop.check()?;
        let (name, scene_file, materials) = self.materials()?;
        let size = self.size.unwrap_or(scene_file.size);
        let mut sheets = Vec::with_capacity(materials.len());
        for material in materials {
            let grid = wavelengths::usual([&material.medium]);
            sheets.push(OpticsSheet::compute(material, &grid, DEFAULT_TOLERANCE, context)?);
        }
        let (scene, notes) = (build(&sheets, size)?, notes(&sheets));

        let folder = self.output.clone().unwrap_or_else(|| PathBuf::from("out").join(&name));
        let dir = OutputDir::create(&folder)?;
        let identity = self.identity(size);
        let film = if self.resume { Some(read_checkpoint(&dir.file(CHECKPOINT)?, &identity)?) } else { None };

        let start = Instant::now();
        let rendered = self.expose(&scene, stop, film, start, context)?;
        let seconds = start.elapsed().as_secs_f64();
        let interrupted = rendered.outcome == Outcome::Stopped && context.is_cancelled();
        if rendered.film.samples().1 == 0 {
            return Err(JobError::Cancelled);
        }

        context.say(Event::Begin(Stage::Write));
        let mut files = self.write_pictures(&dir, &rendered.film, &scene_file.title)?;
        for sheet in &sheets {
            let stem = if sheets.len() == 1 { "optics".into() } else { format!("optics-{}", sheet.material.name) };
            files.extend(sheet.write(&dir, &stem)?);
        }
        let checkpoint = dir.file(CHECKPOINT)?;
        if interrupted {
            write_checkpoint(&checkpoint, &identity, &rendered.film)?;
        } else {
            // What is finished needs no checkpoint; that there was none is no error.
            let _ = std::fs::remove_file(&checkpoint);
        }
        dir.commit();
        context.say(Event::End(Stage::Write));
        Ok(RenderReport {
            title: scene_file.title,
            sheets,
            interrupted,
            approximate: self.approximate,
            notes,
            samples: rendered.film.samples(),
            noise: rendered.noise,
            seconds,
            statistics: rendered.statistics,
            folder,
            files,
        })
    }

    /// Name of what is rendered, the scene it stands in, and the materials from left to right.
    fn materials(&self) -> Result<(String, SceneFile, Vec<Material>), JobError> {
        match Subject::find(&self.subject)? {
            Subject::Material(recipe) => {
                let material = recipe.material(&self.set)?;
                let glass = SceneFile::glass()?;
                Ok((material.name.clone(), SceneFile { title: recipe.title().into(), ..glass }, vec![material]))
            }
            Subject::Scene(name, scene) => {
                let materials = self.materials_of(&name, &scene)?;
                Ok((name, scene, materials))
            }
        }
    }

    fn materials_of(&self, name: &str, scene: &SceneFile) -> Result<Vec<Material>, JobError> {
        let mut recipes = Vec::with_capacity(scene.glasses.len());
        for glass in &scene.glasses {
            let glass = glass.as_ref().ok_or_else(|| JobError::NoMaterial { scene: name.into() })?;
            recipes.push(Recipe::find(glass)?);
        }
        let has = |recipe: &Recipe, input: &str| recipe.inputs().iter().any(|(i, _)| i.name == input);
        if let Some(input) = self.set.keys().find(|input| !recipes.iter().any(|r| has(r, input))) {
            return Err(JobError::NoSuchInput { scene: name.into(), input: input.clone() });
        }
        let settings = |recipe: &Recipe| self.set.clone().into_iter().filter(|(k, _)| has(recipe, k)).collect();
        recipes.iter().map(|recipe| Ok(recipe.material(&settings(recipe))?)).collect()
    }

    /// What a checkpoint must agree with: all that decides the value of a sample.
    fn identity(&self, size: Size) -> String {
        let relevant = Self { size: Some(size), ..Self::new(self.subject.clone()) };
        let relevant = Self {
            set: self.set.clone(),
            seed: self.seed,
            similarity: self.similarity,
            approximate: self.approximate,
            dispersion: self.dispersion,
            ..relevant
        };
        let job = serde_json::to_string(&relevant).unwrap_or_default();
        format!("mieux {} {job}", env!("CARGO_PKG_VERSION"))
    }

    fn expose(
        &self,
        scene: &Scene,
        stop: Stop,
        film: Option<Film>,
        start: Instant,
        context: &Context<'_>,
    ) -> Result<Rendered, JobError> {
        let (rule, limit) = match stop {
            Stop::Samples(n) => (StopRule::Samples(n), None),
            Stop::Noise(n) => (StopRule::Noise(n), None),
            Stop::Seconds(s) => (StopRule::Never, Some(Duration::from_secs_f64(s.min(1e9)))),
        };
        let transport = Transport {
            dispersion: self.dispersion,
            similarity: self.similarity,
            diffusion: self.approximate == Some(Approximation::Diffusion),
            ..Transport::default()
        };
        let settings = RenderSettings { seed: self.seed, stop: rule, transport };
        let sink = |progress: &Progress| {
            context.say(Event::Progress {
                stage: Stage::Render,
                done: progress.samples,
                total: progress.end,
                samples_per_pixel: Some(progress.pass_samples),
                noise: progress.noise,
            });
            let late = limit.is_some_and(|limit| start.elapsed() >= limit);
            if late || context.is_cancelled() { Flow::Stop } else { Flow::Continue }
        };
        context.say(Event::Begin(Stage::Render));
        let threads = self.threads.unwrap_or(0);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|e| JobError::Threads { threads, reason: e.to_string() })?;
        let rendered = pool.install(|| render(scene, &settings, film, &sink))?;
        context.say(Event::End(Stage::Render));
        Ok(rendered)
    }

    fn write_pictures(&self, dir: &OutputDir, film: &Film, title: &str) -> Result<Vec<PathBuf>, JobError> {
        let [width, height] = film.resolution();
        let rgb: Vec<f64> = film.pixels().iter().flat_map(|p| p.mean()).collect();
        let variance: Vec<f64> = film.pixels().iter().flat_map(|p| p.variance_of_mean()).collect();
        let samples: Vec<f64> = film.pixels().iter().map(|p| p.samples as f64).collect();
        let (png, exr) = (dir.file("picture.png")?, dir.file("picture.exr")?);
        write_png_srgb8(&png, width, height, &rgb, 1.0)?;
        let layers = ExrFilm { rgb: &rgb, variance: Some(&variance), samples: Some(&samples) };
        let set: String = self.set.iter().map(|(k, v)| format!(" --set {k}={v}")).collect();
        let approximate = if self.approximate.is_some() { " --approximate diffusion" } else { "" };
        let comment = format!("{title}: mieux render {}{set}{approximate} --seed {}", self.subject, self.seed);
        write_exr(&exr, width, height, &layers, &comment)?;
        Ok(vec![png, exr])
    }
}

/// Constant beyond the first and last wavelength, as far as pictures reach.
fn beyond(spectrum: &Sampled) -> Result<Sampled, SpectrumError> {
    let (first, last) = WavelengthGrid::frisvad2007().range();
    let (mut wavelengths, mut values) = (spectrum.grid().as_slice().to_vec(), spectrum.values().to_vec());
    if wavelengths[0] > first {
        wavelengths.insert(0, first);
        values.insert(0, values[0]);
    }
    if wavelengths[wavelengths.len() - 1] < last {
        wavelengths.push(last);
        values.push(values[values.len() - 1]);
    }
    Sampled::new(WavelengthGrid::new(wavelengths)?, values)
}

/// What is said of materials that are not known as far as pictures reach.
fn notes(sheets: &[OpticsSheet]) -> Vec<String> {
    let usual = WavelengthGrid::frisvad2007().range();
    let partly = sheets.iter().filter(|sheet| sheet.bulk.grid().range() != usual);
    partly
        .map(|sheet| {
            let (from, to) = sheet.bulk.grid().range();
            let (from, to) = (format_length(from), format_length(to));
            format!(
                "{} is known from {from} to {to}; beyond, its properties are taken as at the nearer end",
                sheet.material.name
            )
        })
        .collect()
}

/// The scene of glasses filled with the materials of the sheets.
fn build(sheets: &[OpticsSheet], size: Size) -> Result<Scene, JobError> {
    let glass = OpticsMedium::new(Substance::SodaLimeGlass, Vec::new())
        .and_then(|glass| glass.bulk_optics(&WavelengthGrid::regular(370e-9, 790e-9, 10e-9)?, DEFAULT_TOLERANCE))
        .map_err(|source| JobError::Medium { material: "glass".into(), source })?;
    let mut liquids = Vec::with_capacity(sheets.len());
    for sheet in sheets {
        liquids.push((sheet.material.title.clone(), medium(&sheet.bulk)?));
    }
    let mut wanted = GlassScene::new(liquids, medium(&glass)?);
    wanted.resolution = [size.width(), size.height()];
    Ok(glasses(&wanted).map_err(mieux_render::render::RenderError::from)?)
}

fn medium(bulk: &mieux_optics::medium::BulkOptics) -> Result<Medium, JobError> {
    let spectrum = |values: &[f64]| beyond(&Sampled::new(bulk.grid().clone(), values.to_vec())?);
    Ok(Medium::new(
        spectrum(bulk.sigma_s())?,
        spectrum(bulk.sigma_a())?,
        spectrum(bulk.asymmetry())?,
        spectrum(bulk.n_real())?,
    ))
}
