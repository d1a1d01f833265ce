//! What the tests of all formats share.

use mieux_optics::phase::{AngleGrid, FournierForand, HenyeyGreenstein, PhaseFunction, TableRule, Tabulated};
use mieux_optics::spectrum::WavelengthGrid;

use super::channels::Channels;
use super::{Kept, Phases, Subject, Written};

/// A lobe as a table, as phase functions of materials are.
pub fn lobe(g: f64) -> PhaseFunction {
    let hg = HenyeyGreenstein::new(g).unwrap();
    let grid = AngleGrid::graded(40.0, 8.0).unwrap();
    Tabulated::from_fn(grid, TableRule::Points, |theta| hg.value(theta.cos())).unwrap().into()
}

/// Something white with a blue that is absorbed; every quantity varies over wavelength.
pub fn emulsion() -> Subject {
    let grid = WavelengthGrid::frisvad2007();
    let over = |f: &dyn Fn(f64) -> f64| grid.iter().map(|w| f(w * 1e9)).collect::<Vec<f64>>();
    Subject {
        name: "emulsion".into(),
        title: "An emulsion".into(),
        source: "a test -- of what ends comments".into(),
        sigma_s: over(&|w| 2.1e4 * (w / 550.0).powf(-1.3)),
        sigma_a: over(&|w| 4.0 + 60.0 * (-((w - 450.0) / 40.0).powi(2)).exp()),
        asymmetry: over(&|w| 0.93 - 0.02 * (w - 550.0) / 200.0),
        refractive_index: over(&|w| 1.33 + 3e3 / (w * w)),
        phases: Phases::One { wavelength_m: 550e-9, function: lobe(0.93) },
        metres_per_unit: 1.0,
        kept: Kept::Reduced,
        isotropic: false,
        drafts: false,
        grid,
    }
}

/// The same with a forward peak that no table at equal steps of the cosine shows.
pub fn droplets() -> Subject {
    let function = PhaseFunction::from(FournierForand::new(1.1, 3.5835).unwrap());
    let g = function.asymmetry();
    let subject = emulsion();
    let asymmetry = vec![g; subject.grid.len()];
    Subject { asymmetry, phases: Phases::One { wavelength_m: 550e-9, function }, ..subject }
}

pub fn text_of(written: &Written) -> String {
    String::from_utf8(written.files[0].1.clone()).unwrap()
}

/// The numbers in quotes after the first `key`, separated by commas, in single precision, in which renderers read them.
pub fn numbers_after(text: &str, key: &str) -> Vec<f64> {
    let at = text.find(key).unwrap_or_else(|| panic!("no {key}")) + key.len();
    let inside = text[at..].trim_start_matches('"').split('"').next().unwrap();
    inside.split(',').map(|number| f64::from(number.trim().parse::<f32>().unwrap())).collect()
}

/// The coefficients that were read are the material's, within the errors that were printed; and what was printed is what was
/// read, so that no error is overstated to pass.
pub fn assert_recovered(subject: &Subject, written: &Written, sigma_s: &[f64], sigma_a: &[f64], g: &[f64]) {
    let within =
        |read: f64, truth: f64, error: f64| (read - truth).abs() <= (error * (1.0 + 1e-3) + 1e-6) * truth.abs();
    let truth = subject.reduced();
    let mut largest = 0.0f64;
    for i in 0..subject.grid.len() {
        if written.held.sigma_s[i].is_nan() {
            continue;
        }
        let reduced = sigma_s[i] * (1.0 - g[i]);
        assert!(within(reduced, truth[i], written.loss.reduced.largest), "reduced {i}: {reduced} for {}", truth[i]);
        assert!(
            within(sigma_a[i], subject.sigma_a[i], written.loss.sigma_a.largest),
            "sigma_a {i}: {} for {}",
            sigma_a[i],
            subject.sigma_a[i]
        );
        assert!((g[i] - subject.asymmetry[i]).abs() <= written.loss.asymmetry.largest + 1e-6, "g {i}: {}", g[i]);
        largest = largest.max((sigma_a[i] / subject.sigma_a[i] - 1.0).abs());
    }
    let printed = written.loss.sigma_a.largest;
    assert!((largest - printed).abs() <= 0.01 * printed + 1e-4, "{largest} {printed}");
    // And the file says so itself.
    let text = String::from_utf8_lossy(&written.files[0].1).into_owned();
    assert!(
        text.contains("error of sigma_a: at most") && text.contains("scene unit") || text.contains("1/m"),
        "{text}"
    );
}

/// The same, of three channels.
pub fn assert_colours_recovered(subject: &Subject, written: &Written, sigma_s: &[f64], sigma_a: &[f64], g: f64) {
    assert_eq!((sigma_s.len(), sigma_a.len()), (3, 3));
    let channels = Channels::new(&subject.grid).unwrap();
    let of = |values: &[f64]| -> Vec<f64> {
        channels.of_wavelengths().iter().map(|c| c.map_or(f64::NAN, |c| values[c])).collect()
    };
    assert_recovered(subject, written, &of(sigma_s), &of(sigma_a), &vec![g; subject.grid.len()]);
    // The channels themselves are held to single precision, absorption to what a difference leaves of it.
    let wanted = channels.average(&subject.grid, &subject.reduced());
    let absorbed = channels.average(&subject.grid, &subject.sigma_a);
    for c in 0..3 {
        assert!((sigma_s[c] * (1.0 - g) / wanted[c] - 1.0).abs() < 1e-5, "{c}");
        assert!((sigma_a[c] / absorbed[c] - 1.0).abs() < 2e-3, "{c}: {} {}", sigma_a[c], absorbed[c]);
    }
}
