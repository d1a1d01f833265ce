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
use super::crossing::{Crossing, Series, cross};
use super::depth::Passage;
use super::drivers::{Extent, LayerDrive, lanewise};
use super::legendre::Orders;
use super::matrix::{
    Cholesky, Matrix, add_product, add_scaled, apply, apply_add, dot, product, scale, symmetric_product_into,
};
use super::modes::{Modes, Table};
use super::plan::Plan;
use crate::lanes::{MAX_LANES, Re, step};
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
pub(super) type Answering<S> = (Matrix<S>, Vec<Vec<Re<S>>>);

/// One problem per lane: stacks of one shape, each with an order of the expansion in azimuth.
pub(super) struct Lanes<'a> {
    pub plans: [&'a Plan<'a>; MAX_LANES],
    pub orders: Orders,
}

impl Lanes<'_> {
    #[inline(always)]
    pub fn gather<S: Simd>(&self, simd: S, mut value: impl FnMut(&Plan, usize) -> f64) -> Re<S> {
        lanewise(simd, |lane| value(self.plans[lane], self.orders[lane]))
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
    pub drives: Vec<LayerDrive<S>>,
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
    pub fn streams(&self, simd: S, modal: &Level<S>) -> Level<S> {
        Level { s: self.combine(simd, &self.x, &modal.s), d: self.combine(simd, &self.y, &modal.d) }
    }
}

/// All that was found, for every drive.
pub(super) struct Answer<S: Simd> {
    /// Just above the first plane, and just below the last.
    pub above: Vec<Level<S>>,
    pub below: Vec<Level<S>>,
    /// By drive and layer, in modes: at its top, at the depths at which it is cut, and at its bottom.
    pub ends: Vec<Vec<Vec<Level<S>>>>,
}

/// A swept stack.
pub(super) struct Sweep<'a, S: Simd> {
    pub simd: S,
    pub lanes: &'a Lanes<'a>,
    pub drives: &'a [Drive],
    /// The beams of each drive and lane.
    pub beams: Vec<Vec<Option<BeamLine>>>,
    pub tables: &'a [Table<S>],
    pub slices: Vec<Slice<S>>,
    crossings: Vec<Option<Crossing<S>>>,
    /// The factor of `1 + Z` above the first plane.
    top: Cholesky<S>,
    /// Admittance and sources just above the first plane.
    from_all: Answering<S>,
}

impl<'a, S: Simd> Sweep<'a, S> {
    /// From the ground up. `cuts` are, for each layer and lane, the scaled depths at which it is cut into pieces: as many
    /// in each lane.
    #[inline(always)]
    pub fn new(
        simd: S,
        lanes: &'a Lanes<'a>,
        tables: &'a [Table<S>],
        drives: &'a [Drive],
        cuts: &[Vec<Re<S>>],
    ) -> Self {
        step(
            simd,
            #[inline(always)]
            || Self::ascend(simd, lanes, tables, drives, cuts),
        )
    }

    #[inline(always)]
    fn ascend(simd: S, lanes: &'a Lanes<'a>, tables: &'a [Table<S>], drives: &'a [Drive], cuts: &[Vec<Re<S>>]) -> Self {
        let beams: Vec<Vec<Option<BeamLine>>> = drives.iter().map(|drive| beam_lines::<S>(lanes, drive)).collect();
        let first = lanes.plans[0];
        let (mut z, mut e) = ground(simd, lanes, &tables[first.frame.below], drives, &beams);
        let count = first.layers.len();
        let mut slices: Vec<Slice<S>> = Vec::with_capacity(count);
        let mut crossings: Vec<Option<Crossing<S>>> = Vec::with_capacity(count + 1);
        for j in (0..=count).rev() {
            let above = if j == 0 { first.frame.above } else { first.layers[j - 1].medium };
            crossings.push(if first.frame.planes[j].resistance.is_some() {
                let count = tables[above].cosines.len();
                let crossing = step(
                    simd,
                    #[inline(always)]
                    || cross(simd, lanes, j, count, z, e),
                );
                (z, e) = crossing.seen_from_above(simd);
                Some(crossing)
            } else {
                None
            });
            if j > 0 {
                let table = &tables[above];
                let mut slice = slice(simd, lanes, j - 1, table, drives, &beams);
                let whole = lanes.gather(simd, |plan, _| plan.layers[j - 1].thickness);
                let cuts = &cuts[j - 1];
                (z, e) = step(
                    simd,
                    #[inline(always)]
                    || slice.climb(simd, whole, cuts, z, e),
                );
                slices.push(slice);
            }
        }
        slices.reverse();
        crossings.reverse();
        let mut open = z.clone();
        for i in 0..z.columns {
            let value = open.row(i)[i] + Re::splat(simd, 1.0);
            open.row_mut(i)[i] = value;
        }
        let (top, _) = Cholesky::new(simd, open);
        Self { simd, lanes, drives, beams, tables, slices, crossings, top, from_all: (z, e) }
    }

