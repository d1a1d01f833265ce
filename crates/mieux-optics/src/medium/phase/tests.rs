use std::f64::consts::PI;

use super::*;
use crate::Complex64;
use crate::material::milk::Milk;
use crate::medium::DEFAULT_TOLERANCE;
use crate::medium::Inclusion;
use crate::mie::Directions;
use crate::mie::PlaneWave;
use crate::mie::Sphere;
use crate::particle::{LogNormal, PowerLaw, SizeDistribution, Weighting};
use crate::phase::{Rayleigh, compare};
use crate::substance::{Conditions, Substance};

pub(super) const GREEN: f64 = 550e-9;
pub(super) const AIR: Substance = Substance::Constant(Complex64::new(1.0, 0.0));

pub(super) fn milk(fat: f64, protein: f64) -> Medium {
    Milk::new([fat, protein, 20.0, 0.17]).unwrap().medium().unwrap()
}

fn water() -> Substance {
    Substance::named("water", Conditions::default()).unwrap()
}

fn droplets(sizes: SizeDistribution) -> Medium {
    let droplets = Inclusion::new("droplets", water(), sizes, 1e-6);
    Medium::new(AIR, vec![droplets]).unwrap()
}

pub(super) fn droplet(diameter_m: f64) -> Medium {
    droplets(SizeDistribution::monodisperse(0.5 * diameter_m).unwrap())
}

/// Median radius and geometric deviation by number of a fog.
const FOG: (f64, f64) = (4e-6, 1.4);

fn fog() -> Medium {
    droplets(SizeDistribution::LogNormal(LogNormal::from_median(Weighting::Number, FOG.0, FOG.1).unwrap()))
}

fn table(medium: &Medium, tolerance: f64) -> Tabulated {
    match medium.phase_at(GREEN, tolerance).unwrap() {
        PhaseFunction::Tabulated(table) => table,
        other => panic!("{other}"),
    }
}

/// Against the coefficients, which know of no angle; and a sum over angle that the table has no part in.
#[test]
fn the_mean_cosine_is_that_of_the_bulk_and_the_integral_is_one() {
    let media = [
        ("fat", milk(3.5, 0.0)),
        ("casein", milk(0.0, 3.4)),
        ("both", milk(3.5, 3.4)),
        ("droplet of 50 um", droplet(50e-6)),
        ("droplet of 100 um", droplet(100e-6)),
        ("fog", fog()),
    ];
    for (name, medium) in media {
        // Droplets of many sizes resonate, and take their time.
        let tolerance = if name == "fog" { 1e-3 } else { DEFAULT_TOLERANCE };
        let exact = 1.0 - medium.optics_at(GREEN, tolerance).unwrap().asymmetry;
        let table = table(&medium, tolerance);
        let error = table.one_minus_asymmetry() / exact - 1.0;
        assert!(error.abs() < 1e-3, "{name}: {error:e}");
        let values: Vec<f64> = table.grid().as_slice().iter().map(|theta| table.value(theta.cos())).collect();
        let simpson = |i: usize| {
            let theta = &table.grid().as_slice()[i..=i + 1];
            let middle: f64 = 0.5 * (theta[0] + theta[1]);
            let f =
                [values[i] * theta[0].sin(), table.value(middle.cos()) * middle.sin(), values[i + 1] * theta[1].sin()];
            (theta[1] - theta[0]) / 6.0 * (f[0] + 4.0 * f[1] + f[2])
        };
        let integral = 2.0 * PI * (0..values.len() - 1).map(simpson).sum::<f64>();
        assert!((integral - 1.0).abs() < 1e-4, "{name}: {integral}");
    }
}

/// The size integral by brute force: the distribution by number over equal steps of the logarithm.
#[test]
fn fog_is_the_mean_over_its_droplets() {
    let index = water().index(GREEN).unwrap();
    let wave = PlaneWave::new(GREEN, Complex64::ONE).unwrap();
    let degrees = [0.0f64, 0.5, 2.0, 10.0, 40.0, 90.0, 120.0, 138.0, 150.0, 165.0, 178.0, 179.0, 180.0];
    let directions = Directions::new(degrees.map(|angle| angle.to_radians().cos()));
    let (mut mean, mut total) = ([0.0; 13], 0.0);
    let steps = 12_000;
    for i in 0..=steps {
        let z = -4.0 + 10.0 * f64::from(i) / f64::from(steps);
        let radius = FOG.0 * (FOG.1.ln() * z).exp();
        let coefficients = Sphere::new(wave, radius, index).unwrap().coefficients();
        let scattering = (-0.5 * z * z).exp() * coefficients.scattering().unwrap().scattering;
        total += scattering;
        for (mean, p) in mean.iter_mut().zip(coefficients.phase_function(&directions).unwrap()) {
            *mean += scattering * p;
        }
    }
    let table = table(&fog(), 1e-3);
    for (mean, angle) in mean.iter().zip(degrees) {
        let error = table.value(angle.to_radians().cos()) * total / mean - 1.0;
        assert!(error.abs() < 5e-3, "{angle} degrees: {error:e}");
    }
}

