//! What a running job says, and how it is asked to stop.

use std::sync::atomic::{AtomicBool, Ordering};

/// What a job is busy with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Computing optical properties; counted in wavelengths.
    Optics,
    /// Following light; counted in samples.
    Render,
    /// Computing particles; counted in particles, their total being estimated from the size of a file.
    Spheres,
    /// Computing phase functions; counted in functions.
    Phase,
    /// Solving slabs; counted in slabs and wavelengths.
    Slabs,
    /// Following photons through slabs; counted in photons.
    Photons,
    /// Fitting or matching paints; not counted.
    Paints,
    /// Writing files; counted in files.
    Write,
}

/// A report of progress.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// A stage begins.
    Begin(Stage),
    /// How far a stage is.
    Progress {
        /// The stage.
        stage: Stage,
        /// Done so far, in the unit of the stage.
        done: u64,
        /// All there is to do, as far as that is known.
        total: Option<u64>,
        /// Samples per pixel of the pass at hand, in [`Stage::Render`].
        samples_per_pixel: Option<u64>,
        /// Mean relative error of the picture so far, in [`Stage::Render`].
        noise: Option<f64>,
    },
    /// A stage has ended.
    End(Stage),
}

/// What a job runs in.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// Hears every event, from any thread.
    pub sink: &'a (dyn Fn(Event) + Sync),
    /// Asks the job to stop at the next point from which it can go on later.
    pub cancel: &'a AtomicBool,
}

impl Context<'_> {
    pub(super) fn say(&self, event: Event) {
        (self.sink)(event);
    }

    pub(super) fn count(&self, stage: Stage, done: u64, total: u64) {
        self.say(Event::Progress { stage, done, total: Some(total), samples_per_pixel: None, noise: None });
    }

    pub(super) fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }
}
