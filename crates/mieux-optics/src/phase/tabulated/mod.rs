//! A phase function known at angles: Lorenz-Mie results, measurements.

mod build;
mod cosine;
mod grid;

use std::f64::consts::PI;
use std::fmt;

pub use build::TableRule;
pub use grid::AngleGrid;

use super::{PhaseError, quadrature};

/// A phase function that is linear in `mu` within each bin of an angle grid; normalisation, samples, mean cosine and
/// Legendre moments are those of this interpolant exactly.
///
/// A bin has a value at each of its ends; neighbours share theirs if the table was made of values at angles
/// ([`Self::new`]) and need not if it was made of integrals over bins ([`TableRule::Integrated`]).
///
/// Everything is held over `1 - mu`, so that a forward peak a fraction of a degree wide keeps its digits.
#[derive(Debug, Clone, PartialEq)]
pub struct Tabulated {
    grid: AngleGrid,
    /// `1 - cos(theta)` of the angles, from 0 to 2.
    away: Vec<f64>,
    /// Values in 1/sr at the forward and the backward end of each bin.
    ends: Vec<[f64; 2]>,
    /// Share of the light scattered closer to forward than each angle, from 0 to 1.
    cumulative: Vec<f64>,
    /// `1 - g`.
    lack: f64,
    /// Estimated relative error of `lack`.
    error: f64,
}

impl Tabulated {
    /// From values (any common scale) at angles in rad that rise strictly from 0 to pi.
    ///
    /// The error of `1 - g` is estimated from how it changes as every second angle is left out, once and again.
    ///
    /// # Errors
    /// [`PhaseError::TableLength`], [`PhaseError::Angle`], [`PhaseError::AngleValue`] for a value negative or not
    /// finite, [`PhaseError::Integral`] if all values are zero.
    pub fn new(angles_rad: Vec<f64>, values: Vec<f64>) -> Result<Self, PhaseError> {
        if angles_rad.len() != values.len() || values.len() < 2 {
            return Err(PhaseError::TableLength { angles: angles_rad.len(), values: values.len() });
        }
        let grid = AngleGrid::new(angles_rad)?;
        check_values(&grid, values.iter().copied().map(|v| [v; 1]))?;
        let coarse = every_second(grid.as_slice(), &values);
        let coarser = every_second(&coarse.0, &coarse.1);
        let mut table = Self::assemble(grid, pairs(&values))?;
        table.error = table.error_from(coarse, coarser);
        Ok(table)
    }

    /// Relative error of `1 - g`, from the tables of every second and every fourth angle.
    fn error_from(&self, coarse: (Vec<f64>, Vec<f64>), coarser: (Vec<f64>, Vec<f64>)) -> f64 {
        // With fewer angles, leaving some out leaves nothing.
        if coarser.0.len() < 3 {
            return f64::INFINITY;
        }
        let lack = |(angles, values): (Vec<f64>, Vec<f64>)| -> Option<f64> {
            Some(Self::assemble(AngleGrid::new(angles).ok()?, pairs(&values)).ok()?.lack)
        };
        let (Some(coarse), Some(coarser)) = (lack(coarse), lack(coarser)) else { return f64::INFINITY };
        let (last, first) = ((self.lack - coarse).abs(), (coarse - coarser).abs());
        // Differences that shrink by `ratio` from step to step sum to `ratio/(1 - ratio)` of the last; where they do
        // not shrink, the peak has not been seen yet. Never less than the last, in case it shrank by luck.
        let ratio = if last > 0.0 { last / first } else { 0.0 };
        let factor = if ratio < 0.99 { (ratio / (1.0 - ratio)).max(1.0) } else { 100.0 };
        last * factor / self.lack
    }

    /// From the values (any common scale) at the forward and backward end of each bin between the angles of a grid.
    ///
    /// The estimated error is 0: such a table is taken at its word.
    ///
    /// # Errors
    /// [`PhaseError::TableLength`] unless there is one pair fewer than angles; else as [`Self::new`].
    pub fn from_bins(grid: AngleGrid, ends: Vec<[f64; 2]>) -> Result<Self, PhaseError> {
        if ends.len() + 1 != grid.len() {
            return Err(PhaseError::TableLength { angles: grid.len(), values: ends.len() });
        }
        check_values(&grid, ends.iter().copied())?;
        Self::assemble(grid, ends)
    }

    /// Normalises checked values.
    fn assemble(grid: AngleGrid, mut ends: Vec<[f64; 2]>) -> Result<Self, PhaseError> {
        let away: Vec<f64> = grid.as_slice().iter().map(|&theta| quadrature::away_of(theta)).collect();
        // The largest first, so that no sum overflows.
        let largest = ends.iter().flatten().copied().fold(0.0, f64::max);
        let mut integral = 0.0;
        for (end, width) in ends.iter_mut().zip(widths(&away)) {
            *end = end.map(|v| if largest > 0.0 { v / largest } else { 0.0 });
            integral += PI * width * (end[0] + end[1]);
        }
        if !(integral > 0.0 && (1.0 / integral).is_finite()) {
            return Err(PhaseError::Integral { integral });
        }
        let mut cumulative = Vec::with_capacity(grid.len());
        let (mut below, mut lack) = (0.0, 0.0);
        cumulative.push(0.0);
        for ((end, width), start) in ends.iter_mut().zip(widths(&away)).zip(&away) {
            *end = end.map(|v| v / integral);
            let [near, far] = *end;
            below += PI * width * (near + far);
            lack += PI * width * (start * (near + far) + width * (near + 2.0 * far) / 3.0);
            cumulative.push(below);
        }
        // What rounding left of the sum: 1e-13 at most, spread over all.
        for share in &mut cumulative {
            *share /= below;
        }
        Ok(Self { grid, away, ends, cumulative, lack, error: 0.0 })
    }

