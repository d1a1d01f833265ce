//! What the coefficients add up to.

use num_complex::Complex64;
use pulp::Simd;

use super::kernel::{Sink, Term};
use super::weights::Weight;
use crate::lanes::{Cx, LaneArray, Re, Wave};

/// Sums over all orders, abreast. Unless the waves are scaled, the real part of `forward` is left to the other sums.
pub(super) struct Sums<S: Simd, const SCALED: bool> {
    forward: Cx<S>,
    size: Re<S>,
    scattering: Re<S>,
    loss: Re<S>,
    /// The parts of the asymmetry, of orders with the one before and of both coefficients of one order.
    neighbours: Re<S>,
    pairs: Re<S>,
    previous: (Cx<S>, Cx<S>),
    /// What earlier runs of orders added up to, so that rounding grows with the length of a run only.
    earlier: [Re<S>; 7],
}

/// The sums of one sphere.
#[derive(Debug, Clone, Copy)]
pub(super) struct SphereSums {
    /// Sum of `(2n + 1)(a_n + b_n)`.
    pub forward: Complex64,
    /// Of the order of the sum of `(2n + 1)(|a_n| + |b_n|)` when the waves are scaled, else 0.
    pub size: f64,
    /// Sum of `(2n + 1)(|a_n|^2 + |b_n|^2)`.
    pub scattering: f64,
    /// Sum of `(2n + 1)(Re a_n - |a_n|^2 + Re b_n - |b_n|^2)`.
    pub loss: f64,
    /// Half the numerator of the asymmetry, eq 26 of `frisvad2007`.
    pub asymmetry: f64,
}

/// The sums of several spheres as plain memory.
pub(super) struct GroupSums {
    forward_re: LaneArray,
    forward_im: LaneArray,
    size: LaneArray,
    scattering: LaneArray,
    loss: LaneArray,
    asymmetry: LaneArray,
}

impl<S: Simd, const SCALED: bool> Sums<S, SCALED> {
    #[inline(always)]
    pub fn new(simd: S) -> Self {
        let zero = Re::splat(simd, 0.0);
        let z = Cx { re: zero, im: zero };
        Self {
            forward: z,
            size: zero,
            scattering: zero,
            loss: zero,
            neighbours: zero,
            pairs: zero,
            previous: (z, z),
            earlier: [zero; 7],
        }
    }

    #[inline(always)]
    pub fn finish(mut self) -> GroupSums {
        self.pause();
        let [forward_re, forward_im, size, scattering, loss, neighbours, pairs] = self.earlier;
        GroupSums {
            forward_re: if SCALED { forward_re } else { scattering + loss }.lanes(),
            forward_im: forward_im.lanes(),
            size: size.lanes(),
            scattering: scattering.lanes(),
            loss: loss.lanes(),
            asymmetry: (neighbours + pairs).lanes(),
        }
    }
}

impl<S: Simd, const SCALED: bool> Sink<S> for Sums<S, SCALED> {
    #[inline(always)]
    fn take(&mut self, weight: &Weight, Term { a, b, square, loss }: Term<S>) {
        let factor = loss.same(weight.factor);
        if SCALED {
            self.forward.re = factor.mul_add(a.re + b.re, self.forward.re);
            self.size = factor.mul_add(a.size() + b.size(), self.size);
        }
        self.forward.im = factor.mul_add(a.im + b.im, self.forward.im);
        self.scattering = factor.mul_add(square, self.scattering);
        self.loss = factor.mul_add(loss, self.loss);
        let (a0, b0) = self.previous;
        let beside = a0.dot_add(a, b0.dot(b));
        self.neighbours = loss.same(weight.neighbours).mul_add(beside, self.neighbours);
        self.pairs = loss.same(weight.pair).mul_add(a.dot(b), self.pairs);
        self.previous = (a, b);
    }

    #[inline(always)]
    fn pause(&mut self) {
        let zero = self.loss.same(0.0);
        let Self { forward, size, scattering, loss, neighbours, pairs, earlier, .. } = self;
        let parts = [&mut forward.re, &mut forward.im, size, scattering, loss, neighbours, pairs];
        for (earlier, part) in earlier.iter_mut().zip(parts) {
            *earlier = *earlier + *part;
            *part = zero;
        }
    }
}

impl GroupSums {
    #[inline(always)]
    pub fn lane(&self, i: usize) -> SphereSums {
        SphereSums {
            forward: Complex64::new(self.forward_re[i], self.forward_im[i]),
            size: self.size[i],
            scattering: self.scattering[i],
            loss: self.loss[i],
            asymmetry: self.asymmetry[i],
        }
    }
}
