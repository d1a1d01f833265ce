//! Lossless bodies under a white sky cannot be seen: everything is 1.

#![allow(clippy::print_stdout)]

mod common;

use common::{RANGE, by_wavelength, flat_sky, paths, spectrum};
use mieux_render::integrator::Transport;
use mieux_render::light::constant;
use mieux_render::medium::Medium;
use mieux_render::scene::{Finish, GlassScene, Prepared, Scene, glasses};

fn scene(milk: Medium, table: bool) -> Scene {
    let glass = Medium::clear(constant(0.0).unwrap(), spectrum([1.54, 1.523, 1.517])).unwrap();
    let mut wanted = GlassScene::new(vec![("milk".into(), milk)], glass);
    wanted.wavelength_range = RANGE;
    let mut scene = glasses(&wanted).unwrap();
    scene.environment = flat_sky();
    if table {
        let white = constant(1.0).unwrap();
        scene.surfaces[0].finish = Finish::Diffuse { reflectance: white, both_sides: true };
    } else {
        scene.surfaces.clear();
    }
    scene
}

/// Every bin of wavelengths is 1 within three standard errors and the `share` given; all
/// wavelengths together within three standard errors and 0.5 %.
fn assert_invisible(scene: &Scene, transport: &Transport, n: u64, share: f64, what: &str) {
    let prepared = Prepared::new(scene).unwrap();
    let [width, height] = prepared.camera().resolution().map(f64::from);
    let (estimates, statistics) = paths(&prepared, transport, n, |sampler| {
        let [x, y] = sampler.pair();
        prepared.camera().ray(x * width, y * height)
    });
    println!("{what}: {statistics:?}");
    assert_eq!(statistics.lost, 0, "{what}");
    for (bin, tally) in by_wavelength(&estimates, 8).iter().enumerate() {
        tally.assert_near(1.0, 3.0, share, &format!("{what}, bin {bin}"));
    }
    let mut all = common::Tally::default();
    estimates.iter().for_each(|e| all.add(e.radiance.iter().sum::<f64>() / 4.0));
    all.assert_near(1.0, 3.0, 5e-3, what);
}

fn chromatic() -> Medium {
    Medium::new(
        spectrum([9_000.0, 7_000.0, 5_000.0]),
        constant(0.0).unwrap(),
        spectrum([0.80, 0.85, 0.88]),
        spectrum([1.357, 1.347, 1.343]),
    )
}

#[test]
fn whole_milk_in_a_glass() {
    let milk = Medium::grey(57_837.0, 0.0, 0.954, 1.347).unwrap();
    assert_invisible(&scene(milk, false), &Transport::default(), 40_000, 5e-3, "whole milk");
}

#[test]
fn chromatic_milk_in_a_glass() {
    assert_invisible(&scene(chromatic(), false), &Transport::default(), 300_000, 5e-3, "chromatic");
}

#[test]
fn chromatic_milk_with_dispersion() {
    let transport = Transport { dispersion: true, ..Transport::default() };
    assert_invisible(&scene(chromatic(), false), &transport, 300_000, 5e-3, "dispersive");
}

#[test]
fn milk_on_a_white_table() {
    assert_invisible(&scene(chromatic(), true), &Transport::default(), 1_200_000, 5e-3, "on a table");
}
