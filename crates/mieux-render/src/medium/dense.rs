//! Spectra as the renderer reads them: evenly spaced, so that a look-up is one product.

use mieux_optics::spectrum::Sampled;

use super::MediumError;
use crate::integrator::Lanes;

/// A spectrum resampled every nanometre or finer over the rendered range; linear in between.
#[derive(Debug, Clone)]
pub(crate) struct Dense {
    start: f64,
    per_metre: f64,
    values: Vec<f64>,
}

impl Dense {
    /// Resamples and checks: every value must satisfy `valid`, or the error names the `rule`.
    pub(crate) fn new(
        what: &'static str,
        spectrum: &Sampled,
        (low, high): (f64, f64),
        rule: &'static str,
        valid: impl Fn(f64) -> bool,
    ) -> Result<Self, MediumError> {
        let steps = ((high - low) / 1e-9 - 1e-6).ceil().max(1.0);
        let mut values = Vec::with_capacity(steps as usize + 1);
        for i in 0..=steps as usize {
            let wavelength_m = (low + (high - low) * (i as f64 / steps)).min(high);
            let Some(value) = spectrum.at(wavelength_m) else {
                return Err(MediumError::Range { what, known_m: spectrum.grid().range(), asked_m: (low, high) });
            };
            if !valid(value) {
                return Err(MediumError::Value { what, wavelength_m, value, rule });
            }
            values.push(value);
        }
        Ok(Self { start: low, per_metre: steps / (high - low), values })
    }

    /// The value at a wavelength (m), clamped to the rendered range.
    #[inline]
    pub(crate) fn at(&self, wavelength: f64) -> f64 {
        let place = ((wavelength - self.start) * self.per_metre).clamp(0.0, (self.values.len() - 1) as f64);
        let below = (place as usize).min(self.values.len() - 2);
        let t = place - below as f64;
        self.values[below] + (self.values[below + 1] - self.values[below]) * t
    }

    /// The same wavelengths, other values.
    pub(crate) fn map(&self, f: impl Fn(f64) -> f64) -> Self {
        Self { values: self.values.iter().map(|&v| f(v)).collect(), ..*self }
    }

    /// The same wavelengths, values by wavelength (m).
    pub(crate) fn by_wavelength(&self, f: impl Fn(f64) -> f64) -> Self {
        let end = self.start + (self.values.len() - 1) as f64 / self.per_metre;
        let at = |i: usize| f((self.start + i as f64 / self.per_metre).min(end));
        Self { values: (0..self.values.len()).map(at).collect(), ..*self }
    }

    /// The sum of two on the same range.
    pub(crate) fn plus(&self, other: &Self) -> Self {
        Self { values: self.values.iter().zip(&other.values).map(|(a, b)| a + b).collect(), ..*self }
    }

    /// Whether another on the same range has the same values.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        self.values == other.values
    }

    /// Mean over the rendered range.
    pub(crate) fn mean(&self) -> f64 {
        self.values.iter().sum::<f64>() / self.values.len() as f64
    }

    /// Whether all values are as asked.
    pub(crate) fn all(&self, f: impl Fn(f64) -> bool) -> bool {
        self.values.iter().all(|&v| f(v))
    }

    /// Rounded to twelve digits after the point, so that media meant to have equal indices have.
    pub(crate) fn rounded(mut self) -> Self {
        self.values.iter_mut().for_each(|v| *v = (*v * 1e12).round() / 1e12);
        self
    }

    /// The values at the wavelengths of a path.
    #[inline]
    pub(crate) fn lanes(&self, wavelengths: &Lanes) -> Lanes {
        wavelengths.map(|w| self.at(w))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mieux_optics::spectrum::WavelengthGrid;

    #[test]
    fn agrees_with_the_samples_and_refuses_what_is_missing() {
        let grid = WavelengthGrid::new(vec![375e-9, 500e-9, 775e-9]).unwrap();
        let spectrum = Sampled::new(grid, vec![1.0, 4.0, 2.0]).unwrap();
        let dense = Dense::new("x", &spectrum, (380e-9, 775e-9), "", |_| true).unwrap();
        for i in 0..1000 {
            let w = 380e-9 + 395e-9 * f64::from(i) / 999.0;
            assert!((dense.at(w) - spectrum.at(w.min(775e-9)).unwrap()).abs() < 1e-9);
        }
        assert!(matches!(
            Dense::new("x", &spectrum, (360e-9, 700e-9), "", |_| true),
            Err(MediumError::Range { what: "x", .. })
        ));
        let refused = Dense::new("x", &spectrum, (400e-9, 700e-9), "must be below 3", |v| v < 3.0);
        assert!(matches!(refused, Err(MediumError::Value { value, .. }) if value >= 3.0));
    }
}
