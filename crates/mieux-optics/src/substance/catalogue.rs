//! What is known by name.

use super::brine::BRINE_TEMPERATURES;
use super::error::SubstanceError;
use super::water::{Water, WaterAbsorption};
use super::{Substance, builtin, within};

/// The state in which a substance is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditions {
    /// Temperature, degrees Celsius.
    pub temperature_c: f64,
    /// Salt, g/kg of water with it.
    pub salinity: f64,
}

impl Default for Conditions {
    /// 20 degrees Celsius, no salt.
    fn default() -> Self {
        Self { temperature_c: 20.0, salinity: 0.0 }
    }
}

impl Conditions {
    /// Of a temperature in degrees Celsius, without salt.
    pub fn at(temperature_c: f64) -> Self {
        Self { temperature_c, ..Self::default() }
    }
}

/// A substance that comes with the program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SubstanceEntry {
    /// Its name.
    pub name: &'static str,
    /// What it is, in a line.
    pub about: &'static str,
    /// Keys of `references.bib`.
    pub sources: &'static [&'static str],
    /// Temperatures (degrees Celsius) that it takes, if temperature acts on it.
    pub temperature: Option<(f64, f64)>,
    /// Salinities (g/kg) that it takes, if salinity acts on it.
    pub salinity: Option<(f64, f64)>,
}

/// Temperatures of milk fat, degrees Celsius: measured at 20 and 40.
const FAT_TEMPERATURES: (f64, f64) = (0.0, 60.0);

const fn plain(name: &'static str, about: &'static str, sources: &'static [&'static str]) -> SubstanceEntry {
    SubstanceEntry { name, about, sources, temperature: None, salinity: None }
}

impl SubstanceEntry {
    /// All of them, in alphabetical order.
    pub const ALL: [Self; 29] = [
        plain("air", "air, taken as vacuum: 1", &[]),
        plain("air-standard", "dry air at 15 C and 101.325 kPa", &["ciddor1996"]),
        plain("algae", "algae of coastal waters: 1.41, absorption an example", &["frisvad2007", "bricaud1995"]),
        plain("brine", "brine of the sea and of sea ice as in 2007: 1.34", &["frisvad2007", "pegau1997"]),
        plain("calcite", "calcite, mean over its axes, no absorption", &["ghosh1999"]),
        plain("casein", "casein micelles: 1.503, no absorption", &["attaie2000"]),
        plain("fused-silica", "fused silica, no absorption", &["malitson1965"]),
        plain("hematite", "red iron oxide, mean over its axes", &["querry1985"]),
        plain("ice", "ice at -7 C", &["warren2008"]),
        plain("ice-2007", "ice as in 2007: 1.31", &["frisvad2007", "warren2006", "grenfell1981"]),
        plain("kaolin", "kaolin: 1.56, no absorption", &["anthony1995"]),
        plain("linseed-oil", "fresh linseed oil: 1.478, no absorption", &["laurie1937"]),
        SubstanceEntry {
            temperature: Some(FAT_TEMPERATURES),
            ..plain("milk-fat", "fat of cow's milk", &["walstra1984", "michalski2001"])
        },
        plain("mineral", "minerals of coastal waters: 1.58, absorption an example", &["frisvad2007", "babin2003"]),
        plain("opac-mineral", "mineral dust of OPAC", &["hess1998"]),
        plain("opac-soot", "soot of OPAC", &["hess1998"]),
        plain("opac-water-soluble", "dry water-soluble aerosol of OPAC", &["hess1998"]),
        plain("polystyrene", "polystyrene of beads, no absorption", &["ma2003"]),
        SubstanceEntry {
            temperature: Some(BRINE_TEMPERATURES),
            ..plain(
                "sea-ice-brine",
                "brine in equilibrium with ice",
                &["ulaby1986", "assur1958", "quan1995", "pegau1997"],
            )
        },
        SubstanceEntry {
            temperature: Some(Water::TEMPERATURES),
            ..plain("sea-water", "water with 35 g/kg of salt", &["quan1995", "pope1997", "hale1973", "pegau1997"])
        },
        plain("soda-lime-glass", "low-iron soda-lime glass", &["rubin1985"]),
        plain("soot", "soot: 1.95+0.79i", &["bond2006"]),
        plain("soybean-oil", "soybean oil, no absorption", &["michels2008"]),
        plain("tio2-anatase", "anatase, a polycrystalline film", &["jolivet2023"]),
        plain("tio2-rutile", "rutile, mean over its axes, no absorption", &["devore1951"]),
        SubstanceEntry {
            temperature: Some(Water::TEMPERATURES),
            salinity: Some(Water::SALINITIES),
            ..plain("water", "water", &["quan1995", "pope1997", "hale1973", "pegau1997"])
        },
        plain("water-hale-querry", "water at 25 C, near ultraviolet to far infrared", &["hale1973"]),
        SubstanceEntry {
            temperature: Some(Water::TEMPERATURES),
            salinity: Some(Water::SALINITIES),
            ..plain(
                "water-ioccg",
                "water that absorbs by temperature and salinity",
                &["quan1995", "ioccg2018", "rottgers2014"],
            )
        },
        plain("water-segelstein", "water at 25 C, ultraviolet to radio", &["segelstein1981"]),
    ];

