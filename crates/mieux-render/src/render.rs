//! Exposes a film: passes of more and more samples, tile by tile, on all threads of the caller's pool.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::prelude::*;

use crate::film::{Film, Pixel};
use crate::integrator::{Statistics, Transport, trace};
use crate::sampler::PixelSampler;
use crate::scene::{Prepared, Scene, SceneError};

/// When a render is done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StopRule {
    /// At this many samples in every pixel; at least 1.
    Samples(u64),
    /// At the end of the first pass that brings [`Film::noise`] down to this; above 0.
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

/// How far a render is; given to the sink after every tile, by whichever thread finished it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Samples taken so far in all pixels, earlier runs included.
    pub samples: u64,
    /// Samples in all pixels at the end of this pass.
    pub pass_end: u64,
    /// Samples in all pixels at the end, if that is known.
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
}

/// Side of a tile, pixels.
const TILE: u32 = 16;
/// Passes double up to this many samples per pixel, then grow by as many: whole groups, by which the film judges noise.
const LARGEST_PASS: u64 = 4;

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
    let mut film = film.unwrap_or_else(|| Film::new(scene.camera().resolution()));
    check(scene, settings, &film)?;
    let mut statistics = Statistics::default();
    let outcome = loop {
        let least = film.samples().0;
        let noise = Some(film.noise()).filter(|n| n.is_finite());
        let done = match settings.stop {
            StopRule::Samples(n) => least >= n,
            // Judged at the ends of passes alone, so that an interruption does not change the end.
            StopRule::Noise(wanted) => ends_pass(&film) && noise.is_some_and(|n| n <= wanted),
            StopRule::Never => false,
        };
        if done {
            break Outcome::Finished;
        }
        let pass = Pass { scene, settings, target: next_target(least, settings.stop), noise };
        if pass.run(&mut film, &mut statistics, sink) == Flow::Stop {
            break Outcome::Stopped;
        }
    };
    Ok(Rendered { noise: film.noise(), film, outcome, statistics })
}

fn check(scene: &Prepared, settings: &RenderSettings, film: &Film) -> Result<(), RenderError> {
    match settings.stop {
        StopRule::Samples(samples) if !(1..=1 << 40).contains(&samples) => Err(RenderError::Samples { samples }),
        StopRule::Noise(noise) if !(noise > 0.0 && noise.is_finite()) => Err(RenderError::Noise { noise }),
        _ if film.resolution() != scene.camera().resolution() => {
            Err(RenderError::Resolution { film: film.resolution(), camera: scene.camera().resolution() })
        }
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

/// Whether every pixel stands at the end of the same pass.
fn ends_pass(film: &Film) -> bool {
    let (least, most) = film.samples();
    least == most && (least > 0 && next_target(least - 1, StopRule::Never) == least)
}

struct Pass<'a> {
    scene: &'a Prepared,
    settings: &'a RenderSettings,
    target: u64,
    noise: Option<f64>,
}

/// A rectangle of pixels: left, top, width, height.
type Tile = [u32; 4];

impl Pass<'_> {
    fn run(&self, film: &mut Film, statistics: &mut Statistics, sink: &(dyn Fn(&Progress) -> Flow + Sync)) -> Flow {
        let count = film.pixels().len() as u64;
        let pass_end: u64 = film.pixels().iter().map(|p| p.samples.max(self.target)).sum();
        let stop = AtomicBool::new(false);
        let samples = AtomicU64::new(film.total_samples());
        let report = |taken: u64| {
            let progress = Progress {
                samples: samples.fetch_add(taken, Ordering::Relaxed) + taken,
                pass_end,
                end: if let StopRule::Samples(n) = self.settings.stop { Some(n * count) } else { None },
                pass_samples: self.target,
                noise: self.noise,
            };
            if sink(&progress) == Flow::Stop {
                stop.store(true, Ordering::Relaxed);
            }
        };
        let exposed: &Film = film;
        let finished: Vec<_> = tiles(film.resolution())
            .into_par_iter()
            .filter_map(|tile| {
                if stop.load(Ordering::Relaxed) {
                    return None;
                }
                let (pixels, statistics) = self.tile(exposed, tile);
                report(statistics.paths);
                Some((tile, pixels, statistics))
            })
            .collect();
        for ([left, top, width, _], pixels, counted) in finished {
            for (i, pixel) in (0u32..).zip(pixels) {
                *film.pixel_mut(left + i % width, top + i / width) = pixel;
            }
            *statistics += counted;
        }
        if stop.into_inner() { Flow::Stop } else { Flow::Continue }
    }

    /// The pixels of a tile brought up to the target.
    fn tile(&self, film: &Film, [left, top, width, height]: Tile) -> (Vec<Pixel>, Statistics) {
        let mut statistics = Statistics::default();
        let mut pixels = Vec::with_capacity((width * height) as usize);
        for y in top..top + height {
            for x in left..left + width {
                let mut pixel = film.pixel(x, y).copied().unwrap_or_default();
                while pixel.samples < self.target {
                    pixel.add(self.sample(x, y, pixel.samples, &mut statistics));
                }
                pixels.push(pixel);
            }
        }
        (pixels, statistics)
    }

    fn sample(&self, x: u32, y: u32, index: u64, statistics: &mut Statistics) -> [f64; 3] {
        let mut sampler = PixelSampler::new(self.settings.seed, x, y, index);
        let [dx, dy] = sampler.pair();
        let ray = self.scene.camera().ray(f64::from(x) + dx, f64::from(y) + dy);
        let estimate = trace(self.scene, &self.settings.transport, ray, &mut sampler, statistics);
        self.scene.observer().colour(&estimate.wavelengths, &estimate.radiance)
    }
}

fn tiles([width, height]: [u32; 2]) -> Vec<Tile> {
    let starts = |length: u32| (0..length).step_by(TILE as usize);
    starts(height)
        .flat_map(|top| starts(width).map(move |left| [left, top, TILE.min(width - left), TILE.min(height - top)]))
        .collect()
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
        let covered: u32 = tiles([33, 50]).iter().map(|[_, _, w, h]| w * h).sum();
        assert_eq!(covered, 33 * 50);
        assert_eq!(tiles([1, 1]), [[0, 0, 1, 1]]);
    }
}