    /// The angles, rad.
    pub fn grid(&self) -> &AngleGrid {
        &self.grid
    }

    /// The normalised values in 1/sr at the forward and the backward end of each bin.
    pub fn bins(&self) -> &[[f64; 2]] {
        &self.ends
    }

    /// `1 - cos(theta)` of the angles.
    pub(in crate::phase) fn edges(&self) -> &[f64] {
        &self.away
    }

    /// Value in 1/sr at the scattering cosine `mu` in [-1, 1]; at an angle where two bins disagree, the backward one's.
    /// Also the density of [`Self::sample`] per solid angle.
    pub fn value(&self, mu: f64) -> f64 {
        self.value_away(1.0 - mu)
    }

    /// The value at `1 - mu`.
    pub(in crate::phase) fn value_away(&self, away: f64) -> f64 {
        if away.is_nan() {
            return away;
        }
        let bin = self.bin(away);
        self.inside(bin, away.clamp(0.0, 2.0))
    }

    /// The bin that holds `away`, the backward one of two that meet there.
    fn bin(&self, away: f64) -> usize {
        self.away.partition_point(|&edge| edge <= away).clamp(1, self.ends.len()) - 1
    }

    /// Share of the light scattered by less than the angle of cosine `mu` in [-1, 1].
    pub fn forward_fraction(&self, mu: f64) -> f64 {
        let away = (1.0 - mu).clamp(0.0, 2.0);
        if away.is_nan() {
            return away;
        }
        let bin = self.bin(away);
        let [near, far] = self.ends[bin];
        let width = self.away[bin + 1] - self.away[bin];
        let t = (away - self.away[bin]) / width;
        self.cumulative[bin] + 2.0 * PI * width * t * (near + 0.5 * t * (far - near))
    }

    /// Scattering cosine in [-1, 1] for a uniform `xi` in [0, 1]: the exact inverse of the cumulative distribution,
    /// rising from -1 to 1.
    pub fn sample(&self, xi: f64) -> f64 {
        if xi.is_nan() {
            return xi;
        }
        let wanted = (1.0 - xi).clamp(0.0, 1.0);
        // The last bin that starts below `wanted` and is not empty.
        let mut bin = self.cumulative.partition_point(|&share| share <= wanted).clamp(1, self.ends.len()) - 1;
        while bin > 0 && self.ends[bin] == [0.0, 0.0] {
            bin -= 1;
        }
        let [near, far] = self.ends[bin];
        let width = self.away[bin + 1] - self.away[bin];
        let rest = (wanted - self.cumulative[bin]) / (2.0 * PI * width);
        // The root of near t + (far - near) t^2 / 2 = rest, in the form that does not cancel.
        let root = (near * near + 2.0 * (far - near) * rest).max(0.0).sqrt();
        let t = if rest > 0.0 { (2.0 * rest / (near + root)).min(1.0) } else { 0.0 };
        (1.0 - (self.away[bin] + t * width)).clamp(-1.0, 1.0)
    }

    /// Mean cosine.
    pub fn asymmetry(&self) -> f64 {
        1.0 - self.lack
    }

    /// `1 - g`, with all its digits where `g` is close to 1: the scale of reduced scattering.
    pub fn one_minus_asymmetry(&self) -> f64 {
        self.lack
    }

    /// Estimated relative error of [`Self::one_minus_asymmetry`] against the function that was tabulated; infinite if
    /// there are too few angles to tell.
    pub fn one_minus_asymmetry_error(&self) -> f64 {
        self.error
    }

    /// Moment of the Legendre polynomial of the given degree, exact for the interpolant up to rounding. The time grows
    /// with the number of angles times the degree; [`Self::legendre_moments`] is the way to many.
    pub fn legendre_moment(&self, degree: u32) -> f64 {
        quadrature::moment(&self.away, degree, |bin, away| self.inside(bin, away))
    }

    /// The moments of all degrees from 0 to `max_degree`.
    pub fn legendre_moments(&self, max_degree: u32) -> Vec<f64> {
        quadrature::moments(&self.away, max_degree, |bin, away| self.inside(bin, away))
    }

    fn inside(&self, bin: usize, away: f64) -> f64 {
        let [near, far] = self.ends[bin];
        let t = (away - self.away[bin]) / (self.away[bin + 1] - self.away[bin]);
        near * (1.0 - t) + far * t
    }
}

fn widths(away: &[f64]) -> impl Iterator<Item = f64> + '_ {
    away.windows(2).map(|pair| pair[1] - pair[0])
}

fn check_values<const N: usize>(grid: &AngleGrid, values: impl Iterator<Item = [f64; N]>) -> Result<(), PhaseError> {
    for (&theta_rad, group) in grid.as_slice().iter().zip(values) {
        for value in group {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(PhaseError::AngleValue { theta_rad, value });
            }
        }
    }
    Ok(())
}

/// A value at each end of each bin.
fn pairs(values: &[f64]) -> Vec<[f64; 2]> {
    values.windows(2).map(|pair| [pair[0], pair[1]]).collect()
}

/// Every second angle and value, and the last.
fn every_second(angles: &[f64], values: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let count = values.len();
    (0..count).filter(|i| i % 2 == 0 || i + 1 == count).map(|i| (angles[i], values[i])).unzip()
}

impl fmt::Display for Tabulated {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "tabulated ({} angles, g = {})", self.grid.len(), self.asymmetry())
    }
}

#[cfg(test)]
mod tests;
