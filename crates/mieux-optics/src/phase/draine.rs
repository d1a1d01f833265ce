//! Draine's phase function: Henyey-Greenstein's peak times Rayleigh's `1 + alpha mu^2`.

use std::fmt;

use super::henyey_greenstein::away_at;
use super::{HenyeyGreenstein, PhaseError};

/// `HG(g) (1 + alpha mu^2) / (1 + alpha (1 + 2 g^2)/3)`: `alpha = 0` is Henyey-Greenstein, `alpha = 1` is
/// Cornette-Shanks, and with `g = 0` too it is Rayleigh.
///
/// | | |
/// |---|---|
/// | `g` | asymmetry of the Henyey-Greenstein factor, -1 < g < 1; not the mean cosine, which is [`Self::asymmetry`] |
/// | `alpha` | weight of the Rayleigh factor, finite and not negative |
///
/// Source: `draine2003`; eq 5 of `jendersie2023s`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Draine {
    lobe: HenyeyGreenstein,
    alpha: f64,
    /// Shares of 1 and of `mu^2` in the factor `constant + square mu^2` that makes the function of `HG(g)`.
    constant: f64,
    square: f64,
}

impl Draine {
    /// # Errors
    /// [`PhaseError::Asymmetry`] unless `-1 < g < 1`; [`PhaseError::Alpha`] unless `0 <= alpha < infinity`.
    pub fn new(g: f64, alpha: f64) -> Result<Self, PhaseError> {
        if !(alpha >= 0.0 && alpha.is_finite()) {
            return Err(PhaseError::Alpha { alpha });
        }
        let lobe = HenyeyGreenstein::new(g)?;
        let mean_square = (1.0 + 2.0 * g * g) / 3.0;
        // As 1/(1/alpha + ..), an alpha of any size neither overflows nor vanishes.
        let square = if alpha > 0.0 { 1.0 / (1.0 / alpha + mean_square) } else { 0.0 };
        Ok(Self { lobe, alpha, constant: 1.0 / (1.0 + alpha * mean_square), square })
    }

    /// The parameters `g` and `alpha`.
    pub fn parameters(&self) -> (f64, f64) {
        (self.lobe.asymmetry(), self.alpha)
    }

    /// Value in 1/sr at the scattering cosine `mu` in [-1, 1]. Also the density of [`Self::sample`] per solid angle.
    pub fn value(&self, mu: f64) -> f64 {
        self.lobe.value(mu) * (self.constant + self.square * mu * mu)
    }

    /// Scattering cosine in [-1, 1] for a uniform `xi` in [0, 1]: the exact inverse of the cumulative distribution,
    /// rising from -1 to 1.
    ///
    /// This is the root of the quartic of `jendersie2023s` (eq 6), which divides by `g` and `alpha`. With
    /// `e = 1 - z`, `mu = z + g (1 - z^2)/2` (their `v` is `1 - g z`) the quartic needs no division, and written in the
    /// Henyey-Greenstein survival `u = (1 + g) e / (2 (1 - g + g e))` its slope is `constant + square mu^2`: a root
    /// that Halley's method, held in a bracket, finds to rounding for every parameter.
    pub fn sample(&self, xi: f64) -> f64 {
        if xi.is_nan() {
            return xi;
        }
        let g = self.lobe.asymmetry().abs();
        let backward = self.lobe.asymmetry() < 0.0;
        let wanted = if backward { xi } else { 1.0 - xi }.clamp(0.0, 1.0);
        let (mut low, mut high) = (0.0, 1.0);
        let mut u = wanted;
        for _ in 0..100 {
            let point = self.survival(g, u);
            let excess = point.survival - wanted;
            if excess > 0.0 {
                high = u;
            } else {
                low = u;
            }
            let slope = point.slope;
            let halley = u - excess * slope / (slope * slope - 0.5 * excess * point.curvature);
            let inside = halley >= low && halley <= high;
            let next = if inside { halley } else { 0.5 * (low + high) };
            let step = (next - u).abs();
            u = next;
            // Convergence is cubic: what is left of such a step is below rounding.
            if step <= if inside { 1e-7 * u } else { 1e-16 * u } {
                break;
            }
        }
        let mu = (1.0 - self.survival(g, u).away).clamp(-1.0, 1.0);
        if backward { -mu } else { mu }
    }

    /// The cumulative distribution from the peak on, for a lobe of asymmetry `g >= 0`, where that of its
    /// Henyey-Greenstein factor alone is `u`.
    #[inline]
    fn survival(&self, g: f64, u: f64) -> Point {
        let h = 1.0 - g;
        let (e, away) = away_at(g, u);
        let mu = 1.0 - away;
        let v = h + g * e;
        let squares = 1.0 - h * e * (1.0 - e * (h / 3.0 + g * e / 12.0));
        Point {
            survival: u * (self.constant + self.square * squares),
            slope: self.constant + self.square * mu * mu,
            // d mu / d u is -2 v^3 / (1 - g^2).
            curvature: -4.0 * self.square * mu * v * v * v / (h * (1.0 + g)),
            away,
        }
    }

    /// Mean cosine, `g (1 + alpha (3 + 2 g^2)/5) / (1 + alpha (1 + 2 g^2)/3)`.
    pub fn asymmetry(&self) -> f64 {
        let g = self.lobe.asymmetry();
        g * (self.constant + self.square * (3.0 + 2.0 * g * g) / 5.0)
    }

