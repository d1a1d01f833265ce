//! The jobs behind `mieux slab`: how much light comes back from layers, passes them, and stays.

mod colour;
mod compare;
mod error;
mod light;
mod look;
mod matter;
mod sample;
mod sheet;
mod solve;
mod stacks;

use std::path::PathBuf;

use mieux_io::output::OutputDir;
use mieux_optics::medium::DEFAULT_TOLERANCE;
use mieux_optics::transfer::DiscreteOrdinates;
use serde::{Deserialize, Serialize};

use super::{Context, Event, JobError, Stage};
pub use compare::{SlabCompare, SlabCompareReport, SlabCompareSheet, Trial};
pub use error::SlabError;
pub use light::{Backing, SlabLight};
pub use look::LayerColour;
pub(super) use look::Look;
use matter::Wanted;
pub use sample::{PhaseName, Sample};
pub use sheet::{Patch, SlabSheet};
pub use solve::{Answer, Solver};
use solve::{Question, solve};
pub use stacks::Case;
use stacks::Stacks;

/// Light onto layers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Slab {
    /// What it falls onto.
    pub sample: Sample,
    /// As typed: `400nm:700nm:25nm` or `450nm,550nm`; the seventeen of frisvad2007 when left out. For materials only.
    #[serde(default)]
    pub wavelengths: Option<String>,
    /// How it falls in.
    #[serde(default)]
    pub light: SlabLight,
    /// What lies below: behind a gap of the medium outside, unless it is in contact.
    #[serde(default)]
    pub backing: Backing,
    /// The backing is in optical contact with the last layer.
    #[serde(default)]
    pub contact: bool,
    /// Refractive index of the medium outside.
    #[serde(default = "one")]
    pub index_outside: f64,
    /// Refractive index of clear slides above and below.
    #[serde(default)]
    pub slides: Option<f64>,
    /// How it is solved.
    #[serde(default)]
    pub solver: Solver,
    /// Streams of solvers that have some, even, 2 to 256; 32 when left out.
    #[serde(default)]
    pub streams: Option<usize>,
    /// Photons for each thickness and wavelength, of the solver that has some; [`Slab::DEFAULT_PHOTONS`] when left out.
    #[serde(default)]
    pub photons: Option<u64>,
    /// The same seed gives the same result, to the bit; 0 when left out.
    #[serde(default)]
    pub seed: Option<u64>,
    /// Relative tolerance of the integral over particle sizes.
    #[serde(default = "default_tolerance")]
    pub tolerance: f64,
    /// Folder for table, JSON and plot; nothing is written when left out.
    #[serde(default)]
    pub output: Option<PathBuf>,
}

fn one() -> f64 {
    1.0
}

fn default_tolerance() -> f64 {
    DEFAULT_TOLERANCE
}

impl Slab {
    /// Photons unless another number is asked for.
    pub const DEFAULT_PHOTONS: u64 = 100_000;
    /// Most photons.
    pub const MAX_PHOTONS: u64 = 1 << 40;
    /// More moments than streams can tell apart: where indices differ, ranges of directions have streams of their own.
    const MARGIN: usize = 32;

    /// Parallel light along the normal onto a sample over black.
    pub fn new(sample: Sample) -> Self {
        Self {
            sample,
            wavelengths: None,
            light: SlabLight::default(),
            backing: Backing::default(),
            contact: false,
            index_outside: 1.0,
            slides: None,
            solver: Solver::Auto,
            streams: None,
            photons: None,
            seed: None,
            tolerance: DEFAULT_TOLERANCE,
            output: None,
        }
    }

    fn streams(&self) -> usize {
        self.streams.unwrap_or(DiscreteOrdinates::default().streams)
    }

    fn photons(&self) -> u64 {
        self.photons.unwrap_or(Self::DEFAULT_PHOTONS)
    }

    /// That nothing was set which the solver has no use for, and that what was set can be.
    fn check(&self) -> Result<(), JobError> {
        let with = || format!("the solver {}", self.solver.resolved());
        let uses = [
            ("a number of streams", self.streams.is_some() && !self.solver.has_streams()),
            ("a number of photons", self.photons.is_some() && !self.solver.has_photons()),
            ("a seed", self.seed.is_some() && !self.solver.has_photons()),
        ];
        if let Some((what, _)) = uses.into_iter().find(|(_, idle)| *idle) {
            return Err(SlabError::Meaningless { what, with: with() }.into());
        }
        self.check_numbers()
    }

    fn check_numbers(&self) -> Result<(), JobError> {
        DiscreteOrdinates::with_streams(self.streams())?;
        if !(1..=Self::MAX_PHOTONS).contains(&self.photons()) {
            let allowed = "from 1 to 2^40 photons can be followed";
            return Err(JobError::Value { name: "photons", value: self.photons().to_string(), allowed });
        }
        Ok(())
    }

    pub(super) fn run(&self, context: &Context<'_>) -> Result<SlabReport, JobError> {
        self.check()?;
        let incidence = self.light.incidence()?;
        let dir = self.output.as_deref().map(OutputDir::create).transpose()?;
        let wanted = Wanted {
            degree: if self.solver.has_streams() { self.streams() + Self::MARGIN } else { 1 },
            functions: self.solver.has_photons(),
            tolerance: self.tolerance,
        };
        let stacks = Stacks::build(self, wanted, context)?;
        let question = Question {
            stacks: &stacks.stacks,
            functions: &stacks.functions,
            incidence,
            streams: self.streams(),
            photons: self.photons(),
            seed: self.seed.unwrap_or(0),
        };
        let answers = solve(self.solver, &question, context)?;
        let sheet = SlabSheet::new(self, stacks, answers);
        let mut files = Vec::new();
        if let Some(dir) = dir {
            context.say(Event::Begin(Stage::Write));
            let (table, json, svg) = (sheet.table()?, sheet.json(), sheet.svg()?);
            files.push(dir.write("slab.csv", |out| table.write_csv(out))?);
            files.push(dir.write("slab.json", |out| Ok(serde_json::to_writer_pretty(out, &json)?))?);
            files.push(dir.write("slab.svg", |out| out.write_all(svg.as_bytes()))?);
            dir.commit();
            context.say(Event::End(Stage::Write));
        }
        Ok(SlabReport { sheet, files })
    }
}

/// What [`Slab`] leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct SlabReport {
    /// The answers.
    pub sheet: SlabSheet,
    /// The files written.
    pub files: Vec<PathBuf>,
}
