//! One layer, from thin to thick.
//!
//! With `s` and `d` the sum and the difference of the streams down and up, each weighted by the root of the flux it stands
//! for, a layer is `s' = -P d`, `d' = -Q s`, with `P` and `Q` symmetric and positive. Lit alike from both sides it answers
//! with `d = Y s`, lit with opposite signs with `d = (Y + 2 B) s`: as `tanh` and `coth` of half its thickness. Two such
//! layers on each other have
//!
//! ```text
//! Y' = 2 Y - Y (Y + B)^-1 Y,    B' = B (Y + B)^-1 B / 2,
//! ```
//!
//! which is the doubling of reflection and transmission (`vandehulst1980`) written for their sum and difference. There
//! `Y` and `Y + 2 B` become their harmonic and arithmetic mean; nothing cancels, `B` keeps all its digits however little
//! passes, and where nothing is absorbed the row and column of `Y` that say so stay exactly 0.
//!
//! The first layer is no thin-layer approximation but a rational one of `tanh` and `coth`, exact to rounding up to an
//! optical thickness along the slowest stream of about 1.

use pulp::Simd;

use super::algebra::{reflect_both_sides, solve_rows, solve_rows_lower};
use super::table::Table;
use crate::lanes::{LaneArray, MAX_LANES, Re};
use crate::transfer::discrete_ordinates::matrix::{
    Cholesky, Matrix, dot, multiply, product, scale, symmetric_product_into,
};
use crate::transfer::discrete_ordinates::plan::Plan;

/// What a layer reflects and transmits: amplitudes of streams, symmetric, and the same from both sides.
pub(super) struct Slab<S: Simd> {
    pub reflection: Matrix<S>,
    pub transmission: Matrix<S>,
    /// Not positive in lanes whose moments are not of a phase function.
    pub least: Re<S>,
}

/// The coefficients of the numerator of the [7/7] Pade approximant of `exp(y)`; those of the denominator have alternating
/// signs. Its error up to `y = 1` is `7!^2 / (14! 15!) = 2e-16`.
const PADE: [f64; 8] = {
    let mut c = [1.0; 8];
    let mut j = 1;
    while j < 8 {
        c[j] = c[j - 1] * (8 - j) as f64 / (j * (15 - j)) as f64;
        j += 1;
    }
    c
};

/// Thinner layers than this scatter nothing that shows. What is caught in one by total reflection is lost so slowly that its
/// sum over passages would be one of rounding.
pub(super) const THINNEST: f64 = 1e-12;

impl<S: Simd> Slab<S> {
    #[inline(always)]
    pub fn new(simd: S, plans: &[&Plan; MAX_LANES], layer: usize, table: &Table<S>) -> Self {
        let (zero, one) = (Re::splat(simd, 0.0), Re::splat(simd, 1.0));
        let n = table.len();
        let (p, q, least_even) = rates(simd, plans, layer, table);
        let (factor, least_odd) = Cholesky::new(simd, p);
        let lower = with_own_diagonal(&factor, zero);
        let thickness: LaneArray = std::array::from_fn(|lane| plans[lane].layers[layer].thickness.max(THINNEST));
        let thickness = Re::load(simd, &thickness);
        let c = congruent(simd, &lower, &q);
        let doublings = doublings(&c, thickness);
        let thin = thickness * Re::splat(simd, 0.5f64.powi(doublings));
        let (mut y, mut b) = start(simd, c, thin);
        double(simd, doublings, &mut y, &mut b);

        // Back from the factor of P: (1 + Y)^-1 = L (L^T L + Y)^-1 L^T.
        let mut upper = lower.clone();
        for i in 0..n {
            for j in 0..n {
                upper.data[i * n + j] = lower.data[j * n + i];
            }
        }
        let mut even = Matrix::zeros(simd, n, n);
        symmetric_product_into(&upper, &upper, zero, &mut even);
        let mut odd = even.clone();
        for i in 0..n * n {
            even.data[i] = even.data[i] + y.data[i];
            odd.data[i] = odd.data[i] + y.data[i] + b.data[i] + b.data[i];
        }
        let (mut even_answer, mut odd_answer) = (lower.clone(), lower.clone());
        solve_rows(&Cholesky::new(simd, even).0, &mut even_answer, zero);
        solve_rows(&Cholesky::new(simd, odd).0, &mut odd_answer, zero);
        let half = product(simd, &even_answer, &b);
        let mut transmission = Matrix::zeros(simd, n, n);
        symmetric_product_into(&half, &odd_answer, zero, &mut transmission);
        scale(&mut transmission.data, Re::splat(simd, 2.0));
        for (sum, other) in even_answer.data.iter_mut().zip(&odd_answer.data) {
            *sum = *sum + *other;
        }
        let mut reflection = Matrix::zeros(simd, n, n);
        symmetric_product_into(&lower, &even_answer, zero, &mut reflection);
        for i in 0..n {
            reflection.data[i * n + i] = reflection.data[i * n + i] - one;
        }
        reflect_both_sides(&mut reflection, &table.mirror, zero);
        reflect_both_sides(&mut transmission, &table.mirror, zero);
        Self { reflection, transmission, least: least_odd.if_less(least_even, least_odd, least_even) }
    }
}

