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

#[cfg(test)]
mod tests {
    use mieux_optics::phase::{HenyeyGreenstein, Isotropic};
    use mieux_optics::transfer::{Ground, Layer, Moments};

    use super::*;

    fn layer(tau: f64, albedo: f64, g: f64) -> (Layer, PhaseFunction) {
        (Layer::new(tau, albedo, Moments::henyey_greenstein(g).unwrap()), HenyeyGreenstein::new(g).unwrap().into())
    }

    fn van_de_hulst(photons: u64, seed: u64) -> SlabWalk {
        let (layer, phase) = layer(2.0, 0.9, 0.75);
        SlabWalk::new(Stack::slab(layer), vec![phase], Incidence::NORMAL, photons, seed)
    }

    fn run(walk: &SlabWalk) -> SlabCounts {
        walk.run(&mut |_| Flow::Continue).unwrap()
    }

    #[test]
    fn the_number_of_threads_leaves_no_trace() {
        let (top, first) = layer(0.7, 0.8, 0.9);
        let (bottom, second) = layer(3.0, 0.99, -0.2);
        let stack = Stack {
            above: 1.0,
            layers: vec![top.with_index(1.3), bottom.with_index(1.6)],
            below: 1.1,
            ground: Ground::Lambertian(0.4),
        };
        let mut walk = SlabWalk::new(stack, vec![first, second], Incidence::Diffuse, 5_000, 11);
        walk.bins = Some([5, 3]);
        let on = |walk: &SlabWalk, threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| run(walk))
        };
        let one = on(&walk, 1);
        assert_eq!(one, on(&walk, 3));
        walk.seed = 12;
        assert_ne!(one.reflectance, on(&walk, 2).reflectance);
    }

    /// Means of many seeds scatter around the truth as their errors say, which the roulette, the even start and the
    /// weights of absorption must leave as it is. Van de Hulst's slab.
    #[test]
    fn errors_are_honest() {
        let seeds = 100;
        let (mut reflected, mut transmitted, mut balance) = (0.0, 0.0, 0.0);
        for seed in 0..seeds {
            let counts = run(&van_de_hulst(10_000, seed));
            reflected += ((counts.reflectance.value - 0.097_394_64) / counts.reflectance.error).powi(2);
            transmitted += ((counts.transmittance.value - 0.660_957_70) / counts.transmittance.error).powi(2);
            // Light enough for the roulette only where more is absorbed.
            let mut dark = van_de_hulst(10_000, seed);
            dark.stack.layers[0].albedo = 0.6;
            dark.stack.layers[0].optical_thickness = 20.0;
            let counts = run(&dark);
            balance += ((counts.balance.value - 1.0) / counts.balance.error).powi(2);
        }
        // 100 degrees of freedom: 99.99 % lie below 162, and above 55.
        for chi2 in [reflected, transmitted, balance] {
            assert!((55.0..162.0).contains(&chi2), "{reflected} {transmitted} {balance}");
        }
    }

    #[test]
    fn progress_is_told_and_stops() {
        let mut told = Vec::new();
        let counts = van_de_hulst(100_000, 1)
            .run(&mut |progress| {
                told.push(progress);
                if told.len() == 3 { Flow::Stop } else { Flow::Continue }
            })
            .unwrap();
        assert_eq!(told[1], SlabProgress { photons: 8_000, end: 100_000 });
        assert_eq!(counts.photons, 12_000);
        assert!((counts.reflectance.value - 0.0974).abs() < 5.0 * counts.reflectance.error);
        assert_eq!(run(&van_de_hulst(1_999, 1)).photons, 2_000);
        assert!(run(&van_de_hulst(1, 1)).reflectance.error.is_infinite());
    }

    #[test]
    fn what_cannot_be_walked_is_refused() {
        let message = |walk: &SlabWalk| walk.run(&mut |_| Flow::Continue).unwrap_err().to_string();
        let mut walk = van_de_hulst(10, 1);
        walk.source = Source::Top(Incidence::Beam(0.0));
        assert!(message(&walk).contains("cosine 0 "), "{}", message(&walk));
        walk.source = Source::Top(Incidence::Beam(f64::NAN));
        assert!(message(&walk).contains("NaN"));
        walk.source = Source::Emission;
        assert_eq!(walk.run(&mut |_| Flow::Continue), Err(SlabWalkError::Dark));
        walk.bins = Some([0, 4]);
        assert!(message(&walk).contains("0 x 4 bins"));
        walk.photons = 0;
        assert!(message(&walk).contains("0 photons"));
        walk.phases.push(Isotropic.into());
        assert!(message(&walk).contains("2 phase functions for 1 layers"));
        walk.stack.layers[0].albedo = 1.5;
        assert!(message(&walk).contains("albedo 1.5"));
    }

    /// No layers are a plane alone, or nothing; and from the denser side there may be no way through it.
    #[test]
    fn planes_alone() {
        let mut stack = Stack { above: 1.5, layers: vec![], below: 1.0, ground: Ground::Black };
        let walk = |stack: &Stack| run(&SlabWalk::new(stack.clone(), vec![], Incidence::Beam(0.5), 100, 1));
        assert_eq!(walk(&stack).reflectance.value, 1.0);
        stack.above = 1.0;
        assert_eq!(walk(&stack).transmittance_unscattered.value, 1.0);
        stack.ground = Ground::Lambertian(0.25);
        let counts = walk(&stack);
        assert_eq!((counts.reflectance.value, counts.transmittance.value), (0.25, 0.75));
        assert_eq!((counts.reflectance_specular.value, counts.transmittance_unscattered.value), (0.0, 0.75));
    }
}
