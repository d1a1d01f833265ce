//! What the tests of light transport share.
#![allow(dead_code, clippy::print_stdout)]

use mieux_optics::spectrum::{Sampled, WavelengthGrid};
use mieux_render::DVec3;
use mieux_render::camera::Pinhole;
use mieux_render::geometry::{Ray, cuboid, disk};
use mieux_render::integrator::{Estimate, Statistics, Transport, trace};
use mieux_render::light::{Environment, Pattern, constant};
use mieux_render::medium::Medium;
use mieux_render::sampler::PixelSampler;
use mieux_render::scene::{Body, Prepared, Scene, Surface};

pub const RANGE: (f64, f64) = (380e-9, 775e-9);

/// Values at 380, 580 and 780 nm.
pub fn spectrum(values: [f64; 3]) -> Sampled {
    Sampled::new(WavelengthGrid::new(vec![380e-9, 580e-9, 780e-9]).unwrap(), values.to_vec()).unwrap()
}

/// Radiance 1 at all wavelengths from all directions.
pub fn flat_sky() -> Environment {
    Environment { spectrum: constant(1.0).unwrap(), pattern: Pattern::Uniform }
}

pub fn body(name: &str, mesh: mieux_render::geometry::Mesh, medium: Medium, priority: i32) -> Body {
    Body { name: name.into(), mesh, medium, priority, roughness: 0.0 }
}

pub fn scene(bodies: Vec<Body>, surfaces: Vec<Surface>, position: [f64; 3], target: [f64; 3]) -> Scene {
    let up = if position[0] == target[0] && position[1] == target[1] { [0.0, 1.0, 0.0] } else { [0.0, 0.0, 1.0] };
    let camera = Pinhole::new(position, target, up, 30.0, [64, 64]).unwrap();
    Scene { camera, environment: flat_sky(), lamps: vec![], bodies, surfaces, wavelength_range: RANGE }
}

/// Mean and standard error.
#[derive(Default, Clone, Copy, Debug)]
pub struct Tally {
    n: f64,
    sum: f64,
    squares: f64,
}

impl Tally {
    pub fn add(&mut self, value: f64) {
        self.n += 1.0;
        self.sum += value;
        self.squares += value * value;
    }

    pub fn mean(&self) -> f64 {
        self.sum / self.n
    }

    pub fn error(&self) -> f64 {
        ((self.squares / self.n - self.mean().powi(2)).max(0.0) / (self.n - 1.0)).sqrt()
    }

    pub fn assert_near(&self, expected: f64, sigmas: f64, share: f64, what: &str) {
        let off = self.mean() - expected;
        println!(
            "{what}: {:.6} +- {:.6}, expected {expected} ({:+.2} errors)",
            self.mean(),
            self.error(),
            off / self.error().max(1e-300)
        );
        assert!(
            off.abs() <= sigmas * self.error() + 1e-9,
            "{what}: {} +- {} is not {expected}",
            self.mean(),
            self.error()
        );
        assert!(off.abs() <= share * expected.abs(), "{what}: {} is not {expected}", self.mean());
    }
}

/// Follows `n` paths, on all cores, in an order that does not depend on them.
pub fn paths(
    scene: &Prepared,
    transport: &Transport,
    n: u64,
    ray: impl Fn(&mut PixelSampler) -> Ray + Sync,
) -> (Vec<Estimate>, Statistics) {
    use rayon::prelude::*;
    let chunks: Vec<_> = (0..n.div_ceil(1000))
        .into_par_iter()
        .map(|chunk| {
            let mut statistics = Statistics::default();
            let estimates: Vec<_> = (chunk * 1000..n.min((chunk + 1) * 1000))
                .map(|i| {
                    // Every path is a pixel of its own: independent samples, honest errors.
                    let mut sampler = PixelSampler::new(12, i as u32, (i >> 32) as u32, 0);
                    let ray = ray(&mut sampler);
                    trace(scene, transport, ray, &mut sampler, &mut statistics)
                })
                .collect();
            (estimates, statistics)
        })
        .collect();
    let mut all = Statistics::default();
    chunks.iter().for_each(|(_, s)| all += *s);
    (chunks.into_iter().flat_map(|(e, _)| e).collect(), all)
}

/// A very wide slab between z = 0 and `thickness`, met at right angles from above; one side is black, so that only
/// what is reflected (`up`) or transmitted reaches the sky.
pub fn slab(medium: Medium, thickness: f64, up: bool) -> Prepared {
    let wide = 10.0;
    let mesh = cuboid([-wide, -wide, 0.0], [wide, wide, thickness]).unwrap();
    let z = if up { -0.2 * thickness } else { 1.5 * thickness };
    let black = Surface::diffuse("black", disk([0.0, 0.0, z], 2.0 * wide, 64).unwrap(), constant(0.0).unwrap());
    let eye = [1e-4, 2e-4, 1.2 * thickness];
    Prepared::new(&scene(vec![body("slab", mesh, medium, 0)], vec![black], eye, [eye[0], eye[1], 0.0])).unwrap()
}

/// The light sent straight down into a [`slab`] that comes out on its open side, over all wavelengths alike.
pub fn slab_share(scene: &Prepared, transport: &Transport, n: u64) -> Tally {
    let down = Ray { origin: scene.camera().position(), direction: -DVec3::Z };
    let (estimates, statistics) = paths(scene, transport, n, |_| down);
    assert_eq!(statistics.lost, 0);
    let mut tally = Tally::default();
    estimates.iter().for_each(|e| tally.add(e.radiance.iter().sum::<f64>() / 4.0));
    tally
}

/// One tally per bin of wavelengths; the bins hold equally many.
pub fn by_wavelength(estimates: &[Estimate], bins: usize) -> Vec<Tally> {
    let mut all: Vec<(f64, f64)> =
        estimates.iter().flat_map(|e| (0..4).map(|k| (e.wavelengths[k], e.radiance[k]))).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.chunks(all.len().div_ceil(bins))
        .map(|bin| {
            let mut tally = Tally::default();
            bin.iter().for_each(|(_, radiance)| tally.add(*radiance));
            tally
        })
        .collect()
}
