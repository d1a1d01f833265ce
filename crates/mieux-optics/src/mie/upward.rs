//! The series by upward recurrences, with nothing stored.
//!
//! Upward, `psi` and `p` lose their own digits beyond the order of their size parameter, but by no more than the
//! coefficients there, which fade, gain on those before: each coefficient is right to about 1e-16 of the largest.

use pulp::Simd;

use super::elementary::{moved, sin_cos_complex};
use super::host::{Fraction, Host};
use super::kernel::{Constants, Group, Sink, divide};
use super::recurrence::up;
use super::weights::Weights;
use crate::lanes::{Cx, Wave};

/// `M_{n-1}` and `M_n` of the numerators or of the other parts of the denominators.
type Pair<S> = [Cx<S>; 2];

/// All orders by upward recurrences: for size parameters above 1 or so, a particle optically denser than its host, a
/// contrast that is not small and little absorption over its radius in either.
#[inline(always)]
pub(super) fn upward<S: Simd, H: Host<S>>(simd: S, group: &Group, weights: &mut Weights, sink: &mut impl Sink<S>) {
    let constants = Constants::<S, H>::new(simd, group);
    let [mut psi, mut chi] = H::start(simd, constants.x, constants.inverse_x);
    let unit = Cx { re: constants.real(1.0), im: constants.real(0.0) };
    let (sin, cos) = moved(sin_cos_complex(simd, constants.y), constants.y, unit, constants.inverse_y);
    let mut p = [cos, sin];
    let (mut over, mut under) = (start(&constants, psi, p), start(&constants, chi, p));
    let one = constants.real(1.0);
    let product = constants.kappa.times(p[1]);
    over = [over[1], psi[1].times_add(product, over[0])];
    under = [under[1], chi[1].times_add(product, under[0])];
    psi = up(constants.inverse_x, one, psi);
    chi = up(constants.inverse_x, one, chi);
    p = up(constants.inverse_y, one, p);

    let mut first = 1;
    while first <= group.order {
        let count = (group.order + 1 - first).min(Weights::WINDOW);
        for weight in weights.run(first, count) {
            let (factor, order) = (constants.real(weight.factor), constants.real(weight.order));
            let product = constants.kappa.times(p[1]);
            let (gained, lost) = (psi[1].times(product), chi[1].times(product));
            let (n_a, y_a) = (order.times_add(gained, over[0]), order.times_add(lost, under[0]));
            let (n_b, y_b) = (over[1], under[1]);
            let a = Fraction::new(y_a.cross(n_a), n_a, y_a);
            let b = Fraction::new(y_b.cross(n_b), n_b, y_b);
            sink.take(weight, divide(a, b));
            over = [over[1], factor.times_add(gained, over[0])];
            under = [under[1], factor.times_add(lost, under[0])];
            psi = up(constants.inverse_x, factor, psi);
            chi = up(constants.inverse_x, factor, chi);
            p = up(constants.inverse_y, factor, p);
        }
        sink.pause();
        first += count;
    }
}

/// `M_{-1}` and `M_0` from orders -1 and 0.
#[inline(always)]
fn start<S: Simd, H: Host<S>>(constants: &Constants<S, H>, wave: [H::Wave; 2], p: Pair<S>) -> Pair<S> {
    let q = [p[0].times(constants.inverse_m), p[1].times(constants.inverse_m)];
    [wave[0].times_sub(p[1], wave[1].times(q[0])), wave[0].times_sub(q[1], wave[1].times(p[0]))]
}
