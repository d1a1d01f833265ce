//! The series of a homogeneous sphere, eight spheres abreast.
//!
//! With `psi = z j_n`, `chi = -z y_n` and `zeta = psi - i chi` of the host's size parameter `x`, `p` any multiple of
//! `psi_n(y)` inside the particle and `q = p / m`, the coefficients are `N / (N - i Y)` where
//!
//! - `N_a = psi_{n+1} p_n - psi_n u` and `Y_a = chi_{n+1} p_n - chi_n u` with `u = (n + 1) kappa p_n + q_{n+1}` and
//!   `kappa = (1 - 1/m^2) / x`;
//! - `N_b = psi_{n+1} q_n - psi_n p_{n+1}`, and `Y_b` the same in `chi`.
//!
//! The leading terms of neighbouring orders, which cancel between particle and host, never appear; nothing is divided
//! but once per order, for both coefficients; and as `p` may have any scale, no recurrence needs a division at all.
//! Source: eq 9-10 of `frisvad2007`, rearranged.

use pulp::Simd;

use super::elementary::sin_cos_complex;
use super::host::Host;
use super::lanes::{Cx, LaneArray, Re, Wave};
use super::weights::{Weight, Weights};

/// Spheres abreast, in the numbers that the series is made of.
#[derive(Clone, Copy)]
pub(super) struct Group {
    /// Vacuum wave number times radius.
    pub k0r: LaneArray,
    pub host_re: LaneArray,
    pub host_im: LaneArray,
    pub particle_re: LaneArray,
    pub particle_im: LaneArray,
    /// Largest order that any of them needs.
    pub order: usize,
    /// Order from which downward recurrences start so that their start is forgotten at `order`: host, particle.
    pub start: [usize; 2],
    /// Smallest modulus of any size parameter, in the host or inside.
    pub smallest: f64,
}

/// The coefficients of one order, each divided by `exp(-2 i x)` when the host's waves are scaled.
#[derive(Clone, Copy)]
pub(super) struct Term<S: Simd> {
    pub a: Cx<S>,
    pub b: Cx<S>,
    /// `|a|^2 + |b|^2`.
    pub square: Re<S>,
    /// `Re a - |a|^2 + Re b - |b|^2`, free of cancellation; of no meaning when the host's waves are scaled.
    pub loss: Re<S>,
}

/// Takes the coefficients, order by order from 1.
pub(super) trait Sink<S: Simd> {
    fn take(&mut self, weight: &Weight, term: Term<S>);
}

/// Longest run of orders that a downward recurrence is kept in memory for.
const BLOCK: usize = 64;

/// How far numbers may grow over one run, as a natural logarithm: fourth powers of the result must not overflow.
const GROWTH: f64 = 138.0;

/// What stays the same from order to order.
struct Constants<S: Simd, H: Host<S>> {
    simd: S,
    x: H::Wave,
    inverse_x: H::Wave,
    y: Cx<S>,
    inverse_y: Cx<S>,
    inverse_m: Cx<S>,
    kappa: Cx<S>,
}

impl<S: Simd, H: Host<S>> Constants<S, H> {
    #[inline(always)]
    fn new(simd: S, group: &Group) -> Self {
        let load = |lanes| Re::load(simd, lanes);
        let k0r = load(&group.k0r);
        let host = Cx { re: load(&group.host_re), im: load(&group.host_im) };
        let particle = Cx { re: load(&group.particle_re), im: load(&group.particle_im) };
        let x = H::size_parameter(k0r, host);
        let y = k0r.times(particle);
        let inverse_particle = particle.recip();
        let contrast = (particle - host).times(particle + host).times(inverse_particle).times(inverse_particle);
        let inverse_x = x.recip();
        Self {
            simd,
            x,
            inverse_x,
            y,
            inverse_y: y.recip(),
            inverse_m: host.times(inverse_particle),
            kappa: inverse_x.times(contrast),
        }
    }

    #[inline(always)]
    fn real(&self, value: f64) -> Re<S> {
        Re::splat(self.simd, value)
    }
}

/// Two neighbouring orders `n` and `n + 1` of everything that a coefficient is made of.
#[derive(Clone, Copy)]
struct Orders<S: Simd, W> {
    psi: [W; 2],
    chi: [W; 2],
    p: [Cx<S>; 2],
    q: [Cx<S>; 2],
}

