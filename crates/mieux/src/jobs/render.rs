//! The job behind `mieux render`.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use mieux_io::checkpoint::{MAX_BINS, read_checkpoint, write_checkpoint};
use mieux_io::image::Tone;
use mieux_io::output::OutputDir;
use mieux_io::quantity::Size;
use mieux_render::film::{Film, Filter};
use mieux_render::integrator::{Statistics, Transport};
use mieux_render::render::{
    Exposure, Flow, Outcome, Progress, RenderError, RenderSettings, Rendered, Shard, StopRule, expose, worst_tile_noise,
};
use mieux_render::scene::Prepared;
use serde::{Deserialize, Serialize};

use super::keeper::Keeper;
use super::pictures::{Look, write_pictures};
use super::wanted::Wanted;
use super::{Context, Event, JobError, OpticsSheet, Stage};

/// The file that an interrupted render goes on from.
const CHECKPOINT: &str = "render.checkpoint";
/// The file in which one of several parts of a picture waits for the others.
pub(super) const SHARD: &str = "shard.film";

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
    /// How rays are spread around pixels: `box` when left out, `tent`, `gaussian`, `mitchell`, `blackman-harris`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub filter: Option<String>,
    /// A window of the picture: left, top, width, height in pixels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crop: Option<[u32; 4]>,
    /// Bins of wavelength in which radiance is written besides; 0 for none.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub spectral_bins: usize,
    /// One of several parts: which, from 1, and of how many.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<(u32, u32)>,
    /// The tone curve of the PNG: `srgb` when left out, `filmic`, `reinhard`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tone: Option<String>,
    /// Exposure of the PNG in stops: each doubles the light.
    #[serde(default)]
    pub exposure: f64,
    /// Where a tev viewer listens that is shown the picture as it grows (`host:port`); the PNG is refreshed as well.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preview: Option<String>,
    /// Seconds between checkpoints; 30 when left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub checkpoint_seconds: Option<f64>,
    /// Go on with the render that was interrupted in the same folder.
    #[serde(default)]
    pub resume: bool,
    /// Folder for the results; `out/NAME` when left out.
    #[serde(default)]
    pub output: Option<PathBuf>,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // As serde asks for it.
