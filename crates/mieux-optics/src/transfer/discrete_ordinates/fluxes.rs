//! Fluxes at any depth.

use std::f64::consts::PI;

use pulp::{Simd, WithSimd};

use super::beam::{BeamLine, Thickness};
use super::modes::Table;
use super::plan::Plan;
use super::shares::{check_modes, flux};
use super::sweep::{Drive, Lanes, Level, Sweep, tables};
use super::views::Cuts;
use super::{DiscreteOrdinates, check_cosine};
use crate::lanes::{MAX_LANES, Re};
use crate::transfer::{Stack, TransferError};

/// The light that meets a stack from outside. What layers emit comes in addition.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Light {
    /// Parallel light from above: the cosine of its angle with the normal there, in (0, 1], and its flux onto the
    /// horizontal, from 0 up in any unit.
    pub beam: Option<(f64, f64)>,
    /// Radiance that falls in from all directions above, in the unit of flux per steradian.
    pub above: f64,
    /// The same from below; a ground that reflects lets nothing through.
    pub below: f64,
}

impl Light {
    pub(super) fn drive(&self) -> Drive {
        Drive { beam: self.beam, above: self.above, below: self.below, emission: true }
    }

    pub(super) fn check(&self) -> Result<(), TransferError> {
        if let Some((cosine, _)) = self.beam {
            check_cosine(cosine)?;
        }
        let strengths = [self.above, self.below, self.beam.map_or(0.0, |(_, flux)| flux)];
        match strengths.into_iter().find(|value| !(*value >= 0.0 && value.is_finite())) {
            Some(value) => Err(TransferError::Source { value }),
            None => Ok(()),
        }
    }
}

/// Flux through a horizontal plane, in the unit of the light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fluxes {
    /// Of the beam, downward, that was never scattered.
    pub down_direct: f64,
    /// All other light downward.
    pub down_diffuse: f64,
    /// Upward.
    pub up: f64,
    /// The mean over all directions of all radiance, the beam's included; in the unit of the light per steradian.
    pub mean_intensity: f64,
}

impl Fluxes {
    /// Downward less upward.
    pub fn net(&self) -> f64 {
        self.down_direct + self.down_diffuse - self.up
    }
}

pub(super) fn solve(
    solver: &DiscreteOrdinates,
    stack: &Stack,
    light: &Light,
    depths: &[f64],
) -> Result<Vec<Fluxes>, TransferError> {
    let cuts = Cuts::new(stack, depths.iter().copied().map(Some))?;
    let plan = Plan::new(stack, solver.streams, solver.cut_peak);
    pulp::Arch::new().dispatch(Question { plan: &plan, light, cuts: &cuts, streams: solver.streams })
}

struct Question<'a> {
    plan: &'a Plan<'a>,
    light: &'a Light,
    cuts: &'a Cuts,
    streams: usize,
}

impl WithSimd for Question<'_> {
    type Output = Result<Vec<Fluxes>, TransferError>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self { plan, light, cuts, streams } = self;
        let lanes = Lanes { plans: [plan; MAX_LANES], orders: [0; MAX_LANES] };
        let drives = [light.drive()];
        let tables = tables(simd, &lanes);
        let sweep = Sweep::new(simd, &lanes, &tables, &drives, &cuts.scaled(simd, plan));
        check_modes(&sweep, 1, streams)?;
        let answer = sweep.descend();
        let line = |thickness| light.beam.map(|(cosine, flux)| BeamLine::new(plan, cosine, flux, &thickness));
        let (scaled, exact) = (line(Thickness::Scaled), line(Thickness::True));
        let mut out = Vec::with_capacity(cuts.asked.len());
        for (number, cut) in cuts.asked.iter().flatten() {
            let (layer, depth) = (&plan.layers[*number], cuts.depths[*number][*cut]);
            let table = &sweep.tables[layer.medium];
            let level = &sweep.slices[*number].modes.streams(simd, &answer.ends[0][*number][cut + 1]);
            let beam = |line: &Option<BeamLine>, depth: f64, thickness: f64| {
                line.as_ref().map_or([0.0; 2], |line| line.layers[*number].at(depth, thickness))
            };
            let [down, up] = beam(&scaled, depth * layer.stretch, layer.thickness);
            let [direct, _] = beam(&exact, depth, plan.stack.layers[*number].optical_thickness);
            let cosine = scaled.as_ref().map_or(1.0, |line| line.layers[*number].cosine);
            out.push(Fluxes {
                down_direct: direct,
                down_diffuse: flux(simd, table, level, 1.0)[0] + down - direct,
                up: flux(simd, table, level, -1.0)[0] + up,
                mean_intensity: mean_intensity(simd, table, level) + (down + up) / (4.0 * PI * cosine),
            });
        }
        Ok(out)
    }
}

/// Of the streams.
#[inline(always)]
fn mean_intensity<S: Simd>(simd: S, table: &Table<S>, level: &Level<S>) -> f64 {
    let mut sum = Re::splat(simd, 0.0);
    for (i, s) in level.s.iter().enumerate() {
        sum = (table.weights[i] / table.cosines[i]).sqrt().mul_add(*s, sum);
    }
    0.5 * (sum * table.index).lanes()[0]
}
