//! Matter that light comes into straight: fogs, clouds, lamps in and beside them, surfaces of all finishes.

#![allow(clippy::print_stdout)]

mod common;

use std::f64::consts::PI;
use std::sync::Arc;

use common::{Tally, body, by_wavelength, flat_sky, paths, scene, spectrum};
use mieux_optics::phase::{AngleGrid, HenyeyGreenstein, PhaseFunction, Rayleigh, SpectralPhase, TableRule, Tabulated};
use mieux_optics::spectrum::WavelengthGrid;
use mieux_render::DVec3;
use mieux_render::geometry::{Mesh, Ray, cuboid, disk, sphere};
use mieux_render::integrator::Transport;
use mieux_render::light::{Environment, Lamp, Pattern, SkyImage, constant};
use mieux_render::medium::{Filter, Grid, Medium, Part, Phase, Placement};
use mieux_render::scene::{Body, Finish, Prepared, Scene, Surface};

fn of(value: f64) -> mieux_optics::spectrum::Sampled {
    constant(value).unwrap()
}

fn dark() -> Environment {
    Environment { spectrum: of(0.0), pattern: Pattern::Uniform }
}

fn part(sigma_s: f64, sigma_a: f64, g: f64) -> Part {
    Part {
        sigma_s: of(sigma_s),
        sigma_a: of(sigma_a),
        phase: Phase::HenyeyGreenstein(of(g)),
        emission: None,
        density: None,
    }
}

/// A grid over the cube of half side 1, its density a function of the place.
fn grid(size: [usize; 3], density: impl Fn([f64; 3]) -> f64) -> Arc<Grid> {
    let mut values = Vec::new();
    for k in 0..size[2] {
        for j in 0..size[1] {
            for i in 0..size[0] {
                let at = |c: usize, n: usize| 2.0 * (c as f64 + 0.5) / n as f64 - 1.0;
                values.push(density([at(i, size[0]), at(j, size[1]), at(k, size[2])]) as f32);
            }
        }
    }
    let placement = Placement { corner: [-1.0; 3], edges: [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]] };
    Arc::new(Grid::new(size, &values, Filter::Trilinear, &placement).unwrap())
}

fn ball(medium: Medium) -> Body {
    body("ball", sphere([0.0; 3], 0.9, 48).unwrap(), medium, 0)
}

/// Mean over wavelengths of what a ray sees.
fn seen(scene: &Scene, n: u64, ray: impl Fn(&mut mieux_render::sampler::PixelSampler) -> Ray + Sync) -> Tally {
    let prepared = Prepared::new(scene).unwrap();
    let (estimates, statistics) = paths(&prepared, &Transport::default(), n, ray);
    assert_eq!(statistics.lost, 0);
    let mut tally = Tally::default();
    estimates.iter().for_each(|e| tally.add(e.radiance.iter().sum::<f64>() / 4.0));
    tally
}

fn towards(from: [f64; 3], to: [f64; 3]) -> Ray {
    let (from, to) = (DVec3::from_array(from), DVec3::from_array(to));
    Ray { origin: from, direction: (to - from).normalize() }
}

fn assert_alike(a: &Tally, b: &Tally, what: &str) {
    let error = a.error().hypot(b.error());
    println!("{what}: {:.5} +- {:.5}, {:.5} +- {:.5}", a.mean(), a.error(), b.mean(), b.error());
    assert!((a.mean() - b.mean()).abs() < 3.0 * error, "{what}");
    assert!(error < 0.03 * a.mean(), "{what}: too noisy to tell");
}

fn eye(bodies: Vec<Body>, surfaces: Vec<Surface>) -> Scene {
    scene(bodies, surfaces, [0.0, -4.0, 0.3], [0.0, 0.0, 0.0])
}