/// `P` and `Q`, reflected so that equal radiance is the last axis, and the least pivot of `Q` without it.
#[inline(always)]
fn rates<S: Simd>(
    simd: S,
    plans: &[&Plan; MAX_LANES],
    layer: usize,
    table: &Table<S>,
) -> (Matrix<S>, Matrix<S>, Re<S>) {
    let zero = Re::splat(simd, 0.0);
    let n = table.len();
    let mut even = rate(simd, plans, layer, table, 0);
    let mut odd = rate(simd, plans, layer, table, 1);
    reflect_both_sides(&mut even, &table.mirror, zero);
    reflect_both_sides(&mut odd, &table.mirror, zero);
    // What is known of equal radiance.
    let loss: LaneArray = std::array::from_fn(|lane| plans[lane].layers[layer].loss);
    let loss = Re::load(simd, &loss);
    for (i, share) in table.even_loss.iter().enumerate() {
        let value = loss * *share;
        even.data[i * n + n - 1] = value;
        even.data[(n - 1) * n + i] = value;
    }
    let mut rest = Matrix::zeros(simd, n - 1, n - 1);
    for i in 0..n - 1 {
        rest.row_mut(i).copy_from_slice(&even.row(i)[..n - 1]);
    }
    let (_, least) = Cholesky::new(simd, rest);
    (odd, even, least)
}

/// `M^-1/2 (1 - sum_l c_l p_l p_l^T) M^-1/2` over degrees of one parity.
#[inline(always)]
fn rate<S: Simd>(simd: S, plans: &[&Plan; MAX_LANES], layer: usize, table: &Table<S>, parity: usize) -> Matrix<S> {
    let n = table.len();
    let zero = Re::splat(simd, 0.0);
    let degrees = table.functions.columns.saturating_sub(parity).div_ceil(2);
    let mut functions = Matrix { columns: degrees, data: Vec::with_capacity(n * degrees) };
    for i in 0..n {
        functions.data.extend(table.functions.row(i).iter().skip(parity).step_by(2));
    }
    let mut strength = Vec::with_capacity(degrees);
    for j in 0..degrees {
        let mut lanes = [0.0; MAX_LANES];
        for (lane, out) in lanes.iter_mut().enumerate() {
            let (scaled, degree) = (&plans[lane].layers[layer], 2 * j + parity);
            *out = scaled.strength(degree);
        }
        strength.push(Re::load(simd, &lanes));
    }
    let mut rate = Matrix::zeros(simd, n, n);
    for i in 0..n {
        let mut weighted = functions.row(i).to_vec();
        multiply(&mut weighted, &strength);
        for j in 0..=i {
            let scattered = dot(&weighted, functions.row(j), zero) * table.inverse_root[i] * table.inverse_root[j];
            rate.data[i * n + j] = zero - scattered;
            rate.data[j * n + i] = zero - scattered;
        }
        rate.data[i * n + i] = rate.data[i * n + i] + Re::splat(simd, 1.0) / table.cosines[i];
    }
    rate
}

/// The factor with its own diagonal instead of the inverse.
#[inline(always)]
fn with_own_diagonal<S: Simd>(cholesky: &Cholesky<S>, zero: Re<S>) -> Matrix<S> {
    let mut factor = cholesky.0.clone();
    let n = factor.columns;
    for i in 0..n {
        let inverse = factor.data[i * n + i];
        factor.data[i * n + i] = zero.if_less(inverse, zero.same(1.0) / inverse.max(zero.same(1e-300)), zero);
    }
    factor
}

/// `L^T Q L`.
#[inline(always)]
fn congruent<S: Simd>(simd: S, lower: &Matrix<S>, q: &Matrix<S>) -> Matrix<S> {
    let n = q.columns;
    let zero = Re::splat(simd, 0.0);
    let mut upper = Matrix::zeros(simd, n, n);
    for i in 0..n {
        for j in i..n {
            upper.data[i * n + j] = lower.data[j * n + i];
        }
    }
    let half = product(simd, &upper, q);
    let mut c = Matrix::zeros(simd, n, n);
    symmetric_product_into(&half, &upper, zero, &mut c);
    c
}

