//! Exposes a film: passes of more and more samples, tile by tile, on all threads of the caller's pool.

use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};

use rayon::prelude::*;

use crate::film::{Film, Filter, Pixel, relative_error};
use crate::integrator::{Statistics, Transport, trace};
use crate::sampler::PixelSampler;
use crate::scene::{Prepared, Scene, SceneError};

/// When a render is done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StopRule {
    /// At this many samples in every pixel; at least 1.
    Samples(u64),
    /// When the mean relative error per pixel is down to this in every tile of 16 x 16 pixels, each tile taking as many
    /// samples as it needs; above 0. What is meant by relative error is said at [`Film::noise`].
    Noise(f64),
    /// Only when the sink says so.
    Never,
}

/// How to render.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderSettings {
    /// The same seed gives the same picture.
    pub seed: u64,
    /// When to stop.
    pub stop: StopRule,
    /// How light is followed.
    pub transport: Transport,
}

impl Default for RenderSettings {
    /// Seed 0, 64 samples per pixel, exact transport without dispersion.
    fn default() -> Self {
        Self { seed: 0, stop: StopRule::Samples(64), transport: Transport::default() }
    }
}

/// What part of the picture is exposed, and how.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Exposure {
    /// A window of the camera's picture: left, top, width, height in pixels. The film is as large as the window, and its
    /// pixels are those of the whole picture to the bit (by [`StopRule::Noise`], as far as both take the same samples).
    pub crop: Option<[u32; 4]>,
    /// How rays are spread around the centre of a pixel.
    pub filter: Filter,
    /// Only every so manyth tile.
    pub shard: Option<Shard>,
    /// Bins of wavelength in which radiance is kept besides; 0 for none.
    pub bins: usize,
}

/// One of several parts that make a picture together: tiles in turn, so that all parts take about as long.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Which part, from 0.
    pub index: u32,
    /// How many parts there are.
    pub count: u32,
}

/// How far a render is; given to the sink after every tile, by whichever thread finished it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Samples taken so far in all pixels, earlier runs included.
    pub samples: u64,
    /// Samples in all pixels at the end of this pass.
    pub pass_end: u64,
    /// Samples in all pixels at the end, if that is known, or as it is foreseen from the noise so far.
    pub end: Option<u64>,
    /// Samples per pixel at the end of this pass.
    pub pass_samples: u64,
    /// Noise at the end of the last pass, once there is one with eight samples per pixel.
    pub noise: Option<f64>,
}

/// What the sink wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flow {
    /// Go on.
    Continue,
    /// Finish the tiles at hand, show the film to whoever keeps it, and go on.
    Keep,
    /// Finish the tiles at hand and return the film as it is; it can be taken up again.
    Stop,
}

/// Why a render ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// The stop rule was met.
    Finished,
    /// The sink asked for it. Pixels may have different numbers of samples.
    Stopped,
}

/// What a render leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct Rendered {
    /// The picture, and all that is needed to go on with it.
    pub film: Film,
    /// Why it ended.
    pub outcome: Outcome,
    /// What happened in this run.
    pub statistics: Statistics,
    /// [`Film::noise`] of the picture.
    pub noise: f64,
}

/// Why nothing can be rendered.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RenderError {
    /// The scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// No samples, or more than 2^40.
    #[error("{samples} samples per pixel; between 1 and 2^40 are possible")]
    Samples {
        /// The offending number.
        samples: u64,
    },
    /// The noise to reach must be positive.
    #[error("a noise of {noise} cannot be reached; it must be positive")]
    Noise {
        /// The offending value.
        noise: f64,
    },
    /// The film to go on with has another size than the camera's.
    #[error("the film has {film:?} pixels, the camera {camera:?}")]
    Resolution {
        /// Width and height of the film.
        film: [u32; 2],
        /// Width and height of the camera.
        camera: [u32; 2],
    },
    /// A crop window that is empty or reaches beyond the picture.
    #[error(
        "the crop window {window:?} (left, top, width, height) is empty or reaches beyond a picture of {camera:?} pixels"
    )]
    Crop {
        /// Left, top, width, height.
        window: [u32; 4],
        /// Width and height of the camera.
        camera: [u32; 2],
    },
    /// A part that there is not.
    #[error("there is no part {index} of {count}, counted from 0")]
    Shard {
        /// Which part.
        index: u32,
        /// Of how many.
        count: u32,
    },
    /// The film to go on with has another number of bins.
    #[error("the film has {film} bins of wavelength, {wanted} are wanted")]
    Bins {
        /// Bins of the film.
        film: usize,
        /// Bins asked for.
        wanted: usize,
    },
}

