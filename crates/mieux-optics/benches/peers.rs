//! Workloads timed against other programs by `benches/peers/mie/run.py`: one JSON line each, one thread.
//!
//! `cargo bench -p mieux-optics --bench peers -- --workload NAME`, without a name all of them.

use std::f64::consts::PI;
use std::hint::black_box;

use mieux_optics::Complex64;
use mieux_optics::mie::{Directions, PlaneWave, Sphere, scatter_spheres};
use rustix::time::{ClockId, clock_gettime};

fn log_spaced(from: f64, to: f64, count: usize) -> impl Iterator<Item = f64> {
    let ratio = (to / from).ln() / (count.max(2) - 1) as f64;
    (0..count).map(move |i| from * (ratio * i as f64).exp())
}

fn spheres(from: f64, to: f64, count: usize) -> Vec<Sphere> {
    let wave = PlaneWave::new(1.0, Complex64::new(1.0, 0.0)).expect("within range");
    log_spaced(from, to, count)
        .map(|x| Sphere::new(wave, x / (2.0 * PI), Complex64::new(1.5, 0.01)).expect("within range"))
        .collect()
}

/// Radii x wavelengths, in a host with imaginary index `host_im`.
fn population(host_im: f64) -> Vec<Sphere> {
    let mut all = Vec::new();
    for i in 0..17 {
        let wavelength = (380.0 + 25.0 * f64::from(i)) * 1e-9;
        let wave = PlaneWave::new(wavelength, Complex64::new(1.33, host_im)).expect("within range");
        let radii = log_spaced(1e-8, 1e-5, 1000);
        all.extend(radii.map(|r| Sphere::new(wave, r, Complex64::new(1.5, 0.01)).expect("within range")));
    }
    all
}

/// Processor time used so far, s.
fn cpu_seconds() -> f64 {
    let t = clock_gettime(ClockId::ProcessCPUTime);
    t.tv_sec as f64 + 1e-9 * t.tv_nsec as f64
}

fn time(name: &str, spheres: &[Sphere]) {
    let mut best = f64::INFINITY;
    let mut out = Vec::new();
    for _ in 0..9 {
        out.clear();
        let start = cpu_seconds();
        scatter_spheres(black_box(spheres), &mut out).expect("computed");
        best = best.min(cpu_seconds() - start);
        black_box(&out);
    }
    println!("{{\"workload\": \"{name}\", \"spheres\": {}, \"cpu_seconds\": {best:e}}}", spheres.len());
}

fn time_amplitudes(spheres: &[Sphere]) {
    let mut best = f64::INFINITY;
    for _ in 0..5 {
        let start = cpu_seconds();
        let directions = Directions::uniform(1801);
        for sphere in black_box(spheres) {
            black_box(sphere.coefficients().amplitudes(&directions).expect("computed"));
        }
        best = best.min(cpu_seconds() - start);
    }
    println!("{{\"workload\": \"amplitudes\", \"spheres\": {}, \"cpu_seconds\": {best:e}}}", spheres.len());
}

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let workloads: [(&str, Vec<Sphere>); 6] = [
        ("x1to100", spheres(1.0, 100.0, 100_000)),
        ("x0.1to1000", spheres(0.1, 1000.0, 100_000)),
        ("population", population(0.0)),
        ("population-absorbing", population(1e-4)),
        ("x1e5", spheres(1e5, 1e5, 1)),
        ("x1e6", spheres(1e6, 1e6, 1)),
    ];
    for (name, spheres) in &workloads {
        if wanted.is_empty() || wanted.iter().any(|w| w == name) {
            time(name, spheres);
        }
    }
    if wanted.is_empty() || wanted.iter().any(|w| w == "amplitudes") {
        time_amplitudes(&spheres(1.0, 100.0, 1000));
    }
}
