//! The job behind `mieux export`: a material for another renderer.

mod sheet;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use mieux_io::export::{Format, Kept, Phases, PhasesNeeded, Subject, write};
use mieux_io::output::OutputDir;
use mieux_io::quantity::{Length, parse_wavelengths};
use mieux_io::recipe::{Material, Recipe};
use mieux_optics::phase::SpectralPhase;
use mieux_optics::spectrum::WavelengthGrid;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{Context, Event, JobError, OpticsSheet, Stage};
pub use sheet::{ExportReport, ExportSheet};

/// A material, written for another renderer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Export {
    /// A built-in material, or the path of a recipe.
    pub material: String,
    /// For whom.
    pub to: Format,
    /// Inputs that differ from the recipe's.
    #[serde(default)]
    pub set: BTreeMap<String, f64>,
    /// As typed: `400nm:700nm:25nm` or `450nm,550nm`; the seventeen of frisvad2007 when left out.
    #[serde(default)]
    pub wavelengths: Option<String>,
    /// Length of a scene unit, m.
    #[serde(default = "default_scale")]
    pub metres_per_unit: f64,
    /// What stays right where one asymmetry stands for all wavelengths.
    #[serde(default)]
    pub keep: Kept,
    /// Write reduced scattering and an isotropic phase function.
    #[serde(default)]
    pub isotropic: bool,
    /// Where a single phase function is taken: at the wavelength nearest to this.
    #[serde(default = "default_phase_at")]
    pub phase_at: Length,
    /// Write formats that are drafts.
    #[serde(default)]
    pub draft: bool,
    /// Relative tolerance of the integral over particle sizes, and of `1 - g` of phase functions.
    #[serde(default = "default_tolerance")]
    pub tolerance: f64,
    /// Folder for the files; `out/NAME-FORMAT` when left out.
    #[serde(default)]
    pub output: Option<PathBuf>,
}

fn default_scale() -> f64 {
    1.0
}

fn default_phase_at() -> Length {
    Length::GREEN
}

fn default_tolerance() -> f64 {
    Export::DEFAULT_TOLERANCE
}

impl Export {
    /// Relative tolerance unless another is asked for.
    pub const DEFAULT_TOLERANCE: f64 = 1e-3;

    /// A material at the usual wavelengths, in metres.
    pub fn new(material: impl Into<String>, to: Format) -> Self {
        Self {
            material: material.into(),
            to,
            set: BTreeMap::new(),
            wavelengths: None,
            metres_per_unit: default_scale(),
            keep: Kept::default(),
            isotropic: false,
            phase_at: default_phase_at(),
            draft: false,
            tolerance: Self::DEFAULT_TOLERANCE,
            output: None,
        }
    }

    pub(super) fn run(&self, context: &Context<'_>) -> Result<ExportReport, JobError> {
        let material = Recipe::find(&self.material)?.material(&self.set)?;
        let grid = match &self.wavelengths {
            Some(text) => parse_wavelengths(text)?,
            None => WavelengthGrid::frisvad2007(),
        };
        let folder = self
            .output
            .clone()
            .unwrap_or_else(|| Path::new("out").join(format!("{}-{}", material.name, self.to.name())));
        let sheet = OpticsSheet::compute(material, &grid, self.tolerance, context)?;
        let phases = self.phases(&sheet.material, &grid, context)?;
        let subject = self.subject(&sheet, phases);
        let written = write(self.to, &subject)?;
        let dir = OutputDir::create(&folder)?;
        context.say(Event::Begin(Stage::Write));
        let mut files = Vec::new();
        for (name, bytes) in &written.files {
            files.push(dir.write(name, |out| out.write_all(bytes))?);
        }
        dir.commit();
        context.say(Event::End(Stage::Write));
        Ok(ExportReport { sheet: ExportSheet { format: self.to, subject, written }, files })
    }

    /// The phase functions that the format asks for.
    fn phases(&self, material: &Material, grid: &WavelengthGrid, context: &Context<'_>) -> Result<Phases, JobError> {
        let medium_error = |source| JobError::Medium { material: material.name.clone(), source };
        let at = |wavelength: f64| material.medium.phase_at(wavelength, self.tolerance).map_err(medium_error);
        match self.to.phases() {
            PhasesNeeded::One if !self.isotropic => {
                context.say(Event::Begin(Stage::Phase));
                let away = |w: &f64| (w - self.phase_at.metres()).abs();
                let nearest = grid.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
                let wavelength_m = nearest.unwrap_or(self.phase_at.metres());
                let function = at(wavelength_m)?;
                context.say(Event::End(Stage::Phase));
                Ok(Phases::One { wavelength_m, function })
            }
            PhasesNeeded::All => {
                context.say(Event::Begin(Stage::Phase));
                let (total, done) = (grid.len() as u64, AtomicU64::new(0));
                let functions: Result<Vec<_>, JobError> = grid
                    .as_slice()
                    .par_iter()
                    .map(|&wavelength| {
                        if context.is_cancelled() {
                            return Err(JobError::Cancelled);
                        }
                        let function = at(wavelength)?;
                        context.count(Stage::Phase, done.fetch_add(1, Ordering::Relaxed) + 1, total);
                        Ok(function)
                    })
                    .collect();
                context.say(Event::End(Stage::Phase));
                Ok(Phases::All(SpectralPhase::new(grid.clone(), functions?)?))
            }
            _ => Ok(Phases::None),
        }
    }

    fn subject(&self, sheet: &OpticsSheet, phases: Phases) -> Subject {
        let (material, bulk) = (&sheet.material, &sheet.bulk);
        let inputs: Vec<String> =
            material.inputs.iter().map(|(input, value)| format!("{} = {value} {}", input.name, input.unit)).collect();
        let source = format!(
            "computed by mieux {} from what it is made of: {}{}",
            env!("CARGO_PKG_VERSION"),
            self.material,
            if inputs.is_empty() { String::new() } else { format!(" ({})", inputs.join(", ")) }
        );
        Subject {
            name: material.name.clone(),
            title: material.title.clone(),
            source,
            grid: bulk.grid().clone(),
            sigma_s: bulk.sigma_s().to_vec(),
            sigma_a: bulk.sigma_a().to_vec(),
            asymmetry: bulk.asymmetry().to_vec(),
            refractive_index: bulk.n_real().to_vec(),
            phases,
            metres_per_unit: self.metres_per_unit,
            kept: self.keep,
            isotropic: self.isotropic,
            drafts: self.draft,
        }
    }
}
