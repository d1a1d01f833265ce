//! Through a stack from the ground up, and back down.
//!
//! Whatever lies below a plane answers light by `d = Z s + e`: a symmetric positive admittance and what comes from its own
//! sources. A ground has a simple `Z`; a layer, in its modes, and a refracting plane, stream by stream, are resistances in
//! series with what is below them. Sums and products of positive matrices are all there is, so nothing cancels however
//! thick, thin, or clear a layer is. (The invariant imbedding of `chandrasekhar1960` in the form of a transmission line.)
//!
//! Radiances are basic ones, `I / n^2`, which refraction leaves alone.

use pulp::Simd;

use super::beam::{BeamLine, Thickness};
use super::depth::{LinearOverlap, Overlap, Passage};
use super::legendre::Orders;
use super::matrix::{
    Cholesky, Matrix, add_scaled, apply, apply_add, dot, multiply, product, scale, subtract_scaled, symmetric_product,
};
use super::modes::{Modes, Table};
use super::plan::Plan;
use crate::lanes::{LaneArray, MAX_LANES, Re};
use crate::transfer::Ground;

/// What drives the light, for one right-hand side.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Drive {
    /// Cosine above, and flux onto the horizontal.
    pub beam: Option<(f64, f64)>,
    /// Radiance that falls in from all directions above.
    pub above: f64,
    /// And below.
    pub below: f64,
    /// Whether the layers emit.
    pub emission: bool,
}

/// What lies below a plane: its admittance, and for each drive what comes from there.
type Answering<S> = (Matrix<S>, Vec<Vec<Re<S>>>);

/// How one mode passes through a piece, in every lane.
type Passages = [Passage; MAX_LANES];

/// One problem per lane: stacks of one shape, each with an order of the expansion in azimuth.
pub(super) struct Lanes<'a> {
    pub plans: [&'a Plan<'a>; MAX_LANES],
    pub orders: Orders,
}

impl Lanes<'_> {
    #[inline(always)]
    pub fn gather<S: Simd>(&self, simd: S, mut value: impl FnMut(&Plan, usize) -> f64) -> Re<S> {
        let lanes: LaneArray = std::array::from_fn(|lane| value(self.plans[lane], self.orders[lane]));
        Re::load(simd, &lanes)
    }
}

/// A part of a layer between two depths, and what was found on the way up.
pub(super) struct Piece<S: Simd> {
    series: Series<S>,
    /// Admittance below, in modes.
    below: Matrix<S>,
    sech: Vec<Re<S>>,
    /// For each drive: what comes from below, what the piece itself adds.
    from_below: Vec<Vec<Re<S>>>,
    own: Vec<Vec<Re<S>>>,
}

/// A layer with its modes.
pub(super) struct Slice<S: Simd> {
    pub modes: Modes<S>,
    pub pieces: Vec<Piece<S>>,
    /// For each drive that has a beam, its coupling to the modes: `X^T q_e` and `Y^T q_o` per flux along the beam.
    pub beams: Vec<Option<[Vec<Re<S>>; 2]>>,
}

/// A plane that refracts.
struct Crossing<S: Simd> {
    series: Series<S>,
    /// Of the streams that are trapped below.
    trapped: Option<Trapped<S>>,
    from_below: Vec<Vec<Re<S>>>,
    admittance: Matrix<S>,
    above: usize,
}

struct Trapped<S: Simd> {
    factor: Cholesky<S>,
    /// Rows: trapped streams; columns: the others.
    coupling: Matrix<S>,
    from_below: Vec<Vec<Re<S>>>,
}

/// Resistances in series with an admittance.
struct Series<S: Simd> {
    /// Their square roots, and the inverses of these.
    roots: Vec<Re<S>>,
    inverse: Vec<Re<S>>,
    factor: Cholesky<S>,
    /// The admittance of both: `(Z^-1 + R)^-1`.
    admittance: Matrix<S>,
}

