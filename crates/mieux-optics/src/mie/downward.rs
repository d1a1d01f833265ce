//! The series by downward recurrences, stable everywhere.

use pulp::Simd;

use super::host::Host;
use super::kernel::{Constants, Group, Sink, divide};
use super::lanes::{Cx, Re, Wave};
use super::recurrence::{Descent, up};
use super::weights::Weights;

/// Longest run of orders that is kept in memory.
const BLOCK: usize = 64;

/// How far numbers may grow over one run, as a natural logarithm: fourth powers of the result must not overflow.
pub(super) const GROWTH: f64 = 138.0;

/// Everything that runs downward, at one order `n` and the next: `psi` and `p`, each with a factor of its own, and `M`
/// with both.
#[derive(Clone, Copy)]
pub(super) struct Checkpoint<S: Simd, W> {
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

/// All orders with `psi` and `p` by downward recurrences. They are run through once to leave a checkpoint every few
/// orders, then again run by run, so that memory stays small at any size.
#[inline(always)]
pub(super) fn downward<S: Simd, H: Host<S>>(
    simd: S,
    group: &Group,
    weights: &mut Weights,
    checkpoints: &mut Vec<Checkpoint<S, H::Wave>>,
    sink: &mut impl Sink<S>,
) {
    let constants = Constants::<S, H>::new(simd, group);
    let growth = (2.0 * group.start[0].max(group.start[1]) as f64 + 1.0) / group.smallest + 1.0;
    let run = ((GROWTH / growth.ln()) as usize).clamp(4, BLOCK);
    descend(&constants, group, run, checkpoints);

    let [_, chi] = H::start(simd, constants.x, constants.inverse_x);
    let mut chi = up(constants.inverse_x, constants.real(1.0), chi);
    let zero = Cx { re: constants.real(0.0), im: constants.real(0.0) };
    let mut kept = [(constants.x, zero, zero); BLOCK + 1];
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
    let (zero, one) = (constants.real(0.0), constants.real(1.0));
    let (x0, x1) = (constants.x - constants.x, constants.x.mul(constants.inverse_x));
    let psi = Descent::new([x0, x1, constants.inverse_x], one, [group.start[0], group.order], run);
    let (y0, y1) = (Cx { re: zero, im: zero }, Cx { re: one, im: zero });
    let p = Descent::new([y0, y1, constants.inverse_y], one, [group.start[1], group.order], run);
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
