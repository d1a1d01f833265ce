//! Several wavelengths per path tell the same as one; refraction scales radiance by the square of the index.

#![allow(clippy::print_stdout)]

mod common;

use common::{body, by_wavelength, paths, scene, slab, spectrum};
use mieux_render::DVec3;
use mieux_render::geometry::{Ray, sphere};
use mieux_render::integrator::Transport;
use mieux_render::light::constant;
use mieux_render::medium::Medium;
use mieux_render::scene::Prepared;

/// The reflectance of a slab whose every property changes with wavelength, bin by bin.
#[test]
fn companions_change_nothing_but_the_noise() {
    let medium = Medium::new(
        spectrum([6_000.0, 3_000.0, 2_000.0]),
        spectrum([500.0, 60.0, 10.0]),
        spectrum([0.3, 0.6, 0.7]),
        spectrum([1.36, 1.34, 1.33]),
    );
    let slab = slab(medium, 1e-3, true);
    let down = Ray { origin: slab.camera().position(), direction: -DVec3::Z };
    let run = |companions, dispersion| {
        let transport = Transport { companions, dispersion, ..Transport::default() };
        by_wavelength(&paths(&slab, &transport, 400_000, |_| down).0, 8)
    };
    let single = run(false, false);
    let (many, dispersive) = (run(true, false), run(true, true));
    for (bin, one) in single.iter().enumerate() {
        for (what, other) in [("companions", &many), ("dispersion", &dispersive)] {
            let off = one.mean() - other[bin].mean();
            let error = one.error().hypot(other[bin].error());
            println!("{what} bin {bin}: {:.5} {:.5} ({:+.2})", one.mean(), other[bin].mean(), off / error);
            assert!(off.abs() < 3.5 * error, "{what} bin {bin}");
        }
        // Whoever shares his path has less noise.
        assert!(many[bin].error() < one.error());
    }
}

/// A camera in water under a white sky sees n^2, in clear and in turbid water, whatever the direction.
#[test]
fn a_camera_in_water_sees_the_square_of_the_index() {
    let n = spectrum([1.36, 1.33, 1.32]);
    let clear = Medium::clear(constant(0.0).unwrap(), n.clone()).unwrap();
    let of = |value| constant(value).unwrap();
    let turbid = Medium::new(of(50.0), of(0.0), of(0.5), clear.n.clone());
    for medium in [clear, turbid] {
        let ball = body("ball", sphere([0.0; 3], 0.1, 48).unwrap(), medium, 0);
        let inside = Prepared::new(&scene(vec![ball], vec![], [0.03, 0.02, 0.01], [0.0; 3])).unwrap();
        for dispersion in [false, true] {
            let transport = Transport { dispersion, ..Transport::default() };
            let (estimates, statistics) = paths(&inside, &transport, 20_000, |sampler| {
                let [x, y] = sampler.pair();
                inside.camera().ray(64.0 * x, 64.0 * y)
            });
            assert_eq!(statistics.lost, 0);
            for (bin, tally) in by_wavelength(&estimates, 4).iter().enumerate() {
                let quantile = inside.observer().wavelengths((bin as f64 + 0.5) / 4.0)[0];
                let index = n.at(if dispersion { quantile } else { 587.56e-9 }).unwrap();
                // The index varies over a bin; 1 % covers that, and n^2 differs from 1 and n by much more.
                let expected = index * index;
                let off = (tally.mean() - expected).abs();
                assert!(off < 3.5 * tally.error() + 1e-2 * expected, "bin {bin}: {} {expected}", tally.mean());
            }
        }
    }
}