    /// The entry of that name.
    pub fn named(name: &str) -> Option<&'static Self> {
        static ALL: [SubstanceEntry; 29] = SubstanceEntry::ALL;
        ALL.iter().find(|entry| entry.name == name)
    }

    /// Room temperature without salt, or what comes nearest for this substance.
    pub fn typical(&self) -> Conditions {
        let room = Conditions::default();
        let (low, high) = self.temperature.unwrap_or((room.temperature_c, room.temperature_c));
        Conditions { temperature_c: room.temperature_c.clamp(low, high), ..room }
    }

    /// The substance under conditions; those that do not act on it may be anything.
    ///
    /// # Errors
    /// [`SubstanceError::Condition`].
    pub fn substance(&self, conditions: Conditions) -> Result<Substance, SubstanceError> {
        let Conditions { temperature_c, salinity } = conditions;
        let name = || self.name.to_string();
        if let Some(range) = self.temperature {
            within(name, "temperature", "degC", temperature_c, range)?;
        }
        if let Some(range) = self.salinity {
            within(name, "salinity", "g/kg", salinity, range)?;
        }
        Ok(match self.name {
            "air" => Substance::Air,
            "casein" => Substance::Casein,
            "milk-fat" => Substance::MilkFat { temperature_c },
            "soda-lime-glass" => Substance::SodaLimeGlass,
            "sea-ice-brine" => Substance::SeaIceBrine { temperature_c },
            "sea-water" => Substance::Water(Water::new(temperature_c, 35.0, WaterAbsorption::PopeFry)?),
            "water" => Substance::Water(Water::new(temperature_c, salinity, WaterAbsorption::PopeFry)?),
            "water-ioccg" => Substance::Water(Water::new(temperature_c, salinity, WaterAbsorption::Ioccg)?),
            other => {
                let dispersion = builtin::named(other);
                Substance::Dispersive(dispersion.ok_or_else(|| SubstanceError::Unknown { name: name() })?)
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_known_and_has_an_index_in_the_visible() {
        for entry in SubstanceEntry::ALL {
            let substance = Substance::named(entry.name, entry.typical()).unwrap();
            for wavelength in [450e-9, 550e-9, 650e-9] {
                let n = substance.index(wavelength).unwrap();
                assert!(n.re >= 1.0 && n.im >= 0.0, "{}: {n}", entry.name);
            }
            if let Some((first, last)) = substance.wavelength_range() {
                assert!(substance.index(first).is_ok() && substance.index(last).is_ok(), "{}", entry.name);
                for beyond in [first * 0.999, last * 1.001] {
                    let error = substance.index(beyond).unwrap_err();
                    assert!(matches!(error, SubstanceError::Wavelength { .. }), "{}: {error}", entry.name);
                }
            }
        }
        assert!(SubstanceEntry::ALL.is_sorted_by_key(|entry| entry.name));
    }

    #[test]
    fn every_source_is_in_the_bibliography() {
        let references = include_str!("../../../../references.bib");
        for key in SubstanceEntry::ALL.iter().flat_map(|entry| entry.sources) {
            assert!(references.contains(&format!("{{{key},")), "{key}");
        }
    }

    #[test]
    fn conditions_act_where_they_mean_something() {
        let named = |name: &str, temperature_c, salinity| {
            Substance::named(name, Conditions { temperature_c, salinity }).and_then(|s| s.index(550e-9))
        };
        assert_eq!(named("casein", -100.0, 99.0).unwrap().re, 1.503);
        assert_eq!(named("sea-water", 10.0, 0.0).unwrap(), named("water", 10.0, 35.0).unwrap());
        assert!(named("sea-ice-brine", -15.0, 0.0).unwrap().re > 1.365);
        for (name, temperature_c, salinity) in
            [("water", 31.0, 0.0), ("water", 20.0, -1.0), ("sea-ice-brine", 20.0, 0.0)]
        {
            assert!(matches!(named(name, temperature_c, salinity), Err(SubstanceError::Condition { .. })), "{name}");
        }
        let unknown = Substance::named("unobtainium", Conditions::default()).unwrap_err();
        assert_eq!(unknown.to_string(), "there is no substance called `unobtainium`");
    }
}
