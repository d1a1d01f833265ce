//! Glass to put things in.

use std::sync::LazyLock;

use num_complex::Complex64;

use crate::spectrum::{Sampled, embedded_table};

/// Real and imaginary part of low-iron soda-lime glass (`rubin1985`).
pub(super) fn soda_lime() -> &'static [Sampled; 2] {
    static TABLE: LazyLock<[Sampled; 2]> =
        LazyLock::new(|| embedded_table(include_str!("../../../../data/substances/soda-lime-glass.csv")));
    &TABLE
}

pub(super) fn soda_lime_index(wavelength_m: f64) -> Option<Complex64> {
    let [real, imaginary] = soda_lime();
    Some(Complex64::new(real.at(wavelength_m)?, imaginary.at(wavelength_m)?))
}
