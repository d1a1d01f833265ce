use super::*;
use crate::phase::testing::sphere::Sphere;
use crate::phase::{AngleGrid, Draine, FournierForand, TableRule, Tabulated, WaterDroplet};

const KEPT: Options = Options { weight: Weight::SolidAngle, keep_asymmetry: true };

/// What has the form of the model is recovered, from a table of it.
#[test]
fn a_model_is_found_again() {
    for (w, g1, g2) in [(0.9, 0.9, -0.4), (0.6, 0.98, 0.3), (0.5, 0.5, -0.5)] {
        let truth = DoubleHenyeyGreenstein::new(w, g1, g2).unwrap();
        for keep_asymmetry in [false, true] {
            for weight in [Weight::SolidAngle, Weight::Energy] {
                let fit = double_henyey_greenstein(&truth.into(), &Options { weight, keep_asymmetry }).unwrap();
                assert!(fit.rms_log10 < 1e-4 && fit.total_variation < 1e-4, "{truth}: {fit:?}");
            }
        }
    }
    for (w, g_hg, g_d, alpha) in [(0.4, 0.97, 0.5, 25.0), (0.25, 0.05, 0.1, 200.0)] {
        let truth = HenyeyGreensteinDraine::new(w, g_hg, g_d, alpha).unwrap();
        for keep_asymmetry in [false, true] {
            let options = Options { keep_asymmetry, ..Options::default() };
            let fit = henyey_greenstein_draine(&truth.into(), &options).unwrap();
            assert!(fit.rms_log10 < 1e-3 && fit.total_variation < 1e-3, "{truth}: {fit:?}");
        }
    }
    for g in [-0.9, 0.0, 0.6, 0.99] {
        let truth = HenyeyGreenstein::new(g).unwrap();
        let fit = henyey_greenstein(&truth.into(), &Options::default()).unwrap();
        assert!((fit.phase.asymmetry() - g).abs() < 1e-5, "{g}: {fit:?}");
    }
}

#[test]
fn the_mean_cosine_is_kept_when_asked() {
    let target = PhaseFunction::from(WaterDroplet::new(12e-6).unwrap());
    let one = henyey_greenstein(&target, &KEPT).unwrap();
    let two = double_henyey_greenstein(&target, &KEPT).unwrap();
    let free = double_henyey_greenstein(&target, &Options::default()).unwrap();
    assert!(one.asymmetry_error.abs() < 1e-14 && two.asymmetry_error.abs() < 1e-13);
    // More freedom can only help the metric.
    assert!(free.rms_log10 <= two.rms_log10 * (1.0 + 1e-6) && two.rms_log10 < one.rms_log10);
}

/// No neighbour of a minimum is better: the metric is recomputed here, apart from the search.
#[test]
fn a_fit_is_a_minimum() {
    let target = PhaseFunction::from(Draine::new(0.7, 3.0).unwrap());
    let fit = double_henyey_greenstein(&target, &Options::default()).unwrap();
    let (w, g1, g2) = fit.phase.parameters();
    for (dw, d1, d2) in [(1e-2, 0.0, 0.0), (0.0, 1e-2, 0.0), (0.0, 0.0, 1e-2)] {
        for sign in [-1.0, 1.0] {
            let beside = DoubleHenyeyGreenstein::new(w + sign * dw, g1 + sign * d1, g2 + sign * d2).unwrap();
            assert!(compare(&target, &beside.into()).rms_log10 > fit.rms_log10, "{fit:?}");
        }
    }
}

