//! The RGB fit to milk that `frisvad2007` prints (eq 39-46), kept to compare with.
//!
//! Its bands are averages by the Stiles-Burch 1959 functions over samples every 25 nm, `g` weighted by `sigma_s`
//! ([`crate::spectrum::ColourMatching::average`]). The computed milk meets it within a few percent.

use crate::material::{Input, MaterialError};

/// Optical properties in the three bands red, green, blue.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MilkFit {
    /// Scattering coefficient, 1/m.
    pub sigma_s: [f64; 3],
    /// Absorption coefficient, 1/m.
    pub sigma_a: [f64; 3],
    /// Mean cosine.
    pub asymmetry: [f64; 3],
}

/// Scattering coefficient per weight percent of protein, 1/m.
const PROTEIN_SCATTERING: [f64; 3] = [213.5, 338.3, 614.0];
/// Mean cosine times scattering coefficient per weight percent of protein, 1/m.
const PROTEIN_FORWARD: [f64; 3] = [18.63, 37.79, 96.69];

/// The published fit at the given fat and protein in weight percent.
///
/// # Errors
/// [`MaterialError::InputRange`] when a content is negative or not finite, or both are zero (nothing scatters, and the
/// fit has no asymmetry to give).
pub fn published_fit(fat: f64, protein: f64) -> Result<MilkFit, MaterialError> {
    let positive = if fat == 0.0 { f64::MIN_POSITIVE } else { 0.0 };
    let limits = |name: &'static str, minimum| Input {
        name: name.into(),
        unit: "wt.-%".into(),
        default: 0.0,
        minimum,
        maximum: 100.0,
        about: "".into(),
    };
    limits("fat", 0.0).check(fat)?;
    limits("protein", positive).check(protein)?;

    let log_fat = if fat > 0.0 { fat.ln() } else { 0.0 };
    let forward = fat_asymmetry(fat);
    let absorption = [(1.381, -0.008600, 1.209), (2.201, -0.01459, 1.982), (10.13, -0.07048, 4.170)];
    let scattering = [(15631.0, 1.24), (18349.0, 1.15), (22585.0, 1.01)];
    let h1 = [(-0.00129, 0.0305, -0.219), (-0.00149, 0.0327, -0.213), (-0.00206, 0.0373, -0.202)];

    let mut fit = MilkFit { sigma_s: [0.0; 3], sigma_a: [0.0; 3], asymmetry: [0.0; 3] };
    for c in 0..3 {
        let (constant, by_protein, by_fat) = absorption[c];
        fit.sigma_a[c] = constant + by_protein * protein + by_fat * fat;
        let (factor, power) = scattering[c];
        let (x4, x3, x2) = h1[c];
        let x = log_fat;
        let from_fat = factor * fat.powf(power) * (x4 * x.powi(4) + x3 * x.powi(3) + x2 * x * x).exp();
        fit.sigma_s[c] = PROTEIN_SCATTERING[c] * protein + from_fat;
        fit.asymmetry[c] = (PROTEIN_FORWARD[c] * protein + from_fat * forward[c]) / fit.sigma_s[c];
    }
    Ok(fit)
}

/// Mean cosine of the fat alone: two pieces that meet at 0.7 wt.-%; 0 without fat.
fn fat_asymmetry(fat: f64) -> [f64; 3] {
    if fat == 0.0 {
        return [0.0; 3];
    }
    let (factors, cubic) = if fat < 0.7 {
        (
            [(0.9523, -0.0120), (0.9539, -0.00783), (0.9554, -0.000161)],
            [(-0.0386, -0.00543), (-0.0368, 0.00266), (-0.0334, 0.0111)],
        )
    } else {
        (
            [(0.9576, 0.00911), (0.9585, 0.00783), (0.9577, 0.00531)],
            [(0.000281, -0.00366), (0.000379, -0.00401), (0.000509, -0.00429)],
        )
    };
    let x = if fat < 0.7 { -fat.ln() } else { fat.ln() };
    std::array::from_fn(|c| {
        let ((factor, power), (x3, x2)) = (factors[c], cubic[c]);
        factor * fat.powf(power) * (x3 * x.powi(3) + x2 * x * x).exp()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Protein alone: the fit is linear and can be read off the equations.
    #[test]
    fn protein_alone_is_linear() {
        let fit = published_fit(0.0, 2.0).unwrap();
        assert_eq!(fit.sigma_s, [427.0, 676.6, 1228.0]);
        assert!((fit.asymmetry[2] - 96.69 / 614.0).abs() < 1e-15);
        assert!((fit.sigma_a[0] - (1.381 - 0.0172)).abs() < 1e-12);
    }

    /// At 1 wt.-% of fat every logarithm vanishes.
    #[test]
    fn one_percent_of_fat_leaves_the_factors() {
        let fit = published_fit(1.0, 0.0).unwrap();
        assert_eq!(fit.sigma_s, [15631.0, 18349.0, 22585.0]);
        for (g, expected) in fit.asymmetry.into_iter().zip([0.9576, 0.9585, 0.9577]) {
            assert!((g - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn what_the_fit_cannot_say_is_refused() {
        assert!(published_fit(-0.1, 3.0).is_err());
        assert!(published_fit(1.0, f64::NAN).is_err());
        assert!(published_fit(0.0, 0.0).is_err());
    }
}
