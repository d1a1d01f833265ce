//! Expansion of scattering matrices in Legendre polynomials and generalised spherical functions.
//!
//! Products of two amplitudes are polynomials in `mu` of a degree twice the order of the series, and times any function of
//! the expansion, with the roots that come in pairs, still polynomials. Gauss-Legendre quadrature with as many nodes as
//! the degree asks for integrates them without error but rounding: no table over angle comes between.

use std::f64::consts::PI;

use super::MieError;
use super::amplitude::{Directions, Mueller};
use super::coefficients::Coefficients;
use crate::integrate::gauss_legendre;

/// Expansion coefficients of a normalised scattering matrix, degree by degree from 0, in the signs of `derooij1984` (the
/// matrix has `a1 = 4 pi p11`, `a2 = a1`, `a3 = 4 pi p33`, `a4 = a3`, `b1 = 4 pi p12`, `b2 = 4 pi p34`).
#[derive(Debug, Clone, PartialEq)]
pub struct Expansion {
    /// Of `a1` in `P_l`: `2l + 1` times the Legendre moment of the phase function; 1 at degree 0.
    pub alpha1: Vec<f64>,
    /// With `alpha3`, of `a2 + a3` in `P^l_22` and of `a2 - a3` in `P^l_2-2`: `alpha2 + alpha3` and `alpha2 - alpha3`.
    pub alpha2: Vec<f64>,
    /// See `alpha2`.
    pub alpha3: Vec<f64>,
    /// Of `a4` in `P_l`.
    pub alpha4: Vec<f64>,
    /// Of `b1` in `P^l_02`.
    pub beta1: Vec<f64>,
    /// Of `b2` in `P^l_02`.
    pub beta2: Vec<f64>,
}

impl Coefficients {
    /// Legendre moments of the phase function, `<P_l(cos theta)>` for `l` from 0, as many as there are: twice the number of
    /// terms and one. The first is 1, the second the asymmetry. The work grows with the square of the size parameter.
    ///
    /// # Errors
    /// As for [`Coefficients::amplitudes`].
    pub fn legendre_moments(&self) -> Result<Vec<f64>, MieError> {
        let (nodes, matrices) = self.at_nodes()?;
        let mut moments = vec![0.0; nodes.len()];
        for ((mu, weight), matrix) in nodes.iter().zip(&matrices) {
            let mut function = Generalised::new(0, 0, *mu);
            for moment in &mut moments {
                *moment += 2.0 * PI * weight * matrix.p11 * function.next();
            }
        }
        Ok(moments)
    }

    /// Expansion of the scattering matrix, for polarised transfer; as many degrees as [`Self::legendre_moments`] gives.
    ///
    /// # Errors
    /// As for [`Coefficients::amplitudes`].
    pub fn expansion(&self) -> Result<Expansion, MieError> {
        let (nodes, matrices) = self.at_nodes()?;
        let zero = vec![0.0; nodes.len()];
        let (mut plus, mut minus) = (zero.clone(), zero.clone());
        let (mut alpha1, mut alpha4, mut beta1, mut beta2) = (zero.clone(), zero.clone(), zero.clone(), zero);
        for ((mu, weight), Mueller { p11, p12, p33, p34 }) in nodes.iter().zip(&matrices) {
            let mut functions = [(0, 0), (2, 2), (2, -2), (0, 2)].map(|(m, n)| Generalised::new(m, n, *mu));
            for l in 0..nodes.len() {
                let [p00, p22, p2m2, p02] = functions.each_mut().map(Generalised::next);
                // (2l + 1)/2 of the integral of 4 pi p
                let scale = 2.0 * PI * weight * (2 * l + 1) as f64;
                alpha1[l] += scale * p11 * p00;
                alpha4[l] += scale * p33 * p00;
                plus[l] += scale * (p11 + p33) * p22;
                minus[l] += scale * (p11 - p33) * p2m2;
                beta1[l] += scale * p12 * p02;
                beta2[l] += scale * p34 * p02;
            }
        }
        let half = |sign: f64| plus.iter().zip(&minus).map(|(p, m)| 0.5 * (p + sign * m)).collect();
        Ok(Expansion { alpha1, alpha2: half(1.0), alpha3: half(-1.0), alpha4, beta1, beta2 })
    }

    /// Nodes and weights that integrate every product exactly, and the scattering matrix there.
    #[allow(clippy::type_complexity)]
    fn at_nodes(&self) -> Result<(Vec<(f64, f64)>, Vec<Mueller>), MieError> {
        let mut nodes = gauss_legendre(2 * self.terms().len() + 1);
        let matrices = self.mueller(&Directions::new(nodes.iter().map(|(mu, _)| *mu)))?;
        // The phase function integrates to 1; what the rule makes of it is off by the rounding of many weights.
        let whole: f64 = nodes.iter().zip(&matrices).map(|((_, weight), m)| 2.0 * PI * weight * m.p11).sum();
        if whole > 0.0 {
            nodes.iter_mut().for_each(|(_, weight)| *weight /= whole);
        }
        Ok((nodes, matrices))
    }
}

