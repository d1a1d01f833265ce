//! What the sources in a layer give to its modes: beams that are scattered, and light that is emitted.

use pulp::Simd;

use super::beam::BeamLine;
use super::depth::{Decay, Fall, LinearOverlap, Overlap, Passage};
use super::matrix::apply;
use super::modes::{Modes, Table};
use super::plan::Plan;
use super::sweep::{Drive, Lanes};
use crate::lanes::{MAX_LANES, Re};

/// How one drive acts in a layer.
pub(super) struct LayerDrive<S: Simd> {
    pub beam: Option<BeamDrive<S>>,
    pub emission: Option<Emission<S>>,
}

/// A beam: down from the top of the layer, up from its bottom.
pub(super) struct BeamDrive<S: Simd> {
    /// What it gives to the even and the odd part of each mode, per flux along the beam.
    pub coupling: [Vec<Re<S>>; 2],
    /// The inverse of its cosine.
    pub nu: Re<S>,
    down: Re<S>,
    up: Re<S>,
}

/// Light that is emitted, all of order 0.
pub(super) struct Emission<S: Simd> {
    /// What it gives to the even part of each mode.
    pub shares: Vec<Re<S>>,
    /// Twice what is emitted per optical depth, at the top of the layer.
    from: Re<S>,
    slope: Re<S>,
}

/// A part of a layer, in scaled optical depth.
#[derive(Clone, Copy)]
pub(super) struct Extent<S: Simd> {
    pub top: Re<S>,
    pub thickness: Re<S>,
    /// Of the layer.
    pub whole: Re<S>,
}

impl<S: Simd> LayerDrive<S> {
    #[inline(always)]
    pub fn new(
        simd: S,
        lanes: &Lanes,
        layer: usize,
        (table, modes): (&Table<S>, &Modes<S>),
        drive: &Drive,
        lines: &[Option<BeamLine>],
    ) -> Self {
        let beam = match drive.beam {
            Some(_) => Some(BeamDrive::new(simd, lanes, layer, table, modes, lines)),
            None => None,
        };
        let emits = drive.emission && lanes.plans.iter().any(|plan| plan.stack.layers[layer].emission != [0.0; 2]);
        let emission = if emits { Some(Emission::new(simd, lanes, layer, table, modes)) } else { None };
        Self { beam, emission }
    }

    /// What the sources in a part of the layer give to `f` at its bottom, and to `g` at its top.
    #[inline(always)]
    pub fn own(&self, simd: S, modes: &Modes<S>, passages: &[Passage<S>], extent: Extent<S>) -> [Vec<Re<S>>; 2] {
        let zero = Re::splat(simd, 0.0);
        let mut own = [vec![zero; modes.k.len()], vec![zero; modes.k.len()]];
        if let Some(beam) = &self.beam {
            beam.add(simd, modes, passages, extent, &mut own);
        }
        if let Some(emission) = &self.emission {
            emission.add(simd, modes, extent, &mut own);
        }
        own
    }
}

impl<S: Simd> BeamDrive<S> {
    #[inline(always)]
    fn new(
        simd: S,
        lanes: &Lanes,
        layer: usize,
        table: &Table<S>,
        modes: &Modes<S>,
        lines: &[Option<BeamLine>],
    ) -> Self {
        let (mut down, mut up, mut cosine) = ([0.0; MAX_LANES], [0.0; MAX_LANES], [1.0; MAX_LANES]);
        for (lane, line) in lines.iter().enumerate() {
            let Some(beam) = line.as_ref().map(|line| line.layers[layer]) else { continue };
            let scale = azimuthal(lanes.orders[lane]) / beam.cosine;
            (down[lane], up[lane], cosine[lane]) = (beam.down * scale, beam.up * scale, beam.cosine);
        }
        let cosine = Re::load(simd, &cosine);
        let coupling = modes.coupling(simd, table, cosine);
        Self { coupling, nu: cosine.recip(), down: Re::load(simd, &down), up: Re::load(simd, &up) }
    }

    /// The beam down at the top of a part of the layer, and up at its bottom.
    #[inline(always)]
    pub fn at(&self, simd: S, extent: Extent<S>) -> [Re<S>; 2] {
        let rest = (extent.whole - extent.top - extent.thickness).max(Re::splat(simd, 0.0));
        let (above, below) = (Decay::new(simd, self.nu * extent.top), Decay::new(simd, self.nu * rest));
        [self.down * above.left, self.up * below.left]
    }

