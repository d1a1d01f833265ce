//! Light through plane-parallel matter.
//!
//! # Conventions
//! - Optical depth grows downward from the top; `+` is down, `-` is up; cosines are against the normal and positive.
//! - Phase functions integrate to 1 over the sphere; `chi_l` is the mean of `P_l`, so `chi_0 = 1` and `chi_1 = g`.
//! - A source of strength 1 falls onto the *horizontal* unless said otherwise; shares are of what falls in.
//! - Planes between layers of different index refract and reflect (Fresnel, unpolarised, incoherent).

mod adding_doubling;
pub mod beer_lambert;
pub mod diffusion;
mod discrete_ordinates;
mod error;
pub mod fresnel;
pub mod inverse;
pub mod kubelka_munk;
mod moments;
mod stack;
mod streams;

pub use adding_doubling::AddingDoubling;
pub use discrete_ordinates::{DiscreteOrdinates, Fluxes, Light, Place, Radiances, Views};
pub use error::TransferError;
pub use moments::{MAX_MOMENTS, Moments};
pub use stack::{Ground, Incidence, Layer, Shares, Stack};