impl<S: Simd, W: Wave<S>> Orders<S, W> {
    /// `a_n` and `b_n` from orders `n` and `n + 1`.
    #[inline(always)]
    fn term<H: Host<S, Wave = W>>(&self, constants: &Constants<S, H>, weight: &Weight) -> Term<S> {
        let Self { psi, chi, p, q } = *self;
        let u = constants.kappa.scale(constants.real(weight.next)).times_add(p[0], q[1]);
        let a = H::fraction(u.cross(p[0]), against(psi, p[0], u), against(chi, p[0], u));
        let b = H::fraction(p[1].cross(q[0]), against(psi, q[0], p[1]), against(chi, q[0], p[1]));
        let both = (a.below * b.below).recip();
        let (under_a, under_b) = (both * b.below, both * a.below);
        Term {
            a: a.over.scale(under_a),
            b: b.over.scale(under_b),
            square: a.square.mul_add(under_a, b.square * under_b),
            loss: a.loss.mul_add(under_a, b.loss * under_b),
        }
    }
}

/// `wave_{n+1} upper - wave_n lower`.
#[inline(always)]
fn against<S: Simd, W: Wave<S>>(wave: [W; 2], upper: Cx<S>, lower: Cx<S>) -> Cx<S> {
    wave[0].times_sub(lower, wave[1].times(upper))
}

/// One step of the three-term recurrence in either direction: `(2n + 1) / z * current - other`.
#[inline(always)]
fn step<S: Simd, W: Wave<S>>(inverse: W, factor: Re<S>, current: W, other: W) -> W {
    current.mul_sub(inverse.scale(factor), other)
}

/// All orders by upward recurrences: for size parameters above 1 or so, a particle no thinner optically than its host
/// and little absorption over its radius in either. Nothing is stored.
#[inline(always)]
pub(super) fn upward<S: Simd, H: Host<S>>(simd: S, group: &Group, weights: &mut Weights, sink: &mut impl Sink<S>) {
    let constants = Constants::<S, H>::new(simd, group);
    let [psi, chi] = H::start(simd, constants.x);
    let (sin, cos) = sin_cos_complex(simd, constants.y);
    let one = constants.real(1.0);
    let mut psi = up(constants.inverse_x, one, psi);
    let mut chi = up(constants.inverse_x, one, chi);
    let mut inside = Inside { p: [cos, sin], q: [sin; 2], reduced: sin.times(constants.inverse_y) };
    inside.up(&constants, one);
    let mut first = 1;
    while first <= group.order {
        let count = (group.order + 1 - first).min(Weights::WINDOW);
        for weight in weights.run(first, count) {
            let factor = constants.real(weight.factor);
            psi = up(constants.inverse_x, factor, psi);
            chi = up(constants.inverse_x, factor, chi);
            inside.up(&constants, factor);
            sink.take(weight, Orders { psi, chi, p: inside.p, q: inside.q }.term(&constants, weight));
        }
        first += count;
    }
}

/// From orders `n - 1` and `n` to `n` and `n + 1`, with `factor = 2n + 1`.
#[inline(always)]
fn up<S: Simd, W: Wave<S>>(inverse: W, factor: Re<S>, pair: [W; 2]) -> [W; 2] {
    [pair[1], step(inverse, factor, pair[1], pair[0])]
}

/// The waves inside the particle on their way up: `p` and `q` at orders `n` and `n + 1`, and `p_{n+1} / y`.
struct Inside<S: Simd> {
    p: [Cx<S>; 2],
    q: [Cx<S>; 2],
    reduced: Cx<S>,
}

impl<S: Simd> Inside<S> {
    #[inline(always)]
    fn up<H: Host<S>>(&mut self, constants: &Constants<S, H>, factor: Re<S>) {
        self.p = [self.p[1], self.reduced.scale(factor) - self.p[0]];
        self.reduced = self.p[1].times(constants.inverse_y);
        self.q = [self.q[1], constants.x.times(self.reduced)];
    }
}

/// A downward recurrence: `f_{n+1}` and `f_n` up to a common factor.
#[derive(Clone, Copy)]
struct Descent<W> {
    above: W,
    here: W,
}

impl<W> Descent<W> {
    /// At the order `from`, above which the solution counts as zero, down to the order `to`.
    #[inline(always)]
    fn new<S: Simd>([zero, one, inverse]: [W; 3], unit: Re<S>, [from, to]: [usize; 2], run: usize) -> Self
    where
        W: Wave<S>,
    {
        let mut descent = Self { above: zero, here: one };
        for n in (to + 1..=from).rev() {
            descent.down(inverse, unit.same(2.0 * n as f64 + 1.0));
            if n % run == 0 {
                descent.rescale();
            }
        }
        descent
    }

