//! Any bit patterns into every entry point: no panic, no hang, an error or finite numbers out.
//!
//! Bounded by count and by time: `MIEUX_FUZZ_SECONDS` (default 3) for each target.

use std::time::{Duration, Instant};

use mieux_optics::Complex64;
use mieux_optics::mie::{
    Directions, Layer, LayeredSphere, PlaneWave, Population, ScatteringDefinition, Sphere, SphereScattering,
    scatter_layered_spheres, scatter_spheres,
};

/// Size parameter up to which the series of one case is short enough to run many.
const SHORT: f64 = 2e4;

/// A small counter-based generator (`steele2014`).
struct Bits(u64);

impl Bits {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / 2f64.powi(53)
    }

    /// Any double there is, often one of the odd ones, and as often one that means something.
    fn double(&mut self, least: f64, most: f64) -> f64 {
        const ODD: [f64; 10] =
            [0.0, -0.0, f64::NAN, f64::INFINITY, -1.0, f64::MIN_POSITIVE, 5e-324, f64::MAX, 1.0, f64::EPSILON];
        match self.next() % 16 {
            0 => f64::from_bits(self.next()),
            1 => ODD[(self.next() % ODD.len() as u64) as usize],
            _ => (least.ln() + self.unit() * (most / least).ln()).exp(),
        }
    }

    fn index(&mut self) -> Complex64 {
        let im = if self.next().is_multiple_of(4) { 0.0 } else { self.double(1e-14, 20.0) };
        Complex64::new(self.double(1e-3, 20.0), im)
    }

    fn wave(&mut self) -> Option<PlaneWave> {
        let definition = [ScatteringDefinition::Frisvad2007, ScatteringDefinition::MishchenkoYang2018];
        let wave = PlaneWave::new(self.double(1e-7, 1e-5), self.index()).ok()?;
        Some(wave.with_definition(definition[(self.next() % 2) as usize]))
    }

    /// Often small enough to be computed at once; what is larger is left to [`Sphere::new`] alone.
    fn sphere(&mut self) -> Option<Sphere> {
        let (wave, radius, index) = (self.wave()?, self.double(1e-14, 1e-2), self.index());
        let sphere = Sphere::new(wave, radius, index).ok()?;
        let k0r = wave.wave_number().norm() / wave.host().norm() * radius;
        (k0r * index.norm().max(wave.host().norm()) < SHORT).then_some(sphere)
    }

    fn layered(&mut self) -> Option<LayeredSphere> {
        let wave = self.wave()?;
        let mut radius = self.double(1e-10, 1e-5);
        let mut layers = Vec::new();
        let mut largest = wave.host().norm();
        for _ in 0..1 + self.next() % 5 {
            let index = self.index();
            largest = largest.max(index.norm());
            layers.push(Layer { radius, index });
            radius =
                if self.next().is_multiple_of(16) { self.double(1e-10, 1e-4) } else { radius * (1.0 + self.unit()) };
        }
        let sphere = LayeredSphere::new(wave, &layers).ok()?;
        let k0 = wave.wave_number().norm() / wave.host().norm();
        (k0 * layers[layers.len() - 1].radius * largest < SHORT).then_some(sphere)
    }
}

/// Runs a target many times, but not for longer than it is given.
fn fuzz(seed: u64, mut target: impl FnMut(&mut Bits) -> bool) {
    let seconds = std::env::var("MIEUX_FUZZ_SECONDS").ok().and_then(|s| s.parse().ok()).unwrap_or(3.0);
    let end = Instant::now() + Duration::from_secs_f64(seconds);
    let (mut bits, mut computed) = (Bits(seed), 0u32);
    for _ in 0..2_000_000 {
        if Instant::now() > end {
            break;
        }
        computed += u32::from(target(&mut bits));
    }
    assert!(computed > 20, "only {computed} cases got through to be computed");
}

