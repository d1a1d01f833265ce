//! Progress on the terminal; silent where there is none.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use mieux::jobs::{Event, Stage};

/// One bar per stage, one stage at a time.
pub struct Bars {
    shown: bool,
    current: Mutex<ProgressBar>,
    hint: Hint,
    /// Progress that came out of order is not shown.
    furthest: AtomicU64,
}

/// Tells the user that the request to stop was heard.
#[derive(Clone)]
pub struct Hint(ProgressBar);

impl Hint {
    pub fn stopping(&self) {
        if !self.0.is_hidden() {
            self.0.set_message("stopping after the work at hand; once more to quit at once");
            self.0.tick();
        }
    }
}

impl Bars {
    pub fn new(shown: bool) -> Self {
        let hint = ProgressBar::with_draw_target(None, target(shown));
        hint.set_style(style("{msg}"));
        Self { shown, current: Mutex::new(ProgressBar::hidden()), hint: Hint(hint), furthest: AtomicU64::new(0) }
    }

    pub fn hint(&self) -> Hint {
        self.hint.clone()
    }

    pub fn hear(&self, event: Event) {
        let Ok(mut current) = self.current.lock() else { return };
        match event {
            Event::Begin(stage) => {
                self.furthest.store(0, Ordering::Relaxed);
                *current = self.bar(stage);
            }
            Event::Progress { stage, done, total, samples_per_pixel, noise } => {
                if self.furthest.fetch_max(done, Ordering::Relaxed) > done {
                    return;
                }
                if let (Some(total), true) = (total, current.length() != total) {
                    if current.length().is_none() && stage == Stage::Render {
                        current.set_style(style(
                            "render  {bar:20} {percent} %, {per_sec}, {elapsed} so far, {eta} left, {msg}",
                        ));
                    }
                    current.set_length(total);
                }
                current.set_position(done);
                if let Some(samples) = samples_per_pixel {
                    let noise = noise.map_or("-".into(), |n| format!("{:.1} %", 100.0 * n));
                    current.set_message(format!("pass to {samples} samples per pixel, noise {noise}"));
                }
            }
            Event::End(_) => current.finish_and_clear(),
        }
    }

    pub fn clear(&self) {
        if let Ok(current) = self.current.lock() {
            current.finish_and_clear();
        }
        self.hint.0.finish_and_clear();
    }

    fn bar(&self, stage: Stage) -> ProgressBar {
        let (length, template) = match stage {
            Stage::Optics => (Some(1), "optics  {bar:30} {pos}/{len} wavelengths, {eta} left"),
            Stage::Render => (None, "render  {spinner} {human_pos} samples, {per_sec}, {elapsed} so far, {msg}"),
            Stage::Spheres => {
                (None, "mie     {bar:30} {human_pos} of about {human_len} particles, {per_sec}, {eta} left")
            }
            Stage::Phase => (Some(1), "phase   {bar:30} {pos}/{len} functions"),
            Stage::Slabs => (Some(1), "slab    {bar:30} {pos}/{len} slabs"),
            Stage::Photons => (Some(1), "slab    {bar:30} {human_pos} of {human_len} photons, {per_sec}, {eta} left"),
            Stage::Paints => (None, "paints  {spinner} {elapsed} so far"),
            Stage::Write => (None, "writing the results"),
        };
        let bar = ProgressBar::with_draw_target(length, target(self.shown));
        bar.set_style(style(template));
        bar.enable_steady_tick(Duration::from_millis(200));
        bar
    }
}

fn target(shown: bool) -> ProgressDrawTarget {
    if shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}
