//! Two fluxes, one down and one up, in a film that absorbs and scatters (`kubelka1931`, `kubelka1948`).
//!
//! # What K and S are
//! The share of a *diffuse* flux through the horizontal that is absorbed, and sent the other way, per length. Diffuse light
//! goes twice as far as the film is deep, so `K = 2 sigma_a`, and with `S = 3/4 sigma_s (1 - g)` the answer for thick matter
//! tends to that of diffusion theory as absorption goes to 0 ([`Film::of_medium`]). Textbooks that find `K = sigma_a` and
//! `S = sigma_s / 2` for isotropic scattering count radiance along its own way where the flux through the horizontal is
//! meant, which holds for light that travels straight up and down only. [`Film::along_the_normal`] is that pair;
//! for diffuse light on paint its K is half, and its S two thirds, of what is needed.
//!
//! # What it leaves out
//! Light that is not diffuse, and the surface: see [`Saunderson`] for the latter. [`shares`] answers for whole stacks.

mod film;
mod hiding;
mod ladder;
mod measure;
mod saunderson;
mod two_flux;

pub use film::{Film, mix};
pub use hiding::{Chart, thickness_for};
pub use ladder::{Ladder, LadderFit, Rung};
pub use measure::{from_infinite_and_one, from_two_backings, from_two_thicknesses};
pub use saunderson::Saunderson;
pub use two_flux::shares;

/// Why a film or a measurement was refused. Carries the offending value.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum KubelkaMunkError {
    /// Coefficients, thicknesses and concentrations are finite and not negative.
    #[error("the {quantity} {value} is not a finite number from 0 up")]
    Negative {
        /// Which.
        quantity: &'static str,
        /// The offending value, SI.
        value: f64,
    },
    /// A measured reflectance lies strictly between 0 and 1.
    #[error("the {quantity} {value} is not between 0 and 1 (both excluded); percent are to be divided by 100")]
    Reflectance {
        /// Which.
        quantity: &'static str,
        /// The offending value.
        value: f64,
    },
    /// A sample that is darker than its surface alone.
    #[error(
        "the reflectance {value} is not above the {surface} that the surface alone sends to the instrument; is its specular \
         component excluded?"
    )]
    DarkerThanSurface {
        /// The offending value.
        value: f64,
        /// What the surface reflects.
        surface: f64,
    },
    /// A share lies in [0, 1].
    #[error("the {quantity} {value} is not between 0 and 1")]
    Share {
        /// Which.
        quantity: &'static str,
        /// The offending value.
        value: f64,
    },
    /// The index of a binder.
    #[error("the refractive index {value} is not between 1 and 10")]
    RefractiveIndex {
        /// The offending value.
        value: f64,
    },
    /// Readings that no film has.
    #[error("no film that absorbs and scatters has these readings: {why}")]
    NoFilm {
        /// What contradicts.
        why: &'static str,
    },
    /// A film that never hides what is below.
    #[error("no thickness hides to a contrast ratio of {wanted}: it tends to {reached} at most")]
    NeverHides {
        /// The ratio asked for.
        wanted: f64,
        /// The highest there is.
        reached: f64,
    },
    /// Too few readings for the unknowns.
    #[error("{found} readings for {unknowns} unknowns; at least {unknowns} different ones are needed")]
    TooFew {
        /// How many there are.
        found: usize,
        /// What is to be found.
        unknowns: usize,
    },
}

fn natural(quantity: &'static str, value: f64) -> Result<f64, KubelkaMunkError> {
    if value >= 0.0 && value.is_finite() { Ok(value) } else { Err(KubelkaMunkError::Negative { quantity, value }) }
}

fn share(quantity: &'static str, value: f64) -> Result<f64, KubelkaMunkError> {
    if (0.0..=1.0).contains(&value) { Ok(value) } else { Err(KubelkaMunkError::Share { quantity, value }) }
}

fn measured(quantity: &'static str, value: f64) -> Result<f64, KubelkaMunkError> {
    if value > 0.0 && value < 1.0 { Ok(value) } else { Err(KubelkaMunkError::Reflectance { quantity, value }) }
}
