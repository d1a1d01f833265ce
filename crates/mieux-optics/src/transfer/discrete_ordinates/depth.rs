//! Integrals over the depth of a layer: what an exponential drives in a mode, and what a direction collects of it.

/// How a mode passes through a layer.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Passage {
    /// `exp(-k t)`.
    pub fade: f64,
    /// `1 / cosh(k t)`.
    pub sech: f64,
    /// `tanh(k t) / k`: its resistance; `t` for `k = 0`.
    pub resistance: f64,
}

impl Passage {
    /// For `k >= 0` and `t >= 0`.
    #[inline]
    pub fn new(k: f64, t: f64) -> Self {
        let x = k * t;
        let fade = (-x).exp();
        let square = fade * fade;
        let inverse = 1.0 / (1.0 + square);
        let resistance = if x > 1.0 {
            (1.0 - square) * inverse / k
        } else if x < 1e-150 {
            t
        } else {
            x.tanh() / k
        };
        Self { fade, sech: 2.0 * fade * inverse, resistance }
    }
}

/// The integral over `x` in [0, t] of `exp(-a x) exp(-b (t - x))`, also for `a = b`.
pub(super) fn crossing(a: f64, b: f64, t: f64) -> f64 {
    let (least, difference) = (a.min(b), (a - b).abs());
    (-least * t).exp() * fading(difference, t)
}

/// The integral over `x` in [0, t] of `exp(-a x)`.
pub(super) fn fading(a: f64, t: f64) -> f64 {
    let x = a * t;
    if x < 1e-8 { t * (1.0 - 0.5 * x) } else { -(-x).exp_m1() / a }
}

/// Integrals over the depth `x` in [0, t] of a mode times `exp(-nu x)`, all divided by `cosh(k t)`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Overlap {
    /// Of `cosh(k x)`.
    pub cosh: f64,
    /// Of `sinh(k x) / k`.
    pub sinh: f64,
    /// Of `cosh(k (t - x))`.
    pub cosh_back: f64,
    /// Of `sinh(k (t - x)) / k`.
    pub sinh_back: f64,
}

impl Overlap {
    /// For `k >= 0`; the passage of the mode is what the caller has already.
    #[inline]
    pub fn new(k: f64, fall: &Fall, passage: &Passage) -> Self {
        let Passage { fade: mode, sech, resistance } = *passage;
        let Fall { nu, thickness: t, fade: beam, .. } = *fall;
        if k.max(nu) * t < THIN {
            return Self::thin(k, fall);
        }
        let both = k + nu;
        let along = if both * t > 1.0 { (1.0 - mode * beam) / both } else { fading(both, t) };
        let difference = (k - nu).abs();
        let against = if difference * t > 1.0 { (beam - mode) / (k - nu) } else { crossing(k, nu, t) };
        let scale = 1.0 / (1.0 + mode * mode);
        let cosh = (against + mode * along) * scale;
        let cosh_back = (along + mode * against) * scale;
        if k > 0.3 * nu {
            let scale = scale / k;
            let (sinh, sinh_back) = ((against - mode * along) * scale, (along - mode * against) * scale);
            return Self { cosh, sinh, cosh_back, sinh_back };
        }
        // For small k the differences above cancel.
        let inverse = 1.0 / ((nu - k) * (nu + k));
        let sinh = (sech - beam * (1.0 + nu * resistance)) * inverse;
        let sinh_back = (nu * resistance - 1.0 + beam * sech) * inverse;
        Self { cosh, sinh, cosh_back, sinh_back }
    }

    /// The integrands are smooth: eight Gauss nodes are exact to rounding.
    fn thin(k: f64, beam: &Fall) -> Self {
        let t = beam.thickness;
        let hyperbolic = GAUSS_8.map(|(x, _)| small_hyperbolic(k, 0.5 * t * (1.0 + x)));
        let [mut cosh, mut sinh, mut cosh_back, mut sinh_back] = [0.0; 4];
        for (q, weight) in beam.nodes.iter().enumerate() {
            // The nodes seen from the other end are the nodes in the other order.
            let ([c, s], [c_back, s_back]) = (hyperbolic[q], hyperbolic[7 - q]);
            cosh += weight * c;
            sinh += weight * s;
            cosh_back += weight * c_back;
            sinh_back += weight * s_back;
        }
        let scale = 1.0 / small_hyperbolic(k, t)[0];
        Self { cosh: cosh * scale, sinh: sinh * scale, cosh_back: cosh_back * scale, sinh_back: sinh_back * scale }
    }
}

/// How a beam `exp(-nu x)` falls off in a piece of a layer.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Fall {
    nu: f64,
    thickness: f64,
    /// At the far end.
    fade: f64,
    /// At the Gauss nodes of a thin piece, with their weights.
    nodes: [f64; 8],
}

impl Fall {
    /// For `nu > 0` and `t >= 0`.
    pub fn new(nu: f64, t: f64) -> Self {
        let fade = (-nu * t).exp();
        let nodes = if nu * t < THIN {
            GAUSS_8.map(|(x, weight)| 0.5 * t * weight * (-0.5 * nu * t * (1.0 + x)).exp())
        } else {
            [0.0; 8]
        };
        Self { nu, thickness: t, fade, nodes }
    }
}

/// Up to this optical thickness, in a mode's and a beam's own measure, a piece is thin.
const THIN: f64 = 0.5;

