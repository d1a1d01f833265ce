//! The series of a sphere of concentric layers, eight spheres abreast.
//!
//! In every layer the field is `u = alpha psi + beta chi` of the layer's own size parameter, and `u'` below stands for the
//! same with `psi_{n+1}` and `chi_{n+1}`. From a layer of index `m_1` to the next of index `m_2` the pair `(u, u')` becomes
//!
//! - `(u, m_1/m_2 u')` for the magnetic coefficient,
//! - `(u, m_2/m_1 u' + (n + 1) kappa u)` for the electric one, `kappa = (1 - m_2^2/m_1^2) / z_2`,
//!
//! and across a layer `alpha = u chi_{n+1} - u' chi_n`, `beta = u' psi_n - u psi_{n+1}`. The host is one more layer, in which
//! `N = -beta` and `Y = alpha`. Where a layer absorbs much, `psi` and `chi` are those of [`Opaque`](super::host::Opaque), so
//! that what decays and what grows across it stay apart: the ratios of `yang2003`, without their divisions.
//!
//! What lies inside a boundary is invisible to orders beyond the reach of its size parameter; they start outside it. Up to
//! there `chi` may leave the range of numbers, so it is brought back to 1 with every run and the lost factors are kept as
//! their ratio over the layer, which is all that counts.

use pulp::Simd;

use super::downward::GROWTH;
use super::host::{Fraction, Host};
use super::kernel::{Sink, contrast, divide};
use super::recurrence::{Descent, up};
use super::weights::Weights;
use crate::lanes::{Cx, LaneArray, Re, Wave};

/// Longest run of orders that is kept in memory.
const BLOCK: usize = 16;

/// One layer of spheres abreast.
pub(super) struct LayerGroup {
    /// Vacuum wave number times outer radius.
    pub k0r: LaneArray,
    pub re: LaneArray,
    pub im: LaneArray,
    /// Order beyond which nothing inside the inner boundary is seen.
    pub farthest: usize,
    /// `exp(2 i (z_outer - z_inner))` across the layer, real and imaginary parts.
    pub across: [LaneArray; 2],
    /// Order from which `psi` starts downward at the inner and at the outer boundary.
    pub start: [usize; 2],
}

/// Layered spheres abreast, all of as many layers. Aligned for the same reason as [`Group`](super::kernel::Group).
#[repr(align(64))]
pub(super) struct LayeredGroup {
    pub host_re: LaneArray,
    pub host_im: LaneArray,
    /// From the core outward.
    pub layers: Vec<LayerGroup>,
    /// Largest order that any of them needs.
    pub order: usize,
    /// Order from which `psi` in the host starts downward.
    pub start: usize,
    /// Smallest modulus of any size parameter.
    pub smallest: f64,
}

/// `psi` and `chi` at one boundary, seen from one of its sides.
struct Boundary<S: Simd, W> {
    inverse: W,
    descent: Descent<W>,
    /// The start of every run from above, the first on top.
    checkpoints: Vec<Descent<W>>,
    /// `psi` over the run, from its first order to one beyond its last.
    psi: [W; BLOCK + 1],
    chi: [W; 2],
    one: Re<S>,
}

impl<S: Simd, W: Wave<S>> Boundary<S, W> {
    #[inline(always)]
    fn new<H: Host<S, Wave = W>>(simd: S, z: W, start: usize, order: usize, run: usize) -> Self {
        let inverse = z.recip();
        let unit = Re::splat(simd, 1.0);
        let [_, chi] = H::start(simd, z, inverse);
        let descent = Descent::new(simd, inverse, [start, order], run);
        let mut boundary = Self {
            inverse,
            descent,
            checkpoints: Vec::with_capacity(order.div_ceil(run)),
            psi: [z; BLOCK + 1],
            chi: up(inverse, unit, chi),
            one: unit,
        };
        boundary.descend(order, run);
        boundary
    }

    /// Leaves a checkpoint at the top of every run.
    #[inline(always)]
    fn descend(&mut self, order: usize, run: usize) {
        for k in (0..order.div_ceil(run)).rev() {
            let mut top = self.descent;
            for n in (k * run + 1..=((k + 1) * run).min(order)).rev() {
                self.descent.down(self.inverse, self.one.same(2.0 * n as f64 + 1.0));
            }
            let factor = self.descent.size().recip();
            self.descent.scale(factor);
            top.scale(factor);
            self.checkpoints.push(top);
        }
    }

    /// Prepares the run of orders from `first` on, and `chi` at its first order.
    #[inline(always)]
    fn enter(&mut self, first: usize, count: usize) {
        if let Some(mut at) = self.checkpoints.pop() {
            self.psi[count] = at.above;
            for i in (0..count).rev() {
                self.psi[i] = at.here;
                at.down(self.inverse, self.one.same(2.0 * (first + i) as f64 + 1.0));
            }
        }
    }

