//! Photons through a stack of layers: how much comes back, passes, and stays, by Monte Carlo alone.
//!
//! Nothing here is shared with the solvers of the transfer equation but the description of the stack, Fresnel's formula
//! and the phase functions, so that each can be held against the other. What is counted is unbiased: free flights end
//! at scattering, absorption only takes weight (`wang1995` calls it implicit capture), and light ones end in Russian
//! roulette.
//!
//! ```
//! use mieux_optics::phase::{HenyeyGreenstein, PhaseFunction};
//! use mieux_optics::transfer::{Incidence, Layer, Moments, Stack};
//! use mieux_render::detector::slab::SlabWalk;
//! use mieux_render::render::Flow;
//!
//! let phase = PhaseFunction::from(HenyeyGreenstein::new(0.75)?);
//! let stack = Stack::slab(Layer::new(2.0, 0.9, Moments::of(&phase, 32)?));
//! let walk = SlabWalk::new(stack, vec![phase], Incidence::NORMAL, 20_000, 1);
//! let counts = walk.run(&mut |_| Flow::Continue)?;
//! // Van de Hulst's slab.
//! assert!((counts.reflectance.value - 0.09739).abs() < 5.0 * counts.reflectance.error);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod counts;
mod photon;
mod source;

use mieux_optics::phase::PhaseFunction;
use mieux_optics::transfer::{Incidence, Stack, TransferError};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use crate::render::Flow;
use crate::sampler::mix;
use counts::{Layout, Tally, Totals};
use photon::Slab;
use source::Start;

pub use counts::{Estimate, Radiance, SlabCounts};

/// Where the photons come from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Source {
    /// They fall onto the top.
    Top(Incidence),
    /// The layers emit them ([`mieux_optics::transfer::Layer::emission`]); shares are of all that is emitted.
    Emission,
}

/// An experiment: a stack, light, and how many photons are sent.
#[derive(Debug, Clone, PartialEq)]
pub struct SlabWalk {
    /// What the light meets.
    pub stack: Stack,
    /// The phase function of each layer, from the top down. These are sampled; the moments in the stack are not read.
    pub phases: Vec<PhaseFunction>,
    /// Where the light comes from.
    pub source: Source,
    /// Photons to be followed, from 1 up; rounded up to whole batches, by less than a thousandth.
    pub photons: u64,
    /// The same seed gives the same bits, whatever the number of threads.
    pub seed: u64,
    /// How many bins of the cosine and of the azimuth the light that leaves is sorted into; `None` counts it only.
    pub bins: Option<[usize; 2]>,
    /// Collisions after which a photon is given up: thick slabs without absorption would hold it for ever. What it
    /// carried is [`SlabCounts::lost`].
    pub most_collisions: u64,
}

/// How far a walk is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SlabProgress {
    /// Photons followed to their end.
    pub photons: u64,
    /// Photons at the end.
    pub end: u64,
}

/// Why no photon was sent.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SlabWalkError {
    /// The stack, or the angle of incidence.
    #[error(transparent)]
    Transfer(#[from] TransferError),
    /// Each layer needs its phase function.
    #[error("{phases} phase functions for {layers} layers")]
    Phases {
        /// Layers of the stack.
        layers: usize,
        /// Phase functions given.
        phases: usize,
    },
    /// At least one photon, and at least one collision allowed.
    #[error("{photons} photons of at most {collisions} collisions; at least 1 of each is needed")]
    Photons {
        /// Photons asked for.
        photons: u64,
        /// Collisions allowed.
        collisions: u64,
    },
    /// At least one bin, and not more than memory holds.
    #[error("{cosines} x {azimuths} bins; from 1 x 1 to 1000 x 1000 are possible")]
    Bins {
        /// Of the cosine.
        cosines: usize,
        /// Of the azimuth.
        azimuths: usize,
    },
    /// No layer emits.
    #[error("no layer both absorbs and has a temperature: nothing is emitted")]
    Dark,
}

/// Photons are sent in about this many batches, by whose differences errors are judged.
const BATCHES: u64 = 1000;
/// Largest batch, so that progress is seen.
const LARGEST_BATCH: u64 = 1 << 14;
/// Batches between two reports of progress.
const ROUND: u64 = 40;
/// Long enough for a photon that leaves a slab of optical thickness 1000 without loss.
const MOST_COLLISIONS: u64 = 10_000_000;

impl SlabWalk {
    /// Light onto the top, no bins.
    pub fn new(stack: Stack, phases: Vec<PhaseFunction>, incidence: Incidence, photons: u64, seed: u64) -> Self {
        let source = Source::Top(incidence);
        Self { stack, phases, source, photons, seed, bins: None, most_collisions: MOST_COLLISIONS }
    }

    /// Sends the photons on all threads of the caller's pool. `progress` is called between rounds of batches; if it
    /// says stop, what has been counted so far is returned (from one round on).
    ///
    /// # Errors
    /// [`SlabWalkError`], before anything is sent.
    pub fn run(&self, progress: &mut dyn FnMut(SlabProgress) -> Flow) -> Result<SlabCounts, SlabWalkError> {
        self.check()?;
        let start = Start::new(self.source, &self.stack)?;
        let slab = Slab::new(&self.stack, &self.phases, self.most_collisions);
        let layout = Layout { layers: self.stack.layers.len(), bins: self.bins };
        let size = self.photons.div_ceil(BATCHES).min(LARGEST_BATCH);
        let batches = self.photons.div_ceil(size);
        let mut totals = Totals::new(layout);
        for first in (0..batches).step_by(ROUND as usize) {
            let round = first..(first + ROUND).min(batches);
            let tallies: Vec<Tally> =
                round.clone().into_par_iter().map(|batch| self.batch(&slab, &start, layout, batch, size)).collect();
            // Summed in order, so that the threads leave no trace in the last bits.
            tallies.iter().for_each(|tally| totals.add(tally));
            if progress(SlabProgress { photons: round.end * size, end: batches * size }) == Flow::Stop {
                break;
            }
        }
        Ok(totals.counts(size, start.power()))
    }

    fn check(&self) -> Result<(), SlabWalkError> {
        self.stack.check()?;
        let (layers, phases) = (self.stack.layers.len(), self.phases.len());
        if layers != phases {
            return Err(SlabWalkError::Phases { layers, phases });
        }
        if self.photons == 0 || self.most_collisions == 0 {
            return Err(SlabWalkError::Photons { photons: self.photons, collisions: self.most_collisions });
        }
        match self.bins {
            Some([cosines, azimuths]) if ![cosines, azimuths].iter().all(|n| (1..=1000).contains(n)) => {
                Err(SlabWalkError::Bins { cosines, azimuths })
            }
            _ => Ok(()),
        }
    }

    /// Photons of a stream of their own.
    fn batch(&self, slab: &Slab<'_>, start: &Start, layout: Layout, batch: u64, size: u64) -> Tally {
        let place = mix(mix(self.seed ^ 0x6d69_6575_785f_736c) ^ batch);
        let state = u128::from(place) << 64 | u128::from(mix(place ^ 0xd1b5_4a32_d192_ed03));
        let mut generator = Pcg64Mcg::new(state);
        let mut tally = Tally::new(layout);
        let even = source::Even::new(size, &mut generator);
        for index in 0..size {
            if let Some(photon) = start.photon(slab, even.pair(index), &mut generator, &mut tally) {
                slab.follow(photon, &mut generator, &mut tally);
            }
        }
        tally
    }
}
