//! From spectra to what a screen shows: CIE XYZ, linear sRGB, the sRGB transfer curve.

use super::{Lab, WavelengthGrid, cie1931, d65};

/// CIE XYZ (relative to `Y = 1` for white) to linear sRGB with the D65 white point (`iec1999`); may leave [0, 1].
pub fn xyz_to_linear_srgb([x, y, z]: [f64; 3]) -> [f64; 3] {
    [
        3.2404541621141054 * x - 1.5371385127977166 * y - 0.498531409556016 * z,
        -0.969266030505187 * x + 1.8760108454466942 * y + 0.04155601753034984 * z,
        0.05564343095911469 * x - 0.20402591351675387 * y + 1.0572251882231791 * z,
    ]
}

/// Relative luminance of linear sRGB: the `Y` row of the inverse of [`xyz_to_linear_srgb`].
pub fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.21267285140562253 * r + 0.7151521552878178 * g + 0.07217499330655958 * b
}

/// The sRGB curve from a linear value (clamped to [0, 1]) to the encoded one in [0, 1] (`iec1999`).
pub fn srgb_encode(linear: f64) -> f64 {
    let v = linear.clamp(0.0, 1.0);
    if v <= 0.0031308 { 12.92 * v } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 }
}

/// The inverse of [`srgb_encode`], from an encoded value (clamped to [0, 1]).
pub fn srgb_decode(encoded: f64) -> f64 {
    let v = encoded.clamp(0.0, 1.0);
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// The inverse of [`xyz_to_linear_srgb`].
pub fn linear_srgb_to_xyz([r, g, b]: [f64; 3]) -> [f64; 3] {
    [
        0.4124564390896922 * r + 0.357576077643909 * g + 0.18043748326639894 * b,
        luminance([r, g, b]),
        0.019333895582329317 * r + 0.11919202588130297 * g + 0.9503040785363679 * b,
    ]
}

/// XYZ (white `Y = 1`) under D65 of a reflectance given at the wavelengths of `grid` (m), by the trapezoidal rule
/// over the grid; the white of the same grid normalises it.
pub fn reflectance_to_xyz(grid: &WavelengthGrid, reflectance: impl Fn(f64) -> f64) -> [f64; 3] {
    let values: Vec<f64> = grid.iter().map(reflectance).collect();
    Daylight::new(grid).xyz(&values)
}

/// How the CIE 1931 observer sees reflectances under D65 that are known on a grid: by the trapezoidal rule over the grid,
/// relative to its own white.
#[derive(Debug, Clone, PartialEq)]
pub struct Daylight {
    weights: Vec<[f64; 3]>,
}

impl Daylight {
    /// On a grid of wavelengths. One that holds nothing of the visible has black for every colour.
    pub fn new(grid: &WavelengthGrid) -> Self {
        let wavelengths = grid.as_slice();
        let mut weights: Vec<[f64; 3]> = Vec::with_capacity(wavelengths.len());
        for (i, &wavelength) in wavelengths.iter().enumerate() {
            let before = wavelengths[i.saturating_sub(1)];
            let after = wavelengths[(i + 1).min(wavelengths.len() - 1)];
            let width = if wavelengths.len() == 1 { 1.0 } else { 0.5 * (after - before) };
            let power = d65().at(wavelength).unwrap_or(0.0) * width;
            weights.push(cie1931().at(wavelength).map(|matching| matching * power));
        }
        let white: f64 = weights.iter().map(|weight| weight[1]).sum();
        if white > 0.0 {
            weights.iter_mut().flatten().for_each(|weight| *weight /= white);
        } else {
            weights.iter_mut().flatten().for_each(|weight| *weight = 0.0);
        }
        Self { weights }
    }

    /// XYZ (white `Y = 1`) of a reflectance, one value for each wavelength of the grid; missing ones count as 0.
    pub fn xyz(&self, reflectance: &[f64]) -> [f64; 3] {
        let mut xyz = [0.0; 3];
        for (weight, value) in self.weights.iter().zip(reflectance) {
            (0..3).for_each(|c| xyz[c] += weight[c] * value);
        }
        xyz
    }

    /// XYZ of the perfect white.
    pub fn white(&self) -> [f64; 3] {
        self.weights.iter().fold([0.0; 3], |sum, weight| std::array::from_fn(|c| sum[c] + weight[c]))
    }

    /// L*a*b* of a reflectance, relative to the perfect white.
    pub fn lab(&self, reflectance: &[f64]) -> Lab {
        let white = self.white();
        if white.iter().all(|w| *w > 0.0) {
            Lab::from_xyz(self.xyz(reflectance), white)
        } else {
            Lab { l: 0.0, a: 0.0, b: 0.0 }
        }
    }

    /// Linear sRGB of a reflectance; may leave [0, 1].
    pub fn linear_srgb(&self, reflectance: &[f64]) -> [f64; 3] {
        xyz_to_linear_srgb(self.xyz(reflectance))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_is_white() {
        let grid = cie1931().grid().clone();
        let rgb = xyz_to_linear_srgb(reflectance_to_xyz(&grid, |_| 1.0));
        for channel in rgb {
            assert!((channel - 1.0).abs() < 2e-3, "{rgb:?}");
        }
        assert!((luminance([1.0; 3]) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn the_srgb_curve_joins_and_clamps() {
        assert_eq!(srgb_encode(-1.0), 0.0);
        assert!((srgb_encode(2.0) - 1.0).abs() < 1e-12);
        assert!((srgb_encode(0.0031308) - srgb_encode(0.0031309)).abs() < 1e-5);
        assert!((srgb_encode(0.18) - 0.461356).abs() < 1e-5);
    }

    #[test]
    fn there_and_back() {
        for rgb in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.2, 0.3, 0.9]] {
            let back = xyz_to_linear_srgb(linear_srgb_to_xyz(rgb));
            (0..3).for_each(|c| assert!((back[c] - rgb[c]).abs() < 1e-12, "{rgb:?} {back:?}"));
        }
        for i in 0..=255 {
            let code = f64::from(i) / 255.0;
            assert!((srgb_encode(srgb_decode(code)) - code).abs() < 1e-6, "{i}");
        }
    }

    #[test]
    fn nothing_visible_is_black() {
        let infrared = Daylight::new(&WavelengthGrid::new(vec![1.5e-6, 1.6e-6]).unwrap());
        assert_eq!(infrared.lab(&[0.5, 0.5]), Lab { l: 0.0, a: 0.0, b: 0.0 });
        let grid = cie1931().grid().clone();
        let white = Daylight::new(&grid).lab(&vec![1.0; grid.len()]);
        assert!((white.l - 100.0).abs() < 1e-9 && white.chroma() < 1e-9);
    }

    #[test]
    fn a_green_filter_is_green() {
        let grid = cie1931().grid().clone();
        let [r, g, b] =
            xyz_to_linear_srgb(reflectance_to_xyz(&grid, |w| if (500e-9..570e-9).contains(&w) { 1.0 } else { 0.0 }));
        assert!(g > r && g > b);
    }
}
