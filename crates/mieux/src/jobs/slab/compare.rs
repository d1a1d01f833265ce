//! All solvers side by side.

use std::path::PathBuf;
use std::time::Instant;

use mieux_io::output::OutputDir;
use mieux_io::table::Table;
use mieux_optics::transfer::Shares;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::super::{Context, Event, JobError, Stage};
use super::sheet::{QUANTITIES, Quantity};
use super::{Answer, Question, Slab, SlabError, SlabSheet, Solver, Stacks, Wanted, solve};

/// Streams of the answer that all others are compared with.
const REFERENCE_STREAMS: usize = 64;

/// A slab by every solver that applies, each compared with discrete ordinates of 64 streams.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SlabCompare {
    /// The slab; its solver is left at `auto`, its streams and photons are those of the solvers that have some.
    pub slab: Slab,
}

/// The answers of one solver, and what they took.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// Which one.
    pub solver: Solver,
    /// With how many streams, if with any.
    pub streams: Option<usize>,
    /// With how many photons for each answer, if with any.
    pub photons: Option<u64>,
    /// In the order of the reference.
    pub answers: Vec<Answer>,
    /// Time that went by, s.
    pub wall_s: f64,
    /// Time of all processors together, s; `None` where the system does not tell.
    pub processor_s: Option<f64>,
}

impl Trial {
    fn run(solver: Solver, streams: usize, question: &Question<'_>, context: &Context<'_>) -> Result<Self, JobError> {
        let (start, processor) = (Instant::now(), processor_time());
        let answers = solve(solver, &Question { streams, ..*question }, context)?;
        Ok(Self {
            solver,
            streams: solver.has_streams().then_some(streams),
            photons: solver.has_photons().then_some(question.photons),
            answers,
            wall_s: start.elapsed().as_secs_f64(),
            processor_s: processor.zip(processor_time()).map(|(before, after)| after - before),
        })
    }

    /// Largest absolute difference of a share from that of the reference.
    pub fn largest_difference(&self, reference: &Self, pick: fn(&Shares) -> f64) -> f64 {
        self.differences(reference, pick).into_iter().map(f64::abs).fold(0.0, f64::max)
    }

    /// The largest of the differences of reflectance, transmittance and absorptance from those of the reference, in
    /// standard errors; `None` without such errors.
    pub fn largest_deviation(&self, reference: &Self) -> Option<f64> {
        let all = QUANTITIES[..3].iter().filter_map(|(_, pick)| self.deviations(reference, *pick));
        all.flatten().map(f64::abs).reduce(f64::max)
    }

    fn differences(&self, reference: &Self, pick: fn(&Shares) -> f64) -> Vec<f64> {
        let pairs = self.answers.iter().zip(&reference.answers);
        pairs.map(|(ours, theirs)| pick(&ours.shares) - pick(&theirs.shares)).collect()
    }

    /// Differences in standard errors; where nothing was counted and nothing expected, 0.
    fn deviations(&self, reference: &Self, pick: fn(&Shares) -> f64) -> Option<Vec<f64>> {
        let errors: Option<Vec<f64>> = self.answers.iter().map(|answer| answer.errors.as_ref().map(pick)).collect();
        let pairs = self.differences(reference, pick).into_iter().zip(errors?);
        Some(pairs.map(|(difference, error)| if error > 0.0 { difference / error } else { 0.0 }).collect())
    }

    fn json(&self, reference: Option<&Self>) -> Value {
        let mut value = Map::new();
        value.insert("solver".into(), json!(self.solver));
        value.insert("streams".into(), json!(self.streams));
        if self.photons.is_some() {
            value.insert("photons".into(), json!(self.photons));
        }
        value.insert("wall_s".into(), json!(self.wall_s));
        value.insert("processor_s".into(), json!(self.processor_s));
        for (name, pick) in QUANTITIES {
            let shares: Vec<f64> = self.answers.iter().map(|answer| pick(&answer.shares)).collect();
            value.insert(name.into(), json!(shares));
            let Some(reference) = reference else { continue };
            value.insert(format!("difference_{name}"), json!(self.differences(reference, pick)));
            if let Some(deviations) = self.deviations(reference, pick) {
                let errors: Vec<f64> = self.answers.iter().filter_map(|a| a.errors.as_ref().map(pick)).collect();
                value.insert(format!("{name}_se"), json!(errors));
                value.insert(format!("deviation_{name}"), json!(deviations));
            }
        }
        Value::Object(value)
    }
}

impl SlabCompare {
    pub(in crate::jobs) fn run(&self, context: &Context<'_>) -> Result<SlabCompareReport, JobError> {
        let slab = &self.slab;
        if slab.solver != Solver::Auto {
            let with = "a comparison, which runs all of them".to_owned();
            return Err(SlabError::Meaningless { what: "a solver", with }.into());
        }
        slab.check_numbers()?;
        let incidence = slab.light.incidence()?;
        let dir = slab.output.as_deref().map(OutputDir::create).transpose()?;
        let degree = slab.streams().max(REFERENCE_STREAMS) + Slab::MARGIN;
        let wanted = Wanted { degree, functions: true, tolerance: slab.tolerance };
        let (stacks, no_photons) = match Stacks::build(slab, wanted, context) {
            // The others can work with it.
            Err(JobError::Slab(error @ SlabError::NegativePhase { .. })) => {
                let stacks = Stacks::build(slab, Wanted { functions: false, ..wanted }, context)?;
                (stacks, Some(error.to_string()))
            }
            other => (other?, None),
        };
        let question = Question {
            stacks: &stacks.stacks,
            functions: &stacks.functions,
            incidence,
            streams: slab.streams(),
            photons: slab.photons(),
            seed: slab.seed.unwrap_or(0),
        };
        let reference = Trial::run(Solver::DiscreteOrdinates, REFERENCE_STREAMS, &question, context)?;
        let (trials, refused) = trials(slab.streams(), &question, no_photons.as_deref(), context)?;
        let basis = SlabSheet::new(
            &Slab { streams: Some(REFERENCE_STREAMS), ..slab.clone() },
            stacks,
            reference.answers.clone(),
        );
        let sheet = SlabCompareSheet { basis, reference, trials, refused };
        let mut files = Vec::new();
        if let Some(dir) = dir {
            context.say(Event::Begin(Stage::Write));
            let (table, json) = (sheet.table()?, sheet.json());
            files.push(dir.write("slab-compare.csv", |out| table.write_csv(out))?);
            files.push(dir.write("slab-compare.json", |out| Ok(serde_json::to_writer_pretty(out, &json)?))?);
            dir.commit();
            context.say(Event::End(Stage::Write));
        }
        Ok(SlabCompareReport { sheet, files })
    }
}

