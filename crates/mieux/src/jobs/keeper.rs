//! What happens to a picture while it is made: checkpoints, and previews.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use mieux_io::checkpoint::write_checkpoint;
use mieux_io::output::OutputDir;
use mieux_io::tev::Viewer;
use mieux_render::film::Film;

use super::pictures::{Look, write_png};
use super::{JobError, Render};

/// Seconds between checkpoints, unless another time is asked for, and between previews.
const CHECKPOINT_SECONDS: f64 = 30.0;
const PREVIEW_SECONDS: f64 = 1.0;

/// Says when something is due; shared with the threads that render.
#[derive(Clone)]
pub(super) struct Clock {
    start: Instant,
    /// Nanoseconds after the start.
    due: Arc<AtomicU64>,
}

impl Clock {
    pub(super) fn is_due(&self) -> bool {
        self.now() >= self.due.load(Ordering::Relaxed)
    }

    fn now(&self) -> u64 {
        self.start.elapsed().as_nanos() as u64
    }
}

/// Writes checkpoints and shows previews.
pub(super) struct Keeper<'a> {
    dir: &'a OutputDir,
    checkpoint: PathBuf,
    identity: &'a str,
    look: &'a Look,
    clock: Clock,
    /// Nanoseconds between them, and when the next is due.
    checkpoints: (u64, u64),
    previews: Option<(u64, u64)>,
    viewer: Option<Viewer>,
    /// What went wrong, of each kind the last.
    troubles: [Option<String>; 2],
}

impl<'a> Keeper<'a> {
    pub(super) fn new(
        job: &Render,
        dir: &'a OutputDir,
        checkpoint: PathBuf,
        identity: &'a str,
        look: &'a Look,
        title: &str,
        window: [u32; 4],
    ) -> Result<Self, JobError> {
        let nanoseconds = |s: f64| (s * 1e9) as u64;
        let every = nanoseconds(job.checkpoint_seconds.unwrap_or(CHECKPOINT_SECONDS));
        let (mut viewer, mut troubles) = (None, [None, None]);
        if let Some(address) = &job.preview {
            match Viewer::open(address, &format!("mieux: {title}"), [window[2], window[3]]) {
                Ok(open) => viewer = Some(open),
                Err(e) => troubles[1] = Some(format!("{e}; picture.png alone was refreshed")),
            }
        }
        let previews = job.preview.is_some().then(|| (nanoseconds(PREVIEW_SECONDS), nanoseconds(PREVIEW_SECONDS)));
        let first = previews.map_or(every, |p| p.1.min(every));
        let clock = Clock { start: Instant::now(), due: Arc::new(AtomicU64::new(first)) };
        Ok(Self { dir, checkpoint, identity, look, clock, checkpoints: (every, every), previews, viewer, troubles })
    }

    pub(super) fn clock(&self) -> Clock {
        self.clock.clone()
    }

    /// Does what is due. What cannot be written does not end the render: it is told at its end.
    pub(super) fn keep(&mut self, film: &Film) {
        let now = self.clock.now();
        if now >= self.checkpoints.1 {
            self.troubles[0] = write_checkpoint(&self.checkpoint, self.identity, film)
                .err()
                .map(|e| format!("the last checkpoint could not be written, an older one is untouched: {e}"));
            self.checkpoints.1 = self.clock.now() + self.checkpoints.0;
        }
        if self.previews.is_some_and(|p| now >= p.1) {
            self.show(film);
            let _ = write_png(self.dir, film, self.look);
            self.previews = self.previews.map(|(every, _)| (every, self.clock.now() + every));
        }
        let next = self.previews.map_or(u64::MAX, |p| p.1).min(self.checkpoints.1);
        self.clock.due.store(next, Ordering::Relaxed);
    }

    fn show(&mut self, film: &Film) {
        let Some(viewer) = &mut self.viewer else { return };
        let rgb: Vec<[f32; 3]> = film.pixels().iter().map(|p| p.mean().map(|v| v as f32)).collect();
        if let Err(e) = viewer.update(&rgb) {
            self.troubles[1] = Some(e.to_string());
            self.viewer = None;
        }
    }

    /// Shows the picture as it is in the end, and says what went wrong.
    pub(super) fn finish(mut self, film: &Film) -> Vec<String> {
        self.show(film);
        self.troubles.into_iter().flatten().collect()
    }
}
