//! Radiance at any height, in any direction.
//!
//! The streams know the light at their own directions; into any other direction it is what the sources between have sent:
//! what the modes scatter, order by order of the expansion in azimuth (`gathered.rs`), what the beam scatters at first and
//! what is emitted (`first_order.rs`), followed through all layers and planes (`ray.rs`).

use std::f64::consts::PI;

use pulp::{Simd, WithSimd};

use super::DiscreteOrdinates;
use super::beam::{BeamLine, Thickness};
use super::drivers::Extent;
use super::first_order::FirstOrder;
use super::fluxes::Light;
use super::forward_peak::{Mending, mending};
use super::gathered::Receiver;
use super::plan::{Plan, Scaled};
use super::ray::{Ends, Followed, Ray, Segment};
use super::shares::{check_modes, flux};
use super::sweep::{Answer, Drive, Lanes, Sweep, tables};
use super::views::{Cuts, Place, Radiances, Views};
use crate::lanes::{MAX_LANES, Re};
use crate::transfer::{Ground, Stack, TransferError};

/// When orders abreast give less than this share of the greatest so far, higher ones are left out.
const NEGLIGIBLE: f64 = 1e-14;

pub(super) fn solve(
    solver: &DiscreteOrdinates,
    stack: &Stack,
    light: &Light,
    views: &Views,
) -> Result<Radiances, TransferError> {
    let depths = views.places.iter().map(|place| match place {
        Place::Depth(depth) => Some(*depth),
        Place::Above | Place::Below => None,
    });
    let cuts = Cuts::new(stack, depths)?;
    let plan = Plan::new(stack, solver.streams, solver.cut_peak);
    let beam = light.beam.map(|(cosine, flux)| BeamLine::new(&plan, cosine, flux, &Thickness::Scaled));
    let question = Question { solver, plan: &plan, light, beam: beam.as_ref(), cuts: &cuts, views };
    let values = pulp::Arch::new().dispatch(question)?;
    Ok(Radiances { values, cosines: views.cosines.len(), azimuths: views.azimuths.len() })
}

struct Question<'a> {
    solver: &'a DiscreteOrdinates,
    plan: &'a Plan<'a>,
    light: &'a Light,
    beam: Option<&'a BeamLine>,
    cuts: &'a Cuts,
    views: &'a Views<'a>,
}

/// The different rays of the views.
struct Rays {
    list: Vec<Ray>,
    /// By place and cosine.
    of: Vec<usize>,
}

/// What the modes give to the rays: by ray and segment, down and up, by order.
struct Orders {
    values: Vec<f64>,
    count: usize,
    /// Rises from the ground or from below.
    below: f64,
}

impl WithSimd for Question<'_> {
    type Output = Result<Vec<f64>, TransferError>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self { plan, light, views, .. } = self;
        let rays = self.rays();
        let bounds = self.bounds();
        let orders = self.orders(simd, &rays.list, &bounds)?;
        let exact = self.solver.correct_radiance;
        let first = FirstOrder::new(simd, plan, self.beam, &rays.list, views.azimuths, exact);
        let above = plan.frame.media[plan.frame.above].index;
        let mirror = if let Ground::Mirror(share) = plan.stack.ground { share } else { 0.0 };
        let ends = Ends { above: light.above / (above * above), below: orders.below, mirror };
        let mendings = self.mendings(simd, &rays.list, &bounds);
        let mut values = vec![0.0; views.places.len() * views.cosines.len() * views.azimuths.len()];
        for (number, azimuth) in views.azimuths.iter().enumerate() {
            let waves: Vec<f64> = (0..orders.count).map(|m| (m as f64 * azimuth).cos()).collect();
            let mut followed = Vec::with_capacity(rays.list.len());
            let mut gathered = orders.values.chunks_exact(2 * orders.count.max(1));
            for (i, ray) in rays.list.iter().enumerate() {
                let mut segments = Vec::with_capacity(bounds.len());
                for (layer, bounds) in bounds.iter().enumerate() {
                    let mut list = Vec::with_capacity(bounds.len());
                    for (cut, pair) in bounds.windows(2).enumerate() {
                        let gathered = gathered.next().unwrap_or(&[]);
                        let Some(cosine) = ray.cosines[layer] else {
                            list.push(Segment::default());
                            continue;
                        };
                        let mut segment = first.gather(layer, (i, cosine), number, pair[0], pair[1] - pair[0]);
                        let (down, up) = gathered.split_at(orders.count);
                        segment.down += down.iter().zip(&waves).map(|(value, wave)| value * wave).sum::<f64>();
                        segment.up += up.iter().zip(&waves).map(|(value, wave)| value * wave).sum::<f64>();
                        if let Some(mending) = mendings.get(i) {
                            let at = |bound: usize| mending[layer][bound].get(number).copied().unwrap_or(0.0);
                            segment.down += at(cut + 1) - segment.fade * at(cut);
                        }
                        list.push(segment);
                    }
                    segments.push(list);
                }
                followed.push(ray.follow(&segments, ends));
            }
            self.read(&rays, &followed, number, &mut values);
        }
        Ok(values)
    }
}

