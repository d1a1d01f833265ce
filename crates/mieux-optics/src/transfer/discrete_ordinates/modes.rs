//! The modes of a homogeneous layer.
//!
//! With `s` and `d` the sum and the difference of the radiances down and up, each stream weighted by the square root of
//! the flux it stands for, the discrete transfer equation is `s' = -A d`, `d' = -B s`, with `A` and `B` symmetric and
//! positive. The vectors `X` with `X X^T = A` and `X^T B X = K^2` diagonal turn it into independent pairs
//! `f' = -g`, `g' = -k^2 f` with `s = X f`, `d = Y g` and `Y = A^-1 X`, so that `X^T Y = 1`. Nothing degenerates for a layer
//! that absorbs nothing: there one `k` is 0.
//!
//! `A` and `B` are what `stamnes1988` reduces the equation to, made symmetric as in `nakajima1986`; but their product is
//! never formed. `k` are the singular values of the product of their Cholesky factors, found by rotating columns until
//! they are orthogonal (one-sided Jacobi, `demmel1992`), which keeps the digits of the small ones: these decide what a
//! thick layer does.

use pulp::Simd;

use super::legendre::{Orders, Recurrence};
use super::matrix::{Cholesky, Matrix, add_scaled, apply, dot, multiply, scale, subtract_scaled};
use crate::lanes::{LaneArray, Re, step};

/// What the streams of a medium are, and the Legendre functions at them.
pub(super) struct Table<S: Simd> {
    pub cosines: Vec<Re<S>>,
    /// Square roots of the cosines.
    roots: Vec<Re<S>>,
    pub weights: Vec<Re<S>>,
    pub index: Re<S>,
    /// `sqrt(w) L_j(mu)`: a row a stream, a column a degree `l - m`.
    pub functions: Matrix<S>,
    /// Those of even degree, reflected so that the constant one is the first axis (in lanes of order 0), and those of odd.
    halves: [Matrix<S>; 2],
    /// The pairs of modes, round by round.
    tournament: Vec<[usize; 2]>,
    /// The square root of the flux, over pi, of each stream if its basic radiance is 1: `n sqrt(w mu)`.
    pub root_fluxes: Vec<Re<S>>,
    pub recurrence: Recurrence<S>,
    /// Which turns the constant function into the first axis, in lanes of order 0; and 2 over its square.
    reflector: (Vec<Re<S>>, Re<S>),
    /// 1 in lanes of order 0, 0 in others.
    axial: Re<S>,
    /// The inverse length of the constant function, all but 1, in lanes of order 0; 1 in others.
    constant: Re<S>,
}

impl<S: Simd> Table<S> {
    /// For `count` degrees from the order of each lane on.
    #[inline(always)]
    pub fn new(simd: S, cosines: Vec<Re<S>>, weights: Vec<Re<S>>, index: Re<S>, orders: Orders, count: usize) -> Self {
        let recurrence = Recurrence::new(simd, orders, count);
        let (zero, one) = (Re::splat(simd, 0.0), Re::splat(simd, 1.0));
        let mut functions = Vec::with_capacity(cosines.len() * count);
        for (cosine, weight) in cosines.iter().zip(&weights) {
            let first = functions.len();
            recurrence.append(simd, *cosine, &mut functions);
            let root = weight.sqrt();
            scale(&mut functions[first..], root);
        }
        let mut functions = Matrix { columns: count, data: functions };
        let axial: LaneArray = orders.map(|m| if m == 0 { 1.0 } else { 0.0 });
        let axial = Re::load(simd, &axial);
        let n = cosines.len();
        // Under refraction the rule integrates polynomials almost but not quite. So that no light is made or lost, the
        // other even functions are made orthogonal to the constant one.
        let mut constant = Vec::with_capacity(n);
        for i in 0..n {
            constant.push(functions.row(i)[0]);
        }
        let norm = one / dot(&constant, &constant, zero).max(Re::splat(simd, 1e-300)).sqrt();
        scale(&mut constant, norm * axial);
        let constant_length = one + axial * (norm - one);
        let mut overlap = vec![zero; count];
        for (i, share) in constant.iter().enumerate() {
            add_scaled(&mut overlap, *share, functions.row(i));
        }
        for (j, value) in overlap.iter_mut().enumerate() {
            if j == 0 || j % 2 == 1 {
                *value = zero;
            }
        }
        for (i, share) in constant.iter().enumerate() {
            let row = functions.row_mut(i);
            subtract_scaled(row, *share, &overlap);
            row[0] = row[0] + axial * (constant[i] - row[0]);
        }
        let mut mirror = constant;
        mirror[0] = mirror[0] + axial;
        let twice = axial * Re::splat(simd, 2.0) / dot(&mirror, &mirror, zero).max(Re::splat(simd, 1e-300));
        let reflector = (mirror, twice);
        let mut even = every_second(&functions, 0);
        reflect(&reflector, &mut even, zero);
        // What is known to be 0 is 0.
        let other = one - axial;
        scale(even.row_mut(0), other);
        for i in 0..n {
            let value = even.row(i)[0] * other;
            even.row_mut(i)[0] = if i == 0 { value + axial } else { value };
        }
        let halves = [even, every_second(&functions, 1)];
        let (mut roots, mut root_fluxes) = (Vec::with_capacity(n), Vec::with_capacity(n));
        for (cosine, weight) in cosines.iter().zip(&weights) {
            roots.push(cosine.sqrt());
            root_fluxes.push(index * (*weight * *cosine).sqrt());
        }
        Self {
            cosines,
            roots,
            weights,
            index,
            functions,
            halves,
            tournament: tournament(n),
            root_fluxes,
            recurrence,
            reflector,
            axial,
            constant: constant_length,
        }
    }
}

