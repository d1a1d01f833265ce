//! How an observer weighs a spectrum, and daylight to look by.

use std::sync::LazyLock;

use super::{Sampled, WavelengthGrid, embedded_table};

/// Three colour-matching functions over wavelength; zero outside their table.
#[derive(Debug, Clone)]
pub struct ColourMatching {
    functions: [Sampled; 3],
}

impl ColourMatching {
    fn parse(text: &str) -> Self {
        Self { functions: embedded_table(text) }
    }

    /// The three functions at a wavelength in metres.
    pub fn at(&self, wavelength_m: f64) -> [f64; 3] {
        self.functions.each_ref().map(|f| f.at(wavelength_m).unwrap_or(0.0))
    }

    /// The wavelengths of the table, m.
    pub fn grid(&self) -> &WavelengthGrid {
        self.functions[0].grid()
    }

    /// The weighted mean of a spectrum by each function: sum of function times value over sum of function,
    /// taken over the samples of the spectrum as frisvad2007 does (section 4), not over an interpolant.
    ///
    /// `weight` multiplies every function, one per sample: `sigma_s` when asymmetries are averaged, else ones.
    pub fn average(&self, spectrum: &Sampled, weight: impl Fn(usize) -> f64) -> [f64; 3] {
        let mut sum = [0.0; 3];
        let mut norm = [0.0; 3];
        for (i, (wavelength, &value)) in spectrum.grid().iter().zip(spectrum.values()).enumerate() {
            for (channel, matching) in self.at(wavelength).into_iter().enumerate() {
                sum[channel] += matching * weight(i) * value;
                norm[channel] += matching * weight(i);
            }
        }
        std::array::from_fn(|channel| sum[channel] / norm[channel])
    }
}

/// CIE 1931 2-degree standard observer, 380 to 780 nm (`cie2018`).
pub fn cie1931() -> &'static ColourMatching {
    static OBSERVER: LazyLock<ColourMatching> =
        LazyLock::new(|| ColourMatching::parse(include_str!("../../../../data/spectra/cie1931-2deg.csv")));
    &OBSERVER
}

/// Stiles and Burch 1959 10-degree RGB colour-matching functions, 390 to 830 nm (`stiles1959`).
pub fn stiles_burch1959() -> &'static ColourMatching {
    static OBSERVER: LazyLock<ColourMatching> =
        LazyLock::new(|| ColourMatching::parse(include_str!("../../../../data/spectra/stiles-burch1959-10deg.csv")));
    &OBSERVER
}

/// CIE standard illuminant D65, relative spectral power, 100 at 560 nm, 300 to 780 nm (`cie2018`).
pub fn d65() -> &'static Sampled {
    static ILLUMINANT: LazyLock<Sampled> = LazyLock::new(|| {
        let [power] = embedded_table(include_str!("../../../../data/spectra/d65.csv"));
        power
    });
    &ILLUMINANT
}

#[cfg(test)]
mod tests {
    use super::*;

    /// White points of the two observers' own definitions: equal energy is (1/3, 1/3) for CIE 1931.
    #[test]
    fn equal_energy_is_white_to_the_standard_observer() {
        let observer = cie1931();
        let mut xyz = [0.0; 3];
        for wavelength in observer.grid().iter() {
            let at = observer.at(wavelength);
            (0..3).for_each(|c| xyz[c] += at[c]);
        }
        let sum: f64 = xyz.iter().sum();
        assert!((xyz[0] / sum - 1.0 / 3.0).abs() < 1e-4);
        assert!((xyz[1] / sum - 1.0 / 3.0).abs() < 1e-4);
        assert_eq!(observer.at(900e-9), [0.0; 3]);
    }

    #[test]
    fn d65_has_its_published_chromaticity() {
        let observer = cie1931();
        let mut xyz = [0.0; 3];
        for wavelength in observer.grid().iter() {
            let at = observer.at(wavelength);
            let power = d65().at(wavelength).unwrap();
            (0..3).for_each(|c| xyz[c] += at[c] * power);
        }
        let sum: f64 = xyz.iter().sum();
        assert!((xyz[0] / sum - 0.31272).abs() < 1e-4, "{}", xyz[0] / sum);
        assert!((xyz[1] / sum - 0.32903).abs() < 1e-4, "{}", xyz[1] / sum);
    }

    #[test]
    fn stiles_burch_primaries_are_pure_at_their_wavelengths() {
        // At 526.3 nm the green function is near 1 and the others vanish.
        let [r, g, b] = stiles_burch1959().at(526.3e-9);
        assert!((g - 1.0).abs() < 0.05 && r.abs() < 0.05 && b.abs() < 0.02, "{r} {g} {b}");
    }

    #[test]
    fn an_average_of_a_constant_is_the_constant() {
        let grid = WavelengthGrid::frisvad2007();
        let flat = Sampled::new(grid.clone(), vec![2.5; grid.len()]).unwrap();
        for channel in stiles_burch1959().average(&flat, |i| 1.0 + i as f64) {
            assert!((channel - 2.5).abs() < 1e-12);
        }
    }
}
