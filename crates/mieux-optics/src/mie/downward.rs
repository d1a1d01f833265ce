//! The series by downward recurrences, stable everywhere.

use pulp::Simd;

use super::host::Host;
use super::kernel::{Constants, Group, Sink, Slopes, divide};
use super::recurrence::{Descent, up};
use super::weights::Weights;
use crate::lanes::{Cx, Re, Wave};

/// Longest run of orders that is kept in memory.
const BLOCK: usize = 64;

/// How far numbers may grow over one run, as a natural logarithm: fourth powers of the result must not overflow.
pub(super) const GROWTH: f64 = 138.0;

/// Everything that runs downward, at one order `n` and the next: `psi` and `p`, each with a factor of its own, and `M`
/// with both.
#[derive(Clone, Copy)]
struct Checkpoint<S: Simd, W> {
    psi: Descent<W>,
    p: Descent<Cx<S>>,
    magnetic: Descent<Cx<S>>,
}

impl<S: Simd, W: Wave<S>> Checkpoint<S, W> {
    /// From order `n` to `n - 1`, with `factor = 2n + 1`.
    #[inline(always)]
    fn down<H: Host<S, Wave = W>>(&mut self, constants: &Constants<S, H>, factor: Re<S>) {
        let product = self.psi.here.times(constants.kappa.times(self.p.here));
        let below = factor.times_sub(product, self.magnetic.above);
        self.magnetic = Descent { above: self.magnetic.here, here: below };
        self.psi.down(constants.inverse_x, factor);
        self.p.down(constants.inverse_y, factor);
    }

    #[inline(always)]
    fn scale(&mut self, psi: Re<S>, p: Re<S>) {
        self.psi.scale(psi);
        self.p.scale(p);
        self.magnetic.scale(psi * p);
    }
}

/// Memory that one group after another makes use of.
pub(super) struct Scratch<S: Simd, W> {
    checkpoints: Vec<Checkpoint<S, W>>,
    /// `psi`, `p` and `M` over one run.
    kept: Vec<(W, Cx<S>, Cx<S>)>,
}

impl<S: Simd, W> Scratch<S, W> {
    pub fn new() -> Self {
        Self { checkpoints: Vec::new(), kept: Vec::new() }
    }
}

/// All orders with `psi` and `p` by downward recurrences. They are run through once to leave a checkpoint every few
/// orders, then again run by run, so that memory stays small at any size.
#[inline(always)]
pub(super) fn downward<S: Simd, H: Host<S>, O: Sink<S>>(
    simd: S,
    group: &Group,
    weights: &mut Weights,
    scratch: &mut Scratch<S, H::Wave>,
    sink: &mut O,
) {
    let constants = Constants::<S, H>::new(simd, group);
    let growth = (2.0 * group.start[0].max(group.start[1]) as f64 + 1.0) / group.smallest + 1.0;
    let run = ((GROWTH / growth.ln()) as usize).clamp(4, BLOCK);
    let Scratch { checkpoints, kept } = scratch;
    descend(&constants, group, run, checkpoints);

    let [_, chi] = H::start(simd, constants.x, constants.inverse_x);
    let mut chi = up(constants.inverse_x, constants.real(1.0), chi);
    let zero = Cx { re: constants.real(0.0), im: constants.real(0.0) };
    kept.resize(BLOCK + 1, (constants.x, zero, zero));
    // A whole array, so that its bounds are known.
    let Some(kept) = kept.first_chunk_mut::<{ BLOCK + 1 }>() else { return };
    let mut first = 1;
    while let Some(mut at) = checkpoints.pop() {
        let count = run.min(group.order + 1 - first);
        let weights = weights.run(first, count);
        kept[count] = (at.psi.above, at.p.above, at.magnetic.above);
        for (i, weight) in weights.iter().enumerate().rev() {
            kept[i] = (at.psi.here, at.p.here, at.magnetic.here);
            at.down(&constants, constants.real(weight.factor));
        }
        chi = up(constants.inverse_x, constants.real(weights[0].factor), chi);
        // psi_n chi_{n+1} - psi_{n+1} chi_n = 1 gives the factor that psi lacks.
        let scale = chi[1].mul_sub(kept[0].0, chi[0].mul(kept[1].0)).recip();
        let (_, mut p, mut magnetic) = kept[0];
        let mut q = p.times(constants.inverse_m);
        magnetic = scale.times(magnetic);
        for (i, weight) in weights.iter().enumerate() {
            if i > 0 {
                chi = up(constants.inverse_x, constants.real(weight.factor), chi);
            }
            let psi = scale.mul(kept[i].0);
            let (_, p_above, magnetic_above) = kept[i + 1];
            let q_above = p_above.times(constants.inverse_m);
            let magnetic_above = scale.times(magnetic_above);

            let next = constants.real(weight.next);
            let product = constants.kappa.times(p);
            let n_a = next.times_sub(psi.times(product), magnetic_above);
            let u = next.times_add(product, q_above);
            let y_a = chi[0].times_sub(u, chi[1].times(p));
            let y_b = chi[0].times_sub(p_above, chi[1].times(q));
            let a = H::fraction(u.cross(p), n_a, y_a);
            let b = H::fraction(p_above.cross(q), magnetic, y_b);
            if O::SLOPES {
                let denominators = [H::denominator(n_a, y_a), H::denominator(magnetic, y_b)];
                sink.take_slopes(slopes(&constants, weight.order, [p, p_above], q, denominators));
            }
            sink.take(weight, divide(a, b));
            (p, q, magnetic) = (p_above, q_above, magnetic_above);
        }
        sink.pause();
        first += count;
    }
}

