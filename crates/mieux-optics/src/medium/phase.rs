//! Phase functions of media: the mean of those of single spheres, each by how much it scatters.
//!
//! Source: eq 31 and 32 of `frisvad2007`.

mod broad;
mod members;
mod moments;
mod rays;

use super::{Medium, MediumError, OpticsAt};
use crate::phase::{AngleGrid, HenyeyGreenstein, Isotropic, PhaseError, PhaseFunction, SpectralPhase, Tabulated};
use crate::spectrum::WavelengthGrid;
use members::{Member, Members, Road};

/// Bins to a period of the largest sphere's oscillation over angle, to begin with.
const BINS_PER_PERIOD: f64 = 8.0;

/// Grids that are tried before giving up.
const ATTEMPTS: usize = 4;

/// What a medium does to light of one wavelength: coefficients, moments and phase function from one pass over its particles.
#[derive(Debug, Clone)]
pub struct ScatteringAt {
    optics: OpticsAt,
    /// `1 - g` with all its digits.
    lack: f64,
    ensemble: Ensemble,
}

/// The mean phase function of all particles.
#[derive(Debug, Clone)]
enum Ensemble {
    /// Nothing scatters.
    Nothing,
    /// A polynomial in the cosine, by all its Legendre moments, and the largest size parameter that counts.
    Exact { moments: Vec<f64>, largest: f64 },
    /// Spheres that are in each other's way, whose structure factor is no polynomial.
    Packed { medium: Medium, members: Vec<Member>, largest: f64 },
    /// Sizes so many, or so large, that a table is all there is.
    Broad(Tabulated),
    /// What is too large for anything else.
    StandIn(HenyeyGreenstein),
}

impl Medium {
    /// Size parameter of the largest spheres whose phase functions are sums of Lorenz and Mie's series.
    pub const LARGEST_SIZE: f64 = 2500.0;

    /// Coefficients, Legendre moments and phase function at a vacuum wavelength (m), from one pass over all particles: the
    /// way to more than one of [`Self::optics_at`], [`Self::legendre_moments_at`] and [`Self::phase_at`], which say how good they are.
    ///
    /// # Errors
    /// As for [`Self::optics_at`].
    pub fn scattering_at(&self, wavelength: f64, tolerance: f64) -> Result<ScatteringAt, MediumError> {
        let found = self.integrated_at(wavelength, tolerance)?;
        let ensemble = self.ensemble(wavelength, tolerance, &found)?;
        Ok(ScatteringAt { optics: found.optics, lack: found.lack, ensemble })
    }

    /// Phase function at a vacuum wavelength (m): the mean of the phase functions of all spheres, weighted by how
    /// much each scatters, as a table over angle; isotropic where nothing scatters.
    ///
    /// - Up to a size parameter of 500, and beyond where sizes are few, every sphere is exact, and sizes are as close as fringes want.
    /// - Up to [`Self::LARGEST_SIZE`] spheres of many sizes are exact, and sizes are drawn from so wide a range that fringes over
    ///   size and angle average out; what is left of them is some per cent in one direction.
    /// - Where more than a share `tolerance` of the light is scattered by spheres beyond that, those above 1000 are followed by
    ///   rays, refracted and reflected up to thirty times, and what passes them by diffraction, which does not resolve fringes, and errs by
    ///   some per cent, by more where there is little light (measured in `docs/large-particles.md`).
    /// - Coated spheres, and packed ones, beyond [`Self::LARGEST_SIZE`] have Henyey and Greenstein's function of the right asymmetry.
    ///
    /// `1 - g` of the table is within half of `tolerance` (relative, 1e-12 to 1) of what the coefficients say, which where
    /// need be is enforced by a factor `exp(c (1 - cos))` close to 1.
    ///
    /// # Errors
    /// As for [`Self::optics_at`], or [`MediumError::Phase`] when no grid of angles reaches the tolerance.
    pub fn phase_at(&self, wavelength: f64, tolerance: f64) -> Result<PhaseFunction, MediumError> {
        self.scattering_at(wavelength, tolerance)?.phase_function(tolerance)
    }

    /// [`Self::phase_at`] for every wavelength of a grid.
    ///
    /// # Errors
    /// As for [`Self::phase_at`].
    pub fn spectral_phase(&self, grid: &WavelengthGrid, tolerance: f64) -> Result<SpectralPhase, MediumError> {
        let functions: Result<Vec<_>, _> = grid.iter().map(|wavelength| self.phase_at(wavelength, tolerance)).collect();
        Ok(SpectralPhase::new(grid.clone(), functions?)?)
    }

    /// Legendre moments, from degree 0 to `max_degree`, of the phase function at a vacuum wavelength (m): 1, the mean
    /// cosine, and so on; 1 and zeros where nothing scatters.
    ///
    /// The phase function of every sphere is a polynomial in the scattering cosine, and a Gauss rule with enough nodes for
    /// the largest gives the moments of all of them without error but rounding: what is left is that of the integral over
    /// radius. (A structure factor, where packing is corrected for, is no polynomial, and gets nodes enough for 1e-6.) Where
    /// [`Self::phase_at`] has rays, or sizes that are spread wide, they are those of its table.
    ///
    /// # Errors
    /// As for [`Self::optics_at`].
    pub fn legendre_moments_at(
        &self,
        wavelength: f64,
        max_degree: usize,
        tolerance: f64,
    ) -> Result<Vec<f64>, MediumError> {
        self.scattering_at(wavelength, tolerance)?.legendre_moments(max_degree)
    }