/// Side of a tile, pixels.
pub const TILE: u32 = 16;
/// Passes double up to this many samples per pixel, then grow by as many: whole groups, by which the film judges noise.
const LARGEST_PASS: u64 = 4;
/// Samples per pixel before the first judgement of a tile.
const FIRST_LOOK: u64 = 16;
/// Most samples per pixel a tile takes between two judgements, so that it can be interrupted.
const LONGEST_STEP: u64 = 64;

/// Renders a scene, from scratch or going on with `film` (of the same scene, seed and transport, or the result is a
/// blend). Every pixel takes its samples in order, so a render that was stopped and taken up again, on any number of
/// threads, gives the same bits as one that was not.
///
/// # Errors
/// [`RenderError`] for a scene that cannot be rendered or settings that make no sense; nothing is rendered then.
pub fn render(
    scene: &Scene,
    settings: &RenderSettings,
    film: Option<Film>,
    sink: &(dyn Fn(&Progress) -> Flow + Sync),
) -> Result<Rendered, RenderError> {
    render_prepared(&Prepared::new(scene)?, settings, film, sink)
}

/// [`render`] for a scene that has been prepared.
///
/// # Errors
/// [`RenderError`] for settings that make no sense.
pub fn render_prepared(
    scene: &Prepared,
    settings: &RenderSettings,
    film: Option<Film>,
    sink: &(dyn Fn(&Progress) -> Flow + Sync),
) -> Result<Rendered, RenderError> {
    expose(scene, settings, &Exposure::default(), film, sink, &mut |_| {})
}

/// [`render_prepared`] for part of a picture, with a filter, with spectra. `keep` is shown the film whenever the sink has
/// asked for it with [`Flow::Keep`]: rendering goes on from there to the same bits.
///
/// # Errors
/// [`RenderError`] for settings that make no sense.
pub fn expose(
    scene: &Prepared,
    settings: &RenderSettings,
    exposure: &Exposure,
    film: Option<Film>,
    sink: &(dyn Fn(&Progress) -> Flow + Sync),
    keep: &mut dyn FnMut(&Film),
) -> Result<Rendered, RenderError> {
    let window = window(scene, exposure)?;
    let mut film = film.unwrap_or_else(|| Film::with_bins([window[2], window[3]], exposure.bins));
    check(settings, exposure, window, &film)?;
    let tiles = owned_tiles(window, exposure.shard);
    let mut statistics = Statistics::default();
    let outcome = loop {
        let plan = plan(&mut film, &tiles, settings.stop);
        if plan.work.is_empty() {
            break Outcome::Finished;
        }
        let noise = Some(film.noise()).filter(|n| n.is_finite());
        let pass = Pass { scene, settings, exposure, origin: [window[0], window[1]], plan, noise };
        match pass.run(&mut film, &mut statistics, sink) {
            Flow::Stop => break Outcome::Stopped,
            Flow::Keep => keep(&film),
            Flow::Continue => {}
        }
    };
    Ok(Rendered { noise: film.noise(), film, outcome, statistics })
}

/// Largest mean relative error per pixel in any tile of the film: what [`StopRule::Noise`] brings down.
pub fn worst_tile_noise(film: &Film, exposure: &Exposure) -> f64 {
    let [width, height] = film.resolution();
    let [left, top, ..] = exposure.crop.unwrap_or_default();
    let mut judged = film.clone();
    if judged.floor().is_none() {
        judged.set_floor();
    }
    let floor = judged.floor().unwrap_or(0.0);
    let tiles = owned_tiles([left, top, width, height], exposure.shard);
    tiles.iter().map(|&tile| relative_error(pixels(&judged, tile), floor)).fold(0.0, f64::max)
}

