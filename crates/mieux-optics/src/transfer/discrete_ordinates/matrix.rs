//! Small dense matrices, one per lane, and the few operations that the sweep needs.

use pulp::Simd;

use crate::lanes::Re;

/// A row-major matrix in every lane.
#[derive(Clone)]
pub(in crate::transfer) struct Matrix<S: Simd> {
    pub columns: usize,
    pub data: Vec<Re<S>>,
}

impl<S: Simd> Matrix<S> {
    #[inline(always)]
    pub fn zeros(simd: S, rows: usize, columns: usize) -> Self {
        Self { columns, data: vec![Re::splat(simd, 0.0); rows * columns] }
    }

    #[inline(always)]
    pub fn row(&self, i: usize) -> &[Re<S>] {
        &self.data[i * self.columns..(i + 1) * self.columns]
    }

    #[inline(always)]
    pub fn row_mut(&mut self, i: usize) -> &mut [Re<S>] {
        &mut self.data[i * self.columns..(i + 1) * self.columns]
    }

    /// Rows `i < j`, both open to change.
    #[inline(always)]
    pub fn two_rows(&mut self, i: usize, j: usize) -> (&mut [Re<S>], &mut [Re<S>]) {
        let (upper, lower) = self.data.split_at_mut(j * self.columns);
        (&mut upper[i * self.columns..(i + 1) * self.columns], &mut lower[..self.columns])
    }

    #[inline(always)]
    pub fn rows(&self) -> usize {
        self.data.len().checked_div(self.columns).unwrap_or(0)
    }
}

/// Four sums at a time, so that no step waits for the one before.
#[inline(always)]
pub(in crate::transfer) fn dot<S: Simd>(a: &[Re<S>], b: &[Re<S>], zero: Re<S>) -> Re<S> {
    let mut sums = [zero; 4];
    let (a4, b4) = (a.chunks_exact(4), b.chunks_exact(4));
    let mut rest = zero;
    for (x, y) in a4.remainder().iter().zip(b4.remainder()) {
        rest = x.mul_add(*y, rest);
    }
    for (x, y) in a4.zip(b4) {
        for q in 0..4 {
            sums[q] = x[q].mul_add(y[q], sums[q]);
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

/// `y += factor x`.
#[inline(always)]
pub(in crate::transfer) fn add_scaled<S: Simd>(y: &mut [Re<S>], factor: Re<S>, x: &[Re<S>]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y = factor.mul_add(*x, *y);
    }
}

/// `y -= factor x`.
#[inline(always)]
pub(in crate::transfer) fn subtract_scaled<S: Simd>(y: &mut [Re<S>], factor: Re<S>, x: &[Re<S>]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y = factor.neg_mul_add(*x, *y);
    }
}

/// `y = factor y`. (Loops, not closures: only what is inlined runs in wide registers.)
#[inline(always)]
pub(in crate::transfer) fn scale<S: Simd>(y: &mut [Re<S>], factor: Re<S>) {
    for y in y {
        *y = *y * factor;
    }
}

/// `y = x y`, one by one.
#[inline(always)]
pub(in crate::transfer) fn multiply<S: Simd>(y: &mut [Re<S>], x: &[Re<S>]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y = *y * *x;
    }
}

/// `A x`.
#[inline(always)]
pub(in crate::transfer) fn apply<S: Simd>(a: &Matrix<S>, x: &[Re<S>], zero: Re<S>) -> Vec<Re<S>> {
    let mut y = Vec::with_capacity(a.rows());
    for i in 0..a.rows() {
        y.push(dot(a.row(i), x, zero));
    }
    y
}

/// `A x + b`.
#[inline(always)]
pub(in crate::transfer) fn apply_add<S: Simd>(a: &Matrix<S>, x: &[Re<S>], b: &[Re<S>], zero: Re<S>) -> Vec<Re<S>> {
    let mut y = Vec::with_capacity(a.rows());
    for (i, b) in b.iter().enumerate() {
        y.push(dot(a.row(i), x, zero) + *b);
    }
    y
}

/// `A B`.
#[inline(always)]
pub(in crate::transfer) fn product<S: Simd>(simd: S, a: &Matrix<S>, b: &Matrix<S>) -> Matrix<S> {
    let mut c = Matrix::zeros(simd, a.rows(), b.columns);
    add_product(a, b, &mut c);
    c
}

