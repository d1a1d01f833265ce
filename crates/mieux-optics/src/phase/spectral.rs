//! A phase function at each of many wavelengths.

use super::{PhaseError, PhaseFunction};
use crate::spectrum::WavelengthGrid;

/// One phase function per wavelength of a grid; between two wavelengths, their mixture in proportion.
///
/// The mixture is a phase function itself: it integrates to 1, its moments are the mixture of the moments, and its
/// samples are distributed as its value says.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectralPhase {
    grid: WavelengthGrid,
    functions: Vec<PhaseFunction>,
}

impl SpectralPhase {
    /// # Errors
    /// [`PhaseError::SpectralLength`] unless there is one function per wavelength.
    pub fn new(grid: WavelengthGrid, functions: Vec<PhaseFunction>) -> Result<Self, PhaseError> {
        if grid.len() != functions.len() {
            return Err(PhaseError::SpectralLength { wavelengths: grid.len(), functions: functions.len() });
        }
        Ok(Self { grid, functions })
    }

    /// The wavelengths, m.
    pub fn grid(&self) -> &WavelengthGrid {
        &self.grid
    }

    /// The phase functions, in the order of the grid.
    pub fn functions(&self) -> &[PhaseFunction] {
        &self.functions
    }

    /// The phase function at a vacuum wavelength in metres, or `None` outside the grid, whose ends give way by one part
    /// in 1e12.
    pub fn at(&self, wavelength_m: f64) -> Option<PhaseMixture<'_>> {
        let grid = self.grid.as_slice();
        let (first, last) = self.grid.range();
        if !(wavelength_m >= first * (1.0 - 1e-12) && wavelength_m <= last * (1.0 + 1e-12)) {
            return None;
        }
        let above = grid.partition_point(|&w| w < wavelength_m).min(grid.len() - 1);
        let below = above.saturating_sub(1);
        let share = if above == below { 0.0 } else { (wavelength_m - grid[below]) / (grid[above] - grid[below]) };
        Some(PhaseMixture {
            below: &self.functions[below],
            above: &self.functions[above],
            share: share.clamp(0.0, 1.0),
        })
    }

    /// Value in 1/sr at a wavelength in metres and a scattering cosine in [-1, 1]; `None` outside the grid.
    pub fn value(&self, wavelength_m: f64, mu: f64) -> Option<f64> {
        Some(self.at(wavelength_m)?.value(mu))
    }

    /// Scattering cosine for a uniform `xi` in [0, 1] at a wavelength in metres; `None` outside the grid.
    pub fn sample(&self, wavelength_m: f64, xi: f64) -> Option<f64> {
        Some(self.at(wavelength_m)?.sample(xi))
    }

    /// Mean cosine at a wavelength in metres; `None` outside the grid.
    pub fn asymmetry(&self, wavelength_m: f64) -> Option<f64> {
        Some(self.at(wavelength_m)?.asymmetry())
    }
}

/// The phase function between two wavelengths of a [`SpectralPhase`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhaseMixture<'a> {
    below: &'a PhaseFunction,
    above: &'a PhaseFunction,
    /// Of the one above.
    share: f64,
}

