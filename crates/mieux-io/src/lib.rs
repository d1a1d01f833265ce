//! Every byte in or out of `mieux`: quantities as people type them, images, tables, plots, files.
//!
//! Nothing here prints, exits or reads the environment. Untrusted text and files end in typed errors that carry the
//! offending value and say what would do; every file is written under another name and renamed when it is whole.

mod cells;
pub mod checkpoint;
pub mod export;
pub mod grid;
pub mod image;
pub mod index_file;
pub mod measured;
pub mod mesh;
pub mod mitsuba;
pub mod netcdf;
pub mod output;
pub mod paint;
pub mod plot;
pub mod quantity;
pub mod recipe;
pub mod rows;
pub mod rxt;
pub mod scene;
pub mod slab_file;
pub mod table;
#[cfg(test)]
mod testing;
pub mod tev;
mod text_error;

pub use text_error::{TextError, nearest_names};
