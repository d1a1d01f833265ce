//! Random numbers: a function of seed, pixel and sample alone, whoever computes them.

mod exponential;
mod pixel;
mod turn;

pub use exponential::Exponential;
pub use pixel::PixelSampler;
pub(crate) use pixel::{mix, uniform};
pub use turn::Turn;