impl<S: Simd> Series<S> {
    #[inline(always)]
    fn new(simd: S, z: &Matrix<S>, resistances: &[Re<S>]) -> Self {
        let n = z.columns;
        let one = Re::splat(simd, 1.0);
        let least = Re::splat(simd, 1e-280);
        let mut roots = resistances.to_vec();
        for root in &mut roots {
            *root = root.max(least).sqrt();
        }
        let mut inverse = roots.clone();
        for root in &mut inverse {
            *root = one / *root;
        }
        let mut scaled = Matrix::zeros(simd, n, n);
        for i in 0..n {
            for j in 0..n {
                scaled.data[i * n + j] = z.data[i * n + j] * roots[i] * roots[j];
            }
        }
        let mut sum = scaled.clone();
        for i in 0..n {
            sum.data[i * n + i] = sum.data[i * n + i] + one;
        }
        let (factor, _) = Cholesky::new(simd, sum);
        factor.solve_columns(&mut scaled);
        for i in 0..n {
            for j in 0..n {
                scaled.data[i * n + j] = scaled.data[i * n + j] * inverse[i] * inverse[j];
            }
        }
        Self { roots, inverse, factor, admittance: scaled }
    }

    /// `(1 + R Z)^-1 v`.
    #[inline(always)]
    fn divide(&self, simd: S, v: &mut [Re<S>]) {
        multiply(v, &self.inverse);
        self.factor.solve(v, Re::splat(simd, 0.0));
        multiply(v, &self.roots);
    }

    /// `u - R e`.
    #[inline(always)]
    fn drop(&self, simd: S, e: &[Re<S>], u: Option<&[Re<S>]>) -> Vec<Re<S>> {
        let zero = Re::splat(simd, 0.0);
        let mut drop = Vec::with_capacity(e.len());
        for i in 0..e.len() {
            let from = u.map_or(zero, |u| u[i]);
            drop.push((self.roots[i] * self.roots[i]).neg_mul_add(e[i], from));
        }
        drop
    }

    /// `e + y (u - R e)`.
    #[inline(always)]
    fn carry(&self, simd: S, e: &[Re<S>], u: Option<&[Re<S>]>) -> Vec<Re<S>> {
        let zero = Re::splat(simd, 0.0);
        let drop = self.drop(simd, e, u);
        apply_add(&self.admittance, &drop, e, zero)
    }
}

/// The state at a boundary, for one drive: sums and differences of the weighted streams.
#[derive(Clone)]
pub(super) struct Level<S: Simd> {
    pub s: Vec<Re<S>>,
    pub d: Vec<Re<S>>,
}

impl<S: Simd> Modes<S> {
    /// From modes to streams.
    #[inline(always)]
    fn streams(&self, simd: S, modal: &Level<S>) -> Level<S> {
        Level { s: self.combine(simd, &self.x, &modal.s), d: self.combine(simd, &self.y, &modal.d) }
    }
}

/// All that was found, for every drive.
pub(super) struct Answer<S: Simd> {
    /// Just above the first plane, and just below the last.
    pub above: Vec<Level<S>>,
    pub below: Vec<Level<S>>,
    /// At the depths at which layers are cut, by layer, cut and drive.
    pub cuts: Vec<Vec<Vec<Level<S>>>>,
}

/// A swept stack.
pub(super) struct Sweep<'a, S: Simd> {
    pub simd: S,
    pub lanes: &'a Lanes<'a>,
    pub drives: &'a [Drive],
    /// The beams of each drive and lane.
    pub beams: Vec<Vec<Option<BeamLine>>>,
    pub tables: Vec<Table<S>>,
    pub slices: Vec<Slice<S>>,
    crossings: Vec<Option<Crossing<S>>>,
    top: Series<S>,
    /// Admittance and sources just above the first plane.
    from_all: Answering<S>,
}