    /// Back down.
    #[inline(always)]
    pub fn descend(&self) -> Answer<S> {
        step(
            self.simd,
            #[inline(always)]
            || self.levels(),
        )
    }

    #[inline(always)]
    fn levels(&self) -> Answer<S> {
        let simd = self.simd;
        let zero = Re::splat(simd, 0.0);
        let mut answer = Answer { above: Vec::new(), below: Vec::new(), ends: Vec::with_capacity(self.drives.len()) };
        for (index, drive) in self.drives.iter().enumerate() {
            let table = &self.tables[self.lanes.plans[0].frame.above];
            let mut level = self.enter(index, drive, table);
            answer.above.push(level.clone());
            let mut layers = Vec::with_capacity(self.slices.len());
            for j in 0..self.crossings.len() {
                if let Some(crossing) = &self.crossings[j] {
                    level = crossing.descend(simd, index, &level);
                }
                let Some(slice) = self.slices.get(j) else { break };
                let modes = &slice.modes;
                let mut modal = Level { s: apply(&modes.y, &level.s, zero), d: apply(&modes.x, &level.d, zero) };
                let mut ends = Vec::with_capacity(slice.pieces.len() + 1);
                for piece in &slice.pieces {
                    let next = piece.descend(simd, index, &modal);
                    ends.push(modal);
                    modal = next;
                }
                level = modes.streams(simd, &modal);
                ends.push(modal);
                layers.push(ends);
            }
            answer.ends.push(layers);
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
        let falling =
            self.lanes.gather(simd, |plan, m| basic(drive.above, m, plan.frame.media[plan.frame.above].index));
        let mut s = table.root_fluxes.clone();
        for (s, e) in s.iter_mut().zip(e) {
            *s = (falling + falling).mul_add(*s, zero - *e);
        }
        self.top.solve(&mut s, zero);
        let d = apply_add(z, &s, e, zero);
        Level { s, d }
    }
}

/// The basic radiance of diffuse light, which has order 0 alone.
fn basic(radiance: f64, order: usize, index: f64) -> f64 {
    if order == 0 { radiance / (index * index) } else { 0.0 }
}

/// The tables of all media of these problems.
#[inline(always)]
pub(super) fn tables<S: Simd>(simd: S, lanes: &Lanes) -> Vec<Table<S>> {
    step(
        simd,
        #[inline(always)]
        || make_tables(simd, lanes),
    )
}

#[inline(always)]
fn make_tables<S: Simd>(simd: S, lanes: &Lanes) -> Vec<Table<S>> {
    let first = lanes.plans[0];
    let least = lanes.orders.iter().min().copied().unwrap_or(0);
    let mut tables = Vec::with_capacity(first.frame.media.len());
    for medium in 0..first.frame.media.len() {
        let count = first.frame.media[medium].streams.len();
        let (mut cosines, mut weights) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for i in 0..count {
            cosines.push(lanes.gather(simd, |plan, _| plan.frame.media[medium].streams[i].cosine));
            weights.push(lanes.gather(simd, |plan, _| plan.frame.media[medium].streams[i].weight));
        }
        let index = lanes.gather(simd, |plan, _| plan.frame.media[medium].index);
        let degrees = (2 * count).saturating_sub(least).max(1);
        tables.push(Table::new(simd, cosines, weights, index, lanes.orders, degrees));
    }
    tables
}

fn beam_lines<S: Simd>(lanes: &Lanes, drive: &Drive) -> Vec<Option<BeamLine>> {
    let line = |plan: &&Plan| drive.beam.map(|(cosine, flux)| BeamLine::new(plan, cosine, flux, &Thickness::Scaled));
    lanes.plans[..S::F64_LANES].iter().map(line).collect()
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
    let roots = &table.root_fluxes;
    let square = dot(roots, roots, zero);
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
            let index = plan.frame.media[plan.frame.below].index;
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
            scaled.strength(degree)
        }));
    }
    let loss = lanes.gather(simd, |plan, _| plan.layers[layer].loss);
    let modes = Modes::new(simd, table, strength, loss);
    let mut own = Vec::with_capacity(drives.len());
    for (drive, lines) in drives.iter().zip(beams) {
        own.push(LayerDrive::new(simd, lanes, layer, (table, &modes), drive, lines));
    }
    Slice { modes, pieces: Vec::with_capacity(1), drives: own }
}

