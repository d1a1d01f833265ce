//! What a camera sees: spectral volumetric path tracing of refracting, scattering bodies.
//!
//! A [`scene::Scene`] in memory goes in, a [`film::Film`] in memory comes out ([`render::render`]). Nothing here
//! touches a file, prints, or looks at a clock: when to stop for time is decided by the caller's sink.
//!
//! # Conventions
//! - Lengths in metres, coefficients in 1/m, wavelengths in vacuum. `z` is up. Directions are unit vectors.
//! - `cos(theta) = 1` is forward. Rays run from the camera towards the light.
//! - A path carries radiance divided by the square of the refractive index, `L / n^2`, which refraction leaves
//!   unchanged (`frisvad2012`, eq 4.2). The light divides by the square of the index around it, the camera multiplies
//!   by the square of the index it stands in; nothing in between has to know.
//! - A path holds four wavelengths: the hero, by which it is sampled, and three companions (`wilkie2014`).
//! - The same seed gives the same bits, whatever the number of threads and however often a render was interrupted.
//!
//! Sources are named by their keys in `references.bib`.

pub mod camera;
pub mod detector;
pub mod film;
pub mod geometry;
pub mod integrator;
pub mod light;
pub mod medium;
pub mod render;
pub mod sampler;
pub mod scene;
pub mod surface;

pub use glam::DVec3;
