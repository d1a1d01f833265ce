//! The random walk against published and computed solutions for slabs.

#![allow(clippy::print_stdout)]

mod common;

use common::{slab, slab_share};
use mieux_render::integrator::Transport;
use mieux_render::medium::Medium;

/// Van de Hulst's slab (`vandehulst1980`): g 0.75, optical thickness 2, albedo 0.9, no change of index.
#[test]
fn van_de_hulst() {
    let medium = || Medium::grey(1800.0, 200.0, 0.75, 1.0).unwrap();
    let transport = Transport::default();
    let reflected = slab_share(&slab(medium(), 1e-3, true), &transport, 3_000_000);
    reflected.assert_near(0.09739464, 3.0, 3e-3, "reflected");
    let transmitted = slab_share(&slab(medium(), 1e-3, false), &transport, 1_000_000);
    transmitted.assert_near(0.66095770, 3.0, 3e-3, "transmitted");
}

/// Isotropic, albedo 0.9, index 1.5, practically infinitely deep: the total reflectance with the specular part, by
/// adding-doubling (PHYSICS section 7: Saunderson would say 0.299).
#[test]
fn deep_slab_with_a_surface() {
    let medium = Medium::grey(54_000.0, 6_000.0, 0.0, 1.5).unwrap();
    let reflected = slab_share(&slab(medium, 1e-3, true), &Transport::default(), 1_000_000);
    reflected.assert_near(0.25994, 3.0, 5e-3, "reflected");
}

/// A lossless slab returns everything, up or down.
#[test]
fn lossless_slab_keeps_all() {
    let medium = || Medium::grey(3000.0, 0.0, 0.6, 1.33).unwrap();
    let transport = Transport::default();
    let up = slab_share(&slab(medium(), 1e-3, true), &transport, 200_000);
    let down = slab_share(&slab(medium(), 1e-3, false), &transport, 200_000);
    let sum = up.mean() + down.mean();
    assert!((sum - 1.0).abs() < 3.0 * up.error().hypot(down.error()), "{sum}");
}

/// What similarity gets wrong: reflectance of a slab of whole milk, 2 mm thick, with and without a surface.
///
/// Measured with 1.5 million exact and 3 million switched paths: +0.27 % +- 0.06 % without a surface, -0.57 % +- 0.07 % with
/// one of index 1.347.
#[test]
fn similarity_is_nearly_right() {
    for (n, bound) in [(1.0, 0.01), (1.347, 0.01)] {
        let milk = || Medium::grey(57_837.0, 6.08, 0.954, n).unwrap();
        let similar = Transport { similarity: true, ..Transport::default() };
        let exact = slab_share(&slab(milk(), 2e-3, true), &Transport::default(), 60_000);
        let switched = slab_share(&slab(milk(), 2e-3, true), &similar, 200_000);
        let bias = switched.mean() / exact.mean() - 1.0;
        let error = (switched.error() / switched.mean()).hypot(exact.error() / exact.mean());
        println!("index {n}: {:.5} against {:.5}: bias {bias:+.5} +- {error:.5}", switched.mean(), exact.mean());
        assert!(bias.abs() < bound + 3.0 * error, "index {n}: {bias} +- {error}");
    }
}
