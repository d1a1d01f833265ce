//! What the modes of a layer, and the beams and the emission in it, give to a direction.
//!
//! The integral of a mode along a ray needs no antiderivative: multiplied by the ray's fading and integrated by parts, the
//! equations of the mode, `f' = -g + ...`, `g' = -k^2 f + ...`, are two linear equations for the integrals of `f` and `g`,
//! with the values at both ends and the sources on their right.

use pulp::Simd;

use super::depth::{crossing, fading};
use super::drivers::{Extent, LayerDrive};
use super::modes::{Modes, Table};
use super::sweep::Level;
use crate::lanes::{Re, step};

/// A direction (up and down) in a layer.
pub(super) struct Receiver<S: Simd> {
    cosine: f64,
    coupling: [Vec<Re<S>>; 2],
}

/// Integrals along a ray, up and down, through a part of a layer.
pub(super) struct Gathered<S: Simd> {
    pub down: Re<S>,
    pub up: Re<S>,
}

/// A ray that fades by `exp(-lambda x)`, and the sources gathered by it, in one lane or in all.
struct Fading<S: Simd> {
    lambda: Re<S>,
    fade: Re<S>,
    /// Of the beams down and up, and of the emission.
    beams: [Re<S>; 2],
    emission: Re<S>,
}

/// A mode and a ray are too close when their rates differ by less than this share.
const NEAR: f64 = 5e-4;

/// Where the ray is sampled instead, as shares of its rate, with weights: exact to the third power of the steps.
const BESIDE: [(f64, f64); 4] = [(1e-3, 4.0 / 6.0), (-1e-3, 4.0 / 6.0), (2e-3, -1.0 / 6.0), (-2e-3, -1.0 / 6.0)];

/// Sources and levels as a ray meets them: a ray down is a ray up in the layer turned over.
struct Side<'a, S: Simd> {
    near: &'a Level<S>,
    far: &'a Level<S>,
    /// 1 up, -1 down.
    sign: Re<S>,
}

impl<S: Simd> Receiver<S> {
    #[inline(always)]
    pub fn new(simd: S, modes: &Modes<S>, table: &Table<S>, cosine: f64) -> Self {
        Self { cosine, coupling: modes.coupling(simd, table, Re::splat(simd, cosine)) }
    }

    /// The light scattered more than once that the ray gathers between two levels (in modes) of the layer, and that
    /// scattered after being emitted.
    #[inline(always)]
    pub fn gather(
        &self,
        simd: S,
        modes: &Modes<S>,
        drive: &LayerDrive<S>,
        extent: Extent<S>,
        [top, bottom]: [&Level<S>; 2],
    ) -> Gathered<S> {
        step(
            simd,
            #[inline(always)]
            || self.both(simd, modes, drive, extent, [top, bottom]),
        )
    }

    #[inline(always)]
    fn both(
        &self,
        simd: S,
        modes: &Modes<S>,
        drive: &LayerDrive<S>,
        extent: Extent<S>,
        [top, bottom]: [&Level<S>; 2],
    ) -> Gathered<S> {
        let one = Re::splat(simd, 1.0);
        let up = Side { near: top, far: bottom, sign: one };
        let down = Side { near: bottom, far: top, sign: one.same(-1.0) };
        Gathered {
            up: self.along(simd, modes, drive, extent, &up),
            down: self.along(simd, modes, drive, extent, &down),
        }
    }

