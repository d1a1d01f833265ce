//! Time per collision of the random walk in whole milk, and of the queries it rests on.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use mieux_optics::phase::{HenyeyGreenstein, PhaseFunction};
use mieux_optics::transfer::{Ground, Incidence, Layer, Moments, Stack};
use mieux_render::DVec3;
use mieux_render::camera::Pinhole;
use mieux_render::detector::slab::SlabWalk;
use mieux_render::geometry::{Accelerator, DrinkingGlass, Ray, sphere};
use mieux_render::integrator::{Statistics, Transport, trace};
use mieux_render::light::Environment;
use mieux_render::medium::Medium;
use mieux_render::render::Flow;
use mieux_render::sampler::PixelSampler;
use mieux_render::scene::{Body, Prepared, Scene};

/// A ball of whole milk of 3 cm radius, seen from its middle and from outside.
fn ball(eye: [f64; 3]) -> Option<Prepared> {
    let milk = Medium::grey(57_837.0, 6.08, 0.954, 1.347)?;
    let body =
        Body { name: "milk".into(), mesh: sphere([0.0; 3], 0.03, 64).ok()?, medium: milk, priority: 0, roughness: 0.0 };
    let camera = Pinhole::new(eye, [0.001; 3], [0.0, 0.0, 1.0], 15.0, [64, 64]).ok()?;
    let environment = Environment::white_sky();
    let range = (380e-9, 775e-9);
    Prepared::new(&Scene {
        camera,
        environment,
        lamps: vec![],
        bodies: vec![body],
        surfaces: vec![],
        wavelength_range: range,
    })
    .ok()
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

/// Photons through slabs: van de Hulst's, three layers of tissue, and a thick one.
fn slabs(criterion: &mut Criterion) {
    let layer = |tau, albedo, g| -> Option<(Layer, PhaseFunction)> {
        let layer = Layer::new(tau, albedo, Moments::henyey_greenstein(g).ok()?);
        Some((layer, HenyeyGreenstein::new(g).ok()?.into()))
    };
    let tissue = [(10.1, 100.0 / 101.0, 0.9), (1.1, 10.0 / 11.0, 0.0), (2.4, 10.0 / 12.0, 0.7)];
    let stacks = [("one layer", vec![(2.0, 0.9, 0.75)], 1.0), ("three layers", tissue.to_vec(), 1.37)];
    let mut group = criterion.benchmark_group("photons through slabs");
    for (name, layers, index) in stacks.into_iter().chain([("thick", vec![(1000.0, 0.9999, 0.9)], 1.5)]) {
        let Some(pairs) = layers.into_iter().map(|(t, a, g)| layer(t, a, g)).collect::<Option<Vec<_>>>() else {
            continue;
        };
        let (layers, phases): (Vec<Layer>, Vec<PhaseFunction>) = pairs.into_iter().unzip();
        let layers = layers.into_iter().map(|layer| layer.with_index(index)).collect();
        let stack = Stack { above: 1.0, layers, below: 1.0, ground: Ground::Black };
        let photons = if name == "thick" { 2_000 } else { 50_000 };
        let walk = SlabWalk::new(stack, phases, Incidence::NORMAL, photons, 1);
        let collisions = walk.run(&mut |_| Flow::Continue).map_or(0, |counts| counts.collisions);
        let each = collisions as f64 / photons as f64;
        group.sample_size(10).throughput(Throughput::Elements(photons));
        group.bench_function(format!("{name}, {each:.0} collisions each"), |b| {
            b.iter(|| walk.run(&mut |_| Flow::Continue))
        });
    }
    group.finish();
}

criterion_group!(benches, walk, queries, slabs);
criterion_main!(benches);
