//! The streams of a medium, those of the beams first, and the Legendre polynomials at them.

use pulp::Simd;

use crate::lanes::{MAX_LANES, Re};
use crate::transfer::discrete_ordinates::matrix::{Matrix, add_scaled, dot, scale, subtract_scaled};
use crate::transfer::discrete_ordinates::plan::Plan;
use crate::transfer::streams::refracted_cosine;

/// The quadrature weight of a stream that carries a beam: what is scattered into it is lost in the rounding of what is not,
/// and its root, which is what the matrices are made of, is far from the least number there is.
const BEAM_WEIGHT: f64 = 1e-24;

/// What a medium is to the streams.
pub(super) struct Table<S: Simd> {
    /// `1 / sqrt(mu)`.
    pub inverse_root: Vec<Re<S>>,
    pub cosines: Vec<Re<S>>,
    /// Square roots of the flux, over `2 pi`, of a stream of basic radiance 1: `n sqrt(w mu)`.
    pub roots: Vec<Re<S>>,
    /// `sqrt(w) P_l(mu)`: a row a stream, a column a degree.
    pub functions: Matrix<S>,
    /// Reflects equal radiance in all directions into the last axis, but for the sign.
    pub mirror: Vec<Re<S>>,
    /// What is lost of equal radiance without any scattering, per optical depth and lost share, after that reflection.
    pub even_loss: Vec<Re<S>>,
}

/// What one stream is in each lane.
#[inline(always)]
fn gather<S: Simd>(simd: S, value: impl Fn(usize) -> f64) -> Re<S> {
    let mut lanes = [0.0; MAX_LANES];
    for (lane, out) in lanes.iter_mut().enumerate() {
        *out = value(lane);
    }
    Re::load(simd, &lanes)
}

impl<S: Simd> Table<S> {
    #[inline(always)]
    pub fn new(simd: S, plans: &[&Plan; MAX_LANES], medium: usize, beams: &[f64]) -> Self {
        let (zero, one) = (Re::splat(simd, 0.0), Re::splat(simd, 1.0));
        let count = plans[0].frame.media[medium].streams.len();
        let (mut cosines, mut weights) = (Vec::new(), Vec::new());
        // Where a beam does not enter, its stream is one that nothing reaches and that reaches nothing.
        let mut enters = Vec::new();
        for &cosine in beams {
            let inside = |lane: usize| {
                let plan = plans[lane];
                refracted_cosine(cosine, plan.frame.media[plan.frame.above].index, plan.frame.media[medium].index)
            };
            cosines.push(gather(simd, |lane| inside(lane).unwrap_or(1.0)));
            // n^2 mu d(mu) is the same on both sides of a plane.
            weights.push(gather(simd, |lane| {
                let plan = plans[lane];
                let ratio = plan.frame.media[plan.frame.above].index / plan.frame.media[medium].index;
                BEAM_WEIGHT * ratio * ratio * cosine / inside(lane).unwrap_or(1.0)
            }));
            enters.push(gather(simd, |lane| if inside(lane).is_some() { 1.0 } else { 0.0 }));
        }
        for i in 0..count {
            cosines.push(gather(simd, |lane| plans[lane].frame.media[medium].streams[i].cosine));
            weights.push(gather(simd, |lane| plans[lane].frame.media[medium].streams[i].weight));
        }
        let index = gather(simd, |lane| plans[lane].frame.media[medium].index);
        let mut functions = polynomials(simd, &cosines, &weights, 2 * count);
        close(&mut functions, beams.len(), zero);
        for (i, enters) in enters.iter().enumerate() {
            scale(functions.row_mut(i), *enters);
        }
        let (mut inverse_root, mut roots, mut unit) = (Vec::new(), Vec::new(), Vec::new());
        for (cosine, weight) in cosines.iter().zip(&weights) {
            inverse_root.push(one / cosine.sqrt());
            let root = (*weight * *cosine).sqrt();
            roots.push(index * root);
            unit.push(root);
        }
        for (root, enters) in unit.iter_mut().zip(&enters) {
            *root = *root * *enters;
        }
        let length = dot(&unit, &unit, zero).sqrt();
        let (mirror, even_loss) = mirror(&unit, &cosines, length);
        Self { inverse_root, cosines, roots, functions, mirror, even_loss }
    }

    #[inline(always)]
    pub fn len(&self) -> usize {
        self.cosines.len()
    }
}

/// `sqrt(w) P_l(mu)` for `count` degrees.
#[inline(always)]
fn polynomials<S: Simd>(simd: S, cosines: &[Re<S>], weights: &[Re<S>], count: usize) -> Matrix<S> {
    let mut functions = Matrix::zeros(simd, cosines.len(), count.max(1));
    for (i, (cosine, weight)) in cosines.iter().zip(weights).enumerate() {
        let root = weight.sqrt();
        let row = functions.row_mut(i);
        let (mut before, mut here) = (Re::splat(simd, 0.0), Re::splat(simd, 1.0));
        for (l, out) in row.iter_mut().enumerate() {
            *out = here * root;
            let degree = l as f64;
            let (rise, fall) = ((2.0 * degree + 1.0) / (degree + 1.0), degree / (degree + 1.0));
            let next = Re::splat(simd, fall).neg_mul_add(before, Re::splat(simd, rise) * *cosine * here);
            (before, here) = (here, next);
        }
    }
    functions
}

/// Under refraction the rule integrates polynomials almost but not quite. So that no light is made or lost, the other even
/// polynomials are made orthogonal to the constant one, at all streams but those of beams.
#[inline(always)]
fn close<S: Simd>(functions: &mut Matrix<S>, beams: usize, zero: Re<S>) {
    let rows = functions.rows();
    let mut square = zero;
    for i in beams..rows {
        square = functions.row(i)[0].mul_add(functions.row(i)[0], square);
    }
    let inverse = zero.same(1.0) / square.sqrt();
    for i in 0..rows {
        functions.row_mut(i)[0] = functions.row(i)[0] * inverse;
    }
    let mut overlap = vec![zero; functions.columns];
    for i in beams..rows {
        let share = functions.row(i)[0];
        add_scaled(&mut overlap, share, functions.row(i));
    }
    for (degree, value) in overlap.iter_mut().enumerate() {
        if degree == 0 || degree % 2 == 1 {
            *value = zero;
        }
    }
    for i in beams..rows {
        let share = functions.row(i)[0];
        subtract_scaled(functions.row_mut(i), share, &overlap);
    }
}

/// The reflection, and what it makes of the losses.
#[inline(always)]
fn mirror<S: Simd>(unit: &[Re<S>], cosines: &[Re<S>], length: Re<S>) -> (Vec<Re<S>>, Vec<Re<S>>) {
    let zero = length.same(0.0);
    let inverse = zero.same(1.0) / length;
    let mut mirror = unit.to_vec();
    scale(&mut mirror, inverse);
    if let Some(last) = mirror.last_mut() {
        *last = *last + zero.same(1.0);
    }
    let mut loss = Vec::with_capacity(unit.len());
    for (root, cosine) in unit.iter().zip(cosines) {
        loss.push(zero - *root / *cosine * inverse);
    }
    let along = zero.same(2.0) * dot(&mirror, &loss, zero) / dot(&mirror, &mirror, zero);
    subtract_scaled(&mut loss, along, &mirror);
    (mirror, loss)
}
