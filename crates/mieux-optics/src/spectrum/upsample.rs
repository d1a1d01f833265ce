//! From linear sRGB to spectra that look like it under D65.

use std::sync::OnceLock;

use super::colour::Daylight;
use super::{Sampled, WavelengthGrid};

/// Wavelengths on which colours are judged, m: every 5 nm of the visible.
fn grid() -> &'static WavelengthGrid {
    static GRID: OnceLock<WavelengthGrid> = OnceLock::new();
    GRID.get_or_init(|| match WavelengthGrid::regular(380e-9, 780e-9, 5e-9) {
        Ok(grid) => grid,
        Err(_) => WavelengthGrid::frisvad2007(),
    })
}

fn daylight() -> &'static Daylight {
    static DAYLIGHT: OnceLock<Daylight> = OnceLock::new();
    DAYLIGHT.get_or_init(|| Daylight::new(grid()))
}

/// A smooth reflectance between 0 and 1 from 380 to 780 nm whose linear sRGB under D65 is as given: a sigmoid of a polynomial
/// of second degree (`jakob2019`). Channels are clamped to [0, 1]; colours that no reflectance has come out as near as the
/// sigmoid gets.
pub fn reflectance_of(rgb: [f64; 3]) -> Sampled {
    let wanted = rgb.map(|v| if v.is_finite() { v.clamp(0.0, 1.0) } else { 0.0 });
    let values = if wanted[0] == wanted[1] && wanted[1] == wanted[2] {
        vec![wanted[0]; grid().len()]
    } else {
        sigmoids(solve(wanted))
    };
    // One finite value per wavelength: this cannot fail.
    Sampled::new(grid().clone(), values).unwrap_or_else(|_| super::d65().clone())
}

/// Spectra of the three channels of light: each factor of D65 looks like its primary, all three together are 1. Outside the
/// colours that light of this smoothness can have, they are negative here and there.
pub fn primaries() -> [Sampled; 3] {
    let parts: [Vec<f64>; 3] = {
        let step = |w: f64, at: f64| 1.0 / (1.0 + (-(w - at) / 11e-9).exp());
        let of = |f: &dyn Fn(f64) -> f64| grid().iter().map(f).collect::<Vec<f64>>();
        [of(&|w| step(w, 588e-9)), of(&|w| step(w, 492e-9) - step(w, 588e-9)), of(&|w| 1.0 - step(w, 492e-9))]
    };
    let colours = [0, 1, 2].map(|i: usize| daylight().linear_srgb(&parts[i]));
    let inverse = invert(&colours);
    [0, 1, 2].map(|channel: usize| {
        let values =
            (0..grid().len()).map(|w| (0..3).map(|part| inverse[channel][part] * parts[part][w]).sum()).collect();
        Sampled::new(grid().clone(), values).unwrap_or_else(|_| super::d65().clone())
    })
}

/// `m` such that `sum over part of m[channel][part] colours[part]` is the unit colour of the channel.
fn invert(colours: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|channel: usize| {
        let unit = std::array::from_fn(|k| if k == channel { 1.0 } else { 0.0 });
        let transposed = std::array::from_fn(|row| std::array::from_fn(|part| colours[part][row]));
        solve3(transposed, unit).unwrap_or(unit)
    })
}

/// The unknowns of three linear equations (Cramer's rule), or `None` where they have none.
fn solve3(a: [[f64; 3]; 3], b: [f64; 3]) -> Option<[f64; 3]> {
    let det = |m: &[[f64; 3]; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let whole = det(&a);
    if whole.abs() < 1e-300 {
        return None;
    }
    Some(std::array::from_fn(|column| {
        let mut with = a;
        (0..3).for_each(|row| with[row][column] = b[row]);
        det(&with) / whole
    }))
}

fn sigmoids(c: [f64; 3]) -> Vec<f64> {
    grid().iter().map(|w| sigmoid(c, w)).collect()
}

/// The polynomial runs over the visible as -1 to 1.
fn sigmoid(c: [f64; 3], wavelength: f64) -> f64 {
    let t = (wavelength - 580e-9) / 200e-9;
    let x = (c[0] * t + c[1]) * t + c[2];
    0.5 + 0.5 * x / (1.0 + x * x).sqrt()
}

/// Newton's method, damped, from grey.
fn solve(wanted: [f64; 3]) -> [f64; 3] {
    let colour = |c: [f64; 3]| daylight().linear_srgb(&sigmoids(c));
    let miss = |rgb: [f64; 3]| (0..3).map(|k| (rgb[k] - wanted[k]).powi(2)).sum::<f64>();
    let mean = (wanted.iter().sum::<f64>() / 3.0).clamp(1e-3, 1.0 - 1e-3);
    let start = (2.0 * mean - 1.0) / (1.0 - (2.0 * mean - 1.0).powi(2)).sqrt();
    let mut c = [0.0, 0.0, start];
    let mut rgb = colour(c);
    for _ in 0..60 {
        if miss(rgb) < 1e-20 {
            break;
        }
        let mut slope = [[0.0; 3]; 3];
        for k in 0..3 {
            let step = 1e-6 * (1.0 + c[k].abs());
            let mut moved = c;
            moved[k] += step;
            let there = colour(moved);
            (0..3).for_each(|row| slope[row][k] = (there[row] - rgb[row]) / step);
        }
        let off = std::array::from_fn(|k| wanted[k] - rgb[k]);
        let Some(change) = solve3(slope, off) else { break };
        let mut damping = 1.0;
        let better = (0..30).find_map(|_| {
            let next = std::array::from_fn(|k| (c[k] + damping * change[k]).clamp(-300.0, 300.0));
            damping *= 0.5;
            let there = colour(next);
            (miss(there) < miss(rgb)).then_some((next, there))
        });
        let Some(better) = better else { break };
        (c, rgb) = better;
    }
    c
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflectances_have_their_colour() {
        for rgb in [[0.2, 0.5, 0.7], [0.8, 0.3, 0.1], [0.05, 0.4, 0.05], [0.5, 0.5, 0.5], [0.9, 0.85, 0.2]] {
            let spectrum = reflectance_of(rgb);
            assert!(spectrum.values().iter().all(|v| (0.0..=1.0).contains(v)));
            let got = daylight().linear_srgb(spectrum.values());
            for k in 0..3 {
                assert!((got[k] - rgb[k]).abs() < 2e-3, "{rgb:?} {got:?}");
            }
        }
        // What no reflectance can be comes near.
        let red = daylight().linear_srgb(reflectance_of([1.0, 0.0, 0.0]).values());
        assert!(red[0] > 0.8 && red[1] < 0.05 && red[2] < 0.05, "{red:?}");
        assert_eq!(reflectance_of([f64::NAN, 0.0, 0.0]).values()[0], 0.0);
    }

    #[test]
    fn primaries_are_the_primaries_and_add_up() {
        let primaries = primaries();
        for (k, primary) in primaries.iter().enumerate() {
            let got = daylight().linear_srgb(primary.values());
            for (c, v) in got.iter().enumerate() {
                assert!((v - if c == k { 1.0 } else { 0.0 }).abs() < 1e-9);
            }
        }
        for w in 0..primaries[0].values().len() {
            assert!((primaries.iter().map(|p| p.values()[w]).sum::<f64>() - 1.0).abs() < 1e-3);
        }
    }
}
