//! The job behind `mieux optics`.

mod folder;

use std::collections::BTreeMap;
use std::path::PathBuf;

use mieux_io::output::OutputDir;
use mieux_io::recipe::Recipe;
use mieux_optics::medium::DEFAULT_TOLERANCE;
use serde::{Deserialize, Serialize};

use super::slab::Look;
use super::{Context, Event, JobError, OpticsSheet, Stage, wavelengths};

/// Optical properties of a material over wavelength.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Optics {
    /// A built-in material, or the path of a recipe.
    pub material: String,
    /// Inputs that differ from the recipe's.
    #[serde(default)]
    pub set: BTreeMap<String, f64>,
    /// As typed: `400nm:700nm:25nm` or `450nm,550nm`; the seventeen of frisvad2007 when left out.
    #[serde(default)]
    pub wavelengths: Option<String>,
    /// Relative tolerance of the integral over particle sizes.
    #[serde(default = "default_tolerance")]
    pub tolerance: f64,
    /// Folder for tables, plots, phase functions and colours; nothing is written when left out.
    #[serde(default)]
    pub output: Option<PathBuf>,
}

fn default_tolerance() -> f64 {
    DEFAULT_TOLERANCE
}

impl Optics {
    /// The properties of a material at the usual wavelengths.
    pub fn new(material: impl Into<String>) -> Self {
        Self {
            material: material.into(),
            set: BTreeMap::new(),
            wavelengths: None,
            tolerance: DEFAULT_TOLERANCE,
            output: None,
        }
    }

    pub(super) fn run(&self, context: &Context<'_>) -> Result<OpticsReport, JobError> {
        let material = Recipe::find(&self.material)?.material(&self.set)?;
        let grid = wavelengths::chosen(self.wavelengths.as_ref(), [&material.medium])?;
        let sheet = OpticsSheet::compute(material, &grid, self.tolerance, context)?;
        let mut files = Vec::new();
        if let Some(folder) = &self.output {
            let dir = OutputDir::create(folder)?;
            let look = Look::compute(&sheet.material, &grid, self.tolerance, context)?;
            context.say(Event::Begin(Stage::Write));
            files = folder::write(&dir, &sheet, &look)?;
            dir.commit();
            context.say(Event::End(Stage::Write));
        }
        Ok(OpticsReport { sheet, files })
    }
}

/// What [`Optics`] leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct OpticsReport {
    /// The properties.
    pub sheet: OpticsSheet,
    /// The files written.
    pub files: Vec<PathBuf>,
}
