//! What a point source in an infinite medium does, arranged so that pairs of sources lose no digits.

/// `exp(-sigma d) / d`.
#[inline]
pub(super) fn potential(d: f64, sigma: f64) -> f64 {
    (-sigma * d).exp() / d
}

/// `z (1 + sigma d) exp(-sigma d) / d^3`: minus the derivative of [`potential`] along `z`. Its integral over a plane is
/// `2 pi exp(-sigma z)`.
#[inline]
pub(super) fn flux(z: f64, d: f64, sigma: f64) -> f64 {
    z * decay(sigma * d) / (d * d * d)
}

/// `(1 + x) exp(-x)`, 0 at infinity.
#[inline]
pub(super) fn decay(x: f64) -> f64 {
    if x < 800.0 { (1.0 + x) * (-x).exp() } else { 0.0 }
}

/// [`potential`] of the nearer source less that of one farther by `by`: far away the two are almost alike.
#[inline]
pub(super) fn potential_between(near: f64, by: f64, sigma: f64) -> f64 {
    let far = near + by;
    let fade = (-sigma * near).exp();
    if fade > 0.0 && far.is_finite() { fade * (by / near - (-sigma * by).exp_m1()) / far } else { 0.0 }
}

/// By how much `hypot(r, far)` is more than `hypot(r, near)`.
#[inline]
pub(super) fn farther(r: f64, near: f64, far: f64) -> f64 {
    let (a, b) = (r.hypot(near), r.hypot(far));
    if a + b > 0.0 { (far - near) * ((far + near) / (a + b)) } else { 0.0 }
}

/// `(1 - exp(-x)) / x`, 1 at 0.
#[inline]
pub(super) fn relative_loss(x: f64) -> f64 {
    if x.abs() < 1e-300 { 1.0 } else { -(-x).exp_m1() / x }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_keep_their_digits() {
        for (r, near, far, sigma) in [(0.3f64, 1.0, 5.0, 0.2), (3.0, 1.0, 1.5, 1.0), (2.0, 0.5, 9.0, 0.0)] {
            let (a, b) = (r.hypot(near), r.hypot(far));
            let by = farther(r, near, far);
            assert!((by - (b - a)).abs() < 1e-14);
            let plain = potential(a, sigma) - potential(b, sigma);
            assert!((potential_between(a, by, sigma) / plain - 1.0).abs() < 1e-13);
        }
        // Far away: (far^2 - near^2) / (2 r^3).
        let r = 1e8;
        let found = potential_between(r, farther(r, 1.0, 2.0), 0.0);
        assert!((found / (1.5 / r.powi(3)) - 1.0).abs() < 1e-12);
        assert_eq!(potential_between(f64::INFINITY, 0.0, 1.0), 0.0);
        assert_eq!(flux(1.0, 1e200, 0.0), 0.0);
        assert_eq!(flux(1.0, f64::INFINITY, 1.0), 0.0);
    }
}