impl<'a, S: Simd> Sweep<'a, S> {
    /// From the ground up. `cuts` are, for each layer and lane, the scaled depths at which it is cut into pieces: as many
    /// in each lane.
    #[inline(always)]
    pub fn new(simd: S, lanes: &'a Lanes<'a>, drives: &'a [Drive], cuts: &[Vec<Re<S>>]) -> Self {
        let tables = tables(simd, lanes);
        let beams: Vec<Vec<Option<BeamLine>>> = drives.iter().map(|drive| beam_lines(lanes, drive)).collect();
        let first = lanes.plans[0];
        let (mut z, mut e) = ground(simd, lanes, &tables[first.below], drives, &beams);
        let count = first.layers.len();
        let mut slices: Vec<Slice<S>> = Vec::with_capacity(count);
        let mut crossings: Vec<Option<Crossing<S>>> = Vec::with_capacity(count + 1);
        for j in (0..=count).rev() {
            let above = if j == 0 { first.above } else { first.layers[j - 1].medium };
            crossings.push(if first.planes[j].resistance.is_some() {
                let crossing = cross(simd, lanes, j, tables[above].cosines.len(), z, e);
                (z, e) = crossing.seen_from_above(simd);
                Some(crossing)
            } else {
                None
            });
            if j > 0 {
                let table = &tables[above];
                let mut slice = slice(simd, lanes, j - 1, table, drives, &beams);
                (z, e) = slice.climb(simd, lanes, j - 1, table, (drives, &beams), &cuts[j - 1], z, e);
                slices.push(slice);
            }
        }
        slices.reverse();
        crossings.reverse();
        let open = vec![Re::splat(simd, 1.0); z.columns];
        let top = Series::new(simd, &z, &open);
        Self { simd, lanes, drives, beams, tables, slices, crossings, top, from_all: (z, e) }
    }

    /// Back down.
    #[inline(always)]
    pub fn descend(&self) -> Answer<S> {
        let simd = self.simd;
        let zero = Re::splat(simd, 0.0);
        let mut answer = Answer { above: Vec::new(), below: Vec::new(), cuts: Vec::with_capacity(self.slices.len()) };
        for slice in &self.slices {
            answer.cuts.push(slice.pieces.iter().skip(1).map(|_| Vec::new()).collect());
        }
        for (index, drive) in self.drives.iter().enumerate() {
            let table = &self.tables[self.lanes.plans[0].above];
            let mut level = self.enter(index, drive, table);
            answer.above.push(level.clone());
            for j in 0..self.crossings.len() {
                if let Some(crossing) = &self.crossings[j] {
                    level = crossing.descend(simd, index, &level);
                }
                let Some(slice) = self.slices.get(j) else { break };
                let modes = &slice.modes;
                let mut modal = Level { s: apply(&modes.y, &level.s, zero), d: apply(&modes.x, &level.d, zero) };
                for (cut, piece) in slice.pieces.iter().enumerate() {
                    modal = piece.descend(simd, index, &modal);
                    level = modes.streams(simd, &modal);
                    if let Some(list) = answer.cuts[j].get_mut(cut) {
                        list.push(level.clone());
                    }
                }
            }
            answer.below.push(level);
        }
        answer
    }

    /// The state above the first plane: radiance that falls in is known, the rest answers.
    #[inline(always)]
    fn enter(&self, index: usize, drive: &Drive, table: &Table<S>) -> Level<S> {
        let simd = self.simd;
        let zero = Re::splat(simd, 0.0);
        let (z, e) = (&self.from_all.0, &self.from_all.1[index]);
        let falling = self.lanes.gather(simd, |plan, m| basic(drive.above, m, plan.media[plan.above].index));
        let two = Re::splat(simd, 2.0);
        let mut s: Vec<Re<S>> = (0..z.columns).map(|i| two * falling * table.root_flux(i) - e[i]).collect();
        self.top.divide(simd, &mut s);
        let d = (0..z.columns).map(|i| dot(z.row(i), &s, zero) + e[i]).collect();
        Level { s, d }
    }
}

