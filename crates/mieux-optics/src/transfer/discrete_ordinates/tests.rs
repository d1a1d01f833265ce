use std::f64::consts::PI;

use super::*;
use crate::transfer::{Ground, Layer, Moments};

fn hg(tau: f64, albedo: f64, g: f64) -> Layer {
    Layer::new(tau, albedo, Moments::henyey_greenstein(g).unwrap())
}

fn solver(streams: usize) -> DiscreteOrdinates {
    DiscreteOrdinates::with_streams(streams).unwrap()
}

/// A stack with all there is: refraction both ways, a pane, a cloudless layer, a bright ground.
fn mixed(albedo: f64, ground: Ground) -> Stack {
    let layers = vec![
        Layer::pane(1.5, 0.0),
        hg(3.0, albedo, 0.8).with_index(1.33),
        hg(0.0, albedo, 0.3).with_index(1.1),
        hg(20.0, albedo, -0.3).with_index(1.45),
        Layer::new(0.7, albedo, Moments::isotropic()),
    ];
    Stack { above: 1.0, layers, below: 1.2, ground }
}

#[test]
fn nothing_is_lost_without_absorption() {
    for ground in [Ground::Black, Ground::Lambertian(0.7), Ground::Mirror(0.4)] {
        for tau in [0.0, 1e-8, 1.0, 1e3, 1e6] {
            let mut stack = mixed(1.0, ground);
            stack.layers[3].optical_thickness = tau;
            for incidence in [Incidence::NORMAL, Incidence::Beam(0.05), Incidence::Diffuse] {
                let s = solver(24).shares(&stack, incidence).unwrap();
                assert!(s.absorptance.abs() < 1e-11, "{ground:?} {tau} {incidence:?}: {s:?}");
                assert!(s.transmittance > 0.0 && s.reflectance > 0.0);
            }
        }
    }
    let white = solver(16).shares(&mixed(1.0, Ground::Lambertian(1.0)), Incidence::NORMAL).unwrap();
    assert!((white.reflectance - 1.0).abs() < 1e-11 && white.transmittance.abs() < 1e-11, "{white:?}");
}

/// The net flux is what the shares say at both ends, and falls with depth wherever light is absorbed.
#[test]
fn fluxes_and_shares_agree() {
    let stack = mixed(0.95, Ground::Lambertian(0.3));
    let shares = solver(32).shares(&stack, Incidence::Beam(0.7)).unwrap();
    let light = Light { beam: Some((0.7, 1.0)), ..Light::default() };
    let depths: Vec<f64> = (0..=237).map(|i| f64::from(i) * 0.1).collect();
    let fluxes = solver(32).fluxes(&stack, &light, &depths).unwrap();
    assert!((fluxes[0].net() - (1.0 - shares.reflectance)).abs() < 1e-12);
    assert!((fluxes[237].net() - shares.transmittance).abs() < 1e-12);
    assert!(fluxes.windows(2).all(|pair| pair[1].net() < pair[0].net()));
    // A layer cut by planes is the layer.
    let cut = solver(32).fluxes(&stack, &light, &[1.5, 1.5, 0.75, 20.0]).unwrap();
    let alone = solver(32).fluxes(&stack, &light, &[1.5]).unwrap();
    for found in &cut[..2] {
        assert!((found.up - alone[0].up).abs() < 1e-13 && (found.net() - alone[0].net()).abs() < 1e-13);
    }
}

/// In a black box of its own temperature nothing flows: every layer emits as it absorbs, whatever its index.
#[test]
fn equilibrium_is_still() {
    let mut stack = mixed(0.6, Ground::Black);
    stack.layers.iter_mut().for_each(|layer| layer.emission = [2.5; 2]);
    let light = Light { beam: None, above: 2.5, below: 2.5 * 1.44 };
    for flux in solver(20).fluxes(&stack, &light, &[0.0, 1.0, 3.0, 13.0, 23.7]).unwrap() {
        assert!(flux.net().abs() < 1e-12 * flux.up, "{flux:?}");
    }
    let below = solver(20).fluxes(&stack, &light, &[0.5]).unwrap()[0];
    assert!((below.up - 2.5 * PI * 1.33 * 1.33).abs() < 1e-9, "{below:?}");
}

/// A linear source in a thick black medium gives the Eddington-Barbier flux, `pi (B_0 + 2/3 B')`.
#[test]
fn a_graded_source_shines_as_the_depth_of_two_thirds() {
    let mut layer = hg(60.0, 0.0, 0.0);
    layer.emission = [1.0, 1.0 + 60.0 * 0.25];
    let up = solver(32).fluxes(&Stack::slab(layer), &Light::default(), &[0.0]).unwrap()[0].up;
    assert!((up - PI * (1.0 + 2.0 / 3.0 * 0.25)).abs() < 1e-9, "{up}");
}

