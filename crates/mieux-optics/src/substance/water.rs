//! Water, fresh or salt: dispersion by Quan and Fry, absorption by whom you like.

use std::f64::consts::PI;
use std::sync::LazyLock;

use num_complex::Complex64;

use super::error::SubstanceError;
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

/// Wavelengths (m) over which [`quan_fry_index`] holds (`huibers1997`).
const QUAN_FRY: (f64, f64) = (200e-9, 1100e-9);

/// Salinity of the sea (g/kg) to which the difference of brine and water in appendix C of `frisvad2007` belongs.
const SEA: f64 = 35.0;

/// Who measured the absorption of water.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum WaterAbsorption {
    /// `pope1997` and `hale1973` as tabulated in `frisvad2012`, 375-775 nm; salt adds what `pegau1997` found
    /// (the difference of brine and water in appendix C of `frisvad2007`, in proportion to salinity). Temperature does
    /// not act on it.
    #[default]
    PopeFry,
    /// The compilation of `ioccg2018`, 200-1100 nm, where temperature and salinity act (`rottgers2014`); salt 400 nm
    /// and beyond.
    Ioccg,
    /// `hale1973`, 200-1100 nm. Nothing acts on it.
    HaleQuerry,
    /// `segelstein1981`, 200-1100 nm. Nothing acts on it.
    Segelstein,
}

/// Water with salt in it or without.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Water {
    temperature_c: f64,
    salinity: f64,
    absorption: WaterAbsorption,
}

impl Water {
    /// Temperatures (degrees Celsius) for which the real part is known.
    pub const TEMPERATURES: (f64, f64) = (0.0, 30.0);
    /// Salinities (g/kg) for which the real part is known.
    pub const SALINITIES: (f64, f64) = (0.0, 35.0);

    /// Of a temperature in degrees Celsius (0 to 30) and a salinity in g/kg (0 to 35).
    ///
    /// # Errors
    /// [`SubstanceError::Condition`].
    pub fn new(temperature_c: f64, salinity: f64, absorption: WaterAbsorption) -> Result<Self, SubstanceError> {
        let name = || "water".to_string();
        super::within(name, "temperature", "degC", temperature_c, Self::TEMPERATURES)?;
        super::within(name, "salinity", "g/kg", salinity, Self::SALINITIES)?;
        Ok(Self { temperature_c, salinity, absorption })
    }

    /// Pure water at 20 degrees Celsius.
    pub const ROOM: Self = Self { temperature_c: 20.0, salinity: 0.0, absorption: WaterAbsorption::PopeFry };

    /// Salinity, g/kg.
    pub fn salinity(&self) -> f64 {
        self.salinity
    }

    pub(super) fn index(&self, wavelength_m: f64) -> Option<Complex64> {
        let (first, last) = self.wavelength_range();
        let inside = wavelength_m >= first * (1.0 - 1e-12) && wavelength_m <= last * (1.0 + 1e-12);
        let imaginary = if inside { self.imaginary(wavelength_m)? } else { return None };
        Some(Complex64::new(quan_fry_index(wavelength_m, self.temperature_c, self.salinity), imaginary))
    }

    fn imaginary(&self, wavelength_m: f64) -> Option<f64> {
        match self.absorption {
            WaterAbsorption::PopeFry => salt_absorption(wavelength_m, self.salinity),
            WaterAbsorption::Ioccg => {
                let [pure, per_degree, per_salinity] = ioccg();
                let mut absorption = pure.at(wavelength_m)?;
                absorption += 1e-4 * per_degree.at(wavelength_m)? * (self.temperature_c - IOCCG_TEMPERATURE);
                if self.salinity > 0.0 {
                    absorption += 1e-4 * per_salinity.at(wavelength_m)? * self.salinity;
                }
                Some(absorption.max(0.0) * wavelength_m / (4.0 * PI))
            }
            WaterAbsorption::HaleQuerry => hale_querry()[1].at(wavelength_m),
            WaterAbsorption::Segelstein => segelstein()[1].at(wavelength_m),
        }
    }

    pub(super) fn wavelength_range(&self) -> (f64, f64) {
        let table = match self.absorption {
            WaterAbsorption::PopeFry => pure_absorption(),
            WaterAbsorption::Ioccg if self.salinity > 0.0 => &ioccg()[2],
            WaterAbsorption::Ioccg => &ioccg()[0],
            WaterAbsorption::HaleQuerry => &hale_querry()[1],
            WaterAbsorption::Segelstein => &segelstein()[1],
        };
        let (first, last) = table.grid().range();
        (first.max(QUAN_FRY.0), last.min(QUAN_FRY.1))
    }
}

/// Temperature of the pure water in the compilation of `ioccg2018`, degrees Celsius.
const IOCCG_TEMPERATURE: f64 = 22.0;

/// Imaginary part of the index of water with salt in it (g/kg), 375-775 nm.
pub(super) fn salt_absorption(wavelength_m: f64, salinity: f64) -> Option<f64> {
    let pure = pure_absorption().at(wavelength_m)?;
    if salinity == 0.0 {
        return Some(pure);
    }
    let sea = super::builtin::brine_absorption().at(wavelength_m)?;
    Some((pure + (sea - pure) * (salinity / SEA)).max(0.0))
}

