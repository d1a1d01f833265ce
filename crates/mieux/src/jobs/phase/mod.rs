//! The job behind `mieux phase`: how scattered light spreads over angle.

mod model;
mod sheet;

use std::path::PathBuf;

use mieux_io::output::OutputDir;
use mieux_io::quantity::Angles;
use mieux_optics::phase::{PhaseFunction, fit};
use serde::{Deserialize, Serialize};

use super::{Context, Event, JobError, Stage};
pub use model::{Named, PhaseModel};
pub use sheet::{Compared, PhaseSheet};

/// A phase function, and others to compare it with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Phase {
    /// The phase function.
    pub function: PhaseModel,
    /// What to compare it with.
    #[serde(default)]
    pub compare: Vec<Comparand>,
    /// Fits keep the mean cosine, at the price of shape.
    #[serde(default)]
    pub keep_asymmetry: bool,
    /// Scattering angles to give values at; every 5 degrees when left out.
    #[serde(default)]
    pub angles: Option<Angles>,
    /// The highest Legendre moment to give.
    #[serde(default = "default_moments")]
    pub moments: u32,
    /// Relative tolerance of Lorenz-Mie results: of the integral over sizes, and of `1 - g`.
    #[serde(default = "default_tolerance")]
    pub tolerance: f64,
    /// Folder for table and plot; nothing is written when left out.
    #[serde(default)]
    pub output: Option<PathBuf>,
}

fn default_moments() -> u32 {
    Phase::DEFAULT_MOMENTS
}

fn default_tolerance() -> f64 {
    Phase::DEFAULT_TOLERANCE
}

/// What a phase function is compared with: a fit to it, or another one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Comparand {
    /// A function of a few parameters, fitted to the one that is asked for.
    Fit(FitKind),
    /// Any other.
    Model(PhaseModel),
}

/// What can be fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FitKind {
    /// One Henyey-Greenstein lobe.
    Hg,
    /// Two Henyey-Greenstein lobes.
    TwoLobeHg,
    /// A Henyey-Greenstein lobe and a Draine lobe.
    HgDraine,
}

impl FitKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Hg, Self::TwoLobeHg, Self::HgDraine];

    /// As it is written down.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hg => "hg",
            Self::TwoLobeHg => "two-lobe-hg",
            Self::HgDraine => "hg-draine",
        }
    }

    fn fit(self, target: &PhaseFunction, options: &fit::Options) -> Result<Named, JobError> {
        let phase: PhaseFunction = match self {
            Self::Hg => fit::henyey_greenstein(target, options)?.phase.into(),
            Self::TwoLobeHg => fit::double_henyey_greenstein(target, options)?.phase.into(),
            Self::HgDraine => fit::henyey_greenstein_draine(target, options)?.phase.into(),
        };
        Ok(Named { name: self.name().to_owned(), title: model::title(&phase), phase })
    }
}

impl Phase {
    /// The highest Legendre moment unless another is asked for.
    pub const DEFAULT_MOMENTS: u32 = 8;
    /// The highest that may be asked for: the time grows with it, and a table has tens of thousands of bins.
    pub const MAX_MOMENTS: u32 = 10_000;
    /// Relative tolerance unless another is asked for.
    pub const DEFAULT_TOLERANCE: f64 = 1e-3;

    /// A phase function by itself, and nothing written.
    pub fn new(function: PhaseModel) -> Self {
        Self {
            function,
            compare: Vec::new(),
            keep_asymmetry: false,
            angles: None,
            moments: Self::DEFAULT_MOMENTS,
            tolerance: Self::DEFAULT_TOLERANCE,
            output: None,
        }
    }

    /// The function and what it is compared with, without what would be compared with itself.
    fn compute(&self, context: &Context<'_>) -> Result<PhaseSheet, JobError> {
        if self.moments > Self::MAX_MOMENTS {
            let allowed = "at most 10000";
            return Err(JobError::Value { name: "moments", value: self.moments.to_string(), allowed });
        }
        context.say(Event::Begin(Stage::Phase));
        let itself = |comparand: &&Comparand| matches!(comparand, Comparand::Model(model) if *model == self.function);
        let others: Vec<&Comparand> = self.compare.iter().filter(|c| !itself(c)).collect();
        let total = 1 + others.len() as u64;
        let function = self.function.compute(self.tolerance)?;
        context.count(Stage::Phase, 1, total);
        let options = fit::Options { keep_asymmetry: self.keep_asymmetry, ..fit::Options::default() };
        let mut sheet = PhaseSheet::new(function, self.angles, self.moments);
        for (i, other) in others.into_iter().enumerate() {
            if context.is_cancelled() {
                return Err(JobError::Cancelled);
            }
            let (named, fitted) = match other {
                Comparand::Fit(kind) => (kind.fit(&sheet.function.phase, &options)?, true),
                Comparand::Model(model) => (model.compute(self.tolerance)?, false),
            };
            sheet.compare(named, fitted);
            context.count(Stage::Phase, i as u64 + 2, total);
        }
        context.say(Event::End(Stage::Phase));
        Ok(sheet)
    }

    pub(super) fn run(&self, context: &Context<'_>) -> Result<PhaseReport, JobError> {
        let dir = self.output.as_deref().map(OutputDir::create).transpose()?;
        let sheet = self.compute(context)?;
        let mut files = Vec::new();
        if let Some(dir) = dir {
            context.say(Event::Begin(Stage::Write));
            let (table, svg, json) = (sheet.table()?, sheet.svg()?, sheet.json());
            files.push(dir.write("phase.csv", |out| table.write_csv(out))?);
            files.push(dir.write("phase.json", |out| Ok(serde_json::to_writer_pretty(out, &json)?))?);
            files.push(dir.write("phase-function.svg", |out| out.write_all(svg.as_bytes()))?);
            dir.commit();
            context.say(Event::End(Stage::Write));
        }
        Ok(PhaseReport { sheet, files })
    }
}

/// What [`Phase`] leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct PhaseReport {
    /// The functions.
    pub sheet: PhaseSheet,
    /// The files written.
    pub files: Vec<PathBuf>,
}
