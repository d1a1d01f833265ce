//! Shares of the light that falls in.

use std::f64::consts::PI;
use std::rc::Rc;

use pulp::{Simd, WithSimd};

use super::DiscreteOrdinates;
use super::beam::{BeamLine, Thickness};
use super::matrix::dot;
use super::modes::Table;
use super::plan::{Frame, Plan, Planner};
use super::sweep::{Drive, Lanes, Level, Sweep, tables};
use crate::lanes::{LaneArray, MAX_LANES, Re};
use crate::transfer::{Ground, Incidence, Shares, Stack, TransferError};

/// For every stack and every incidence.
pub(super) fn solve(
    solver: &DiscreteOrdinates,
    stacks: &[Stack],
    incidences: &[Incidence],
) -> Result<Vec<Vec<Shares>>, TransferError> {
    let drives: Vec<Drive> = incidences.iter().map(|incidence| drive(*incidence)).collect();
    pulp::Arch::new().dispatch(Question { solver, stacks, incidences, drives: &drives })
}

/// Light of flux 1 onto the horizontal.
fn drive(incidence: Incidence) -> Drive {
    match incidence {
        Incidence::Beam(cosine) => Drive { beam: Some((cosine, 1.0)), ..Drive::default() },
        Incidence::Diffuse => Drive { above: 1.0 / PI, ..Drive::default() },
    }
}

struct Question<'a> {
    solver: &'a DiscreteOrdinates,
    stacks: &'a [Stack],
    incidences: &'a [Incidence],
    drives: &'a [Drive],
}

impl WithSimd for Question<'_> {
    type Output = Result<Vec<Vec<Shares>>, TransferError>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let abreast = S::F64_LANES.min(MAX_LANES);
        let mut out = Vec::with_capacity(self.stacks.len());
        let mut planner = Planner::new(self.solver.streams, self.solver.cut_peak);
        let mut waiting = self.stacks.iter().map(|stack| planner.plan(stack));
        let mut plans: Vec<Plan> = waiting.by_ref().take(abreast).collect();
        // The wavelengths of a material of constant index share their tables.
        let mut known: Option<(Rc<Frame>, Vec<Table<S>>)> = None;
        while let Some(first) = plans.first() {
            let alike = plans.iter().take_while(|plan| plan.is_like(first)).count();
            let group = &plans[..alike];
            let lanes =
                Lanes { plans: std::array::from_fn(|lane| &group[lane.min(alike - 1)]), orders: [0; MAX_LANES] };
            let (_, tables) = match known.take().filter(|(frame, _)| group.iter().all(|plan| plan.shares_media(frame)))
            {
                Some(same) => known.insert(same),
                None => known.insert((Rc::clone(&first.frame), tables(simd, &lanes))),
            };
            let mixed = !group.iter().all(|plan| plan.shares_media(&first.frame));
            self.answer(simd, &lanes, tables, group, &mut out)?;
            if mixed {
                known = None;
            }
            plans.drain(..alike);
            plans.extend(waiting.by_ref().take(alike));
        }
        Ok(out)
    }
}

impl Question<'_> {
    /// For plans of one shape, no more than there are lanes.
    #[inline(always)]
    fn answer<S: Simd>(
        &self,
        simd: S,
        lanes: &Lanes,
        tables: &[Table<S>],
        plans: &[Plan],
        out: &mut Vec<Vec<Shares>>,
    ) -> Result<(), TransferError> {
        let cuts = vec![Vec::new(); plans[0].layers.len()];
        let sweep = Sweep::new(simd, lanes, tables, self.drives, &cuts);
        check_modes(&sweep, plans.len(), self.solver.streams)?;
        let answer = sweep.descend();
        let mut found: Vec<Vec<Shares>> = plans.iter().map(|_| Vec::with_capacity(self.drives.len())).collect();
        for (index, incidence) in self.incidences.iter().enumerate() {
            let [above, below] = [plans[0].frame.above, plans[0].frame.below].map(|medium| &tables[medium]);
            let up = flux(simd, above, &answer.above[index], -1.0);
            let down = flux(simd, above, &answer.above[index], 1.0);
            let below_down = flux(simd, below, &answer.below[index], 1.0);
            let below_up = flux(simd, below, &answer.below[index], -1.0);
            for (lane, plan) in plans.iter().enumerate() {
                let line = sweep.beams[index][lane].as_ref();
                let flows = Flows {
                    down: line.map_or(down[lane], |_| 1.0),
                    up: up[lane],
                    below: below_down[lane] - below_up[lane],
                };
                found[lane].push(flows.shares(plan, *incidence, line));
            }
        }
        out.extend(found);
        Ok(())
    }
}

/// The flux of the streams: down (`sign` 1) or up (-1).
#[inline(always)]
pub(super) fn flux<S: Simd>(simd: S, table: &Table<S>, level: &Level<S>, sign: f64) -> LaneArray {
    let roots = &table.root_fluxes;
    let zero = Re::splat(simd, 0.0);
    let sum = Re::splat(simd, sign).mul_add(dot(roots, &level.d, zero), dot(roots, &level.s, zero));
    (sum * Re::splat(simd, PI)).lanes()
}

/// That every layer has modes.
#[inline(always)]
pub(super) fn check_modes<S: Simd>(sweep: &Sweep<S>, lanes: usize, streams: usize) -> Result<(), TransferError> {
    for (layer, slice) in sweep.slices.iter().enumerate() {
        if !slice.modes.least.lanes()[..lanes].iter().all(|least| *least > 0.0) {
            return Err(TransferError::NotAPhaseFunction { layer, streams });
        }
    }
    Ok(())
}

/// Fluxes of the streams; that down at the top is all that falls in.
struct Flows {
    down: f64,
    up: f64,
    below: f64,
}

impl Flows {
    fn shares(&self, plan: &Plan, incidence: Incidence, line: Option<&BeamLine>) -> Shares {
        let kept = match plan.stack.ground {
            Ground::Mirror(share) => 1.0 - share,
            _ => 1.0,
        };
        let lambert = match plan.stack.ground {
            Ground::Lambertian(share) => share,
            _ => 0.0,
        };
        let (reflected, on_ground) = line.map_or((0.0, 0.0), |line| (line.reflected, line.on_ground));
        let reflectance = (self.up + reflected) / self.down;
        let transmittance = (self.below + on_ground * kept) / self.down;
        let (specular, unscattered) = unscattered(plan, incidence);
        Shares {
            reflectance,
            transmittance,
            absorptance: 1.0 - reflectance - transmittance,
            reflectance_specular: specular,
            transmittance_unscattered: unscattered * kept * (1.0 - lambert),
        }
    }
}

/// What is reflected and what reaches the ground without having been scattered, of light of flux 1.
pub(in crate::transfer) fn unscattered(plan: &Plan, incidence: Incidence) -> (f64, f64) {
    let line = |cosine: f64, flux: f64| {
        let line = BeamLine::new(plan, cosine, flux, &Thickness::True);
        [line.reflected, line.on_ground]
    };
    let [reflected, on_ground] = match incidence {
        Incidence::Beam(cosine) => line(cosine, 1.0),
        Incidence::Diffuse => {
            let streams = &plan.frame.media[plan.frame.above].streams;
            let total: f64 = streams.iter().map(|stream| stream.weight * stream.cosine).sum();
            streams.iter().fold([0.0; 2], |sum, stream| {
                let found = line(stream.cosine, stream.weight * stream.cosine / total);
                [sum[0] + found[0], sum[1] + found[1]]
            })
        }
    };
    (reflected, on_ground)
}