/// Leaves the checkpoint of every run, the first on top of the stack.
#[inline(always)]
fn descend<S: Simd, H: Host<S>>(
    constants: &Constants<S, H>,
    group: &Group,
    run: usize,
    checkpoints: &mut Vec<Checkpoint<S, H::Wave>>,
) {
    let (inverse_x, inverse_y) = (constants.inverse_x, constants.inverse_y);
    let psi = Descent::new(constants.simd, inverse_x, [group.start[0], group.order], run);
    let p = Descent::new(constants.simd, inverse_y, [group.start[1], group.order], run);
    // At the top, where terms no longer count, by their definition.
    let q = [p.here.times(constants.inverse_m), p.above.times(constants.inverse_m)];
    let magnetic = Descent {
        here: psi.here.times_sub(p.above, psi.above.times(q[0])),
        above: psi.here.times_sub(q[1], psi.above.times(p.here)),
    };
    let mut at = Checkpoint { psi, p, magnetic };
    checkpoints.clear();
    for k in (0..group.order.div_ceil(run)).rev() {
        let mut top = at;
        for n in (k * run + 1..=((k + 1) * run).min(group.order)).rev() {
            at.down(constants, constants.real(2.0 * n as f64 + 1.0));
        }
        let (psi, p) = (at.psi.size().recip(), at.p.size().recip());
        at.scale(psi, p);
        top.scale(psi, p);
        checkpoints.push(top);
    }
}

/// Derivatives of the coefficients, which as `(L psi - psi') / (L zeta - zeta')` with the logarithmic derivative `L` that the
/// particle imposes are `da = i ((n (n + 1) / x^2 - 1 - L^2) dx - dL) / (L zeta - zeta')^2`, since `psi'' = (n (n + 1) / x^2
/// - 1) psi` and the Wronskian is `i`; `L = A / m` and `m A`, where `A = psi_n'(y) / psi_n(y)` obeys `A' = n (n + 1) / y^2 - 1
/// - A^2`.
#[inline(always)]
fn slopes<S: Simd, H: Host<S>>(
    constants: &Constants<S, H>,
    n: f64,
    [p, p_above]: [Cx<S>; 2],
    q: Cx<S>,
    denominators: [Cx<S>; 2],
) -> Slopes<S> {
    let unit = Cx { re: constants.real(1.0), im: constants.real(0.0) };
    let (inverse_x, inverse_y) = (constants.inverse_x.times(unit), constants.inverse_y);
    let order = constants.real(n * (n + 1.0));
    let curvature = |inverse: Cx<S>| inverse.times(inverse).scale(order) - unit;
    let (bend_x, bend_y) = (curvature(inverse_x), curvature(inverse_y));
    let m = constants.inverse_m.recip();
    // A p, and A p / m.
    let inner = p.times(inverse_y).scale(constants.real(n + 1.0)) - p_above;
    let outer = inner.times(constants.inverse_m);
    let (p2, q2, inner2) = (p.times(p), q.times(q), inner.times(inner));

    let a_x = bend_x.times(p2) - outer.times(outer) - p.times(outer).times(inverse_x);
    let a_y = p.times(outer).times(inverse_y) - (bend_y.times(p2) - inner2).times(constants.inverse_m);
    let b_x = bend_x.times(q2) - inner2 + q.times(inner).times(inverse_x);
    let b_y = inner2.times(constants.inverse_m) - m.times(bend_y).times(q2) - q.times(inner).times(inverse_y);
    let over = |slope: Cx<S>, denominator: Cx<S>| {
        let inverse = denominator.recip();
        let value = slope.times(inverse).times(inverse);
        Cx { re: constants.real(0.0) - value.im, im: value.re }
    };
    let [d_a, d_b] = denominators;
    Slopes { a: [over(a_x, d_a), over(a_y, d_a)], b: [over(b_x, d_b), over(b_y, d_b)] }
}
