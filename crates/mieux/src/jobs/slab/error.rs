//! What makes no slab.

/// Settings of a slab that do not go together.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SlabError {
    /// Something that has no meaning beside something else.
    #[error("{what} has no meaning with {with}")]
    Meaningless {
        /// What was given.
        what: &'static str,
        /// With what.
        with: String,
    },
    /// Something that is missing.
    #[error("{what} is missing: {wanted}")]
    Missing {
        /// What it is.
        what: &'static str,
        /// What would do.
        wanted: &'static str,
    },
    /// A file of layers without a place for the material.
    #[error(
        "none of the layers in `{layers}` is {material}: give a layer with material = \"*\" where it goes, or leave it out"
    )]
    NoPlace {
        /// The file.
        layers: String,
        /// The material.
        material: String,
    },
    /// A half-space with something below it.
    #[error("only the last layer can be endless, and layer {layer} of {layers} would be")]
    EndlessAbove {
        /// Number of the layer, from 1 at the top.
        layer: usize,
        /// How many there are.
        layers: usize,
    },
    /// Moments of a function that photons cannot follow.
    #[error(
        "the phase function of these moments is negative at {angle_deg} degrees, and photons cannot be scattered by less \
         than nothing; discrete ordinates can work with it"
    )]
    NegativePhase {
        /// Scattering angle, degrees.
        angle_deg: f64,
    },
}
