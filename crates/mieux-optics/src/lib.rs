//! What a material does to light.
//!
//! From what a material is made of (substances, particles and their sizes, amounts) to its spectral optical
//! properties: coefficients of scattering and absorption, phase functions, refractive index.
//! Pure `f64` mathematics in SI units; nothing here touches a file, prints, or looks at a clock.
//!
//! # Conventions
//! - Lengths in metres, coefficients in 1/m, wavelengths in vacuum, temperatures in degrees Celsius where named so.
//! - Time factor `exp(-i w t)`: a refractive index is `n' + i n''`, and `n'' >= 0` absorbs.
//! - `cos(theta) = 1` is forward. Phase functions integrate to 1 over the sphere.
//! - Every quantity is spectral; RGB appears in [`spectrum::colour`] alone.
//!
//! Sources are named by their keys in `references.bib`.

pub mod material;
pub mod medium;
pub mod mie;
pub mod paint;
pub mod particle;
pub mod phase;
pub mod spectrum;
pub mod substance;
pub mod transfer;

mod integrate;
mod lanes;
mod levenberg_marquardt;

pub use num_complex::Complex64;