#[test]
fn a_tighter_tolerance_gives_the_same_function() {
    for medium in [milk(3.5, 3.4), fog()] {
        let loose = medium.phase_at(GREEN, 1e-2).unwrap();
        let tight = medium.phase_at(GREEN, 1e-3).unwrap();
        let apart = compare(&tight, &loose);
        assert!(apart.rms_log10 < 5e-3 && apart.total_variation < 2e-3, "{apart:?}");
        assert!(apart.delta_asymmetry.abs() < 1e-2 * (1.0 - tight.asymmetry()), "{apart:?}");
    }
}

#[test]
fn two_inclusions_are_weighted_by_what_they_scatter() {
    let inclusion = |radius_m, volume_fraction| {
        let sizes = SizeDistribution::monodisperse(radius_m).unwrap();
        Inclusion::new("spheres", Substance::Constant(Complex64::new(1.5, 1e-4)), sizes, volume_fraction)
    };
    let medium = |inclusions: &[Inclusion]| Medium::new(water(), inclusions.to_vec()).unwrap();
    let parts = [inclusion(50e-9, 0.2), inclusion(1e-6, 1e-3)];
    let both = medium(&parts).phase_at(GREEN, 1e-5).unwrap();
    let each = parts.map(|part| {
        let medium = medium(&[part]);
        (medium.optics_at(GREEN, 1e-5).unwrap().sigma_s, medium.phase_at(GREEN, 1e-5).unwrap())
    });
    let total = each[0].0 + each[1].0;
    assert!(each.iter().all(|(sigma_s, _)| *sigma_s > 0.1 * total));
    for mu in [-1.0, -0.7, 0.0, 0.4, 0.9, 1.0] {
        let mean = each.iter().map(|(sigma_s, phase)| sigma_s * phase.value(mu)).sum::<f64>() / total;
        assert!((both.value(mu) / mean - 1.0).abs() < 1e-3, "{mu}");
    }
}

#[test]
fn small_particles_scatter_as_rayleigh_says_and_nothing_not_at_all() {
    let small = droplet(2e-9).phase_at(GREEN, 1e-5).unwrap();
    for mu in [-1.0, -0.5, 0.0, 0.5, 1.0] {
        assert!((small.value(mu) / Rayleigh.value(mu) - 1.0).abs() < 1e-3, "{mu}");
    }
    assert_eq!(milk(0.0, 0.0).phase_at(GREEN, 1e-4).unwrap(), Isotropic.into());
}

/// Small spheres do not oscillate over angle, and need finer tables all the same.
#[test]
fn every_size_reaches_its_tolerance() {
    for radius in [2e-9, 30e-9, 0.1e-6, 0.2e-6, 0.25e-6, 0.3e-6, 0.5e-6, 0.9e-6, 2e-6] {
        for tolerance in [1e-3, 1e-4, 1e-5] {
            droplet(radius).phase_at(GREEN, tolerance).unwrap_or_else(|e| panic!("{radius} {tolerance}: {e}"));
        }
    }
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let medium = milk(1.5, 3.4);
    assert_eq!(medium.phase_at(GREEN, 1e-3).unwrap(), pool.install(|| medium.phase_at(GREEN, 1e-3)).unwrap());
}

#[test]
fn a_spectrum_has_a_function_for_every_wavelength() {
    let grid = WavelengthGrid::new(vec![450e-9, 650e-9]).unwrap();
    let medium = milk(0.0, 3.4);
    let spectral = medium.spectral_phase(&grid, 1e-4).unwrap();
    let bulk = medium.bulk_optics(&grid, 1e-4).unwrap();
    for (phase, g) in spectral.functions().iter().zip(bulk.asymmetry()) {
        assert!((phase.asymmetry() - g).abs() < 1e-3 * (1.0 - g));
    }
    assert!(spectral.asymmetry(550e-9).is_some() && spectral.asymmetry(700e-9).is_none());
}