#[test]
fn a_table_with_oscillations_and_zeros_can_be_fitted() {
    let grid = AngleGrid::graded(100.0, 12.0).unwrap();
    let table = Tabulated::from_fn(grid, TableRule::Points, |theta| {
        let z = 100.0 * theta;
        (if z > 1e-3 { (z.sin() / z).powi(2) } else { 1.0 }) + 1e-4 * (50.0 * theta).cos().max(0.0)
    })
    .unwrap();
    let target = PhaseFunction::from(table);
    for options in [Options::default(), KEPT, Options { weight: Weight::Energy, keep_asymmetry: true }] {
        let fit = henyey_greenstein_draine(&target, &options).unwrap();
        assert!(fit.rms_log10.is_finite() && fit.max_log10.is_finite());
        assert!(!options.keep_asymmetry || fit.asymmetry_error.abs() < 1e-12);
        assert_eq!(fit, henyey_greenstein_draine(&target, &options).unwrap());
    }
}

/// The search, let loose on Lorenz-Mie theory, comes to about the lobes that jendersie2023s publish for the diameter,
/// and closer to theory than they do.
#[test]
fn a_droplet_is_fitted_by_lobes_like_the_published_ones() {
    let x = std::f64::consts::PI * 10.0 / 0.55;
    let sphere = Sphere::new(x, 1.333);
    let grid = AngleGrid::graded(x, 8.0).unwrap();
    let table = Tabulated::from_fn(grid, TableRule::Integrated, |theta| sphere.intensity(theta)).unwrap();
    let target = PhaseFunction::from(table);
    let options = Options { weight: Weight::Energy, keep_asymmetry: true };
    let fit = henyey_greenstein_draine(&target, &options).unwrap();
    let published = WaterDroplet::new(10e-6).unwrap();
    let parameters = |lobes: HenyeyGreensteinDraine| {
        let (g_d, alpha) = lobes.draine().parameters();
        [lobes.draine_weight(), lobes.henyey_greenstein().asymmetry(), g_d, alpha]
    };
    for (ours, theirs) in parameters(fit.phase).into_iter().zip(parameters(published.lobes())) {
        assert!((ours / theirs - 1.0).abs() < 0.2, "{fit:?}");
    }
    assert!(fit.total_variation < compare(&target, &published.into()).total_variation);
    // Fewer parameters, worse.
    let two = double_henyey_greenstein(&target, &options).unwrap();
    let one = henyey_greenstein(&target, &options).unwrap();
    assert!(fit.rms_log10 < two.rms_log10 && two.rms_log10 < one.rms_log10);
}

/// Whatever the function, the answer is finite, and the mean cosine is kept where that was asked.
#[test]
fn any_function_can_be_fitted() {
    let targets: [PhaseFunction; 4] = [
        HenyeyGreenstein::new(0.999_999).unwrap().into(),
        Draine::new(-0.5, 1e3).unwrap().into(),
        FournierForand::new(1.1, 3.2).unwrap().into(),
        Tabulated::new(vec![0.0, 1.0, 1.1, std::f64::consts::PI], vec![0.0, 0.0, 1.0, 0.0]).unwrap().into(),
    ];
    for target in targets {
        for weight in [Weight::SolidAngle, Weight::Energy] {
            for keep_asymmetry in [false, true] {
                let options = Options { weight, keep_asymmetry };
                let one = henyey_greenstein(&target, &options).unwrap();
                let two = double_henyey_greenstein(&target, &options).unwrap();
                let draine = henyey_greenstein_draine(&target, &options).unwrap();
                for (rms, g) in [
                    (one.rms_log10, one.asymmetry_error),
                    (two.rms_log10, two.asymmetry_error),
                    (draine.rms_log10, draine.asymmetry_error),
                ] {
                    assert!(rms.is_finite() && (!keep_asymmetry || g.abs() < 1e-9), "{target} {options:?}: {rms} {g}");
                }
                // A second lobe can always be given no weight, a Draine lobe no alpha: neither may end up worse.
                assert!(two.rms_log10 < one.rms_log10 * 1.01 + 1e-3, "{target} {options:?}: {two:?} {one:?}");
                assert!(draine.rms_log10 < two.rms_log10 * 1.1 + 1e-3, "{target} {options:?}: {draine:?} {two:?}");
            }
        }
    }
}
