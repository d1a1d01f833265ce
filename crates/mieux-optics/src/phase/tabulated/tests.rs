use std::f64::consts::PI;

use super::*;
use crate::phase::testing::{self, Uniform};
use crate::phase::{FournierForand, HenyeyGreenstein, PhaseFunction};

/// Amplitudes of a lossless sphere by the textbook series (`bohren1983`, section 4.4 and 4.8), written for this test.
struct Sphere {
    a: Vec<(f64, f64)>,
    b: Vec<(f64, f64)>,
}

impl Sphere {
    /// Size parameter and relative refractive index, both real.
    fn new(x: f64, m: f64) -> Self {
        let last = (x + 4.05 * x.cbrt() + 8.0) as usize;
        let log_derivative = |z: f64| {
            let mut d = vec![0.0; last + 1];
            let mut next = 0.0;
            for n in (1..=(last.max(z as usize) + 60)).rev() {
                let ratio = n as f64 / z;
                // next is D_n; this makes D_{n-1}.
                next = ratio - 1.0 / (next + ratio);
                if n - 1 <= last {
                    d[n - 1] = next;
                }
            }
            d
        };
        let (inside, outside) = (log_derivative(m * x), log_derivative(x));
        let (mut psi, mut chi) = (x.sin(), (x.cos(), -x.sin()));
        let (mut a, mut b) = (Vec::new(), Vec::new());
        for n in 1..=last {
            let k = n as f64;
            let before = psi;
            // From the downward logarithmic derivative: upward recurrence of psi is unstable beyond x.
            psi = before / (k / x + outside[n]);
            let chi_n = (2.0 * k - 1.0) / x * chi.0 - chi.1;
            let (chi_before, chi_now) = (chi.0, chi_n);
            chi = (chi_now, chi.0);
            let coefficient = |factor: f64| {
                let (p, q) = (factor * psi - before, factor * chi_now - chi_before);
                // p / (p - i q)
                let size = p * p + q * q;
                (p * p / size, p * q / size)
            };
            a.push(coefficient(inside[n] / m + k / x));
            b.push(coefficient(inside[n] * m + k / x));
        }
        Self { a, b }
    }

    /// `|S1|^2 + |S2|^2`.
    fn intensity(&self, theta: f64) -> f64 {
        let mu = theta.cos();
        let (mut pi_before, mut pi_now) = (0.0, 1.0);
        let mut s = [(0.0, 0.0); 2];
        for (i, (a, b)) in self.a.iter().zip(&self.b).enumerate() {
            let n = (i + 1) as f64;
            let tau = n * mu * pi_now - (n + 1.0) * pi_before;
            let weight = (2.0 * n + 1.0) / (n * (n + 1.0));
            s[0].0 += weight * (a.0 * pi_now + b.0 * tau);
            s[0].1 += weight * (a.1 * pi_now + b.1 * tau);
            s[1].0 += weight * (a.0 * tau + b.0 * pi_now);
            s[1].1 += weight * (a.1 * tau + b.1 * pi_now);
            let next = ((2.0 * n + 1.0) * mu * pi_now - (n + 1.0) * pi_before) / n;
            (pi_before, pi_now) = (pi_now, next);
        }
        s.iter().map(|s| s.0 * s.0 + s.1 * s.1).sum()
    }

    /// Mean cosine from the coefficients alone, no angle in sight.
    fn asymmetry(&self) -> f64 {
        let product = |p: (f64, f64), q: (f64, f64)| p.0 * q.0 + p.1 * q.1;
        let (mut sum, mut efficiency) = (0.0, 0.0);
        for i in 0..self.a.len() {
            let n = (i + 1) as f64;
            efficiency += (2.0 * n + 1.0) * (product(self.a[i], self.a[i]) + product(self.b[i], self.b[i]));
            if i + 1 < self.a.len() {
                let next = product(self.a[i], self.a[i + 1]) + product(self.b[i], self.b[i + 1]);
                sum += n * (n + 2.0) / (n + 1.0) * next;
            }
            sum += (2.0 * n + 1.0) / (n * (n + 1.0)) * product(self.a[i], self.b[i]);
        }
        2.0 * sum / efficiency
    }
}

#[test]
fn the_sphere_of_this_test_is_right() {
    // x = 10, m = 1.5: Qsca-weighted g of the standard programs (`wiscombe1980` tables), 4 digits.
    let sphere = Sphere::new(10.0, 1.5);
    let table = Tabulated::to_tolerance(10.0, 1e-4, |theta| sphere.intensity(theta)).unwrap();
    assert!((table.asymmetry() - sphere.asymmetry()).abs() < 1e-5);
}

/// A droplet of 50 um radius in green light: a forward peak 0.3 degrees wide, rainbow and glory.
#[test]
fn a_large_droplet_keeps_its_mean_cosine() {
    let x = 2.0 * PI * 50.0 / 0.55;
    let sphere = Sphere::new(x, 1.333);
    let exact = 1.0 - sphere.asymmetry();
    let points = Tabulated::to_tolerance(x, 1e-3, |theta| sphere.intensity(theta)).unwrap();
    let error = points.one_minus_asymmetry() / exact - 1.0;
    println!(
        "points: {} angles, error {error:e}, estimate {:e}",
        points.grid().len(),
        points.one_minus_asymmetry_error()
    );
    assert!(error.abs() < 1e-3 && error.abs() <= points.one_minus_asymmetry_error());
    let grid = AngleGrid::graded(x, 1.0).unwrap();
    let binned = Tabulated::from_fn(grid, TableRule::Integrated, |theta| sphere.intensity(theta)).unwrap();
    let error = binned.one_minus_asymmetry() / exact - 1.0;
    println!(
        "bins: {} angles, error {error:e}, estimate {:e}",
        binned.grid().len(),
        binned.one_minus_asymmetry_error()
    );
    assert!(error.abs() < 1e-5 && error.abs() <= binned.one_minus_asymmetry_error() + 1e-9);
}
