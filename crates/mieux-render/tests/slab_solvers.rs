//! Discrete ordinates against photons: random stacks, each solved by both, which share nothing but the description.
//!
//! `MIEUX_SLABS` (12) stacks with `MIEUX_PHOTONS` (40 000) photons each; more are a study rather than a test:
//! `MIEUX_SLABS=200 MIEUX_PHOTONS=1000000 cargo test --release -p mieux-render --test slab_solvers -- --nocapture`.
//! `MIEUX_FIRST_SLAB` leaves out those before, `MIEUX_SERIES` takes other photons.

#![allow(clippy::print_stdout)]

use std::f64::consts::PI;

use mieux_optics::medium::{Inclusion, Medium};
use mieux_optics::particle::SizeDistribution;
use mieux_optics::phase::{HenyeyGreenstein, PhaseFunction};
use mieux_optics::substance::Substance;
use mieux_optics::transfer::{DiscreteOrdinates, Ground, Incidence, Layer, Light, Moments, Place, Stack, Views};
use mieux_render::detector::slab::SlabWalk;
use mieux_render::render::Flow;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

fn number(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

struct Dice(Pcg64Mcg);

impl Dice {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A Lorenz-Mie sphere, lossless or not, or one lobe.
    fn phase(&mut self) -> PhaseFunction {
        if self.between(0.0, 1.0) < 0.2 {
            return sphere(10f64.powf(self.between(-1.5, 0.5)), self.between(1.1, 1.6));
        }
        HenyeyGreenstein::new(self.between(-0.5, 0.99)).unwrap().into()
    }

    /// One to five layers; a third of the stacks has one index throughout.
    fn stack(&mut self) -> (Stack, Vec<PhaseFunction>) {
        let count = 1 + (self.between(0.0, 5.0) as usize).min(4);
        let refracts = self.between(0.0, 1.0) > 0.33;
        let mut phases = Vec::new();
        let mut layers = Vec::new();
        for _ in 0..count {
            let phase = self.phase();
            let tau = 10f64.powf(self.between(-2.0, 3.0)) / count as f64;
            // Seldom without any loss; a thick layer then takes a photon a long while.
            let albedo =
                if tau < 30.0 && self.between(0.0, 1.0) < 0.1 { 1.0 } else { 1.0 - self.between(0.0, 1.0).powi(3) };
            let index = if refracts { self.between(1.0, 1.7) } else { 1.0 };
            layers.push(Layer::new(tau, albedo, Moments::of(&phase, 3000).unwrap()).with_index(index));
            phases.push(phase);
        }
        let ground = match self.between(0.0, 3.0) as u32 {
            0 => Ground::Black,
            1 => Ground::Lambertian(self.between(0.0, 1.0)),
            _ => Ground::Mirror(self.between(0.0, 1.0)),
        };
        (Stack { above: 1.0, layers, below: 1.0, ground }, phases)
    }
}

/// The phase function of one sphere in air, radius in um, at 550 nm.
fn sphere(radius_um: f64, index: f64) -> PhaseFunction {
    let substance = Substance::Constant(mieux_optics::Complex64::new(index, 0.0));
    let sizes = SizeDistribution::Monodisperse { radius_m: radius_um * 1e-6 };
    let sphere = Inclusion::new("sphere", substance, sizes, 1e-6);
    Medium::new(Substance::Constant(1.0.into()), vec![sphere]).unwrap().phase_at(550e-9, 1e-3).unwrap()
}

#[test]
fn random_stacks_agree_with_photons() {
    let mut dice = Dice(Pcg64Mcg::seed_from_u64(4));
    // Peaks of g = 0.99 under refraction, which divides the streams between two ranges of directions.
    let solver = DiscreteOrdinates::with_streams(160).unwrap();
    let photons = number("MIEUX_PHOTONS", 40_000);
    let (first, series) = (number("MIEUX_FIRST_SLAB", 0), number("MIEUX_SERIES", 0));
    let mut worst = 0.0f64;
    for slab in 0..number("MIEUX_SLABS", 12) {
        let (stack, phases) = dice.stack();
        let incidence =
            if dice.between(0.0, 1.0) < 0.3 { Incidence::Diffuse } else { Incidence::Beam(dice.between(0.1, 1.0)) };
        if slab < first {
            continue;
        }
        let ours = solver.shares(&stack, incidence).unwrap();
        let walk = SlabWalk::new(stack.clone(), phases, incidence, photons, slab + 1 + 1000 * series);
        let counts = walk.run(&mut |_| Flow::Continue).unwrap();
        for (name, estimate, value) in [
            ("reflectance", counts.reflectance, ours.reflectance),
            ("transmittance", counts.transmittance, ours.transmittance),
            ("absorptance", counts.absorptance, ours.absorptance),
        ] {
            // What discrete ordinates themselves leave open is far below this.
            let error = estimate.error.hypot(1e-7);
            let deviation = (estimate.value - value) / error;
            worst = worst.max(deviation.abs());
            println!(
                "slab {slab}, {name}: {value:.7} for {:.7} +- {:.7}, {deviation:+.2}",
                estimate.value, estimate.error
            );
            assert!(deviation.abs() < 4.0, "slab {slab}, {name}: {value} for {estimate:?}\n{incidence:?} {stack:?}");
        }
    }
    println!("worst deviation: {worst:.2} standard errors");
}

/// Radiance out of a refracting stack, up and down, around the mean of four bins. A table of one sphere scatters in a part.
#[test]
fn radiance_agrees_with_photons() {
    let phases = [sphere(0.4, 1.4), HenyeyGreenstein::new(0.7).unwrap().into()];
    let layer = |tau, albedo, phase, index| Layer::new(tau, albedo, Moments::of(phase, 300).unwrap()).with_index(index);
    let layers = vec![layer(1.0, 0.95, &phases[0], 1.33), layer(2.0, 0.99, &phases[1], 1.5)];
    let stack = Stack { above: 1.0, layers, below: 1.0, ground: Ground::Lambertian(0.3) };
    let (cosines, azimuths) = (10, 8);
    let mut walk = SlabWalk::new(stack.clone(), phases.to_vec(), Incidence::Beam(0.7), 400_000, 5);
    walk.bins = Some([cosines, azimuths]);
    let counts = walk.run(&mut |_| Flow::Continue).unwrap();
    // Three nodes of Gauss's rule in each direction of a bin; the grazing bins are left out, where radiance bends most.
    let nodes = [(-0.6f64.sqrt(), 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.6f64.sqrt(), 5.0 / 18.0)];
    let solver = DiscreteOrdinates::with_streams(64).unwrap();
    let light = Light { beam: Some((0.7, 1.0)), ..Light::default() };
    let mut worst = 0.0f64;
    for (side, place, radiance) in
        [(-1.0, Place::Above, counts.radiance_up.unwrap()), (1.0, Place::Below, counts.radiance_down.unwrap())]
    {
        for cosine in 2..cosines {
            let of_bin = nodes.map(|(x, _)| (cosine as f64 + 0.5 + 0.5 * x) / cosines as f64);
            for azimuth in 0..azimuths {
                let angles = nodes.map(|(x, _)| 2.0 * PI * (azimuth as f64 + 0.5 * x) / azimuths as f64);
                let views = Views { places: &[place], cosines: &of_bin.map(|c| side * c), azimuths: &angles };
                let found = solver.radiance(&stack, &light, &views).unwrap();
                let (mut sum, mut total) = (0.0, 0.0);
                for (i, (_, wc)) in nodes.iter().enumerate() {
                    for (k, (_, wa)) in nodes.iter().enumerate() {
                        sum += of_bin[i] * wc * wa * found.get(0, i, k).unwrap();
                        total += of_bin[i] * wc * wa;
                    }
                }
                let estimate = radiance.at(cosine, azimuth).unwrap();
                let deviation = (estimate.value - sum / total) / estimate.error;
                worst = worst.max(deviation.abs());
                assert!(deviation.abs() < 4.5, "{place:?} {cosine} {azimuth}: {} for {estimate:?}", sum / total);
            }
        }
    }
    println!("worst deviation of radiance: {worst:.2} standard errors of 128 bins");
}
