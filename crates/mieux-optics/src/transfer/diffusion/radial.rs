//! Profiles over the distance: their integral over the surface, and samples from them.

use std::convert::Infallible;
use std::f64::consts::{PI, TAU};

use crate::integrate::integrate;
use crate::transfer::TransferError;

/// The integral over the surface of a profile that changes over lengths from about a hundredth of `length` (m) up, and falls
/// as the third power of the distance and, if `sigma` (1/m) is not 0, as `exp(-sigma r)`; to 1e-10.
pub(super) fn area_integral(profile: impl Fn(f64) -> f64, length: f64, sigma: f64) -> f64 {
    let far = if sigma * length > 1e-12 { (60.0 / sigma).max(length) } else { 1e13 * length };
    let near = 1e-12 * length;
    // Over the logarithm of the distance, a decade at a time.
    let decades = (far / near).log10().ceil();
    let knots: Vec<f64> = (0..=decades as u32).map(|k| (f64::from(k) / decades) * (far / near).ln()).collect();
    let found = integrate(&knots, 1e-10, [1e-200], |y| {
        let r = near * y.exp();
        Ok::<_, Infallible>([TAU * r * r * profile(r)])
    });
    match found {
        Ok(found) => found.map_or(f64::NAN, |integral| integral.value[0]),
        Err(never) => match never {},
    }
}

/// Samples of the distance from nearly a given profile, with the density that they have exactly: between the knots of a
/// table the density is a power of the distance, and so are its integrals; beyond the last it falls as the third power.
#[derive(Debug, Clone, PartialEq)]
pub struct RadialSampler {
    /// Distances, m, from above 0.
    knots: Vec<f64>,
    /// Per area at the knots, 1/m^2.
    densities: Vec<f64>,
    /// Exponents from each knot to the next.
    exponents: Vec<f64>,
    /// Chance of a distance below each knot.
    below: Vec<f64>,
}

/// Knots per factor of ten, and how many tens the table spans below and above its unit of length.
const PER_DECADE: f64 = 80.0;
const BELOW: f64 = 1e-4;
const ABOVE: f64 = 1e4;

impl RadialSampler {
    /// For a profile (1/m^2 over m, positive near `length`), in a table over distances from 1e-4 to 1e4 times `length` (m, the
    /// transport mean free path) or to where the profile has sunk out of sight.
    ///
    /// # Errors
    /// [`TransferError::Dark`] if the profile is 0.
    pub fn new(profile: impl Fn(f64) -> f64, length: f64) -> Result<Self, TransferError> {
        let (mut knots, mut densities, mut peak) = (Vec::new(), Vec::new(), 0f64);
        let count = (PER_DECADE * (ABOVE / BELOW).log10()) as u32;
        for k in 0..=count {
            let r = length * BELOW * 10f64.powf(f64::from(k) / PER_DECADE);
            let value = profile(r);
            let counts = value * r * r;
            if !(value > 0.0 && value.is_finite()) || counts < 1e-14 * peak {
                if peak > 0.0 {
                    break;
                }
                continue;
            }
            peak = peak.max(counts);
            knots.push(r);
            densities.push(value);
        }
        if knots.len() < 2 {
            return Err(TransferError::Dark);
        }
        let last = knots.len() - 1;
        let mut exponents: Vec<f64> =
            (0..last).map(|k| (densities[k + 1] / densities[k]).ln() / (knots[k + 1] / knots[k]).ln()).collect();
        exponents.push(-3.0);
        let mut below = Vec::with_capacity(knots.len());
        let mut sum = PI * knots[0] * knots[0] * densities[0];
        below.push(sum);
        for k in 0..last {
            sum += shell(knots[k], densities[k], exponents[k], knots[k + 1] / knots[k]);
            below.push(sum);
        }
        sum += TAU * densities[last] * knots[last] * knots[last];
        densities.iter_mut().for_each(|density| *density /= sum);
        below.iter_mut().for_each(|chance| *chance /= sum);
        Ok(Self { knots, densities, exponents, below })
    }

    /// A distance, m, for a uniform number in [0, 1).
    pub fn sample(&self, xi: f64) -> f64 {
        let k = self.below.partition_point(|below| *below <= xi);
        if k == 0 {
            return self.knots[0] * (xi.max(0.0) / self.below[0]).sqrt();
        }
        let k = k - 1;
        let (r, power) = (self.knots[k], self.exponents[k] + 2.0);
        let part = (xi - self.below[k]) / (TAU * self.densities[k] * r * r);
        // part = (s^power - 1) / power for the ratio s of the distances.
        let logarithm = if (power * part).abs() < 1e-9 { part } else { (power * part).max(-1.0).ln_1p() / power };
        let end = self.knots.get(k + 1).copied().unwrap_or(1e12 * r);
        (r * logarithm.exp()).min(end)
    }

    /// The density of [`RadialSampler::sample`] per area of the surface, 1/m^2.
    pub fn density(&self, r: f64) -> f64 {
        let k = self.knots.partition_point(|knot| *knot <= r);
        if k == 0 {
            return self.densities[0];
        }
        self.densities[k - 1] * (r / self.knots[k - 1]).powf(self.exponents[k - 1])
    }
}

/// The integral over a ring of a density that is `density (r / from)^exponent`, up to `ratio` times the distance.
fn shell(from: f64, density: f64, exponent: f64, ratio: f64) -> f64 {
    let (power, logarithm) = (exponent + 2.0, ratio.ln());
    let x = power * logarithm;
    let integral = if x.abs() < 1e-12 { logarithm } else { x.exp_m1() / power };
    TAU * density * from * from * integral
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_and_an_exponential_are_integrated() {
        let found = area_integral(|r| 1.0 / (1.0 + r * r).powf(1.5), 1.0, 0.0);
        assert!((found / TAU - 1.0).abs() < 1e-9, "{found}");
        let found = area_integral(|r| (-3.0 * r).exp() / r, 0.1, 3.0);
        assert!((found / (TAU / 3.0) - 1.0).abs() < 1e-9, "{found}");
    }

    /// The share of samples below a distance is the integral of the density, and the density is nearly the profile.
    #[test]
    fn samples_have_the_density_that_is_told() {
        for sigma in [0.0, 0.3, 30.0] {
            let profile = |r: f64| (-sigma * r).exp() / (1.0 + r * r).powf(1.5);
            let sampler = RadialSampler::new(profile, 1.0).unwrap();
            let total = area_integral(profile, 1.0, sigma);
            for xi in [1e-9, 1e-4, 0.01, 0.3, 0.5, 0.9, 0.999, 0.99999] {
                let r = sampler.sample(xi);
                let inside = integrate(&[-30.0, -12.0, -9.0, -6.0, -3.0, -1.0, 0.0], 1e-9, [1e-12], |y| {
                    let s = r * y.exp();
                    Ok::<_, Infallible>([TAU * s * s * sampler.density(s)])
                });
                let inside = inside.unwrap().unwrap().value[0];
                assert!((inside - xi).abs() < 1e-8, "{sigma} {xi}: {inside}");
                if profile(r) * r * r > 1e-12 {
                    let ratio = sampler.density(r) * total / profile(r);
                    assert!((ratio - 1.0).abs() < 5e-3, "{sigma} {xi}: {ratio}");
                }
            }
        }
        assert_eq!(RadialSampler::new(|_| 0.0, 1.0), Err(TransferError::Dark));
        assert_eq!(RadialSampler::new(|_| f64::NAN, 1.0), Err(TransferError::Dark));
    }
}