    /// Moment of the Legendre polynomial of the given degree, in closed form: `mu^2 P_l` is a sum of `P_{l-2}`, `P_l`
    /// and `P_{l+2}`, whose moments over the Henyey-Greenstein factor are powers of `g`.
    pub fn legendre_moment(&self, degree: u32) -> f64 {
        let l = f64::from(degree);
        let power = |degree: u32| self.lobe.legendre_moment(degree);
        let above = (l + 1.0) * (l + 2.0) / ((2.0 * l + 1.0) * (2.0 * l + 3.0)) * power(degree.saturating_add(2));
        let here = ((l + 1.0).powi(2) / (2.0 * l + 3.0) + l * l / (2.0 * l - 1.0)) / (2.0 * l + 1.0) * power(degree);
        let below =
            if degree < 2 { 0.0 } else { l * (l - 1.0) / ((2.0 * l + 1.0) * (2.0 * l - 1.0)) * power(degree - 2) };
        self.constant * power(degree) + self.square * (above + here + below)
    }
}

/// A point of a cumulative distribution, its derivatives, and `1 - mu` there.
struct Point {
    survival: f64,
    slope: f64,
    curvature: f64,
    away: f64,
}

impl fmt::Display for Draine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (g, alpha) = self.parameters();
        write!(f, "Draine (g = {g}, alpha = {alpha})")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phase::{Rayleigh, testing};

    const G: [f64; 8] = [-0.999, -0.5, -1e-9, 0.0, 1e-3, 0.5, 0.95, 0.999];
    const ALPHA: [f64; 5] = [0.0, 1e-6, 1.0, 30.0, 1000.0];

    #[test]
    fn is_a_phase_function_at_its_corners() {
        for g in G {
            for alpha in ALPHA {
                let phase = Draine::new(g, alpha).unwrap().into();
                testing::check(&phase);
                testing::check_inverse(&phase, &[]);
            }
        }
    }

    /// Equation 6 of jendersie2023s as printed.
    fn as_printed(g: f64, a: f64, xi: f64) -> f64 {
        let (g2, g4) = (g * g, g.powi(4));
        let t0 = a - a * g2;
        let t1 = a * g4 - a;
        let t2 = -3.0 * (4.0 * (g4 - g2) + t1 * (1.0 + g2));
        let t3 = g * (2.0 * xi - 1.0);
        let t4 = 3.0 * g2 * (1.0 + t3) + a * (2.0 + g2 * (1.0 + (1.0 + 2.0 * g2) * t3));
        let t5 = t0 * (t1 * t2 + t4 * t4) + t1.powi(3);
        let t6 = t0 * 4.0 * (g4 - g2);
        let t7 = (t5 + (t5 * t5 - t6.powi(3)).sqrt()).cbrt();
        let t8 = 2.0 * (t1 + t6 / t7 + t7) / t0;
        let t9 = (6.0 * (1.0 + g2) + t8).sqrt();
        let root = (6.0 * (1.0 + g2) - t8 + 8.0 * t4 / (t0 * t9)).sqrt() - t9;
        0.5 * g + (0.5 / g - root * root / (8.0 * g))
    }

    #[test]
    fn the_sample_is_the_published_root_where_that_one_keeps_its_digits() {
        for (g, alpha) in [(0.3, 1.0), (0.5, 10.0), (0.8, 30.0), (0.9, 1.0), (0.5, 250.0), (-0.6, 5.0)] {
            let phase = Draine::new(g, alpha).unwrap();
            for i in 1..200 {
                let xi = f64::from(i) / 200.0;
                let (ours, printed) = (phase.sample(xi), as_printed(g, alpha, xi));
                assert!((ours - printed).abs() < 2e-9, "g {g} alpha {alpha} xi {xi}: {ours} {printed}");
            }
        }
    }

    #[test]
    fn its_limits_are_the_older_functions() {
        for i in 0..=200 {
            let (xi, mu) = (f64::from(i) / 200.0, f64::from(i) / 100.0 - 1.0);
            for g in G {
                let (draine, hg) = (Draine::new(g, 0.0).unwrap(), HenyeyGreenstein::new(g).unwrap());
                assert_eq!(draine.value(mu), hg.value(mu));
                assert!((draine.sample(xi) - hg.sample(xi)).abs() < 4e-16, "g {g} xi {xi}");
            }
            let rayleigh = Draine::new(0.0, 1.0).unwrap();
            assert!((rayleigh.value(mu) / Rayleigh.value(mu) - 1.0).abs() < 1e-15);
            assert!((rayleigh.sample(xi) - Rayleigh.sample(xi)).abs() < 1e-15, "xi {xi}");
        }
    }

    #[test]
    fn the_mean_cosine_is_the_first_moment() {
        for g in G {
            for alpha in ALPHA {
                let phase = Draine::new(g, alpha).unwrap();
                let printed = g * (1.0 + alpha * (3.0 + 2.0 * g * g) / 5.0) / (1.0 + alpha * (1.0 + 2.0 * g * g) / 3.0);
                assert!((phase.asymmetry() - printed).abs() < 1e-15);
                assert!((phase.legendre_moment(1) - printed).abs() < 1e-15);
                assert!((phase.legendre_moment(0) - 1.0).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn parameters_out_of_range_are_refused() {
        for alpha in [-1e-3, f64::NAN, f64::INFINITY] {
            assert!(matches!(Draine::new(0.5, alpha), Err(PhaseError::Alpha { .. })));
        }
        assert_eq!(Draine::new(1.0, 1.0), Err(PhaseError::Asymmetry { g: 1.0 }));
        assert!(Draine::new(0.5, 1e308).unwrap().value(1.0).is_finite());
    }
}
