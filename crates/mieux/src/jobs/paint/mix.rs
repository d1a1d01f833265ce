//! What a mixture looks like.

use std::collections::BTreeMap;
use std::path::PathBuf;

use mieux_io::quantity::Length;
use mieux_optics::paint::Recipe;
use mieux_optics::transfer::kubelka_munk::Chart;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::{Shown, named, paints};
use crate::jobs::{Context, JobError};

/// Paints mixed in proportion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaintMix {
    /// The file of paints.
    pub paints: PathBuf,
    /// Paints and their amounts, in any one unit.
    pub recipe: BTreeMap<String, f64>,
    /// Thickness of the film; opaque when left out.
    #[serde(default)]
    pub thickness: Option<Length>,
    /// Reflectance of what is below the film.
    #[serde(default)]
    pub backing: f64,
}

/// What [`PaintMix`] leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct PaintMixReport {
    /// The mixture.
    pub shown: Shown,
    /// Thickness (m) at which it hides a black and white chart, where the file says how much its reference scatters.
    pub hiding_thickness: Option<f64>,
}

impl PaintMixReport {
    /// All of it.
    pub fn json(&self) -> Value {
        let mut all = self.shown.json();
        all["hiding_thickness_m"] = json!(self.hiding_thickness);
        all
    }
}

impl PaintMix {
    pub(in crate::jobs) fn run(&self, _context: &Context<'_>) -> Result<PaintMixReport, JobError> {
        let set = paints(&self.paints)?;
        let recipe = Recipe::new(self.recipe.clone())?;
        let reflectance = match self.thickness {
            Some(thickness) => set.reflectance_over(&recipe, thickness.metres(), self.backing),
            None => set.reflectance(&recipe),
        };
        let reflectance = reflectance.map_err(|error| named(error, &set))?;
        let hiding_thickness = match set.scattering() {
            // Some mixtures never hide, which is no reason to say nothing about them.
            Some(_) => set.hiding_thickness(&recipe, Chart::default(), Chart::COMPLETE).ok(),
            None => None,
        };
        Ok(PaintMixReport { shown: Shown::new(&set, recipe, reflectance), hiding_thickness })
    }
}
