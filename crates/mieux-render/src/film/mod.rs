//! What the camera records: colour from spectra, sums from samples, noise from sums of squares.

mod observer;
mod picture;

pub use observer::{Observer, ObserverError};
pub use picture::{Film, FilmError, Pixel};
