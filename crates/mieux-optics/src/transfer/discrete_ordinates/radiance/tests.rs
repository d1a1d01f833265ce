use std::f64::consts::PI;

use super::super::beam::{BeamLine, Thickness};
use super::super::plan::Plan;
use crate::integrate::gauss_legendre;
use crate::transfer::{DiscreteOrdinates, Ground, Layer, Light, Moments, Place, Stack, Views};

fn hg(tau: f64, albedo: f64, g: f64) -> Layer {
    Layer::new(tau, albedo, Moments::henyey_greenstein(g).unwrap())
}

fn solver(streams: usize) -> DiscreteOrdinates {
    DiscreteOrdinates::with_streams(streams).unwrap()
}

/// Refraction both ways, a pane, a layer of no thickness.
fn mixed(ground: Ground) -> Stack {
    let layers = vec![
        Layer::pane(1.5, 0.1),
        hg(1.0, 0.9, 0.6).with_index(1.33),
        hg(0.0, 0.9, 0.3).with_index(1.1),
        hg(2.0, 0.8, -0.3).with_index(1.45),
        hg(0.7, 0.99, 0.5),
    ];
    Stack { above: 1.0, layers, below: 1.2, ground }
}

fn at(solver: &DiscreteOrdinates, stack: &Stack, light: &Light, place: Place, cosine: f64, azimuth: f64) -> f64 {
    let views = Views { places: &[place], cosines: &[cosine], azimuths: &[azimuth] };
    solver.radiance(stack, light, &views).unwrap().get(0, 0, 0).unwrap()
}

fn beam(cosine: f64, flux: f64) -> Light {
    Light { beam: Some((cosine, flux)), ..Light::default() }
}

/// `I = w F H(mu) H(mu_0) / (4 pi (mu + mu_0))` for a flux `F` onto the horizontal, with `H` from its integral equation
/// (`chandrasekhar1960`), solved here by iteration.
#[test]
fn a_half_space_follows_the_h_function() {
    let rule: Vec<(f64, f64)> = gauss_legendre(64).into_iter().map(|(x, w)| (0.5 * (1.0 + x), 0.5 * w)).collect();
    for albedo in [0.3, 0.9, 0.999] {
        let mut h = vec![1.0; rule.len()];
        let next = |mu: f64, h: &[f64]| {
            let sum: f64 = rule.iter().zip(h).map(|((x, w), h)| w * x * h / (mu + x)).sum();
            1.0 / ((1.0f64 - albedo).sqrt() + 0.5 * albedo * sum)
        };
        for _ in 0..300 {
            h = rule.iter().zip(&h).map(|((mu, _), before)| 0.5 * (next(*mu, &h) + before)).collect();
        }
        for (mu, mu0) in [(1.0, 1.0), (0.3, 0.7), (0.05, 0.2)] {
            let exact = albedo / (4.0 * PI) * next(mu, &h) * next(mu0, &h) / (mu + mu0);
            let half_space = Stack::slab(hg(1e5, albedo, 0.0));
            let ours = at(&solver(64), &half_space, &beam(mu0, 1.0), Place::Above, -mu, 0.4);
            assert!((ours / exact - 1.0).abs() < 1e-7, "{albedo} {mu} {mu0}: {ours} for {exact}");
        }
    }
}

/// Cosines with weights that sum over a hemisphere, in a medium of this index: directions of total reflection are apart
/// from those that leave, and nodes are dense on both sides of where they meet.
fn hemisphere(index: f64) -> Vec<(f64, f64)> {
    let critical = [1.0f64, 1.1, 1.2, 1.33, 1.45].into_iter().filter(|other| *other < index);
    let mut knots: Vec<f64> = critical.map(|other| (1.0 - (other / index).powi(2)).sqrt()).chain([0.0, 1.0]).collect();
    knots.sort_by(f64::total_cmp);
    let mut nodes = Vec::new();
    for pair in knots.windows(2) {
        let width = pair[1] - pair[0];
        nodes.extend(gauss_legendre(24).iter().map(|(x, w)| {
            let u = 0.5 * (1.0 + x);
            (pair[0] + width * u * u * (3.0 - 2.0 * u), 0.5 * w * width * 6.0 * u * (1.0 - u))
        }));
    }
    nodes
}