    /// From order `n` to `n - 1`, with `factor = 2n + 1`.
    #[inline(always)]
    fn down<S: Simd>(&mut self, inverse: W, factor: Re<S>)
    where
        W: Wave<S>,
    {
        let below = step(inverse, factor, self.here, self.above);
        self.above = self.here;
        self.here = below;
    }

    /// Brings what has been reached to a size of 1; gives the factor.
    #[inline(always)]
    fn rescale<S: Simd>(&mut self) -> Re<S>
    where
        W: Wave<S>,
    {
        let factor = (self.here.size() + self.above.size()).recip();
        self.scale(factor);
        factor
    }

    #[inline(always)]
    fn scale<S: Simd>(&mut self, factor: Re<S>)
    where
        W: Wave<S>,
    {
        self.above = self.above.scale(factor);
        self.here = self.here.scale(factor);
    }
}

/// Where a run of orders starts from above: `psi` and `p` at its last order and one beyond.
#[derive(Clone, Copy)]
pub(super) struct Checkpoint<S: Simd, W> {
    psi: Descent<W>,
    p: Descent<Cx<S>>,
}

/// All orders with `psi` and `p` by downward recurrences, stable everywhere. They are run through once to leave a
/// checkpoint every few orders, then again run by run, so that memory stays small at any size.
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

    let [_, chi] = H::start(simd, constants.x);
    let mut chi = up(constants.inverse_x, constants.real(1.0), chi);
    let zero = constants.real(0.0);
    let mut kept = [(constants.x, Cx { re: zero, im: zero }); BLOCK + 1];
    let mut first = 1;
    while let Some(Checkpoint { mut psi, mut p }) = checkpoints.pop() {
        let count = run.min(group.order + 1 - first);
        kept[count] = (psi.above, p.above);
        for i in (0..count).rev() {
            kept[i] = (psi.here, p.here);
            let factor = constants.real(2.0 * (first + i) as f64 + 1.0);
            psi.down(constants.inverse_x, factor);
            p.down(constants.inverse_y, factor);
        }
        let weights = weights.run(first, count);
        chi = up(constants.inverse_x, constants.real(weights[0].factor), chi);
        let scale = chi[1].mul_sub(kept[0].0, chi[0].mul(kept[1].0)).recip();
        let mut next = (scale.mul(kept[0].0), kept[0].1, kept[0].1.times(constants.inverse_m));
        for (i, (weight, &(psi, p))) in weights.iter().zip(&kept[1..]).enumerate() {
            if i > 0 {
                chi = up(constants.inverse_x, constants.real(weight.factor), chi);
            }
            let here = next;
            next = (scale.mul(psi), p, p.times(constants.inverse_m));
            let o = Orders { psi: [here.0, next.0], chi, p: [here.1, next.1], q: [here.2, next.2] };
            sink.take(weight, o.term(&constants, weight));
        }
        first += count;
    }
}

/// Leaves the checkpoint of every run, the last on the floor of the stack.
#[inline(always)]
fn descend<S: Simd, H: Host<S>>(
    constants: &Constants<S, H>,
    group: &Group,
    run: usize,
    checkpoints: &mut Vec<Checkpoint<S, H::Wave>>,
) {
    let (zero, one) = (constants.real(0.0), constants.real(1.0));
    let (x0, x1) = (constants.x - constants.x, constants.x.mul(constants.inverse_x));
    let mut psi = Descent::new([x0, x1, constants.inverse_x], one, [group.start[0], group.order], run);
    let (y0, y1) = (Cx { re: zero, im: zero }, Cx { re: one, im: zero });
    let mut p = Descent::new([y0, y1, constants.inverse_y], one, [group.start[1], group.order], run);
    checkpoints.clear();
    let runs = group.order.div_ceil(run);
    for k in (0..runs).rev() {
        let mut top = Checkpoint { psi, p };
        for n in (k * run + 1..=((k + 1) * run).min(group.order)).rev() {
            let factor = constants.real(2.0 * n as f64 + 1.0);
            psi.down(constants.inverse_x, factor);
            p.down(constants.inverse_y, factor);
        }
        top.psi.scale(psi.rescale());
        top.p.scale(p.rescale());
        checkpoints.push(top);
    }
}
