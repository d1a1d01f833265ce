//! A Henyey-Greenstein lobe and a Draine lobe: the form of the fits to Lorenz-Mie scattering.

use std::fmt;

use super::double_henyey_greenstein::pick;
use super::{Draine, HenyeyGreenstein, PhaseError};

/// `(1 - w) HG(g_hg) + w Draine(g_d, alpha)`.
///
/// | | |
/// |---|---|
/// | `draine_weight` | share of Draine's lobe, 0 to 1 |
/// | `g_hg`, `g_d` | parameters of the lobes, -1 < g < 1 |
/// | `alpha` | weight of Draine's Rayleigh factor, finite and not negative |
///
/// Source: eq 1 of `jendersie2023s`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HenyeyGreensteinDraine {
    draine_weight: f64,
    hg: HenyeyGreenstein,
    draine: Draine,
}

impl HenyeyGreensteinDraine {
    /// # Errors
    /// [`PhaseError::Weight`] unless `0 <= draine_weight <= 1`, else as [`HenyeyGreenstein::new`] and [`Draine::new`].
    pub fn new(draine_weight: f64, g_hg: f64, g_d: f64, alpha: f64) -> Result<Self, PhaseError> {
        if !(0.0..=1.0).contains(&draine_weight) {
            return Err(PhaseError::Weight { weight: draine_weight });
        }
        Ok(Self { draine_weight, hg: HenyeyGreenstein::new(g_hg)?, draine: Draine::new(g_d, alpha)? })
    }

    /// Share of Draine's lobe.
    pub fn draine_weight(&self) -> f64 {
        self.draine_weight
    }

    /// The Henyey-Greenstein lobe.
    pub fn henyey_greenstein(&self) -> HenyeyGreenstein {
        self.hg
    }

    /// Draine's lobe.
    pub fn draine(&self) -> Draine {
        self.draine
    }

    /// Value in 1/sr at the scattering cosine `mu` in [-1, 1]. Also the density of [`Self::sample`] per solid angle.
    pub fn value(&self, mu: f64) -> f64 {
        (1.0 - self.draine_weight) * self.hg.value(mu) + self.draine_weight * self.draine.value(mu)
    }

    /// Scattering cosine in [-1, 1] for a uniform `xi` in [0, 1]: Draine's lobe below its weight, else
    /// Henyey-Greenstein's, and what is left of `xi` gives the cosine. Not monotone in `xi`.
    pub fn sample(&self, xi: f64) -> f64 {
        let (draine, xi) = pick(self.draine_weight, xi);
        if draine { self.draine.sample(xi) } else { self.hg.sample(xi) }
    }

    /// Mean cosine.
    pub fn asymmetry(&self) -> f64 {
        (1.0 - self.draine_weight) * self.hg.asymmetry() + self.draine_weight * self.draine.asymmetry()
    }

    /// Moment of the Legendre polynomial of the given degree, in closed form.
    pub fn legendre_moment(&self, degree: u32) -> f64 {
        (1.0 - self.draine_weight) * self.hg.legendre_moment(degree)
            + self.draine_weight * self.draine.legendre_moment(degree)
    }
}

impl fmt::Display for HenyeyGreensteinDraine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (g_d, alpha) = self.draine.parameters();
        let (w, g) = (self.draine_weight, self.hg.asymmetry());
        write!(f, "Henyey-Greenstein + Draine (w_D = {w}, g_HG = {g}, g_D = {g_d}, alpha = {alpha})")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phase::testing;

    #[test]
    fn is_a_phase_function_at_its_corners() {
        for (w, g_hg, g_d, alpha) in [
            (0.0, 0.5, 0.1, 10.0),
            (1.0, 0.5, -0.999, 1000.0),
            (0.4, 0.999, 0.5, 25.0),
            (0.25, 0.0, 0.0, 1000.0),
            (0.6, -0.999, 0.999, 0.0),
        ] {
            let phase = HenyeyGreensteinDraine::new(w, g_hg, g_d, alpha).unwrap();
            testing::check(&phase.into());
            testing::check_inverse(&phase.into(), &[w]);
        }
    }

    #[test]
    fn parameters_out_of_range_are_refused() {
        assert!(HenyeyGreensteinDraine::new(-0.1, 0.0, 0.0, 0.0).is_err());
        assert!(HenyeyGreensteinDraine::new(f64::NAN, 0.0, 0.0, 0.0).is_err());
        assert!(HenyeyGreensteinDraine::new(0.5, 1.0, 0.0, 0.0).is_err());
        assert!(HenyeyGreensteinDraine::new(0.5, 0.0, -1.0, 0.0).is_err());
        assert!(HenyeyGreensteinDraine::new(0.5, 0.0, 0.0, -1.0).is_err());
    }
}
