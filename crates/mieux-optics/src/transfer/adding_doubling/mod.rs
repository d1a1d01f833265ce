//! Adding and doubling (`vandehulst1980`, `prahl1993`): what a thin layer reflects and transmits is known, two layers
//! together follow from each, and so a thick one from a thin one and a stack from its layers.
//!
//! It follows light along the same streams as [`DiscreteOrdinates`](super::DiscreteOrdinates) and shares nothing else with
//! it: no modes, no transmission lines, no analytic beam. Two solvers that agree to many digits are each other's check.
//!
//! `table.rs` has the streams of a medium, `layer.rs` a layer from thin to thick, `adding.rs` what layers, planes and the
//! ground are together. A beam is a stream like others, of a weight so small that nothing is scattered into it.

mod adding;
mod algebra;
mod layer;
mod table;

use pulp::{Simd, WithSimd};

use super::discrete_ordinates::plan::{Plan, Planner};
use super::discrete_ordinates::{check_cosine, shares::unscattered};
use super::{Ground, Incidence, Shares, Stack, TransferError};
use crate::lanes::MAX_LANES;
use adding::Total;

/// The solver and its settings.
///
/// ```
/// use mieux_optics::transfer::{AddingDoubling, Incidence, Layer, Moments, Stack};
///
/// let slab = Stack::slab(Layer::new(2.0, 0.9, Moments::henyey_greenstein(0.75)?));
/// let shares = AddingDoubling::default().shares(&slab, Incidence::NORMAL)?;
/// assert!((shares.reflectance - 0.09739464).abs() < 1e-7);
/// # Ok::<(), mieux_optics::transfer::TransferError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AddingDoubling {
    /// Directions in both hemispheres of the densest medium: even, from 2 to 256. (Twice what others call quadrature
    /// points.)
    pub streams: usize,
    /// Whether what the streams cannot resolve of the forward peak counts as not scattered (delta-M, `wiscombe1977`).
    pub cut_peak: bool,
}

impl Default for AddingDoubling {
    fn default() -> Self {
        Self { streams: 32, cut_peak: true }
    }
}

/// Beams along the horizon are followed at this cosine: no share differs by more than some 1e-11.
const GRAZING: f64 = 1e-12;

impl AddingDoubling {
    /// With another number of streams.
    ///
    /// # Errors
    /// [`TransferError::Streams`] unless it is even and from 2 to 256.
    pub fn with_streams(streams: usize) -> Result<Self, TransferError> {
        let solver = Self { streams, ..Self::default() };
        solver.check()?;
        Ok(solver)
    }

    fn check(&self) -> Result<(), TransferError> {
        let streams = self.streams;
        if streams.is_multiple_of(2) && (2..=256).contains(&streams) {
            Ok(())
        } else {
            Err(TransferError::Streams { streams })
        }
    }

    /// Where the light goes that falls onto a stack; emission is left out.
    ///
    /// # Errors
    /// [`TransferError`] for matter or light that cannot be.
    pub fn shares(&self, stack: &Stack, incidence: Incidence) -> Result<Shares, TransferError> {
        let all = self.shares_of(std::slice::from_ref(stack), &[incidence])?;
        all.into_iter().flatten().next().ok_or(TransferError::Streams { streams: self.streams })
    }

    /// The same for many stacks and, in the inner list, many ways of falling in. Stacks of one shape (the same planes at
    /// which the index changes) are solved abreast.
    ///
    /// # Errors
    /// As [`AddingDoubling::shares`].
    pub fn shares_of(&self, stacks: &[Stack], incidences: &[Incidence]) -> Result<Vec<Vec<Shares>>, TransferError> {
        self.check()?;
        stacks.iter().try_for_each(Stack::check)?;
        let mut beams = Vec::new();
        for incidence in incidences {
            if let Incidence::Beam(cosine) = *incidence {
                check_cosine(cosine)?;
                beams.push(cosine.max(GRAZING));
            }
        }
        let mut planner = Planner::new(self.streams, self.cut_peak);
        let plans: Vec<Plan> = stacks.iter().map(|stack| planner.plan(stack)).collect();
        let mut out = Vec::with_capacity(stacks.len());
        let mut first = 0;
        while first < plans.len() {
            let alike = plans[first..].iter().take(MAX_LANES).take_while(|plan| plan.is_like(&plans[first])).count();
            let plans = &plans[first..first + alike];
            let group = Group { plans, beams: &beams, incidences, streams: self.streams };
            out.extend(pulp::Arch::new().dispatch(group)?);
            first += alike;
        }
        Ok(out)
    }
}

/// Plans of one shape, at most [`MAX_LANES`].
struct Group<'a> {
    plans: &'a [Plan<'a>],
    /// Cosines above, of the incidences that are beams, in order.
    beams: &'a [f64],
    incidences: &'a [Incidence],
    streams: usize,
}

impl WithSimd for Group<'_> {
    type Output = Result<Vec<Vec<Shares>>, TransferError>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let mut out = Vec::with_capacity(self.plans.len());
        for plans in self.plans.chunks(S::F64_LANES.min(MAX_LANES)) {
            let lanes: [&Plan; MAX_LANES] = std::array::from_fn(|lane| &plans[lane.min(plans.len() - 1)]);
            let total = Total::of(simd, &lanes, self.beams);
            if let Some(layer) = total.unphysical(plans.len()) {
                return Err(TransferError::NotAPhaseFunction { layer, streams: self.streams });
            }
            let mut found = vec![Vec::with_capacity(self.incidences.len()); plans.len()];
            let mut beam = 0;
            for incidence in self.incidences {
                let flows = match incidence {
                    Incidence::Beam(_) => {
                        beam += 1;
                        total.of_beam(simd, beam - 1)
                    }
                    Incidence::Diffuse => total.of_diffuse(simd, self.beams.len()),
                };
                for (lane, plan) in plans.iter().enumerate() {
                    found[lane].push(shares(plan, *incidence, flows[0][lane], flows[1][lane]));
                }
            }
            out.extend(found);
        }
        Ok(out)
    }
}

fn shares(plan: &Plan, incidence: Incidence, reflectance: f64, transmittance: f64) -> Shares {
    let (specular, reaches_ground) = unscattered(plan, incidence);
    let passes = match plan.stack.ground {
        Ground::Black => 1.0,
        Ground::Lambertian(share) | Ground::Mirror(share) => 1.0 - share,
    };
    Shares {
        reflectance,
        transmittance,
        absorptance: 1.0 - reflectance - transmittance,
        reflectance_specular: specular,
        transmittance_unscattered: reaches_ground * passes,
    }
}

#[cfg(test)]
mod tests;
