//! Diffusion: its profiles against photons, and the approximate way through bodies against what it promises.

#![allow(clippy::print_stdout)]

mod common;

use std::f64::consts::PI;

use common::{body, by_wavelength, paths, scene, slab, slab_share, spectrum};
use mieux_optics::phase::{HenyeyGreenstein, PhaseFunction};
use mieux_optics::transfer::diffusion::{DiffusionMedium, DiffusionModel, Profile};
use mieux_optics::transfer::{Incidence, Layer, Moments, Stack};
use mieux_render::DVec3;
use mieux_render::detector::slab::{Rings, SlabCounts, SlabWalk};
use mieux_render::geometry::{Ray, sphere};
use mieux_render::integrator::Transport;
use mieux_render::medium::Medium;
use mieux_render::render::Flow;
use mieux_render::scene::Prepared;

const DIFFUSE: Transport = Transport { dispersion: false, similarity: false, diffusion: true, companions: true };

/// Photons down a pencil beam into a half-space whose transport mean free path is 1 m.
fn photons(medium: &DiffusionMedium, edges: &[f64], photons: u64) -> SlabCounts {
    let phase = PhaseFunction::from(HenyeyGreenstein::new(medium.asymmetry()).unwrap());
    let depth = 100.0;
    let layer = Layer::new(depth * medium.sigma_t(), medium.albedo(), Moments::of(&phase, 2).unwrap());
    let eta = medium.relative_index();
    let stack = Stack { below: eta, ..Stack::slab(layer.with_index(eta)) };
    let mut walk = SlabWalk::new(stack, vec![phase], Incidence::NORMAL, photons, 3);
    walk.rings = Some(Rings { edges: edges.to_vec(), thickness: vec![depth] });
    walk.run(&mut |_| Flow::Continue).unwrap()
}

/// Mean of a profile over a ring.
fn mean(profile: &Profile, [from, to]: [f64; 2]) -> f64 {
    let step = (to / from).ln() / 4.0;
    let at = |k: f64| {
        let r = from * (k * step).exp();
        2.0 * PI * r * r * profile.reflectance(r)
    };
    let power = 2.0 * step / 45.0 * (7.0 * (at(0.0) + at(4.0)) + 32.0 * (at(1.0) + at(3.0)) + 12.0 * at(2.0));
    power / (PI * (to * to - from * from))
}

/// From one to eight transport mean free paths the models are as near to photons as has been measured, with a little room
/// for noise; the total of photons is that of discrete ordinates.
#[test]
fn profiles_are_near_photons() {
    let edges = [1.0, 1.5, 2.2, 3.2, 4.6, 6.5, 8.0];
    for (albedo, g, eta, allowed) in BOUNDS {
        let medium = DiffusionMedium::new(1.0 - albedo, albedo / (1.0 - g), g, eta).unwrap();
        let counts = photons(&medium, &edges, 200_000);
        let entering = medium.entering();
        let exact = medium.exact_total().unwrap();
        let total = (counts.reflectance.value - counts.reflectance_specular.value) / entering;
        assert!((total - exact).abs() < 5.0 * counts.reflectance.error + 1e-4, "{total} {exact}");
        for (model, allowed) in DiffusionModel::ALL.into_iter().zip(allowed) {
            let profile = Profile::new(model, &medium).unwrap();
            let (mut off, mut there, mut variance) = (0.0, 0.0, 0.0);
            for (ends, found) in counts.radial_up.as_ref().unwrap().rings() {
                let area = ends[1] * ends[1] - ends[0] * ends[0];
                off += area * (entering * mean(&profile, ends) - found.value).abs();
                there += area * found.value;
                variance += (area * found.error).powi(2);
            }
            let (off, noise) = (off / there, variance.sqrt() / there);
            println!("{albedo} {g} {eta} {}: {off:.4} +- {noise:.4}", model.name());
            assert!(off < allowed + 3.0 * noise, "{albedo} {g} {eta} {}: {off} +- {noise}", model.name());
        }
    }
}

/// Reduced albedo, g, index; and by which share each model (in the order of `ALL`) may be off.
const BOUNDS: [(f64, f64, f64, [f64; 5]); 3] = [
    (0.99, 0.8, 1.347, [0.14, 0.125, 0.035, 0.20, 0.08]),
    (0.99, 0.0, 1.0, [0.255, 0.255, 0.32, 0.57, 0.135]),
    (0.8, 0.0, 1.3, [0.55, 0.59, 0.27, 1.22, 0.12]),
];

