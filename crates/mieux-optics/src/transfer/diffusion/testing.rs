//! What every model is put to.

use super::{DiffusionMedium, radial};

/// From white to black, from thin to dense, with and without a surface.
pub fn media() -> Vec<DiffusionMedium> {
    let all = [
        (0.0, 1e3, 0.0, 1.0),
        (0.0, 5e4, 0.95, 1.347),
        (6.08, 57_837.0, 0.954, 1.347),
        (1.1, 2550.0, 0.0, 1.3),
        (1e-9, 1.0, 0.5, 1.5),
        (0.5, 1.0, 0.3, 0.75),
        (30.0, 20.0, -0.4, 2.0),
        (1e6, 1e3, 0.0, 1.3),
        (100.0, 0.0, 0.0, 1.33),
    ];
    all.into_iter().filter_map(|(a, s, g, n)| DiffusionMedium::new(a, s, g, n).ok()).collect()
}

/// That a total is the integral of a profile over the surface.
pub fn check_total(medium: &DiffusionMedium, sigma: f64, profile: impl Fn(f64) -> f64, total: f64) {
    let integral = radial::area_integral(profile, 1.0 / medium.reduced_extinction(), sigma);
    assert!((integral - total).abs() < 2e-9 * (1e-3 + total.abs()), "{medium:?}: {total} is not {integral}");
}

/// That a profile is finite and not negative at every distance, and falls.
pub fn check_places(medium: &DiffusionMedium, profile: impl Fn(f64) -> f64) {
    let length = 1.0 / medium.reduced_extinction();
    let mut before = f64::INFINITY;
    for k in -60..=200 {
        let value = profile(length * 10f64.powf(0.1 * f64::from(k)));
        assert!(value >= 0.0 && value.is_finite(), "{medium:?} at 10^{k}: {value}");
        assert!(value <= before * (1.0 + 1e-9), "{medium:?} at 10^{k}: {value} after {before}");
        before = value;
    }
    for r in [0.0, 1e200, f64::INFINITY] {
        let value = profile(r);
        assert!(value >= 0.0 && value.is_finite(), "{medium:?} at {r}: {value}");
    }
}