/// Radiance summed over directions is the flux, everywhere and with every source; and its mean is the mean intensity.
#[test]
fn sums_to_fluxes() {
    let mut emitting = mixed(Ground::Lambertian(0.4));
    emitting.layers[1].emission = [1.0, 3.0];
    emitting.layers[3].emission = [0.2, 0.1];
    let cases = [
        (mixed(Ground::Black), Light { beam: Some((0.6, 1.0)), above: 0.3, below: 0.2 }),
        (mixed(Ground::Mirror(0.5)), beam(0.6, 2.0)),
        (emitting, beam(0.95, 1.0)),
    ];
    let azimuths: Vec<f64> = (0..16).map(|i| 2.0 * PI * f64::from(i) / 16.0).collect();
    let solver = DiscreteOrdinates { correct_radiance: false, ..solver(64) };
    for (stack, light) in cases {
        let plan = Plan::new(&stack, solver.streams, true);
        let line = light.beam.map(|(cosine, flux)| BeamLine::new(&plan, cosine, flux, &Thickness::Scaled)).unwrap();
        for (depth, layer, within) in [(0.1, 1, 0.0), (0.6, 1, 0.5), (2.1, 3, 1.0), (3.5, 4, 0.4)] {
            let nodes = hemisphere(stack.layers[layer].refractive_index);
            let cosines: Vec<f64> = nodes.iter().map(|n| n.0).chain(nodes.iter().map(|n| -n.0)).collect();
            let views = Views { places: &[Place::Depth(depth)], cosines: &cosines, azimuths: &azimuths };
            let found = solver.radiance(&stack, &light, &views).unwrap();
            let flux = solver.fluxes(&stack, &light, &[depth]).unwrap()[0];
            // What the beam itself carries.
            let scaled = &plan.layers[layer];
            let direct = line.layers[layer].at(within * scaled.stretch, scaled.thickness);
            let (mut sums, mut mean) = (direct, (direct[0] + direct[1]) / line.layers[layer].cosine);
            for (i, cosine) in cosines.iter().enumerate() {
                let weight = nodes[i % nodes.len()].1 * 2.0 * PI / 16.0;
                let all: f64 = (0..16).map(|k| found.get(0, i, k).unwrap()).sum();
                sums[usize::from(*cosine < 0.0)] += weight * cosine.abs() * all;
                mean += weight * all;
            }
            let expected = [flux.down_direct + flux.down_diffuse, flux.up, flux.mean_intensity];
            for (ours, theirs) in [sums[0], sums[1], mean / (4.0 * PI)].into_iter().zip(expected) {
                assert!((ours / theirs - 1.0).abs() < 1e-4, "{depth}: {ours} for {theirs} in {flux:?}");
            }
        }
    }
}

/// What goes from one direction into another goes back alike, as basic radiance per flux.
#[test]
fn is_reciprocal() {
    let stack = mixed(Ground::Lambertian(0.3));
    for (here, there, azimuth) in [(0.9, 0.3, 0.7), (0.15, 0.55, 2.5)] {
        let one = at(&solver(32), &stack, &beam(here, 1.0), Place::Above, -there, azimuth);
        let other = at(&solver(32), &stack, &beam(there, 1.0), Place::Above, -here, azimuth);
        assert!((one / other - 1.0).abs() < 1e-9, "{one} {other}");
    }
}

/// Sixteen streams see the light around the beam behind a cloud as many do, where first scattering alone, with all its
/// moments, would be up to 3.5 times too bright.
#[test]
fn the_forward_peak_is_put_back() {
    let (few, many) = (solver(16), solver(96));
    for tau in [0.5, 6.0] {
        let stack = Stack::slab(hg(tau, 0.99, 0.95));
        let views = Views { places: &[Place::Below], cosines: &[0.8, 0.79, 0.77], azimuths: &[0.0, 0.02, 0.15] };
        let radiance = |solver: &DiscreteOrdinates| solver.radiance(&stack, &beam(0.8, 1.0), &views).unwrap();
        let (ours, reference) = (radiance(&few), radiance(&many));
        for (ours, reference) in ours.as_slice().iter().zip(reference.as_slice()) {
            assert!((ours / reference - 1.0).abs() < 6e-3, "{tau}: {ours} for {reference}");
        }
    }
}

/// Layers of one matter are the layer that they make, peak and all.
#[test]
fn a_cut_layer_is_the_layer() {
    let whole = Stack::slab(hg(3.0, 0.95, 0.9).with_index(1.3));
    let cut = Stack { layers: [0.5, 0.0, 2.5].map(|tau| hg(tau, 0.95, 0.9).with_index(1.3)).to_vec(), ..whole.clone() };
    for (place, cosine) in
        [(Place::Below, 0.58), (Place::Depth(3.0), 0.8), (Place::Above, -0.4), (Place::Depth(0.5), -0.1)]
    {
        let [one, other] = [&whole, &cut].map(|stack| at(&solver(16), stack, &beam(0.6, 1.0), place, cosine, 0.05));
        assert!((one / other - 1.0).abs() < 1e-10, "{place:?}: {one} {other}");
    }
}

#[test]
fn refuses_directions_that_are_none() {
    let stack = Stack::slab(hg(1.0, 0.9, 0.5));
    let ask = |place, cosine, azimuth| {
        let views = Views { places: &[place], cosines: &[cosine], azimuths: &[azimuth] };
        solver(8).radiance(&stack, &beam(0.5, 1.0), &views)
    };
    for cosine in [0.0, 1.1, -1.1, f64::NAN] {
        assert!(ask(Place::Above, cosine, 0.0).is_err());
    }
    assert!(ask(Place::Above, 0.5, f64::INFINITY).is_err());
    assert!(ask(Place::Depth(1.5), 0.5, 0.0).is_err());
    assert_eq!(ask(Place::Above, 0.5, 0.0).unwrap().get(0, 0, 1), None);
    // Nothing comes down from a dark sky; the beam is left out.
    assert_eq!(ask(Place::Above, 0.5, 0.0).unwrap().get(0, 0, 0), Some(0.0));
}
