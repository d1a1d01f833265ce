//! What can be wrong with the parameters of a phase function.

/// Why a phase function, a table of one, or a fit of one was refused. Carries the offending value.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PhaseError {
    /// The asymmetry must lie strictly between -1 and 1.
    #[error("asymmetry g = {g} is not between -1 and 1 (both excluded)")]
    Asymmetry {
        /// The offending value.
        g: f64,
    },
    /// The weight of a lobe must lie in [0, 1] (of many lobes: be finite, not negative, and not all zero).
    #[error("a lobe cannot have the weight {weight}: weights are not negative, and sum to something positive")]
    Weight {
        /// The offending value.
        weight: f64,
    },
    /// A mixture needs at least one lobe.
    #[error("a mixture needs at least one lobe")]
    NoLobes,
    /// Draine's second parameter must be finite and not negative.
    #[error("Draine's alpha = {alpha} is not a finite number from 0 up")]
    Alpha {
        /// The offending value.
        alpha: f64,
    },
    /// The fit for water droplets holds for diameters up to 50 micrometres.
    #[error("the droplet diameter {} um is not above 0 and at most 50 um", diameter_m * 1e6)]
    Diameter {
        /// The offending diameter, m.
        diameter_m: f64,
    },
    /// Fournier and Forand's relative refractive index must lie in (1, 2].
    #[error("the relative refractive index {refractive_index} is not above 1 and at most 2")]
    RefractiveIndex {
        /// The offending value.
        refractive_index: f64,
    },
    /// The Junge slope must lie strictly between 3 and 5.
    #[error("the Junge slope {slope} is not between 3 and 5 (both excluded)")]
    JungeSlope {
        /// The offending value.
        slope: f64,
    },
    /// No Junge slope gives this share of backward scattering.
    #[error("the backscatter fraction {fraction} is not one that this refractive index can give, between 0 and 1/2")]
    BackscatterFraction {
        /// The offending value.
        fraction: f64,
    },
    /// A table needs as many values as angles, and at least two.
    #[error("{angles} angles and {values} values make no table: as many of each are needed, and at least two")]
    TableLength {
        /// Number of angles.
        angles: usize,
        /// Number of values.
        values: usize,
    },
    /// Angles must rise strictly from 0 to pi, far enough apart for their cosines to differ.
    #[error("angle number {index}, {theta_rad} rad, breaks the order: angles rise strictly from 0 to pi")]
    Angle {
        /// Position in the table, from 0.
        index: usize,
        /// The offending angle, rad.
        theta_rad: f64,
    },
    /// A tabulated value must be finite and not negative.
    #[error("the value {value} at the angle {theta_rad} rad is not a finite number from 0 up")]
    AngleValue {
        /// Where, rad.
        theta_rad: f64,
        /// What was found there.
        value: f64,
    },
    /// The integral over the sphere is zero, or so small that the normalised values overflow.
    #[error("the tabulated values integrate to {integral}, which cannot be normalised")]
    Integral {
        /// The integral over the sphere, relative to the largest value, sr.
        integral: f64,
    },
    /// A grid of angles must be asked for with positive finite figures, and not with millions of angles.
    #[error("{what} = {value} makes no grid of angles")]
    AngleGrid {
        /// Which figure.
        what: &'static str,
        /// The offending value.
        value: f64,
    },
    /// The function does not settle under quadrature between two angles.
    #[error("the function cannot be integrated between {from_rad} and {to_rad} rad")]
    NotIntegrable {
        /// Start of the bin, rad.
        from_rad: f64,
        /// End of the bin, rad.
        to_rad: f64,
    },
    /// Even the finest grid leaves 1 - g less certain than was asked for.
    #[error("the table knows 1 - g to {reached:e} of itself, but {wanted:e} was asked for")]
    Tolerance {
        /// The estimated relative error of 1 - g on the finest grid.
        reached: f64,
        /// The tolerance asked for.
        wanted: f64,
    },
    /// A spectral phase function needs one phase function per wavelength.
    #[error("{wavelengths} wavelengths but {functions} phase functions")]
    SpectralLength {
        /// Number of wavelengths.
        wavelengths: usize,
        /// Number of phase functions.
        functions: usize,
    },
}
