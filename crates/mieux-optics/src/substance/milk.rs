//! Milk fat.

use std::sync::LazyLock;

use num_complex::Complex64;

use crate::spectrum::{Sampled, embedded_table};

/// Imaginary part of the refractive index of milk fat.
pub(super) fn fat_absorption() -> &'static Sampled {
    static TABLE: LazyLock<Sampled> = LazyLock::new(|| {
        let [n_imag] = embedded_table(include_str!("../../../../data/substances/milk-fat-absorption.csv"));
        n_imag
    });
    &TABLE
}

/// Eq 4.35 of `frisvad2012` with `b = 3.73` measured at 20 C and 3.77 at 40 C, linear in between and beyond.
pub(super) fn fat_index(wavelength_m: f64, temperature_c: f64) -> Option<Complex64> {
    let b = 3.73 + (3.77 - 3.73) * (temperature_c - 20.0) / 20.0;
    let l2 = (wavelength_m * 1e6).powi(2);
    let real = (((b + 2.0) * l2 - 0.03) / ((b - 1.0) * l2 - 0.03)).sqrt();
    Some(Complex64::new(real, fat_absorption().at(wavelength_m)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fat_has_its_measured_index() {
        // 1.461 at 589 nm and 20 C (`michalski2001`); 1.4552 at 40 C follows from b = 3.77 (`walstra1984`).
        assert!((fat_index(589e-9, 20.0).unwrap().re - 1.461).abs() < 5e-4);
        assert!((fat_index(589e-9, 40.0).unwrap().re - 1.4552).abs() < 5e-4);
    }
}
