use super::*;
use crate::transfer::{Ground, Layer, Moments};

fn hg(tau: f64, albedo: f64, g: f64) -> Layer {
    Layer::new(tau, albedo, Moments::henyey_greenstein(g).unwrap())
}

#[test]
fn van_de_hulst() {
    for streams in [16, 32, 64, 128] {
        let solver = DiscreteOrdinates::with_streams(streams).unwrap();
        let s = solver.shares(&Stack::slab(hg(2.0, 0.9, 0.75)), Incidence::NORMAL).unwrap();
        println!("{streams}: {s:?}");
    }
}

#[test]
fn half_space() {
    for streams in [8, 16, 32, 64, 128] {
        let solver = DiscreteOrdinates::with_streams(streams).unwrap();
        let s = solver.shares(&Stack::slab(hg(1e6, 0.9, 0.0).with_index(1.5)), Incidence::NORMAL).unwrap();
        let c = solver
            .shares(&Stack::slab(hg(1e6, 1.0, 0.9).with_index(1.5)).over(Ground::Lambertian(0.5)), Incidence::Diffuse)
            .unwrap();
        println!("{streams}: {s:?} {c:?}");
    }
}