/// Generalised spherical functions `P^l_mn(mu)` of ascending degree (`hovenier1983`), 0 below `max(|m|, |n|)`.
struct Generalised {
    mu: f64,
    m: i32,
    n: i32,
    degree: i32,
    before: f64,
    here: f64,
}

impl Generalised {
    fn new(m: i32, n: i32, mu: f64) -> Self {
        Self { mu, m, n, degree: 0, before: 0.0, here: 0.0 }
    }

    /// The value at the degree reached, and on to the next.
    fn next(&mut self) -> f64 {
        let Self { mu, m, n, degree, .. } = *self;
        let lowest = m.abs().max(n.abs());
        if degree == lowest {
            self.before = 0.0;
            self.here = match (m, n) {
                (0, 0) => 1.0,
                (2, 2) => 0.25 * (1.0 + mu) * (1.0 + mu),
                (2, -2) => 0.25 * (1.0 - mu) * (1.0 - mu),
                _ => -0.25 * 6f64.sqrt() * (1.0 - mu) * (1.0 + mu),
            };
        }
        let value = self.here;
        self.degree += 1;
        if degree >= lowest {
            let (l, m, n) = (f64::from(degree), f64::from(m), f64::from(n));
            let root = |l: f64| ((l * l - m * m) * (l * l - n * n)).sqrt();
            let above = if degree == 0 {
                mu
            } else {
                ((2.0 * l + 1.0) * (l * (l + 1.0) * mu - m * n) * self.here - (l + 1.0) * root(l) * self.before)
                    / (l * root(l + 1.0))
            };
            (self.before, self.here) = (self.here, above);
        }
        value
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::super::{PlaneWave, Sphere};
    use super::*;

    fn coefficients(x: f64, re: f64, im: f64) -> Coefficients {
        let wave = PlaneWave::new(2.0 * PI, Complex64::new(1.0, 0.0)).unwrap();
        Sphere::new(wave, x, Complex64::new(re, im)).unwrap().coefficients()
    }

    /// The expansion of Rayleigh scattering is known in closed form (`derooij1984`).
    #[test]
    fn rayleigh_has_four_degrees_less_one() {
        let e = coefficients(1e-4, 1.5, 0.0).expansion().unwrap();
        let beta = 6f64.sqrt() / 2.0;
        let expected = [
            (&e.alpha1, [1.0, 0.0, 0.5]),
            (&e.alpha2, [0.0, 0.0, 3.0]),
            (&e.alpha3, [0.0; 3]),
            (&e.alpha4, [0.0, 1.5, 0.0]),
            (&e.beta1, [0.0, 0.0, beta]),
            (&e.beta2, [0.0; 3]),
        ];
        for (found, expected) in expected {
            for l in 0..3 {
                assert!((found[l] - expected[l]).abs() < 1e-7, "{l}: {} {}", found[l], expected[l]);
            }
            assert!(found[3..].iter().all(|v| v.abs() < 1e-7));
        }
    }

    #[test]
    fn the_first_moments_are_one_and_the_asymmetry() {
        for (x, re, im) in [(0.1, 1.5, 0.0), (5.0, 1.33, 0.01), (60.0, 1.5, 0.0), (300.0, 1.33, 1e-5)] {
            let c = coefficients(x, re, im);
            let (moments, g) = (c.legendre_moments().unwrap(), c.scattering().unwrap().asymmetry);
            assert!((moments[0] - 1.0).abs() < 1e-12, "{x}: {}", moments[0]);
            assert!((moments[1] - g).abs() < 1e-12, "{x}: {} {g}", moments[1]);
            assert!(moments[moments.len() - 1].abs() < 1e-10);
        }
    }

    /// The sum over degrees is the matrix again, at angles that are no nodes.
    #[test]
    fn the_expansion_adds_up_to_the_matrix() {
        let c = coefficients(12.0, 1.5, 0.02);
        let e = c.expansion().unwrap();
        let directions = Directions::new([1.0, 0.93, 0.2, -0.5, -0.999]);
        for (mu, matrix) in directions.cosines().iter().zip(c.mueller(&directions).unwrap()) {
            let mut functions = [(0, 0), (2, 2), (2, -2), (0, 2)].map(|(m, n)| Generalised::new(m, n, *mu));
            let (mut a1, mut plus, mut minus, mut a4, mut b1, mut b2) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
            for l in 0..e.alpha1.len() {
                let [p00, p22, p2m2, p02] = functions.each_mut().map(Generalised::next);
                a1 += e.alpha1[l] * p00;
                a4 += e.alpha4[l] * p00;
                plus += (e.alpha2[l] + e.alpha3[l]) * p22;
                minus += (e.alpha2[l] - e.alpha3[l]) * p2m2;
                b1 += e.beta1[l] * p02;
                b2 += e.beta2[l] * p02;
            }
            let found = [a1, 0.5 * (plus + minus), 0.5 * (plus - minus), a4, b1, b2];
            let expected = [matrix.p11, matrix.p11, matrix.p33, matrix.p33, matrix.p12, matrix.p34];
            for (found, expected) in found.iter().zip(expected) {
                let expected = 4.0 * PI * expected;
                assert!((found - expected).abs() < 1e-10 * (4.0 * PI * matrix.p11), "{mu}: {found} {expected}");
            }
        }
    }
}