/// By every solver; and those that cannot, with the reason.
#[allow(clippy::type_complexity)]
fn trials(
    streams: usize,
    question: &Question<'_>,
    no_photons: Option<&str>,
    context: &Context<'_>,
) -> Result<(Vec<Trial>, Vec<(Solver, String)>), JobError> {
    let (mut trials, mut refused) = (Vec::new(), Vec::new());
    for solver in Solver::ALL.into_iter().filter(|solver| *solver != Solver::Auto) {
        if let (true, Some(reason)) = (solver.has_photons(), no_photons) {
            refused.push((solver, reason.to_owned()));
            continue;
        }
        match Trial::run(solver, streams, question, context) {
            Ok(trial) => trials.push(trial),
            Err(JobError::Transfer(reason)) => refused.push((solver, reason.to_string())),
            Err(error) => return Err(error),
        }
    }
    Ok((trials, refused))
}

/// Slabs by all solvers.
#[derive(Debug, Clone, PartialEq)]
pub struct SlabCompareSheet {
    /// The slabs, with the answers of the reference.
    pub basis: SlabSheet,
    /// Discrete ordinates of 64 streams.
    pub reference: Trial,
    /// All solvers that apply.
    pub trials: Vec<Trial>,
    /// Those that do not, and why.
    pub refused: Vec<(Solver, String)>,
}

impl SlabCompareSheet {
    /// A row for each slab and wavelength: the shares by the reference, then, for each solver, its own and, where there
    /// are some, their standard errors. Times and largest differences are remarks.
    ///
    /// # Errors
    /// Never; the table checks the lengths of its columns.
    pub fn table(&self) -> Result<Table, JobError> {
        let mut table = self.basis.table()?;
        for trial in std::iter::once(&self.reference).chain(&self.trials) {
            let processor = trial.processor_s.map_or(String::new(), |s| format!(", processors {s:.3e} s"));
            let [r, t, a] = self.largest_differences(trial);
            let text =
                format!("wall {:.3e} s{processor}; largest differences R {r:.2e}, T {t:.2e}, A {a:.2e}", trial.wall_s);
            table = table.with_metadata(named(trial), text);
        }
        for (solver, reason) in &self.refused {
            table = table.with_metadata(format!("{solver} does not apply"), reason.clone());
        }
        for trial in &self.trials {
            let prefix = trial.solver.name().replace('-', "_");
            for (name, pick) in &QUANTITIES[..3] {
                let shares = trial.answers.iter().map(|answer| pick(&answer.shares)).collect();
                table = table.with_column(format!("{prefix}_{name}"), "", shares)?;
                if trial.photons.is_some() {
                    let error = |answer: &Answer| answer.errors.as_ref().map_or(f64::NAN, pick);
                    let errors = trial.answers.iter().map(error).collect();
                    table = table.with_column(format!("{prefix}_{name}_se"), "", errors)?;
                }
            }
        }
        Ok(table)
    }

    /// Of reflectance, transmittance and absorptance.
    pub fn largest_differences(&self, trial: &Trial) -> [f64; 3] {
        let largest = |(_, pick): Quantity| trial.largest_difference(&self.reference, pick);
        [largest(QUANTITIES[0]), largest(QUANTITIES[1]), largest(QUANTITIES[2])]
    }

    /// As JSON: what [`SlabSheet::json`] says of the slabs, with the answers of the reference, and an object for each
    /// solver.
    pub fn json(&self) -> Value {
        let mut value = self.basis.json();
        if let Value::Object(map) = &mut value {
            map.insert("reference".into(), self.reference.json(None));
            let trials = self.trials.iter().map(|trial| trial.json(Some(&self.reference)));
            map.insert("solvers".into(), Value::Array(trials.collect()));
            let refused = self.refused.iter().map(|(solver, reason)| json!({ "solver": solver, "reason": reason }));
            map.insert("not_applicable".into(), Value::Array(refused.collect()));
        }
        value
    }
}

/// The solver and its settings.
pub(super) fn named(trial: &Trial) -> String {
    match trial.streams {
        Some(streams) => format!("{}, {streams} streams", trial.solver),
        None => trial.solver.to_string(),
    }
}

/// What [`SlabCompare`] leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct SlabCompareReport {
    /// The comparison.
    pub sheet: SlabCompareSheet,
    /// The files written.
    pub files: Vec<PathBuf>,
}

/// Seconds that all threads of this process have run so far.
#[cfg(unix)]
fn processor_time() -> Option<f64> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Some(time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64)
}

#[cfg(not(unix))]
fn processor_time() -> Option<f64> {
    None
}