/// The basic radiance of diffuse light, which has order 0 alone.
fn basic(radiance: f64, order: usize, index: f64) -> f64 {
    if order == 0 { radiance / (index * index) } else { 0.0 }
}

#[inline(always)]
fn tables<S: Simd>(simd: S, lanes: &Lanes) -> Vec<Table<S>> {
    let first = lanes.plans[0];
    let least = lanes.orders.iter().min().copied().unwrap_or(0);
    let mut tables = Vec::with_capacity(first.media.len());
    for medium in 0..first.media.len() {
        let count = first.media[medium].streams.len();
        let (mut cosines, mut weights) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for i in 0..count {
            cosines.push(lanes.gather(simd, |plan, _| plan.media[medium].streams[i].cosine));
            weights.push(lanes.gather(simd, |plan, _| plan.media[medium].streams[i].weight));
        }
        let index = lanes.gather(simd, |plan, _| plan.media[medium].index);
        let degrees = (2 * count).saturating_sub(least).max(1);
        tables.push(Table::new(simd, cosines, weights, index, lanes.orders, degrees));
    }
    tables
}

fn beam_lines(lanes: &Lanes, drive: &Drive) -> Vec<Option<BeamLine>> {
    let line = |plan: &&Plan| drive.beam.map(|(cosine, flux)| BeamLine::new(plan, cosine, flux, &Thickness::Scaled));
    lanes.plans.iter().map(line).collect()
}

/// The admittance of the ground, or of the half-space below, and what comes from there.
#[inline(always)]
fn ground<S: Simd>(
    simd: S,
    lanes: &Lanes,
    table: &Table<S>,
    drives: &[Drive],
    beams: &[Vec<Option<BeamLine>>],
) -> Answering<S> {
    let n = table.cosines.len();
    let zero = Re::splat(simd, 0.0);
    // A share that every stream keeps, and one that goes into the mean of all.
    let mirror = lanes.gather(simd, |plan, _| match plan.stack.ground {
        Ground::Mirror(share) => (1.0 - share) / (1.0 + share),
        _ => 1.0,
    });
    let diffuse = lanes.gather(simd, |plan, m| match plan.stack.ground {
        Ground::Lambertian(share) if m == 0 => share,
        _ => 0.0,
    });
    let roots = table.root_fluxes();
    let square = dot(&roots, &roots, zero);
    let one = Re::splat(simd, 1.0);
    let mixing = (diffuse + diffuse) / ((one + diffuse) * square);
    let mut z = Matrix::zeros(simd, n, n);
    for i in 0..n {
        for j in 0..n {
            z.data[i * n + j] = zero - mixing * roots[i] * roots[j];
        }
        z.data[i * n + i] = z.data[i * n + i] + mirror;
    }
    let mut sources = Vec::with_capacity(drives.len());
    for (drive, beams) in drives.iter().zip(beams) {
        let mut lane = 0;
        let rising = lanes.gather(simd, |plan, m| {
            let beam = beams[lane].as_ref().map_or(0.0, |beam| beam.on_ground);
            lane += 1;
            let index = plan.media[plan.below].index;
            let from_beam = match plan.stack.ground {
                Ground::Lambertian(share) => basic(share * beam / std::f64::consts::PI, m, index),
                _ => 0.0,
            };
            // Behind a ground there is no light.
            let outside = if plan.stack.ground == Ground::Black { basic(drive.below, m, index) } else { 0.0 };
            from_beam + outside
        });
        let mut e = roots.clone();
        scale(&mut e, zero - (rising + rising) / (one + diffuse));
        sources.push(e);
    }
    (z, sources)
}

#[inline(always)]
fn cross<S: Simd>(simd: S, lanes: &Lanes, plane: usize, above: usize, z: Matrix<S>, e: Vec<Vec<Re<S>>>) -> Crossing<S> {
    let common = above.min(z.columns);
    let mut resistances = Vec::with_capacity(common);
    for i in 0..common {
        let share = |plan: &Plan, _: usize| plan.planes[plane].resistance.as_ref().map_or(0.0, |r| r[i]);
        resistances.push(lanes.gather(simd, share));
    }
    let ((admittance, from_below), trapped) =
        if common < z.columns { eliminate(simd, z, e, common) } else { ((z, e), None) };
    let series = Series::new(simd, &admittance, &resistances);
    Crossing { series, trapped, from_below, admittance, above }
}

