//! The angles at which a phase function is tabulated.

use std::f64::consts::PI;

use super::super::PhaseError;
use super::super::quadrature::away_of;

/// Scattering angles in rad, rising strictly from 0 to pi.
#[derive(Debug, Clone, PartialEq)]
pub struct AngleGrid(Vec<f64>);

impl AngleGrid {
    /// More angles than this are taken for a slip of the pen.
    pub const MAX_LEN: usize = 10_000_000;
    /// Widest bin of a graded grid, rad.
    const WIDEST: f64 = PI / 180.0;
    /// Growth of the bins from one end of a graded grid.
    const GROWTH: f64 = 1.1;

    /// From angles in rad. A last angle within 1e-9 of pi is taken for pi: it went through degrees.
    ///
    /// # Errors
    /// [`PhaseError::TableLength`] for fewer than two; [`PhaseError::Angle`] for the first that breaks the order, or is
    /// so close to its neighbour that their cosines do not differ.
    pub fn new(mut angles_rad: Vec<f64>) -> Result<Self, PhaseError> {
        let count = angles_rad.len();
        if count < 2 {
            return Err(PhaseError::TableLength { angles: count, values: count });
        }
        if angles_rad[0] != 0.0 {
            return Err(PhaseError::Angle { index: 0, theta_rad: angles_rad[0] });
        }
        let last = &mut angles_rad[count - 1];
        if (*last - PI).abs() <= 1e-9 {
            *last = PI;
        } else {
            return Err(PhaseError::Angle { index: count - 1, theta_rad: *last });
        }
        for (i, pair) in angles_rad.windows(2).enumerate() {
            // `1 - cos` would not tell angles beyond pi apart from those before it.
            let rises = pair[1] > pair[0] && pair[1] <= PI && away_of(pair[1]) > away_of(pair[0]);
            if !rises {
                return Err(PhaseError::Angle { index: i + 1, theta_rad: pair[1] });
            }
        }
        Ok(Self(angles_rad))
    }

    /// `bins + 1` angles at equal distances.
    ///
    /// # Errors
    /// [`PhaseError::AngleGrid`] for no bins, or [`Self::MAX_LEN`] of them.
    pub fn uniform(bins: usize) -> Result<Self, PhaseError> {
        if bins == 0 || bins >= Self::MAX_LEN {
            return Err(PhaseError::AngleGrid { what: "number of bins", value: bins as f64 });
        }
        Self::new((0..=bins).map(|i| if i == bins { PI } else { PI * i as f64 / bins as f64 }).collect())
    }

    /// For a sphere of the given size parameter `x = 2 pi r n / lambda`, whose scattering oscillates over angle with
    /// the period `pi / x`: so many bins to a period (but none wider than 1 degree), and from there ever finer towards
    /// forward, for the peak, and towards backward, for the glory. For a population, the largest sphere that counts.
    ///
    /// The number of bins is even.
    ///
    /// # Errors
    /// [`PhaseError::AngleGrid`] unless both are positive and finite and there are fewer than [`Self::MAX_LEN`] angles.
    pub fn graded(size_parameter: f64, bins_per_period: f64) -> Result<Self, PhaseError> {
        for (what, value) in [("size parameter", size_parameter), ("bins per period", bins_per_period)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(PhaseError::AngleGrid { what, value });
            }
        }
        let widest = (PI / (size_parameter * bins_per_period)).min(Self::WIDEST);
        if PI / widest > 0.9 * Self::MAX_LEN as f64 {
            return Err(PhaseError::AngleGrid { what: "size parameter times bins per period", value: PI / widest });
        }
        Self::mirrored(widest / 8.0, Self::GROWTH, widest)
    }

    /// For many spheres of many sizes, whose oscillations over angle average out: as fine towards forward and backward as the
    /// peak of the largest size parameter wants, and away from there in steps of 3 % up to half a degree.
    ///
    /// # Errors
    /// [`PhaseError::AngleGrid`] unless it is positive and finite.
    pub(crate) fn broad(size_parameter: f64) -> Result<Self, PhaseError> {
        if !(size_parameter > 0.0 && size_parameter.is_finite()) {
            return Err(PhaseError::AngleGrid { what: "size parameter", value: size_parameter });
        }
        let widest = 0.5 * Self::WIDEST;
        Self::mirrored((0.05 / size_parameter).min(widest), 1.03, widest)
    }

    /// Bins that grow from both ends.
    fn mirrored(narrowest: f64, growth: f64, widest: f64) -> Result<Self, PhaseError> {
        // Half of it, up to 90 degrees, stretched to end there; the other half is its image.
        let mut half = vec![0.0];
        let (mut angle, mut width) = (0.0, narrowest);
        while angle < 0.5 * PI {
            angle += width;
            half.push(angle);
            width = (width * growth).min(widest);
        }
        let stretch = 0.5 * PI / angle;
        let mut angles: Vec<f64> = half.iter().map(|theta| theta * stretch).collect();
        angles.extend(half.iter().rev().skip(1).map(|theta| PI - theta * stretch));
        Self::new(angles)
    }

    /// So many bins to a period as asked for, or those of the widest bins there are: fewer give the same grid.
    pub(crate) fn effective_bins_per_period(size_parameter: f64, bins_per_period: f64) -> f64 {
        bins_per_period.max(PI / (size_parameter * Self::WIDEST))
    }

    /// The angles in rad.
    pub fn as_slice(&self) -> &[f64] {
        &self.0
    }

    /// How many angles; at least two.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.0.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_graded_grid_is_fine_at_its_ends_and_even() {
        for (x, per_period) in [(1e-3, 1.0), (1.0, 8.0), (600.0, 16.0), (5000.0, 3.0)] {
            let grid = AngleGrid::graded(x, per_period).unwrap();
            assert_eq!(grid.len() % 2, 1);
            let widths: Vec<f64> = grid.as_slice().windows(2).map(|p| p[1] - p[0]).collect();
            let widest = widths.iter().copied().fold(0.0, f64::max);
            assert!(widest <= (PI / (x * per_period)).min(AngleGrid::WIDEST) * (1.0 + 1e-9));
            assert!(widths[0] < 0.2 * widest && widths[widths.len() - 1] < 0.2 * widest);
        }
    }

    #[test]
    fn what_is_no_grid_is_refused() {
        assert!(AngleGrid::new(vec![0.0]).is_err());
        assert!(AngleGrid::new(vec![0.1, PI]).is_err());
        assert!(AngleGrid::new(vec![0.0, 3.0]).is_err());
        assert_eq!(AngleGrid::new(vec![0.0, 2.0, 1.0, PI]), Err(PhaseError::Angle { index: 2, theta_rad: 1.0 }));
        for theta in [f64::NAN, 0.0, -1.0, 1e-200, 4.0, f64::INFINITY, PI] {
            assert!(matches!(AngleGrid::new(vec![0.0, theta, PI]), Err(PhaseError::Angle { .. })), "{theta}");
        }
        assert!(AngleGrid::new(vec![0.0, 180f64.to_radians() - 1e-12]).is_ok());
        assert!(AngleGrid::uniform(0).is_err() && AngleGrid::uniform(usize::MAX).is_err());
        for x in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
            assert!(matches!(AngleGrid::graded(x, 8.0), Err(PhaseError::AngleGrid { .. })), "{x}");
            assert!(AngleGrid::graded(8.0, if x == 1e9 { f64::MAX } else { x }).is_err());
        }
    }
}
