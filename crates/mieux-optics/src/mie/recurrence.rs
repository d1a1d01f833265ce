//! The three-term recurrence of Riccati-Bessel functions, `f_{n+1} + f_{n-1} = (2n + 1) / z f_n`, both ways.
//!
//! `psi_n` is the solution that fades beyond the order of its argument, so it runs downward; every other one runs upward.

use num_complex::Complex64;
use pulp::Simd;

use crate::lanes::{Re, Wave};

/// One step of the three-term recurrence in either direction: `(2n + 1) / z * current - other`.
#[inline(always)]
pub(super) fn step<S: Simd, W: Wave<S>>(inverse: W, factor: Re<S>, current: W, other: W) -> W {
    current.mul_sub(inverse.scale(factor), other)
}

/// From orders `n - 1` and `n` to `n` and `n + 1`, with `factor = 2n + 1`.
#[inline(always)]
pub(super) fn up<S: Simd, W: Wave<S>>(inverse: W, factor: Re<S>, pair: [W; 2]) -> [W; 2] {
    [pair[1], step(inverse, factor, pair[1], pair[0])]
}

/// A downward recurrence: `f_{n+1}` and `f_n` up to a common factor.
#[derive(Clone, Copy)]
pub(super) struct Descent<W> {
    pub above: W,
    pub here: W,
}

impl<W> Descent<W> {
    /// At the order `from`, above which the solution counts as zero, down to the order `to`.
    #[inline(always)]
    pub fn new<S: Simd>(simd: S, inverse: W, [from, to]: [usize; 2], run: usize) -> Self
    where
        W: Wave<S>,
    {
        let mut descent = Self { above: W::splat(simd, 0.0), here: W::splat(simd, 1.0) };
        for n in (to + 1..=from).rev() {
            descent.down(inverse, Re::splat(simd, 2.0 * n as f64 + 1.0));
            if n % run == 0 {
                descent.scale(descent.size().recip());
            }
        }
        descent
    }

    /// From order `n` to `n - 1`, with `factor = 2n + 1`.
    #[inline(always)]
    pub fn down<S: Simd>(&mut self, inverse: W, factor: Re<S>)
    where
        W: Wave<S>,
    {
        let below = step(inverse, factor, self.here, self.above);
        self.above = self.here;
        self.here = below;
    }

    #[inline(always)]
    pub fn size<S: Simd>(&self) -> Re<S>
    where
        W: Wave<S>,
    {
        self.here.size() + self.above.size()
    }

    #[inline(always)]
    pub fn scale<S: Simd>(&mut self, factor: Re<S>)
    where
        W: Wave<S>,
    {
        self.above = self.above.scale(factor);
        self.here = self.here.scale(factor);
    }
}

/// Order beyond which the terms of a series in size parameter `modulus` no longer count.
///
/// Beyond the edge `n = |x|` coefficients fall like `exp(-1.886 p^(3/2))` with `p = (n - |x|) / |x|^(1/3)`, which is eq
/// 19 of `frisvad2007` with 6.5 (3e-14, in the sums less) where 4.3 gave 1e-8.
pub(super) fn series_order(modulus: f64) -> usize {
    (modulus + 6.5 * cube_root(modulus) + 3.0) as usize
}

/// Cube root of a positive normal number to 1e-4, which is all that an order needs: a third of the exponent, then one
/// step of Halley's method.
fn cube_root(x: f64) -> f64 {
    let guess = f64::from_bits(x.to_bits() / 3 + 0x2A9F_7893_782D_A1CE);
    let cube = guess * guess * guess;
    guess * (cube + 2.0 * x) / (2.0 * cube + x)
}

/// A little more, at most 0.06, than the natural logarithm of a positive normal number: between powers of two the binary one
/// is the bits of the number but for 0.0861.
fn logarithm_above(x: f64) -> f64 {
    (x.to_bits() as f64 / (1u64 << 52) as f64 - 1022.9139) * std::f64::consts::LN_2
}

/// How many of the first `width` size parameters, ascending, can go abreast: orders that only the largest needs make the
/// outgoing waves of the smallest grow, which must stay far from overflow.
pub(super) fn abreast(width: usize, sizes: &[f64]) -> usize {
    let smallest = sizes.first().copied().unwrap_or(1.0);
    let fits = |count: &usize| {
        let (least, most) = (series_order(smallest), series_order(sizes[count - 1]));
        most == least || (most - least) as f64 * logarithm_above((2.0 * most as f64 + 1.0) / smallest) < 50.0
    };
    (1..=width.min(sizes.len())).rev().find(fits).unwrap_or(1)
}

/// Order from which a downward recurrence in an argument of size `modulus` forgets its start before it reaches `order`.
pub(super) fn top_order(modulus: f64, order: usize) -> usize {
    series_order(modulus).max(order) + 4 + (1.2 * modulus).min(12.0) as usize
}

/// Order from which a downward recurrence in `z` forgets its start before it reaches `order`, where `top` ([`top_order`])
/// does for whatever `z`: sooner where `z` absorbs.
pub(super) fn start_order(z: Complex64, order: usize, top: usize) -> usize {
    let nu = order as f64 + 0.5;
    if top > order + 100 && z.im > 0.0 && nu * nu < z.norm_sqr() {
        // Per order the dominated solution shrinks by exp(-2 |Im theta|) against the other, where cos theta = nu / z.
        let steps = 20.0 / (nu / z).acos().im.abs();
        if steps < top as f64 {
            return top.min(order + 16 + steps as usize);
        }
    }
    top
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cube_roots_are_good_enough() {
        for i in 0..2000 {
            let x = 10f64.powf(f64::from(i) * 0.01 - 10.0);
            assert!((cube_root(x) / x.cbrt() - 1.0).abs() < 1e-4, "{x:e}");
        }
    }

    #[test]
    fn logarithms_are_bounded_from_above() {
        for i in 0..2000 {
            let x = 10f64.powf(f64::from(i) * 0.01 - 10.0);
            assert!((0.0..0.06).contains(&(logarithm_above(x) - x.ln())), "{x:e}");
        }
    }
}