impl Question<'_> {
    /// The medium of a place, and its refractive index.
    fn index(&self, place: usize) -> f64 {
        let plan = self.plan;
        let medium = match (self.views.places[place], self.cuts.asked[place]) {
            (Place::Depth(_), Some((layer, _))) => plan.layers[layer].medium,
            (Place::Below, _) => plan.frame.below,
            _ => plan.frame.above,
        };
        plan.frame.media[medium].index
    }

    fn rays(&self) -> Rays {
        let mut known: Vec<(f64, f64)> = Vec::new();
        let mut rays = Rays { list: Vec::new(), of: Vec::new() };
        for place in 0..self.views.places.len() {
            let index = self.index(place);
            for cosine in self.views.cosines {
                let here = (cosine.abs(), index);
                let number = known.iter().position(|other| *other == here).unwrap_or_else(|| {
                    known.push(here);
                    rays.list.push(Ray::new(self.plan, here.0, index));
                    known.len() - 1
                });
                rays.of.push(number);
            }
        }
        rays
    }

    /// Of each layer: scaled depths from its top to its bottom, the cuts between.
    fn bounds(&self) -> Vec<Vec<f64>> {
        let layers = self.plan.layers.iter().zip(&self.cuts.depths);
        layers
            .map(|(layer, cuts)| {
                let cuts = cuts.iter().map(|depth| depth * layer.stretch);
                std::iter::once(0.0).chain(cuts).chain([layer.thickness]).collect()
            })
            .collect()
    }

    /// For each ray, if radiance is to be corrected and there is a beam.
    #[inline(always)]
    fn mendings<S: Simd>(&self, simd: S, rays: &[Ray], bounds: &[Vec<f64>]) -> Vec<Mending> {
        let mut mendings = Vec::new();
        if let Some(beam) = self.beam.filter(|_| self.solver.correct_radiance && self.solver.cut_peak) {
            for ray in rays {
                mendings.push(mending(simd, self.plan, beam, ray, bounds, self.views.azimuths));
            }
        }
        mendings
    }

    /// How many orders there are: only an oblique beam has more than one, and only as many as the phase functions have
    /// moments.
    fn order_count(&self) -> usize {
        match self.light.beam {
            Some((cosine, flux)) if cosine < 1.0 && flux > 0.0 => {}
            _ => return 1,
        }
        let scattering = self.plan.layers.iter().filter(|layer| layer.albedo > 0.0);
        let last = |layer: &Scaled| (0..layer.degrees).rfind(|degree| layer.moment(*degree) != 0.0).unwrap_or(0);
        scattering.map(last).max().unwrap_or(0) + 1
    }

    /// What the modes give to each ray.
    #[inline(always)]
    fn orders<S: Simd>(&self, simd: S, rays: &[Ray], bounds: &[Vec<f64>]) -> Result<Orders, TransferError> {
        let abreast = S::F64_LANES.min(MAX_LANES);
        let total = self.order_count();
        let segments: usize = bounds.iter().map(|bounds| bounds.len() - 1).sum();
        let mut orders = Orders { values: vec![0.0; 2 * segments * rays.len() * total], count: total, below: 0.0 };
        let drives = [self.light.drive()];
        let cuts = self.cuts.scaled(simd, self.plan);
        let mut greatest = 0.0f64;
        for from in (0..total).step_by(abreast) {
            let numbers = std::array::from_fn(|lane| (from + lane % abreast).min(total - 1));
            let lanes = Lanes { plans: [self.plan; MAX_LANES], orders: numbers };
            let tables = tables(simd, &lanes);
            let sweep = Sweep::new(simd, &lanes, &tables, &drives, &cuts);
            check_modes(&sweep, abreast, self.solver.streams)?;
            let answer = sweep.descend();
            if from == 0 {
                orders.below = self.below(simd, &sweep, &answer, &drives[0]);
            }
            let most = self.gather(simd, (&sweep, &answer), rays, bounds, from, &mut orders);
            if most <= NEGLIGIBLE * greatest {
                break;
            }
            greatest = greatest.max(most);
        }
        Ok(orders)
    }

    /// Of the orders abreast, to every ray and segment; returns the greatest.
    #[inline(always)]
    fn gather<S: Simd>(
        &self,
        simd: S,
        (sweep, answer): (&Sweep<S>, &Answer<S>),
        rays: &[Ray],
        bounds: &[Vec<f64>],
        from: usize,
        orders: &mut Orders,
    ) -> f64 {
        let count = S::F64_LANES.min(orders.count - from);
        let total = orders.count;
        let mut slots = orders.values.chunks_exact_mut(total);
        let mut greatest = 0.0f64;
        for ray in rays {
            for (layer, bounds) in bounds.iter().enumerate() {
                let slice = &sweep.slices[layer];
                let table = &sweep.tables[self.plan.layers[layer].medium];
                let Some(cosine) = ray.cosines[layer] else {
                    // Totally reflected elsewhere: its slots stay 0.
                    slots.by_ref().take(2 * (bounds.len() - 1)).for_each(|_| {});
                    continue;
                };
                let receiver = Receiver::new(simd, &slice.modes, table, cosine);
                let whole = Re::splat(simd, self.plan.layers[layer].thickness);
                for (cut, pair) in bounds.windows(2).enumerate() {
                    let (top, thickness) = (Re::splat(simd, pair[0]), Re::splat(simd, pair[1] - pair[0]));
                    let extent = Extent { top, thickness, whole };
                    let levels = [&answer.ends[0][layer][cut], &answer.ends[0][layer][cut + 1]];
                    let found = receiver.gather(simd, &slice.modes, &slice.drives[0], extent, levels);
                    for side in [found.down, found.up] {
                        let lanes = side.lanes();
                        let Some(slot) = slots.next() else { continue };
                        slot[from..from + count].copy_from_slice(&lanes[..count]);
                        greatest = lanes[..count].iter().fold(greatest, |most, value| most.max(value.abs()));
                    }
                }
            }
        }
        greatest
    }

    /// The basic radiance that rises from the ground.
    #[inline(always)]
    fn below<S: Simd>(&self, simd: S, sweep: &Sweep<S>, answer: &Answer<S>, drive: &Drive) -> f64 {
        let plan = self.plan;
        let index = plan.frame.media[plan.frame.below].index;
        let radiance = match plan.stack.ground {
            Ground::Black => drive.below,
            Ground::Mirror(_) => 0.0,
            Ground::Lambertian(share) => {
                let diffuse = flux(simd, &sweep.tables[plan.frame.below], &answer.below[0], 1.0)[0];
                share * (diffuse + self.beam.map_or(0.0, |beam| beam.on_ground)) / PI
            }
        };
        radiance / (index * index)
    }

    /// At the places.
    fn read(&self, rays: &Rays, followed: &[Followed], azimuth: usize, values: &mut [f64]) {
        let Views { places, cosines, azimuths } = *self.views;
        for (place, asked) in
            places.iter().zip(&self.cuts.asked).enumerate().map(|(i, (place, cut))| (i, (*place, *cut)))
        {
            let index = self.index(place);
            for (number, cosine) in cosines.iter().enumerate() {
                let ray = &followed[rays.of[place * cosines.len() + number]];
                let pair = match asked {
                    (Place::Depth(_), Some((layer, cut))) => ray.cuts[layer][cut],
                    (Place::Below, _) => ray.below,
                    _ => ray.above,
                };
                let basic = if *cosine > 0.0 { pair[0] } else { pair[1] };
                values[(place * cosines.len() + number) * azimuths.len() + azimuth] = basic * index * index;
            }
        }
    }
}

#[cfg(test)]
mod tests;
