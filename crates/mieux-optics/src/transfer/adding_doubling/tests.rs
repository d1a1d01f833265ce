use super::*;
use crate::transfer::{DiscreteOrdinates, Layer, Moments};

fn hg(tau: f64, albedo: f64, g: f64) -> Layer {
    Layer::new(tau, albedo, Moments::henyey_greenstein(g).unwrap())
}

fn solver(streams: usize) -> AddingDoubling {
    AddingDoubling::with_streams(streams).unwrap()
}

/// A stack with all there is: refraction both ways, a pane, a clear layer, a bright ground.
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

const INCIDENCES: [Incidence; 4] = [Incidence::NORMAL, Incidence::Beam(0.05), Incidence::Beam(0.6), Incidence::Diffuse];

#[test]
fn nothing_is_lost_without_absorption() {
    for ground in [Ground::Black, Ground::Lambertian(0.7), Ground::Mirror(0.4)] {
        for tau in [0.0, 1e-8, 1.0, 1e3, 1e6] {
            let mut stack = mixed(1.0, ground);
            stack.layers[3].optical_thickness = tau;
            for found in solver(24).shares_of(&[stack], &INCIDENCES).unwrap()[0].iter() {
                assert!(found.absorptance.abs() < 1e-11, "{ground:?} {tau}: {found:?}");
                assert!(found.transmittance > 0.0 && found.reflectance > 0.0);
            }
        }
    }
    let white = solver(16).shares(&mixed(1.0, Ground::Lambertian(1.0)), Incidence::NORMAL).unwrap();
    assert!((white.reflectance - 1.0).abs() < 1e-11 && white.transmittance.abs() < 1e-11, "{white:?}");
}

/// Two solvers of the same discrete equation, which have nothing else in common.
#[test]
fn agrees_with_discrete_ordinates_on_a_mixed_stack() {
    for ground in [Ground::Black, Ground::Lambertian(0.7), Ground::Mirror(0.4)] {
        for albedo in [0.0, 0.3, 0.99, 1.0] {
            let stacks = [mixed(albedo, ground)];
            let ours = &solver(24).shares_of(&stacks, &INCIDENCES).unwrap()[0];
            let theirs = &DiscreteOrdinates::with_streams(24).unwrap().shares_of(&stacks, &INCIDENCES).unwrap()[0];
            for (a, b) in ours.iter().zip(theirs) {
                let off = (a.reflectance - b.reflectance).abs().max((a.transmittance - b.transmittance).abs());
                assert!(off < 1e-11, "{ground:?} {albedo}: {a:?} {b:?}");
                assert_eq!(a.reflectance_specular, b.reflectance_specular);
                assert_eq!(a.transmittance_unscattered, b.transmittance_unscattered);
            }
        }
    }
}
