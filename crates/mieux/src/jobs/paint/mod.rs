//! The jobs behind `mieux paint`: paints from measurements, what they become when mixed, and recipes for wanted colours.

mod fit;
mod matching;
mod mix;
mod shown;

use std::path::Path;

use mieux_io::nearest_names;
use mieux_io::paint::load_paints;
use mieux_optics::paint::{PaintError, PaintSet};

use super::JobError;
pub use fit::{HoldOut, PaintFit, PaintFitReport, SampleFit};
pub use matching::{PaintMatch, PaintMatchReport, PaintTarget};
pub use mix::{PaintMix, PaintMixReport};
pub use shown::Shown;

/// The paints of a file.
fn paints(path: &Path) -> Result<PaintSet, JobError> {
    Ok(load_paints(path)?)
}

/// The error, with names that are near to one that is not known.
fn named(error: PaintError, set: &PaintSet) -> JobError {
    match error {
        PaintError::Unknown { paint } => {
            let names = || set.paints().iter().map(|paint| paint.name.as_str());
            let help = match nearest_names(&paint, names()).first() {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("the paints are {}", names().collect::<Vec<_>>().join(", ")),
            };
            JobError::NoSuchPaint { paint, help }
        }
        other => other.into(),
    }
}