/// Spheres of an index, of radii by a power law between size parameters, in a host of index 1.
fn powder(index: Complex64, [least, most]: [f64; 2]) -> Medium {
    let radius = |x: f64| x * GREEN / (2.0 * PI);
    let sizes = SizeDistribution::PowerLaw(PowerLaw::new(3.0, radius(least), radius(most)).unwrap());
    Medium::new(AIR, vec![Inclusion::new("powder", Substance::Constant(index), sizes, 1e-6)]).unwrap()
}

/// Shares of light between consecutive angles in degrees.
fn shares(table: &Tabulated, degrees: &[f64]) -> Vec<f64> {
    let below = |angle: &f64| table.forward_fraction(angle.to_radians().cos());
    degrees.windows(2).map(|pair| below(&pair[1]) - below(&pair[0])).collect()
}

const DEGREES: [f64; 17] =
    [0.0, 0.1, 0.3, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 45.0, 60.0, 75.0, 90.0, 110.0, 130.0, 155.0, 180.0];

/// The road by rays against exact spheres of size parameters from 1000 to 2400: bubbles in ice, brine in ice, minerals in
/// water, water in air. What is left is light at the rim (1 to 5 degrees, and all wide angles of the weakest contrast).
#[test]
fn rays_are_right_where_waves_can_tell() {
    let cases = [(0.763, 0.0), (1.023, 0.0), (1.05, 0.0), (1.12, 3e-4), (1.33, 0.0)];
    for (re, im) in cases {
        let medium = powder(Complex64::new(re, im), [1000.0, 2400.0]);
        let found = medium.integrated_at(GREEN, 1e-3).unwrap();
        let Members { mut members, road, largest } = medium.members(GREEN, 1e-3, &found.panels).unwrap();
        assert_eq!(road, Road::Broad);
        let exact = broad::table(&medium, GREEN, &members, largest, found.lack).unwrap();
        members.iter_mut().for_each(|member| member.rays = true);
        let rays = broad::table(&medium, GREEN, &members, largest, found.lack).unwrap();
        assert!((rays.one_minus_asymmetry() / found.lack - 1.0).abs() < 1e-6);
        let (exact, rays) = (shares(&exact, &DEGREES), shares(&rays, &DEGREES));
        let elsewhere = 0.5 * exact.iter().zip(&rays).map(|(e, r)| (e - r).abs()).sum::<f64>();
        assert!(elsewhere < 6e-3, "{re}: {elsewhere}");
        for ((exact, rays), angle) in exact.iter().zip(&rays).zip(&DEGREES[1..]).filter(|((e, _), _)| **e > 0.02) {
            assert!((rays / exact - 1.0).abs() < 0.06, "{re}, up to {angle} degrees: {exact} {rays}");
        }
    }
}

/// Fringes average out: other sizes, and up to twice as many, give the same function.
#[test]
fn sizes_spread_wide_are_enough() {
    let medium = powder(Complex64::new(1.12, 1e-4), [100.0, 1500.0]);
    let PhaseFunction::Tabulated(table) = medium.phase_at(GREEN, 1e-3).unwrap() else { panic!() };
    let found = medium.integrated_at(GREEN, 1e-3).unwrap();
    let thirds = |[from, to]: [f64; 2]| {
        (0..30).map(move |k| [0, 1].map(|j| from + (to - from) * f64::from(k + j) / 30.0)).collect::<Vec<_>>()
    };
    let finer = found
        .panels
        .iter()
        .map(|parts| parts.iter().map(|p| p.iter().copied().flat_map(thirds).collect()).collect())
        .collect::<Vec<_>>();
    let members = medium.members(GREEN, 1e-3, &finer).unwrap();
    let other = broad::table(&medium, GREEN, &members.members, members.largest, found.lack).unwrap();
    for ((a, b), angle) in shares(&table, &DEGREES).iter().zip(shares(&other, &DEGREES)).zip(&DEGREES[1..]) {
        assert!((a / b - 1.0).abs() < 2e-3, "up to {angle} degrees: {a} {b}");
    }
}

#[test]
fn what_cannot_be_computed_says_so() {
    for tolerance in [0.0, 1e-13, 2.0, f64::NAN] {
        assert!(matches!(droplet(1e-6).phase_at(GREEN, tolerance), Err(MediumError::Tolerance { .. })));
    }
    assert!(matches!(droplet(1e-6).phase_at(2e-6, 1e-4), Err(MediumError::Substance(_))));
    assert!(matches!(droplet(1e3).phase_at(GREEN, 1e-4), Err(MediumError::Mie { .. })));
    assert!(droplet(1e-6).phase_at(GREEN, 1.0).is_ok());
}