/// Without the streams from `common` on, which find no way up: their difference is 0.
#[inline(always)]
fn eliminate<S: Simd>(
    simd: S,
    z: Matrix<S>,
    mut e: Vec<Vec<Re<S>>>,
    common: usize,
) -> (Answering<S>, Option<Trapped<S>>) {
    let count = z.columns - common;
    let zero = Re::splat(simd, 0.0);
    let (mut inner, mut coupling) = (Matrix::zeros(simd, count, count), Matrix::zeros(simd, count, common));
    let mut outer = Matrix::zeros(simd, common, common);
    for t in 0..count {
        inner.row_mut(t).copy_from_slice(&z.row(common + t)[common..]);
        coupling.row_mut(t).copy_from_slice(&z.row(common + t)[..common]);
    }
    for i in 0..common {
        outer.row_mut(i).copy_from_slice(&z.row(i)[..common]);
    }
    let (factor, _) = Cholesky::new(simd, inner);
    let mut solved = coupling.clone();
    factor.solve_columns(&mut solved);
    for t in 0..count {
        for i in 0..common {
            let weight = coupling.row(t)[i];
            subtract_scaled(outer.row_mut(i), weight, solved.row(t));
        }
    }
    let mut from_below = Vec::with_capacity(e.len());
    for e in &mut e {
        let mut rest = e.split_off(common);
        from_below.push(rest.clone());
        factor.solve(&mut rest, zero);
        for (t, value) in rest.iter().enumerate() {
            subtract_scaled(e, *value, coupling.row(t));
        }
    }
    ((outer, e), Some(Trapped { factor, coupling, from_below }))
}

impl<S: Simd> Crossing<S> {
    /// The streams that only exist above are reflected totally: their difference is 0.
    #[inline(always)]
    fn seen_from_above(&self, simd: S) -> Answering<S> {
        let common = self.admittance.columns;
        let zero = Re::splat(simd, 0.0);
        let mut z = Matrix::zeros(simd, self.above, self.above);
        for i in 0..common {
            z.row_mut(i)[..common].copy_from_slice(self.series.admittance.row(i));
        }
        let mut sources = Vec::with_capacity(self.from_below.len());
        for e in &self.from_below {
            let mut e = self.series.carry(simd, e, None);
            e.resize(self.above, zero);
            sources.push(e);
        }
        (z, sources)
    }

    #[inline(always)]
    fn descend(&self, simd: S, drive: usize, above: &Level<S>) -> Level<S> {
        let zero = Re::splat(simd, 0.0);
        let common = self.admittance.columns;
        let e = &self.from_below[drive];
        let mut s = self.series.drop(simd, e, Some(&above.s[..common]));
        self.series.divide(simd, &mut s);
        let mut d = apply_add(&self.admittance, &s, e, zero);
        if let Some(Trapped { factor, coupling, from_below }) = &self.trapped {
            let mut rest = apply_add(coupling, &s, &from_below[drive], zero);
            scale(&mut rest, Re::splat(simd, -1.0));
            factor.solve(&mut rest, zero);
            d.resize(common + rest.len(), zero);
            s.extend(rest);
        }
        Level { s, d }
    }
}

