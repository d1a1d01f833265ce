//! Lorenz-Mie scattering by one lossless sphere, to tabulate. Kept apart from the library's own.

/// Amplitudes of a lossless sphere by the textbook series (`bohren1983`, section 4.4 and 4.8), written for this test.
pub(crate) struct Sphere {
    a: Vec<(f64, f64)>,
    b: Vec<(f64, f64)>,
}

impl Sphere {
    /// Size parameter and relative refractive index, both real.
    pub(crate) fn new(x: f64, m: f64) -> Self {
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
    pub(crate) fn intensity(&self, theta: f64) -> f64 {
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
    pub(crate) fn asymmetry(&self) -> f64 {
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
fn the_mean_cosine_is_the_known_one() {
    // r = 0.5 um, n = 1.5 in 1.33 at 0.55 um: computed in 50-digit arithmetic by another program.
    let x = 2.0 * std::f64::consts::PI * 0.5 * 1.33 / 0.55;
    assert!((Sphere::new(x, 1.5 / 1.33).asymmetry() - 0.943_794_368_628).abs() < 1e-11);
}