fn is_zero(n: &usize) -> bool {
    *n == 0
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
    /// When the mean relative standard error per pixel is down to this in every tile of 16 x 16 pixels.
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
    /// The same in the tile of 16 x 16 pixels where it is largest.
    pub worst_noise: f64,
    /// The part of a picture that was made, if not the whole: which, and of how many.
    pub shard: Option<(u32, u32)>,
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
            filter: None,
            crop: None,
            spectral_bins: 0,
            shard: None,
            tone: None,
            exposure: 0.0,
            preview: None,
            checkpoint_seconds: None,
            resume: false,
            output: None,
        }
    }

    pub(super) fn run(&self, context: &Context<'_>) -> Result<RenderReport, JobError> {
        self.develop(None, context)
    }

    /// Renders, going on with `given`, whose identity must be the job's.
    pub(super) fn develop(&self, given: Option<(&str, Film)>, context: &Context<'_>) -> Result<RenderReport, JobError> {
        let stop = self.stop.check()?;
        let (exposure, look) = self.choices()?;
        let wanted = Wanted::find(&self.subject, &self.set)?;
        let size = self.size.unwrap_or(wanted.size);
        let sheets = wanted.sheets(context)?;
        let (scene, mut notes) = wanted.scene(&sheets, size)?;
        let scene = Prepared::new(&scene).map_err(RenderError::from)?;
        let window = exposure.crop.unwrap_or([0, 0, size.width(), size.height()]);
        check_window(window, size)?;

        let folder = self.output.clone().unwrap_or_else(|| PathBuf::from("out").join(&wanted.name));
        let dir = OutputDir::create(&folder)?;
        let identity = self.identity(size, wanted.fingerprint(&sheets));
        let checkpoint = dir.file(CHECKPOINT)?;
        let film = match given {
            Some((found, _)) if found != identity => return Err(JobError::OtherScene),
            Some((_, film)) => Some(film),
            None if self.resume => Some(read_checkpoint(&checkpoint, &identity)?),
            None => None,
        };

        let mut keeper = Keeper::new(self, &dir, checkpoint.clone(), &identity, &look, &wanted.title, window)?;
        let start = Instant::now();
        let rendered = self.expose(&scene, &exposure, stop, film, (start, &mut keeper), context)?;
        let seconds = start.elapsed().as_secs_f64();
        let interrupted = rendered.outcome == Outcome::Stopped && context.is_cancelled();
        if rendered.film.samples().1 == 0 {
            return Err(JobError::Cancelled);
        }
        notes.extend(keeper.finish(&rendered.film));
        if interrupted {
            // First of all: what follows may not fit on the disk any more.
            write_checkpoint(&checkpoint, &identity, &rendered.film)?;
        }

        context.say(Event::Begin(Stage::Write));
        let comment = self.comment(&wanted.title);
        let mut files = write_pictures(&dir, &rendered.film, &scene, window, &look, &comment)?;
        for sheet in &sheets {
            let stem = if sheets.len() == 1 { "optics".into() } else { format!("optics-{}", sheet.material.name) };
            files.extend(sheet.write(&dir, &stem)?);
        }
        if self.shard.is_some() && !interrupted {
            let file = dir.file(SHARD)?;
            write_checkpoint(&file, &identity, &rendered.film)?;
            files.push(file);
        }
        if !interrupted {
            // What is finished needs no checkpoint; that there was none is no error.
            let _ = std::fs::remove_file(&checkpoint);
        }
        dir.commit();
        context.say(Event::End(Stage::Write));
        Ok(RenderReport {
            title: wanted.title,
            sheets,
            interrupted,
            approximate: self.approximate,
            notes,
            samples: rendered.film.samples(),
            noise: rendered.noise,
            worst_noise: worst_tile_noise(&rendered.film, &exposure),
            shard: self.shard,
            seconds,
            statistics: rendered.statistics,
            folder,
            files,
        })
    }

    /// What is exposed and how it is shown, with what was typed checked.
    fn choices(&self) -> Result<(Exposure, Look), JobError> {
        let error = |name, value: String, allowed| JobError::Value { name, value, allowed };
        let filter = match &self.filter {
            None => Filter::default(),
            Some(name) => Filter::ALL.iter().find(|(n, _)| n == name).map(|f| f.1).ok_or_else(|| {
                error("filter", name.clone(), "box, tent, gaussian, mitchell and blackman-harris are known")
            })?,
        };
        let tone = match &self.tone {
            None => Tone::default(),
            Some(name) => Tone::ALL
                .iter()
                .find(|(n, _)| n == name)
                .map(|t| t.1)
                .ok_or_else(|| error("tone", name.clone(), "srgb, filmic and reinhard are known"))?,
        };
        if !self.exposure.is_finite() || self.exposure.abs() > 50.0 {
            return Err(error("exposure", self.exposure.to_string(), "between -50 and 50 stops"));
        }
        if self.spectral_bins > MAX_BINS as usize {
            return Err(error("spectral", self.spectral_bins.to_string(), "at most 40 bins of wavelength"));
        }
        let shard = match self.shard {
            None => None,
            Some((k, n)) if k >= 1 && k <= n && n <= 65_536 => Some(Shard { index: k - 1, count: n }),
            Some((k, n)) => return Err(error("shard", format!("{k}/{n}"), "k/n with k from 1 to n, as in `2/4`")),
        };
        if shard.is_some() && !matches!(self.stop, Stop::Samples(_)) {
            return Err(JobError::ShardStop);
        }
        if let Some(s) = self.checkpoint_seconds.filter(|s| !(*s > 0.0 && s.is_finite())) {
            return Err(error("checkpoint", format!("{s} s"), "a time above zero"));
        }
        let exposure = Exposure { crop: self.crop, filter, shard, bins: self.spectral_bins };
        Ok((exposure, Look { tone, factor: self.exposure.exp2() }))
    }

    /// What the picture says of itself.
    fn comment(&self, title: &str) -> String {
        let set: String = self.set.iter().map(|(k, v)| format!(" --set {k}={v}")).collect();
        let approximate = if self.approximate.is_some() { " --approximate diffusion" } else { "" };
        let filter = self.filter.as_ref().map(|f| format!(" --filter {f}")).unwrap_or_default();
        let crop = self.crop.map(|[x, y, w, h]| format!(" --crop {x},{y},{w},{h}")).unwrap_or_default();
        format!("{title}: mieux render {}{set}{approximate}{filter}{crop} --seed {}", self.subject, self.seed)
    }

    /// What a checkpoint must agree with: all that decides the value of a sample, the properties of the materials (whose
    /// files may have changed) included; of a part of a picture also when it ends.
    fn identity(&self, size: Size, fingerprint: u64) -> String {
        let relevant = Self { size: Some(size), ..Self::new(self.subject.clone()) };
        let relevant = Self {
            set: self.set.clone(),
            seed: self.seed,
            similarity: self.similarity,
            approximate: self.approximate,
            dispersion: self.dispersion,
            filter: self.filter.clone(),
            crop: self.crop,
            spectral_bins: self.spectral_bins,
            shard: self.shard,
            stop: if self.shard.is_some() { self.stop } else { Stop::default() },
            ..relevant
        };
        let job = serde_json::to_string(&relevant).unwrap_or_default();
        format!("mieux {} {fingerprint:016x} {job}", env!("CARGO_PKG_VERSION"))
    }

    /// The same job, with identity and film, as the one that all parts belong to.
    pub(super) fn whole(&self, size: Size, fingerprint: &str) -> (Self, String) {
        let whole = Self { shard: None, ..self.clone() };
        let job = Self { stop: Stop::default(), size: Some(size), ..whole.clone() };
        let job = serde_json::to_string(&job).unwrap_or_default();
        (whole, format!("mieux {} {fingerprint} {job}", env!("CARGO_PKG_VERSION")))
    }

    fn expose(
        &self,
        scene: &Prepared,
        exposure: &Exposure,
        stop: Stop,
        film: Option<Film>,
        (start, keeper): (Instant, &mut Keeper<'_>),
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
        let clock = keeper.clock();
        let first = film.as_ref().map_or(0, Film::total_samples);
        let sink = |progress: &Progress| {
            let elapsed = start.elapsed();
            // By time, the end is where the pace so far leads to.
            let foreseen = limit.map(|limit| {
                let pace = limit.as_secs_f64() / elapsed.as_secs_f64().max(1e-9);
                first + ((progress.samples - first) as f64 * pace.max(1.0)) as u64
            });
            context.say(Event::Progress {
                stage: Stage::Render,
                done: progress.samples,
                total: progress.end.or(foreseen),
                samples_per_pixel: Some(progress.pass_samples),
                noise: progress.noise,
            });
            let late = limit.is_some_and(|limit| elapsed >= limit);
            match late || context.is_cancelled() {
                true => Flow::Stop,
                false if clock.is_due() => Flow::Keep,
                false => Flow::Continue,
            }
        };
        context.say(Event::Begin(Stage::Render));
        let threads = self.threads.unwrap_or(0);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|e| JobError::Threads { threads, reason: e.to_string() })?;
        let mut keep = |film: &Film| keeper.keep(film);
        let rendered = pool.install(|| expose(scene, &settings, exposure, film, &sink, &mut keep))?;
        context.say(Event::End(Stage::Render));
        Ok(rendered)
    }
}

fn check_window(window: [u32; 4], size: Size) -> Result<(), JobError> {
    let [x, y, w, h] = window.map(u64::from);
    if w == 0 || h == 0 || x + w > size.width().into() || y + h > size.height().into() {
        return Err(RenderError::Crop { window, camera: [size.width(), size.height()] }.into());
    }
    Ok(())
}
