//! Refracting planes, and resistances in series with what is below them.

use pulp::Simd;

use super::matrix::{Cholesky, Matrix, apply_add, multiply, scale, subtract_scaled};
use super::plan::Plan;
use super::sweep::{Answering, Lanes, Level};
use crate::lanes::Re;

/// A plane that refracts.
pub(super) struct Crossing<S: Simd> {
    series: Series<S>,
    /// Of the streams that are trapped below.
    trapped: Option<Trapped<S>>,
    from_below: Vec<Vec<Re<S>>>,
    /// Below the plane, and just above it.
    admittance: Matrix<S>,
    answer: Matrix<S>,
    above: usize,
}

struct Trapped<S: Simd> {
    factor: Cholesky<S>,
    /// Rows: trapped streams; columns: the others.
    coupling: Matrix<S>,
    from_below: Vec<Vec<Re<S>>>,
}

/// Resistances in series with an admittance.
pub(super) struct Series<S: Simd> {
    /// Their square roots, and the inverses of these.
    roots: Vec<Re<S>>,
    inverse: Vec<Re<S>>,
    factor: Cholesky<S>,
}

impl<S: Simd> Series<S> {
    /// With the admittance of both: `(Z^-1 + R)^-1`.
    #[inline(always)]
    pub fn new(simd: S, z: &Matrix<S>, resistances: &[Re<S>]) -> (Self, Matrix<S>) {
        let n = z.columns;
        let one = Re::splat(simd, 1.0);
        let least = Re::splat(simd, 1e-280);
        let mut roots = resistances.to_vec();
        for root in &mut roots {
            *root = root.max(least).sqrt();
        }
        let mut inverse = roots.clone();
        for root in &mut inverse {
            *root = one / *root;
        }
        let mut scaled = Matrix::zeros(simd, n, n);
        for i in 0..n {
            for j in 0..n {
                scaled.data[i * n + j] = z.data[i * n + j] * roots[i] * roots[j];
            }
        }
        let mut sum = scaled.clone();
        for i in 0..n {
            sum.data[i * n + i] = sum.data[i * n + i] + one;
        }
        let (factor, _) = Cholesky::new(simd, sum);
        factor.solve_columns(&mut scaled);
        for i in 0..n {
            for j in 0..n {
                scaled.data[i * n + j] = scaled.data[i * n + j] * inverse[i] * inverse[j];
            }
        }
        (Self { roots, inverse, factor }, scaled)
    }

    /// `(1 + R Z)^-1 v`.
    #[inline(always)]
    pub fn divide(&self, simd: S, v: &mut [Re<S>]) {
        multiply(v, &self.inverse);
        self.factor.solve(v, Re::splat(simd, 0.0));
        multiply(v, &self.roots);
    }

    /// `u - R e`.
    #[inline(always)]
    pub fn drop(&self, simd: S, e: &[Re<S>], u: Option<&[Re<S>]>) -> Vec<Re<S>> {
        let zero = Re::splat(simd, 0.0);
        let mut drop = Vec::with_capacity(e.len());
        for i in 0..e.len() {
            let from = u.map_or(zero, |u| u[i]);
            drop.push((self.roots[i] * self.roots[i]).neg_mul_add(e[i], from));
        }
        drop
    }

    /// `e + Y (u - R e)`, with the admittance `Y` of both.
    #[inline(always)]
    pub fn carry(&self, simd: S, y: &Matrix<S>, e: &[Re<S>], u: Option<&[Re<S>]>) -> Vec<Re<S>> {
        let zero = Re::splat(simd, 0.0);
        let drop = self.drop(simd, e, u);
        apply_add(y, &drop, e, zero)
    }
}

#[inline(always)]
pub(super) fn cross<S: Simd>(
    simd: S,
    lanes: &Lanes,
    plane: usize,
    above: usize,
    z: Matrix<S>,
    e: Vec<Vec<Re<S>>>,
) -> Crossing<S> {
    let common = above.min(z.columns);
    let mut resistances = Vec::with_capacity(common);
    for i in 0..common {
        let share = |plan: &Plan, _: usize| plan.frame.planes[plane].resistance.as_ref().map_or(0.0, |r| r[i]);
        resistances.push(lanes.gather(simd, share));
    }
    let ((admittance, from_below), trapped) =
        if common < z.columns { eliminate(simd, z, e, common) } else { ((z, e), None) };
    let (series, answer) = Series::new(simd, &admittance, &resistances);
    Crossing { series, trapped, from_below, admittance, answer, above }
}

/// Without the streams from `common` on, which find no way up: their difference is 0.
#[inline(always)]
fn eliminate<S: Simd>(
    simd: S,
    z: Matrix<S>,
    mut e: Vec<Vec<Re<S>>>,
    common: usize,
) -> (Answering<S>, Option<Trapped<S>>) {
    let count = z.columns - common;
    let zero = Re::splat(simd, 0.0);
    let (mut inner, mut coupling) = (Matrix::zeros(simd, count, count), Matrix::zeros(simd, count, common));
    let mut outer = Matrix::zeros(simd, common, common);
    for t in 0..count {
        inner.row_mut(t).copy_from_slice(&z.row(common + t)[common..]);
        coupling.row_mut(t).copy_from_slice(&z.row(common + t)[..common]);
    }
    for i in 0..common {
        outer.row_mut(i).copy_from_slice(&z.row(i)[..common]);
    }
    let (factor, _) = Cholesky::new(simd, inner);
    let mut solved = coupling.clone();
    factor.solve_columns(&mut solved);
    for t in 0..count {
        for i in 0..common {
            let weight = coupling.row(t)[i];
            subtract_scaled(outer.row_mut(i), weight, solved.row(t));
        }
    }
    let mut from_below = Vec::with_capacity(e.len());
    for e in &mut e {
        let mut rest = e.split_off(common);
        from_below.push(rest.clone());
        factor.solve(&mut rest, zero);
        for (t, value) in rest.iter().enumerate() {
            subtract_scaled(e, *value, coupling.row(t));
        }
    }
    ((outer, e), Some(Trapped { factor, coupling, from_below }))
}

impl<S: Simd> Crossing<S> {
    /// The streams that only exist above are reflected totally: their difference is 0.
    #[inline(always)]
    pub fn seen_from_above(&self, simd: S) -> Answering<S> {
        let common = self.admittance.columns;
        let zero = Re::splat(simd, 0.0);
        let mut z = Matrix::zeros(simd, self.above, self.above);
        for i in 0..common {
            z.row_mut(i)[..common].copy_from_slice(self.answer.row(i));
        }
        let mut sources = Vec::with_capacity(self.from_below.len());
        for e in &self.from_below {
            let mut e = self.series.carry(simd, &self.answer, e, None);
            e.resize(self.above, zero);
            sources.push(e);
        }
        (z, sources)
    }

    #[inline(always)]
    pub fn descend(&self, simd: S, drive: usize, above: &Level<S>) -> Level<S> {
        let zero = Re::splat(simd, 0.0);
        let common = self.admittance.columns;
        let e = &self.from_below[drive];
        let mut s = self.series.drop(simd, e, Some(&above.s[..common]));
        self.series.divide(simd, &mut s);
        let mut d = apply_add(&self.admittance, &s, e, zero);
        if let Some(Trapped { factor, coupling, from_below }) = &self.trapped {
            let mut rest = apply_add(coupling, &s, &from_below[drive], zero);
            scale(&mut rest, Re::splat(simd, -1.0));
            factor.solve(&mut rest, zero);
            d.resize(common + rest.len(), zero);
            s.extend(rest);
        }
        Level { s, d }
    }
}