/// The tiles, in pixels of the film, that one part of a picture owns, of a window `[left, top, width, height]`.
pub fn owned_tiles([left, top, width, height]: [u32; 4], shard: Option<Shard>) -> Vec<[u32; 4]> {
    let Shard { index, count } = shard.unwrap_or(Shard { index: 0, count: 1 });
    let all = tiles([left, top, width, height]).into_iter().zip((0..count).cycle());
    all.filter(|&(_, turn)| turn == index).map(|(tile, _)| tile).collect()
}

fn window(scene: &Prepared, exposure: &Exposure) -> Result<[u32; 4], RenderError> {
    let camera = scene.camera().resolution();
    let window = exposure.crop.unwrap_or([0, 0, camera[0], camera[1]]);
    let [left, top, width, height] = window.map(u64::from);
    let inside = width > 0 && height > 0 && left + width <= camera[0].into() && top + height <= camera[1].into();
    if inside { Ok(window) } else { Err(RenderError::Crop { window, camera }) }
}

fn check(settings: &RenderSettings, exposure: &Exposure, window: [u32; 4], film: &Film) -> Result<(), RenderError> {
    if let Some(Shard { index, count }) = exposure.shard.filter(|s| s.index >= s.count) {
        return Err(RenderError::Shard { index, count });
    }
    match settings.stop {
        StopRule::Samples(samples) if !(1..=1 << 40).contains(&samples) => Err(RenderError::Samples { samples }),
        StopRule::Noise(noise) if !(noise > 0.0 && noise.is_finite()) => Err(RenderError::Noise { noise }),
        _ if film.resolution() != [window[2], window[3]] => {
            Err(RenderError::Resolution { film: film.resolution(), camera: [window[2], window[3]] })
        }
        _ if film.bins() != exposure.bins => Err(RenderError::Bins { film: film.bins(), wanted: exposure.bins }),
        _ => Ok(()),
    }
}

/// Samples per pixel at the end of the pass after `samples`: 1, 2, 4, 8, 12, ....
fn next_target(samples: u64, stop: StopRule) -> u64 {
    let next = if samples < LARGEST_PASS {
        (samples + 1).next_power_of_two()
    } else {
        (samples / LARGEST_PASS + 1) * LARGEST_PASS
    };
    if let StopRule::Samples(n) = stop { next.min(n) } else { next }
}

/// A rectangle of pixels of the film: left, top, width, height.
type Tile = [u32; 4];

/// What a pass does: tiles, each up to its own number of samples per pixel.
struct Plan {
    work: Vec<(Tile, u64)>,
    /// Samples in all pixels once all is done, as far as that can be told.
    end: Option<u64>,
}

fn pixels(film: &Film, [left, top, width, height]: Tile) -> impl Iterator<Item = &Pixel> {
    (top..top + height).flat_map(move |y| (left..left + width).filter_map(move |x| film.pixel(x, y)))
}

/// Fewest and most samples in the pixels of a tile.
fn span(film: &Film, tile: Tile) -> (u64, u64) {
    pixels(film, tile).fold((u64::MAX, 0), |(low, high), p| (low.min(p.samples), high.max(p.samples)))
}