/// A fog whose properties change with wavelength.
fn chromatic(sigma: f64, density: Option<Arc<Grid>>) -> Medium {
    let s = |v: [f64; 3]| spectrum(v.map(|v| v * sigma));
    let part = Part {
        sigma_s: s([3.0, 2.0, 1.0]),
        sigma_a: s([0.1, 0.2, 0.4]),
        phase: Phase::HenyeyGreenstein(spectrum([0.3, 0.6, 0.8])),
        emission: None,
        density,
    };
    Medium { n: of(1.0), parts: vec![part] }
}

/// A white sky does not see a white fog, however it is made and whatever else is in it.
#[test]
fn lossless_fogs_and_finishes_are_invisible() {
    let lumpy = grid([24, 20, 17], |p| (1.0 + (9.0 * p[0]).sin() * (7.0 * p[1] + 3.0 * p[2]).cos()) * 2.0);
    let cloud =
        Medium { n: of(1.0), parts: vec![part(0.5, 0.0, 0.7), Part { density: Some(lumpy), ..part(2.0, 0.0, 0.8) }] };
    let blend = Medium { n: of(1.0), parts: vec![part(1.0, 0.0, 0.9), part(2.0, 0.0, -0.3)] };
    let water = Medium::grey(3.0, 0.0, 0.9, 1.33).unwrap();
    let floor = Surface::diffuse("floor", disk([0.0, 0.0, -0.3], 3.0, 64).unwrap(), of(1.0));
    let pane = Surface {
        name: "pane".into(),
        mesh: disk([0.1, 0.0, 0.2], 0.5, 64).unwrap(),
        finish: Finish::ThinPane { n: spectrum([1.54, 1.52, 1.51]) },
        emission: None,
    };
    let mirror = Surface {
        name: "mirror".into(),
        mesh: disk([0.0, 0.2, 0.4], 0.4, 64).unwrap(),
        finish: Finish::Conductor { n: of(1e-3), k: of(1e3), roughness: 0.0 },
        emission: None,
    };
    let within = body("milk", sphere([0.2, 0.1, 0.0], 0.25, 32).unwrap(), water.clone(), 5);
    // A small patch of sky looked at by itself, so that looking for light is at work everywhere.
    let mut sun = vec![1.0f32; 64 * 32];
    sun[10 * 64 + 20] = 1.0;
    let image =
        SkyImage::new([64, 32], vec![of(1.0)], sun, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]).unwrap();
    let sky = Environment { spectrum: of(1.0), pattern: Pattern::Image(Arc::new(image)) };
    for (what, bodies, surfaces) in [
        ("fog", vec![ball(blend.clone())], vec![]),
        ("cloud", vec![ball(cloud.clone())], vec![]),
        ("cloud on a floor", vec![ball(cloud.clone())], vec![floor.clone()]),
        ("milk in a cloud", vec![ball(cloud), within.clone()], vec![floor.clone()]),
        ("milk in fog with a pane and a mirror", vec![ball(blend), within], vec![floor, pane, mirror]),
        ("milk", vec![ball(water)], vec![]),
    ] {
        for environment in [flat_sky(), sky.clone()] {
            let mut scene = eye(bodies.clone(), surfaces.clone());
            scene.environment = environment;
            let tally = seen(&scene, 40_000, |sampler| {
                let [u, v] = sampler.pair();
                towards([0.0, -4.0, 0.3], [1.6 * u - 0.8, 0.0, 1.6 * v - 0.8])
            });
            tally.assert_near(1.0, 3.0, 3e-3, what);
        }
    }
}

