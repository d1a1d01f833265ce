//! Fournier and Forand: particles suspended in sea water, their sizes distributed as a power law.

use std::f64::consts::PI;
use std::fmt;

use super::{PhaseError, quadrature};

/// Width in `1 - mu` of the cap that stands for the infinite peak: 15 urad. Where `mu` still tells
/// directions apart, to a millionth.
const CAP: f64 = 1.0 / (1u64 << 33) as f64;

/// The phase function of spheres of relative refractive index `n` in anomalous diffraction, whose sizes follow
/// Junge's power law of slope `mu_J`.
///
/// | | |
/// |---|---|
/// | `refractive_index` | of the particles relative to water, above 1 and at most 2 (1.05 to 1.2 in the sea) |
/// | `junge_slope` | exponent of the size distribution, strictly between 3 and 5 (3.5 to 4 in the sea) |
///
/// The published form integrates to 1 analytically, but is infinite at exactly forward, as no real sea is. Within
/// 15 urad of forward a constant with the same integral stands for it here, so that the function is finite
/// everywhere and still integrates to 1. It is sampled by inverting the published cumulative numerically, to rounding.
///
/// Source: `fournier1994`, in the form of `fournier1999` as `mobley2002` print it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FournierForand {
    refractive_index: f64,
    junge_slope: f64,
    /// `(3 - mu_J)/2`, in (-1, 0).
    nu: f64,
    /// `delta / sin^2(theta/2)`.
    scale: f64,
    /// Coefficient of the term `3 mu^2 - 1`, 1/sr.
    quadrupole: f64,
    /// Share of the light inside the cap.
    cap: f64,
    /// Logarithm of the backward value times `4 pi sr`.
    backward: f64,
    asymmetry: f64,
}

impl FournierForand {
    /// # Errors
    /// [`PhaseError::RefractiveIndex`] unless `1 < refractive_index <= 2`; [`PhaseError::JungeSlope`] unless
    /// `3 < junge_slope < 5`.
    pub fn new(refractive_index: f64, junge_slope: f64) -> Result<Self, PhaseError> {
        let mut phase = Self::without_asymmetry(refractive_index, junge_slope)?;
        phase.asymmetry = phase.legendre_moment(1);
        Ok(phase)
    }

    fn without_asymmetry(refractive_index: f64, junge_slope: f64) -> Result<Self, PhaseError> {
        if !(refractive_index > 1.0 && refractive_index <= 2.0) {
            return Err(PhaseError::RefractiveIndex { refractive_index });
        }
        if !(junge_slope > 3.0 && junge_slope < 5.0) {
            return Err(PhaseError::JungeSlope { slope: junge_slope });
        }
        let nu = 0.5 * (3.0 - junge_slope);
        let scale = 4.0 / (3.0 * (refractive_index - 1.0).powi(2));
        let first = slope(scale, (nu * scale.ln()).exp_m1(), nu);
        let quadrupole = -first / (16.0 * PI * scale.powf(nu));
        let (cap, backward, asymmetry) = (0.0, 0.0, f64::NAN);
        let mut phase = Self { refractive_index, junge_slope, nu, scale, quadrupole, cap, backward, asymmetry };
        phase.cap = phase.published_cumulative(CAP);
        phase.backward = (4.0 * PI * phase.value_away(2.0)).ln();
        Ok(phase)
    }

