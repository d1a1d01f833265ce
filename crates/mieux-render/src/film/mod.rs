//! What the camera records: colour from spectra, sums from samples, noise from sums of squares.

mod denoise;
mod difference;
mod filter;
mod observer;
mod picture;

pub use denoise::{Noisy, denoise};
pub use difference::{Block, Difference, DifferenceError, Estimated, Verdict, difference};
pub use filter::Filter;
pub use observer::{Observer, ObserverError};
pub(crate) use picture::relative_error;
pub use picture::{Film, FilmError, Pixel};
