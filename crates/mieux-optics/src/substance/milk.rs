//! What milk is made of besides water: fat, and riboflavin dissolved in the water.

use std::sync::LazyLock;

use num_complex::Complex64;

use crate::spectrum::{Sampled, embedded_table};

/// Riboflavin in cow's milk, mg per 100 g (`fox1998`).
pub const NATURAL_RIBOFLAVIN_MG_PER_100G: f64 = 0.17;

/// What riboflavin at the given concentration (mg per 100 g of solution) adds to the imaginary part of the index of
/// water, at a wavelength in metres; `None` outside 375-775 nm unless there is none of it.
///
/// Beer-Lambert: proportional to concentration. Data: `du1998`, as table 4.2 of `frisvad2012`.
pub fn riboflavin_absorption_index(wavelength_m: f64, mg_per_100g: f64) -> Option<f64> {
    static TABLE: LazyLock<Sampled> = LazyLock::new(|| {
        let [n_imag] = embedded_table(include_str!("../../../../data/substances/riboflavin-absorption.csv"));
        n_imag
    });
    if mg_per_100g == 0.0 {
        return Some(0.0);
    }
    Some(TABLE.at(wavelength_m)? * (mg_per_100g / NATURAL_RIBOFLAVIN_MG_PER_100G))
}

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

    #[test]
    fn riboflavin_is_proportional_to_its_concentration() {
        let natural = riboflavin_absorption_index(450e-9, 0.17).unwrap();
        assert!((natural - 4.096e-7).abs() < 1e-20);
        assert!((riboflavin_absorption_index(450e-9, 0.34).unwrap() - 2.0 * natural).abs() < 1e-20);
        assert_eq!(riboflavin_absorption_index(900e-9, 0.0), Some(0.0));
        assert_eq!(riboflavin_absorption_index(900e-9, 0.1), None);
    }
}
