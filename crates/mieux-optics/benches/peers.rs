//! Workloads timed beside other programs by `benches/peers/mie/run.py`, which describes them: one JSON line each, one
//! thread, processor time, the making of the spheres included.
//!
//! `cargo bench -p mieux-optics --bench peers -- --workload NAME`, without a name all of them.

#![allow(clippy::print_stdout)]

use std::f64::consts::PI;
use std::hint::black_box;

use mieux_optics::Complex64;
use mieux_optics::mie::{
    Directions, Layer, LayeredSphere, PlaneWave, Population, PopulationScattering, ScatteringDefinition, Sphere,
    scatter_layered_spheres,
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

/// What a workload makes, with what its checksum needs.
enum Made<'a> {
    /// Radii, and what spheres of them do.
    CrossSections(&'a [f64], PopulationScattering),
    /// The sum of squared moduli of amplitudes, and of how many spheres.
    Amplitudes(usize, f64),
}

impl Made<'_> {
    /// Number of spheres, and the sum of their efficiencies or of their squared amplitudes, by which contenders are seen
    /// to do the same.
    fn checksum(&self) -> (usize, f64) {
        match self {
            Self::CrossSections(radii, all) => {
                let both = all.extinction.iter().zip(&all.scattering).enumerate();
                (all.extinction.len(), both.map(|(i, (e, s))| (e + s) / (PI * radii[i % radii.len()].powi(2))).sum())
            }
            Self::Amplitudes(spheres, sum) => (*spheres, *sum),
        }
    }
}

/// A population, into the memory of results had before.
fn population<'a>(
    mut all: PopulationScattering,
    radii: &'a [f64],
    wavelengths: &[f64],
    host: &[Complex64],
    particle: &[Complex64],
) -> Made<'a> {
    let definition = ScatteringDefinition::default();
    Population { radii, wavelengths, host, particle, definition }.scatter_into(&mut all).expect("computed");
    Made::CrossSections(radii, all)
}

fn spheres(all: PopulationScattering, sizes: &[f64]) -> Made<'_> {
    population(all, sizes, &[2.0 * PI], &[c(1.0, 0.0)], &[c(1.5, 0.01)])
}

/// Radii by wavelengths, in a host with imaginary index `host_im`.
fn table(all: PopulationScattering, radii: &[f64], host_im: f64) -> Made<'_> {
    let nm: [f64; 17] = std::array::from_fn(|i| 380.0 + 25.0 * i as f64);
    let host = nm.map(|nm| c(1.32 + 3100.0 / (nm * nm), host_im));
    let particle = nm.map(|nm| c(1.45 + 4000.0 / (nm * nm), 1e-6));
    population(all, radii, &nm.map(|nm| nm * 1e-9), &host, &particle)
}

fn amplitudes(sizes: &[f64]) -> Made<'_> {
    let (wave, index) = (vacuum(), c(1.5, 0.01));
    let directions = Directions::uniform(1801);
    let mut sum = 0.0;
    for x in sizes {
        let coefficients = Sphere::new(wave, *x, index).expect("within range").coefficients();
        let amplitudes = coefficients.amplitudes(&directions).expect("computed");
        sum += amplitudes.iter().flatten().map(|s| s.norm_sqr()).sum::<f64>();
    }
    Made::Amplitudes(sizes.len(), sum)
}

fn layers(sizes: &[f64], count: usize) -> Made<'_> {
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
    let (extinction, scattering) = out.iter().map(|s| (s.extinction, s.scattering)).unzip();
    Made::CrossSections(sizes, PopulationScattering { extinction, scattering, ..Default::default() })
}

/// Takes the memory of results had before.
type Work<'a> = dyn Fn(PopulationScattering) -> Made<'a> + 'a;

fn time(name: &str, work: &Work) {
    let (mut best, mut memory, mut sums) = (f64::INFINITY, PopulationScattering::default(), (0, 0.0));
    for _ in 0..9 {
        let start = cpu_seconds();
        let made = black_box(work(memory));
        best = best.min(cpu_seconds() - start);
        sums = made.checksum();
        memory = match made {
            Made::CrossSections(_, all) => all,
            Made::Amplitudes(..) => PopulationScattering::default(),
        };
    }
    let (spheres, checksum) = sums;
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
        ("spheres-100", &|all| spheres(all, &hundred)),
        ("spheres-1000", &|all| spheres(all, &thousand)),
        ("table-lossless", &|all| table(all, &radii, 0.0)),
        ("table-absorbing", &|all| table(all, &radii, 1e-6)),
        ("single-1e5", &|all| spheres(all, &[1e5])),
        ("single-1e6", &|all| spheres(all, &[1e6])),
        ("amplitudes", &|_| amplitudes(&few)),
        ("layers-2", &|_| layers(&some, 2)),
        ("layers-10", &|_| layers(&some, 10)),
    ];
    for (name, work) in workloads {
        if wanted.is_empty() || wanted.iter().any(|w| w == name) {
            time(name, work);
        }
    }
}