fn plan(film: &mut Film, tiles: &[Tile], stop: StopRule) -> Plan {
    let spans: Vec<(u64, u64)> = tiles.iter().map(|&tile| span(film, tile)).collect();
    let least = spans.iter().map(|s| s.0).min().unwrap_or(u64::MAX);
    let area = |tile: &Tile| u64::from(tile[2] * tile[3]);
    let StopRule::Noise(wanted) = stop else {
        let end = match stop {
            StopRule::Samples(n) => Some(n * tiles.iter().map(area).sum::<u64>()),
            _ => None,
        };
        let done = matches!(stop, StopRule::Samples(n) if least >= n);
        let target = if done || tiles.is_empty() { 0 } else { next_target(least, stop) };
        let work = tiles.iter().zip(&spans).filter(|(_, s)| s.0 < target).map(|(&tile, _)| (tile, target));
        return Plan { work: work.collect(), end };
    };
    if film.floor().is_none() && least >= FIRST_LOOK && !tiles.is_empty() {
        film.set_floor();
    }
    let Some(floor) = film.floor() else {
        let target = next_target(least, StopRule::Samples(FIRST_LOOK));
        let work = tiles.iter().zip(&spans).filter(|(_, s)| s.0 < target).map(|(&tile, _)| (tile, target));
        return Plan { work: work.collect(), end: None };
    };
    let (mut work, mut end) = (Vec::new(), 0);
    for (&tile, &(low, high)) in tiles.iter().zip(&spans) {
        let next =
            if low < high { Next { target: high, foreseen: high } } else { judge(film, tile, low, floor, wanted) };
        if next.target > low {
            work.push((tile, next.target));
        }
        end += next.foreseen * area(&tile);
    }
    Plan { work, end: Some(end) }
}

struct Next {
    target: u64,
    foreseen: u64,
}

/// Up to how many samples per pixel a tile goes before it is judged again. This follows from the tile's own pixels and the
/// floor alone, so that it does not matter when others are done or a render is interrupted. Errors fall with the root of the
/// samples: most of the way is gone at once, since every look at a chance to stop is a chance to stop too early.
fn judge(film: &Film, tile: Tile, samples: u64, floor: f64, wanted: f64) -> Next {
    let error = relative_error(pixels(film, tile), floor);
    if samples >= FIRST_LOOK && error <= wanted {
        return Next { target: samples, foreseen: samples };
    }
    let samples = samples.max(1);
    let foreseen = if error.is_finite() { samples as f64 * (error / wanted).powi(2) } else { 2.0 * samples as f64 };
    let foreseen = foreseen.clamp(samples as f64 + 1.0, (1u64 << 40) as f64);
    let step = ((0.95 * foreseen) as u64).saturating_sub(samples).min(LONGEST_STEP).min(samples);
    let target = (samples + step.max(1)).next_multiple_of(LARGEST_PASS);
    Next { target, foreseen: (foreseen as u64).max(target) }
}

struct Pass<'a> {
    scene: &'a Prepared,
    settings: &'a RenderSettings,
    exposure: &'a Exposure,
    /// Where the film lies in the camera's picture.
    origin: [u32; 2],
    plan: Plan,
    noise: Option<f64>,
}

/// A tile brought up to its target: pixels, their spectra, what happened.
struct Exposed {
    pixels: Vec<Pixel>,
    spectra: Vec<f64>,
    statistics: Statistics,
}