impl PhaseMixture<'_> {
    /// Value in 1/sr, as [`PhaseFunction::value`].
    pub fn value(&self, mu: f64) -> f64 {
        self.mix(|phase| phase.value(mu))
    }

    /// Density of [`Self::sample`] per sr: [`Self::value`].
    pub fn pdf(&self, mu: f64) -> f64 {
        self.value(mu)
    }

    /// Scattering cosine in [-1, 1] for a uniform `xi` in [0, 1], which picks one of the two neighbours in proportion,
    /// and what is left of it the cosine. NaN gives NaN.
    pub fn sample(&self, xi: f64) -> f64 {
        let (above, xi) = super::double_henyey_greenstein::pick(self.share, xi);
        if above { self.above.sample(xi) } else { self.below.sample(xi) }
    }

    /// Mean cosine.
    pub fn asymmetry(&self) -> f64 {
        self.mix(PhaseFunction::asymmetry)
    }

    /// Moment of the Legendre polynomial of the given degree.
    pub fn legendre_moment(&self, degree: u32) -> f64 {
        self.mix(|phase| phase.legendre_moment(degree))
    }

    fn mix(&self, f: impl Fn(&PhaseFunction) -> f64) -> f64 {
        // On a wavelength of the grid the neighbour is not asked.
        if self.share == 0.0 {
            f(self.below)
        } else if self.share == 1.0 {
            f(self.above)
        } else {
            (1.0 - self.share) * f(self.below) + self.share * f(self.above)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phase::testing::Uniform;
    use crate::phase::{HenyeyGreenstein, Rayleigh};

    fn two() -> SpectralPhase {
        let grid = WavelengthGrid::new(vec![400e-9, 500e-9]).unwrap();
        SpectralPhase::new(grid, vec![Rayleigh.into(), HenyeyGreenstein::new(0.8).unwrap().into()]).unwrap()
    }

    #[test]
    fn is_a_mixture_between_and_itself_on_its_wavelengths() {
        let spectral = two();
        for mu in [-1.0, -0.2, 0.5, 1.0] {
            let [a, b] = [0, 1].map(|i: usize| spectral.functions()[i].value(mu));
            assert_eq!(spectral.value(400e-9, mu), Some(a));
            assert_eq!(spectral.value(500e-9, mu), Some(b));
            assert!((spectral.value(475e-9, mu).unwrap() / (0.25 * a + 0.75 * b) - 1.0).abs() < 1e-12);
        }
        assert!((spectral.asymmetry(425e-9).unwrap() - 0.2).abs() < 1e-12);
        assert!((spectral.at(425e-9).unwrap().legendre_moment(2) - (0.075 + 0.25 * 0.64)).abs() < 1e-12);
    }

    /// The mixture is a two-term sum that is monotone in neither: bins of equal width in mu, each against the integral
    /// of the value over it.
    #[test]
    fn samples_pass_a_chi_squared_test() {
        let spectral = two();
        for (wavelength, seed) in [(400e-9, 1), (430e-9, 2), (470e-9, 3), (500e-9, 4)] {
            let here = spectral.at(wavelength).unwrap();
            let (samples, bins) = (50_000, 50);
            let mut counts = vec![0u32; bins];
            let mut uniform = Uniform::new(seed);
            for _ in 0..samples {
                counts[(((here.sample(uniform.next()) + 1.0) * 25.0) as usize).min(bins - 1)] += 1;
            }
            let edges: Vec<f64> = (0..=bins).map(|i| i as f64 / 25.0).collect();
            let mut expected = vec![0.0; bins];
            crate::phase::quadrature::visit(&edges, 0, |bin, away, weight| {
                expected[bins - 1 - bin] += f64::from(samples) * weight * here.pdf(1.0 - away);
            });
            let chi2: f64 = counts.iter().zip(&expected).map(|(&n, e)| (f64::from(n) - e).powi(2) / e).sum();
            // 49 degrees of freedom: 99.99 % lie below 96.
            assert!(chi2 < 96.0, "{wavelength}: {chi2}");
        }
    }

    #[test]
    fn refuses_what_does_not_fit_and_what_lies_outside() {
        let grid = WavelengthGrid::new(vec![400e-9, 500e-9]).unwrap();
        assert_eq!(
            SpectralPhase::new(grid, vec![Rayleigh.into()]),
            Err(PhaseError::SpectralLength { wavelengths: 2, functions: 1 })
        );
        let spectral = two();
        for wavelength in [399e-9, 501e-9, f64::NAN, f64::INFINITY, -1.0] {
            assert!(spectral.at(wavelength).is_none());
        }
        let one = SpectralPhase::new(WavelengthGrid::new(vec![5e-7]).unwrap(), vec![Rayleigh.into()]).unwrap();
        assert_eq!(one.asymmetry(5e-7), Some(0.0));
        assert!(one.sample(5e-7, f64::NAN).unwrap().is_nan());
    }
}
