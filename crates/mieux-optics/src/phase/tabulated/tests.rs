use std::f64::consts::PI;

use super::*;
use crate::phase::testing::{self, Uniform, sphere::Sphere};
use crate::phase::{FournierForand, HenyeyGreenstein, PhaseFunction};

/// A droplet of 50 um radius in green light: a forward peak 0.3 degrees wide, rainbow and glory.
#[test]
fn a_large_droplet_keeps_its_mean_cosine() {
    let x = 2.0 * PI * 50.0 / 0.55;
    let sphere = Sphere::new(x, 1.333);
    let exact = 1.0 - sphere.asymmetry();
    let points = Tabulated::to_tolerance(x, 1e-3, |theta| sphere.intensity(theta)).unwrap();
    let error = points.one_minus_asymmetry() / exact - 1.0;
    assert!(error.abs() < 1e-3 && error.abs() <= points.one_minus_asymmetry_error());
    let grid = AngleGrid::graded(x, 1.0).unwrap();
    let binned = Tabulated::from_fn(grid, TableRule::Integrated, |theta| sphere.intensity(theta)).unwrap();
    let error = binned.one_minus_asymmetry() / exact - 1.0;
    assert!(error.abs() < 1e-5 && error.abs() <= binned.one_minus_asymmetry_error() + 1e-9);
}

/// What goes wrong without a graded grid: the same droplet at equal steps of the cosine.
#[test]
fn equal_steps_of_the_cosine_lose_the_peak_and_say_so() {
    let x = PI * 20.0 / 0.55;
    let sphere = Sphere::new(x, 1.33);
    let exact = 1.0 - sphere.asymmetry();
    // The errors were found by another program.
    for (count, known) in [(1001usize, 0.74), (5001, 0.22), (20001, 0.019)] {
        let angles: Vec<f64> = (0..count).map(|i| (1.0 - 2.0 * i as f64 / (count - 1) as f64).acos()).collect();
        let grid = AngleGrid::new(angles).unwrap();
        let table = Tabulated::from_fn(grid, TableRule::Points, |theta| sphere.intensity(theta)).unwrap();
        let error = (table.one_minus_asymmetry() / exact - 1.0).abs();
        assert!((error / known - 1.0).abs() < 0.03, "{count}: {error}");
        assert!(table.one_minus_asymmetry_error() > error, "{count}: {}", table.one_minus_asymmetry_error());
    }
}

/// A piecewise linear function is its own table: everything to rounding.
#[test]
fn any_table_is_a_phase_function() {
    let mut uniform = Uniform::new(7);
    for bins in [1usize, 2, 3, 10, 60] {
        let mut angles: Vec<f64> = (1..bins).map(|_| PI * uniform.next().powi(3)).collect();
        angles.extend([0.0, PI]);
        angles.sort_by(f64::total_cmp);
        // Steps between bins, and empty bins at both ends and inside.
        let ends: Vec<[f64; 2]> = (0..bins)
            .map(|i| if i % 4 == 3 || (bins > 2 && i == 0) { [0.0; 2] } else { [uniform.next() * 1e5, uniform.next()] })
            .collect();
        let table = Tabulated::from_bins(AngleGrid::new(angles).unwrap(), ends).unwrap();
        let phase = PhaseFunction::from(table.clone());
        testing::check(&phase);
        let shares: Vec<f64> = table.cumulative.iter().map(|share| 1.0 - share).collect();
        testing::check_inverse(&phase, &shares);
        assert!(table.asymmetry() + table.one_minus_asymmetry() == 1.0);
    }
}

#[test]
fn the_sample_inverts_the_forward_fraction() {
    let table = Tabulated::new(vec![0.0, 0.01, 0.1, 1.0, 2.0, PI], vec![1e6, 1e3, 0.0, 0.0, 1.0, 2.0]).unwrap();
    for i in 0..=1000 {
        let xi = f64::from(i) / 1000.0;
        let mu = table.sample(xi);
        assert!((table.forward_fraction(mu) - (1.0 - xi)).abs() < 1e-9, "{xi}: {mu}");
    }
    assert_eq!((table.sample(0.0), table.sample(1.0)), (-1.0, 1.0));
    // Nothing lies between 0.1 and 1 rad, so nothing is sampled there.
    let mut uniform = Uniform::new(3);
    for _ in 0..100_000 {
        let mu = table.sample(uniform.next());
        assert!(mu >= 0.1f64.cos() - 1e-12 || mu <= 1f64.cos() + 1e-12);
    }
}