impl Pass<'_> {
    fn run(&self, film: &mut Film, statistics: &mut Statistics, sink: &(dyn Fn(&Progress) -> Flow + Sync)) -> Flow {
        let total = film.total_samples();
        let missing =
            |&(tile, target): &(Tile, u64)| pixels(film, tile).map(|p| target.saturating_sub(p.samples)).sum::<u64>();
        let pass_end = total + self.plan.work.iter().map(missing).sum::<u64>();
        let pass_samples = self.plan.work.iter().map(|w| w.1).max().unwrap_or(0);
        let asked = AtomicU8::new(0);
        let samples = AtomicU64::new(total);
        let report = |taken: u64| {
            let samples = samples.fetch_add(taken, Ordering::Relaxed) + taken;
            let progress = Progress { samples, pass_end, end: self.plan.end, pass_samples, noise: self.noise };
            let wish = match sink(&progress) {
                Flow::Continue => 0,
                Flow::Keep => 1,
                Flow::Stop => 2,
            };
            asked.fetch_max(wish, Ordering::Relaxed);
        };
        let exposed: &Film = film;
        let finished: Vec<_> = (&self.plan.work)
            .into_par_iter()
            .with_max_len(1)
            .filter_map(|&(tile, target)| {
                if asked.load(Ordering::Relaxed) > 0 {
                    return None;
                }
                let done = self.tile(exposed, tile, target);
                report(done.statistics.paths);
                Some((tile, done))
            })
            .collect();
        for ([left, top, width, _], done) in finished {
            for (i, pixel) in (0u32..).zip(done.pixels) {
                let (x, y) = (left + i % width, top + i / width);
                *film.pixel_mut(x, y) = pixel;
                let bins = film.bins();
                film.spectrum_mut(x, y).copy_from_slice(&done.spectra[i as usize * bins..(i as usize + 1) * bins]);
            }
            *statistics += done.statistics;
        }
        match asked.into_inner() {
            0 => Flow::Continue,
            1 => Flow::Keep,
            _ => Flow::Stop,
        }
    }

    /// The pixels of a tile brought up to the target.
    fn tile(&self, film: &Film, [left, top, width, height]: Tile, target: u64) -> Exposed {
        let mut statistics = Statistics::default();
        let mut pixels = Vec::with_capacity((width * height) as usize);
        let mut spectra = Vec::with_capacity((width * height) as usize * film.bins());
        for y in top..top + height {
            for x in left..left + width {
                let mut pixel = film.pixel(x, y).copied().unwrap_or_default();
                let start = spectra.len();
                spectra.extend_from_slice(film.spectrum(x, y));
                while pixel.samples < target {
                    pixel.add(self.sample(x, y, pixel.samples, &mut spectra[start..], &mut statistics));
                }
                pixels.push(pixel);
            }
        }
        Exposed { pixels, spectra, statistics }
    }

    fn sample(&self, x: u32, y: u32, index: u64, bins: &mut [f64], statistics: &mut Statistics) -> [f64; 3] {
        let (x, y) = (x + self.origin[0], y + self.origin[1]);
        let mut sampler = PixelSampler::new(self.settings.seed, x, y, index);
        let ([dx, dy], weight) = self.exposure.filter.sample(sampler.pair());
        let ray = self.scene.camera().ray(f64::from(x) + dx, f64::from(y) + dy);
        let mut estimate = trace(self.scene, &self.settings.transport, ray, &mut sampler, statistics);
        if weight != 1.0 {
            estimate.radiance.iter_mut().for_each(|radiance| *radiance *= weight);
        }
        if !bins.is_empty() {
            self.scene.observer().bin(&estimate.wavelengths, &estimate.radiance, bins);
        }
        self.scene.observer().colour(&estimate.wavelengths, &estimate.radiance)
    }
}

/// The tiles of a window `[left, top, width, height]`, in pixels of the window; their edges are those of the whole picture.
fn tiles([left, top, width, height]: [u32; 4]) -> Vec<Tile> {
    let cuts = |start: u32, length: u32| {
        let first = TILE - start % TILE;
        std::iter::once(0).chain((first..length).step_by(TILE as usize)).map(move |a| {
            let end = if a == 0 { first } else { a + TILE };
            (a, end.min(length) - a)
        })
    };
    cuts(top, height).flat_map(|(y, h)| cuts(left, width).map(move |(x, w)| [x, y, w, h])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn passes_grow_and_then_keep_their_size() {
        let targets: Vec<u64> =
            std::iter::successors(Some(0), |&n| Some(next_target(n, StopRule::Never))).take(10).collect();
        assert_eq!(targets, [0, 1, 2, 4, 8, 12, 16, 20, 24, 28]);
        assert_eq!(next_target(5, StopRule::Never), 8);
        assert_eq!(next_target(5, StopRule::Samples(6)), 6);
    }

    #[test]
    fn tiles_cover_every_pixel_once() {
        for window in [[0, 0, 33, 50], [5, 17, 33, 50], [16, 31, 1, 1], [3, 3, 13, 29]] {
            let covered: u32 = tiles(window).iter().map(|[_, _, w, h]| w * h).sum();
            assert_eq!(covered, window[2] * window[3]);
            let parts = (0..3).flat_map(|index| owned_tiles(window, Some(Shard { index, count: 3 })));
            assert_eq!(parts.map(|[_, _, w, h]| w * h).sum::<u32>(), covered);
        }
        assert_eq!(tiles([0, 0, 1, 1]), [[0, 0, 1, 1]]);
        assert_eq!(tiles([15, 0, 3, 4]), [[0, 0, 1, 4], [1, 0, 2, 4]]);
    }
}