/// Under an even sky a deep slab returns what enters times the exact total, whatever is sampled: places, axes, wavelengths,
/// lights and directions must all be weighed right.
#[test]
fn a_deep_slab_returns_the_exact_total() {
    for (sigma_s, sigma_a, g, n) in [(54_000.0, 6_000.0, 0.0, 1.5), (60_000.0, 20.0, 0.95, 1.35), (5e4, 0.0, 0.5, 1.0)]
    {
        let found = slab_share(&slab(Medium::grey(sigma_s, sigma_a, g, n).unwrap(), 0.1, true), &DIFFUSE, 100_000);
        let medium = DiffusionMedium::new(sigma_a, sigma_s, g, n).unwrap();
        let expected = 1.0 - medium.entering() * (1.0 - medium.exact_total().unwrap());
        found.assert_near(expected, 4.0, 1e-2, "deep slab");
    }
}

/// The same where every wavelength scatters and absorbs differently: a path found for one stands for the others.
#[test]
fn wavelengths_share_their_paths() {
    let medium = Medium::new(
        spectrum([80_000.0, 40_000.0, 20_000.0]),
        spectrum([2_000.0, 100.0, 10.0]),
        spectrum([0.3, 0.3, 0.3]),
        spectrum([1.35, 1.35, 1.35]),
    );
    let slab = slab(medium, 0.1, true);
    let down = Ray { origin: slab.camera().position(), direction: -DVec3::Z };
    for companions in [true, false] {
        let (estimates, _) = paths(&slab, &Transport { companions, ..DIFFUSE }, 150_000, |_| down);
        let bins = 10;
        let mut wavelengths: Vec<f64> = estimates.iter().flat_map(|e| e.wavelengths).collect();
        wavelengths.sort_by(f64::total_cmp);
        let parts = wavelengths.chunks(wavelengths.len().div_ceil(bins));
        for (part, found) in parts.zip(by_wavelength(&estimates, bins)) {
            let middle = part[part.len() / 2] * 1e9;
            let between = |low: f64, high: f64, t: f64| low + (high - low) * t;
            let (sigma_s, sigma_a) = if middle < 580.0 {
                let t = (middle - 380.0) / 200.0;
                (between(80_000.0, 40_000.0, t), between(2_000.0, 100.0, t))
            } else {
                let t = (middle - 580.0) / 200.0;
                (between(40_000.0, 20_000.0, t), between(100.0, 10.0, t))
            };
            let here = DiffusionMedium::new(sigma_a, sigma_s, 0.3, 1.35).unwrap();
            let expected = 1.0 - here.entering() * (1.0 - here.exact_total().unwrap());
            let off = (found.mean() - expected).abs();
            println!("{middle:.0} nm: {:.4} +- {:.4} for {expected:.4}", found.mean(), found.error());
            // The mean over a bin is not the value in its middle.
            assert!(off < 4.0 * found.error() + 0.01 * expected, "{middle}: {} {expected}", found.mean());
        }
    }
}

/// A white ball under a white sky is nearly white: what is lost or made where the surface is not flat.
#[test]
fn a_ball_in_a_furnace() {
    let medium = Medium::grey(1e5, 0.0, 0.8, 1.4).unwrap();
    let ball = sphere([0.0; 3], 5e-3, 64).unwrap();
    let scene = Prepared::new(&scene(vec![body("ball", ball, medium, 0)], vec![], [0.0, -1.0, 0.0], [0.0; 3])).unwrap();
    let ray = Ray { origin: DVec3::new(1e-3, -1.0, 2e-3), direction: DVec3::Y };
    let (estimates, statistics) = paths(&scene, &DIFFUSE, 100_000, |_| ray);
    let mut tally = common::Tally::default();
    estimates.iter().for_each(|e| tally.add(e.radiance.iter().sum::<f64>() / 4.0));
    println!("{:.4} +- {:.4}, {statistics:?}", tally.mean(), tally.error());
    assert_eq!(statistics.lost, 0);
    assert!((tally.mean() - 1.0).abs() < 0.03 + 3.0 * tally.error(), "{}", tally.mean());
}

/// What is too thin is walked through, to the bit.
#[test]
fn thin_bodies_are_walked_through() {
    let medium = || Medium::grey(5_000.0, 10.0, 0.0, 1.3).unwrap();
    let of = |transport: &Transport| slab_share(&slab(medium(), 1e-3, true), transport, 2_000).mean();
    assert_eq!(of(&DIFFUSE), of(&Transport::default()));
}
