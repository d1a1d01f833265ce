//! Time per collision of the random walk in whole milk, and of the queries it rests on.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use mieux_render::DVec3;
use mieux_render::camera::Pinhole;
use mieux_render::geometry::{Accelerator, DrinkingGlass, Ray, sphere};
use mieux_render::integrator::{Statistics, Transport, trace};
use mieux_render::light::Environment;
use mieux_render::medium::Medium;
use mieux_render::sampler::PixelSampler;
use mieux_render::scene::{Body, Prepared, Scene};

/// A ball of whole milk of 3 cm radius, seen from its middle and from outside.
fn ball(eye: [f64; 3]) -> Option<Prepared> {
    let milk = Medium::grey(57_837.0, 6.08, 0.954, 1.347)?;
    let body = Body { name: "milk".into(), mesh: sphere([0.0; 3], 0.03, 64).ok()?, medium: milk, priority: 0 };
    let camera = Pinhole::new(eye, [0.001; 3], [0.0, 0.0, 1.0], 15.0, [64, 64]).ok()?;
    let environment = Environment::white_sky();
    let range = (380e-9, 775e-9);
    Prepared::new(&Scene { camera, environment, bodies: vec![body], surfaces: vec![], wavelength_range: range }).ok()
}

/// Paths `first..first + n`; returns how many collisions they had.
fn collisions(scene: &Prepared, first: u32, n: u32) -> u64 {
    let mut statistics = Statistics::default();
    for i in first..first + n {
        let mut sampler = PixelSampler::new(1, i, 0, 0);
        let ray = scene.camera().ray(32.0, 32.0);
        std::hint::black_box(trace(scene, &Transport::default(), ray, &mut sampler, &mut statistics));
    }
    statistics.collisions
}

fn walk(criterion: &mut Criterion) {
    for (name, eye, paths) in [("from outside", [0.0, -0.2, 0.0], 2000), ("from the middle", [0.0; 3], 100)] {
        let Some(scene) = ball(eye) else { continue };
        let mut group = criterion.benchmark_group("whole milk, per collision");
        group.sample_size(20).throughput(Throughput::Elements(collisions(&scene, 0, paths)));
        group.bench_function(name, |b| b.iter(|| collisions(&scene, 0, paths)));
        group.finish();
    }
}

fn queries(criterion: &mut Criterion) {
    let glass = DrinkingGlass::default();
    let (Ok(body), Ok(liquid)) = (glass.glass(), glass.liquid(0.08)) else { return };
    let accelerator = Accelerator::new([&body, &liquid]);
    let points: Vec<DVec3> = (0..1000)
        .map(|i| {
            let angle = f64::from(i) * 2.399963;
            let r = glass.inner_radius() - 1e-3 * f64::from(i % 10) / 10.0;
            DVec3::new(r * angle.cos(), r * angle.sin(), 0.01 + 6.5e-5 * f64::from(i))
        })
        .collect();
    let mut group = criterion.benchmark_group("queries near the wall");
    group.throughput(Throughput::Elements(1000));
    group.bench_function("distance bound", |b| {
        b.iter(|| points.iter().map(|&p| accelerator.distance_lower_bound(p)).sum::<f64>())
    });
    group.bench_function("short ray", |b| {
        let hit = |p: &DVec3| {
            accelerator.intersect(&Ray { origin: *p, direction: DVec3::X }, 2e-5, Accelerator::NONE).is_some()
        };
        b.iter(|| points.iter().filter(|p| hit(p)).count())
    });
    group.finish();
}

criterion_group!(benches, walk, queries);
criterion_main!(benches);
