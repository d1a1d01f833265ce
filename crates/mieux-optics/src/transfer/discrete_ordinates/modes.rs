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
    pub weights: Vec<Re<S>>,
    pub index: Re<S>,
    /// `sqrt(w) L_j(mu)`: a row a stream, a column a degree `l - m`.
    pub functions: Matrix<S>,
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
        Self {
            cosines,
            weights,
            index,
            functions,
            recurrence,
            reflector: (mirror, twice),
            axial,
            constant: constant_length,
        }
    }

    /// The square root of the flux that a stream of basic radiance 1 carries, over pi: `n sqrt(w mu)`.
    #[inline(always)]
    pub fn root_flux(&self, i: usize) -> Re<S> {
        self.index * (self.weights[i] * self.cosines[i]).sqrt()
    }

    /// [`Self::root_flux`] of all.
    #[inline(always)]
    pub fn root_fluxes(&self) -> Vec<Re<S>> {
        let mut roots = Vec::with_capacity(self.cosines.len());
        for i in 0..self.cosines.len() {
            roots.push(self.root_flux(i));
        }
        roots
    }

    /// The functions reflected so that the constant one is the first axis (in lanes of order 0), a row a stream.
    #[inline(always)]
    fn reflected(&self, simd: S) -> Matrix<S> {
        let count = self.functions.columns;
        let (mirror, twice) = &self.reflector;
        let mut along = vec![Re::splat(simd, 0.0); count];
        for (i, share) in mirror.iter().enumerate() {
            add_scaled(&mut along, *share * *twice, self.functions.row(i));
        }
        let mut reflected = self.functions.clone();
        for (i, share) in mirror.iter().enumerate() {
            subtract_scaled(reflected.row_mut(i), *share, &along);
        }
        // What is known to be 0 is 0.
        let other = Re::splat(simd, 1.0) - self.axial;
        scale(reflected.row_mut(0), other);
        for i in 0..mirror.len() {
            let value = reflected.row(i)[0] * other;
            reflected.row_mut(i)[0] = if i == 0 { value + self.axial } else { value };
        }
        reflected
    }
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
        let (odd, least_odd) = Cholesky::new(simd, remainder(simd, &table.functions, &strength, 1));
        let mut even = remainder(simd, &table.reflected(simd), &strength, 0);
        even.data[0] = even.data[0] + table.axial * (loss - even.data[0]);
        let lossless = Re::splat(simd, 1e-15);
        let (even, mut least_even) = Cholesky::new(simd, even);
        // Without loss, order 0 has one pivot of exactly 0.
        least_even = least_even + table.axial * lossless;
        let odd_factor = with_diagonal(&odd, one);
        let even_factor = with_diagonal(&even, one);

        // Columns of M^-1 H L_E, then G^T = L_O^T (M^-1 H L_E).
        let right = self::reflect(simd, table, even_factor);
        let mut x = Matrix::zeros(simd, n, n);
        let mut g = Matrix::zeros(simd, n, n);
        for i in 0..n {
            let inverse = one / table.cosines[i];
            let root = inverse.sqrt();
            for k in 0..=i {
                let factor = odd_factor.row(i)[k];
                x.data[k * n + i] = factor * root;
                let scaled = factor * inverse;
                add_scaled(g.row_mut(k), scaled, right.row(i));
            }
        }
        let k = orthogonalise(simd, &mut g, &mut x);
        let y = conjugate(simd, table, &odd, &x);
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
            let scale = Re::splat(simd, 1.0) / (table.cosines[i].sqrt() * table.index);
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

/// The lower half of `1 - sum_j c_j p_j p_j^T` over degrees of one parity.
#[inline(always)]
fn remainder<S: Simd>(simd: S, functions: &Matrix<S>, strength: &[Re<S>], parity: usize) -> Matrix<S> {
    let n = functions.rows();
    let (zero, one) = (Re::splat(simd, 0.0), Re::splat(simd, 1.0));
    let count = (functions.columns + 1 - parity) / 2;
    let mut rows = Matrix { columns: count, data: Vec::with_capacity(n * count) };
    let mut weighted = Matrix { columns: count, data: Vec::with_capacity(n * count) };
    for i in 0..n {
        let row = functions.row(i);
        for j in (parity..functions.columns).step_by(2) {
            rows.data.push(row[j]);
            weighted.data.push(row[j] * strength[j]);
        }
    }
    let mut matrix = Matrix::zeros(simd, n, n);
    for i in 0..n {
        for j in 0..=i {
            let scattered = dot(&weighted.data[i * count..][..count], &rows.data[j * count..][..count], zero);
            matrix.data[i * n + j] = if i == j { one - scattered } else { zero - scattered };
        }
    }
    matrix
}

/// The factor with its own diagonal instead of the inverse.
#[inline(always)]
fn with_diagonal<S: Simd>(cholesky: &Cholesky<S>, one: Re<S>) -> Matrix<S> {
    let mut factor = cholesky.0.clone();
    let n = factor.columns;
    let zero = one.same(0.0);
    for i in 0..n {
        let inverse = factor.data[i * n + i];
        factor.data[i * n + i] = zero.if_less(inverse, one / inverse.max(one.same(1e-300)), zero);
    }
    factor
}

