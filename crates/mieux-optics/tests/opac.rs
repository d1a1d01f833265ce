//! Aerosol components of OPAC (`hess1998`), read in place from the shared tables: populations of spheres in air.

#![allow(clippy::print_stdout)] // figures for whoever runs it with --nocapture

mod shared;

use std::f64::consts::PI;

use mieux_optics::Complex64;
use mieux_optics::medium::{DEFAULT_TOLERANCE, Inclusion, Medium};
use mieux_optics::mie::scatter_sphere;
use mieux_optics::particle::{LogNormal, ModifiedGamma, SizeDistribution, Weighting};
use mieux_optics::substance::Substance;

const UM: f64 = 1e-6;

/// The number behind a word of the header.
fn header(text: &str, word: &str) -> Option<f64> {
    let line = text.lines().find(|line| line.starts_with('#') && line.contains(word))?;
    line.rsplit(':').next()?.trim().parse().ok()
}

/// Wavelength (m), extinction, scattering, absorption (1/m), albedo, asymmetry and index, row by row.
fn rows(text: &str) -> Vec<[f64; 8]> {
    let table = text.lines().filter_map(|line| {
        let line = line.strip_prefix('#')?;
        let cells: Vec<f64> = line.split_whitespace().map(|cell| cell.parse()).collect::<Result<_, _>>().ok()?;
        let [wavelength, extinction, scattering, absorption, albedo, asymmetry, _, re, im] = cells[..] else {
            return None;
        };
        Some([wavelength * UM, extinction * 1e-3, scattering * 1e-3, absorption * 1e-3, albedo, asymmetry, re, -im])
    });
    table.collect()
}

/// A component, and how many of its particles per m^3 lie between the limits: the tables count one per cm^3 before the
/// distribution is cut off.
struct Component {
    name: &'static str,
    sizes: SizeDistribution,
    number: f64,
}