#[inline(always)]
fn slice<S: Simd>(
    simd: S,
    lanes: &Lanes,
    layer: usize,
    table: &Table<S>,
    drives: &[Drive],
    beams: &[Vec<Option<BeamLine>>],
) -> Slice<S> {
    let mut strength = Vec::with_capacity(table.functions.columns);
    for j in 0..table.functions.columns {
        strength.push(lanes.gather(simd, |plan, m| {
            let scaled = &plan.layers[layer];
            let degree = m + j;
            scaled.moments.get(degree).map_or(0.0, |chi| scaled.albedo * (2 * degree + 1) as f64 * chi)
        }));
    }
    let loss = lanes.gather(simd, |plan, _| plan.layers[layer].loss);
    let modes = Modes::new(simd, table, strength, loss);
    let mut couplings = Vec::with_capacity(drives.len());
    for (drive, lines) in drives.iter().zip(beams) {
        let cosine: LaneArray =
            std::array::from_fn(|lane| lines[lane].as_ref().map_or(1.0, |line| line.layers[layer].cosine));
        couplings.push(match drive.beam {
            Some(_) => Some(modes.coupling(simd, table, Re::load(simd, &cosine))),
            None => None,
        });
    }
    Slice { modes, pieces: Vec::new(), beams: couplings }
}

impl<S: Simd> Slice<S> {
    /// From the bottom of the layer to its top: the admittance and sources there.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "the state of the sweep")]
    fn climb(
        &mut self,
        simd: S,
        lanes: &Lanes,
        layer: usize,
        table: &Table<S>,
        (drives, beams): (&[Drive], &[Vec<Option<BeamLine>>]),
        cuts: &[Re<S>],
        z: Matrix<S>,
        e: Vec<Vec<Re<S>>>,
    ) -> Answering<S> {
        let zero = Re::splat(simd, 0.0);
        let whole = lanes.gather(simd, |plan, _| plan.layers[layer].thickness);
        let modes = &self.modes;
        // Z is symmetric: so is what it becomes in modes.
        let half = product(simd, &modes.x, &z);
        let mut z = symmetric_product(simd, &half, &modes.x);
        let mut e = e;
        for e in &mut e {
            *e = apply(&modes.x, e, zero);
        }
        let ends: Vec<Re<S>> = [zero].iter().chain(cuts).chain([&whole]).copied().collect();
        for pair in ends.windows(2).rev() {
            let (top, thickness) = (pair[0], pair[1] - pair[0]);
            let mut passages: Vec<Passages> = Vec::with_capacity(modes.k.len());
            let t = thickness.lanes();
            for k in &modes.k {
                let k = k.lanes();
                passages.push(std::array::from_fn(|lane| Passage::new(k[lane], t[lane])));
            }
            let drivers = Drivers { simd, lanes, layer, table, modes, top, thickness, whole, passages: &passages };
            let mut own = Vec::with_capacity(drives.len());
            for ((drive, lines), coupling) in drives.iter().zip(beams).zip(&self.beams) {
                own.push(drivers.own(drive, lines, coupling.as_ref()));
            }
            let (piece, up) = piece(simd, modes, &passages, z, e, own);
            (z, e) = up;
            self.pieces.push(piece);
        }
        self.pieces.reverse();
        let half = product(simd, &z, &modes.y);
        let n = modes.y.columns;
        let mut through = Matrix::zeros(simd, n, n);
        for k in 0..n {
            for i in 0..n {
                let weight = modes.y.row(k)[i];
                // The lower half; the rest is its mirror image.
                add_scaled(&mut through.row_mut(i)[..=i], weight, half.row(k));
            }
        }
        for i in 0..n {
            for j in 0..i {
                through.data[j * n + i] = through.data[i * n + j];
            }
        }
        for e in &mut e {
            *e = modes.combine(simd, &modes.y, e);
        }
        (through, e)
    }
}

