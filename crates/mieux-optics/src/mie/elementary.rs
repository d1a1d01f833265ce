//! Sine and cosine of numbers abreast, where recurrences start.

use pulp::Simd;

use crate::lanes::{Cx, LaneArray, Re, Wave};

/// Arguments up to which two-part reduction by pi/2 keeps an absolute error of a few 1e-16.
const REDUCIBLE: f64 = 1e5;

/// pi/2 in three parts, the leading one as a double.
const HALF_PI: [f64; 3] = [std::f64::consts::FRAC_PI_2, 6.123_233_995_736_766e-17, -1.497_384_904_859_17e-33];

/// Adding and subtracting this rounds a double to an integer.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

const SINE: [f64; 8] = [
    1.0,
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
];
const COSINE: [f64; 9] = [
    1.0,
    -1.0 / 2.0,
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 20_922_789_888_000.0,
];
/// `sinh(b) / b` and `cosh(b)` in powers of `b^2`, to 1e-16 for `|b|` up to [`NARROW`].
const SINH: [f64; 10] = [
    1.0,
    1.0 / 6.0,
    1.0 / 120.0,
    1.0 / 5040.0,
    1.0 / 362_880.0,
    1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    1.0 / 1_307_674_368_000.0,
    1.0 / 355_687_428_096_000.0,
    1.0 / 121_645_100_408_832_000.0,
];
const COSH: [f64; 11] = [
    1.0,
    1.0 / 2.0,
    1.0 / 24.0,
    1.0 / 720.0,
    1.0 / 40_320.0,
    1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    1.0 / 87_178_291_200.0,
    1.0 / 20_922_789_888_000.0,
    1.0 / 6_402_373_705_728_000.0,
    1.0 / 2_432_902_008_176_640_000.0,
];

/// Largest imaginary part that [`sin_cos_complex`] is made for.
pub(super) const NARROW: f64 = 1.5;

#[inline(always)]
fn polynomial<S: Simd, const N: usize>(x: Re<S>, coefficients: &[f64; N]) -> Re<S> {
    let mut sum = x.same(coefficients[N - 1]);
    for &c in coefficients[..N - 1].iter().rev() {
        sum = sum.mul_add(x, x.same(c));
    }
    sum
}

/// `(sin x, cos x)` with an absolute error below 3e-16.
#[inline(always)]
pub(super) fn sin_cos<S: Simd>(simd: S, x: Re<S>) -> (Re<S>, Re<S>) {
    if x.lanes()[..S::F64_LANES].iter().any(|x| x.abs() > REDUCIBLE) {
        return sin_cos_by_lane(simd, x);
    }
    let quarter_turns = x.mul_add(x.same(std::f64::consts::FRAC_2_PI), x.same(ROUNDER));
    let count = quarter_turns - x.same(ROUNDER);
    let mut rest = x;
    for part in HALF_PI {
        rest = count.neg_mul_add(x.same(part), rest);
    }
    let square = rest * rest;
    let (s, c) = (rest * polynomial(square, &SINE), polynomial(square, &COSINE));
    quarter_turns.turn(s, c)
}

#[inline(never)]
fn sin_cos_by_lane<S: Simd>(simd: S, x: Re<S>) -> (Re<S>, Re<S>) {
    let (mut s, mut c): (LaneArray, LaneArray) = (x.lanes(), x.lanes());
    for (s, c) in s.iter_mut().zip(&mut c) {
        (*s, *c) = s.sin_cos();
    }
    (Re::load(simd, &s), Re::load(simd, &c))
}

/// `(sin z, cos z)` for imaginary parts up to [`NARROW`]; the imaginary parts of the results keep their own digits
/// however small they are.
#[inline(always)]
pub(super) fn sin_cos_complex<S: Simd>(simd: S, z: Cx<S>) -> (Cx<S>, Cx<S>) {
    let (s, c) = sin_cos(simd, z.re);
    let square = z.im * z.im;
    let (sinh, cosh) = (z.im * polynomial(square, &SINH), polynomial(square, &COSH));
    let zero = z.re.same(0.0);
    (Cx { re: s * cosh, im: c * sinh }, Cx { re: c * cosh, im: s.neg_mul_add(sinh, zero) })
}

/// A multiple of `(sin z, cos z)`, by 1 or by `2 exp(-Im z)`, whatever the imaginary part.
#[inline(always)]
pub(super) fn sin_cos_multiple<S: Simd>(simd: S, z: Cx<S>) -> (Cx<S>, Cx<S>) {
    if !z.im.same(NARROW).any_less(z.im) {
        return sin_cos_complex(simd, z);
    }
    let (s, c) = sin_cos(simd, z.re);
    let sinh = loss(simd, z.im);
    let (cosh, zero) = (sinh.same(2.0) - sinh, sinh.same(0.0));
    (Cx { re: s * cosh, im: c * sinh }, Cx { re: c * cosh, im: s.neg_mul_add(sinh, zero) })
}

/// `1 - exp(-2 b)`
#[inline(never)]
fn loss<S: Simd>(simd: S, b: Re<S>) -> Re<S> {
    Re::load(simd, &b.lanes().map(|b| -(-2.0 * b).exp_m1()))
}

/// `(sin z, cos z)` moved on to `1 / inverse`, which the rounding of `inverse = 1 / z` has put beside `z`: a recurrence
/// that runs on `inverse` must start from there, or it carries the difference, up to 1e-16 of a large `z`, as a phase.
#[inline(always)]
pub(super) fn moved<S: Simd, W: Wave<S>>((sin, cos): (W, W), z: W, one: W, inverse: W) -> (W, W) {
    let excess = z.mul_sub(inverse, one);
    let shift = z.mul(excess);
    (sin - shift.mul(cos), cos + shift.mul(sin))
}
