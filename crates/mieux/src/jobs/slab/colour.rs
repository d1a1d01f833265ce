//! The colour of what is reflected or passes.

use mieux_optics::spectrum::colour::{reflectance_to_xyz, xyz_to_linear_srgb};
use mieux_optics::spectrum::{WavelengthGrid, cie1931};

/// Linear sRGB under D65 for the CIE 1931 observer of shares at the wavelengths of a grid: linear between them, constant
/// beyond the first and the last. Of a single share, the grey of it.
pub(super) fn linear_srgb(grid: Option<&WavelengthGrid>, shares: &[f64]) -> [f64; 3] {
    let (Some(grid), true) = (grid, shares.len() > 1) else {
        return [shares.first().copied().unwrap_or(0.0); 3];
    };
    let wavelengths = grid.as_slice();
    let at = |wavelength: f64| {
        let above = wavelengths.partition_point(|w| *w < wavelength).clamp(1, wavelengths.len() - 1);
        let (from, to) = (wavelengths[above - 1], wavelengths[above]);
        let t = ((wavelength - from) / (to - from)).clamp(0.0, 1.0);
        shares[above - 1] + t * (shares[above] - shares[above - 1])
    };
    xyz_to_linear_srgb(reflectance_to_xyz(cie1931().grid(), at))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_is_white_and_one_number_is_grey() {
        let grid = WavelengthGrid::frisvad2007();
        for channel in linear_srgb(Some(&grid), &[1.0; 17]) {
            assert!((channel - 1.0).abs() < 2e-3);
        }
        assert_eq!(linear_srgb(None, &[0.3]), [0.3; 3]);
    }

    /// A step up at 580 nm is orange to red; the colour must not depend on how finely the plateaux are sampled.
    #[test]
    fn a_step_is_orange_however_finely_it_is_sampled() {
        let step = |w: f64| ((w - 570e-9) / 20e-9).clamp(0.0, 1.0);
        let of = |wavelengths: Vec<f64>| {
            let shares: Vec<f64> = wavelengths.iter().map(|w| step(*w)).collect();
            linear_srgb(Some(&WavelengthGrid::new(wavelengths).unwrap()), &shares)
        };
        let coarse = of(vec![570e-9, 590e-9]);
        let fine = of((38..=78).map(|i| 10e-9 * f64::from(i)).collect());
        for c in 0..3 {
            assert!((coarse[c] - fine[c]).abs() < 2e-3, "{coarse:?} {fine:?}");
        }
        assert!(fine[0] > 0.8 && fine[1] < 0.5 && fine[2] < 0.1, "{fine:?}");
    }
}