/// Simpson's rule over the logarithm of the radius (um), for a number density in 1/um.
fn number(from: f64, to: f64, density: impl Fn(f64) -> f64) -> f64 {
    let steps = 4000;
    let h = (to / from).ln() / f64::from(steps);
    let weight = |i: i32| if i == 0 || i == steps { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
    let value = |i: i32| {
        let r = from * (h * f64::from(i)).exp();
        weight(i) * density(r) * r
    };
    h / 3.0 * (0..=steps).map(value).sum::<f64>()
}

fn log_normal(name: &'static str) -> Option<Component> {
    let text = shared::text(&format!("optics/opac_{name}00.txt"))?;
    let [minimum, maximum, deviation, median] =
        ["minimum radius", "maximum radius", "sigma", "Rmod (wet)"].map(|word| header(&text, word).expect(word));
    let sizes = LogNormal::from_median(Weighting::Number, median * UM, deviation).unwrap();
    let s = deviation.ln();
    let density = |r: f64| (-0.5 * ((r / median).ln() / s).powi(2)).exp() / ((2.0 * PI).sqrt() * s * r);
    Some(Component {
        name,
        sizes: SizeDistribution::LogNormal(sizes.truncated(minimum * UM, maximum * UM).unwrap()),
        number: 1e6 * number(minimum, maximum, density),
    })
}

fn fog() -> Option<Component> {
    let text = shared::text("optics/opac_fogr00.txt")?;
    let [minimum, maximum, a, alpha, b, gamma] = ["minimum radius", "maximum radius", "  A:", "ALPHA", "  B:", "Gamma"]
        .map(|word| header(&text, word).expect(word));
    let mode = (alpha / (gamma * b)).powf(1.0 / gamma);
    let sizes = ModifiedGamma::new(mode * UM, alpha, gamma).unwrap();
    Some(Component {
        name: "fogr",
        sizes: SizeDistribution::ModifiedGamma(sizes.truncated(minimum * UM, maximum * UM).unwrap()),
        number: 1e6 * number(minimum, maximum, |r| a * r.powf(alpha) * (-b * r.powf(gamma)).exp()),
    })
}

/// Asymmetry of the fog at 0.8, 0.9 and 1 um, where the table bulges to 0.011 above what Lorenz-Mie theory gives for its own
/// inputs: by an independent program (miepython 3.3, 40 000 radii).
const FOG: [(f64, f64); 3] = [(0.8, 0.859995), (0.9, 0.857795), (1.0, 0.855780)];

/// Largest relative difference from the tables.
const BOUND: f64 = 0.005;

/// Share of extinction below which the tables' absorption, a difference of two numbers of four digits, says nothing.
const UNSAID: f64 = 1e-3;

/// Scattering and absorption (1/m) by summing 60 000 spheres one by one: where the tables' own sizes are too coarse.
fn fine(component: &Component, wavelength: f64, index: Complex64) -> [f64; 2] {
    let Component { sizes, number, .. } = component;
    let (from, to) = (-8.5f64, -4.2f64);
    let steps = 60_000;
    let (mut sums, mut count) = ([0.0; 2], 0.0);
    for i in 0..steps {
        let r = 10f64.powf(from + (to - from) * (f64::from(i) + 0.5) / f64::from(steps));
        let weight = sizes.density(Weighting::Number, r).unwrap() * r;
        if weight > 0.0 {
            let s = scatter_sphere(r, wavelength, 1.0.into(), index).unwrap();
            sums[0] += weight * s.scattering;
            sums[1] += weight * s.absorption;
            count += weight;
        }
    }
    sums.map(|sum| number * sum / count)
}

/// The worst relative differences in extinction, scattering, absorption and albedo, and the worst in asymmetry.
fn worst(component: &Component) -> Option<[f64; 5]> {
    let Component { name, sizes, number } = component;
    let rows = rows(&shared::text(&format!("optics/opac_{name}00.txt"))?);
    assert!(rows.len() >= 50, "{name}: {} rows", rows.len());
    let volume_fraction = number * sizes.mean_volume().unwrap();
    let mut worst = [0.0f64; 5];
    for [wavelength, extinction, scattering, absorption, albedo, asymmetry, re, im] in rows {
        let index = Complex64::new(re, im);
        let inclusion = Inclusion::new(*name, Substance::Constant(index), sizes.clone(), volume_fraction);
        let air = Substance::Constant(Complex64::new(1.0, 0.0));
        let bulk = Medium::new(air, vec![inclusion]).unwrap().optics_at(wavelength, DEFAULT_TOLERANCE).unwrap();
        let independent = FOG.iter().find(|(um, _)| *name == "fogr" && (um * UM / wavelength - 1.0).abs() < 1e-9);
        if let Some((_, expected)) = independent {
            assert!((bulk.asymmetry - expected).abs() < 2e-4, "{}", bulk.asymmetry);
        }
        let asymmetry = independent.map_or(asymmetry, |(_, expected)| *expected);
        let (s, a) = (bulk.sigma_s, bulk.sigma_a);
        let mut errors = [
            (s + a) / extinction - 1.0,
            s / scattering - 1.0,
            a / absorption - 1.0,
            s / (s + a) / albedo - 1.0,
            bulk.asymmetry - asymmetry,
        ];
        let [t, s, a, w] = [0, 1, 2, 3].map(|k| 100.0 * errors[k]);
        println!("{name} {:.2} um: {t:+.3} % {s:+.3} % {a:+.3} % {w:+.3} % {:+.4}", wavelength / UM, errors[4]);
        if absorption < UNSAID * extinction {
            errors[2] = 0.0;
        } else if errors[2].abs() > BOUND {
            // Extinction and scattering agree, and absorption is the small difference of the two: who is right?
            let [_, expected] = fine(component, wavelength, index);
            println!("    absorption against a fine sum: {:+.3} %", 100.0 * (bulk.sigma_a / expected - 1.0));
            assert!((extinction - scattering - absorption).abs() < 2e-4 * extinction);
            errors[2] = bulk.sigma_a / expected - 1.0;
        }
        (0..5).for_each(|k| worst[k] = worst[k].max(errors[k].abs()));
    }
    Some(worst)
}

/// Extinction, scattering, absorption and albedo within 0.5 %, asymmetry within 0.01.
///
/// What is behind it: the tables are for one particle per cm^3 *before* the limits cut the distribution. Their sizes are too
/// coarse for absorption where it is a few per cent of extinction, 0.8 % off for the mineral at 0.7 um, 3 % for the fog: there
/// the sum of many spheres decides.
#[test]
fn aerosols_extinguish_and_scatter_as_tabulated() {
    for component in [log_normal("soot"), log_normal("waso"), log_normal("miam"), fog()].into_iter().flatten() {
        if let Some(worst) = worst(&component) {
            let name = component.name;
            let [t, s, a, w] = [0, 1, 2, 3].map(|k| 100.0 * worst[k]);
            println!("{name}: worst {t:.3} % {s:.3} % {a:.3} % {w:.3} %, asymmetry {:.4}", worst[4]);
            assert!(worst[..4].iter().all(|error| *error < BOUND), "{name}: {worst:?}");
            assert!(worst[4] < 0.01, "{name}: asymmetry off by {}", worst[4]);
        }
    }
}
