//! One door to all solvers.

use std::fmt;
use std::str::FromStr;

use mieux_optics::phase::PhaseFunction;
use mieux_optics::transfer::{
    AddingDoubling, DiscreteOrdinates, Incidence, Shares, Stack, TransferError, diffusion, kubelka_munk,
};
use mieux_render::detector::slab::SlabWalk;
use mieux_render::render::Flow;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::super::{Context, Event, JobError, Stage};

/// Stacks that are given to a thread together. Fixed, so that results do not depend on the number of threads, and as
/// many as the widest registers hold.
const BATCH: usize = 8;

/// How the transfer of light is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Solver {
    /// The best there is for the question: discrete ordinates.
    #[default]
    Auto,
    /// [`DiscreteOrdinates`].
    DiscreteOrdinates,
    /// [`AddingDoubling`]: along the same streams by other means.
    Adding,
    /// [`kubelka_munk::shares`]: two fluxes. Approximate.
    KubelkaMunk,
    /// [`diffusion::shares`]: one equation of diffusion. Approximate.
    Diffusion,
    /// Photons followed one by one ([`SlabWalk`]), with standard errors.
    MonteCarlo,
}

impl Solver {
    /// All of them, the choice among them first.
    pub const ALL: [Self; 6] =
        [Self::Auto, Self::DiscreteOrdinates, Self::Adding, Self::KubelkaMunk, Self::Diffusion, Self::MonteCarlo];

    /// As it is written down.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::DiscreteOrdinates => "discrete-ordinates",
            Self::Adding => "adding",
            Self::KubelkaMunk => "kubelka-munk",
            Self::Diffusion => "diffusion",
            Self::MonteCarlo => "monte-carlo",
        }
    }

    /// What [`Solver::Auto`] stands for; the others are themselves.
    pub fn resolved(self) -> Self {
        if self == Self::Auto { Self::DiscreteOrdinates } else { self }
    }

    /// Whether it follows light along streams, whose number can be chosen.
    pub fn has_streams(self) -> bool {
        matches!(self.resolved(), Self::DiscreteOrdinates | Self::Adding)
    }

    /// Whether it solves a simpler equation than that of radiative transfer.
    pub fn is_approximate(self) -> bool {
        matches!(self, Self::KubelkaMunk | Self::Diffusion)
    }

    /// Whether it sends photons, whose number and seed can be chosen.
    pub fn has_photons(self) -> bool {
        self == Self::MonteCarlo
    }
}

impl fmt::Display for Solver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Solver {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let names = Self::ALL.map(Self::name).join(", ");
        Self::ALL
            .into_iter()
            .find(|solver| solver.name() == text)
            .ok_or_else(|| format!("there is no solver of that name; the solvers are {names}"))
    }
}

/// Where the light goes, and how well that is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer {
    /// Shares of the light that falls in.
    pub shares: Shares,
    /// Their standard errors, where photons were counted.
    pub errors: Option<Shares>,
}

/// What is to be solved, and with what settings.
#[derive(Clone, Copy)]
pub(super) struct Question<'a> {
    pub stacks: &'a [Stack],
    /// Phase functions of the layers of each stack; needed for photons only.
    pub functions: &'a [Vec<PhaseFunction>],
    pub incidence: Incidence,
    pub streams: usize,
    /// For each stack.
    pub photons: u64,
    pub seed: u64,
}

/// Where the light goes in every stack.
pub(super) fn solve(solver: Solver, question: &Question<'_>, context: &Context<'_>) -> Result<Vec<Answer>, JobError> {
    match solver.resolved() {
        Solver::Auto | Solver::DiscreteOrdinates => {
            let solver = DiscreteOrdinates::with_streams(question.streams)?;
            in_batches(question, context, |stacks| {
                let found = solver.shares_of(stacks, &[question.incidence])?;
                Ok(found.into_iter().flatten().collect())
            })
        }
        Solver::Adding => {
            let solver = AddingDoubling::with_streams(question.streams)?;
            in_batches(question, context, |stacks| {
                let found = solver.shares_of(stacks, &[question.incidence])?;
                Ok(found.into_iter().flatten().collect())
            })
        }
        Solver::KubelkaMunk => in_batches(question, context, |stacks| {
            stacks.iter().map(|stack| kubelka_munk::shares(stack, question.incidence)).collect()
        }),
        Solver::Diffusion => in_batches(question, context, |stacks| {
            stacks.iter().map(|stack| diffusion::shares(stack, question.incidence)).collect()
        }),
        Solver::MonteCarlo => follow_photons(question, context),
    }
}

/// By a solver that has no randomness, some stacks at a time.
fn in_batches(
    question: &Question<'_>,
    context: &Context<'_>,
    shares_of: impl Fn(&[Stack]) -> Result<Vec<Shares>, TransferError> + Sync,
) -> Result<Vec<Answer>, JobError> {
    let total = question.stacks.len() as u64;
    let done = std::sync::atomic::AtomicU64::new(0);
    context.say(Event::Begin(Stage::Slabs));
    let found: Result<Vec<Vec<Shares>>, JobError> = question
        .stacks
        .par_chunks(BATCH)
        .map(|stacks| {
            if context.is_cancelled() {
                return Err(JobError::Cancelled);
            }
            let shares = shares_of(stacks)?;
            let count = stacks.len() as u64;
            context.count(Stage::Slabs, done.fetch_add(count, std::sync::atomic::Ordering::Relaxed) + count, total);
            Ok(shares)
        })
        .collect();
    context.say(Event::End(Stage::Slabs));
    Ok(found?.into_iter().flatten().map(|shares| Answer { shares, errors: None }).collect())
}

fn follow_photons(question: &Question<'_>, context: &Context<'_>) -> Result<Vec<Answer>, JobError> {
    let total = question.photons.saturating_mul(question.stacks.len() as u64);
    context.say(Event::Begin(Stage::Photons));
    let mut answers = Vec::with_capacity(question.stacks.len());
    for (i, (stack, functions)) in question.stacks.iter().zip(question.functions).enumerate() {
        // Neighbours in a spectrum have errors of their own.
        let seed = question.seed.wrapping_add(i as u64);
        let walk = SlabWalk::new(stack.clone(), functions.clone(), question.incidence, question.photons, seed);
        let before = question.photons * i as u64;
        let counts = walk.run(&mut |progress| {
            context.count(Stage::Photons, (before + progress.photons).min(total), total);
            if context.is_cancelled() { Flow::Stop } else { Flow::Continue }
        })?;
        if context.is_cancelled() {
            return Err(JobError::Cancelled);
        }
        let of = |pick: fn(&mieux_render::detector::slab::Estimate) -> f64| Shares {
            reflectance: pick(&counts.reflectance),
            transmittance: pick(&counts.transmittance),
            absorptance: pick(&counts.absorptance),
            reflectance_specular: pick(&counts.reflectance_specular),
            transmittance_unscattered: pick(&counts.transmittance_unscattered),
        };
        answers.push(Answer { shares: of(|e| e.value), errors: Some(of(|e| e.error)) });
    }
    context.say(Event::End(Stage::Photons));
    Ok(answers)
}
