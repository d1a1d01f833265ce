//! Light scattered once, and light emitted, on its way into a direction: known without any streams, with all moments of
//! the phase function.

use std::f64::consts::PI;

use pulp::Simd;

use super::beam::BeamLine;
use super::depth::{crossing, fading};
use super::drivers::twice_emitted;
use super::gathered::rising;
use super::plan::Plan;
use super::ray::{Ray, Segment};
use crate::lanes::{LaneArray, MAX_LANES, Re, step};

/// How strongly each layer scatters the beam into each ray, for each azimuth.
pub(super) struct FirstOrder<'a> {
    plan: &'a Plan<'a>,
    beam: Option<&'a BeamLine>,
    /// By layer, ray and azimuth: from a direction into that of the same sign, and of the other sign; per scaled optical
    /// depth and steradian.
    phases: Vec<Vec<[f64; 2]>>,
    azimuths: usize,
}

impl<'a> FirstOrder<'a> {
    /// With `exact`, all moments count (the first of the two corrections of `nakajima1988`); without, those that the
    /// streams know.
    #[inline(always)]
    pub fn new<S: Simd>(
        simd: S,
        plan: &'a Plan<'a>,
        beam: Option<&'a BeamLine>,
        rays: &[Ray],
        azimuths: &[f64],
        exact: bool,
    ) -> Self {
        let mut phases: Vec<Vec<[f64; 2]>> = Vec::with_capacity(plan.layers.len());
        for (layer, scaled) in plan.layers.iter().enumerate() {
            let Some(beam) = beam.filter(|_| scaled.albedo > 0.0) else {
                phases.push(Vec::new());
                continue;
            };
            let moments = &plan.stack.layers[layer].moments;
            // Layers of one phase function and index differ in their albedo alone.
            let alike = (0..layer).find(|other| {
                !phases[*other].is_empty()
                    && plan.layers[*other].medium == scaled.medium
                    && plan.stack.layers[*other].moments == *moments
            });
            let albedo = |layer: usize| {
                if exact {
                    plan.stack.layers[layer].albedo / plan.layers[layer].stretch
                } else {
                    plan.layers[layer].albedo
                }
            };
            if let Some(other) = alike {
                let ratio = albedo(layer) / albedo(other);
                phases.push(phases[other].iter().map(|pair| pair.map(|value| value * ratio)).collect());
                continue;
            }
            let degrees = if exact { moments.as_slice().len() } else { scaled.degrees };
            let moment = |degree| if exact { moments.get(degree) } else { scaled.moment(degree) };
            let scale = albedo(layer) / (4.0 * PI);
            let strengths: Vec<f64> =
                (0..degrees).map(|degree| scale * (2 * degree + 1) as f64 * moment(degree)).collect();
            let cosines = scattering_cosines(rays, layer, beam.layers[layer].cosine, azimuths);
            let values = legendre_series(simd, &strengths, &cosines);
            phases.push(values.chunks(2).map(|pair| [pair[0], pair[1]]).collect());
        }
        Self { plan, beam, phases, azimuths: azimuths.len() }
    }

    /// What a ray gathers in a part of a layer (from scaled depth `top` on).
    pub fn gather(&self, layer: usize, (ray, cosine): (usize, f64), azimuth: usize, top: f64, t: f64) -> Segment {
        let scaled = &self.plan.layers[layer];
        let lambda = 1.0 / cosine;
        let mut segment = Segment { fade: (-lambda * t).exp(), ..Segment::default() };
        if let (Some(beam), Some([same, other])) =
            (self.beam, self.phases[layer].get(ray * self.azimuths + azimuth).copied())
        {
            let beam = &beam.layers[layer];
            let nu = 1.0 / beam.cosine;
            let [down, up] = [beam.at(top, scaled.thickness)[0], beam.at(top + t, scaled.thickness)[1]];
            let (along, against) = (fading(nu + lambda, t), crossing(nu, lambda, t));
            let index = self.plan.frame.media[scaled.medium].index;
            let scale = lambda * nu / (index * index);
            segment.up = scale * (other * down * along + same * up * against);
            segment.down = scale * (same * down * against + other * up * along);
        }
        if self.plan.stack.layers[layer].emission != [0.0; 2] {
            let [from, slope] = twice_emitted(self.plan, layer).map(|value| 0.5 * value * lambda);
            let (flat, rising) = (fading(lambda, t), rising(lambda, t));
            segment.up += (from + slope * top) * flat + slope * rising;
            segment.down += (from + slope * (top + t)) * flat - slope * rising;
        }
        segment
    }
}

/// For each ray and azimuth, from the beam down into the ray down (or both up), and into the other.
fn scattering_cosines(rays: &[Ray], layer: usize, beam: f64, azimuths: &[f64]) -> Vec<f64> {
    let mut cosines = Vec::with_capacity(2 * rays.len() * azimuths.len());
    for ray in rays {
        let cosine = ray.cosines[layer].unwrap_or(1.0);
        for same in same_side_cosines(cosine, beam, azimuths) {
            cosines.extend([same, (same - 2.0 * cosine * beam).clamp(-1.0, 1.0)]);
        }
    }
    cosines
}

/// For each azimuth, the cosine between a beam and a ray on the same side of the horizontal.
pub(super) fn same_side_cosines(cosine: f64, beam: f64, azimuths: &[f64]) -> Vec<f64> {
    let across = ((1.0 - cosine * cosine) * (1.0 - beam * beam)).max(0.0).sqrt();
    azimuths.iter().map(|azimuth| (across * azimuth.cos() + cosine * beam).clamp(-1.0, 1.0)).collect()
}

/// Vectors of cosines summed at a time, so that no step waits for the one before.
const ABREAST: usize = 4;

/// `sum_l strengths_l P_l` at every cosine.
#[inline(always)]
pub(super) fn legendre_series<S: Simd>(simd: S, strengths: &[f64], cosines: &[f64]) -> Vec<f64> {
    step(
        simd,
        #[inline(always)]
        || sum_of_legendre(simd, strengths, cosines),
    )
}

#[inline(always)]
fn sum_of_legendre<S: Simd>(simd: S, strengths: &[f64], cosines: &[f64]) -> Vec<f64> {
    let (zero, one) = (Re::splat(simd, 0.0), Re::splat(simd, 1.0));
    let mut out = Vec::with_capacity(cosines.len());
    for group in cosines.chunks(ABREAST * S::F64_LANES) {
        let (mut x, mut before, mut here, mut sum) =
            ([zero; ABREAST], [zero; ABREAST], [one; ABREAST], [zero; ABREAST]);
        for (x, chunk) in x.iter_mut().zip(group.chunks(S::F64_LANES)) {
            let mut lanes: LaneArray = [0.0; MAX_LANES];
            lanes[..chunk.len()].copy_from_slice(chunk);
            *x = Re::load(simd, &lanes);
        }
        for (l, strength) in strengths.iter().enumerate() {
            let strength = Re::splat(simd, *strength);
            // P_{l+1} = P_l x + (P_l x - P_{l-1}) l / (l + 1)
            let ratio = Re::splat(simd, l as f64 / (l + 1) as f64);
            for q in 0..ABREAST {
                sum[q] = strength.mul_add(here[q], sum[q]);
                let product = here[q] * x[q];
                let next = ratio.mul_add(product - before[q], product);
                before[q] = here[q];
                here[q] = next;
            }
        }
        for (sum, chunk) in sum.iter().zip(group.chunks(S::F64_LANES)) {
            out.extend_from_slice(&sum.lanes()[..chunk.len()]);
        }
    }
    out
}