    /// Brings `chi` to the next order; `factor` is that of the order it reaches.
    #[inline(always)]
    fn rise(&mut self, factor: Re<S>) {
        self.chi = up(self.inverse, factor, self.chi);
    }

    /// Brings `chi` to a size of 1; gives the factor.
    #[inline(always)]
    fn rescale(&mut self) -> Re<S> {
        let factor = (self.chi[0].size() + self.chi[1].size()).recip();
        self.chi = [self.chi[0].scale(factor), self.chi[1].scale(factor)];
        factor
    }

    /// Scales `psi` over the run so that `psi_n chi_{n+1} - psi_{n+1} chi_n = 1`.
    #[inline(always)]
    fn normalise(&mut self, count: usize) {
        let factor = self.chi[1].mul_sub(self.psi[0], self.chi[0].mul(self.psi[1])).recip();
        for psi in &mut self.psi[..=count] {
            *psi = factor.mul(*psi);
        }
    }

    #[inline(always)]
    fn psi(&self, i: usize) -> [W; 2] {
        [self.psi[i], self.psi[i + 1]]
    }
}

/// One layer, ready to be crossed.
struct Layer<S: Simd> {
    /// `None` in the core.
    inner: Option<Entry<S>>,
    outer: Boundary<S, Cx<S>>,
    farthest: usize,
}

/// The inner boundary of a layer.
struct Entry<S: Simd> {
    boundary: Boundary<S, Cx<S>>,
    interface: Interface<S>,
    /// `exp(2 i (z_outer - z_inner))` where waves are scaled, else 1.
    across: Cx<S>,
    /// `chi` has lost this factor at the outer boundary beyond what it has lost at the inner one.
    lost: Re<S>,
}

/// From one index `m_1` to the next `m_2` outward.
struct Interface<S: Simd> {
    /// `m_1 / m_2`
    ratio: Cx<S>,
    /// `m_2 / m_1`
    inverse: Cx<S>,
    kappa: Cx<S>,
}

impl<S: Simd> Interface<S> {
    #[inline(always)]
    fn new(inside: Cx<S>, outside: Cx<S>, inverse_z: Cx<S>) -> Self {
        let (inverse, contrast) = contrast(outside, inside);
        Self { ratio: inverse.recip(), inverse, kappa: inverse_z.times(contrast) }
    }

    #[inline(always)]
    fn cross(&self, field: &mut Field<S>, next: Re<S>) {
        field.magnetic[1] = self.ratio.times(field.magnetic[1]);
        let [u, raised] = field.electric;
        field.electric[1] = self.inverse.times_add(raised, self.kappa.scale(next).times(u));
    }
}

/// `u` and `u'` of both coefficients.
struct Field<S: Simd> {
    electric: [Cx<S>; 2],
    magnetic: [Cx<S>; 2],
}

/// `wave_{n+1} u - wave_n u'`.
#[inline(always)]
fn against<S: Simd, W: Wave<S>>(wave: [W; 2], [u, raised]: [Cx<S>; 2]) -> Cx<S> {
    wave[0].times_sub(raised, wave[1].times(u))
}

#[inline(always)]
fn load<S: Simd>(simd: S, re: &LaneArray, im: &LaneArray) -> Cx<S> {
    Cx { re: Re::load(simd, re), im: Re::load(simd, im) }
}

impl<S: Simd> Layer<S> {
    #[inline(always)]
    fn new<K: Host<S, Wave = Cx<S>>>(
        simd: S,
        layer: &LayerGroup,
        below: Option<&LayerGroup>,
        order: usize,
        run: usize,
    ) -> Self {
        let m = load(simd, &layer.re, &layer.im);
        let outer = Boundary::new::<K>(simd, Re::load(simd, &layer.k0r).times(m), layer.start[1], order, run);
        let inner = match below {
            None => None,
            Some(below) => {
                let z = Re::load(simd, &below.k0r).times(m);
                let boundary = Boundary::new::<K>(simd, z, layer.start[0], order, run);
                let interface = Interface::new(load(simd, &below.re, &below.im), m, boundary.inverse);
                let across = load(simd, &layer.across[0], &layer.across[1]);
                Some(Entry { boundary, interface, across, lost: Re::splat(simd, 1.0) })
            }
        };
        Self { inner, outer, farthest: layer.farthest }
    }

    /// Prepares the run of orders from `first` on.
    #[inline(always)]
    fn enter(&mut self, first: usize, count: usize) {
        self.outer.enter(first, count);
        if let Some(entry) = &mut self.inner {
            entry.boundary.enter(first, count);
        }
    }