/// `C += A B`.
#[inline(always)]
pub(in crate::transfer) fn add_product<S: Simd>(a: &Matrix<S>, b: &Matrix<S>, c: &mut Matrix<S>) {
    for i in 0..a.rows() {
        let row = c.row_mut(i);
        // Two terms a pass halve the traffic of the sums.
        let pairs = a.row(i).chunks_exact(2);
        if let [last] = pairs.remainder() {
            add_scaled(row, *last, b.row(a.columns - 1));
        }
        for (k, pair) in pairs.enumerate() {
            for ((sum, x), y) in row.iter_mut().zip(b.row(2 * k)).zip(b.row(2 * k + 1)) {
                *sum = pair[1].mul_add(*y, pair[0].mul_add(*x, *sum));
            }
        }
    }
}

/// `C = A B^T` in place of `out`, which the caller knows to be symmetric.
#[inline(always)]
pub(in crate::transfer) fn symmetric_product_into<S: Simd>(
    a: &Matrix<S>,
    b: &Matrix<S>,
    zero: Re<S>,
    out: &mut Matrix<S>,
) {
    let n = out.columns;
    for i in 0..n {
        for j in 0..=i {
            let value = dot(a.row(i), b.row(j), zero);
            out.data[i * n + j] = value;
            out.data[j * n + i] = value;
        }
    }
}

/// The lower Cholesky factor of a symmetric positive matrix, with the inverses of its diagonal on the diagonal; above it
/// is 0. A direction without stiffness (a pivot of 0) is left out: its inverse counts as 0.
#[derive(Clone)]
pub(in crate::transfer) struct Cholesky<S: Simd>(pub Matrix<S>);

impl<S: Simd> Cholesky<S> {
    /// Of a matrix whose lower half counts; and the least pivot of each lane.
    #[inline(always)]
    pub fn new(simd: S, mut a: Matrix<S>) -> (Self, Re<S>) {
        let n = a.columns;
        let (zero, one, tiny) = (Re::splat(simd, 0.0), Re::splat(simd, 1.0), Re::splat(simd, 1e-300));
        let mut least = Re::splat(simd, f64::MAX);
        for i in 0..n {
            for j in 0..i {
                let (upper, lower) = a.two_rows(j, i);
                lower[j] = (lower[j] - dot(&lower[..j], &upper[..j], zero)) * upper[j];
            }
            let row = a.row_mut(i);
            let pivot = row[i] - dot(&row[..i], &row[..i], zero);
            least = pivot.if_less(least, pivot, least);
            row[i] = tiny.if_less(pivot, one / pivot.max(tiny).sqrt(), zero);
            row[i + 1..].fill(zero);
        }
        (Self(a), least)
    }

    /// The diagonal of the factor itself.
    #[inline(always)]
    pub fn diagonal(&self, i: usize) -> Re<S> {
        let inverse = self.0.row(i)[i];
        let zero = inverse.same(0.0);
        zero.if_less(inverse, inverse.max(inverse.same(1e-300)).recip(), zero)
    }

    /// The factor with its own diagonal instead of the inverses.
    #[inline(always)]
    pub fn into_factor(mut self) -> Matrix<S> {
        for i in 0..self.0.columns {
            self.0.row_mut(i)[i] = self.diagonal(i);
        }
        self.0
    }

    /// Solves `L x = b` in place.
    #[inline(always)]
    pub fn solve_lower(&self, x: &mut [Re<S>], zero: Re<S>) {
        for i in 0..x.len() {
            let row = self.0.row(i);
            x[i] = (x[i] - dot(&row[..i], &x[..i], zero)) * row[i];
        }
    }

    /// Solves `L^T x = b` in place.
    #[inline(always)]
    pub fn solve_upper(&self, x: &mut [Re<S>]) {
        for i in (0..x.len()).rev() {
            let row = self.0.row(i);
            x[i] = x[i] * row[i];
            let value = x[i];
            subtract_scaled(&mut x[..i], value, &row[..i]);
        }
    }

    /// Solves `L L^T x = b` in place.
    #[inline(always)]
    pub fn solve(&self, x: &mut [Re<S>], zero: Re<S>) {
        self.solve_lower(x, zero);
        self.solve_upper(x);
    }

    /// `L L^T X = B` in place, for all columns of `B` at once.
    #[inline(always)]
    pub fn solve_columns(&self, b: &mut Matrix<S>) {
        let n = self.0.columns;
        for i in 0..n {
            for k in 0..i {
                let factor = self.0.data[i * n + k];
                let (upper, lower) = b.two_rows(k, i);
                subtract_scaled(lower, factor, upper);
            }
            let inverse = self.0.data[i * n + i];
            scale(b.row_mut(i), inverse);
        }
        for i in (0..n).rev() {
            let inverse = self.0.data[i * n + i];
            scale(b.row_mut(i), inverse);
            for k in 0..i {
                let factor = self.0.data[i * n + k];
                let (upper, lower) = b.two_rows(k, i);
                subtract_scaled(upper, factor, lower);
            }
        }
    }
}
