//! Fluxes at any depth.

use pulp::{Simd, WithSimd};

use super::beam::{BeamLine, Thickness};
use super::plan::Plan;
use super::shares::{check_modes, flux};
use super::sweep::{Drive, Lanes, Sweep};
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
}

impl Fluxes {
    /// Downward less upward.
    pub fn net(&self) -> f64 {
        self.down_direct + self.down_diffuse - self.up
    }
}

/// Where a depth lies: the layer, the depth in it, and the place in the list of those asked for.
#[derive(Debug, Clone, Copy)]
struct Place {
    layer: usize,
    depth: f64,
    asked: usize,
}

pub(super) fn solve(
    solver: &DiscreteOrdinates,
    stack: &Stack,
    light: &Light,
    depths: &[f64],
) -> Result<Vec<Fluxes>, TransferError> {
    let mut places = Vec::with_capacity(depths.len());
    for (asked, depth) in depths.iter().enumerate() {
        places.push(place(stack, *depth, asked)?);
    }
    places.sort_by(|a, b| a.layer.cmp(&b.layer).then(a.depth.total_cmp(&b.depth)));
    let plan = Plan::new(stack, solver.streams, solver.cut_peak);
    pulp::Arch::new().dispatch(Question { plan: &plan, light, places: &places, streams: solver.streams })
}

/// A depth at a plane belongs to the layer below, that of the bottom to the last.
fn place(stack: &Stack, depth: f64, asked: usize) -> Result<Place, TransferError> {
    let last = stack.layers.len().saturating_sub(1);
    let mut rest = depth;
    if depth >= 0.0 {
        for (layer, thickness) in stack.layers.iter().map(|layer| layer.optical_thickness).enumerate() {
            // What is left after subtracting the layers above carries their rounding.
            let slack = 1e-12 * depth;
            if rest < thickness || (layer == last && rest <= thickness + slack) {
                return Ok(Place { layer, depth: rest.min(thickness), asked });
            }
            rest -= thickness;
        }
    }
    Err(TransferError::Depth { layer: last, value: depth })
}

struct Question<'a> {
    plan: &'a Plan<'a>,
    light: &'a Light,
    places: &'a [Place],
    streams: usize,
}

impl WithSimd for Question<'_> {
    type Output = Result<Vec<Fluxes>, TransferError>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self { plan, light, places, streams } = self;
        let lanes = Lanes { plans: [plan; MAX_LANES], orders: [0; MAX_LANES] };
        let mut cuts = vec![Vec::new(); plan.layers.len()];
        for place in places {
            cuts[place.layer].push(Re::splat(simd, place.depth * plan.layers[place.layer].stretch));
        }
        let drive = Drive { beam: light.beam, above: light.above, below: light.below, emission: true };
        let drives = [drive];
        let sweep = Sweep::new(simd, &lanes, &drives, &cuts);
        check_modes(&sweep, 1, streams)?;
        let answer = sweep.descend();
        let line = |thickness| light.beam.map(|(cosine, flux)| BeamLine::new(plan, cosine, flux, &thickness));
        let (scaled, exact) = (line(Thickness::Scaled), line(Thickness::True));
        let mut out = vec![Fluxes { down_direct: 0.0, down_diffuse: 0.0, up: 0.0 }; places.len()];
        let mut cut = 0;
        for (i, place) in places.iter().enumerate() {
            let layer = &plan.layers[place.layer];
            // Those in one layer come one after the other, from its top.
            cut = if i > 0 && places[i - 1].layer == place.layer { cut + 1 } else { 1 };
            let modal = &answer.ends[0][place.layer][cut];
            let level = &sweep.slices[place.layer].modes.streams(simd, modal);
            let table = &sweep.tables[layer.medium];
            let beam = |line: &Option<BeamLine>, depth: f64, thickness: f64| {
                line.as_ref().map_or([0.0; 2], |line| line.layers[place.layer].at(depth, thickness))
            };
            let [down, up] = beam(&scaled, place.depth * layer.stretch, layer.thickness);
            let [direct, _] = beam(&exact, place.depth, plan.stack.layers[place.layer].optical_thickness);
            out[place.asked] = Fluxes {
                down_direct: direct,
                down_diffuse: flux(simd, table, level, 1.0)[0] + down - direct,
                up: flux(simd, table, level, -1.0)[0] + up,
            };
        }
        Ok(out)
    }
}