    /// From the share of light scattered by more than 90 degrees, as oceanographers measure it, by solving for the
    /// Junge slope.
    ///
    /// # Errors
    /// [`PhaseError::RefractiveIndex`] as [`Self::new`]; [`PhaseError::BackscatterFraction`] for a share that no slope
    /// gives (those attainable lie between 0 and 1/2).
    pub fn from_backscatter(refractive_index: f64, fraction: f64) -> Result<Self, PhaseError> {
        let fraction_of =
            |slope| Self::without_asymmetry(refractive_index, slope).map(|phase| phase.backscatter_fraction());
        let (mut low, mut high) = (3.0 + 1e-9, 5.0 - 1e-9);
        if !(fraction >= fraction_of(low)? && fraction <= fraction_of(high)?) {
            return Err(PhaseError::BackscatterFraction { fraction });
        }
        // The fraction rises with the slope; halving needs no derivative and ends at rounding.
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if fraction_of(middle)? < fraction {
                low = middle;
            } else {
                high = middle;
            }
        }
        Self::new(refractive_index, 0.5 * (low + high))
    }

    /// Refractive index relative to water, and slope of the size distribution.
    pub fn parameters(&self) -> (f64, f64) {
        (self.refractive_index, self.junge_slope)
    }

    /// Share of the light scattered by more than 90 degrees.
    pub fn backscatter_fraction(&self) -> f64 {
        1.0 - self.published_cumulative(1.0)
    }

    /// Value in 1/sr at the scattering cosine `mu` in [-1, 1]. Also the density of [`Self::sample`] per solid angle.
    pub fn value(&self, mu: f64) -> f64 {
        self.value_away(1.0 - mu)
    }

    /// The value at `1 - mu`.
    pub(super) fn value_away(&self, away: f64) -> f64 {
        if away < CAP {
            return self.cap / (2.0 * PI * CAP);
        }
        self.published(away).1
    }

    /// Share of the light scattered closer to forward than `away = 1 - mu`, cap or no cap.
    fn published_cumulative(&self, away: f64) -> f64 {
        self.published(away).0
    }

    /// The published cumulative and value, with their zeros at `delta = 1` divided out.
    fn published(&self, away: f64) -> (f64, f64) {
        let half = 0.5 * away;
        let delta = self.scale * half;
        let log = delta.ln();
        let power = (self.nu * log).exp();
        let first = slope(delta, (self.nu * log).exp_m1(), self.nu);
        // Close to 1 the power loses what the exponential keeps.
        let next = if log.abs() > 0.5 { delta * power - 1.0 } else { ((self.nu + 1.0) * log).exp_m1() };
        let above = slope(delta, next, self.nu + 1.0);
        let second = curvature(self.nu, delta, first);
        let mu = 1.0 - away;
        let cumulative = (above - first * half) / power + 2.0 * PI * self.quadrupole * mu * away * (2.0 - away);
        let value = (second - (second + first) / half) / (4.0 * PI * power) + self.quadrupole * (3.0 * mu * mu - 1.0);
        (cumulative, value)
    }

    /// Scattering cosine in [-1, 1] for a uniform `xi` in [0, 1], rising from -1 to 1: the cumulative distribution
    /// inverted to rounding, by Newton's method held in a bracket.
    pub fn sample(&self, xi: f64) -> f64 {
        if xi.is_nan() {
            return xi;
        }
        let wanted = (1.0 - xi).clamp(0.0, 1.0);
        if wanted <= self.cap {
            return 1.0 - CAP * wanted / self.cap;
        }
        if xi <= 0.0 {
            return -1.0;
        }
        // The cumulative's log odds against the log odds of `away` in [0, 2] is a gently bent line.
        let odds = (wanted / xi).ln();
        let (mut low, mut high) = (log_odds(CAP), 40.0);
        let mut x = self.first_guess(odds, low).clamp(low, high);
        for _ in 0..100 {
            let away = 2.0 / (1.0 + (-x).exp());
            let (below, value) = self.published(away);
            let above = (1.0 - below).max(f64::MIN_POSITIVE);
            let excess = (below / above).ln() - odds;
            if excess > 0.0 {
                high = x;
            } else {
                low = x;
            }
            let slope = PI * value * away * (2.0 - away) / (below * above);
            let newton = x - excess / slope;
            let inside = newton >= low && newton <= high;
            let next = if inside { newton } else { 0.5 * (low + high) };
            let step = (next - x).abs();
            x = next;
            // Convergence is quadratic: what is left of such a step is below rounding.
            if step <= if inside { 1e-7 } else { 1e-14 } {
                break;
            }
        }
        (1.0 - 2.0 / (1.0 + (-x).exp())).clamp(-1.0, 1.0)
    }

    /// Where the two asymptotes of the log odds, the peak's power law and the flat backward side, have the wanted ones.
    fn first_guess(&self, odds: f64, start: f64) -> f64 {
        let peak = start + (odds - (self.cap / (1.0 - self.cap)).ln()) / -self.nu;
        peak.min(odds + self.backward)
    }

    /// Mean cosine, by quadrature to rounding.
    pub fn asymmetry(&self) -> f64 {
        self.asymmetry
    }

    /// Moment of the Legendre polynomial of the given degree, by quadrature to rounding; the time grows with the
    /// square of the degree.
    pub fn legendre_moment(&self, degree: u32) -> f64 {
        quadrature::moment(&quadrature::graded_edges(), degree, |_, away| self.value_away(away))
    }
}

