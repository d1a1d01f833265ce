//! Shares of the light that falls in.

use std::f64::consts::PI;

use pulp::{Simd, WithSimd};

use super::DiscreteOrdinates;
use super::beam::{BeamLine, Thickness};
use super::matrix::dot;
use super::modes::Table;
use super::plan::{Plan, Shape};
use super::sweep::{Drive, Lanes, Level, Sweep};
use crate::lanes::{LaneArray, MAX_LANES, Re};
use crate::transfer::{Ground, Incidence, Shares, Stack, TransferError};

/// For every stack and every incidence.
pub(super) fn solve(
    solver: &DiscreteOrdinates,
    stacks: &[Stack],
    incidences: &[Incidence],
) -> Result<Vec<Vec<Shares>>, TransferError> {
    let plans: Vec<Plan> = stacks.iter().map(|stack| Plan::new(stack, solver.streams, solver.cut_peak)).collect();
    let drives: Vec<Drive> = incidences.iter().map(|incidence| drive(*incidence)).collect();
    let shapes: Vec<Shape> = plans.iter().map(Plan::shape).collect();
    let mut out = Vec::with_capacity(stacks.len());
    let mut first = 0;
    while first < plans.len() {
        let alike = shapes[first..].iter().take(MAX_LANES).take_while(|shape| **shape == shapes[first]).count();
        let found = pulp::Arch::new().dispatch(Group {
            plans: &plans[first..first + alike],
            drives: &drives,
            incidences,
            solver,
        })?;
        out.extend(found);
        first += alike;
    }
    Ok(out)
}

/// Light of flux 1 onto the horizontal.
fn drive(incidence: Incidence) -> Drive {
    match incidence {
        Incidence::Beam(cosine) => Drive { beam: Some((cosine, 1.0)), ..Drive::default() },
        Incidence::Diffuse => Drive { above: 1.0 / PI, ..Drive::default() },
    }
}

/// Plans of one shape, at most [`MAX_LANES`].
struct Group<'a> {
    plans: &'a [Plan<'a>],
    drives: &'a [Drive],
    incidences: &'a [Incidence],
    solver: &'a DiscreteOrdinates,
}

impl WithSimd for Group<'_> {
    type Output = Result<Vec<Vec<Shares>>, TransferError>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let mut out = Vec::with_capacity(self.plans.len());
        for plans in self.plans.chunks(S::F64_LANES.min(MAX_LANES)) {
            let lanes =
                Lanes { plans: std::array::from_fn(|lane| &plans[lane.min(plans.len() - 1)]), orders: [0; MAX_LANES] };
            let cuts = vec![Vec::new(); plans[0].layers.len()];
            let sweep = Sweep::new(simd, &lanes, self.drives, &cuts);
            check_modes(&sweep, plans.len(), self.solver.streams)?;
            let answer = sweep.descend();
            let mut found = vec![Vec::with_capacity(self.drives.len()); plans.len()];
            for (index, incidence) in self.incidences.iter().enumerate() {
                let [above, below] = [plans[0].above, plans[0].below].map(|medium| &sweep.tables[medium]);
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
        }
        Ok(out)
    }
}

/// The flux of the streams: down (`sign` 1) or up (-1).
#[inline(always)]
pub(super) fn flux<S: Simd>(simd: S, table: &Table<S>, level: &Level<S>, sign: f64) -> LaneArray {
    let roots = table.root_fluxes();
    let zero = Re::splat(simd, 0.0);
    let sum = Re::splat(simd, sign).mul_add(dot(&roots, &level.d, zero), dot(&roots, &level.s, zero));
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
            let streams = &plan.media[plan.above].streams;
            let total: f64 = streams.iter().map(|stream| stream.weight * stream.cosine).sum();
            streams.iter().fold([0.0; 2], |sum, stream| {
                let found = line(stream.cosine, stream.weight * stream.cosine / total);
                [sum[0] + found[0], sum[1] + found[1]]
            })
        }
    };
    (reflected, on_ground)
}
