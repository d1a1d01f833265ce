//! A mixture as it is shown.

use mieux_io::plot::srgb_hex;
use mieux_io::table::Table;
use mieux_optics::paint::{PaintSet, Recipe};
use mieux_optics::spectrum::Lab;
use serde_json::{Value, json};

use crate::jobs::JobError;

/// A recipe, its reflectance and its colour.
#[derive(Debug, Clone, PartialEq)]
pub struct Shown {
    /// The recipe.
    pub recipe: Recipe,
    /// Wavelengths in vacuum, nm.
    pub wavelengths_nm: Vec<f64>,
    /// Reflectance at each, surface included.
    pub reflectance: Vec<f64>,
    /// Its colour under D65 for the CIE 1931 observer.
    pub lab: Lab,
    /// The same as linear sRGB; outside [0, 1] where a screen cannot show it.
    pub linear_srgb: [f64; 3],
}

impl Shown {
    pub(super) fn new(set: &PaintSet, recipe: Recipe, reflectance: Vec<f64>) -> Self {
        let daylight = set.daylight();
        let (lab, linear_srgb) = (daylight.lab(&reflectance), daylight.linear_srgb(&reflectance));
        let wavelengths_nm = set.grid().iter().map(|w| (w * 1e9 * 1e6).round() / 1e6).collect();
        Self { recipe, wavelengths_nm, reflectance, lab, linear_srgb }
    }

    /// The colour as screens take it, "#1a2b3c", cut off at what they can show.
    pub fn hex(&self) -> String {
        srgb_hex(self.linear_srgb)
    }

    /// Whether a screen can show it.
    pub fn in_gamut(&self) -> bool {
        self.linear_srgb.iter().all(|v| (-1e-3..=1.0 + 1e-3).contains(v))
    }

    /// The range of wavelengths, nm, where it leaves out much of what is visible; colours then are not those of daylight.
    pub fn lacks_visible(&self) -> Option<(f64, f64)> {
        let (from, to) = (*self.wavelengths_nm.first()?, *self.wavelengths_nm.last()?);
        (from > 420.0 || to < 680.0).then_some((from, to))
    }

    /// Reflectance over wavelength.
    ///
    /// # Errors
    /// Never; the columns have one length.
    pub fn table(&self) -> Result<Table, JobError> {
        let Lab { l, a, b } = self.lab;
        Ok(Table::new(self.recipe.describe())
            .with_metadata("colour (CIE L*a*b*, D65, 1931)", format!("{l:.2}, {a:.2}, {b:.2}"))
            .with_metadata("sRGB", self.hex())
            .with_column("wavelength", "nm", self.wavelengths_nm.clone())?
            .with_column("reflectance", "", self.reflectance.clone())?)
    }

    /// All of it.
    pub fn json(&self) -> Value {
        let recipe: serde_json::Map<String, Value> =
            self.recipe.parts().iter().map(|(name, share)| (name.clone(), json!(share))).collect();
        json!({
            "recipe": recipe,
            "lab": [self.lab.l, self.lab.a, self.lab.b],
            "srgb": self.hex(),
            "in_gamut": self.in_gamut(),
            "wavelength_nm": self.wavelengths_nm,
            "reflectance": self.reflectance,
        })
    }
}