/// A grid of ones is the homogeneous medium; so are two halves, and tables of the same phase function.
#[test]
fn every_way_to_say_the_same_medium_looks_the_same() {
    let lit = |medium: Medium| {
        let lamp = Surface {
            name: "lamp".into(),
            mesh: sphere([0.3, -0.2, 1.4], 0.2, 24).unwrap(),
            finish: Finish::Diffuse { reflectance: of(0.0), both_sides: true },
            emission: Some(of(20.0)),
        };
        let mut scene = eye(vec![ball(medium)], vec![lamp]);
        scene.environment = dark();
        scene.lamps = vec![Lamp::Point { position: [-1.5, -1.0, 0.5], intensity: of(3.0) }];
        scene
    };
    let ones = || Some(grid([16, 9, 20], |_| 1.0));
    let plain = chromatic(1.0, None);
    let mut halves = chromatic(0.5, None);
    halves.parts.push(chromatic(0.5, ones()).parts[0].clone());
    let scale = |g: f64| -> PhaseFunction { HenyeyGreenstein::new(g).unwrap().into() };
    let grid_of = WavelengthGrid::new(vec![380e-9, 580e-9, 780e-9]).unwrap();
    let functions = vec![scale(0.3), scale(0.6), scale(0.8)];
    let spectral = Phase::Spectral(Arc::new(SpectralPhase::new(grid_of.clone(), functions).unwrap()));
    let tables = [0.3, 0.6, 0.8].map(|g| {
        let angles = AngleGrid::graded(60.0, 2.0).unwrap();
        let hg = HenyeyGreenstein::new(g).unwrap();
        PhaseFunction::from(Tabulated::from_fn(angles, TableRule::Integrated, |t| hg.value(t.cos())).unwrap())
    });
    let tabulated = Phase::Spectral(Arc::new(SpectralPhase::new(grid_of, tables.to_vec()).unwrap()));
    let with = |phase: &Phase, density| {
        let mut medium = chromatic(1.0, density);
        medium.parts[0].phase = phase.clone();
        medium
    };
    let look = |medium: Medium| {
        let prepared = Prepared::new(&lit(medium)).unwrap();
        let n = 150_000;
        let (estimates, statistics) = paths(&prepared, &Transport::default(), n, |sampler| {
            let [u, v] = sampler.pair();
            towards([0.0, -4.0, 0.3], [1.4 * u - 0.7, 0.0, 1.4 * v - 0.7])
        });
        assert_eq!(statistics.lost, 0);
        by_wavelength(&estimates, 3)
    };
    let expected = look(plain);
    for (what, medium) in [("a grid of ones", chromatic(1.0, ones())), ("half a grid", halves)] {
        for (a, b) in expected.iter().zip(look(medium)) {
            assert_alike(a, &b, what);
        }
    }
    // The mixture of two Henyey-Greenstein functions is not that of the mean cosine: the tables are compared with each other.
    let expected = look(with(&spectral, None));
    for (what, medium) in [("tables", with(&tabulated, None)), ("tables in a grid", with(&tabulated, ones()))] {
        for (a, b) in expected.iter().zip(look(medium)) {
            assert_alike(a, &b, what);
        }
    }
}

/// A thin fog scatters once: the line integral of what a point light sends into it.
#[test]
fn single_scattering_of_a_point_light_is_its_closed_form() {
    let (sigma_s, sigma_a) = (0.0004, 0.4);
    let light = DVec3::new(0.2, 0.1, 0.3);
    let rayleigh = PhaseFunction::from(Rayleigh);
    let medium = |density: Option<Arc<Grid>>| Medium {
        n: of(1.0),
        parts: vec![Part {
            phase: Phase::Function(Arc::new(rayleigh.clone())),
            density,
            ..part(sigma_s, sigma_a, 0.0)
        }],
    };
    let cube = cuboid([-1.0; 3], [1.0; 3]).unwrap();
    let ray = Ray { origin: DVec3::new(-0.3, -4.0, -0.1), direction: DVec3::Y };
    let steps = 200_000;
    let ds = 2.0 / f64::from(steps);
    let integral: f64 = (0..steps)
        .map(|i| {
            let s = (f64::from(i) + 0.5) * ds;
            let at = DVec3::new(-0.3, -1.0 + s, -0.1);
            let to = light - at;
            let left = (-(sigma_s + sigma_a) * (s + to.length())).exp();
            sigma_s * rayleigh.value(ray.direction.dot(to.normalize())) * 5.0 / to.length_squared() * left * ds
        })
        .sum();
    for (what, density) in [("fog", None), ("cloud", Some(grid([9, 9, 9], |_| 1.0)))] {
        let mut scene = eye(vec![body("cube", cube.clone(), medium(density), 0)], vec![]);
        scene.environment = dark();
        scene.lamps = vec![Lamp::Point { position: light.to_array(), intensity: of(5.0) }];
        let n = if what == "fog" { 20_000 } else { 1_000_000 };
        // Twice scattered light adds less than a thousandth here.
        seen(&scene, n, |_| ray).assert_near(integral, 3.5, 0.01, what);
    }
}

