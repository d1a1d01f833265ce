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

pub use counts::{Estimate, RadialCounts, Radiance, SlabCounts};

/// Where the photons come from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Source {
    /// They fall onto the top.
    Top(Incidence),
    /// The layers emit them ([`mieux_optics::transfer::Layer::emission`]); shares are of all that is emitted.
    Emission,
}

/// Rings around a pencil beam, in which the light that leaves is counted.
#[derive(Debug, Clone, PartialEq)]
pub struct Rings {
    /// Radii of their edges, m, ascending from 0 or more; at least two.
    pub edges: Vec<f64>,
    /// Thickness of each layer, m: how far aside light gets is not told by optical thickness. Above 0.
    pub thickness: Vec<f64>,
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
    /// Rings that the light is sorted into by where it leaves, if it falls onto the top, all of it in one point.
    pub rings: Option<Rings>,
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
    /// Edges that do not rise, thicknesses that are none, or light that does not come from the top.
    #[error(
        "the rings need ascending radii from 0 up, a thickness above 0 for each of {layers} layers, and light from the top"
    )]
    Rings {
        /// Layers of the stack.
        layers: usize,
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
        Self { stack, phases, source, photons, seed, bins: None, rings: None, most_collisions: MOST_COLLISIONS }
    }

    /// Sends the photons on all threads of the caller's pool. `progress` is called between rounds of batches; if it
    /// says stop, what has been counted so far is returned (from one round on).
    ///
    /// # Errors
    /// [`SlabWalkError`], before anything is sent.
    pub fn run(&self, progress: &mut dyn FnMut(SlabProgress) -> Flow) -> Result<SlabCounts, SlabWalkError> {
        self.check()?;
        let start = Start::new(self.source, &self.stack)?;
        let heights = self.rings.as_ref().map(|rings| rings.thickness.as_slice());
        let slab = Slab::new(&self.stack, &self.phases, heights, self.most_collisions);
        let edges = self.rings.as_ref().map_or(&[][..], |rings| &rings.edges);
        let layout = Layout { layers: self.stack.layers.len(), bins: self.bins, edges };
        let size = self.photons.div_ceil(BATCHES).min(LARGEST_BATCH);
        let batches = self.photons.div_ceil(size);
        let mut totals = Totals::new(layout);
        for first in (0..batches).step_by(ROUND as usize) {
            let round = first..(first + ROUND).min(batches);
            let tallies: Vec<Tally<'_>> =
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
        if self.rings.as_ref().is_some_and(|rings| !self.can_be_sorted(rings)) {
            return Err(SlabWalkError::Rings { layers });
        }
        match self.bins {
            Some([cosines, azimuths]) if ![cosines, azimuths].iter().all(|n| (1..=1000).contains(n)) => {
                Err(SlabWalkError::Bins { cosines, azimuths })
            }
            _ => Ok(()),
        }
    }

    fn can_be_sorted(&self, rings: &Rings) -> bool {
        let finite = |values: &[f64]| values.iter().all(|v| *v >= 0.0 && v.is_finite());
        let rises = rings.edges.len() >= 2 && rings.edges.windows(2).all(|ends| ends[0] < ends[1]);
        let heights = rings.thickness.len() == self.stack.layers.len() && rings.thickness.iter().all(|h| *h > 0.0);
        let on_top = matches!(self.source, Source::Top(_));
        rises && heights && on_top && finite(&rings.edges) && finite(&rings.thickness)
    }

    /// Photons of a stream of their own.
    fn batch<'a>(&self, slab: &Slab<'_>, start: &Start, layout: Layout<'a>, batch: u64, size: u64) -> Tally<'a> {
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

    /// What leaves in rings, in the hole and beyond is all that leaves scattered; asking changes nothing else.
    #[test]
    fn rings_share_what_leaves() {
        let (layer, phase) = layer(2.0, 0.9, 0.75);
        let stack = Stack::slab(layer.with_index(1.4)).over(Ground::Lambertian(0.3));
        let plain = SlabWalk::new(stack, vec![phase], Incidence::NORMAL, 20_000, 5);
        let edges = vec![0.0, 1e-4, 1e-3, 3e-3];
        let ringed = SlabWalk { rings: Some(Rings { edges, thickness: vec![1e-3] }), ..plain.clone() };
        let (plain, ringed) = (run(&plain), run(&ringed));
        assert_eq!(plain.reflectance, ringed.reflectance);
        assert_eq!(plain.absorptance, ringed.absorptance);
        let sum = |counts: &RadialCounts| {
            let of_ring = |([from, to], found): ([f64; 2], Estimate)| {
                found.value * std::f64::consts::PI * (to * to - from * from)
            };
            counts.rings().map(of_ring).sum::<f64>() + counts.beyond.value
        };
        let up = sum(ringed.radial_up.as_ref().unwrap());
        assert!((up - (ringed.reflectance.value - ringed.reflectance_specular.value)).abs() < 1e-12);
        // The ground takes 0.7 of all that meets it; what came unscattered is not in the rings.
        let down = sum(ringed.radial_down.as_ref().unwrap());
        let met = (ringed.transmittance.value - ringed.transmittance_unscattered.value) / 0.7;
        assert!((down - met).abs() < 1e-12, "{down} {met}");
    }

    /// Light that has been scattered once, in closed form: nearly all of it in a medium that absorbs what is scattered.
    #[test]
    fn single_scattering_leaves_where_it_should() {
        let (layer, phase) = layer(40.0, 0.02, 0.3);
        let mut walk = SlabWalk::new(Stack::slab(layer.with_index(1.3)), vec![phase], Incidence::NORMAL, 400_000, 8);
        walk.stack.below = 1.3;
        walk.rings = Some(Rings { edges: vec![0.2, 0.4, 0.8, 1.6], thickness: vec![40.0] });
        let medium = mieux_optics::transfer::diffusion::DiffusionMedium::new(0.98, 0.02, 0.3, 1.3).unwrap();
        let single = mieux_optics::transfer::diffusion::SingleScattering::new(&medium).unwrap();
        for ([from, to], found) in run(&walk).radial_up.unwrap().rings() {
            // Simpson's rule over the ring; twice scattered light adds about 2 %.
            let at = |r: f64| r * single.reflectance(r) * medium.entering();
            let middle = 0.5 * (from + to);
            let mean = (at(from) + 4.0 * at(middle) + at(to)) / 6.0 * (to - from) * 2.0 / (to * to - from * from);
            let allowed = 4.0 * found.error + 0.04 * mean;
            assert!((found.value - mean).abs() < allowed, "{from}: {found:?} {mean}");
        }
    }

    #[test]
    fn what_cannot_be_walked_is_refused() {
        let message = |walk: &SlabWalk| walk.run(&mut |_| Flow::Continue).unwrap_err().to_string();
        let mut walk = van_de_hulst(10, 1);
        walk.source = Source::Top(Incidence::Beam(0.0));
        assert!(message(&walk).contains("cosine 0 "), "{}", message(&walk));
        walk.source = Source::Top(Incidence::Beam(f64::NAN));
        assert!(message(&walk).contains("NaN"));
        walk.source = Source::Top(Incidence::NORMAL);
        walk.rings = Some(Rings { edges: vec![0.0, 2.0, 1.0], thickness: vec![1.0] });
        assert!(message(&walk).contains("ascending radii"), "{}", message(&walk));
        walk.rings = None;
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