#[inline(always)]
fn piece<S: Simd>(
    simd: S,
    modes: &Modes<S>,
    passages: &[Passages],
    z: Matrix<S>,
    e: Vec<Vec<Re<S>>>,
    own: Vec<[Vec<Re<S>>; 2]>,
) -> (Piece<S>, Answering<S>) {
    let n = z.columns;
    let (mut resistances, mut sech) = (Vec::with_capacity(n), Vec::with_capacity(n));
    for passage in passages {
        resistances.push(lanewise::<S>(simd, |lane| passage[lane].resistance));
        sech.push(lanewise::<S>(simd, |lane| passage[lane].sech));
    }
    let series = Series::new(simd, &z, &resistances);
    let mut up = Matrix::zeros(simd, n, n);
    for i in 0..n {
        for j in 0..n {
            up.data[i * n + j] = series.admittance.data[i * n + j] * sech[i] * sech[j];
        }
        let k = modes.k[i];
        up.data[i * n + i] = (k * k).mul_add(resistances[i], up.data[i * n + i]);
    }
    let mut from_all = Vec::with_capacity(e.len());
    let mut driven = Vec::with_capacity(e.len());
    for (e, [u, w]) in e.iter().zip(own) {
        let carried = series.carry(simd, e, Some(&u));
        let mut up = w;
        for i in 0..n {
            up[i] = sech[i].mul_add(carried[i], up[i]);
        }
        from_all.push(up);
        driven.push(u);
    }
    (Piece { series, below: z, sech, from_below: e, own: driven }, (up, from_all))
}

impl<S: Simd> Piece<S> {
    #[inline(always)]
    fn descend(&self, simd: S, drive: usize, top: &Level<S>) -> Level<S> {
        let zero = Re::splat(simd, 0.0);
        let e = &self.from_below[drive];
        let mut f = self.series.drop(simd, e, Some(&self.own[drive]));
        for (f, (sech, top)) in f.iter_mut().zip(self.sech.iter().zip(&top.s)) {
            *f = sech.mul_add(*top, *f);
        }
        self.series.divide(simd, &mut f);
        let g = apply_add(&self.below, &f, e, zero);
        Level { s: f, d: g }
    }
}

/// One number per lane.
#[inline(always)]
pub(super) fn lanewise<S: Simd>(simd: S, value: impl Fn(usize) -> f64) -> Re<S> {
    let mut lanes = [0.0; MAX_LANES];
    lanes[..S::F64_LANES].iter_mut().enumerate().for_each(|(lane, out)| *out = value(lane));
    Re::load(simd, &lanes)
}

/// What drives the modes of a piece.
struct Drivers<'a, S: Simd> {
    simd: S,
    lanes: &'a Lanes<'a>,
    layer: usize,
    table: &'a Table<S>,
    modes: &'a Modes<S>,
    top: Re<S>,
    thickness: Re<S>,
    whole: Re<S>,
    passages: &'a [Passages],
}