/// A little sphere that shines is a point light, for every kind of surface and medium: chance, which finds only one of the
/// two, and looking, which finds both, agree.
#[test]
fn a_small_lamp_is_a_point_light() {
    let radius = 0.05;
    let plate = |finish: Finish| Surface {
        name: "plate".into(),
        mesh: disk([0.0, 0.0, -0.2], 1.5, 64).unwrap(),
        finish,
        emission: None,
    };
    let rough = |n: f64| Body { roughness: 0.4, ..ball(Medium::grey(4.0, 0.1, 0.5, n).unwrap()) };
    let diffuse = Finish::Diffuse { reflectance: of(0.7), both_sides: true };
    let metal = Finish::Conductor { n: of(0.2), k: of(3.0), roughness: 0.5 };
    let floor = |finish: &Finish| vec![plate(finish.clone())];
    let lumpy = Some(grid([12, 12, 12], |p| 1.0 + p[0]));
    let (beside, within) = ([0.4, -0.5, 0.85], [0.2, -0.2, 0.3]);
    for (what, place, bodies, surfaces) in [
        ("diffuse", beside, vec![], floor(&diffuse)),
        ("metal", beside, vec![], floor(&metal)),
        ("fog", within, vec![ball(chromatic(0.4, None))], floor(&diffuse)),
        ("cloud", beside, vec![ball(chromatic(0.4, lumpy))], floor(&metal)),
        ("rough body around the lamp", within, vec![rough(1.33)], vec![]),
    ] {
        let mut scene = eye(bodies, surfaces);
        scene.environment = dark();
        let ray = |sampler: &mut mieux_render::sampler::PixelSampler| {
            let [u, v] = sampler.pair();
            towards([0.0, -4.0, 1.3], [u - 0.5, v - 0.5, -0.2])
        };
        scene.lamps = vec![Lamp::Point { position: place, intensity: of(PI * radius * radius * 100.0) }];
        let point = seen(&scene, 300_000, ray);
        scene.lamps.clear();
        // Facets lie within the sphere: made larger to have its area of projection.
        let mesh = sphere(place, radius * 1.0023, 32).unwrap();
        let black = Finish::Diffuse { reflectance: of(0.0), both_sides: true };
        scene.surfaces.push(Surface { name: "lamp".into(), mesh, finish: black, emission: Some(of(100.0)) });
        let small = seen(&scene, 300_000, ray);
        assert_alike(&point, &small, what);
    }
}