    #[inline(always)]
    fn add(&self, simd: S, modes: &Modes<S>, passages: &[Passage<S>], extent: Extent<S>, own: &mut [Vec<Re<S>>; 2]) {
        let fall = Fall::new(simd, self.nu, extent.thickness);
        let [down, up] = self.at(simd, extent);
        let [even, odd] = &self.coupling;
        for i in 0..modes.k.len() {
            let Overlap { cosh, sinh, cosh_back, sinh_back } = Overlap::new(simd, modes.k[i], &fall, &passages[i]);
            let k2 = modes.k[i] * modes.k[i];
            let (alpha, beta) = (odd[i], even[i]);
            // The beam up has the odd part of the other sign, and runs from the bottom.
            own[0][i] = own[0][i] + down * (cosh * alpha + sinh * beta) + up * (sinh_back * beta - cosh_back * alpha);
            own[1][i] =
                own[1][i] + down * (k2 * sinh_back * alpha - cosh_back * beta) - up * (k2 * sinh * alpha + cosh * beta);
        }
    }
}

impl<S: Simd> Emission<S> {
    #[inline(always)]
    fn new(simd: S, lanes: &Lanes, layer: usize, table: &Table<S>, modes: &Modes<S>) -> Self {
        let mut drive = table.weights.clone();
        for (value, cosine) in drive.iter_mut().zip(&table.cosines) {
            *value = table.index * (*value / *cosine).sqrt();
        }
        let shares = apply(&modes.x, &drive, Re::splat(simd, 0.0));
        let axial = |m: usize| if m == 0 { 1.0 } else { 0.0 };
        let from = lanes.gather(simd, |plan, m| axial(m) * twice_emitted(plan, layer)[0]);
        let slope = lanes.gather(simd, |plan, m| axial(m) * twice_emitted(plan, layer)[1]);
        Self { shares, from, slope }
    }

    /// Twice what is emitted per optical depth: at the top of a part of the layer, and its slope.
    #[inline(always)]
    pub fn at(&self, extent: Extent<S>) -> [Re<S>; 2] {
        [self.slope.mul_add(extent.top, self.from), self.slope]
    }

    #[inline(always)]
    fn add(&self, simd: S, modes: &Modes<S>, extent: Extent<S>, own: &mut [Vec<Re<S>>; 2]) {
        let [from, slope] = self.at(extent);
        let t = extent.thickness.lanes();
        for (i, share) in self.shares.iter().enumerate() {
            let k = modes.k[i].lanes();
            let mut o = [LinearOverlap::default(); MAX_LANES];
            for (lane, o) in o[..S::F64_LANES].iter_mut().enumerate() {
                *o = LinearOverlap::new(k[lane], t[lane]);
            }
            let flat = lanewise(simd, |lane| o[lane].flat);
            let rising = lanewise(simd, |lane| o[lane].rising);
            let steep = lanewise(simd, |lane| o[lane].steep);
            own[0][i] = own[0][i] + *share * (from * rising + slope * steep);
            own[1][i] = own[1][i] - *share * (from * flat + slope * rising);
        }
    }
}

/// Twice the basic radiance that a layer emits per scaled optical depth: at its top, and how that grows downward.
pub(super) fn twice_emitted(plan: &Plan, layer: usize) -> [f64; 2] {
    let scaled = &plan.layers[layer];
    let [top, bottom] = plan.stack.layers[layer].emission;
    let twice = 2.0 * scaled.loss;
    [twice * top, twice * (bottom - top) / scaled.thickness.max(1e-300)]
}

/// What a beam of flux 1 along its direction gives to one order of the sum over azimuths: `(2 - delta_m0) / 2 pi`.
fn azimuthal(order: usize) -> f64 {
    if order == 0 { 0.5 / std::f64::consts::PI } else { 1.0 / std::f64::consts::PI }
}

/// One number per lane.
#[inline(always)]
pub(super) fn lanewise<S: Simd>(simd: S, mut value: impl FnMut(usize) -> f64) -> Re<S> {
    let mut lanes = [0.0; MAX_LANES];
    lanes[..S::F64_LANES].iter_mut().enumerate().for_each(|(lane, out)| *out = value(lane));
    Re::load(simd, &lanes)
}
