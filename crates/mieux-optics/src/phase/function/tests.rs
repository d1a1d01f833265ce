use proptest::prelude::*;

use super::*;
use crate::phase::{PhaseError, testing::sphere::Sphere};

/// One of each, at unremarkable parameters.
fn one_of_each() -> Vec<PhaseFunction> {
    vec![
        Isotropic.into(),
        Rayleigh.into(),
        HenyeyGreenstein::new(0.9).unwrap().into(),
        DoubleHenyeyGreenstein::new(0.9, 0.9, -0.4).unwrap().into(),
        HenyeyGreensteinMixture::new(&[(1.0, 0.9), (2.0, 0.1)]).unwrap().into(),
        CornetteShanks::new(0.5).unwrap().into(),
        Draine::new(0.5, 10.0).unwrap().into(),
        HenyeyGreensteinDraine::new(0.5, 0.9, 0.5, 10.0).unwrap().into(),
        WaterDroplet::new(10e-6).unwrap().into(),
        FournierForand::new(1.1, 3.6).unwrap().into(),
        Tabulated::new(vec![0.0, 1.0, std::f64::consts::PI], vec![3.0, 1.0, 2.0]).unwrap().into(),
    ]
}

#[test]
fn every_function_has_a_name_of_its_own_that_starts_its_description() {
    let all = one_of_each();
    for (i, phase) in all.iter().enumerate() {
        assert!(phase.to_string().starts_with(phase.name()), "{phase}");
        assert!(all[..i].iter().all(|other| other.name() != phase.name()));
        let moments = phase.legendre_moments(5);
        assert!((0..=5u32).all(|l| (moments[l as usize] - phase.legendre_moment(l)).abs() < 1e-14));
    }
    assert_eq!(all[6].to_string(), "Draine (g = 0.5, alpha = 10)");
}

#[test]
fn every_source_is_listed() {
    let listed = include_str!("../../../../../references.bib");
    for phase in one_of_each() {
        if let Some(key) = phase.source() {
            assert!(listed.contains(&format!("{{{key},")), "{key}");
        }
    }
}

/// The fit for droplets against the theory that it stands for, in green light and averaged over diameters within a
/// twentieth. Below 1 um the fit is not that of a single sphere's.
#[test]
fn droplets_have_the_mean_cosine_of_theory() {
    for diameter in [1.0, 3.0, 7.0, 20.0, 50.0] {
        let theory: f64 = (0..11)
            .map(|i| {
                let d = diameter * (0.95 + 0.01 * f64::from(i));
                Sphere::new(std::f64::consts::PI * d / 0.55, 1.333).asymmetry() / 11.0
            })
            .sum();
        let fit = WaterDroplet::new(diameter * 1e-6).unwrap().asymmetry();
        assert!((fit - theory).abs() < 0.03, "{diameter}: {fit} {theory}");
    }
}

/// Any bits at all, and often enough numbers that mean something.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![any::<u64>().prop_map(f64::from_bits), -1.5..1.5f64, 0.0..60.0f64, 3.0..5.0f64]
}

fn made_from(p: [f64; 6]) -> Vec<Result<PhaseFunction, PhaseError>> {
    vec![
        HenyeyGreenstein::new(p[0]).map(Into::into),
        DoubleHenyeyGreenstein::new(p[0], p[1], p[2]).map(Into::into),
        HenyeyGreensteinMixture::new(&[(p[0], p[1]), (p[2], p[3]), (p[4], p[5])]).map(Into::into),
        CornetteShanks::new(p[0]).map(Into::into),
        Draine::new(p[0], p[1]).map(Into::into),
        HenyeyGreensteinDraine::new(p[0], p[1], p[2], p[3]).map(Into::into),
        WaterDroplet::new(p[0]).map(Into::into),
        WaterDroplet::new(p[0] * 1e-6).map(Into::into),
        FournierForand::new(p[0], p[1]).map(Into::into),
        FournierForand::from_backscatter(p[0], p[1]).map(Into::into),
        Tabulated::new(vec![0.0, p[0], p[1], std::f64::consts::PI], p[2..].to_vec()).map(Into::into),
        Tabulated::new(vec![0.0, 1e-7, 1.0, std::f64::consts::PI], p[2..].to_vec()).map(Into::into),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn no_number_makes_it_panic(parameters in [(); 6].map(|()| number()), mu in number(), xi in number()) {
        for phase in one_of_each().into_iter().chain(made_from(parameters).into_iter().flatten()) {
            let (value, inside) = (phase.value(mu), phase.value(0.37));
            prop_assert!(value >= 0.0 || mu.is_nan(), "{phase} at {mu}: {value}");
            prop_assert!(inside >= 0.0 && inside.is_finite(), "{phase}: {inside}");
            let sample = phase.sample(xi);
            prop_assert!((-1.0..=1.0).contains(&sample) || (xi.is_nan() && sample.is_nan()), "{phase} of {xi}: {sample}");
            prop_assert!(phase.asymmetry().abs() <= 1.0 + 1e-9, "{phase}: {}", phase.asymmetry());
        }
    }

    #[test]
    fn no_number_makes_a_struct_panic(mu in number(), xi in number(), g in -0.9999..0.9999f64) {
        let hg = HenyeyGreenstein::new(g).unwrap();
        let draine = Draine::new(g, 7.0).unwrap();
        let forand = FournierForand::new(1.2, 4.0 + 0.9 * g).unwrap();
        let table = Tabulated::new(vec![0.0, 1.0, std::f64::consts::PI], vec![3.0, 1.0 + g, 0.0]).unwrap();
        // Outside [-1, 1] the value means nothing, but must not bring the program down.
        let _ = (hg.value(mu), draine.value(mu), forand.value(mu), table.value(mu), table.forward_fraction(mu));
        for sample in [hg.sample(xi), draine.sample(xi), forand.sample(xi), table.sample(xi), Rayleigh.sample(xi)] {
            prop_assert!((-1.0..=1.0).contains(&sample) || xi.is_nan());
        }
    }
}
