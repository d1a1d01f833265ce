use super::*;
use crate::transfer::{AddingDoubling, Incidence, Layer, Moments, Stack};

fn sample(n: f64, slide: f64, g: f64) -> Sample {
    Sample { refractive_index: n, slide_index: slide, asymmetry: g, ..Sample::default() }
}

fn exact(value: f64) -> Option<Estimate> {
    Some(Estimate { value, error: 0.0 })
}

const SAMPLES: [(f64, f64, f64); 4] = [(1.0, 1.0, 0.0), (1.4, 1.5, 0.0), (1.33, 1.0, 0.8), (1.4, 1.5, -0.3)];

/// Shares of slabs of which the coefficients are known, over four decades, lead back to them.
#[test]
fn what_was_put_in_comes_out() {
    for (n, slide, g) in SAMPLES {
        let inversion = Inversion::new(sample(n, slide, g), 16).unwrap();
        for absorption in [0.0, 0.01, 0.3, 2.0] {
            for scattering in [0.1, 1.0, 7.0, 60.0] {
                let slab = Slab { absorption, scattering: scattering / (1.0 - g), asymmetry: g };
                let [r, t, u] = inversion.forward.shares(&[slab]).unwrap()[0];
                let two = Measured { reflectance: exact(r), transmittance: exact(t), unscattered: None };
                // What is lost in the rounding of the shares cannot be found.
                if t < 1e-6 {
                    continue;
                }
                let found = inversion.invert(&two).unwrap();
                assert!(found.misfit.is_none(), "{n} {slide} {slab:?}: {found:?}");
                assert!((found.absorption.value - absorption).abs() < 1e-5 * (1.0 + absorption), "{slab:?} {found:?}");
                assert!((found.scattering.value / slab.scattering - 1.0).abs() < 1e-4, "{slab:?} {found:?}");
                if u > 1e-9 && scattering > 0.2 {
                    let all = inversion.invert(&Measured { unscattered: exact(u), ..two }).unwrap();
                    assert!((all.asymmetry.value - g).abs() < 1e-4, "{n} {slide} {slab:?}: {all:?}");
                    assert!((all.scattering.value / slab.scattering - 1.0).abs() < 1e-4, "{slab:?} {all:?}");
                }
            }
        }
    }
}

/// To first order, errors of what was found are what small changes of what was measured do.
#[test]
fn errors_are_those_of_repeated_measurements() {
    let inversion = Inversion::new(sample(1.4, 1.5, 0.0), 16).unwrap();
    let errors = [1e-4, 2e-4, 1e-5];
    let [r, t, u] = [0.3, 0.25, 0.01];
    let with = |change: [f64; 3]| {
        let one = |i: usize, value: f64| Some(Estimate { value: value + change[i], error: errors[i] });
        Measured { reflectance: one(0, r), transmittance: one(1, t), unscattered: one(2, u) }
    };
    let found = inversion.invert(&with([0.0; 3])).unwrap();
    let values = |f: &Found| [f.absorption, f.scattering, f.reduced_scattering, f.asymmetry];
    let mut variances = [0.0; 4];
    for i in 0..3 {
        let mut change = [0.0; 3];
        change[i] = errors[i];
        let beside = inversion.invert(&with(change)).unwrap();
        for (sum, (a, b)) in variances.iter_mut().zip(values(&beside).iter().zip(values(&found))) {
            *sum += (a.value - b.value).powi(2);
        }
    }
    for (variance, estimate) in variances.iter().zip(values(&found)) {
        assert!((variance.sqrt() / estimate.error - 1.0).abs() < 0.02, "{variances:?} {found:?}");
    }
}

