//! Substances of which all is said by a table or a formula.

use std::sync::{Arc, LazyLock};

use super::dispersion::{Dispersion, Formula, Piece};
use crate::spectrum::{Sampled, embedded_table};

macro_rules! table {
    ($file:literal) => {
        embedded_table(include_str!(concat!("../../../../data/substances/", $file, ".csv")))
    };
}

/// Where what has one index for the eye has it, um.
const VISIBLE: (f64, f64) = (0.36, 0.83);

/// The dispersion of that name, if it is one of these.
pub(super) fn named(name: &str) -> Option<Arc<Dispersion>> {
    static ALL: LazyLock<Vec<Arc<Dispersion>>> = LazyLock::new(|| {
        let tables = [
            ("hematite", table!("hematite")),
            ("ice", table!("ice")),
            ("opac-mineral", table!("opac-mineral")),
            ("opac-soot", table!("opac-soot")),
            ("opac-water-soluble", table!("opac-water-soluble")),
            ("tio2-anatase", table!("tio2-anatase")),
            ("water-hale-querry", super::water::hale_querry().clone()),
            ("water-segelstein", super::water::segelstein().clone()),
        ];
        let tables = tables.map(|(name, [n, k])| both(name, vec![Piece::Table(n)], vec![Piece::Table(k)]));
        tables.into_iter().chain(columns()).chain(formulas()).map(Arc::new).collect()
    });
    ALL.iter().find(|substance| substance.name() == name).cloned()
}

/// A real part alike in the visible, beside a column of appendix C of `frisvad2007`.
fn columns() -> [Dispersion; 4] {
    let [ice] = table!("ice-2007-absorption");
    let [mineral] = table!("mineral-absorption");
    let [algae] = table!("algae-absorption");
    let columns = [("algae", 1.41, algae), ("brine", 1.34, brine_absorption().clone())];
    let columns = columns.into_iter().chain([("ice-2007", 1.31, ice), ("mineral", 1.58, mineral)]);
    let mut columns = columns.map(|(name, n, k)| both(name, vec![cauchy(&[n], VISIBLE)], vec![Piece::Table(k)]));
    std::array::from_fn(|_| columns.next().expect("four of them"))
}

/// Crystals are means over their axes, `(2 n_o + n_e)/3`. What takes no imaginary part has none worth mentioning over
/// the range, or is used for want of one: `docs/substances.md` says which. Formulas by way of the refractiveindex.info
/// database, CC0 1.0; single values are published facts.
fn formulas() -> [Dispersion; 9] {
    let uniaxial = |number, ordinary: &[f64], extraordinary: &[f64], range| {
        Piece::Mean(vec![
            (2.0 / 3.0, formula(number, ordinary, range)),
            (1.0 / 3.0, formula(number, extraordinary, range)),
        ])
    };
    [
        // `ciddor1996`: dry, 15 C, 101.325 kPa, 450 ppm carbon dioxide.
        clear("air-standard", gas(&[0.0, 0.05792105, 238.0185, 0.00167917, 57.362], (0.23, 1.69))),
        // `ghosh1999`, 0.204-2.172 um.
        clear(
            "calcite",
            uniaxial(
                2,
                &[0.73358749, 0.96464345, 1.94325203e-2, 1.82831454, 120.0],
                &[0.35859695, 0.82427830, 1.06689543e-2, 0.14429128, 120.0],
                (0.204, 2.0),
            ),
        ),
        // `malitson1965`, 0.21-3.71 um; it begins to absorb beyond 2 um.
        clear(
            "fused-silica",
            Piece::Formula(formula(
                1,
                &[0.0, 0.6961663, 0.0684043, 0.4079426, 0.1162414, 0.8974794, 9.896161],
                (0.21, 2.0),
            )),
        ),
        // Middle of 1.553 to 1.570 along the axes of kaolinite (`anthony1995`).
        clear("kaolin", cauchy(&[1.56], VISIBLE)),
        // Fresh, 589 nm (`laurie1937`).
        clear("linseed-oil", cauchy(&[1.478], VISIBLE)),
        // `ma2003`, beads in water.
        clear("polystyrene", cauchy(&[1.5725, 0.0031080, -2.0, 0.00034779, -4.0], (0.37, 1.61))),
        // `bond2006`: recommended for the visible at 550 nm.
        both("soot", vec![cauchy(&[1.95], VISIBLE)], vec![cauchy(&[0.79], VISIBLE)]),
        // `michels2008`, who use it from 350 to 900 nm.
        clear("soybean-oil", cauchy(&[1.451, 0.01154, -2.0, -0.001132, -4.0], (0.35, 0.9))),
        // `devore1951`; it begins to absorb below 0.43 um.
        clear(
            "tio2-rutile",
            uniaxial(4, &[5.913, 0.2441, 0.0, 0.0803, 1.0], &[7.197, 0.3322, 0.0, 0.0843, 1.0], (0.43, 1.53)),
        ),
    ]
}

