//! The wavelengths at which a material is asked about.

use super::SpectrumError;

/// Strictly increasing vacuum wavelengths in metres; never empty.
#[derive(Debug, Clone, PartialEq)]
pub struct WavelengthGrid(Vec<f64>);

impl WavelengthGrid {
    /// More wavelengths than this are taken for a slip of the pen.
    pub const MAX_LEN: usize = 1_000_000;

    /// Takes wavelengths in metres, in increasing order.
    ///
    /// # Errors
    /// [`SpectrumError`] when empty, not increasing, or not positive and finite.
    pub fn new(wavelengths_m: Vec<f64>) -> Result<Self, SpectrumError> {
        if wavelengths_m.is_empty() {
            return Err(SpectrumError::Empty);
        }
        for &wavelength_m in &wavelengths_m {
            if !(wavelength_m > 0.0 && wavelength_m.is_finite()) {
                return Err(SpectrumError::Wavelength { wavelength_m });
            }
        }
        for pair in wavelengths_m.windows(2) {
            if pair[1] <= pair[0] {
                return Err(SpectrumError::NotIncreasing { before_m: pair[0], after_m: pair[1] });
            }
        }
        Ok(Self(wavelengths_m))
    }

    /// From `start` to `stop`, both included where the step allows, all in metres.
    ///
    /// # Errors
    /// [`SpectrumError::Regular`] unless `0 < start <= stop`, `step > 0` and there are at most [`Self::MAX_LEN`] points.
    pub fn regular(start_m: f64, stop_m: f64, step_m: f64) -> Result<Self, SpectrumError> {
        let intervals = (stop_m - start_m) / step_m * (1.0 + 1e-12) + 1e-9;
        if !(start_m > 0.0 && stop_m >= start_m && step_m > 0.0 && intervals < Self::MAX_LEN as f64) {
            return Err(SpectrumError::Regular { start_m, stop_m, step_m });
        }
        Self::new((0..=intervals as usize).map(|i| start_m + i as f64 * step_m).collect())
    }

    /// The seventeen wavelengths of frisvad2007: 375 to 775 nm in steps of 25 nm.
    pub fn frisvad2007() -> Self {
        Self((0..17).map(|i| f64::from(375 + 25 * i) * 1e-9).collect())
    }

    /// The wavelengths in metres.
    pub fn as_slice(&self) -> &[f64] {
        &self.0
    }

    /// The wavelengths in metres, in increasing order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        self.0.iter().copied()
    }

    /// How many there are; at least one.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// The shortest and the longest, in metres.
    pub fn range(&self) -> (f64, f64) {
        (self.0[0], self.0[self.0.len() - 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_regular_grid_holds_both_ends() {
        let grid = WavelengthGrid::regular(400e-9, 700e-9, 25e-9).unwrap();
        assert_eq!(grid.len(), 13);
        assert!((grid.range().1 - 700e-9).abs() < 1e-20);
        let seventeen = WavelengthGrid::regular(375e-9, 775e-9, 25e-9).unwrap();
        assert_eq!(seventeen.len(), WavelengthGrid::frisvad2007().len());
        assert_eq!(WavelengthGrid::regular(500e-9, 500e-9, 1e-9).unwrap().len(), 1);
    }

    #[test]
    fn what_is_no_grid_is_refused() {
        assert_eq!(WavelengthGrid::new(vec![]), Err(SpectrumError::Empty));
        assert!(WavelengthGrid::new(vec![5e-7, 5e-7]).is_err());
        assert!(WavelengthGrid::new(vec![f64::NAN]).is_err());
        for (start, stop, step) in
            [(4e-7, 7e-7, 0.0), (4e-7, 7e-7, -1e-9), (7e-7, 4e-7, 1e-9), (0.0, 1e-7, 1e-9), (4e-7, 7e-7, 1e-18)]
        {
            assert!(WavelengthGrid::regular(start, stop, step).is_err(), "{start} {stop} {step}");
        }
        assert!(WavelengthGrid::regular(f64::NAN, 1e-7, 1e-9).is_err());
    }
}
