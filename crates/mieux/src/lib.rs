//! The one door to `mieux`: the libraries, and the jobs that every front end runs.

pub mod jobs;

pub use mieux_io as io;
pub use mieux_optics as optics;
pub use mieux_render as render;