    fn ensemble(
        &self,
        wavelength: f64,
        tolerance: f64,
        found: &super::bulk::Integrated,
    ) -> Result<Ensemble, MediumError> {
        if found.optics.sigma_s <= 0.0 {
            return Ok(Ensemble::Nothing);
        }
        let Members { members, road, largest } = self.members(wavelength, tolerance, &found.panels)?;
        Ok(match road {
            _ if members.is_empty() => Ensemble::Nothing,
            Road::Exact => {
                let moments = moments::of_all(self, &members)?;
                let whole = moments[0];
                Ensemble::Exact { moments: moments.into_iter().map(|moment| moment / whole).collect(), largest }
            }
            Road::Packed => Ensemble::Packed { medium: self.clone(), members, largest },
            Road::Broad => Ensemble::Broad(broad::table(self, wavelength, &members, largest, found.lack)?),
            Road::StandIn => Ensemble::StandIn(HenyeyGreenstein::new(found.optics.asymmetry)?),
        })
    }
}

impl ScatteringAt {
    /// The coefficients, as [`Medium::optics_at`] gives them.
    pub fn optics(&self) -> &OpticsAt {
        &self.optics
    }

    /// Legendre moments from degree 0 to `max_degree`, as [`Medium::legendre_moments_at`] gives them.
    ///
    /// # Errors
    /// [`MediumError::Mie`] for packed spheres in hosts that absorb too much.
    pub fn legendre_moments(&self, max_degree: usize) -> Result<Vec<f64>, MediumError> {
        Ok(match &self.ensemble {
            Ensemble::Nothing => (0..=max_degree).map(|degree| if degree == 0 { 1.0 } else { 0.0 }).collect(),
            Ensemble::Exact { moments, .. } => {
                moments.iter().copied().chain(std::iter::repeat(0.0)).take(max_degree + 1).collect()
            }
            Ensemble::Packed { medium, members, .. } => moments::of_packed(medium, members, max_degree)?,
            Ensemble::Broad(table) => {
                let moments = table.legendre_moments(max_degree as u32);
                let whole = moments[0];
                moments.into_iter().map(|moment| moment / whole).collect()
            }
            Ensemble::StandIn(function) => {
                (0..=max_degree).map(|degree| function.asymmetry().powi(degree as i32)).collect()
            }
        })
    }

    /// The phase function, as [`Medium::phase_at`] gives it; `tolerance` is that of `1 - g` of the table.
    ///
    /// # Errors
    /// [`MediumError::Phase`] when no grid of angles reaches the tolerance; [`MediumError::Mie`] for packed spheres in
    /// hosts that absorb too much.
    pub fn phase_function(&self, tolerance: f64) -> Result<PhaseFunction, MediumError> {
        match &self.ensemble {
            Ensemble::Nothing => Ok(Isotropic.into()),
            Ensemble::Exact { moments, largest } => {
                let own = moments.get(1).map_or(1.0, |mean| 1.0 - mean);
                self.on_graded(*largest, own, tolerance, |grid| Ok(moments::values(moments, grid.as_slice())))
            }
            Ensemble::Packed { medium, members, largest } => {
                let own = 1.0 - moments::of_packed(medium, members, 1)?[1];
                self.on_graded(*largest, own, tolerance, |grid| moments::packed_values(medium, members, grid))
            }
            Ensemble::Broad(table) => Ok(table.clone().into()),
            Ensemble::StandIn(function) => Ok((*function).into()),
        }
    }

    /// A table of values on a grid as fine as their own `1 - g` wants.
    fn on_graded(
        &self,
        largest: f64,
        own: f64,
        tolerance: f64,
        values: impl Fn(&AngleGrid) -> Result<Vec<f64>, MediumError>,
    ) -> Result<PhaseFunction, MediumError> {
        // The other half is left to the integral over radius.
        let wanted = 0.5 * tolerance;
        let mut bins_per_period = AngleGrid::effective_bins_per_period(largest, BINS_PER_PERIOD);
        let mut reached = f64::INFINITY;
        for _ in 0..ATTEMPTS {
            let grid = AngleGrid::graded(largest, bins_per_period)?;
            let values = values(&grid)?;
            let table = Tabulated::new(grid.as_slice().to_vec(), values.clone())?;
            reached = (table.one_minus_asymmetry() / own - 1.0).abs();
            if reached <= wanted {
                // The coefficients know more of resonances than the spheres that the function is the mean of.
                let right = (table.one_minus_asymmetry() / self.lack - 1.0).abs() <= wanted;
                return Ok(if right { table } else { broad::tilted(&grid, &values, self.lack)? }.into());
            }
            // The error falls with the square of the width of a bin.
            bins_per_period *= (1.2 * (reached / wanted).sqrt()).clamp(1.5, 8.0);
        }
        Err(PhaseError::Tolerance { reached, wanted }.into())
    }
}

#[cfg(test)]
mod tests;
