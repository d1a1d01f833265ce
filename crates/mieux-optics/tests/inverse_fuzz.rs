//! Whatever numbers go into adding-doubling and inversion, an error or finite numbers come out.

use mieux_optics::transfer::inverse::{Estimate, Inversion, Measured, Sample};
use mieux_optics::transfer::{AddingDoubling, Ground, Incidence, Layer, Moments, Stack};
use proptest::prelude::*;

/// Any number, those that mean something more often.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => 0.0..=1.0f64,
        2 => (-9.0..7.0f64).prop_map(|x| 10f64.powf(x)),
        1 => any::<f64>(),
        1 => prop_oneof![Just(0.0), Just(1.0), Just(-0.0), Just(f64::NAN), Just(f64::MIN_POSITIVE), Just(1.0 - 1e-16)],
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn adding_gives_shares_or_an_error(
        layers in prop::collection::vec((number(), number(), -1.0..=1.0f64, prop_oneof![Just(1.0), 1.0..2.0f64, number()]), 0..4),
        below in 0.9..2.0f64,
        ground in number(),
        cosine in number(),
        streams in prop_oneof![Just(2usize), Just(8), Just(7)],
        mirror in any::<bool>(),
    ) {
        let layer = |(tau, albedo, g, n): (f64, f64, f64, f64)| {
            Moments::henyey_greenstein(g).ok().map(|moments| Layer::new(tau, albedo, moments).with_index(n))
        };
        let layers: Option<Vec<Layer>> = layers.into_iter().map(layer).collect();
        let Some(layers) = layers else { return Ok(()) };
        let ground = if mirror { Ground::Mirror(ground) } else { Ground::Lambertian(ground) };
        let stack = Stack { above: 1.0, layers, below, ground };
        let solver = AddingDoubling { streams, cut_peak: true };
        if let Ok(all) = solver.shares_of(&[stack], &[Incidence::Beam(cosine), Incidence::Diffuse]) {
            for shares in &all[0] {
                let sum = shares.reflectance + shares.transmittance;
                prop_assert!(shares.reflectance > -1e-9 && shares.transmittance > -1e-9 && sum < 1.0 + 1e-9, "{shares:?}");
            }
        }
    }
}

/// Light is caught in the middle layer, which is too thin to lose any.
#[test]
fn a_layer_of_next_to_nothing_is_nothing() {
    let of = |tau, albedo, g, n| Layer::new(tau, albedo, Moments::henyey_greenstein(g).unwrap()).with_index(n);
    let solver = AddingDoubling { streams: 2, cut_peak: true };
    let shares = |tau: f64| {
        let layers = vec![of(0.708, 0.0, 0.0, 1.627), of(tau, 0.005, -0.277, 1.913), of(0.0, 0.0, 0.0, 1.391)];
        let stack = Stack { above: 1.0, layers, below: 1.945, ground: Ground::Lambertian(0.0) };
        solver.shares_of(&[stack], &[Incidence::Beam(0.0864)]).unwrap()[0][0]
    };
    let nothing = shares(0.0);
    for tau in [9.2e-309, 1e-100, 1e-20, 1e-13, 1e-11, 1e-9] {
        let thin = shares(tau);
        assert!((thin.reflectance - nothing.reflectance).abs() < 1e-6, "{tau} {thin:?}");
        assert!((thin.transmittance - nothing.transmittance).abs() < 1e-6, "{tau} {thin:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn inversion_gives_coefficients_or_an_error(
        n in prop_oneof![Just(1.0), 1.0..1.7f64, number()],
        slide in prop_oneof![Just(1.0), 1.0..1.7f64],
        g in -1.0..=1.0f64,
        shares in [prop::option::of(number()), prop::option::of(number()), prop::option::of(number())],
        error in number(),
    ) {
        let sample = Sample { refractive_index: n, slide_index: slide, asymmetry: g, ..Sample::default() };
        let Ok(inversion) = Inversion::new(sample, 8) else { return Ok(()) };
        let [reflectance, transmittance, unscattered] =
            shares.map(|share| share.map(|value| Estimate { value, error: error.abs() }));
        if let Ok(found) = inversion.invert(&Measured { reflectance, transmittance, unscattered }) {
            let finite = [found.albedo, found.absorption.value, found.scattering.value, found.asymmetry.value];
            prop_assert!(finite.iter().all(|value| value.is_finite()), "{found:?}");
            prop_assert!((0.0..=1.0).contains(&found.albedo) && found.absorption.value >= 0.0, "{found:?}");
            prop_assert!(!found.absorption.error.is_nan() && !found.asymmetry.error.is_nan(), "{found:?}");
            prop_assert!(found.residual.is_finite(), "{found:?}");
        }
    }
}