#[test]
fn shares_that_no_slab_has_lead_to_the_nearest_and_say_why() {
    let inversion = Inversion::new(sample(1.4, 1.5, 0.0), 16).unwrap();
    let invert = |r: f64, t: f64, u: f64| {
        let unscattered = if u > 0.0 { exact(u) } else { None };
        inversion.invert(&Measured { reflectance: exact(r), transmittance: exact(t), unscattered }).unwrap()
    };
    let bright = invert(0.7, 0.4, 0.0);
    assert!(matches!(bright.misfit, Some(Misfit::MoreThanFallsIn { sum }) if (sum - 1.1).abs() < 1e-12), "{bright:?}");
    assert!(bright.absorption.value < 1e-6 && bright.scattering.value > 1.0, "{bright:?}");
    // Half of the excess is in each: the nearest point of R + T = 1.
    assert!((bright.residual - 0.1 / 2f64.sqrt()).abs() < 1e-3, "{bright:?}");
    let dark = invert(0.01, 0.3, 0.0);
    assert!(matches!(dark.misfit, Some(Misfit::ReflectanceBelowSurface { least }) if least > 0.04), "{dark:?}");
    let clear = invert(0.1, 0.9, 0.97);
    assert!(matches!(clear.misfit, Some(Misfit::UnscatteredAboveSurfaces { .. })), "{clear:?}");
    let less = invert(0.2, 0.1, 0.2);
    assert!(matches!(less.misfit, Some(Misfit::TransmittanceBelowUnscattered { .. })), "{less:?}");
}

#[test]
fn refuses_what_cannot_be() {
    let inversion = Inversion::new(Sample::default(), 8).unwrap();
    let of = |r, t, u| inversion.invert(&Measured { reflectance: r, transmittance: t, unscattered: u });
    assert!(matches!(of(exact(1.2), None, None), Err(InverseError::Share { quantity: "reflectance", .. })));
    assert!(matches!(of(exact(f64::NAN), None, None), Err(InverseError::Share { .. })));
    assert!(matches!(of(None, exact(0.5), None), Err(InverseError::TooLittle { .. })));
    assert!(matches!(of(None, None, exact(0.5)), Err(InverseError::TooLittle { .. })));
    let noisy = Some(Estimate { value: 0.5, error: -1.0 });
    assert!(matches!(of(noisy, None, None), Err(InverseError::StandardError { .. })));
    assert!(Inversion::new(sample(0.0, 1.0, 0.0), 8).is_err());
    assert!(Inversion::new(sample(1.4, 1.0, 1.0), 8).is_err());
    assert!(Inversion::new(Sample { optical_thickness: Some(0.0), ..Sample::default() }, 8).is_err());
    assert!(Inversion::new(Sample { specular_in_reflectance: 2.0, ..Sample::default() }, 8).is_err());
}

/// A thick sample by its reflectance alone; the other engine has the last word.
#[test]
fn one_share_gives_one_ratio() {
    let ratio = |g: f64| {
        let inversion = Inversion::new(sample(1.0, 1.0, g), 32).unwrap();
        let reflectance = Some(Estimate { value: 0.4, error: 1e-3 });
        let found = inversion.invert(&Measured { reflectance, ..Measured::default() }).unwrap();
        assert!(found.optical_thickness.is_infinite() && found.misfit.is_none());
        assert!((found.reduced_scattering.value - 1.0).abs() < 1e-12);
        assert!(found.absorption.error > 0.0 && found.absorption.error < 0.01, "{found:?}");
        let thick = Layer::new(1e4, found.albedo, Moments::henyey_greenstein(g).unwrap());
        let again = AddingDoubling::default().shares(&Stack::slab(thick), Incidence::NORMAL).unwrap();
        assert!((again.reflectance - 0.4).abs() < 1e-8, "{again:?}");
        found.absorption.value
    };
    assert!((ratio(0.0) - 0.1217).abs() < 1e-4, "{}", ratio(0.0));
    // Similarity of asymmetries is a rule of thumb: a peak forward takes a sixth less absorption here.
    assert!(ratio(0.9) < ratio(0.0), "{}", ratio(0.9));
}
