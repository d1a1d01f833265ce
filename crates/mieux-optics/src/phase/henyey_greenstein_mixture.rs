//! Any number of Henyey-Greenstein lobes.

use std::fmt;

use super::{HenyeyGreenstein, PhaseError};

/// A sum of Henyey-Greenstein lobes, each with a share; the shares are scaled to sum to 1.
///
/// Source: `kattawar1975` for the idea; the lobes are `henyey1941`.
#[derive(Debug, Clone, PartialEq)]
pub struct HenyeyGreensteinMixture {
    lobes: Vec<HenyeyGreenstein>,
    shares: Vec<f64>,
    /// Where in [0, 1] the share of each lobe ends.
    ends: Vec<f64>,
}

impl HenyeyGreensteinMixture {
    /// From pairs of a weight (finite, not negative, any scale) and an asymmetry.
    ///
    /// # Errors
    /// [`PhaseError::NoLobes`]; [`PhaseError::Weight`] for a weight out of range or a sum that is zero or overflows;
    /// [`PhaseError::Asymmetry`] as [`HenyeyGreenstein::new`].
    pub fn new(weights_and_asymmetries: &[(f64, f64)]) -> Result<Self, PhaseError> {
        if weights_and_asymmetries.is_empty() {
            return Err(PhaseError::NoLobes);
        }
        let mut lobes = Vec::with_capacity(weights_and_asymmetries.len());
        let mut sum = 0.0;
        for &(weight, g) in weights_and_asymmetries {
            if !(weight >= 0.0 && weight.is_finite()) {
                return Err(PhaseError::Weight { weight });
            }
            sum += weight;
            lobes.push(HenyeyGreenstein::new(g)?);
        }
        if !(sum > 0.0 && sum.is_finite()) {
            return Err(PhaseError::Weight { weight: sum });
        }
        let shares: Vec<f64> = weights_and_asymmetries.iter().map(|(weight, _)| weight / sum).collect();
        let mut end = 0.0;
        let ends = shares
            .iter()
            .map(|share| {
                end += share;
                end
            })
            .collect();
        Ok(Self { lobes, shares, ends })
    }

    /// The lobes, each with its share of the scattered light.
    pub fn lobes(&self) -> impl ExactSizeIterator<Item = (f64, HenyeyGreenstein)> + '_ {
        self.shares.iter().copied().zip(self.lobes.iter().copied())
    }

    /// Value in 1/sr at the scattering cosine `mu` in [-1, 1]. Also the density of [`Self::sample`] per solid angle.
    pub fn value(&self, mu: f64) -> f64 {
        self.lobes().map(|(share, lobe)| share * lobe.value(mu)).sum()
    }

    /// Scattering cosine in [-1, 1] for a uniform `xi` in [0, 1]: `xi` picks the lobe and what is left of it the
    /// cosine. Not monotone in `xi`.
    pub fn sample(&self, xi: f64) -> f64 {
        // Rounding may leave the last end a hair below 1: the last lobe that has a share takes the rest.
        let last = self.shares.iter().rposition(|&share| share > 0.0).unwrap_or(0);
        let lobe = self.ends.partition_point(|&end| end <= xi).min(last);
        let start = if lobe == 0 { 0.0 } else { self.ends[lobe - 1] };
        self.lobes[lobe].sample(((xi - start) / self.shares[lobe]).clamp(0.0, 1.0))
    }

    /// Mean cosine.
    pub fn asymmetry(&self) -> f64 {
        self.legendre_moment(1)
    }

    /// Moment of the Legendre polynomial of the given degree.
    pub fn legendre_moment(&self, degree: u32) -> f64 {
        self.lobes().map(|(share, lobe)| share * lobe.legendre_moment(degree)).sum()
    }
}

impl fmt::Display for HenyeyGreensteinMixture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Henyey-Greenstein mixture (")?;
        for (i, (share, lobe)) in self.lobes().enumerate() {
            let comma = if i == 0 { "" } else { ", " };
            write!(f, "{comma}{share} of g = {}", lobe.asymmetry())?;
        }
        f.write_str(")")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phase::testing;

    #[test]
    fn is_a_phase_function_at_its_corners() {
        let lobes = [
            vec![(1.0, 0.0)],
            vec![(2.0, 0.999), (0.0, 0.3), (1.0, -0.999)],
            vec![(0.0, 0.5), (0.1, 0.1), (0.2, 0.9), (0.3, -0.6), (0.0, 0.0)],
        ];
        for lobes in lobes {
            let phase = HenyeyGreensteinMixture::new(&lobes).unwrap();
            let ends = phase.ends.clone();
            testing::check(&phase.clone().into());
            testing::check_inverse(&phase.into(), &ends);
        }
    }

    #[test]
    fn two_lobes_are_the_double_function() {
        let many = HenyeyGreensteinMixture::new(&[(3.0, 0.8), (1.0, -0.3)]).unwrap();
        let double = crate::phase::DoubleHenyeyGreenstein::new(0.75, 0.8, -0.3).unwrap();
        for i in 0..=100 {
            let xi = f64::from(i) / 100.0;
            assert!((many.value(2.0 * xi - 1.0) / double.value(2.0 * xi - 1.0) - 1.0).abs() < 1e-14);
            assert!((many.sample(xi) - double.sample(xi)).abs() < 1e-13);
        }
        assert!((many.asymmetry() - (0.75 * 0.8 - 0.25 * 0.3)).abs() < 1e-15);
    }

    #[test]
    fn parameters_out_of_range_are_refused() {
        assert_eq!(HenyeyGreensteinMixture::new(&[]), Err(PhaseError::NoLobes));
        assert_eq!(HenyeyGreensteinMixture::new(&[(0.0, 0.5)]), Err(PhaseError::Weight { weight: 0.0 }));
        assert!(HenyeyGreensteinMixture::new(&[(f64::NAN, 0.5)]).is_err());
        assert!(HenyeyGreensteinMixture::new(&[(f64::MAX, 0.5), (f64::MAX, 0.5)]).is_err());
        assert!(HenyeyGreensteinMixture::new(&[(-1.0, 0.5), (2.0, 0.5)]).is_err());
        assert!(HenyeyGreensteinMixture::new(&[(1.0, -1.0)]).is_err());
    }
}
