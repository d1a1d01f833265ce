//! Integrals over the depth of a layer: what an exponential drives in a mode, and what a direction collects of it.

use std::f64::consts::LOG2_E;

use pulp::Simd;

use crate::lanes::Re;

/// What is left and what is gone, `exp(-x)` and `1 - exp(-x)`, both with all their digits.
#[derive(Clone, Copy)]
pub(super) struct Decay<S: Simd> {
    pub left: Re<S>,
    gone: Re<S>,
}

impl<S: Simd> Decay<S> {
    /// For `x >= 0`.
    #[inline(always)]
    pub fn new(simd: S, x: Re<S>) -> Self {
        let splat = |value: f64| Re::splat(simd, value);
        let (zero, one, most) = (splat(0.0), splat(1.0), splat(700.0));
        let clamped = x.if_less(most, x, most);
        // Added to this, a number is rounded to whole ones, which are then its last bits.
        let shift = splat(SHIFT);
        let shifted = clamped.mul_add(splat(LOG2_E), shift);
        let halvings = shifted - shift;
        let mut power = shifted.lanes();
        for power in &mut power {
            *power = f64::from_bits((1023 + SHIFT.to_bits()).wrapping_sub(power.to_bits()) << 52);
        }
        let power = Re::load(simd, &power);
        let rest = halvings.mul_add(splat(LN_2[1]), halvings.mul_add(splat(LN_2[0]), zero - clamped));
        let mut sum = splat(EXPONENTIAL[0]);
        for factor in &EXPONENTIAL[1..] {
            sum = sum.mul_add(rest, splat(*factor));
        }
        let excess = power * (rest * rest).mul_add(sum, rest);
        Self { left: x.if_less(most, power + excess, zero), gone: (one - power) - excess }
    }

    /// The integral over `x` in [0, t] of `exp(-a x)`, of which this is the decay.
    #[inline(always)]
    fn integral(&self, a: Re<S>, t: Re<S>) -> Re<S> {
        let x = a * t;
        let short = t * x.mul_add(x.same(-0.5), x.same(1.0));
        x.if_less(x.same(1e-8), short, self.gone / a)
    }
}

const SHIFT: f64 = 6_755_399_441_055_744.0;

/// The first bits of the logarithm of 2, so few that products with whole numbers are exact, and the rest.
const LN_2: [f64; 2] = [0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10];

/// Of the series of `(exp(x) - 1 - x) / x^2`, the last first: enough for `x` up to half the logarithm of 2.
const EXPONENTIAL: [f64; 12] = [
    1.0 / 6_227_020_800.0,
    1.0 / 479_001_600.0,
    1.0 / 39_916_800.0,
    1.0 / 3_628_800.0,
    1.0 / 362_880.0,
    1.0 / 40_320.0,
    1.0 / 5_040.0,
    1.0 / 720.0,
    1.0 / 120.0,
    1.0 / 24.0,
    1.0 / 6.0,
    0.5,
];

/// How a mode passes through a layer.
#[derive(Clone, Copy)]
pub(super) struct Passage<S: Simd> {
    decay: Decay<S>,
    /// `1 / (1 + exp(-2 k t))`.
    inverse: Re<S>,
    /// `1 / cosh(k t)`.
    pub sech: Re<S>,
    /// `tanh(k t) / k`: its resistance; `t` for `k = 0`.
    pub resistance: Re<S>,
}

