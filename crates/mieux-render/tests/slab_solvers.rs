//! Discrete ordinates against photons: random stacks, each solved by both, which share nothing but the description.
//!
//! `MIEUX_SLABS` (12) stacks with `MIEUX_PHOTONS` (40 000) photons each; more are a study rather than a test.

#![allow(clippy::print_stdout)]

use mieux_optics::phase::{AngleGrid, HenyeyGreenstein, PhaseFunction, TableRule, Tabulated, WaterDroplet};
use mieux_optics::transfer::{DiscreteOrdinates, Ground, Incidence, Layer, Moments, Stack};
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

    fn phase(&mut self) -> PhaseFunction {
        if self.between(0.0, 1.0) < 0.2 {
            let droplet = WaterDroplet::new(self.between(0.5e-6, 8e-6)).unwrap();
            let grid = AngleGrid::graded(60.0, 2.0).unwrap();
            return Tabulated::from_fn(grid, TableRule::Integrated, |theta| droplet.value(theta.cos())).unwrap().into();
        }
        HenyeyGreenstein::new(self.between(-0.5, 0.9)).unwrap().into()
    }

    /// One to five layers; a third of the stacks has one index throughout.
    fn stack(&mut self) -> (Stack, Vec<PhaseFunction>) {
        let count = 1 + (self.between(0.0, 5.0) as usize).min(4);
        let refracts = self.between(0.0, 1.0) > 0.33;
        let mut phases = Vec::new();
        let mut layers = Vec::new();
        for _ in 0..count {
            let phase = self.phase();
            let tau = 10f64.powf(self.between(-2.0, 1.5)) / count as f64;
            let albedo = 1.0 - self.between(0.0, 1.0).powi(3);
            let index = if refracts { self.between(1.0, 1.7) } else { 1.0 };
            layers.push(Layer::new(tau, albedo, Moments::of(&phase, 300).unwrap()).with_index(index));
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

#[test]
fn random_stacks_agree_with_photons() {
    let mut dice = Dice(Pcg64Mcg::seed_from_u64(4));
    let solver = DiscreteOrdinates::with_streams(96).unwrap();
    let photons = number("MIEUX_PHOTONS", 40_000);
    let mut worst = 0.0f64;
    for slab in 0..number("MIEUX_SLABS", 12) {
        let (stack, phases) = dice.stack();
        let incidence =
            if dice.between(0.0, 1.0) < 0.3 { Incidence::Diffuse } else { Incidence::Beam(dice.between(0.1, 1.0)) };
        let ours = solver.shares(&stack, incidence).unwrap();
        let walk = SlabWalk::new(stack.clone(), phases, incidence, photons, slab + 1);
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
            assert!(deviation.abs() < 4.0, "slab {slab}, {name}: {value} for {estimate:?}\n{incidence:?} {stack:?}");
        }
    }
    println!("worst deviation: {worst:.2} standard errors");
}