/// The columns of one parity.
#[inline(always)]
fn every_second<S: Simd>(matrix: &Matrix<S>, parity: usize) -> Matrix<S> {
    let columns = (matrix.columns + 1 - parity) / 2;
    let mut data = Vec::with_capacity(matrix.rows() * columns);
    for i in 0..matrix.rows() {
        for j in 0..columns {
            data.push(matrix.row(i)[2 * j + parity]);
        }
    }
    Matrix { columns, data }
}

/// The modes of a layer.
pub(super) struct Modes<S: Simd> {
    /// A row a mode, a column a stream.
    pub x: Matrix<S>,
    pub y: Matrix<S>,
    pub k: Vec<Re<S>>,
    /// `albedo (2 l + 1) chi_l` for each degree of the table.
    pub strength: Vec<Re<S>>,
    /// The least pivot: not positive where the moments are not of a phase function.
    pub least: Re<S>,
}

impl<S: Simd> Modes<S> {
    /// `loss` is one minus the albedo.
    #[inline(always)]
    pub fn new(simd: S, table: &Table<S>, strength: Vec<Re<S>>, loss: Re<S>) -> Self {
        step(
            simd,
            #[inline(always)]
            || Self::find(simd, table, strength, loss),
        )
    }

    #[inline(always)]
    fn find(simd: S, table: &Table<S>, strength: Vec<Re<S>>, loss: Re<S>) -> Self {
        let n = table.cosines.len();
        let one = Re::splat(simd, 1.0);
        let [even, odd] = &table.halves;
        let (odd, least_odd) = Cholesky::new(simd, remainder(simd, n, odd, &strength, 1));
        let mut even = remainder(simd, n, even, &strength, 0);
        even.data[0] = even.data[0] + table.axial * (loss - even.data[0]);
        let lossless = Re::splat(simd, 1e-15);
        let (even, mut least_even) = Cholesky::new(simd, even);
        // Without loss, order 0 has one pivot of exactly 0.
        least_even = least_even + table.axial * lossless;

        // Columns of M^-1 H L_E, then G^T = L_O^T (M^-1 H L_E).
        let mut right = even.into_factor();
        reflect(&table.reflector, &mut right, one.same(0.0));
        let mut x = Matrix::zeros(simd, n, n);
        let mut g = Matrix::zeros(simd, n, n);
        for i in 0..n {
            let inverse = one / table.cosines[i];
            let root = inverse.sqrt();
            for k in 0..=i {
                let factor = if k == i { odd.diagonal(i) } else { odd.0.row(i)[k] };
                x.data[k * n + i] = factor * root;
                let scaled = factor * inverse;
                add_scaled(g.row_mut(k), scaled, right.row(i));
            }
        }
        let k = orthogonalise(simd, &table.tournament, &mut g, &mut x);
        let mut y = g;
        y.data.copy_from_slice(&x.data);
        conjugate(simd, table, &odd, &mut y);
        Self { x, y, k, strength, least: least_odd.if_less(least_even, least_odd, least_even) }
    }