/// Light goes the same way both ways: what a lamp here brings there, a lamp there brings here.
#[test]
fn transport_is_reciprocal() {
    let lumpy = Some(grid([12, 15, 12], |p| (2.0 + 3.0 * p[0] - 2.0 * p[2]).max(0.0)));
    let fog = ball(chromatic(0.8, lumpy));
    let plate = Surface {
        name: "plate".into(),
        mesh: disk([0.0, 0.0, -0.5], 1.5, 64).unwrap(),
        finish: Finish::Conductor { n: of(0.2), k: of(3.0), roughness: 0.6 },
        emission: None,
    };
    let wall = Surface::diffuse("wall", cuboid([-2.0, 1.0, -1.0], [2.0, 1.1, 1.0]).unwrap(), of(0.8));
    // One of them in a hole of the cloud.
    let (a, b) = ([-0.65, 0.1, 0.35], [-1.2, -0.8, 0.6]);
    let fluence = |lamp: [f64; 3], at: [f64; 3]| {
        let mut scene = eye(vec![fog.clone()], vec![plate.clone(), wall.clone()]);
        scene.camera = mieux_render::camera::Pinhole::new(at, [0.0, 5.0, 0.0], [0.0, 0.0, 1.0], 30.0, [8, 8]).unwrap();
        scene.environment = dark();
        scene.lamps = vec![Lamp::Point { position: lamp, intensity: of(1.0) }];
        seen(&scene, 400_000, |sampler| {
            let [u, v] = sampler.pair();
            let (z, phi) = (2.0 * u - 1.0, 2.0 * PI * v);
            let r = (1.0 - z * z).sqrt();
            Ray { origin: DVec3::from_array(at), direction: DVec3::new(r * phi.cos(), r * phi.sin(), z) }
        })
    };
    assert_alike(&fluence(a, b), &fluence(b, a), "there and back");
}

/// A hot thick medium looks like its source function, a thin one like its share; a lossless rest does not matter.
#[test]
fn emission_fills_what_absorbs() {
    let source = 2.5;
    let cube = || cuboid([-1.0; 3], [1.0; 3]).unwrap();
    let flame = |density: Option<Arc<Grid>>, sigma_s| Medium {
        n: of(1.0),
        parts: vec![Part { emission: Some(of(source)), density, ..part(sigma_s, 0.7, 0.2) }],
    };
    for density in [None, Some(grid([8, 8, 8], |_| 1.0))] {
        let mut scene = eye(vec![body("flame", cube(), flame(density.clone(), 0.0), 0)], vec![]);
        scene.environment = dark();
        let ray = towards([0.1, -4.0, 0.2], [0.1, 0.0, 0.2]);
        let share = 1.0 - (-0.7f64 * 2.0).exp();
        seen(&scene, 100_000, |_| ray).assert_near(source * share, 4.0, 0.02, "flame");
        // In a sky as bright as itself it cannot be seen, even if it scatters.
        scene.bodies[0].medium = flame(density, 2.0);
        scene.environment = Environment { spectrum: of(source), pattern: Pattern::Uniform };
        seen(&scene, 50_000, |_| ray).assert_near(source, 3.0, 0.01, "hot furnace");
    }
}

/// A far lamp lights a diffuse plate as the cosine law says, and a spot light only its cone.
#[test]
fn lamps_light_as_they_should() {
    let plate: Mesh = disk([0.0; 3], 2.0, 64).unwrap();
    let mut scene = eye(vec![], vec![Surface::diffuse("plate", plate, of(0.6))]);
    scene.environment = dark();
    let direction = DVec3::new(0.3, 0.1, -0.8);
    scene.lamps = vec![Lamp::Directional { direction: direction.to_array(), irradiance: of(2.0) }];
    let ray = towards([0.0, -2.0, 2.0], [0.5, 0.3, 0.0]);
    let expected = 0.6 / PI * 2.0 * 0.8 / direction.length();
    seen(&scene, 1000, |_| ray).assert_near(expected, 4.0, 1e-9, "far lamp");
    let spot = |x: f64| Lamp::Spot {
        position: [x, 0.3, 1.0],
        direction: [0.0, 0.0, -1.0],
        intensity: of(3.0),
        cutoff: 0.5,
        beam_width: 0.25,
    };
    for (x, profile) in [(0.5, 1.0), (0.5 + 0.4f64.tan(), 0.4), (1.2, 0.0)] {
        scene.lamps = vec![spot(x)];
        let squared = 1.0 + (x - 0.5).powi(2);
        let expected = 0.6 / PI * 3.0 * profile / squared.powf(1.5);
        seen(&scene, 1000, |_| ray).assert_near(expected, 4.0, 1e-9, "spot");
    }
}