impl<S: Simd> Passage<S> {
    /// For `k >= 0` and `t >= 0`.
    #[inline(always)]
    pub fn new(simd: S, k: Re<S>, t: Re<S>) -> Self {
        let (one, tiny) = (Re::splat(simd, 1.0), Re::splat(simd, 1e-150));
        let x = k * t;
        let decay = Decay::new(simd, x);
        let Decay { left, gone } = decay;
        let inverse = one / left.mul_add(left, one);
        let resistance = x.if_less(tiny, t, gone * (one + left) * inverse / k);
        Self { decay, inverse, sech: (left + left) * inverse, resistance }
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
#[derive(Clone, Copy)]
pub(super) struct Overlap<S: Simd> {
    /// Of `cosh(k x)`.
    pub cosh: Re<S>,
    /// Of `sinh(k x) / k`.
    pub sinh: Re<S>,
    /// Of `cosh(k (t - x))`.
    pub cosh_back: Re<S>,
    /// Of `sinh(k (t - x)) / k`.
    pub sinh_back: Re<S>,
}

impl<S: Simd> Overlap<S> {
    /// For `k >= 0`; the passage of the mode is what the caller has already.
    #[inline(always)]
    pub fn new(simd: S, k: Re<S>, fall: &Fall<S>, passage: &Passage<S>) -> Self {
        let (zero, one) = (Re::splat(simd, 0.0), Re::splat(simd, 1.0));
        let Passage { decay: Decay { left: mode, gone }, inverse, sech, resistance } = *passage;
        let Fall { nu, thickness: t, decay: Decay { left: beam, gone: beam_gone }, .. } = *fall;
        let along = beam_gone.mul_add(mode, gone) / (k + nu);
        let difference = (k - nu).abs();
        let mut against = (beam - mode) / (k - nu);
        let apart = difference * t;
        if apart.any_less(one) {
            let near = mode.max(beam) * Decay::new(simd, apart).integral(difference, t);
            against = apart.if_less(one, near, against);
        }
        let cosh = mode.mul_add(along, against) * inverse;
        let cosh_back = mode.mul_add(against, along) * inverse;
        // For small k these differences cancel.
        let scale = inverse / k;
        let (sinh, sinh_back) = (mode.neg_mul_add(along, against) * scale, mode.neg_mul_add(against, along) * scale);
        let slow = one / ((nu - k) * (nu + k));
        let passed = nu * resistance;
        let slow_sinh = beam.neg_mul_add(one + passed, sech) * slow;
        let slow_sinh_back = (passed - one + beam * sech) * slow;
        let least = nu * Re::splat(simd, 0.3);
        let (sinh, sinh_back) = (least.if_less(k, sinh, slow_sinh), least.if_less(k, sinh_back, slow_sinh_back));
        let mut found = Self { cosh, sinh, cosh_back, sinh_back };
        let (reach, limit) = (k.max(nu) * t, Re::splat(simd, THIN));
        if reach.any_less(limit) {
            let thin = Self::thin(k, fall, zero, one);
            found = Self {
                cosh: reach.if_less(limit, thin.cosh, cosh),
                sinh: reach.if_less(limit, thin.sinh, sinh),
                cosh_back: reach.if_less(limit, thin.cosh_back, cosh_back),
                sinh_back: reach.if_less(limit, thin.sinh_back, sinh_back),
            };
        }
        found
    }

    /// The integrands are smooth: five Gauss nodes are exact to rounding.
    #[inline(always)]
    fn thin(k: Re<S>, beam: &Fall<S>, zero: Re<S>, one: Re<S>) -> Self {
        let t = beam.thickness;
        let mut hyperbolic = [[zero; 2]; 5];
        for (pair, (x, _)) in hyperbolic.iter_mut().zip(GAUSS_5) {
            *pair = small_hyperbolic(k, t * zero.same(0.5 + 0.5 * x), one);
        }
        let [mut cosh, mut sinh, mut cosh_back, mut sinh_back] = [zero; 4];
        for q in 0..5 {
            // The nodes seen from the other end are the nodes in the other order.
            let ([c, s], [c_back, s_back]) = (hyperbolic[q], hyperbolic[4 - q]);
            let weight = beam.nodes[q];
            cosh = weight.mul_add(c, cosh);
            sinh = weight.mul_add(s, sinh);
            cosh_back = weight.mul_add(c_back, cosh_back);
            sinh_back = weight.mul_add(s_back, sinh_back);
        }
        let scale = one / small_hyperbolic(k, t, one)[0];
        Self { cosh: cosh * scale, sinh: sinh * scale, cosh_back: cosh_back * scale, sinh_back: sinh_back * scale }
    }
}

/// How a beam `exp(-nu x)` falls off in a piece of a layer.
#[derive(Clone, Copy)]
pub(super) struct Fall<S: Simd> {
    nu: Re<S>,
    thickness: Re<S>,
    /// At the far end.
    decay: Decay<S>,
    /// At the Gauss nodes of a thin piece, with their weights.
    nodes: [Re<S>; 5],
}

impl<S: Simd> Fall<S> {
    /// For `nu > 0` and `t >= 0`.
    #[inline(always)]
    pub fn new(simd: S, nu: Re<S>, t: Re<S>) -> Self {
        let mut nodes = [Re::splat(simd, 0.0); 5];
        let depth = nu * t;
        if depth.any_less(Re::splat(simd, THIN)) {
            for (node, (x, weight)) in nodes.iter_mut().zip(GAUSS_5) {
                let decay = Decay::new(simd, depth * Re::splat(simd, 0.5 + 0.5 * x));
                *node = t * Re::splat(simd, 0.5 * weight) * decay.left;
            }
        }
        Self { nu, thickness: t, decay: Decay::new(simd, depth), nodes }
    }
}

/// Up to this optical thickness, in a mode's and a beam's own measure, a piece is thin.
const THIN: f64 = 0.1;

/// `cosh(k x)` and `sinh(k x) / k` in a thin piece, by their series.
#[inline(always)]
fn small_hyperbolic<S: Simd>(k: Re<S>, x: Re<S>, one: Re<S>) -> [Re<S>; 2] {
    // Factors of neighbouring terms, the last first.
    const COSH: [f64; 4] = [1.0 / (7.0 * 8.0), 1.0 / (5.0 * 6.0), 1.0 / (3.0 * 4.0), 0.5];
    const SINH: [f64; 4] = [1.0 / (8.0 * 9.0), 1.0 / (6.0 * 7.0), 1.0 / (4.0 * 5.0), 1.0 / 6.0];
    let y = (k * x) * (k * x);
    let mut sums = [one; 2];
    for (sum, factors) in sums.iter_mut().zip([COSH, SINH]) {
        for factor in factors {
            *sum = (y * one.same(factor)).mul_add(*sum, one);
        }
    }
    [sums[0], x * sums[1]]
}

const GAUSS_5: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
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
        let flat = if x < 1e-150 { t } else { x.tanh() / k };
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
    use pulp::Scalar;

    use super::*;

    fn number(value: f64) -> Re<Scalar> {
        Re::splat(Scalar, value)
    }

    /// `cosh`, `sinh`, `cosh_back`, `sinh_back`, and the resistance and the `sech` of the passage.
    fn overlap(k: f64, nu: f64, t: f64) -> [f64; 6] {
        let passage = Passage::new(Scalar, number(k), number(t));
        let o = Overlap::new(Scalar, number(k), &Fall::new(Scalar, number(nu), number(t)), &passage);
        [o.cosh, o.sinh, o.cosh_back, o.sinh_back, passage.resistance, passage.sech].map(|value| value.lanes()[0])
    }

    #[test]
    fn both_parts_of_a_decay_have_all_digits() {
        let mut x = 1e-12f64;
        while x < 690.0 {
            let Decay { left, gone } = Decay::new(Scalar, number(x));
            assert!((left.lanes()[0] / (-x).exp() - 1.0).abs() < 5e-16, "{x}");
            assert!((gone.lanes()[0] / -(-x).exp_m1() - 1.0).abs() < 5e-16, "{x}");
            x *= 1.0123;
        }
        for (x, left) in [(0.0, 1.0), (710.0, 0.0), (1e300, 0.0)] {
            let decay = Decay::new(Scalar, number(x));
            assert_eq!([decay.left.lanes()[0], decay.gone.lanes()[0]], [left, 1.0 - left]);
        }
    }

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
            (3.0, 2.5, 0.03),
            (0.2, 0.9, 0.1),
            (0.2, 0.9, 0.12),
        ] {
            let [cosh, sinh, cosh_back, sinh_back, resistance, sech] = overlap(k, nu, t);
            let sinhc = |x: f64| if k * x < 1e-6 { x } else { (k * x).sinh() / k };
            let c = (k * t).cosh();
            for (ours, other) in [
                (cosh, simpson(t, |x| (k * x).cosh() * (-nu * x).exp()) / c),
                (sinh, simpson(t, |x| sinhc(x) * (-nu * x).exp()) / c),
                (cosh_back, simpson(t, |x| (k * (t - x)).cosh() * (-nu * x).exp()) / c),
                (sinh_back, simpson(t, |x| sinhc(t - x) * (-nu * x).exp()) / c),
                (resistance, simpson(t, |x| (k * x).cosh()) / c),
                (sech, 1.0 / c),
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
            let l = LinearOverlap::new(k, t);
            for value in overlap(k, nu, t).into_iter().chain([l.flat, l.rising, l.steep]) {
                assert!(value.is_finite() && value >= 0.0, "{k} {nu} {t}: {value}");
            }
        }
    }
}