fn assert_finite(s: &SphereScattering, what: &dyn std::fmt::Debug) {
    let numbers = [s.extinction, s.scattering, s.absorption, s.asymmetry, s.forward.re, s.forward.im];
    assert!(numbers.iter().all(|v| v.is_finite()), "{s:?} {what:?}");
    assert!(s.scattering >= 0.0 && s.asymmetry.abs() <= 1.0 + 1e-12, "{s:?} {what:?}");
}

#[test]
fn spheres() {
    fuzz(1, |bits| {
        let Some(sphere) = bits.sphere() else { return false };
        let Ok(s) = sphere.scattering() else { return false };
        assert_finite(&s, &sphere);
        true
    });
}

#[test]
fn spheres_abreast() {
    fuzz(2, |bits| {
        let spheres: Vec<Sphere> = (0..20).filter_map(|_| bits.sphere()).collect();
        let mut out = Vec::new();
        if scatter_spheres(&spheres, &mut out).is_err() {
            return false;
        }
        spheres.iter().zip(&out).for_each(|(sphere, s)| assert_finite(s, sphere));
        !spheres.is_empty()
    });
}

#[test]
fn gradients() {
    fuzz(3, |bits| {
        let Some(sphere) = bits.sphere() else { return false };
        let Ok(g) = sphere.gradient() else { return false };
        for slope in [g.radius, g.wavelength, g.host_re, g.host_im, g.particle_re, g.particle_im] {
            let numbers = [slope.extinction, slope.scattering, slope.absorption, slope.asymmetry];
            assert!(numbers.iter().all(|v| v.is_finite()), "{slope:?} {sphere:?}");
        }
        true
    });
}

#[test]
fn amplitudes_and_expansions() {
    fuzz(4, |bits| {
        let Some(sphere) = bits.sphere() else { return false };
        let coefficients = sphere.coefficients();
        let directions = Directions::new((0..9).map(|_| bits.double(1e-6, 2.0)));
        let (Ok(amplitudes), Ok(matrices)) = (coefficients.amplitudes(&directions), coefficients.mueller(&directions))
        else {
            return false;
        };
        assert!(amplitudes.iter().flatten().all(|s| s.is_finite()), "{amplitudes:?} {sphere:?}");
        assert!(matrices.iter().all(|m| m.p11.is_finite() && m.p11 >= 0.0 && m.p12.abs() <= m.p11 * (1.0 + 1e-12)));
        if coefficients.terms().len() < 100 {
            let moments = coefficients.legendre_moments().expect("as the amplitudes");
            assert!(moments.iter().all(|m| m.abs() <= 1.0 + 1e-9), "{moments:?} {sphere:?}");
        }
        assert!(coefficients.backscattering() >= 0.0);
        true
    });
}

#[test]
fn layered_spheres() {
    fuzz(5, |bits| {
        let spheres: Vec<LayeredSphere> = (0..6).filter_map(|_| bits.layered()).collect();
        let mut out = Vec::new();
        if scatter_layered_spheres(&spheres, &mut out).is_err() {
            return false;
        }
        spheres.iter().zip(&out).for_each(|(sphere, s)| assert_finite(s, sphere));
        !spheres.is_empty()
    });
}

#[test]
fn populations() {
    fuzz(6, |bits| {
        let radii: Vec<f64> = (0..bits.next() % 30).map(|_| bits.double(1e-9, 1e-6)).collect();
        let count = bits.next() % 3;
        let mut indices = || (0..count).map(|_| bits.index()).collect::<Vec<_>>();
        let (host, particle) = (indices(), indices());
        let wavelengths: Vec<f64> = (0..count).map(|_| bits.double(1e-7, 1e-5)).collect();
        let definition = ScatteringDefinition::default();
        let population =
            Population { radii: &radii, wavelengths: &wavelengths, host: &host, particle: &particle, definition };
        let Ok(all) = population.scatter() else { return false };
        assert!(all.extinction.iter().chain(&all.scattering).chain(&all.asymmetry).all(|v| v.is_finite()));
        !all.extinction.is_empty()
    });
}
