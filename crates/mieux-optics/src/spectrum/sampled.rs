//! A quantity known at some wavelengths and interpolated between them.

use super::{SpectrumError, WavelengthGrid};

/// Values on a wavelength grid, linear in between: monotone between samples, and never extrapolated.
#[derive(Debug, Clone, PartialEq)]
pub struct Sampled {
    grid: WavelengthGrid,
    values: Vec<f64>,
}

impl Sampled {
    /// Pairs a grid with one finite value per wavelength.
    ///
    /// # Errors
    /// [`SpectrumError::Length`] or [`SpectrumError::Value`].
    pub fn new(grid: WavelengthGrid, values: Vec<f64>) -> Result<Self, SpectrumError> {
        if grid.len() != values.len() {
            return Err(SpectrumError::Length { wavelengths: grid.len(), values: values.len() });
        }
        for (wavelength_m, &value) in grid.iter().zip(&values) {
            if !value.is_finite() {
                return Err(SpectrumError::Value { wavelength_m, value });
            }
        }
        Ok(Self { grid, values })
    }

    /// The value at a wavelength in metres, or `None` outside the samples.
    ///
    /// A single sample holds at its own wavelength only. The ends give way by one part in 1e12, so that a
    /// wavelength that went through a change of unit is still inside.
    pub fn at(&self, wavelength_m: f64) -> Option<f64> {
        let grid = self.grid.as_slice();
        let (first, last) = self.grid.range();
        if !(wavelength_m >= first * (1.0 - 1e-12) && wavelength_m <= last * (1.0 + 1e-12)) {
            return None;
        }
        let above = grid.partition_point(|&w| w < wavelength_m);
        if above == 0 {
            return Some(self.values[0]);
        }
        if above == grid.len() {
            return Some(self.values[above - 1]);
        }
        let (w0, w1) = (grid[above - 1], grid[above]);
        let t = (wavelength_m - w0) / (w1 - w0);
        Some(self.values[above - 1] * (1.0 - t) + self.values[above] * t)
    }

    /// The wavelengths, m.
    pub fn grid(&self) -> &WavelengthGrid {
        &self.grid
    }

    /// The values, in the order of the grid.
    pub fn values(&self) -> &[f64] {
        &self.values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolates_inside_and_refuses_outside() {
        let grid = WavelengthGrid::new(vec![400e-9, 500e-9, 700e-9]).unwrap();
        let s = Sampled::new(grid.clone(), vec![1.0, 3.0, 5.0]).unwrap();
        assert_eq!(s.at(400e-9), Some(1.0));
        assert!((s.at(450e-9).unwrap() - 2.0).abs() < 1e-12);
        assert!((s.at(600e-9).unwrap() - 4.0).abs() < 1e-12);
        assert_eq!(s.at(700e-9), Some(5.0));
        assert_eq!(s.at(399e-9), None);
        assert_eq!(s.at(701e-9), None);
        assert_eq!(s.at(f64::NAN), None);
        assert!(Sampled::new(grid.clone(), vec![1.0]).is_err());
        assert!(Sampled::new(grid, vec![1.0, f64::INFINITY, 0.0]).is_err());
    }
}
