//! Named models of materials with a few inputs that people know, and the media they stand for.

pub mod milk;

use std::borrow::Cow;

use crate::medium::MediumError;
use crate::particle::ParticleError;

/// One input of a model: what it is called, what it means, what it may be.
#[derive(Debug, Clone, PartialEq)]
pub struct Input {
    /// Name, as used on the command line and in recipes.
    pub name: Cow<'static, str>,
    /// Unit, as shown to people.
    pub unit: Cow<'static, str>,
    /// Value taken when none is given.
    pub default: f64,
    /// Smallest value accepted.
    pub minimum: f64,
    /// Largest value accepted.
    pub maximum: f64,
    /// What it means, in one line.
    pub about: Cow<'static, str>,
}

impl Input {
    /// A value with its unit, as people write it.
    pub fn shown(&self, value: f64) -> String {
        format!("{value} {}", self.unit).trim_end().to_owned()
    }

    /// The value, if it may be.
    ///
    /// # Errors
    /// [`MaterialError::InputRange`].
    pub fn check(&self, value: f64) -> Result<f64, MaterialError> {
        if value >= self.minimum && value <= self.maximum {
            Ok(value)
        } else {
            Err(MaterialError::InputRange { input: Box::new(self.clone()), value })
        }
    }
}

/// Why a model cannot be made into a medium.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MaterialError {
    /// An input outside its range.
    #[error("{} = {} is out of range: {} to {}", input.name, input.shown(*value), input.minimum, input.shown(input.maximum))]
    InputRange {
        /// The input.
        input: Box<Input>,
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