/// Imaginary part of the refractive index of pure water.
pub(super) fn pure_absorption() -> &'static Sampled {
    static TABLE: LazyLock<Sampled> = LazyLock::new(|| {
        let [n_imag] = embedded_table(include_str!("../../../../data/substances/water-absorption.csv"));
        n_imag
    });
    &TABLE
}

/// Absorption coefficient of pure water (1/m), and what a degree and a gram of salt per kilogram add (1e-4/m).
fn ioccg() -> &'static [Sampled; 3] {
    static TABLE: LazyLock<[Sampled; 3]> = LazyLock::new(|| {
        let [pure, per_degree] = embedded_table(include_str!("../../../../data/substances/water-ioccg-absorption.csv"));
        let [per_salinity] = embedded_table(include_str!("../../../../data/substances/water-ioccg-salinity.csv"));
        [pure, per_degree, per_salinity]
    });
    &TABLE
}

/// Real and imaginary part (`hale1973`).
pub(super) fn hale_querry() -> &'static [Sampled; 2] {
    static TABLE: LazyLock<[Sampled; 2]> =
        LazyLock::new(|| embedded_table(include_str!("../../../../data/substances/water-hale-querry.csv")));
    &TABLE
}

/// Real and imaginary part (`segelstein1981`).
pub(super) fn segelstein() -> &'static [Sampled; 2] {
    static TABLE: LazyLock<[Sampled; 2]> =
        LazyLock::new(|| embedded_table(include_str!("../../../../data/substances/water-segelstein.csv")));
    &TABLE
}

#[cfg(test)]
mod tests {
    use super::*;

    fn water(temperature_c: f64, salinity: f64, absorption: WaterAbsorption) -> Water {
        Water::new(temperature_c, salinity, absorption).unwrap()
    }

    /// Absorption coefficient, 1/m.
    fn absorption(water: Water, wavelength_m: f64) -> f64 {
        4.0 * PI * water.index(wavelength_m).unwrap().im / wavelength_m
    }

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
        assert_eq!(Water::ROOM.index(475e-9).unwrap().im, 4.309e-10);
        // 0.0565 1/m at 550 nm (`pope1997`).
        assert!((absorption(Water::ROOM, 550e-9) - 0.0565).abs() < 1e-4);
    }

    #[test]
    fn sources_agree_where_water_absorbs_well() {
        // From 600 nm on, where scattering cannot be mistaken for absorption, they differ by 10 %.
        for wavelength in [600e-9, 650e-9, 700e-9, 750e-9] {
            let pope = absorption(Water::ROOM, wavelength);
            for other in [WaterAbsorption::Ioccg, WaterAbsorption::HaleQuerry, WaterAbsorption::Segelstein] {
                let ratio = absorption(water(22.0, 0.0, other), wavelength) / pope;
                assert!((ratio - 1.0).abs() < 0.16, "{other:?} {ratio} at {wavelength}");
            }
        }
    }

    #[test]
    fn temperature_and_salt_act_as_measured() {
        // 0.0106 1/m and degree at 750 nm (`pegau1997`).
        let at = |t| absorption(water(t, 0.0, WaterAbsorption::Ioccg), 750e-9);
        assert!(((at(25.0) - at(15.0)) / 10.0 - 0.0106).abs() < 3e-4);
        // Salt lets more blue-green through and less near ultraviolet (`pegau1997`): -3e-5 1/m per g/kg at 500 nm.
        let slope = |wavelength| {
            (absorption(water(20.0, 35.0, WaterAbsorption::PopeFry), wavelength) - absorption(Water::ROOM, wavelength))
                / 35.0
        };
        assert!((slope(500e-9) + 3e-5).abs() < 1e-5, "{}", slope(500e-9));
        assert!(slope(400e-9) > 5e-5);
    }

    #[test]
    fn where_nothing_is_known_nothing_is_said() {
        assert!(Water::new(-1.0, 0.0, WaterAbsorption::PopeFry).is_err());
        assert!(Water::new(f64::NAN, 0.0, WaterAbsorption::PopeFry).is_err());
        let error = Water::new(20.0, 36.0, WaterAbsorption::PopeFry).unwrap_err();
        assert_eq!(error.to_string(), "water: salinity 36 g/kg is out of range: 0 to 35 g/kg");
        assert!(Water::ROOM.index(374e-9).is_none() && Water::ROOM.index(776e-9).is_none());
        let wide = water(20.0, 0.0, WaterAbsorption::Ioccg);
        assert!(wide.index(200e-9).is_some() && wide.index(1100e-9).is_some() && wide.index(1101e-9).is_none());
        assert!(water(20.0, 10.0, WaterAbsorption::Ioccg).index(390e-9).is_none());
        assert!(water(20.0, 0.0, WaterAbsorption::HaleQuerry).index(199e-9).is_none());
    }
}
