//! Two Henyey-Greenstein lobes, usually one forward and one backward.

use std::fmt;

use super::{HenyeyGreenstein, PhaseError};

/// `w HG(g1) + (1 - w) HG(g2)`.
///
/// | | |
/// |---|---|
/// | `weight` | share of the first lobe, 0 to 1 |
/// | `g1`, `g2` | asymmetries of the lobes, -1 < g < 1 |
///
/// Source: `kattawar1975`; the lobes are `henyey1941`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DoubleHenyeyGreenstein {
    weight: f64,
    first: HenyeyGreenstein,
    second: HenyeyGreenstein,
}

impl DoubleHenyeyGreenstein {
    /// # Errors
    /// [`PhaseError::Weight`] unless `0 <= weight <= 1`; [`PhaseError::Asymmetry`] as [`HenyeyGreenstein::new`].
    pub fn new(weight: f64, g1: f64, g2: f64) -> Result<Self, PhaseError> {
        if !(0.0..=1.0).contains(&weight) {
            return Err(PhaseError::Weight { weight });
        }
        Ok(Self { weight, first: HenyeyGreenstein::new(g1)?, second: HenyeyGreenstein::new(g2)? })
    }

    /// Share of the first lobe, and the asymmetries of the first and the second.
    pub fn parameters(&self) -> (f64, f64, f64) {
        (self.weight, self.first.asymmetry(), self.second.asymmetry())
    }

    /// Value in 1/sr at the scattering cosine `mu` in [-1, 1]. Also the density of [`Self::sample`] per solid angle.
    pub fn value(&self, mu: f64) -> f64 {
        self.weight * self.first.value(mu) + (1.0 - self.weight) * self.second.value(mu)
    }

    /// Scattering cosine in [-1, 1] for a uniform `xi` in [0, 1]: `xi` picks the lobe and what is left of it the
    /// cosine. Not monotone in `xi`.
    pub fn sample(&self, xi: f64) -> f64 {
        let (first, xi) = pick(self.weight, xi);
        if first { self.first.sample(xi) } else { self.second.sample(xi) }
    }

    /// Mean cosine.
    pub fn asymmetry(&self) -> f64 {
        self.legendre_moment(1)
    }

    /// Moment of the Legendre polynomial of the given degree.
    pub fn legendre_moment(&self, degree: u32) -> f64 {
        self.weight * self.first.legendre_moment(degree) + (1.0 - self.weight) * self.second.legendre_moment(degree)
    }
}

impl fmt::Display for DoubleHenyeyGreenstein {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (weight, g1, g2) = self.parameters();
        write!(f, "double Henyey-Greenstein (w = {weight}, g1 = {g1}, g2 = {g2})")
    }
}

/// Whether `xi` falls to the first of two lobes, of the given share, and `xi` stretched to be used again.
pub(super) fn pick(share: f64, xi: f64) -> (bool, f64) {
    if xi < share || share >= 1.0 { (true, xi / share) } else { (false, (xi - share) / (1.0 - share)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phase::testing;

    #[test]
    fn is_a_phase_function_at_its_corners() {
        for (w, g1, g2) in
            [(0.0, 0.5, -0.5), (1.0, 0.999, 0.0), (0.9, 0.95, -0.4), (0.3, 0.999, -0.999), (0.5, 0.0, 0.0)]
        {
            let phase = DoubleHenyeyGreenstein::new(w, g1, g2).unwrap().into();
            testing::check(&phase);
            testing::check_inverse(&phase, &[w]);
        }
    }

    #[test]
    fn a_lone_lobe_is_henyey_greenstein() {
        let hg = HenyeyGreenstein::new(0.7).unwrap();
        let double = DoubleHenyeyGreenstein::new(1.0, 0.7, -0.2).unwrap();
        for i in 0..=100 {
            let xi = f64::from(i) / 100.0;
            assert_eq!(double.value(2.0 * xi - 1.0), hg.value(2.0 * xi - 1.0));
            assert_eq!(double.sample(xi), hg.sample(xi));
        }
    }

    #[test]
    fn parameters_out_of_range_are_refused() {
        for weight in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
            assert!(matches!(DoubleHenyeyGreenstein::new(weight, 0.0, 0.0), Err(PhaseError::Weight { .. })));
        }
        assert_eq!(DoubleHenyeyGreenstein::new(0.5, 0.0, 1.0), Err(PhaseError::Asymmetry { g: 1.0 }));
    }
}
