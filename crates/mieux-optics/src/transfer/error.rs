//! What can be wrong with a question about the transfer of light.

/// Why a slab, a source, or a solver's settings were refused. Carries the offending value.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TransferError {
    /// An optical thickness must be finite and not negative.
    #[error("layer {layer}: the optical thickness {value} is not a finite number from 0 up")]
    OpticalThickness {
        /// Of which layer, from 0 at the top.
        layer: usize,
        /// The offending value.
        value: f64,
    },
    /// A single-scattering albedo must lie in [0, 1].
    #[error("layer {layer}: the albedo {value} is not between 0 and 1")]
    Albedo {
        /// Of which layer, from 0 at the top.
        layer: usize,
        /// The offending value.
        value: f64,
    },
    /// A refractive index must be positive and finite.
    #[error("the refractive index {value} is not between 0.1 and 10")]
    RefractiveIndex {
        /// The offending value.
        value: f64,
    },
    /// The mean cosine must lie strictly between -1 and 1.
    #[error("asymmetry g = {g} is not between -1 and 1 (both excluded)")]
    Asymmetry {
        /// The offending value.
        g: f64,
    },
    /// The moments are not those of a phase function.
    #[error(
        "{value} cannot be the Legendre moment of degree {degree} of a phase function: the first is 1, all lie in \
         [-1, 1], and the second is at least (3 g^2 - 1)/2"
    )]
    Moment {
        /// The degree, from 0.
        degree: usize,
        /// The offending value.
        value: f64,
    },
    /// The reflectance of what lies below must lie in [0, 1].
    #[error("the reflectance {value} of the ground is not between 0 and 1")]
    Ground {
        /// The offending value.
        value: f64,
    },
    /// Discrete ordinates need an even number of streams.
    #[error("{streams} streams: an even number from 2 to 256 is needed")]
    Streams {
        /// The offending number.
        streams: usize,
    },
    /// The cosine of a direction must lie in (0, 1]; of light that may rise, in [-1, 1] but not at 0.
    #[error("the cosine {value} of a direction is 0, not a number, or beyond 1")]
    Cosine {
        /// The offending value.
        value: f64,
    },
    /// An azimuth is a finite angle.
    #[error("the azimuth {value} is not a finite angle")]
    Azimuth {
        /// The offending value, rad.
        value: f64,
    },
    /// Irradiances and radiances are finite and not negative.
    #[error("a source of strength {value} is not a finite number from 0 up")]
    Source {
        /// The offending value.
        value: f64,
    },
    /// A depth lies within the stack.
    #[error("the depth {value} (optical thickness in layer {layer}) lies outside the stack")]
    Depth {
        /// Layer asked for.
        layer: usize,
        /// The offending optical depth in it.
        value: f64,
    },
    /// A coefficient must be finite and not negative, and a medium must do something to light.
    #[error("the {what} coefficient {value} 1/m is not a finite number from 0 up, or leaves nothing to meet light")]
    Coefficient {
        /// Of what.
        what: &'static str,
        /// The offending value, 1/m.
        value: f64,
    },
    /// Diffusion needs room for one transport mean free path.
    #[error("a slab {value} m thick is thinner than one transport mean free path of {least} m, or endless")]
    Thickness {
        /// The offending value, m.
        value: f64,
        /// The least possible, m.
        least: f64,
    },
    /// A profile to be sampled must be positive somewhere.
    #[error("nothing comes back from a medium that does not scatter: there is nothing to sample or rescale")]
    Dark,
    /// The moments give a phase function so negative that light would be created.
    #[error("layer {layer}: with {streams} streams the phase function of these moments has no physical answer")]
    NotAPhaseFunction {
        /// Of which layer, from 0 at the top.
        layer: usize,
        /// Streams asked for.
        streams: usize,
    },
}
