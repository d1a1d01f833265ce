//! Ratios of Riccati-Bessel functions, each by the recurrence in which it is stable.
//!
//! `psi_n(z) = z j_n(z)` is the minimal solution, so its ratios run downward; `zeta_n(z) = z h_n^(1)(z)` is the
//! dominant one whenever `Im z >= 0`, so it runs upward, with the factor `exp(i z)` taken out and nothing to overflow.

use num_complex::Complex64;

/// Order beyond which the terms of a series in size parameter `modulus` fall below 1e-17.
///
/// Beyond the edge `n = |x|` terms fall like `exp(-1.886 p^(3/2))` with `p = (n - |x|) / |x|^(1/3)`, which is eq 19 of
/// `frisvad2007` with `p = 7.6` where 4.3 gave 1e-8.
pub(super) fn series_order(modulus: f64) -> usize {
    (modulus + 7.6 * modulus.cbrt() + 4.0).ceil() as usize
}

/// `rho_n = psi_{n+1}(z) / psi_n(z)` for `n = 0..=order`, by downward recurrence into `out`.
///
/// Related to the logarithmic derivative of `frisvad2007` eq 14 by `A_n = (n + 1)/z - rho_n`. Working with `rho` instead
/// of `A` keeps the leading term, which cancels exactly between particle and host, out of the arithmetic.
pub(super) fn psi_ratios(z: Complex64, order: usize, out: &mut Vec<Complex64>) {
    out.clear();
    out.resize(order + 1, Complex64::ZERO);
    let inverse = z.inv();
    let start = series_order(z.norm()).max(order) + 16;
    let mut rho = z / (2 * start + 3) as f64;
    for n in (0..start).rev() {
        let denominator = inverse * (2 * n + 3) as f64 - rho;
        rho = reciprocal(denominator);
        if n <= order {
            out[n] = rho;
        }
    }
}

/// `1/z`, with a vanishing `z` (a zero of `psi_n` met to the last bit) replaced by the smallest that stays finite when
/// squared: what follows depends on such a ratio only through its inverse.
fn reciprocal(z: Complex64) -> Complex64 {
    let norm = z.norm_sqr();
    if norm < 1e-290 { Complex64::new(1e145, 0.0) } else { Complex64::new(z.re / norm, -z.im / norm) }
}

/// Upward recurrence for `zeta_n(z) exp(-i z)`.
pub(super) struct Zeta {
    inverse: Complex64,
    previous: Complex64,
    current: Complex64,
    n: usize,
}

impl Zeta {
    /// At `n = 0`, where `zeta_0 = -i exp(i z)`.
    pub(super) fn new(z: Complex64) -> Self {
        Self { inverse: z.inv(), previous: Complex64::ONE, current: -Complex64::I, n: 0 }
    }

    /// Moves to the next order and returns `(zeta_n exp(-i z), zeta_{n-1} / zeta_n)`.
    pub(super) fn advance(&mut self) -> (Complex64, Complex64) {
        self.n += 1;
        let next = self.inverse * (2 * self.n - 1) as f64 * self.current - self.previous;
        self.previous = self.current;
        self.current = next;
        (next, self.previous / next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `psi_0 = sin z`, `psi_1 = sin z / z - cos z`.
    #[test]
    fn the_first_ratio_is_elementary() {
        let mut rho = Vec::new();
        for z in
            [Complex64::new(0.3, 0.0), Complex64::new(7.0, 0.4), Complex64::new(120.0, 3.0), Complex64::new(2.0, 30.0)]
        {
            psi_ratios(z, 5, &mut rho);
            let expected = z.inv() - z.cos() / z.sin();
            assert!((rho[0] - expected).norm() < 1e-12 * expected.norm(), "{z}: {} {expected}", rho[0]);
        }
    }

    /// `zeta_1 exp(-i z) = -(1 + i/z)`, and the Wronskian `psi_n zeta'_n - psi'_n zeta_n = i` at every order.
    #[test]
    fn zeta_starts_right_and_keeps_the_wronskian() {
        let z = Complex64::new(9.0, 0.7);
        let (zeta_1, _) = Zeta::new(z).advance();
        assert!((zeta_1 + Complex64::ONE + Complex64::I / z).norm() < 1e-15);

        let mut rho = Vec::new();
        psi_ratios(z, 30, &mut rho);
        let mut zeta = Zeta::new(z);
        let mut psi = z.sin() * rho[0];
        for (n, &rho) in rho.iter().enumerate().skip(1).take(25) {
            let (scaled, q) = zeta.advance();
            let b_minus_a = q - (2 * n + 1) as f64 / z + rho;
            let wronskian = psi * scaled * (Complex64::I * z).exp() * b_minus_a;
            assert!((wronskian - Complex64::I).norm() < 1e-12, "n {n}: {wronskian}");
            psi *= rho;
        }
    }
}
