//! Pictures in files: PNG to look at, OpenEXR to compute with.

mod openexr;
mod radiance;
mod srgb;
mod tone;

use std::path::{Path, PathBuf};

pub use openexr::{
    ExrImage, Film, MAX_CHANNELS, read_exr, spectral_channel, write_exr, write_exr_channels, write_exr_spectral,
};
pub use radiance::read_radiance;
pub use srgb::{write_png_srgb8, write_png_toned};
pub use tone::Tone;

use crate::output::OutputError;
use crate::quantity::{QuantityError, Size};

/// What can go wrong with an image file.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The size is not one an image here can have.
    #[error("no image has this size: {0}")]
    Size(#[from] QuantityError),
    /// Not as many values as the size asks for.
    #[error("{what} has {found} values, but an image of {width}x{height} pixels needs {expected}")]
    Length {
        /// Which values.
        what: String,
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: usize,
        /// Pixels in a row.
        width: u32,
        /// Rows of pixels.
        height: u32,
    },
    /// An exposure that makes no picture.
    #[error("the exposure {exposure} is not a factor of more than 0 and finite")]
    Exposure {
        /// The exposure.
        exposure: f64,
    },
    /// No channels, too many, two of one name, or a name that cannot be written.
    #[error("an image cannot have these channels: {problem}")]
    Channels {
        /// What is wrong, and what is allowed.
        problem: String,
    },
    /// The file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The file could not be opened or read.
    #[error("`{}` cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A picture of radiance that is damaged or of another kind.
    #[error("`{}` is no picture of radiance that can be read: {problem}", path.display())]
    Radiance {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// The file is damaged, cut short, or no OpenEXR file at all.
    #[error("`{}` is not a whole OpenEXR file: {problem}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What was found.
        problem: String,
    },
    /// A sound file of a kind that is not read here.
    #[error("`{}` holds what is not read here: {problem}", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// What was found, and what is read.
        problem: String,
    },
}

/// Makes sure that there are `per_pixel` values for every pixel.
fn check_length(what: &str, found: usize, size: Size, per_pixel: usize) -> Result<(), ImageError> {
    let expected = size.pixels() * per_pixel;
    if found == expected {
        return Ok(());
    }
    Err(ImageError::Length { what: what.to_owned(), found, expected, width: size.width(), height: size.height() })
}

fn damaged(path: &Path, problem: impl Into<String>) -> ImageError {
    ImageError::Damaged { path: path.to_owned(), problem: problem.into() }
}

fn unsupported(path: &Path, problem: impl Into<String>) -> ImageError {
    ImageError::Unsupported { path: path.to_owned(), problem: problem.into() }
}
