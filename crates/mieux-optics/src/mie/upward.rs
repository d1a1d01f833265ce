//! The series by upward recurrences, with nothing stored.
//!
//! Upward, `psi` and `p` lose their own digits beyond the order of their size parameter, but by no more than the
//! coefficients there, which fade, gain on those before: each coefficient is right to about 1e-16 of the largest.

use pulp::Simd;

use super::elementary::{moved, sin_cos_multiple};
use super::host::{Fraction, Host};
use super::kernel::{Constants, Group, Sink, Term, divide};
use super::recurrence::up;
use super::weights::Weights;
use crate::lanes::{Cx, Wave};

/// Orders that are gone through at a time: what is kept of them fits the nearest cache.
const BLOCK: usize = 32;

/// `N` and `Y` of both coefficients of one order.
#[derive(Clone, Copy)]
struct Parts<S: Simd> {
    a: [Cx<S>; 2],
    /// The numerators `M_n` and the same of the denominators, which have a recurrence of their own.
    b: [Cx<S>; 2],
}

/// Memory that one group after another makes use of.
pub(super) struct Scratch<S: Simd> {
    parts: Vec<Parts<S>>,
    terms: Vec<Term<S>>,
}

impl<S: Simd> Scratch<S> {
    pub fn new() -> Self {
        Self { parts: Vec::new(), terms: Vec::new() }
    }
}

/// All orders by upward recurrences: for size parameters above 1 or so, a particle optically denser than its host, a
/// contrast that is not small and little absorption over its radius in either.
///
/// Block by block first the recurrences, then the coefficients, then what the sink does with them: each for itself needs no
/// more registers than there are, and while one order waits for its division others go on.
#[inline(always)]
pub(super) fn upward<S: Simd, H: Host<S>>(
    simd: S,
    group: &Group,
    weights: &mut Weights,
    scratch: &mut Scratch<S>,
    sink: &mut impl Sink<S>,
) {
    let constants = Constants::<S, H>::new(simd, group);
    let Start { mut psi, mut chi, mut p, b } = Start::new(&constants);
    let Scratch { parts, terms } = scratch;
    if parts.is_empty() {
        let (zero, none) = (constants.real(0.0), Cx { re: constants.real(0.0), im: constants.real(0.0) });
        parts.resize(BLOCK + 2, Parts { a: b[0], b: b[0] });
        terms.resize(BLOCK, Term { a: none, b: none, square: zero, loss: zero });
    }
    // A whole array, so that its bounds are known.
    let Some(parts) = parts.first_chunk_mut::<{ BLOCK + 2 }>() else { return };
    (parts[0].b, parts[1].b) = (b[0], b[1]);

    let mut first = 1;
    while first <= group.order {
        let count = (group.order + 1 - first).min(BLOCK);
        let weights = weights.run(first, count);
        for (i, weight) in weights.iter().enumerate().take(BLOCK) {
            let (factor, order) = (constants.real(weight.factor), constants.real(weight.order));
            let (gained, lost) = (psi[1].times(p[1]), chi[1].times(p[1]));
            let [over, under] = parts[i].b;
            parts[i + 1].a = [order.times_add(gained, over), order.times_add(lost, under)];
            parts[i + 2].b = [factor.times_add(gained, over), factor.times_add(lost, under)];
            psi = up(constants.inverse_x, factor, psi);
            chi = up(constants.inverse_x, factor, chi);
            p = up(constants.inverse_y, factor, p);
        }
        for (term, Parts { a, b }) in terms.iter_mut().zip(&parts[1..=count]) {
            *term = divide(fraction(*a), fraction(*b));
        }
        for (weight, term) in weights.iter().zip(terms.iter()) {
            sink.take(weight, *term);
        }
        sink.pause();
        (parts[0].b, parts[1].b) = (parts[count].b, parts[count + 1].b);
        first += count;
    }
}

#[inline(always)]
fn fraction<S: Simd>([over, under]: [Cx<S>; 2]) -> Fraction<S> {
    Fraction::new(under.cross(over), over, under)
}

/// What the recurrences start from: `psi_n`, `chi_n` and `kappa p_n` at orders 0 and 1, and there too `M_n` with what is the
/// same of the denominators.
struct Start<S: Simd, W> {
    psi: [W; 2],
    chi: [W; 2],
    p: [Cx<S>; 2],
    b: [[Cx<S>; 2]; 2],
}

impl<S: Simd, W: Wave<S>> Start<S, W> {
    #[inline(always)]
    fn new<H: Host<S, Wave = W>>(constants: &Constants<S, H>) -> Self {
        let one = constants.real(1.0);
        let [psi, chi] = H::start(constants.simd, constants.x, constants.inverse_x);
        let unit = Cx { re: one, im: constants.real(0.0) };
        let (sin, cos) = moved(sin_cos_multiple(constants.simd, constants.y), constants.y, unit, constants.inverse_y);
        let q = [cos.times(constants.inverse_m), sin.times(constants.inverse_m)];
        let before = |wave: [W; 2]| wave[0].times_sub(sin, wave[1].times(q[0]));
        let at = |wave: [W; 2]| wave[0].times_sub(q[1], wave[1].times(cos));
        let p = [cos.times(constants.kappa), sin.times(constants.kappa)];
        let first = |wave: [W; 2]| wave[1].times_add(p[1], before(wave));
        Self {
            psi: up(constants.inverse_x, one, psi),
            chi: up(constants.inverse_x, one, chi),
            p: up(constants.inverse_y, one, p),
            b: [[at(psi), at(chi)], [first(psi), first(chi)]],
        }
    }
}
