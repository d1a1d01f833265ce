//! Tables made from a function of the angle.

use std::f64::consts::PI;

use super::super::{PhaseError, quadrature::away_of};
use super::{AngleGrid, Tabulated};
use crate::integrate::integrate;

/// How a function becomes a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TableRule {
    /// Its values at the angles. One evaluation per angle; the grid must resolve what the function does.
    #[default]
    Points,
    /// Its integral over each bin, and its mean cosine within, to 1e-8: `1 - g` is right on any grid. Sixteen
    /// evaluations per bin and more. Where a bin's mean lies so close to one end that the line through it would be negative
    /// somewhere, the integral is kept and the mean is not, which the estimated error counts.
    Integrated,
}

impl Tabulated {
    /// Tabulates `f`, a function of the scattering angle in rad with any scale.
    ///
    /// # Errors
    /// [`PhaseError::AngleValue`] where `f` is negative or not finite, [`PhaseError::Integral`] if it is zero,
    /// [`PhaseError::NotIntegrable`] if a bin does not converge under [`TableRule::Integrated`].
    pub fn from_fn(grid: AngleGrid, rule: TableRule, mut f: impl FnMut(f64) -> f64) -> Result<Self, PhaseError> {
        match rule {
            TableRule::Points => {
                let values = grid.as_slice().iter().map(|&theta| f(theta)).collect();
                Self::new(grid.as_slice().to_vec(), values)
            }
            TableRule::Integrated => Self::integrated(grid, f),
        }
    }

    /// Tabulates the values of `f` for a sphere of the given size parameter (see [`AngleGrid::graded`]), on grids of 8
    /// to 128 bins per period of oscillation (of small spheres, 1 to 16 bins per degree), until the estimated relative error of `1 - g` is below `tolerance`.
    ///
    /// # Errors
    /// [`PhaseError::Tolerance`] if the finest grid does not get there; else as [`Self::from_fn`] and
    /// [`AngleGrid::graded`].
    pub fn to_tolerance(
        size_parameter: f64,
        tolerance: f64,
        mut f: impl FnMut(f64) -> f64,
    ) -> Result<Self, PhaseError> {
        let mut reached = f64::INFINITY;
        let coarsest = AngleGrid::effective_bins_per_period(size_parameter, 8.0);
        for finer in [1.0, 2.0, 4.0, 8.0, 16.0] {
            let grid = AngleGrid::graded(size_parameter, finer * coarsest)?;
            let table = Self::from_fn(grid, TableRule::Points, &mut f)?;
            reached = table.one_minus_asymmetry_error();
            if reached <= tolerance {
                return Ok(table);
            }
        }
        Err(PhaseError::Tolerance { reached, wanted: tolerance })
    }

    fn integrated(grid: AngleGrid, mut f: impl FnMut(f64) -> f64) -> Result<Self, PhaseError> {
        let mut ends = Vec::with_capacity(grid.len() - 1);
        // Of the first moments of all bins, what was lost to keep values positive, and what quadrature left open; and
        // what it left open of the integrals.
        let mut lost = 0.0f64;
        let (mut open, mut total_open) = (0.0f64, 0.0f64);
        // Of any scale: integrals of the values themselves might over- or underflow.
        let largest = grid.as_slice().iter().map(|&theta| f(theta)).fold(0.0, f64::max);
        let unit = if largest.is_finite() && largest > 0.0 { largest } else { 1.0 };
        for pair in grid.as_slice().windows(2) {
            let start = away_of(pair[0]);
            let width = away_of(pair[1]) - start;
            let Some(integral) = integrate(pair, 1e-8, [f64::MIN_POSITIVE; 2], |theta| {
                let value = f(theta);
                if value >= 0.0 && value.is_finite() {
                    let weighted = value / unit * theta.sin() / width;
                    Ok([weighted, weighted * (away_of(theta) - start) / width])
                } else {
                    Err(PhaseError::AngleValue { theta_rad: theta, value })
                }
            })?
            else {
                return Err(PhaseError::NotIntegrable { from_rad: pair[0], to_rad: pair[1] });
            };
            let [mean, first] = integral.value;
            let (line, kept) = line_through(mean, first);
            lost += 2.0 * PI * width * width * (kept - first);
            open += 2.0 * PI * width * (start * integral.error[0] + width * integral.error[1]);
            total_open += 2.0 * PI * width * integral.error[0];
            ends.push(line);
        }
        let raw: f64 = ends.iter().zip(super::widths(&edges_of(&grid))).map(|(e, w)| PI * w * (e[0] + e[1])).sum();
        let mut table = Self::from_bins(grid, ends)?;
        table.error = (lost.abs() + open) / (raw * table.lack) + total_open / raw;
        Ok(table)
    }
}

fn edges_of(grid: &AngleGrid) -> Vec<f64> {
    grid.as_slice().iter().map(|&theta| away_of(theta)).collect()
}

/// The line over [0, 1] with the given mean and first moment, at its two ends, and the first moment it has: another
/// one if the line would be negative.
fn line_through(mean: f64, first: f64) -> ([f64; 2], f64) {
    let far = (6.0 * first - 2.0 * mean).clamp(0.0, 2.0 * mean);
    let near = (2.0 * mean - far).max(0.0);
    ([near, far], near / 6.0 + far / 3.0)
}
