//! Phase functions: how scattered light spreads over angle. `cos(theta) = 1` is forward; the integral over the sphere is 1.

mod henyey_greenstein;

pub use henyey_greenstein::HenyeyGreenstein;

/// What can be wrong with the parameters of a phase function.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PhaseError {
    /// The asymmetry must lie strictly between -1 and 1.
    #[error("asymmetry g = {g} is not between -1 and 1 (both excluded)")]
    Asymmetry {
        /// The offending value.
        g: f64,
    },
}