    #[inline(always)]
    fn along(&self, simd: S, modes: &Modes<S>, drive: &LayerDrive<S>, extent: Extent<S>, side: &Side<S>) -> Re<S> {
        let (zero, one) = (Re::splat(simd, 0.0), Re::splat(simd, 1.0));
        let is_up = side.sign.lanes()[0] > 0.0;
        let lambda = 1.0 / self.cosine;
        let ray = Fading::new(simd, drive, extent, lambda, is_up);
        let near = ray.lambda * Re::splat(simd, NEAR);
        let mut beside: Vec<Fading<S>> = Vec::new();
        let mut sum = zero;
        for i in 0..modes.k.len() {
            let k = modes.k[i];
            let close = (k - ray.lambda).abs();
            let mut found = self.mode(drive, side, &ray, k, i, close.if_less(near, one, zero));
            if close.any_less(near) {
                if beside.is_empty() {
                    for (step, _) in BESIDE {
                        beside.push(Fading::new(simd, drive, extent, lambda * (1.0 + step), is_up));
                    }
                }
                let mut mean = zero;
                for (ray, (_, weight)) in beside.iter().zip(BESIDE) {
                    mean = self.mode(drive, side, ray, k, i, zero).mul_add(Re::splat(simd, weight), mean);
                }
                found = close.if_less(near, mean, found);
            }
            sum = sum + found;
        }
        sum * ray.lambda * Re::splat(simd, 0.5)
    }

    /// The integral of mode `i` along a ray; where `skip` is 1 anything finite.
    #[inline(always)]
    fn mode(&self, drive: &LayerDrive<S>, side: &Side<S>, ray: &Fading<S>, k: Re<S>, i: usize, skip: Re<S>) -> Re<S> {
        let Fading { lambda, fade, beams: [down, up], emission } = ray;
        // f and g at both ends; g changes its sign with the direction.
        let mut first = fade.neg_mul_add(side.far.s[i], side.near.s[i]);
        let mut second = fade.neg_mul_add(side.far.d[i], side.near.d[i]) * side.sign;
        if let Some(beam) = &drive.beam {
            let [even, odd] = &beam.coupling;
            first = (odd[i] * side.sign).mul_add(*down - *up, first);
            second = even[i].mul_add(*down + *up, second);
        }
        if let Some(own) = &drive.emission {
            second = own.shares[i].mul_add(*emission, second);
        }
        let apart = (*lambda - k) * (*lambda + k) + skip;
        let f = lambda.mul_add(first, lambda.same(0.0) - second);
        let g = lambda.mul_add(second, lambda.same(0.0) - k * k * first);
        let [even, odd] = &self.coupling;
        (even[i] * f - odd[i] * g) / apart
    }
}

impl<S: Simd> Fading<S> {
    #[inline(always)]
    fn new(simd: S, drive: &LayerDrive<S>, extent: Extent<S>, lambda: f64, is_up: bool) -> Self {
        let t = extent.thickness.lanes()[0];
        let zero = Re::splat(simd, 0.0);
        let (mut beams, mut emission) = ([zero; 2], zero);
        if let Some(beam) = &drive.beam {
            let nu = beam.nu.lanes()[0];
            let (along, against) = (Re::splat(simd, fading(nu + lambda, t)), Re::splat(simd, crossing(nu, lambda, t)));
            let [down, up] = beam.at(simd, extent);
            beams = if is_up { [down * along, up * against] } else { [down * against, up * along] };
        }
        if let Some(own) = &drive.emission {
            let [from, slope] = own.at(extent);
            let flat = Re::splat(simd, fading(lambda, t));
            let rising = Re::splat(simd, rising(lambda, t));
            emission = if is_up {
                from * flat + slope * rising
            } else {
                slope.mul_add(extent.thickness, from) * flat - slope * rising
            };
        }
        Self { lambda: Re::splat(simd, lambda), fade: Re::splat(simd, (-lambda * t).exp()), beams, emission }
    }
}

/// The integral over `x` in [0, t] of `x exp(-a x)`.
pub(super) fn rising(a: f64, t: f64) -> f64 {
    let x = a * t;
    if x < 1e-2 {
        let series = 0.5 - x * (1.0 / 3.0 - x * (1.0 / 8.0 - x * (1.0 / 30.0 - x * (1.0 / 144.0 - x / 840.0))));
        return t * t * series;
    }
    (-(-x).exp_m1() - x * (-x).exp()) / (a * a)
}
