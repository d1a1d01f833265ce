//! How far two phase functions are apart.

use std::f64::consts::PI;

use super::{PhaseFunction, quadrature};

/// Values below this, in 1/sr, are taken for it where logarithms are compared: a zero would be infinitely far.
pub(super) const FLOOR: f64 = 1e-12;

/// What [`compare`] finds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// Root mean square over solid angle of the difference of the decimal logarithms of the values.
    pub rms_log10: f64,
    /// The largest difference of the decimal logarithms, over the nodes of the quadrature.
    pub max_log10: f64,
    /// Mean cosine of the second less that of the first.
    pub delta_asymmetry: f64,
    /// Total variation distance: the share of the light, 0 to 1, that goes elsewhere; `1/2 Int |a - b|`.
    pub total_variation: f64,
}

/// Compares two phase functions over the sphere, by quadrature between the edges of both. Logarithms see values of at
/// least 1e-12 per sr.
pub fn compare(a: &PhaseFunction, b: &PhaseFunction) -> Comparison {
    let edges = quadrature::merge_edges(&a.edges(), &b.edges());
    let (mut squares, mut max_log10, mut variation) = (0.0, 0.0f64, 0.0);
    quadrature::visit(&edges, 0, |_, away, weight| {
        let (p, q) = (a.value_away(away), b.value_away(away));
        let apart = (q.max(FLOOR) / p.max(FLOOR)).log10();
        squares += weight * apart * apart;
        max_log10 = max_log10.max(apart.abs());
        variation += weight * (p - q).abs();
    });
    Comparison {
        rms_log10: (squares / (4.0 * PI)).sqrt(),
        max_log10,
        delta_asymmetry: b.asymmetry() - a.asymmetry(),
        total_variation: 0.5 * variation,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phase::{Draine, HenyeyGreenstein, Isotropic, Rayleigh, Tabulated};

    #[test]
    fn what_is_the_same_is_not_apart() {
        let draine: PhaseFunction = Draine::new(0.9, 0.0).unwrap().into();
        let hg: PhaseFunction = HenyeyGreenstein::new(0.9).unwrap().into();
        let apart = compare(&draine, &hg);
        assert!(apart.rms_log10 < 1e-14 && apart.max_log10 < 1e-14 && apart.total_variation < 1e-14);
        assert_eq!(apart.delta_asymmetry, 0.0);
    }

    /// Rayleigh against isotropic by hand: `|3(1 + mu^2)/16 - 1/4| = |3 mu^2 - 1|/16`, whose integral over mu from -1
    /// to 1, times `2 pi / (2 pi)`, halved, is `1/(6 sqrt 3)`.
    #[test]
    fn the_distance_is_the_one_found_by_hand() {
        let apart = compare(&Isotropic.into(), &Rayleigh.into());
        let by_hand = 1.0 / (6.0 * 3f64.sqrt());
        assert!((apart.total_variation - by_hand).abs() < 1e-4, "{} {by_hand}", apart.total_variation);
        assert!((apart.max_log10 - 0.75f64.log10().abs().max(1.5f64.log10())).abs() < 1e-3);
        let back = compare(&Rayleigh.into(), &Isotropic.into());
        assert_eq!(back.rms_log10, apart.rms_log10);
        let lobes = |g| HenyeyGreenstein::new(g).unwrap().into();
        let apart = compare(&lobes(0.999), &lobes(-0.999));
        assert!(apart.total_variation > 0.99 && apart.total_variation <= 1.0);
        assert!((apart.delta_asymmetry + 1.998).abs() < 1e-12);
    }

    #[test]
    fn an_empty_bin_is_far_but_not_infinitely() {
        let angles = vec![0.0, 0.5 * PI, PI];
        let half: PhaseFunction = Tabulated::new(angles, vec![1.0, 0.0, 0.0]).unwrap().into();
        let apart = compare(&half, &Isotropic.into());
        assert!(apart.rms_log10.is_finite() && (apart.max_log10 - (0.25 / PI / FLOOR).log10()).abs() < 1e-9);
    }
}
