//! A medium at the wavelengths of one path.

use super::{LANES, Lanes};

/// Coefficients (1/m) and index of a medium at the wavelengths of a path, and what walks through it need.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MediumLanes {
    pub(crate) sigma_a: Lanes,
    /// Index by which light is shared between reflection and refraction: each wavelength's own.
    pub(crate) n: Lanes,
    /// Index by which rays bend: the same for all without dispersion.
    pub(crate) n_geometry: Lanes,
    /// `None` where nothing scatters at any of the wavelengths.
    pub(crate) turbid: Option<Turbid>,
    pub(crate) absorbs: bool,
}

/// The scattering side of a medium.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Turbid {
    pub(crate) sigma_s: Lanes,
    pub(crate) g: Lanes,
    /// Extinction, 1/m; never quite 0, so that its inverse and logarithm stay finite.
    pub(crate) sigma_t: Lanes,
    /// Logarithm of what one collision multiplies the density by, apart from the angle, relative to the hero.
    pub(crate) log_collision: Lanes,
    pub(crate) log_albedo: Lanes,
    /// Collisions after which the books are closed: before the angular products leave the range of `f64`, and before
    /// much is absorbed unnoticed.
    pub(crate) interval: u32,
}

/// Stands in for 0 where a logarithm or an inverse is taken.
const TINY: f64 = 1e-30;

impl MediumLanes {
    /// Air, or nothing at all.
    pub(crate) fn vacuum() -> Self {
        let one = [1.0; LANES];
        Self { sigma_a: [0.0; LANES], n: one, n_geometry: one, turbid: None, absorbs: false }
    }

    /// Clear, or where no walk is made.
    pub(crate) fn unwalked(sigma_a: Lanes, n: Lanes, n_geometry: Lanes) -> Self {
        Self { sigma_a, n, n_geometry, turbid: None, absorbs: sigma_a.iter().any(|&s| s > 0.0) }
    }

    pub(crate) fn new(sigma_s: Lanes, sigma_a: Lanes, g: Lanes, n: Lanes, n_geometry: Lanes) -> Self {
        let turbid = sigma_s.iter().any(|&s| s > 0.0).then(|| Turbid::new(sigma_s, &sigma_a, g));
        let absorbs = sigma_a.iter().any(|&s| s > 0.0);
        Self { sigma_a, n, n_geometry, turbid, absorbs }
    }

    /// Share of light left after a distance (m) in a clear medium.
    pub(crate) fn transmittance(&self, distance: f64) -> Lanes {
        self.sigma_a.map(|s| if s > 0.0 { (-s * distance).exp() } else { 1.0 })
    }
}

impl Turbid {
    pub(crate) fn new(sigma_s: Lanes, sigma_a: &Lanes, g: Lanes) -> Self {
        let sigma_t: Lanes = std::array::from_fn(|k| (sigma_s[k] + sigma_a[k]).max(TINY));
        // Henyey-Greenstein is (1 - g^2)^(-1/2) times ((1 + g^2 - 2 g mu)/(1 - g^2))^(-3/2): this is the first factor.
        let log_fixed = |k: usize| sigma_t[k].ln() - 0.5 * (1.0 - g[k] * g[k]).ln();
        let log_albedo: Lanes = std::array::from_fn(|k| (sigma_s[k] / sigma_t[k]).max(TINY).ln());
        let steepest = g.iter().map(|g| ((1.0 + g.abs()) / (1.0 - g.abs())).ln()).fold(0.0, f64::max);
        let mildest = log_albedo.iter().fold(f64::NEG_INFINITY, |m, a| m.max(*a)).abs();
        let interval = 128.0f64.min(600.0 / steepest.max(TINY)).min((0.7 / mildest.max(TINY)).ceil());
        Self {
            sigma_s,
            g,
            sigma_t,
            log_collision: std::array::from_fn(|k| log_fixed(k) - log_fixed(0)),
            log_albedo,
            interval: interval.max(1.0) as u32,
        }
    }

    /// The medium that similarity puts in its place: isotropic, with reduced scattering (frisvad2007, section 3).
    pub(crate) fn reduced(&self, sigma_a: &Lanes) -> Self {
        Self::new(std::array::from_fn(|k| (1.0 - self.g[k]) * self.sigma_s[k]), sigma_a, [0.0; LANES])
    }

    /// Length after which similarity takes over, m: ten mean free paths, the same whichever wavelength is the hero.
    pub(crate) fn similarity_length(&self) -> f64 {
        10.0 * LANES as f64 / self.sigma_t.iter().sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn books_are_closed_in_time() {
        let milk = Turbid::new([57_837.0; 4], &[6.08; 4], [0.954; 4]);
        assert_eq!(milk.interval, 128);
        let peaked = Turbid::new([1.0; 4], &[0.0; 4], [0.9999; 4]);
        assert!(f64::from(peaked.interval) * (1.9999f64 / 0.0001).ln() < 700.0);
        let dark = Turbid::new([1.0; 4], &[100.0; 4], [0.0; 4]);
        assert_eq!(dark.interval, 1);
        let mixed = Turbid::new([0.0, 1.0, 1.0, 1.0], &[0.0; 4], [0.5; 4]);
        assert!(mixed.log_albedo.iter().chain(&mixed.log_collision).all(|l| l.is_finite()));
    }
}
