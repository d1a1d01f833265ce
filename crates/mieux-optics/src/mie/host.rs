//! How the waves of the host are carried, by how much it absorbs over the size of the particle.

use pulp::Simd;

use super::elementary::{moved, sin_cos, sin_cos_complex};
use crate::lanes::{Cx, Re, Wave};

/// Waves `psi_n` and `chi_n` of the host, and what follows from them.
///
/// Both obey the same recurrence and `psi_n chi_{n+1} - psi_{n+1} chi_n = 1`, scaled or not.
pub(super) trait Host<S: Simd> {
    type Wave: Wave<S>;
    fn size_parameter(k0r: Re<S>, index: Cx<S>) -> Self::Wave;
    /// `psi` at orders -1 and 0, `chi` at the same, for recurrences that run on `inverse`, which is `1 / x`.
    fn start(simd: S, x: Self::Wave, inverse: Self::Wave) -> [[Self::Wave; 2]; 2];
    /// What stands below a coefficient.
    #[inline(always)]
    fn denominator(numerator: Cx<S>, second: Cx<S>) -> Cx<S> {
        Cx { re: numerator.re + second.im, im: numerator.im - second.re }
    }
    /// A coefficient, from its parts `N` and `Y` and, in case the waves are real, `Im(Y conj N)` from inside the particle.
    fn fraction(inside: Re<S>, numerator: Cx<S>, second: Cx<S>) -> Fraction<S>;
}

/// A coefficient `N / (N - i Y)` before the division.
#[derive(Clone, Copy)]
pub(super) struct Fraction<S: Simd> {
    /// Numerator once the denominator is real.
    pub over: Cx<S>,
    /// Squared modulus, likewise.
    pub square: Re<S>,
    /// Real part less squared modulus, likewise.
    pub loss: Re<S>,
    /// The real denominator.
    pub below: Re<S>,
}

impl<S: Simd> Fraction<S> {
    /// With `loss = Im(Y conj N)`, every other part is a sum of positive numbers, or nearly so.
    #[inline(always)]
    pub fn new(loss: Re<S>, numerator: Cx<S>, second: Cx<S>) -> Self {
        let square = numerator.norm_sqr();
        let over = Cx { re: square + loss, im: numerator.dot(second) };
        Self { over, square, loss, below: second.dot_add(second, loss) + over.re }
    }
}

/// No absorption: real waves.
pub(super) struct Lossless;

/// Little absorption over the particle: complex waves whose imaginary parts keep their own digits.
pub(super) struct Absorbing;

/// So much absorption over the particle that incoming and outgoing waves part company: `psi exp(i x)` and `i zeta exp(-i x)` in
/// place of `psi` and `chi`.
pub(super) struct Opaque;

impl<S: Simd> Host<S> for Lossless {
    type Wave = Re<S>;

    #[inline(always)]
    fn size_parameter(k0r: Re<S>, index: Cx<S>) -> Re<S> {
        k0r * index.re
    }

    #[inline(always)]
    fn start(simd: S, x: Re<S>, inverse: Re<S>) -> [[Re<S>; 2]; 2] {
        let (sin, cos) = moved(sin_cos(simd, x), x, x.same(1.0), inverse);
        [[cos, sin], [x.same(0.0) - sin, cos]]
    }

    #[inline(always)]
    fn fraction(inside: Re<S>, numerator: Cx<S>, second: Cx<S>) -> Fraction<S> {
        Fraction::new(inside, numerator, second)
    }
}

impl<S: Simd> Host<S> for Absorbing {
    type Wave = Cx<S>;

    #[inline(always)]
    fn size_parameter(k0r: Re<S>, index: Cx<S>) -> Cx<S> {
        k0r.times(index)
    }

    #[inline(always)]
    fn start(simd: S, x: Cx<S>, inverse: Cx<S>) -> [[Cx<S>; 2]; 2] {
        let (zero, one) = (x.re.same(0.0), x.re.same(1.0));
        let (sin, cos) = moved(sin_cos_complex(simd, x), x, Cx { re: one, im: zero }, inverse);
        [[cos, sin], [Cx { re: zero - sin.re, im: zero - sin.im }, cos]]
    }

    #[inline(always)]
    fn fraction(_: Re<S>, numerator: Cx<S>, second: Cx<S>) -> Fraction<S> {
        Fraction::new(second.cross(numerator), numerator, second)
    }
}

impl<S: Simd> Host<S> for Opaque {
    type Wave = Cx<S>;

    #[inline(always)]
    fn denominator(_: Cx<S>, second: Cx<S>) -> Cx<S> {
        Cx { re: second.im, im: second.re.same(0.0) - second.re }
    }

    #[inline(always)]
    fn size_parameter(k0r: Re<S>, index: Cx<S>) -> Cx<S> {
        k0r.times(index)
    }

    /// `psi` runs downward only and is scaled by what `chi` says, so its start is of no use.
    #[inline(always)]
    fn start(simd: S, x: Cx<S>, _: Cx<S>) -> [[Cx<S>; 2]; 2] {
        let (zero, one) = (Re::splat(simd, 0.0), Re::splat(simd, 1.0));
        [[x, x], [Cx { re: zero, im: one }, Cx { re: one, im: zero }]]
    }

    #[inline(always)]
    fn fraction(inside: Re<S>, numerator: Cx<S>, second: Cx<S>) -> Fraction<S> {
        // N / (-i Y)
        Fraction {
            over: Cx { re: inside.same(0.0) - numerator.cross(second), im: numerator.dot(second) },
            square: numerator.norm_sqr(),
            loss: inside.same(0.0),
            below: second.norm_sqr(),
        }
    }
}
