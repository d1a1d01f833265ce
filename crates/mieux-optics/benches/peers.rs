//! Workloads timed beside other programs by `benches/peers/mie/run.py`, which describes them: one JSON line each, one
//! thread, processor time, the making of the spheres included.
//!
//! `cargo bench -p mieux-optics --bench peers -- --workload NAME`, without a name all of them.

#![allow(clippy::print_stdout)]

use std::f64::consts::PI;
use std::hint::black_box;

use mieux_optics::Complex64;
use mieux_optics::mie::{
    Directions, Layer, LayeredSphere, PlaneWave, Population, ScatteringDefinition, Sphere, scatter_layered_spheres,
};
use rustix::time::{ClockId, clock_gettime};

/// Processor time used so far, s.
fn cpu_seconds() -> f64 {
    let t = clock_gettime(ClockId::ProcessCPUTime);
    t.tv_sec as f64 + 1e-9 * t.tv_nsec as f64
}

fn c(re: f64, im: f64) -> Complex64 {
    Complex64::new(re, im)
}

fn log_spaced(from: f64, to: f64, count: usize) -> Vec<f64> {
    let ratio = (to / from).ln() / (count.max(2) - 1) as f64;
    (0..count).map(|i| from * (ratio * i as f64).exp()).collect()
}

/// A wave in vacuum, and the radius that has a size parameter.
fn vacuum() -> PlaneWave {
    PlaneWave::new(2.0 * PI, c(1.0, 0.0)).expect("within range")
}

/// Sum of the efficiencies, by which contenders are seen to do the same.
fn checksum(radii: &[f64], extinction: &[f64], scattering: &[f64]) -> f64 {
    let sums = extinction.iter().zip(scattering).enumerate();
    sums.map(|(i, (e, s))| (e + s) / (PI * radii[i % radii.len()].powi(2))).sum()
}

fn population(radii: &[f64], wavelengths: &[f64], host: &[Complex64], particle: &[Complex64]) -> (usize, f64) {
    let definition = ScatteringDefinition::default();
    let all = Population { radii, wavelengths, host, particle, definition }.scatter().expect("computed");
    (all.extinction.len(), checksum(radii, &all.extinction, &all.scattering))
}

fn spheres(sizes: &[f64]) -> (usize, f64) {
    population(sizes, &[2.0 * PI], &[c(1.0, 0.0)], &[c(1.5, 0.01)])
}

/// Radii by wavelengths, in a host with imaginary index `host_im`.
fn table(radii: &[f64], host_im: f64) -> (usize, f64) {
    let nm: [f64; 17] = std::array::from_fn(|i| 380.0 + 25.0 * i as f64);
    let host = nm.map(|nm| c(1.32 + 3100.0 / (nm * nm), host_im));
    let particle = nm.map(|nm| c(1.45 + 4000.0 / (nm * nm), 1e-6));
    population(radii, &nm.map(|nm| nm * 1e-9), &host, &particle)
}

fn amplitudes(sizes: &[f64]) -> (usize, f64) {
    let (wave, index) = (vacuum(), c(1.5, 0.01));
    let directions = Directions::uniform(1801);
    let mut sum = 0.0;
    for x in sizes {
        let coefficients = Sphere::new(wave, *x, index).expect("within range").coefficients();
        let amplitudes = coefficients.amplitudes(&directions).expect("computed");
        sum += amplitudes.iter().flatten().map(|s| s.norm_sqr()).sum::<f64>();
    }
    (sizes.len(), sum)
}

fn layers(sizes: &[f64], count: usize) -> (usize, f64) {
    let wave = vacuum();
    let layer = |x: f64, i: usize| Layer {
        radius: x * (i + 1) as f64 / count as f64,
        index: if i.is_multiple_of(2) { c(1.33, 0.001) } else { c(1.5, 0.01) },
    };
    let sphere = |x: &f64| {
        let layers: Vec<Layer> = (0..count).map(|i| layer(*x, i)).collect();
        LayeredSphere::new(wave, &layers).expect("within range")
    };
    let spheres: Vec<LayeredSphere> = sizes.iter().map(sphere).collect();
    let mut out = Vec::new();
    scatter_layered_spheres(&spheres, &mut out).expect("computed");
    let (extinction, scattering): (Vec<f64>, Vec<f64>) = out.iter().map(|s| (s.extinction, s.scattering)).unzip();
    (spheres.len(), checksum(sizes, &extinction, &scattering))
}

/// How many spheres were computed, and a sum that shows what came out.
type Work<'a> = dyn Fn() -> (usize, f64) + 'a;

fn time(name: &str, work: &Work) {
    let (mut best, mut result) = (f64::INFINITY, (0, 0.0));
    for _ in 0..9 {
        let start = cpu_seconds();
        result = black_box(work());
        best = best.min(cpu_seconds() - start);
    }
    let (spheres, checksum) = result;
    println!(
        "{{\"workload\": \"{name}\", \"spheres\": {spheres}, \"cpu_seconds\": {best:e}, \"checksum\": {checksum:.12e}}}"
    );
}

fn main() {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("one thread");
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let (hundred, thousand) = (log_spaced(1.0, 100.0, 100_000), log_spaced(0.1, 1000.0, 100_000));
    let radii = log_spaced(1e-8, 1e-5, 1000);
    let (few, some) = (log_spaced(1.0, 100.0, 1000), log_spaced(1.0, 100.0, 10_000));
    let workloads: [(&str, &Work); 9] = [
        ("spheres-100", &|| spheres(&hundred)),
        ("spheres-1000", &|| spheres(&thousand)),
        ("table-lossless", &|| table(&radii, 0.0)),
        ("table-absorbing", &|| table(&radii, 1e-6)),
        ("single-1e5", &|| spheres(&[1e5])),
        ("single-1e6", &|| spheres(&[1e6])),
        ("amplitudes", &|| amplitudes(&few)),
        ("layers-2", &|| layers(&some, 2)),
        ("layers-10", &|| layers(&some, 10)),
    ];
    for (name, work) in workloads {
        if wanted.is_empty() || wanted.iter().any(|w| w == name) {
            time(name, work);
        }
    }
}