/// `H L`.
#[inline(always)]
fn reflect<S: Simd>(simd: S, table: &Table<S>, mut factor: Matrix<S>) -> Matrix<S> {
    let (mirror, twice) = &table.reflector;
    let mut along = vec![Re::splat(simd, 0.0); factor.columns];
    for (i, share) in mirror.iter().enumerate() {
        add_scaled(&mut along, *share * *twice, factor.row(i));
    }
    for (i, share) in mirror.iter().enumerate() {
        subtract_scaled(factor.row_mut(i), *share, &along);
    }
    factor
}

/// `Y = A^-1 X = M^1/2 O^-1 M^1/2 X`, mode by mode.
#[inline(always)]
fn conjugate<S: Simd>(simd: S, table: &Table<S>, odd: &Cholesky<S>, x: &Matrix<S>) -> Matrix<S> {
    let zero = Re::splat(simd, 0.0);
    let mut roots = table.cosines.clone();
    for root in &mut roots {
        *root = root.sqrt();
    }
    let mut y = x.clone();
    for k in 0..y.rows() {
        let row = y.row_mut(k);
        multiply(row, &roots);
        odd.solve(row, zero);
        multiply(row, &roots);
    }
    y
}

/// Two rows are orthogonal when their cosine is smaller than this.
const ORTHOGONAL: f64 = 3e-15;

/// A row this much smaller than the greatest is nothing but rounding.
const VANISHED: f64 = 1e-15;

/// Convergence is quadratic; six sweeps are usual.
const MAX_SWEEPS: usize = 16;

/// Rotates pairs of rows of `g`, and of `x` alike, until the rows of `g` are orthogonal; gives their lengths.
///
/// Pairs come in the order of a tournament: neighbours have no row in common, so that one need not wait for another.
#[inline(always)]
fn orthogonalise<S: Simd>(simd: S, g: &mut Matrix<S>, x: &mut Matrix<S>) -> Vec<Re<S>> {
    let n = g.rows();
    let splat = |value: f64| Re::splat(simd, value);
    let zero = splat(0.0);
    let mut squares = vec![zero; n];
    // With an odd number one row rests in each round.
    let others = 2 * n.div_ceil(2) - 1;
    for _ in 0..MAX_SWEEPS {
        let mut greatest = zero;
        for (k, square) in squares.iter_mut().enumerate() {
            *square = dot(g.row(k), g.row(k), zero);
            greatest = greatest.max(*square);
        }
        let floor = greatest * splat(VANISHED * VANISHED);
        let mut turned = false;
        for round in 0..others {
            for k in 0..=others / 2 {
                let first = if k == 0 { others } else { (round + k) % others };
                let second = (round + others - k) % others;
                let (p, q) = if first < second { (first, second) } else { (second, first) };
                if q < n {
                    turned |= orthogonalise_pair(simd, g, x, &mut squares, (p, q), floor);
                }
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

/// Whether the rows had to be turned in any lane.
#[inline(always)]
fn orthogonalise_pair<S: Simd>(
    simd: S,
    g: &mut Matrix<S>,
    x: &mut Matrix<S>,
    squares: &mut [Re<S>],
    (p, q): (usize, usize),
    floor: Re<S>,
) -> bool {
    let (zero, one) = (Re::splat(simd, 0.0), Re::splat(simd, 1.0));
    let (a, b) = (squares[p], squares[q]);
    let (upper, lower) = g.two_rows(p, q);
    let gamma = dot(upper, lower, zero);
    // Lanes that are done, or hold rounding only, are not turned.
    let allowed = a * b * Re::splat(simd, ORTHOGONAL * ORTHOGONAL);
    let present = a.if_less(floor, zero, b.if_less(floor, zero, one));
    let excess = gamma * gamma * present;
    if !allowed.any_less(excess) {
        return false;
    }
    let gamma = allowed.if_less(excess, gamma, zero);
    let twice = gamma + gamma;
    let difference = b - a;
    let length = twice.mul_add(twice, difference * difference).sqrt() + difference.abs();
    let tangent = twice / difference.if_less(zero, zero - length, length.max(Re::splat(simd, 1e-300)));
    let cosine = one / tangent.mul_add(tangent, one).sqrt();
    let sine = cosine * tangent;
    squares[p] = tangent.neg_mul_add(gamma, a);
    squares[q] = tangent.mul_add(gamma, b);
    rotate(upper, lower, cosine, sine);
    let (upper, lower) = x.two_rows(p, q);
    rotate(upper, lower, cosine, sine);
    true
}

#[inline(always)]
fn rotate<S: Simd>(p: &mut [Re<S>], q: &mut [Re<S>], cosine: Re<S>, sine: Re<S>) {
    for (p, q) in p.iter_mut().zip(q) {
        let (a, b) = (*p, *q);
        *p = sine.neg_mul_add(b, cosine * a);
        *q = sine.mul_add(a, cosine * b);
    }
}