impl<S: Simd> Drivers<'_, S> {
    /// What the sources in the piece give to `f` at the bottom, and to `g` at the top.
    #[inline(always)]
    fn own(&self, drive: &Drive, lines: &[Option<BeamLine>], coupling: Option<&[Vec<Re<S>>; 2]>) -> [Vec<Re<S>>; 2] {
        let zero = Re::splat(self.simd, 0.0);
        let n = self.modes.k.len();
        let mut own = [vec![zero; n], vec![zero; n]];
        if let Some(coupling) = coupling {
            self.add_beam(lines, coupling, &mut own);
        }
        if drive.emission {
            self.add_emission(&mut own);
        }
        own
    }

    #[inline(always)]
    fn add_beam(&self, lines: &[Option<BeamLine>], [even, odd]: &[Vec<Re<S>>; 2], own: &mut [Vec<Re<S>>; 2]) {
        let strengths = self.strengths(lines);
        let (top, t) = (self.top.lanes(), self.thickness.lanes());
        let whole = self.whole.lanes();
        let nu: LaneArray = strengths.map(|(_, _, cosine)| 1.0 / cosine);
        let fade: LaneArray = std::array::from_fn(|lane| (-nu[lane] * t[lane]).exp());
        let down = lanewise(self.simd, |lane| strengths[lane].0 * (-nu[lane] * top[lane]).exp());
        let up = lanewise(self.simd, |lane| {
            strengths[lane].1 * (-nu[lane] * (whole[lane] - top[lane] - t[lane]).max(0.0)).exp()
        });
        for i in 0..self.modes.k.len() {
            let k = self.modes.k[i].lanes();
            let mut parts = [[0.0; MAX_LANES]; 4];
            for lane in 0..S::F64_LANES {
                let o = Overlap::new(k[lane], nu[lane], t[lane], &self.passages[i][lane], fade[lane]);
                parts[0][lane] = o.cosh;
                parts[1][lane] = o.sinh;
                parts[2][lane] = o.cosh_back;
                parts[3][lane] = o.sinh_back;
            }
            let [cosh, sinh, cosh_back, sinh_back] = parts.map(|part| Re::load(self.simd, &part));
            let k2 = self.modes.k[i] * self.modes.k[i];
            let (alpha, beta) = (odd[i], even[i]);
            // The beam up has the odd part of the other sign, and runs from the bottom.
            own[0][i] = own[0][i] + down * (cosh * alpha + sinh * beta) + up * (sinh_back * beta - cosh_back * alpha);
            own[1][i] =
                own[1][i] + down * (k2 * sinh_back * alpha - cosh_back * beta) - up * (k2 * sinh * alpha + cosh * beta);
        }
    }

    /// Of each lane: the beam down at the top of the layer and up at its bottom, as they drive the modes, and the cosine.
    #[inline(always)]
    fn strengths(&self, lines: &[Option<BeamLine>]) -> [(f64, f64, f64); MAX_LANES] {
        std::array::from_fn(|lane| {
            let Some(beam) = lines[lane].as_ref().map(|line| line.layers[self.layer]) else { return (0.0, 0.0, 1.0) };
            let scale = azimuthal(self.lanes.orders[lane]) / beam.cosine;
            (beam.down * scale, beam.up * scale, beam.cosine)
        })
    }

    #[inline(always)]
    fn add_emission(&self, own: &mut [Vec<Re<S>>; 2]) {
        let simd = self.simd;
        let zero = Re::splat(simd, 0.0);
        let mut drive = self.table.weights.clone();
        for (value, cosine) in drive.iter_mut().zip(&self.table.cosines) {
            *value = self.table.index * (*value / *cosine).sqrt();
        }
        let shares = apply(&self.modes.x, &drive, zero);
        let [from, slope] = self.emitted();
        let t = self.thickness.lanes();
        for (i, share) in shares.iter().enumerate() {
            let k = self.modes.k[i].lanes();
            let o: [LinearOverlap; MAX_LANES] = std::array::from_fn(|lane| LinearOverlap::new(k[lane], t[lane]));
            let flat = lanewise(simd, |lane| o[lane].flat);
            let rising = lanewise(simd, |lane| o[lane].rising);
            let steep = lanewise(simd, |lane| o[lane].steep);
            own[0][i] = own[0][i] + *share * (from * rising + slope * steep);
            own[1][i] = own[1][i] - *share * (from * flat + slope * rising);
        }
    }

    /// Twice what is emitted per optical depth: at the top of the piece, and its slope.
    #[inline(always)]
    pub fn emitted(&self) -> [Re<S>; 2] {
        let scale = |plan: &Plan, m: usize| if m == 0 { 2.0 * plan.layers[self.layer].loss } else { 0.0 };
        let emission = |plan: &Plan| plan.stack.layers[self.layer].emission;
        let from = self.lanes.gather(self.simd, |plan, m| scale(plan, m) * emission(plan)[0]);
        let slope = self.lanes.gather(self.simd, |plan, m| {
            let [top, bottom] = emission(plan);
            scale(plan, m) * (bottom - top) / plan.layers[self.layer].thickness.max(1e-300)
        });
        [from + slope * self.top, slope]
    }
}

/// What a beam of flux 1 along its direction gives to one order of the sum over azimuths: `(2 - delta_m0) / 2 pi`.
pub(super) fn azimuthal(order: usize) -> f64 {
    if order == 0 { 0.5 / std::f64::consts::PI } else { 1.0 / std::f64::consts::PI }
}
