//! The discrete-ordinate solver against published and independently computed slabs (`reference_cases.csv`, which names the
//! source of each row).

#![allow(clippy::print_stdout)]

mod shared;

use std::f64::consts::PI;

use mieux_optics::transfer::fresnel::DiffuseReflectance;
use mieux_optics::transfer::{
    DiscreteOrdinates, Fluxes, Incidence, Layer, Light, Moments, Place, Shares, Stack, Views,
};

fn isotropic(tau: f64, albedo: f64) -> Layer {
    Layer::new(tau, albedo, Moments::isotropic())
}

fn rayleigh(tau: f64, albedo: f64) -> Layer {
    Layer::new(tau, albedo, Moments::new(vec![1.0, 0.0, 0.1]).unwrap())
}

fn hg(tau: f64, albedo: f64, g: f64) -> Layer {
    Layer::new(tau, albedo, Moments::henyey_greenstein(g).unwrap())
}

fn shares(stack: &Stack, incidence: Incidence) -> Shares {
    DiscreteOrdinates::with_streams(64).unwrap().shares(stack, incidence).unwrap()
}

/// Through the top and the bottom, with the 16 streams of DISORT's tests: the first of them is 0.0799451 with these and
/// 0.0798719 with 128.
fn fluxes(layer: Layer, light: Light) -> [Fluxes; 2] {
    let bottom = layer.optical_thickness;
    let solver = DiscreteOrdinates::with_streams(16).unwrap();
    let found = solver.fluxes(&Stack::slab(layer), &light, &[0.0, bottom]).unwrap();
    [found[0], found[1]]
}

/// A beam of flux `pi` across itself, or (the first cases of DISORT's tests) onto the horizontal.
fn beam(cosine: f64, horizontal: bool) -> Light {
    Light { beam: Some((cosine, if horizontal { PI } else { PI * cosine })), ..Light::default() }
}

/// Radiance upward just above the top, in the plane of the beam.
fn rising(layer: Layer, light: Light, streams: usize, cosine: f64) -> f64 {
    let views = Views { places: &[Place::Above], cosines: &[-cosine], azimuths: &[0.0] };
    let solver = DiscreteOrdinates::with_streams(streams).unwrap();
    solver.radiance(&Stack::slab(layer), &light, &views).unwrap().get(0, 0, 0).unwrap()
}

/// Chandrasekhar's `H(1)` from the radiance that a half-space sends back along the beam, `a H(1)^2 / (8 pi)`.
fn h_function(albedo: f64) -> f64 {
    let light = Light { beam: Some((1.0, 1.0)), ..Light::default() };
    (rising(isotropic(1e6, albedo), light, 64, 1.0) * 8.0 * PI / albedo).sqrt()
}