    /// How light from or into one direction drives the even and the odd part of each mode: `X^T M^-1/2 sum_j c_j L_j(mu)
    /// p_j / n` over even `j`, and the same of `Y` over odd.
    #[inline(always)]
    pub fn coupling(&self, simd: S, table: &Table<S>, cosine: Re<S>) -> [Vec<Re<S>>; 2] {
        step(
            simd,
            #[inline(always)]
            || self.couple(simd, table, cosine),
        )
    }

    #[inline(always)]
    fn couple(&self, simd: S, table: &Table<S>, cosine: Re<S>) -> [Vec<Re<S>>; 2] {
        let zero = Re::splat(simd, 0.0);
        let mut there = Vec::with_capacity(self.strength.len());
        table.recurrence.append(simd, cosine, &mut there);
        multiply(&mut there, &self.strength);
        // So that a beam scatters all it loses.
        there[0] = there[0] * table.constant;
        let n = table.cosines.len();
        let mut parts = [vec![zero; n], vec![zero; n]];
        let [even, odd] = &mut parts;
        for (i, (even, odd)) in even.iter_mut().zip(odd).enumerate() {
            let mut sums = [zero; 2];
            let pairs = table.functions.row(i).chunks(2).zip(there.chunks(2));
            for (functions, there) in pairs {
                for parity in 0..functions.len() {
                    sums[parity] = functions[parity].mul_add(there[parity], sums[parity]);
                }
            }
            let scale = Re::splat(simd, 1.0) / (table.roots[i] * table.index);
            *even = sums[0] * scale;
            *odd = sums[1] * scale;
        }
        [apply(&self.x, &parts[0], zero), apply(&self.y, &parts[1], zero)]
    }

    /// The sum of the rows of `matrix`, each times its factor.
    #[inline(always)]
    pub fn combine(&self, simd: S, matrix: &Matrix<S>, factors: &[Re<S>]) -> Vec<Re<S>> {
        let mut sum = vec![Re::splat(simd, 0.0); matrix.columns];
        for (k, factor) in factors.iter().enumerate() {
            add_scaled(&mut sum, *factor, matrix.row(k));
        }
        sum
    }
}

/// The lower half of `1 - sum_j c_j p_j p_j^T`, for `n` streams, over degrees of one parity (of which there may be none).
#[inline(always)]
fn remainder<S: Simd>(simd: S, n: usize, functions: &Matrix<S>, strength: &[Re<S>], parity: usize) -> Matrix<S> {
    let (zero, one) = (Re::splat(simd, 0.0), Re::splat(simd, 1.0));
    let mut weighted = vec![zero; functions.columns];
    let mut matrix = Matrix::zeros(simd, n, n);
    for i in 0..n {
        let row = functions.row(i);
        for (j, value) in weighted.iter_mut().enumerate() {
            *value = row[j] * strength[2 * j + parity];
        }
        for j in 0..=i {
            let scattered = dot(&weighted, functions.row(j), zero);
            matrix.data[i * n + j] = if i == j { one - scattered } else { zero - scattered };
        }
    }
    matrix
}

/// `H A` in place, with the mirror of `H` and 2 over its square.
#[inline(always)]
fn reflect<S: Simd>((mirror, twice): &(Vec<Re<S>>, Re<S>), a: &mut Matrix<S>, zero: Re<S>) {
    let mut along = vec![zero; a.columns];
    for (i, share) in mirror.iter().enumerate() {
        add_scaled(&mut along, *share * *twice, a.row(i));
    }
    for (i, share) in mirror.iter().enumerate() {
        subtract_scaled(a.row_mut(i), *share, &along);
    }
}

/// From `X` to `Y = A^-1 X = M^1/2 O^-1 M^1/2 X`, mode by mode.
#[inline(always)]
fn conjugate<S: Simd>(simd: S, table: &Table<S>, odd: &Cholesky<S>, modes: &mut Matrix<S>) {
    let zero = Re::splat(simd, 0.0);
    for k in 0..modes.rows() {
        let row = modes.row_mut(k);
        multiply(row, &table.roots);
        odd.solve(row, zero);
        multiply(row, &table.roots);
    }
}

/// Two rows are orthogonal when their cosine is smaller than this.
const ORTHOGONAL: f64 = 3e-15;

/// A row this much smaller than the greatest is nothing but rounding.
const VANISHED: f64 = 1e-15;

/// Convergence is quadratic; six sweeps are usual.
const MAX_SWEEPS: usize = 16;

