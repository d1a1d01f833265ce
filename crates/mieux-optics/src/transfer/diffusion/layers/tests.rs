//! Diffusion of stacks: against discrete ordinates where it should be right, and by its own balance everywhere.

use super::*;
use crate::transfer::{DiscreteOrdinates, Layer, Moments};

fn layer(tau: f64, albedo: f64, g: f64) -> Layer {
    Layer::new(tau, albedo, Moments::henyey_greenstein(g).unwrap())
}

fn both(stack: &Stack, incidence: Incidence) -> [Shares; 2] {
    let exact = DiscreteOrdinates::with_streams(32).unwrap().shares(stack, incidence).unwrap();
    [shares(stack, incidence).unwrap(), exact]
}

fn check(stack: &Stack, incidence: Incidence, allowed: f64) {
    let [ours, exact] = both(stack, incidence);
    for (name, a, b, allowed) in [
        ("reflectance", ours.reflectance, exact.reflectance, allowed),
        ("transmittance", ours.transmittance, exact.transmittance, allowed),
        ("specular", ours.reflectance_specular, exact.reflectance_specular, 1e-6),
        ("unscattered", ours.transmittance_unscattered, exact.transmittance_unscattered, 1e-6),
    ] {
        assert!((a - b).abs() < allowed, "{name}: {a} for {b} in {stack:?} under {incidence:?}");
    }
}

#[test]
fn near_the_truth_where_light_is_scattered_often() {
    for incidence in [Incidence::NORMAL, Incidence::Beam(0.5), Incidence::Diffuse] {
        for index in [1.0, 1.33, 1.5] {
            for (g, albedo) in [(0.0, 1.0), (0.0, 0.99), (0.8, 0.999), (0.95, 1.0)] {
                let stack = Stack::slab(layer(10.0 / (1.0 - g), albedo, g).with_index(index));
                check(&stack, incidence, 0.02);
            }
        }
    }
}

/// Without absorption all light is reflected or passes, whatever the layers.
#[test]
fn nothing_is_lost_without_absorption() {
    for ground in [Ground::Black, Ground::Lambertian(0.7), Ground::Lambertian(1.0), Ground::Mirror(0.5)] {
        for thickness in [0.0, 1e-9, 0.1, 3.0, 1e4, 1e7] {
            let layers = vec![
                Layer::pane(1.5, 0.0),
                layer(thickness, 1.0, 0.9).with_index(1.3),
                layer(2.0, 1.0, -0.3).with_index(1.3),
                Layer::pane(1.1, 0.0),
                layer(0.3, 1.0, 0.0).with_index(1.7),
                Layer::pane(1.5, 0.0),
            ];
            let stack = Stack { above: 1.0, layers, below: 1.0, ground };
            for incidence in [Incidence::Beam(0.3), Incidence::NORMAL, Incidence::Diffuse] {
                let found = shares(&stack, incidence).unwrap();
                assert!(found.absorptance.abs() < 1e-9, "{ground:?} {thickness}: {found:?}");
                assert!((-1e-12..=1.0 + 1e-9).contains(&found.reflectance), "{found:?}");
            }
        }
    }
}

/// Nothing scatters: Fresnel and Beer-Lambert alone, as discrete ordinates have it.
#[test]
fn clear_stacks_are_exact() {
    let panes = vec![Layer::pane(1.5, 0.2), Layer::pane(1.2, 0.0), Layer::pane(1.6, 1.0)];
    for ground in [Ground::Black, Ground::Lambertian(0.6), Ground::Mirror(0.8)] {
        for (above, below) in [(1.0, 1.0), (1.0, 1.6), (1.4, 1.0)] {
            let stack = Stack { above, layers: panes.clone(), below, ground };
            for incidence in [Incidence::NORMAL, Incidence::Beam(0.4)] {
                check(&stack, incidence, 2e-4);
            }
        }
    }
}

/// A layer in two halves is the layer, also where their names for the same index go through no plane; and an index of its
/// own for a clear pane of no thickness changes only what its planes reflect.
#[test]
fn halves_make_a_whole() {
    for (albedo, g) in [(0.9, 0.5), (1.0, 0.0), (0.3, -0.2)] {
        let one = Stack::slab(layer(4.0, albedo, g).with_index(1.4)).over(Ground::Lambertian(0.3));
        let parts = [1e-7, 1.0, 3.0 - 1e-7].map(|tau| layer(tau, albedo, g).with_index(1.4));
        let two = Stack { layers: parts.to_vec(), ..one.clone() };
        for incidence in [Incidence::Beam(0.7), Incidence::Diffuse] {
            let [a, b] = [&one, &two].map(|stack| shares(stack, incidence).unwrap());
            assert!((a.reflectance - b.reflectance).abs() < 1e-9, "{a:?} {b:?}");
            assert!((a.transmittance - b.transmittance).abs() < 1e-9, "{a:?} {b:?}");
        }
    }
}

#[test]
fn extremes_are_finite() {
    for thickness in [1e-12, 1e-3, 1.0, 1e3, 1e8] {
        for albedo in [1e-12, 0.5, 1.0 - 1e-12, 1.0] {
            for g in [-0.95, 0.0, 0.999] {
                for index in [0.8, 1.0, 2.0] {
                    let stack = Stack::slab(layer(thickness, albedo, g).with_index(index));
                    for incidence in [Incidence::NORMAL, Incidence::Beam(1e-3), Incidence::Diffuse] {
                        let s = shares(&stack, incidence).unwrap();
                        let all = [s.reflectance, s.transmittance, s.absorptance];
                        assert!(all.iter().all(|v| v.is_finite()), "{stack:?}: {s:?}");
                        assert!(all.iter().all(|v| (-0.1..1.1).contains(v)), "{stack:?} {incidence:?}: {s:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let mut stack = Stack::slab(layer(1.0, 0.5, 0.0));
    assert!(matches!(shares(&stack, Incidence::Beam(0.0)), Err(TransferError::Cosine { .. })));
    assert!(matches!(shares(&stack, Incidence::Beam(f64::NAN)), Err(TransferError::Cosine { .. })));
    stack.layers[0].albedo = 2.0;
    assert!(matches!(shares(&stack, Incidence::NORMAL), Err(TransferError::Albedo { .. })));
}