    /// Brings `chi` to the next order.
    #[inline(always)]
    fn rise(&mut self, factor: Re<S>) {
        if let Some(entry) = &mut self.inner {
            self.outer.rise(factor);
            entry.boundary.rise(factor);
        }
    }

    /// Puts the waves of a run to scale, at its first order.
    #[inline(always)]
    fn normalise(&mut self, count: usize) {
        if let Some(entry) = &mut self.inner {
            entry.lost = entry.lost * entry.boundary.rescale() * self.outer.rescale().recip();
            entry.boundary.normalise(count);
            self.outer.normalise(count);
        }
    }

    /// From the inner boundary to the outer one.
    #[inline(always)]
    fn pass(&self, entry: &Entry<S>, field: [Cx<S>; 2], i: usize) -> [Cx<S>; 2] {
        let alpha = against(entry.boundary.chi, field);
        let fading = entry.across.scale(entry.lost * entry.lost);
        let minus_beta = against(entry.boundary.psi(i), field).times(fading);
        let (psi, chi) = (self.outer.psi(i), self.outer.chi);
        [minus_beta.times_sub(chi[0], alpha.times(psi[0])), minus_beta.times_sub(chi[1], alpha.times(psi[1]))]
    }
}

/// The field at the outermost boundary, seen from inside, at order `n`, the `i`th of the run.
#[inline(always)]
fn field_at_surface<S: Simd>(layers: &[Layer<S>], n: usize, i: usize, next: Re<S>) -> Field<S> {
    let start = layers.iter().rposition(|layer| layer.inner.is_none() || n > layer.farthest).unwrap_or(0);
    let psi = layers[start].outer.psi(i);
    let mut field = Field { electric: psi, magnetic: psi };
    for layer in &layers[start + 1..] {
        if let Some(entry) = &layer.inner {
            entry.interface.cross(&mut field, next);
            field.electric = layer.pass(entry, field.electric, i);
            field.magnetic = layer.pass(entry, field.magnetic, i);
        }
    }
    field
}

/// A coefficient from the field outside the surface.
#[inline(always)]
fn fraction<S: Simd, H: Host<S>>(psi: [H::Wave; 2], chi: [H::Wave; 2], field: [Cx<S>; 2]) -> Fraction<S> {
    H::fraction(field[1].cross(field[0]), against(psi, field), against(chi, field))
}

/// The series of layered spheres; `K` says how waves are carried in the layers, `H` how in the host.
#[inline(always)]
pub(super) fn layered<S: Simd, H: Host<S>, K: Host<S, Wave = Cx<S>>>(
    simd: S,
    group: &LayeredGroup,
    weights: &mut Weights,
    sink: &mut impl Sink<S>,
) {
    let farthest = group.layers.iter().flat_map(|l| l.start).max().unwrap_or(0).max(group.start);
    let growth = (2.0 * farthest as f64 + 1.0) / group.smallest + 1.0;
    let run = ((GROWTH / growth.ln()) as usize).clamp(2, BLOCK);

    let mut layers: Vec<Layer<S>> = Vec::with_capacity(group.layers.len());
    for (i, layer) in group.layers.iter().enumerate() {
        layers.push(Layer::new::<K>(simd, layer, i.checked_sub(1).map(|i| &group.layers[i]), group.order, run));
    }
    let Some(last) = group.layers.last() else { return };
    let host = load(simd, &group.host_re, &group.host_im);
    let x = H::size_parameter(Re::load(simd, &last.k0r), host);
    let mut outside = Boundary::new::<H>(simd, x, group.start, group.order, run);
    let unit = Wave::splat(simd, 1.0);
    let surface = Interface::new(load(simd, &last.re, &last.im), host, outside.inverse.times(unit));

    let mut first = 1;
    while first <= group.order {
        let count = run.min(group.order + 1 - first);
        for layer in &mut layers {
            layer.enter(first, count);
        }
        outside.enter(first, count);
        for (i, weight) in weights.run(first, count).iter().enumerate() {
            let (factor, next) = (Re::splat(simd, weight.factor), Re::splat(simd, weight.next));
            for layer in &mut layers {
                layer.rise(factor);
            }
            outside.rise(factor);
            if i == 0 {
                for layer in &mut layers {
                    layer.normalise(count);
                }
                outside.normalise(count);
            }
            let mut field = field_at_surface(&layers, first + i, i, next);
            surface.cross(&mut field, next);
            let (psi, chi) = (outside.psi(i), outside.chi);
            let (a, b) = (fraction::<S, H>(psi, chi, field.electric), fraction::<S, H>(psi, chi, field.magnetic));
            sink.take(weight, divide(a, b));
        }
        sink.pause();
        first += count;
    }
}
