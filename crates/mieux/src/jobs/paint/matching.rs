//! A recipe for a wanted colour.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use mieux_io::paint::read_spectrum;
use mieux_optics::paint::{PaintSet, Target, find_recipe};
use mieux_optics::spectrum::Lab;
use mieux_optics::spectrum::colour::{linear_srgb_to_xyz, srgb_decode, xyz_to_linear_srgb};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::{Shown, paints};
use crate::jobs::{Context, Event, JobError, Stage};

/// The recipe whose mixture comes nearest to a target.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaintMatch {
    /// The file of paints.
    pub paints: PathBuf,
    /// What the mixture is to look like.
    pub target: PaintTarget,
    /// At most so many paints, 1 to 6.
    #[serde(default = "default_at_most")]
    pub at_most: usize,
}

fn default_at_most() -> usize {
    PaintMatch::DEFAULT_AT_MOST
}

/// What a mixture is to look like: "#c04030", "lab:50,40,30", or the path of a spectrum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum PaintTarget {
    /// A colour of screens: red, green and blue, 0 to 255.
    Srgb([u8; 3]),
    /// CIE L*a*b* under D65.
    Lab([f64; 3]),
    /// A file of reflectance over wavelength.
    Spectrum(PathBuf),
}

impl FromStr for PaintTarget {
    type Err = JobError;

    fn from_str(text: &str) -> Result<Self, JobError> {
        let text = text.trim();
        let wrong = |allowed: &'static str| JobError::Value { name: "target", value: text.to_owned(), allowed };
        if let Some(digits) = text.strip_prefix('#') {
            let allowed = "a colour is as `#c04030`: two hexadecimal digits for each of red, green and blue";
            let long: String = match digits.len() {
                3 => digits.chars().flat_map(|c| [c, c]).collect(),
                _ => digits.to_owned(),
            };
            if long.len() != 6 || !long.is_ascii() {
                return Err(wrong(allowed));
            }
            let code = u32::from_str_radix(&long, 16).map_err(|_| wrong(allowed))?;
            let [_, r, g, b] = code.to_be_bytes();
            return Ok(Self::Srgb([r, g, b]));
        }
        if let Some(numbers) = text.strip_prefix("lab:") {
            let allowed = "a colour is as `lab:50,40,30`, with L* from 0 to 100";
            let numbers: Vec<f64> =
                numbers.split(',').map(|n| n.trim().parse().map_err(|_| wrong(allowed))).collect::<Result<_, _>>()?;
            return match numbers[..] {
                [l, a, b] if (0.0..=100.0).contains(&l) && a.abs() <= 500.0 && b.abs() <= 500.0 => {
                    Ok(Self::Lab([l, a, b]))
                }
                _ => Err(wrong(allowed)),
            };
        }
        if !text.contains(['.', '/', '\\']) {
            return Err(wrong("`#c04030`, `lab:50,40,30` or the path of a spectrum, as in `wanted.csv`, is needed"));
        }
        Ok(Self::Spectrum(text.into()))
    }
}

impl TryFrom<String> for PaintTarget {
    type Error = JobError;

    fn try_from(text: String) -> Result<Self, JobError> {
        text.parse()
    }
}

impl fmt::Display for PaintTarget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Srgb([r, g, b]) => write!(f, "#{r:02x}{g:02x}{b:02x}"),
            Self::Lab([l, a, b]) => write!(f, "lab:{l},{a},{b}"),
            Self::Spectrum(path) => write!(f, "{}", path.display()),
        }
    }
}

impl From<PaintTarget> for String {
    fn from(target: PaintTarget) -> Self {
        target.to_string()
    }
}

/// What [`PaintMatch`] leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct PaintMatchReport {
    /// The recipe that comes nearest, and its mixture.
    pub shown: Shown,
    /// The colour that was wanted.
    pub wanted: Lab,
    /// The same as linear sRGB.
    pub wanted_linear_srgb: [f64; 3],
    /// CIEDE2000 between them.
    pub ciede2000: f64,
    /// Root mean square difference of reflectance, where a spectrum was wanted.
    pub rms: Option<f64>,
}

impl PaintMatchReport {
    /// All of it.
    pub fn json(&self) -> Value {
        let mut all = self.shown.json();
        all["wanted_lab"] = json!([self.wanted.l, self.wanted.a, self.wanted.b]);
        all["ciede2000"] = json!(self.ciede2000);
        all["rms_reflectance"] = json!(self.rms);
        all
    }
}

impl PaintMatch {
    /// So many paints reach every colour that any number of them reaches.
    pub const DEFAULT_AT_MOST: usize = 4;

    pub(in crate::jobs) fn run(&self, context: &Context<'_>) -> Result<PaintMatchReport, JobError> {
        let mut set = paints(&self.paints)?;
        let target = self.target(&mut set)?;
        let daylight = set.daylight();
        let white = daylight.white();
        let (wanted, xyz) = match &target {
            Target::Colour(lab) => (*lab, lab.to_xyz(white)),
            Target::Spectrum(values) => (daylight.lab(values), daylight.xyz(values)),
        };
        context.say(Event::Begin(Stage::Paints));
        let found = find_recipe(&set, &target, self.at_most)?;
        context.say(Event::End(Stage::Paints));
        let wanted_linear_srgb = xyz_to_linear_srgb(xyz);
        let shown = Shown::new(&set, found.recipe, found.reflectance);
        Ok(PaintMatchReport { shown, wanted, wanted_linear_srgb, ciede2000: found.ciede2000, rms: found.rms })
    }

    /// The target at the wavelengths of the paints; of these only those that a spectrum covers are kept.
    fn target(&self, set: &mut PaintSet) -> Result<Target, JobError> {
        Ok(match &self.target {
            PaintTarget::Srgb(code) => {
                let xyz = linear_srgb_to_xyz(code.map(|v| srgb_decode(f64::from(v) / 255.0)));
                Target::Colour(Lab::from_xyz(xyz, linear_srgb_to_xyz([1.0; 3])))
            }
            PaintTarget::Lab([l, a, b]) => Target::Colour(Lab { l: *l, a: *a, b: *b }),
            PaintTarget::Spectrum(path) => {
                let spectrum = read_spectrum(path)?;
                *set = set.within(spectrum.grid().range())?;
                Target::Spectrum(set.grid().iter().map(|w| spectrum.at(w).unwrap_or(f64::NAN)).collect())
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_are_read_and_written() {
        for (text, expected) in [
            ("#c04030", PaintTarget::Srgb([0xc0, 0x40, 0x30])),
            ("lab:50,40,-30.5", PaintTarget::Lab([50.0, 40.0, -30.5])),
            ("wall.csv", PaintTarget::Spectrum("wall.csv".into())),
        ] {
            let found: PaintTarget = text.parse().unwrap();
            assert_eq!(found, expected);
            assert_eq!(found.to_string(), text);
        }
        assert_eq!("#fc0".parse::<PaintTarget>().unwrap(), PaintTarget::Srgb([0xff, 0xcc, 0]));
        for text in ["#12345", "#gggggg", "#ééé", "lab:1,2", "lab:150,0,0", "lab:a,b,c", "lab:nan,0,0", ""] {
            assert!(text.parse::<PaintTarget>().is_err(), "{text}");
        }
    }
}
