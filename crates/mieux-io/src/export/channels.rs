//! Three channels of colour out of a spectrum.
//!
//! A channel's value is a weighted mean. The weights are what makes linear sRGB of light of the CIE 1931 observer under
//! D65, without their negative lobes: so a mean lies between the least and the largest of the spectrum, and no
//! coefficient comes out negative.

use mieux_optics::spectrum::colour::xyz_to_linear_srgb;
use mieux_optics::spectrum::{Sampled, WavelengthGrid, cie1931, d65};

use super::ExportError;

/// What it says in files.
pub const PATH: &str = "three channels (linear sRGB), means over wavelength weighted by the CIE 1931 observer under D65, negative lobes left out";

/// Share of a channel's weight that the wavelengths must hold.
const LEAST: f64 = 0.5;

/// Weights of the three channels over wavelength.
pub struct Channels {
    /// Wavelengths in m and the weights there; none where there is a single wavelength, which all channels share.
    weights: Vec<(f64, [f64; 3])>,
    of_wavelengths: Vec<Option<usize>>,
}

impl Channels {
    /// Of what lies between the first and the last wavelength of a grid.
    ///
    /// # Errors
    /// [`ExportError::Channel`] if less than half of a channel's weight does.
    pub fn new(grid: &WavelengthGrid) -> Result<Self, ExportError> {
        if grid.len() == 1 {
            return Ok(Self { weights: Vec::new(), of_wavelengths: vec![Some(0)] });
        }
        let (first, last) = grid.range();
        let mut all = [0.0; 3];
        let mut inside = [0.0; 3];
        let mut weights = Vec::new();
        for wavelength in cie1931().grid().iter() {
            let weight = weights_at(wavelength);
            let within = wavelength >= first * (1.0 - 1e-12) && wavelength <= last * (1.0 + 1e-12);
            for c in 0..3 {
                all[c] += weight[c];
                inside[c] += if within { weight[c] } else { 0.0 };
            }
            if within {
                weights.push((wavelength, weight));
            }
        }
        for (c, channel) in ["red", "green", "blue"].into_iter().enumerate() {
            let share = inside[c] / all[c];
            if share < LEAST {
                return Err(ExportError::Channel { channel, share });
            }
        }
        let strongest = |wavelength: f64| {
            let weight = weights_at(wavelength);
            (0..3).filter(|c| weight[*c] > 0.0).max_by(|a, b| weight[*a].total_cmp(&weight[*b]))
        };
        Ok(Self { weights, of_wavelengths: grid.iter().map(strongest).collect() })
    }

    /// The means of a spectrum that is linear between the wavelengths of the grid.
    pub fn average(&self, grid: &WavelengthGrid, values: &[f64]) -> [f64; 3] {
        let Ok(spectrum) = Sampled::new(grid.clone(), values.to_vec()) else { return [f64::NAN; 3] };
        if self.weights.is_empty() {
            return [values[0]; 3];
        }
        let (mut sum, mut norm) = ([0.0; 3], [0.0; 3]);
        for &(wavelength, weight) in &self.weights {
            let Some(value) = spectrum.at(wavelength) else { continue };
            for c in 0..3 {
                sum[c] += weight[c] * value;
                norm[c] += weight[c];
            }
        }
        std::array::from_fn(|c| sum[c] / norm[c])
    }

    /// The channel that weighs most at each wavelength of the grid; none where none does.
    pub fn of_wavelengths(&self) -> &[Option<usize>] {
        &self.of_wavelengths
    }
}

fn weights_at(wavelength: f64) -> [f64; 3] {
    let power = d65().at(wavelength).unwrap_or(0.0);
    xyz_to_linear_srgb(cie1931().at(wavelength)).map(|weight| power * weight.max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_lie_within_the_spectrum_and_follow_its_colour() {
        let grid = WavelengthGrid::frisvad2007();
        let channels = Channels::new(&grid).unwrap();
        for channel in channels.average(&grid, &vec![3.0; grid.len()]) {
            assert!((channel - 3.0).abs() < 1e-12);
        }
        let rising: Vec<f64> = grid.iter().map(|w| w * 1e9).collect();
        let [r, g, b] = channels.average(&grid, &rising);
        // Dominant wavelengths of the channels; a mean by hand lies near the peaks of the weights.
        assert!(
            (590.0..620.0).contains(&r) && (530.0..560.0).contains(&g) && (440.0..470.0).contains(&b),
            "{r} {g} {b}"
        );
        let of = |nm: f64| {
            let i = grid.iter().position(|w| (w - nm * 1e-9).abs() < 1e-12).unwrap();
            channels.of_wavelengths()[i]
        };
        assert_eq!([of(450.0), of(550.0), of(650.0)], [Some(2), Some(1), Some(0)]);
    }

    #[test]
    fn a_single_wavelength_is_grey_and_too_few_are_refused() {
        let one = WavelengthGrid::new(vec![550e-9]).unwrap();
        assert_eq!(Channels::new(&one).unwrap().average(&one, &[7.0]), [7.0; 3]);
        let green = WavelengthGrid::regular(520e-9, 580e-9, 10e-9).unwrap();
        let Err(ExportError::Channel { channel, share }) = Channels::new(&green) else { panic!("must be refused") };
        assert!(channel == "red" && share < 0.2, "{channel} {share}");
    }
}