/// How often the layer is halved until the rational start is exact, in every lane.
#[inline(always)]
fn doublings<S: Simd>(c: &Matrix<S>, thickness: Re<S>) -> i32 {
    let zero = thickness.same(0.0);
    let mut norm = zero;
    for i in 0..c.columns {
        let mut sum = zero;
        for value in c.row(i) {
            sum = sum + value.abs();
        }
        norm = norm.max(sum);
    }
    let reach = (norm.sqrt() * thickness).lanes();
    let mut most = 0;
    for reach in &reach[..S::F64_LANES.min(MAX_LANES)] {
        if reach.is_finite() && *reach > 1.0 {
            most = most.max(reach.log2().ceil() as i32);
        }
    }
    most
}

/// `Y` and `B` of a layer with `t^2 C <= 1`.
#[inline(always)]
fn start<S: Simd>(simd: S, c: Matrix<S>, t: Re<S>) -> (Matrix<S>, Matrix<S>) {
    let n = c.columns;
    let zero = Re::splat(simd, 0.0);
    let mut constants = [zero; 8];
    for (constant, value) in constants.iter_mut().zip(PADE) {
        *constant = Re::splat(simd, value);
    }
    let mut z = c;
    scale(&mut z.data, t * t);
    let (mut z2, mut z3) = (Matrix::zeros(simd, n, n), Matrix::zeros(simd, n, n));
    symmetric_product_into(&z, &z, zero, &mut z2);
    symmetric_product_into(&z2, &z, zero, &mut z3);
    let (mut even, mut odd) = (Matrix::zeros(simd, n, n), Matrix::zeros(simd, n, n));
    for i in 0..n * n {
        let (z, z2, z3) = (z.data[i], z2.data[i], z3.data[i]);
        even.data[i] = constants[6].mul_add(z3, constants[4].mul_add(z2, constants[2] * z));
        odd.data[i] = constants[7].mul_add(z3, constants[5].mul_add(z2, constants[3] * z));
    }
    for i in 0..n {
        even.data[i * n + i] = even.data[i * n + i] + constants[0];
        odd.data[i * n + i] = odd.data[i * n + i] + constants[1];
    }
    // tanh(y/2) = y O / E with y^2 = Z: all are functions of Z, so that products are symmetric.
    let mut y = Matrix::zeros(simd, n, n);
    symmetric_product_into(&z, &odd, zero, &mut y);
    let mut coth = even.clone();
    solve_rows(&Cholesky::new(simd, even).0, &mut y, zero);
    solve_rows(&Cholesky::new(simd, odd).0, &mut coth, zero);
    let inverse = Re::splat(simd, 1.0) / t;
    scale(&mut y.data, inverse);
    scale(&mut coth.data, inverse);
    let half = Re::splat(simd, 0.5);
    for (b, y) in coth.data.iter_mut().zip(&y.data) {
        *b = half * (*b - *y);
    }
    symmetrise(&mut y, half);
    symmetrise(&mut coth, half);
    (y, coth)
}

/// What rounding has made unequal is made equal.
#[inline(always)]
fn symmetrise<S: Simd>(a: &mut Matrix<S>, half: Re<S>) {
    let n = a.columns;
    for i in 0..n {
        for j in 0..i {
            let mean = half * (a.data[i * n + j] + a.data[j * n + i]);
            a.data[i * n + j] = mean;
            a.data[j * n + i] = mean;
        }
    }
}

#[inline(always)]
fn double<S: Simd>(simd: S, times: i32, y: &mut Matrix<S>, b: &mut Matrix<S>) {
    let zero = Re::splat(simd, 0.0);
    let (two, half) = (Re::splat(simd, 2.0), Re::splat(simd, 0.5));
    let n = y.columns;
    let (mut sum, mut v) = (y.clone(), y.clone());
    for _ in 0..times {
        for i in 0..n * n {
            sum.data[i] = y.data[i] + b.data[i];
        }
        let (factor, _) = Cholesky::new(simd, sum);
        v.data.copy_from_slice(&y.data);
        solve_rows_lower(&factor, &mut v, zero);
        solve_rows_lower(&factor, b, zero);
        for i in 0..n {
            for j in 0..=i {
                let value = two * y.data[i * n + j] - dot(v.row(i), v.row(j), zero);
                y.data[i * n + j] = value;
                y.data[j * n + i] = value;
            }
        }
        symmetric_product_into(b, b, zero, &mut v);
        for (b, v) in b.data.iter_mut().zip(&v.data) {
            *b = half * *v;
        }
        sum = factor.0;
    }
}
