//! Published and arbitrary-precision values for single spheres, read in place from the shared reference tables.

mod shared;

use std::f64::consts::PI;

use mieux_optics::Complex64;
use mieux_optics::mie::{Coefficients, Directions, Layer, LayeredSphere, PlaneWave, ScatteringDefinition, Sphere};

/// What the tables put numbers to: efficiencies, asymmetry and, at 0 and 180 degrees, amplitudes.
struct Found {
    extinction: f64,
    scattering: f64,
    asymmetry: f64,
    backscattering: f64,
    /// By the definition of Mishchenko and Yang.
    far: [f64; 2],
    s1: [Complex64; 2],
}

fn complex(text: &str) -> Option<Complex64> {
    let text = text.trim();
    let Some(text) = text.strip_suffix('i') else { return Some(Complex64::from(text.parse::<f64>().ok()?)) };
    let split = text
        .char_indices()
        .rev()
        .find(|&(i, c)| i > 0 && (c == '+' || c == '-') && !text[..i].ends_with(['e', 'E']))?;
    Some(Complex64::new(text[..split.0].parse().ok()?, text[split.0..].parse().ok()?))
}

/// From vacuum size parameters and indices, the core first, in a host.
fn found(host: Complex64, sizes: &[f64], indices: &[Complex64]) -> Found {
    let wave = PlaneWave::new(2.0 * PI, host).unwrap();
    let coefficients = |wave: PlaneWave| -> Coefficients {
        if let ([x], [m]) = (sizes, indices) {
            return Sphere::new(wave, *x, *m).unwrap().coefficients();
        }
        let layers: Vec<Layer> = sizes.iter().zip(indices).map(|(&radius, &index)| Layer { radius, index }).collect();
        LayeredSphere::new(wave, &layers).unwrap().coefficients()
    };
    let c = coefficients(wave);
    let (s, area) = (c.scattering().unwrap(), PI * sizes[sizes.len() - 1].powi(2));
    let far = coefficients(wave.with_definition(ScatteringDefinition::MishchenkoYang2018)).scattering().unwrap();
    let amplitudes = c.amplitudes(&Directions::new([1.0, -1.0])).unwrap();
    Found {
        extinction: s.extinction / area,
        scattering: s.scattering / area,
        asymmetry: s.asymmetry,
        backscattering: c.backscattering() / area,
        far: [far.extinction / area, far.scattering / area],
        s1: [amplitudes[0][0], amplitudes[1][0]],
    }
}

/// Size parameters and indices of a row; `None` for perfect conductors, which have no index.
fn inputs(kind: &str, size: &str, index: &str) -> Option<(Complex64, Vec<f64>, Vec<Complex64>)> {
    if kind == "absorbing host" {
        let x = size.trim_start_matches("x0=").split(' ').next()?.parse().ok()?;
        let mut words = index.split(' ');
        let host = words.by_ref().nth(1).and_then(complex)?;
        return Some((host, vec![x], vec![words.nth(1).and_then(complex)?]));
    }
    let sizes = size.split(' ').map(|x| x.parse().ok()).collect::<Option<_>>()?;
    let indices = index.split(' ').map(complex).collect::<Option<_>>()?;
    Some((Complex64::ONE, sizes, indices))
}

/// What a number may be off when it is printed so: a little over half a unit of its last digit.
fn printed(text: &str) -> f64 {
    let (mantissa, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
    let decimals = mantissa.split_once('.').map_or(0, |(_, decimals)| decimals.len()) as i32;
    0.6 * 10f64.powi(exponent.parse::<i32>().unwrap() - decimals)
}

#[test]
fn particles_agree_with_the_reference_table() {
    let Some(text) = shared::text("mie/reference_cases.csv") else { return };
    let mut counts = std::collections::BTreeMap::new();
    for line in text.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let (id, kind) = (cells[0], cells[1]);
        let Some((host, sizes, indices)) = inputs(kind, cells[2], cells[3]) else { continue };
        *counts.entry(kind).or_insert(0) += 1;
        let f = found(host, &sizes, &indices);
        let exact = [
            (10, f.extinction),
            (11, f.scattering),
            (12, f.asymmetry),
            (13, f.backscattering),
            (14, f.far[0]),
            (15, f.far[1]),
        ];
        for (column, value) in exact {
            if let Ok(expected) = cells[column].parse::<f64>() {
                assert!((value / expected - 1.0).abs() < 1e-9, "{id}, column {column}: {value} against {expected}");
            }
        }
        // The asymmetries published for the spheres of five layers are wrong; the exact ones above hold.
        let layered = kind == "multilayer5";
        let published = [(4, Some(f.extinction)), (5, Some(f.scattering)), (6, (!layered).then_some(f.asymmetry))];
        for (column, value) in published {
            if let (Some(value), Ok(expected)) = (value, cells[column].parse::<f64>()) {
                let off = (value - expected).abs();
                assert!(off < printed(cells[column]), "{id}, column {column}: {value} against {expected}");
            }
        }
        for (column, s1) in [(8, f.s1[0]), (9, f.s1[1])] {
            if let Some(expected) = complex(cells[column]).filter(|_| !cells[column].is_empty()) {
                let off = (s1 - expected).norm().min((s1.conj() - expected).norm());
                assert!(off < 2e-5 * expected.norm(), "{id}, column {column}: {s1} against {expected}");
            }
        }
    }
    let least = [("homogeneous", 30), ("absorbing host", 4), ("coated", 2), ("multilayer5", 4)];
    for (kind, count) in least {
        assert!(counts.get(kind).is_some_and(|found| *found >= count), "{kind}: {counts:?}");
    }
}

#[test]
fn particles_agree_with_published_efficiencies() {
    let mut count = 0;
    for line in include_str!("data/published.csv").lines().filter(|line| !line.starts_with('#')).skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let (host, sizes, indices) = inputs(cells[1], cells[2], cells[3]).unwrap();
        let f = found(host, &sizes, &indices);
        for (column, value) in [(4, f.extinction), (5, f.scattering), (6, f.backscattering)] {
            if let Ok(expected) = cells[column].parse::<f64>() {
                assert!((value - expected).abs() < printed(cells[column]), "{line}: {value}");
                count += 1;
            }
        }
    }
    assert!(count >= 30, "{count} numbers");
}
