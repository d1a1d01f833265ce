//! How far what is written is from what is known.

use super::Subject;
use crate::quantity::significant;

/// What a reader of the files gets back, at the wavelengths of the subject; NaN at those that no channel of colour sees.
#[derive(Debug, Clone, PartialEq)]
pub struct Held {
    /// Scattering coefficient, 1/m.
    pub sigma_s: Vec<f64>,
    /// Absorption coefficient, 1/m.
    pub sigma_a: Vec<f64>,
    /// Mean cosine of scattering.
    pub asymmetry: Vec<f64>,
}

/// The largest error over the wavelengths, and the root of the mean of its square.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Errors {
    /// The largest.
    pub largest: f64,
    /// Root of the mean square.
    pub rms: f64,
}

impl Errors {
    fn of(errors: impl Iterator<Item = f64>) -> Self {
        let (mut largest, mut squares, mut count) = (0.0f64, 0.0, 0u32);
        for error in errors.filter(|error| !error.is_nan()) {
            largest = largest.max(error.abs());
            squares += error * error;
            count += 1;
        }
        Self { largest, rms: if count == 0 { 0.0 } else { (squares / f64::from(count)).sqrt() } }
    }

    /// Relative to the truth; an absolute difference of nothing is none, and something in place of nothing is all.
    fn relative(held: &[f64], truth: &[f64]) -> Self {
        Self::of(held.iter().zip(truth).map(|(held, truth)| {
            let difference = held - truth;
            if difference == 0.0 { 0.0 } else { difference / truth.abs().max(f64::MIN_POSITIVE) }
        }))
    }
}

/// Errors of what is held, against the spectra.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Loss {
    /// Relative errors of reduced scattering.
    pub reduced: Errors,
    /// Relative errors of scattering.
    pub sigma_s: Errors,
    /// Relative errors of absorption.
    pub sigma_a: Errors,
    /// Differences of asymmetry.
    pub asymmetry: Errors,
    /// Wavelengths at which nothing is held.
    pub unseen: usize,
}

impl Loss {
    /// Of what is held of a subject.
    pub fn new(subject: &Subject, held: &Held) -> Self {
        let reduced: Vec<f64> = held.sigma_s.iter().zip(&held.asymmetry).map(|(s, g)| s * (1.0 - g)).collect();
        Self {
            reduced: Errors::relative(&reduced, &subject.reduced()),
            sigma_s: Errors::relative(&held.sigma_s, &subject.sigma_s),
            sigma_a: Errors::relative(&held.sigma_a, &subject.sigma_a),
            asymmetry: Errors::of(held.asymmetry.iter().zip(&subject.asymmetry).map(|(held, truth)| held - truth)),
            unseen: held.sigma_s.iter().filter(|s| s.is_nan()).count(),
        }
    }

    /// A line for each quantity.
    pub fn lines(&self) -> Vec<String> {
        let percent = |name: &str, e: Errors| {
            format!("error of {name}: at most {} %, rms {} %", short(100.0 * e.largest), short(100.0 * e.rms))
        };
        let mut lines = vec![
            percent("sigma_s' = sigma_s (1 - g)", self.reduced),
            percent("sigma_s", self.sigma_s),
            percent("sigma_a", self.sigma_a),
            format!("error of g: at most {}, rms {}", short(self.asymmetry.largest), short(self.asymmetry.rms)),
        ];
        if self.unseen > 0 {
            lines.push(format!("{} of the wavelengths are in no channel and count nowhere", self.unseen));
        }
        lines
    }
}

/// An error as it is read.
fn short(error: f64) -> String {
    significant(error, 3)
}

/// What became of the phase function.
#[derive(Debug, Clone, PartialEq)]
pub struct PhaseLoss {
    /// In which form it is held.
    pub form: String,
    /// Share of the scattered light, 0 to 1, that goes elsewhere than it should at the wavelength of the function; none
    /// where only the mean cosine is held.
    pub total_variation: Option<f64>,
    /// Relative error of `1 - g` at that wavelength.
    pub one_minus_asymmetry: Option<f64>,
}

impl PhaseLoss {
    /// Where only the mean cosine is held.
    pub(super) fn henyey_greenstein(g: f64) -> Self {
        let form =
            if g == 0.0 { "isotropic".to_owned() } else { format!("Henyey-Greenstein, g = {}", significant(g, 6)) };
        Self { form, total_variation: None, one_minus_asymmetry: None }
    }

    /// A line.
    pub fn line(&self) -> String {
        let mut line = format!("phase function: {}", self.form);
        if let Some(share) = self.total_variation {
            line += &format!("; {} % of the scattered light goes elsewhere", short(100.0 * share));
        }
        if let Some(error) = self.one_minus_asymmetry {
            line += &format!("; 1 - g is off by {} %", short(100.0 * error));
        }
        line
    }
}
