//! The job behind `mieux compare`: two materials, or a material and a measurement, side by side.

mod sheet;

use std::collections::BTreeMap;
use std::path::PathBuf;

use mieux_io::measured::Measured;
use mieux_io::output::OutputDir;
use mieux_io::recipe::Recipe;
use mieux_optics::medium::DEFAULT_TOLERANCE;
use serde::{Deserialize, Serialize};

use super::{Context, Event, JobError, OpticsSheet, Stage, wavelengths};
pub use sheet::{CompareSheet, Difference, Side};

/// A material beside another, beside measurements, or both.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Compare {
    /// The first material, to which the others are compared.
    pub material: String,
    /// Inputs that differ from its recipe's.
    #[serde(default)]
    pub set: BTreeMap<String, f64>,
    /// The other material.
    #[serde(default)]
    pub other: Option<String>,
    /// Inputs that differ from its recipe's.
    #[serde(default)]
    pub set_other: BTreeMap<String, f64>,
    /// A table of measurements ([`Measured`]).
    #[serde(default)]
    pub measured: Option<PathBuf>,
    /// As typed; where left out, those of the measurements, or the seventeen of frisvad2007.
    #[serde(default)]
    pub wavelengths: Option<String>,
    /// Relative tolerance of the integral over particle sizes.
    #[serde(default = "default_tolerance")]
    pub tolerance: f64,
    /// Folder for table, JSON and plot; nothing is written when left out.
    #[serde(default)]
    pub output: Option<PathBuf>,
}

fn default_tolerance() -> f64 {
    DEFAULT_TOLERANCE
}

impl Compare {
    /// A material, to be beside something yet to be said.
    pub fn new(material: impl Into<String>) -> Self {
        Self {
            material: material.into(),
            set: BTreeMap::new(),
            other: None,
            set_other: BTreeMap::new(),
            measured: None,
            wavelengths: None,
            tolerance: DEFAULT_TOLERANCE,
            output: None,
        }
    }

    pub(super) fn run(&self, context: &Context<'_>) -> Result<CompareReport, JobError> {
        if self.other.is_none() && self.measured.is_none() {
            return Err(JobError::NothingToCompare);
        }
        let measured = self.measured.as_ref().map(|path| Measured::read(path)).transpose()?;
        let mut materials = vec![Recipe::find(&self.material)?.material(&self.set)?];
        if let Some(other) = &self.other {
            materials.push(Recipe::find(other)?.material(&self.set_other)?);
        }
        let grid = match (&self.wavelengths, &measured) {
            (None, Some(measured)) => measured.grid.clone(),
            (text, _) => wavelengths::chosen(text.as_ref(), materials.iter().map(|m| &m.medium))?,
        };
        let mut sides = Vec::new();
        for (material, set) in materials.into_iter().zip([&self.set, &self.set_other]) {
            sides.push(Side::computed(&OpticsSheet::compute(material, &grid, self.tolerance, context)?, set));
        }
        if let (Some(measured), Some(path)) = (&measured, &self.measured) {
            sides.push(Side::measured(path, measured, &grid));
        }
        let sheet = CompareSheet::new(grid, sides);
        let mut files = Vec::new();
        if let Some(folder) = &self.output {
            let (table, json, svg) = (sheet.table()?, sheet.json(), sheet.svg()?);
            let dir = OutputDir::create(folder)?;
            context.say(Event::Begin(Stage::Write));
            files.push(dir.write("compare.csv", |out| table.write_csv(out))?);
            files.push(dir.write("compare.json", |out| Ok(serde_json::to_writer_pretty(out, &json)?))?);
            files.push(dir.write("compare.svg", |out| out.write_all(svg.as_bytes()))?);
            dir.commit();
            context.say(Event::End(Stage::Write));
        }
        Ok(CompareReport { sheet, files })
    }
}

/// What [`Compare`] leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct CompareReport {
    /// What was found.
    pub sheet: CompareSheet,
    /// The files written.
    pub files: Vec<PathBuf>,
}