/// `cosh(k x)` and `sinh(k x) / k` for `k x` up to 1/2, by their series.
fn small_hyperbolic(k: f64, x: f64) -> [f64; 2] {
    // Factors of neighbouring terms, the last first.
    const COSH: [f64; 6] =
        [1.0 / (11.0 * 12.0), 1.0 / (9.0 * 10.0), 1.0 / (7.0 * 8.0), 1.0 / (5.0 * 6.0), 1.0 / (3.0 * 4.0), 0.5];
    const SINH: [f64; 5] = [1.0 / (10.0 * 11.0), 1.0 / (8.0 * 9.0), 1.0 / (6.0 * 7.0), 1.0 / (4.0 * 5.0), 1.0 / 6.0];
    let y = (k * x).powi(2);
    let sum = |factors: &[f64]| factors.iter().fold(1.0, |rest, factor| 1.0 + y * rest * factor);
    [sum(&COSH), x * sum(&SINH)]
}

const GAUSS_8: [(f64, f64); 8] = [
    (-0.9602898564975363, 0.10122853629037626),
    (-0.7966664774136267, 0.22238103445337448),
    (-0.525532409916329, 0.31370664587788727),
    (-0.1834346424956498, 0.362683783378362),
    (0.1834346424956498, 0.362683783378362),
    (0.525532409916329, 0.31370664587788727),
    (0.7966664774136267, 0.22238103445337448),
    (0.9602898564975363, 0.10122853629037626),
];

/// Integrals of a mode against a source that is linear in depth, divided by `cosh(k t)`.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LinearOverlap {
    /// Of `cosh(k (t - x))`: `tanh(k t) / k`.
    pub flat: f64,
    /// Of `sinh(k x) / k`, which is also that of `x cosh(k (t - x))`.
    pub rising: f64,
    /// Of `x sinh(k x) / k`.
    pub steep: f64,
}

impl LinearOverlap {
    pub fn new(k: f64, t: f64) -> Self {
        let x = k * t;
        let flat = Passage::new(k, t).resistance;
        // (1 - sech x) / x^2 and (x - tanh x) / x^3.
        let half = if x < 1e-4 {
            1.0
        } else if x > 300.0 {
            0.0
        } else {
            (0.5 * x).sinh() / (0.5 * x)
        };
        let rising = if x > 300.0 { 1.0 / (x * x) } else { 0.5 * half * half / x.cosh() };
        let steep = if x < 0.1 {
            let x2 = x * x;
            1.0 / 3.0 - x2 * (2.0 / 15.0 - x2 * (17.0 / 315.0 - x2 * (62.0 / 2835.0 - x2 * 1382.0 / 155_925.0)))
        } else {
            (x - x.tanh()) / (x * x * x)
        };
        Self { flat, rising: rising * t * t, steep: steep * t * t * t }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By Simpson's rule.
    fn simpson(t: f64, f: impl Fn(f64) -> f64) -> f64 {
        let n = 20_000;
        let h = t / f64::from(n);
        let inner: f64 = (1..n).map(|i| f(h * f64::from(i)) * if i % 2 == 1 { 4.0 } else { 2.0 }).sum();
        (f(0.0) + inner + f(t)) * h / 3.0
    }

    #[test]
    fn every_branch_follows_quadrature() {
        for (k, nu, t) in [
            (0.0, 1.0, 0.3),
            (1e-9, 1.0, 2.0),
            (0.1, 1.3, 5.0),
            (0.29, 1.0, 1.0),
            (0.31, 1.0, 1.0),
            (2.0, 2.0, 3.0),
            (2.0, 2.0 + 1e-9, 3.0),
            (5.0, 1.0, 4.0),
            (1.0, 12.0, 2.0),
            (3.0, 2.5, 0.1),
        ] {
            let o = Overlap::new(k, &Fall::new(nu, t), &Passage::new(k, t));
            let sinhc = |x: f64| if k * x < 1e-6 { x } else { (k * x).sinh() / k };
            let c = (k * t).cosh();
            for (ours, other) in [
                (o.cosh, simpson(t, |x| (k * x).cosh() * (-nu * x).exp()) / c),
                (o.sinh, simpson(t, |x| sinhc(x) * (-nu * x).exp()) / c),
                (o.cosh_back, simpson(t, |x| (k * (t - x)).cosh() * (-nu * x).exp()) / c),
                (o.sinh_back, simpson(t, |x| sinhc(t - x) * (-nu * x).exp()) / c),
            ] {
                assert!((ours / other - 1.0).abs() < 1e-11, "k {k} nu {nu} t {t}: {ours} for {other}");
            }
            let l = LinearOverlap::new(k, t);
            for (ours, other) in [
                (l.flat, simpson(t, |x| (k * (t - x)).cosh()) / c),
                (l.rising, simpson(t, sinhc) / c),
                (l.rising, simpson(t, |x| x * (k * (t - x)).cosh()) / c),
                (l.steep, simpson(t, |x| x * sinhc(x)) / c),
            ] {
                assert!((ours / other - 1.0).abs() < 1e-11, "linear, k {k} t {t}: {ours} for {other}");
            }
        }
    }

    #[test]
    fn nothing_overflows() {
        for (k, nu, t) in [(1e3, 1.0, 1e6), (0.0, 1.0, 1e6), (1e-4, 1.0, 1e6), (50.0, 1e9, 1e-8), (3.0, 1.0, 0.0)] {
            let o = Overlap::new(k, &Fall::new(nu, t), &Passage::new(k, t));
            let l = LinearOverlap::new(k, t);
            for value in [o.cosh, o.sinh, o.cosh_back, o.sinh_back, l.flat, l.rising, l.steep, Passage::new(k, t).sech]
            {
                assert!(value.is_finite() && value >= 0.0, "{k} {nu} {t}: {o:?} {l:?}");
            }
        }
    }
}
