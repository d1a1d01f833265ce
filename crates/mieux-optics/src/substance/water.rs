//! Water: dispersion by Quan and Fry, absorption by Pope and Fry with Hale and Querry beyond.

use std::sync::LazyLock;

use num_complex::Complex64;

use crate::spectrum::{Sampled, embedded_table};

/// Real part of the refractive index of water or sea water (`quan1995`, as eq 4.34 of `frisvad2012`).
///
/// Wavelength in metres (400-700 nm; found to hold over 200-1100 nm by `huibers1997`), temperature 0-30 degrees Celsius,
/// salinity 0-35 g/kg. Outside these the formula is evaluated all the same.
pub fn quan_fry_index(wavelength_m: f64, temperature_c: f64, salinity: f64) -> f64 {
    let (l, t, s) = (wavelength_m * 1e9, temperature_c, salinity);
    1.31405 + (1.779e-4 - 1.05e-6 * t + 1.6e-8 * t * t) * s - 2.02e-6 * t * t + (15.868 + 0.01155 * s - 0.00423 * t) / l
        - 4382.0 / (l * l)
        + 1.1455e6 / (l * l * l)
}

/// Imaginary part of the refractive index of pure water.
pub(super) fn absorption() -> &'static Sampled {
    static TABLE: LazyLock<Sampled> = LazyLock::new(|| {
        let [n_imag] = embedded_table(include_str!("../../../../data/substances/water-absorption.csv"));
        n_imag
    });
    &TABLE
}

pub(super) fn index(wavelength_m: f64, temperature_c: f64) -> Option<Complex64> {
    Some(Complex64::new(quan_fry_index(wavelength_m, temperature_c, 0.0), absorption().at(wavelength_m)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn water_has_the_index_that_handbooks_give() {
        // 589.3 nm: 1.33299 at 20 C (`daimon2007`), sea water of 35 g/kg about 0.0064 more.
        assert!((quan_fry_index(589.3e-9, 20.0, 0.0) - 1.33299).abs() < 5e-5);
        let salt = quan_fry_index(589.3e-9, 20.0, 35.0) - quan_fry_index(589.3e-9, 20.0, 0.0);
        assert!((salt - 0.0064).abs() < 3e-4);
        assert!(quan_fry_index(589.3e-9, 5.0, 0.0) > quan_fry_index(589.3e-9, 25.0, 0.0));
    }

    #[test]
    fn absorption_at_a_table_node_is_the_table() {
        let n = index(475e-9, 20.0).unwrap();
        assert_eq!(n.im, 4.309e-10);
    }
}
