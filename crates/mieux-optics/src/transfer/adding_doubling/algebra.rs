//! What adding and doubling need of dense matrices, in place: they are used over and over.

use pulp::Simd;

use crate::lanes::Re;
use crate::transfer::discrete_ordinates::matrix::{Cholesky, Matrix, dot, scale, subtract_scaled};

/// `H K H` in place, with `K` symmetric and `H = 1 - 2 v v^T / v^2`.
#[inline(always)]
pub(super) fn reflect_both_sides<S: Simd>(k: &mut Matrix<S>, v: &[Re<S>], zero: Re<S>) {
    let n = k.columns;
    let twice = zero.same(2.0) / dot(v, v, zero);
    let mut w = Vec::with_capacity(n);
    for i in 0..n {
        w.push(twice * dot(k.row(i), v, zero));
    }
    let half = zero.same(0.5) * twice * dot(v, &w, zero);
    subtract_scaled(&mut w, half, v);
    for i in 0..n {
        let (vi, wi) = (v[i], w[i]);
        subtract_scaled(k.row_mut(i), vi, &w);
        subtract_scaled(k.row_mut(i), wi, v);
    }
}

/// Rows of `b` become `b L^-T`: each is solved with the lower factor.
#[inline(always)]
pub(super) fn solve_rows_lower<S: Simd>(factor: &Cholesky<S>, b: &mut Matrix<S>, zero: Re<S>) {
    for i in 0..b.rows() {
        factor.solve_lower(b.row_mut(i), zero);
    }
}

/// Rows of `b` become `b A^-1`.
#[inline(always)]
pub(super) fn solve_rows<S: Simd>(factor: &Cholesky<S>, b: &mut Matrix<S>, zero: Re<S>) {
    for i in 0..b.rows() {
        factor.solve(b.row_mut(i), zero);
    }
}

/// `M X = B`, in place of `B`, by elimination without exchange of rows; `M` is lost. In units of flux the columns of `M` are
/// dominated by their diagonals: no light comes back but what was sent. A pivot of 0 belongs to light that is enclosed and
/// that nothing feeds.
#[inline(always)]
pub(super) fn eliminate<S: Simd>(m: &mut Matrix<S>, b: &mut Matrix<S>, zero: Re<S>) {
    let n = m.columns;
    let tiny = zero.same(1e-300);
    for k in 0..n {
        let pivot = m.row(k)[k];
        let inverse = tiny.if_less(pivot.abs(), zero.same(1.0) / tiny.if_less(pivot.abs(), pivot, tiny), zero);
        scale(&mut m.row_mut(k)[k + 1..], inverse);
        scale(b.row_mut(k), inverse);
        for i in k + 1..n {
            let (upper, lower) = m.two_rows(k, i);
            let factor = lower[k];
            subtract_scaled(&mut lower[k + 1..], factor, &upper[k + 1..]);
            let (upper, lower) = b.two_rows(k, i);
            subtract_scaled(lower, factor, upper);
        }
    }
    for k in (1..n).rev() {
        for i in 0..k {
            let factor = m.row(i)[k];
            let (upper, lower) = b.two_rows(i, k);
            subtract_scaled(upper, factor, lower);
        }
    }
}