impl<S: Simd> Slice<S> {
    /// From the bottom of the layer to its top: the admittance and sources there.
    #[inline(always)]
    fn climb(
        &mut self,
        simd: S,
        whole: Re<S>,
        cuts: &[Re<S>],
        mut z: Matrix<S>,
        mut e: Vec<Vec<Re<S>>>,
    ) -> Answering<S> {
        let zero = Re::splat(simd, 0.0);
        let modes = &self.modes;
        // Z is symmetric: so is what it becomes in modes.
        let mut half = product(simd, &modes.x, &z);
        symmetric_product_into(&half, &modes.x, zero, &mut z);
        for e in &mut e {
            *e = apply(&modes.x, e, zero);
        }
        let ends: Vec<Re<S>> = [zero].iter().chain(cuts).chain([&whole]).copied().collect();
        for pair in ends.windows(2).rev() {
            let (top, thickness) = (pair[0], pair[1] - pair[0]);
            let mut passages = Vec::with_capacity(modes.k.len());
            for k in &modes.k {
                passages.push(Passage::new(simd, *k, thickness));
            }
            let extent = Extent { top, thickness, whole };
            let mut own = Vec::with_capacity(self.drives.len());
            for drive in &self.drives {
                own.push(drive.own(simd, modes, &passages, extent));
            }
            let (piece, up) = piece(simd, modes, &passages, z, e, own);
            (z, e) = up;
            self.pieces.push(piece);
        }
        self.pieces.reverse();
        half.data.fill(zero);
        add_product(&z, &modes.y, &mut half);
        z.data.fill(zero);
        let n = z.columns;
        for k in 0..n {
            for i in 0..n {
                let weight = modes.y.row(k)[i];
                // The lower half; the rest is its mirror image.
                add_scaled(&mut z.row_mut(i)[..=i], weight, half.row(k));
            }
        }
        for i in 0..n {
            for j in 0..i {
                z.data[j * n + i] = z.data[i * n + j];
            }
        }
        for e in &mut e {
            *e = modes.combine(simd, &modes.y, e);
        }
        (z, e)
    }
}

#[inline(always)]
fn piece<S: Simd>(
    simd: S,
    modes: &Modes<S>,
    passages: &[Passage<S>],
    z: Matrix<S>,
    e: Vec<Vec<Re<S>>>,
    own: Vec<[Vec<Re<S>>; 2]>,
) -> (Piece<S>, Answering<S>) {
    let n = z.columns;
    let (mut resistances, mut sech) = (Vec::with_capacity(n), Vec::with_capacity(n));
    for passage in passages {
        resistances.push(passage.resistance);
        sech.push(passage.sech);
    }
    let (series, mut answer) = Series::new(simd, &z, &resistances);
    let mut from_all = Vec::with_capacity(e.len());
    let mut driven = Vec::with_capacity(e.len());
    for (e, [u, w]) in e.iter().zip(own) {
        let carried = series.carry(simd, &answer, e, Some(&u));
        let mut up = w;
        for i in 0..n {
            up[i] = sech[i].mul_add(carried[i], up[i]);
        }
        from_all.push(up);
        driven.push(u);
    }
    for i in 0..n {
        for j in 0..n {
            answer.data[i * n + j] = answer.data[i * n + j] * sech[i] * sech[j];
        }
        let k = modes.k[i];
        answer.data[i * n + i] = (k * k).mul_add(resistances[i], answer.data[i * n + i]);
    }
    (Piece { series, below: z, sech, from_below: e, own: driven }, (answer, from_all))
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
