//! How long the optical properties take.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use mieux_optics::Complex64;
use mieux_optics::material::milk::Milk;
use mieux_optics::medium::DEFAULT_TOLERANCE;
use mieux_optics::mie::scatter_sphere;
use mieux_optics::spectrum::WavelengthGrid;

fn spheres(c: &mut Criterion) {
    let (host, particle) = (Complex64::new(1.34, 6e-8), Complex64::new(1.46, 4.6e-6));
    for x in [1.0, 10.0, 100.0] {
        let radius = x / (2.0 * std::f64::consts::PI * 1.34) * 550e-9;
        c.bench_function(&format!("one sphere, size parameter {x}"), |b| {
            b.iter(|| scatter_sphere(black_box(radius), 550e-9, host, particle));
        });
    }
}

fn whole_milk(c: &mut Criterion) {
    let medium = Milk::new([3.5, 3.4, 20.0, 0.17]).and_then(|milk| milk.medium()).expect("whole milk is possible");
    let grid = WavelengthGrid::frisvad2007();
    c.bench_function("whole milk, 17 wavelengths, one thread", |b| {
        b.iter(|| black_box(&medium).bulk_optics(&grid, DEFAULT_TOLERANCE));
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20);
    targets = spheres, whole_milk
}
criterion_main!(benches);