/// To 1e-7 where the forward peak is moderate or nothing refracts. (A peak of g = 0.9 under refraction needs twice the
/// streams: they are shared between two ranges of directions.)
#[test]
fn streams_converge() {
    let stacks = [
        Stack::slab(hg(2.0, 0.9, 0.75)),
        Stack::slab(hg(5.0, 0.99, 0.9)),
        Stack::slab(hg(5.0, 0.99, 0.75).with_index(1.5)),
    ];
    for stack in stacks {
        for incidence in [Incidence::NORMAL, Incidence::Diffuse] {
            let coarse = solver(64).shares(&stack, incidence).unwrap();
            let fine = solver(128).shares(&stack, incidence).unwrap();
            assert!((coarse.reflectance - fine.reflectance).abs() < 1e-7, "{coarse:?} {fine:?}");
            assert!((coarse.transmittance - fine.transmittance).abs() < 1e-7, "{coarse:?} {fine:?}");
        }
    }
}

/// A node as the beam's cosine, and an albedo of 1, are removable singularities; the answer must pass through them.
#[test]
fn is_smooth_where_formulas_divide_by_zero() {
    let stack = |albedo| Stack::slab(hg(2.0, albedo, 0.5));
    let node = crate::integrate::gauss_legendre(8)[5].0.mul_add(0.5, 0.5);
    let at = |cosine: f64| solver(16).shares(&stack(0.9), Incidence::Beam(cosine)).unwrap().reflectance;
    assert!((at(node) - 0.5 * (at(node - 1e-6) + at(node + 1e-6))).abs() < 1e-10);
    let of = |albedo: f64| solver(16).shares(&stack(albedo), Incidence::NORMAL).unwrap().reflectance;
    assert!((of(1.0) - (2.0 * of(1.0 - 1e-7) - of(1.0 - 2e-7))).abs() < 1e-11);
}

/// Neighbours in a group do not touch each other's answers beyond rounding.
#[test]
fn many_are_solved_as_one() {
    let stacks: Vec<Stack> = (0..21).map(|i| mixed(0.05 * f64::from(i % 20), Ground::Lambertian(0.2))).collect();
    let incidences = [Incidence::Beam(0.3), Incidence::Diffuse];
    let all = solver(16).shares_of(&stacks, &incidences).unwrap();
    for (stack, found) in stacks.iter().zip(all) {
        for (incidence, shares) in incidences.iter().zip(found) {
            let alone = solver(16).shares(stack, *incidence).unwrap();
            assert!((alone.reflectance - shares.reflectance).abs() < 1e-13);
            assert!((alone.transmittance - shares.transmittance).abs() < 1e-13);
        }
    }
}

/// Stacks of the same indices have different streams where a dense layer is clear in one and scatters in the other.
#[test]
fn the_stack_before_leaves_no_trace() {
    let dense = |tau, albedo| {
        let layers = vec![hg(tau, albedo, 0.5).with_index(1.6), hg(2.0, 0.9, 0.7).with_index(1.4)];
        Stack { above: 1.0, layers, below: 1.0, ground: Ground::Black }
    };
    let swapped = |stack: Stack| Stack { layers: stack.layers.into_iter().rev().collect(), ..stack };
    let stacks = [
        dense(1.0, 0.0),
        dense(1.0, 0.8),
        dense(0.0, 0.8),
        swapped(dense(1.0, 0.8)),
        swapped(dense(1.0, 0.0)),
        Stack { below: 1.4, ..dense(1.0, 0.0) },
        Stack::slab(hg(1.0, 0.8, 0.5)),
        dense(1.0, 0.8),
    ];
    let all = solver(16).shares_of(&stacks, &[Incidence::Beam(0.6)]).unwrap();
    for (stack, found) in stacks.iter().zip(all) {
        assert_eq!(solver(16).shares(stack, Incidence::Beam(0.6)).unwrap(), found[0]);
    }
}

#[test]
fn refuses_what_cannot_be() {
    let slab = || Stack::slab(hg(1.0, 0.9, 0.5));
    for streams in [0, 3, 258] {
        assert_eq!(DiscreteOrdinates::with_streams(streams), Err(TransferError::Streams { streams }));
    }
    let shares = |stack: &Stack, incidence| DiscreteOrdinates::default().shares(stack, incidence);
    for cosine in [0.0, -0.5, 1.1, f64::NAN] {
        assert!(matches!(shares(&slab(), Incidence::Beam(cosine)), Err(TransferError::Cosine { .. })));
    }
    let refused = |layer: Layer| shares(&Stack::slab(layer), Incidence::NORMAL).unwrap_err();
    assert!(matches!(refused(hg(-1.0, 0.9, 0.0)), TransferError::OpticalThickness { layer: 0, .. }));
    assert!(matches!(refused(hg(1.0, 1.1, 0.0)), TransferError::Albedo { layer: 0, .. }));
    assert!(matches!(refused(hg(1.0, 0.9, 0.0).with_index(0.0)), TransferError::RefractiveIndex { .. }));
    assert!(matches!(shares(&slab().over(Ground::Mirror(2.0)), Incidence::NORMAL), Err(TransferError::Ground { .. })));
    let fluxes = |depth| DiscreteOrdinates::default().fluxes(&slab(), &Light::default(), &[depth]);
    assert!(fluxes(-0.1).is_err() && fluxes(1.1).is_err() && fluxes(f64::NAN).is_err() && fluxes(1.0).is_ok());
    let dark = Light { above: f64::NAN, ..Light::default() };
    assert!(matches!(DiscreteOrdinates::default().fluxes(&slab(), &dark, &[]), Err(TransferError::Source { .. })));
}
