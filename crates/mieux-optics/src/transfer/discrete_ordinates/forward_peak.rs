//! Light that the forward peak has scattered more than once.
//!
//! The streams count the peak as not scattered (delta-M). First scattering with all moments then puts back the peak of light
//! that was scattered in it once; but the beam it starts from still holds what was scattered in it before, so that `n`
//! scatterings spread the light as one would, `n` times over. `nakajima1988` mend this for `n = 2`. Within so narrow a cone
//! all paths are alike, and then all orders together are known: `n` scatterings raise each moment to the power `n`, and
//! their sum is an exponential (the small-angle solution of `goudsmit1940`).

use std::f64::consts::PI;

use pulp::Simd;

use super::beam::BeamLine;
use super::depth::crossing;
use super::first_order::{legendre_series, same_side_cosines};
use super::plan::Plan;
use super::ray::Ray;

/// How far light of first order has to be mended: basic radiance downward, by layer, bound and azimuth.
pub(super) type Mending = Vec<Vec<Vec<f64>>>;

/// Fewer scatterings in the peak than this are as good as none.
const NEGLIGIBLE: f64 = 1e-10;

/// What the light of a ray has met since the last refracting plane.
struct Run<'a> {
    medium: usize,
    /// Radiance scattered by the peak in first order, before it is spread.
    strength: f64,
    /// Mean numbers of scatterings in the peaks of layers, with the peaks.
    met: Vec<(f64, Peak<'a>)>,
}

/// The part of a phase function that counts as not scattered.
#[derive(Clone, Copy)]
struct Peak<'a> {
    moments: &'a [f64],
    /// Below this degree the peak's moments are 1.
    from: usize,
    /// Its share of the phase function.
    share: f64,
}

impl Peak<'_> {
    fn moment(&self, degree: usize) -> f64 {
        if degree < self.from { 1.0 } else { self.moments.get(degree).map_or(0.0, |chi| chi / self.share) }
    }
}

/// For one ray; `bounds` are scaled depths in each layer.
#[inline(always)]
pub(super) fn mending<S: Simd>(
    simd: S,
    plan: &Plan,
    beam: &BeamLine,
    ray: &Ray,
    bounds: &[Vec<f64>],
    azimuths: &[f64],
) -> Mending {
    let mut run = Run { medium: usize::MAX, strength: 0.0, met: Vec::new() };
    let mut all = Vec::with_capacity(bounds.len());
    for (number, bounds) in bounds.iter().enumerate() {
        let layer = &plan.layers[number];
        let original = &plan.stack.layers[number];
        let Some(cosine) = ray.cosines[number] else {
            all.push(vec![Vec::new(); bounds.len()]);
            continue;
        };
        if layer.medium != run.medium {
            run = Run { medium: layer.medium, strength: 0.0, met: Vec::new() };
        }
        let from = layer.degrees;
        let peak = Peak { moments: original.moments.as_slice(), from, share: original.moments.get(from) };
        // Scattered in the peak per scaled optical depth.
        let rate = original.albedo * peak.share.max(0.0) / layer.stretch;
        let (nu, lambda) = (1.0 / beam.layers[number].cosine, 1.0 / cosine);
        let index = plan.frame.media[layer.medium].index;
        let cosines = same_side_cosines(cosine, beam.layers[number].cosine, azimuths);
        let mut found = vec![run.spread(simd, &cosines)];
        if layer.albedo > 0.0 {
            run.met.push((0.0, peak));
        }
        for pair in bounds.windows(2) {
            let (top, t) = (pair[0], pair[1] - pair[0]);
            let [down, _] = beam.layers[number].at(top, layer.thickness);
            let gained = rate * lambda * nu / (index * index) * down * crossing(nu, lambda, t);
            run.strength = run.strength * (-lambda * t).exp() + gained;
            if let Some((count, _)) = run.met.last_mut().filter(|_| layer.albedo > 0.0) {
                *count += rate * t * 0.5 * (nu + lambda);
            }
            found.push(run.spread(simd, &cosines));
        }
        all.push(found);
    }
    all
}

impl Run<'_> {
    /// What is to be added at these scattering cosines; nothing, if there was hardly a scattering in the peak.
    #[inline(always)]
    fn spread<S: Simd>(&self, simd: S, cosines: &[f64]) -> Vec<f64> {
        let total: f64 = self.met.iter().map(|(count, _)| count).sum();
        if total < NEGLIGIBLE || self.strength == 0.0 {
            return Vec::new();
        }
        let degrees = self.met.iter().map(|(_, peak)| peak.moments.len().max(peak.from)).max().unwrap_or(0);
        let scale = self.strength / (4.0 * PI);
        let mut series = Vec::with_capacity(degrees);
        for degree in 0..degrees {
            let mean = self.met.iter().map(|(count, peak)| count * peak.moment(degree)).sum::<f64>() / total;
            // (exp(-X (1 - p)) - exp(-X)) / X, of which p is the first term.
            let all = (-total * (1.0 - mean)).exp() * -(-total * mean).exp_m1() / total;
            series.push(scale * (2 * degree + 1) as f64 * (all - mean));
        }
        legendre_series(simd, &series, cosines)
    }
}
