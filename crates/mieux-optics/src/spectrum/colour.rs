//! From spectra to what a screen shows: CIE XYZ, linear sRGB, the sRGB transfer curve.

use super::{WavelengthGrid, cie1931, d65};

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

/// XYZ (white `Y = 1`) under D65 of a reflectance given at the wavelengths of `grid` (m), by the trapezoidal rule
/// over the grid; the white of the same grid normalises it.
pub fn reflectance_to_xyz(grid: &WavelengthGrid, reflectance: impl Fn(f64) -> f64) -> [f64; 3] {
    let mut xyz = [0.0; 3];
    let mut white_y = 0.0;
    let wavelengths = grid.as_slice();
    for (i, &wavelength) in wavelengths.iter().enumerate() {
        let before = wavelengths[i.saturating_sub(1)];
        let after = wavelengths[(i + 1).min(wavelengths.len() - 1)];
        let width = if wavelengths.len() == 1 { 1.0 } else { 0.5 * (after - before) };
        let power = d65().at(wavelength).unwrap_or(0.0) * width;
        let matching = cie1931().at(wavelength);
        let value = reflectance(wavelength);
        (0..3).for_each(|c| xyz[c] += matching[c] * power * value);
        white_y += matching[1] * power;
    }
    if white_y > 0.0 { xyz.map(|v| v / white_y) } else { [0.0; 3] }
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
    fn a_green_filter_is_green() {
        let grid = cie1931().grid().clone();
        let [r, g, b] =
            xyz_to_linear_srgb(reflectance_to_xyz(&grid, |w| if (500e-9..570e-9).contains(&w) { 1.0 } else { 0.0 }));
        assert!(g > r && g > b);
    }
}