/// Imaginary part of the index of brine in the sea, 375-775 nm.
pub(super) fn brine_absorption() -> &'static Sampled {
    static TABLE: LazyLock<Sampled> = LazyLock::new(|| {
        let [n_imag] = table!("brine-absorption");
        n_imag
    });
    &TABLE
}

fn both(name: &str, real: Vec<Piece>, imaginary: Vec<Piece>) -> Dispersion {
    Dispersion::new(name, real, imaginary).expect("a real part")
}

fn clear(name: &str, real: Piece) -> Dispersion {
    both(name, vec![real], Vec::new()).assume_transparent()
}

fn formula(number: u32, coefficients: &[f64], range_um: (f64, f64)) -> Formula {
    Formula::new(number, coefficients.to_vec(), (range_um.0 * 1e-6, range_um.1 * 1e-6)).expect("a formula")
}

fn cauchy(coefficients: &[f64], range_um: (f64, f64)) -> Piece {
    Piece::Formula(formula(5, coefficients, range_um))
}

fn gas(coefficients: &[f64], range_um: (f64, f64)) -> Piece {
    Piece::Formula(formula(6, coefficients, range_um))
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::*;

    fn index(name: &str, wavelength_m: f64) -> Complex64 {
        named(name).unwrap().index(wavelength_m).unwrap()
    }

    #[test]
    fn indices_are_those_of_handbooks() {
        let d = 589.3e-9;
        for (name, n, tolerance) in [
            // `crc`: air, fused silica (1.4584), ice 1.3091 and 1.3105, calcite 1.6584 and 1.4864.
            ("air-standard", 1.000_277, 1e-6),
            ("fused-silica", 1.4584, 1e-4),
            ("ice", (2.0 * 1.3091 + 1.3105) / 3.0, 3e-4),
            ("calcite", (2.0 * 1.6584 + 1.4864) / 3.0, 2e-4),
            // `devore1951`: 2.613 and 2.909.
            ("tio2-rutile", (2.0 * 2.613 + 2.909) / 3.0, 1e-3),
            // `sultanova2009`: 1.5917 for sheet; beads (`ma2003`) 0.0075 less.
            ("polystyrene", 1.5917, 8e-3),
            // `crc`: anatase 2.561 and 2.488; films are less dense.
            ("tio2-anatase", (2.0 * 2.561 + 2.488) / 3.0, 0.1),
        ] {
            let value = index(name, d).re;
            assert!((value - n).abs() < tolerance, "{name}: {value} against {n}");
        }
    }

    #[test]
    fn tables_are_those_of_their_sources() {
        // `warren2008` at 550 nm; appendix C of `frisvad2007` at 500 nm; OPAC at 550 nm.
        assert!((index("ice", 550e-9) - Complex64::new(1.3110, 2.289e-9)).norm() < 1e-4);
        for (name, wavelength, re, im) in [
            ("ice-2007", 500e-9, 1.31, 5.89e-10),
            ("brine", 500e-9, 1.34, 7.76e-10),
            ("mineral", 500e-9, 1.58, 6.07e-4),
            ("algae", 675e-9, 1.41, 2.53e-4),
            ("soot", 550e-9, 1.95, 0.79),
            ("opac-soot", 550e-9, 1.75, 0.44),
            ("opac-water-soluble", 550e-9, 1.53, 6e-3),
            ("opac-mineral", 550e-9, 1.53, 5.5e-3),
        ] {
            let n = index(name, wavelength);
            assert!((n.re - re).abs() < 1e-12 && (n.im / im - 1.0).abs() < 1e-12, "{name}: {n}");
        }
        // Infrared band of water at 2.94 um, k = 0.298 (`hale1973`: 2.95 um).
        for name in ["water-hale-querry", "water-segelstein"] {
            assert!((index(name, 2.95e-6).im - 0.298).abs() < 0.02, "{name}");
        }
    }
}