/// Against the closed form of what was tabulated, up to the degrees that a peak excites.
#[test]
fn moments_of_a_tabulated_lobe_are_powers_of_its_parameter() {
    let g = 0.98;
    let hg = HenyeyGreenstein::new(g).unwrap();
    let grid = AngleGrid::graded(100.0, 4.0).unwrap();
    let table = Tabulated::from_fn(grid, TableRule::Integrated, |theta| hg.value(theta.cos())).unwrap();
    let off = (table.one_minus_asymmetry() / (1.0 - g) - 1.0).abs();
    assert!(off <= table.one_minus_asymmetry_error());
    assert!(table.one_minus_asymmetry_error() < 1e-7, "{:e}", table.one_minus_asymmetry_error());
    let moments = table.legendre_moments(300);
    for l in [0u32, 1, 2, 10, 100, 300] {
        assert!((moments[l as usize] - table.legendre_moment(l)).abs() < 1e-12);
        assert!(
            (moments[l as usize] - g.powi(l as i32)).abs() < 2e-5,
            "{l}: {}",
            moments[l as usize] - g.powi(l as i32)
        );
    }
}

#[test]
fn integrals_over_bins_survive_what_points_do_not() {
    // A peak that falls between the first two angles altogether.
    let phase = FournierForand::new(1.1, 3.5835).unwrap();
    let f = |theta: f64| phase.value_away(quadrature::away_of(theta));
    let grid = AngleGrid::uniform(180).unwrap();
    let exact = 1.0 - phase.asymmetry();
    let points = Tabulated::from_fn(grid.clone(), TableRule::Points, f).unwrap();
    let bins = Tabulated::from_fn(grid, TableRule::Integrated, f).unwrap();
    let [points_off, bins_off] = [&points, &bins].map(|t| (t.one_minus_asymmetry() / exact - 1.0).abs());
    assert!(points_off > 0.5 && bins_off < 1e-3 && bins_off <= 1.01 * bins.one_minus_asymmetry_error());
}

#[test]
fn values_of_any_scale_are_normalised() {
    for scale in [5e-324, 1e-300, 1.0, 1e308] {
        let table = Tabulated::new(vec![0.0, 1.0, PI], vec![scale, scale, scale]).unwrap();
        let grid = AngleGrid::uniform(4).unwrap();
        let integrated = Tabulated::from_fn(grid, TableRule::Integrated, |_| scale).unwrap();
        for table in [table, integrated] {
            assert!((table.value(0.3) - 0.25 / PI).abs() < 1e-12 && table.asymmetry().abs() < 1e-12);
        }
    }
}

#[test]
fn what_is_no_table_is_refused() {
    assert!(matches!(Tabulated::new(vec![0.0, PI], vec![1.0]), Err(PhaseError::TableLength { .. })));
    assert!(matches!(Tabulated::new(vec![], vec![]), Err(PhaseError::TableLength { .. })));
    assert!(matches!(Tabulated::new(vec![0.0, PI], vec![0.0, 0.0]), Err(PhaseError::Integral { .. })));
    for value in [-1e-300, f64::NAN, f64::INFINITY] {
        let refused = Tabulated::new(vec![0.0, 1.0, PI], vec![1.0, value, 1.0]);
        assert!(matches!(refused, Err(PhaseError::AngleValue { theta_rad, .. }) if theta_rad == 1.0), "{value}");
        let refused = Tabulated::from_fn(AngleGrid::uniform(4).unwrap(), TableRule::Integrated, |_| value);
        assert!(matches!(refused, Err(PhaseError::AngleValue { .. })), "{value}");
    }
    let grid = AngleGrid::uniform(4).unwrap();
    assert!(matches!(Tabulated::from_bins(grid.clone(), vec![[1.0; 2]; 3]), Err(PhaseError::TableLength { .. })));
    let wild = |theta: f64| 1.0 / (theta - 1.0).abs().max(1e-250);
    assert!(matches!(Tabulated::from_fn(grid, TableRule::Integrated, wild), Err(PhaseError::NotIntegrable { .. })));
    let spike = |theta: f64| if theta == 0.0 { 1e9 } else { 1.0 };
    assert!(matches!(Tabulated::to_tolerance(1.0, 1e-6, spike), Err(PhaseError::Tolerance { .. })));
    assert!(Tabulated::new(vec![0.0, PI], vec![1.0, 2.0]).unwrap().one_minus_asymmetry_error().is_infinite());
}