/// Rotates pairs of rows of `g`, and of `x` alike, until the rows of `g` are orthogonal; gives their lengths.
#[inline(always)]
fn orthogonalise<S: Simd>(simd: S, tournament: &[[usize; 2]], g: &mut Matrix<S>, x: &mut Matrix<S>) -> Vec<Re<S>> {
    let n = g.rows();
    let splat = |value: f64| Re::splat(simd, value);
    let zero = splat(0.0);
    let mut squares = vec![zero; n];
    let abreast = (n / 2).max(1);
    let mut turns: Vec<Turn<S>> = Vec::with_capacity(abreast);
    for _ in 0..MAX_SWEEPS {
        let mut greatest = zero;
        for (k, square) in squares.iter_mut().enumerate() {
            *square = dot(g.row(k), g.row(k), zero);
            greatest = greatest.max(*square);
        }
        let floor = greatest * splat(VANISHED * VANISHED);
        let mut turned = false;
        for round in tournament.chunks(abreast) {
            for rows in round {
                let gamma = dot(g.row(rows[0]), g.row(rows[1]), zero);
                turns.extend(Turn::needed(simd, &squares, *rows, gamma, floor));
            }
            turned |= !turns.is_empty();
            for turn in &mut turns {
                turn.aim(simd, &mut squares);
            }
            for turn in turns.drain(..) {
                turn.rotate(g);
                turn.rotate(x);
            }
        }
        if !turned {
            break;
        }
    }
    for (k, square) in squares.iter_mut().enumerate() {
        *square = dot(g.row(k), g.row(k), zero).sqrt();
    }
    squares
}

/// All pairs of `n` rows, the lesser first, in the order of a tournament: the `n / 2` of a round have no row in common, so
/// that one need not wait for another.
fn tournament(n: usize) -> Vec<[usize; 2]> {
    // With an odd number one row rests in each round.
    let others = 2 * n.div_ceil(2) - 1;
    let pair = |round: usize, k: usize| {
        let first = if k == 0 { others } else { (round + k) % others };
        let second = (round + others - k) % others;
        [first.min(second), first.max(second)]
    };
    let all = (0..others).flat_map(|round| (0..=others / 2).map(move |k| pair(round, k)));
    all.filter(|[_, last]| *last < n).collect()
}

/// A rotation of two rows that makes them orthogonal.
#[derive(Clone, Copy)]
struct Turn<S: Simd> {
    rows: [usize; 2],
    /// The product of the rows; 0 in lanes that are not turned.
    gamma: Re<S>,
    cosine: Re<S>,
    sine: Re<S>,
}

impl<S: Simd> Turn<S> {
    /// If rows with this product need it in any lane; lanes that are done, or hold rounding only, are not turned.
    #[inline(always)]
    fn needed(simd: S, squares: &[Re<S>], rows: [usize; 2], gamma: Re<S>, floor: Re<S>) -> Option<Self> {
        let (zero, one) = (Re::splat(simd, 0.0), Re::splat(simd, 1.0));
        let [a, b] = [squares[rows[0]], squares[rows[1]]];
        let allowed = a * b * Re::splat(simd, ORTHOGONAL * ORTHOGONAL);
        let present = a.if_less(floor, zero, b.if_less(floor, zero, one));
        let excess = gamma * gamma * present;
        let turn = Self { rows, gamma: allowed.if_less(excess, gamma, zero), cosine: one, sine: zero };
        if allowed.any_less(excess) { Some(turn) } else { None }
    }

    /// Finds the angle.
    #[inline(always)]
    fn aim(&mut self, simd: S, squares: &mut [Re<S>]) {
        let (zero, one) = (Re::splat(simd, 0.0), Re::splat(simd, 1.0));
        let [p, q] = self.rows;
        let twice = self.gamma + self.gamma;
        let difference = squares[q] - squares[p];
        let length = twice.mul_add(twice, difference * difference).sqrt() + difference.abs();
        let tangent = twice / difference.if_less(zero, zero - length, length.max(Re::splat(simd, 1e-300)));
        self.cosine = one / tangent.mul_add(tangent, one).sqrt();
        self.sine = self.cosine * tangent;
        squares[p] = tangent.neg_mul_add(self.gamma, squares[p]);
        squares[q] = tangent.mul_add(self.gamma, squares[q]);
    }

    #[inline(always)]
    fn rotate(&self, matrix: &mut Matrix<S>) {
        let (upper, lower) = matrix.two_rows(self.rows[0], self.rows[1]);
        for (p, q) in upper.iter_mut().zip(lower) {
            let (a, b) = (*p, *q);
            *p = self.sine.neg_mul_add(b, self.cosine * a);
            *q = self.sine.mul_add(a, self.cosine * b);
        }
    }
}