/// Of a part of the range [0, 2].
fn log_odds(away: f64) -> f64 {
    (away / (2.0 - away)).ln()
}

/// `(delta^nu - 1)/(delta - 1)` given its numerator, finite at 1.
fn slope(delta: f64, numerator: f64, nu: f64) -> f64 {
    if delta == 1.0 { nu } else { numerator / (delta - 1.0) }
}

/// `(delta^nu - 1 - nu (delta - 1))/(delta - 1)^2` given [`slope`]; near 1, where that cancels, a binomial series.
fn curvature(nu: f64, delta: f64, slope: f64) -> f64 {
    let d = delta - 1.0;
    if d.abs() > 0.1 {
        return (slope - nu) / d;
    }
    let mut term = 0.5 * nu * (nu - 1.0);
    let mut sum = term;
    for k in 3..24 {
        term *= (nu - f64::from(k) + 1.0) / f64::from(k) * d;
        sum += term;
    }
    sum
}

impl fmt::Display for FournierForand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Fournier-Forand (n = {}, Junge slope = {})", self.refractive_index, self.junge_slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phase::testing;

    const CORNERS: [(f64, f64); 8] = [
        (1.1, 3.5835),
        (1.001, 3.2),
        (1.05, 3.01),
        (1.2, 4.9),
        (2.0, 4.0),
        (1.34, 3.001),
        (1.0001, 4.999),
        (1.0 + 1e-9, 4.0),
    ];

    #[test]
    fn is_a_phase_function_at_its_corners() {
        for (n, slope) in CORNERS {
            let phase = FournierForand::new(n, slope).unwrap();
            testing::check(&phase.into());
            testing::check_inverse(&phase.into(), &[1.0 - phase.cap]);
        }
    }

    /// The form of mobley2002 as printed, away from the angle where it is 0/0.
    #[test]
    fn has_the_printed_value() {
        let (n, slope): (f64, f64) = (1.1, 3.5835);
        let phase = FournierForand::new(n, slope).unwrap();
        let nu = 0.5 * (3.0 - slope);
        let delta_of = |theta: f64| 4.0 / (3.0 * (n - 1.0).powi(2)) * (0.5 * theta).sin().powi(2);
        for theta in [0.001, 0.02, 0.1, 0.3, 1.0, 2.0, 3.1] {
            let (d, d180) = (delta_of(theta), delta_of(PI));
            let (s2, mu) = ((0.5 * theta).sin().powi(2), theta.cos());
            let bracket = nu * (1.0 - d) - (1.0 - d.powf(nu)) + (d * (1.0 - d.powf(nu)) - nu * (1.0 - d)) / s2;
            let printed = bracket / (4.0 * PI * (1.0 - d).powi(2) * d.powf(nu))
                + (1.0 - d180.powf(nu)) / (16.0 * PI * (d180 - 1.0) * d180.powf(nu)) * (3.0 * mu * mu - 1.0);
            assert!((phase.value(mu) / printed - 1.0).abs() < 1e-9, "{theta}: {} {printed}", phase.value(mu));
        }
    }

    #[test]
    fn is_smooth_where_the_printed_form_is_zero_over_zero() {
        let phase = FournierForand::new(1.1, 3.5835).unwrap();
        let pole = 2.0 / phase.scale;
        for step in [1e-12, 1e-9, 1e-4, 0.0999, 0.1001] {
            let (below, at, above) =
                (phase.value_away(pole * (1.0 - step)), phase.value_away(pole), phase.value_away(pole * (1.0 + step)));
            assert!(below >= at && at >= above, "{step}: {below} {at} {above}");
            assert!((0.5 * (below + above) / at - 1.0).abs() < 4.0 * step * step + 1e-14, "{step}");
        }
    }

    /// The classic match: n = 1.10, slope 3.5835 has the backscatter fraction 0.0183 of Petzold's average harbour
    /// water (mobley2002).
    #[test]
    fn the_backscatter_fraction_is_the_published_one_and_can_be_asked_for() {
        let phase = FournierForand::new(1.1, 3.5835).unwrap();
        assert!((phase.backscatter_fraction() - 0.0183).abs() < 5e-5, "{}", phase.backscatter_fraction());
        // Table 1 of mobley2021, whose n - 1 is rounded to a few percent.
        for (n, slope, fraction) in [
            (1.021, 3.0742, 0.0001),
            (1.04, 3.201, 0.001),
            (1.08, 3.483, 0.01),
            (1.175, 4.065, 0.1),
            (1.15, 4.874, 0.4),
        ] {
            let ours = FournierForand::new(n, slope).unwrap().backscatter_fraction();
            assert!((ours / fraction - 1.0).abs() < 0.04, "{n} {slope}: {ours}");
        }
        for (n, fraction) in [(1.1, 0.0183), (1.05, 0.001), (1.2, 0.4), (1.15, 0.0005)] {
            let phase = FournierForand::from_backscatter(n, fraction).unwrap();
            assert!((phase.backscatter_fraction() - fraction).abs() < 1e-10);
            let edges: Vec<f64> = quadrature::graded_edges().into_iter().filter(|&a| a >= 1.0).collect();
            let mut backward = 0.0;
            quadrature::visit(&edges, 0, |_, away, weight| backward += weight * phase.value_away(away));
            assert!((backward - fraction).abs() < 1e-10, "{backward}");
        }
    }

    /// Against Petzold's measurement of turbid harbour water (`petzold1972`), of which the function with the same share
    /// of backscatter must be a likeness at every angle.
    #[test]
    fn looks_like_the_sea() {
        let folder = std::env::var("MIEUX_SHARED")
            .unwrap_or_else(|_| concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared").to_owned());
        let text = match std::fs::read_to_string(format!("{folder}/data/optics/petzold_sd_harbor_cdf.csv")) {
            Ok(text) => text,
            Err(error) => {
                assert!(std::env::var("MIEUX_REQUIRE_SHARED").is_err(), "{error}");
                return;
            }
        };
        let mut largest = 0.0f64;
        let mut rows = 0;
        let phase = FournierForand::from_backscatter(1.1, 0.0183).unwrap();
        for line in text.lines().skip(1) {
            let numbers: Vec<f64> = line.split(',').map(|n| n.parse().unwrap()).collect();
            let (measured, ours) = (numbers[1], phase.published_cumulative(quadrature::away_of(numbers[0])));
            largest = largest.max((measured - ours).abs());
            rows += 1;
        }
        assert!(rows > 50 && largest < 0.03, "{rows} rows, off by {largest}");
    }

    #[test]
    fn parameters_out_of_range_are_refused() {
        for n in [1.0, 0.9, 2.1, f64::NAN, f64::INFINITY] {
            assert!(matches!(FournierForand::new(n, 3.5), Err(PhaseError::RefractiveIndex { .. })), "{n}");
            assert!(FournierForand::from_backscatter(n, 0.02).is_err());
        }
        for slope in [3.0, 5.0, f64::NAN] {
            assert!(matches!(FournierForand::new(1.1, slope), Err(PhaseError::JungeSlope { .. })), "{slope}");
        }
        for fraction in [0.0, -0.1, 0.6, f64::NAN] {
            let refused = FournierForand::from_backscatter(1.1, fraction);
            assert!(matches!(refused, Err(PhaseError::BackscatterFraction { .. })), "{fraction}");
        }
    }
}