/// What the solver says of a row; `None` for what it is not asked.
fn answer(id: &str) -> Option<f64> {
    let slab = |layer: Layer| Stack::slab(layer);
    let thick = |albedo: f64, n: f64| slab(isotropic(1e6, albedo).with_index(n));
    let three = || {
        let layer =
            |mu_a: f64, mu_s: f64, g: f64, d: f64| hg((mu_a + mu_s) * d, mu_s / (mu_a + mu_s), g).with_index(1.37);
        let layers = vec![layer(1.0, 100.0, 0.9, 0.1), layer(1.0, 10.0, 0.0, 0.1), layer(2.0, 10.0, 0.7, 0.2)];
        Stack { layers, ..slab(isotropic(1.0, 0.5)) }
    };
    let normal = Incidence::NORMAL;
    let tilted = Incidence::Beam(0.6);
    let skin = || shares(&three(), normal);
    Some(match id {
        "C001" => fluxes(isotropic(0.03125, 0.2), beam(0.1, true))[0].up,
        "C004" => fluxes(isotropic(0.03125, 0.99), Light { above: 1.0, ..Light::default() })[0].up,
        "C005" => fluxes(isotropic(32.0, 0.2), beam(0.1, true))[0].up,
        "C006" => fluxes(isotropic(32.0, 1.0), beam(0.1, true))[0].up,
        "C008" => rising(isotropic(0.03125, 1.0), beam(0.1, true), 16, 0.5),
        "C032" | "C033" => {
            let light = Light { beam: Some((0.6, 1.0)), ..Light::default() };
            rising(hg(1.0, 0.9, 0.75), light, 64, if id == "C032" { 0.325 } else { 0.55 })
        }
        "C054" => h_function(0.2),
        "C063" => h_function(0.9),
        "C066" => h_function(0.95),
        "C072" => h_function(0.999),
        "C010" => fluxes(rayleigh(0.2, 0.5), beam(0.080442, false))[1].down_diffuse,
        "C012" => fluxes(rayleigh(0.2, 1.0), beam(0.080442, false))[1].down_diffuse,
        "C014" => fluxes(rayleigh(5.0, 0.5), beam(0.080442, false))[1].down_diffuse,
        "C015" => fluxes(rayleigh(5.0, 1.0), beam(0.080442, false))[0].up,
        "C018" => fluxes(hg(1.0, 1.0, 0.75), beam(1.0, false))[1].down_diffuse,
        "C020" => fluxes(hg(8.0, 1.0, 0.75), beam(1.0, false))[1].down_diffuse,
        "C023" => shares(&slab(hg(2.0, 0.9, 0.75)), normal).reflectance,
        "C025" | "C026" => shares(&slab(hg(2.0, 0.9, 0.75)), normal).reflectance,
        "C028" => {
            let s = shares(&slab(hg(1.0, 0.9, 0.75)), normal);
            s.transmittance - s.transmittance_unscattered
        }
        "C029" => shares(&slab(hg(1.0, 0.9, 0.75)), tilted).reflectance,
        "C037" => shares(&slab(isotropic(1.0, 0.99)), Incidence::Beam(0.5)).transmittance,
        "C038" => shares(&slab(hg(4.0, 0.99, 0.5)), Incidence::Beam(0.5)).reflectance,
        "C050" => shares(&slab(hg(1.0, 0.9, 0.8)), normal).reflectance,
        "C052" => shares(&slab(hg(1.0, 0.9, 0.8)), Incidence::Diffuse).reflectance,
        "C053" => shares(&slab(hg(1.0, 0.9, 0.8)), Incidence::Diffuse).transmittance,
        "C058" => shares(&thick(0.5, 1.0), normal).reflectance,
        "C067" => shares(&thick(0.95, 1.0), normal).reflectance,
        "C068" => shares(&thick(0.95, 1.0), Incidence::Diffuse).reflectance,
        "C070" => shares(&thick(0.99, 1.0), normal).reflectance,
        "C073" => shares(&thick(0.999, 1.0), normal).reflectance,
        "C074" => shares(&thick(0.999, 1.0), Incidence::Diffuse).reflectance,
        "C075" => shares(&thick(0.9, 1.5), normal).reflectance,
        "C077" => shares(&thick(0.99, 1.5), normal).reflectance,
        "C078" => shares(&thick(0.99, 1.5), Incidence::Diffuse).reflectance,
        "C081" => shares(&thick(0.9, 1.3), normal).reflectance,
        "C084" => shares(&thick(0.99, 1.3), Incidence::Diffuse).reflectance,
        "C085" => shares(&thick(0.999, 1.3), normal).reflectance,
        "C086" => shares(&thick(0.999, 1.3), Incidence::Diffuse).reflectance,
        "C090" => skin().reflectance - skin().reflectance_specular,
        "C091" => skin().absorptance,
        _ => return None,
    })
}

/// The tolerance of a row as an absolute number; four standard errors of a Monte Carlo figure.
fn tolerance(text: &str, value: f64) -> f64 {
    let number = text.split_whitespace().find_map(|word| word.parse::<f64>().ok()).expect("a number");
    if text.starts_with("rtol") {
        number * value.abs()
    } else if text.starts_with("sd") {
        4.0 * number
    } else {
        number
    }
}

#[test]
fn every_slab_of_the_shared_table_is_met() {
    let Some(text) = shared::text("transfer/reference_cases.csv") else { return };
    let mut met = 0;
    for fields in csv::Reader::from_reader(text.as_bytes()).records() {
        let fields = fields.expect("a row");
        let Some(ours) = answer(&fields[0]) else { continue };
        let value: f64 = fields[4].parse().expect("a number");
        let allowed = tolerance(&fields[5], value);
        println!("{}: {ours:.9} for {value} (off by {:.1e}, allowed {allowed:.1e})", &fields[0], (ours - value).abs());
        assert!((ours - value).abs() <= allowed, "{fields:?}: {ours}");
        met += 1;
    }
    assert!(met >= 40, "only {met} rows were found");
}

/// Moments of Fresnel's reflectance, from the index and the name that the table gives.
#[test]
fn every_fresnel_moment_of_the_shared_table_is_met() {
    let Some(text) = shared::text("transfer/reference_cases.csv") else { return };
    let mut met = 0;
    for fields in csv::Reader::from_reader(text.as_bytes()).records() {
        let fields = fields.expect("a row");
        if &fields[1] != "fresnel" {
            continue;
        }
        let index: f64 = fields[2].trim_start_matches("n=").parse().expect("an index");
        let of = DiffuseReflectance::new(index).expect("a positive index");
        let ours = match &fields[3] {
            name if name.starts_with("r_ext") => of.external,
            name if name.starts_with("r_int") => of.internal(),
            name if name.starts_with("3C2") => 3.0 * of.c2,
            name if name.starts_with("A=") => of.extrapolation(),
            name if name.starts_with("A_Groenhuis") => of.extrapolation_groenhuis(),
            other => panic!("unknown quantity {other}"),
        };
        let value: f64 = fields[4].parse().expect("a number");
        assert!((ours - value).abs() <= tolerance(&fields[5], value), "{fields:?}: {ours}");
        met += 1;
    }
    assert!(met >= 14, "only {met} rows were found");
}
