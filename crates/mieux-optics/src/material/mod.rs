//! Named models of materials with a few inputs that people know, and the media they stand for.

pub mod milk;

use crate::medium::MediumError;
use crate::particle::ParticleError;

/// One input of a model: what it is called, what it means, what it may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Input {
    /// Name, as used on the command line and in recipes.
    pub name: &'static str,
    /// Unit, as shown to people.
    pub unit: &'static str,
    /// Value taken when none is given.
    pub default: f64,
    /// Smallest value accepted.
    pub minimum: f64,
    /// Largest value accepted.
    pub maximum: f64,
    /// What it means, in one line.
    pub about: &'static str,
}

impl Input {
    /// The value, if it may be.
    ///
    /// # Errors
    /// [`MaterialError::InputRange`].
    pub fn check(&self, value: f64) -> Result<f64, MaterialError> {
        if value >= self.minimum && value <= self.maximum {
            Ok(value)
        } else {
            Err(MaterialError::InputRange { input: *self, value })
        }
    }
}

/// Why a model cannot be made into a medium.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MaterialError {
    /// An input outside its range.
    #[error(
        "{} = {value} {} is out of range: {} to {} {}",
        input.name, input.unit, input.minimum, input.maximum, input.unit
    )]
    InputRange {
        /// The input.
        input: Input,
        /// What was given.
        value: f64,
    },
    /// The sizes that follow from the inputs are impossible.
    #[error(transparent)]
    Particle(#[from] ParticleError),
    /// The medium that follows from the inputs is impossible.
    #[error(transparent)]
    Medium(#[from] MediumError),
}
