use std::f64::consts::PI;

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

fn at(stack: &Stack, light: &Light, streams: usize, place: Place, cosine: f64, azimuth: f64) -> f64 {
    let views = Views { places: &[place], cosines: &[cosine], azimuths: &[azimuth] };
    solver(streams).radiance(stack, light, &views).unwrap().get(0, 0, 0).unwrap()
}

fn beam(cosine: f64, flux: f64) -> Light {
    Light { beam: Some((cosine, flux)), ..Light::default() }
}

/// `I = w F / (4 pi) H(mu) H(mu_0) / (mu + mu_0)` per flux along the beam, with `H` from its integral equation
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
        for _ in 0..400 {
            h = rule.iter().map(|(mu, _)| 0.5 * (next(*mu, &h) + h[rule.iter().position(|r| r.0 == *mu).unwrap()])).collect();
        }
        for (mu, mu0) in [(1.0, 1.0), (0.3, 0.7), (0.05, 0.2)] {
            let exact = albedo / (4.0 * PI) * next(mu, &h) * next(mu0, &h) / (mu + mu0);
            let ours = at(&Stack::slab(hg(1e5, albedo, 0.0)), &beam(mu0, mu0), 64, Place::Above, -mu, 0.4) * mu0 / mu0;
            assert!((ours / exact - 1.0).abs() < 1e-8, "{albedo} {mu} {mu0}: {ours} for {exact}");
        }
    }
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
        (emitting, Light { beam: Some((0.95, 1.0)), above: 0.0, below: 0.0 }),
    ];
    for (stack, light) in cases {
        for depth in [0.1, 0.6, 2.1, 3.5] {
            // Directions of total reflection are apart from those that leave.
            let index: f64 = if depth < 1.1 { 1.33 } else if depth < 3.1 { 1.45 } else { 1.0 };
            let mut knots = vec![0.0, 1.0];
            for other in [1.0f64, 1.1, 1.2, 1.33, 1.45] {
                if other < index {
                    knots.push((1.0 - (other / index).powi(2)).sqrt());
                }
            }
            knots.sort_by(f64::total_cmp);
            let mut nodes = Vec::new();
            for pair in knots.windows(2) {
                let [low, high] = [pair[0], pair[1]];
                // Close to a knot radiance has a root's slope.
                nodes.extend(gauss_legendre(24).iter().map(|(x, w)| {
                    let u = 0.5 * (1.0 + x);
                    (low + (high - low) * u * u * (3.0 - 2.0 * u), 0.5 * w * (high - low) * 6.0 * u * (1.0 - u))
                }));
            }
            let cosines: Vec<f64> = nodes.iter().map(|n| n.0).chain(nodes.iter().map(|n| -n.0)).collect();
            let azimuths: Vec<f64> = (0..16).map(|i| 2.0 * PI * f64::from(i) / 16.0).collect();
            let solver = DiscreteOrdinates { correct_radiance: false, ..solver(64) };
            let views = Views { places: &[Place::Depth(depth)], cosines: &cosines, azimuths: &azimuths };
            let found = solver.radiance(&stack, &light, &views).unwrap();
            let flux = solver.fluxes(&stack, &light, &[depth]).unwrap()[0];
            let (mut sums, mut mean) = ([0.0; 2], 0.0);
            for (i, cosine) in cosines.iter().enumerate() {
                let weight = nodes[i % nodes.len()].1 * 2.0 * PI / 16.0;
                let all: f64 = (0..16).map(|k| found.get(0, i, k).unwrap()).sum();
                sums[usize::from(*cosine < 0.0)] += weight * cosine.abs() * all;
                mean += weight * all;
            }
            // What the beam itself carries.
            let line = super::super::beam::BeamLine::new(
                &super::super::plan::Plan::new(&stack, 64, true),
                light.beam.unwrap().0,
                light.beam.unwrap().1,
                &super::super::beam::Thickness::Scaled,
            );
            let _ = line;
            println!("{depth}: {sums:?} {flux:?} {}", mean / (4.0 * PI));
        }
    }
}
