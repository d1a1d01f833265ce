//! Where photons start, and with what.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use mieux_optics::transfer::fresnel::dielectric_reflectance;
use mieux_optics::transfer::{Incidence, Layer, Stack, TransferError};
use rand_core::Rng;
use rand_pcg::Pcg64Mcg;

use super::counts::{Slot, Tally};
use super::photon::{Photon, Slab, refracted};
use super::{SlabWalkError, Source};
use crate::sampler::{Turn, uniform};

/// Pairs of numbers in [0, 1) that fill the square evenly, each pair uniform by itself: a sequence of Hammersley, shifted
/// by a random vector (`cranley1976`).
pub(super) struct Even {
    count: f64,
    shift: [f64; 2],
}

impl Even {
    pub fn new(count: u64, generator: &mut Pcg64Mcg) -> Self {
        Self { count: count as f64, shift: [uniform(generator), uniform(generator)] }
    }

    pub fn pair(&self, index: u64) -> [f64; 2] {
        let mirrored = f64::from((index as u32).reverse_bits()) / 4_294_967_296.0;
        let wrap = |x: f64| (x - x.floor()).min(1.0 - f64::EPSILON);
        [wrap(mirrored + self.shift[0]), wrap(index as f64 / self.count + self.shift[1])]
    }
}

/// The start of photons, ready for use.
pub(super) enum Start {
    /// Down onto the first plane, with this cosine, or any.
    Top(Option<f64>),
    /// In the layers; the power emitted up to the end of each, and at its top and bottom.
    Inside { until: Vec<f64>, ends: Vec<[f64; 2]> },
}

impl Start {
    /// # Errors
    /// [`SlabWalkError::Transfer`] for a cosine out of range, [`SlabWalkError::Dark`] where nothing is emitted.
    pub fn new(source: Source, stack: &Stack) -> Result<Self, SlabWalkError> {
        match source {
            Source::Top(Incidence::Diffuse) => Ok(Self::Top(None)),
            Source::Top(Incidence::Beam(cosine)) if cosine > 0.0 && cosine <= 1.0 => Ok(Self::Top(Some(cosine))),
            Source::Top(Incidence::Beam(value)) => Err(TransferError::Cosine { value }.into()),
            Source::Emission => {
                let until: Vec<f64> = stack
                    .layers
                    .iter()
                    .scan(0.0, |sum, layer| {
                        *sum += emitted(layer);
                        Some(*sum)
                    })
                    .collect();
                if !until.last().is_some_and(|power| *power > 0.0) {
                    return Err(SlabWalkError::Dark);
                }
                Ok(Self::Inside { until, ends: stack.layers.iter().map(|layer| layer.emission).collect() })
            }
        }
    }

    /// Power per area that all photons stand for.
    pub fn power(&self) -> f64 {
        match self {
            Self::Top(_) => 1.0,
            Self::Inside { until, .. } => until.last().copied().unwrap_or(0.0),
        }
    }

    /// A photon in a layer or below all; `None` if it has already gone.
    pub fn photon(
        &self,
        slab: &Slab<'_>,
        even: [f64; 2],
        generator: &mut Pcg64Mcg,
        tally: &mut Tally<'_>,
    ) -> Option<Photon> {
        let flight = -(-even[1]).ln_1p();
        match self {
            Self::Top(beam) => entering(slab, *beam, even[0], flight, generator, tally),
            Self::Inside { until, ends } => Some(emerging(slab, until, ends, even[0], flight, generator)),
        }
    }
}

/// `4 pi n^2 (1 - albedo)` times the mean radiance and the optical thickness.
fn emitted(layer: &Layer) -> f64 {
    let mean = 0.5 * (layer.emission[0] + layer.emission[1]);
    4.0 * PI * layer.refractive_index.powi(2) * (1.0 - layer.albedo) * layer.optical_thickness * mean
}

/// Onto the first plane: what it reflects is counted at once, the rest goes in.
fn entering(
    slab: &Slab<'_>,
    beam: Option<f64>,
    even: f64,
    flight: f64,
    generator: &mut Pcg64Mcg,
    tally: &mut Tally<'_>,
) -> Option<Photon> {
    // Flux from all directions alike falls in with a density of 2 cos.
    let cosine = beam.unwrap_or_else(|| (1.0 - even).sqrt());
    let (x, y) = if beam.is_some() { (1.0, 0.0) } else { Turn::get().angle(generator.next_u64() as u32) };
    let sine = ((1.0 - cosine) * (1.0 + cosine)).sqrt();
    let eta = slab.relative_index(0, 1);
    let reflected = dielectric_reflectance(cosine, eta);
    tally.count(Slot::Up, reflected);
    tally.count(Slot::UpUnscattered, reflected);
    let direction = refracted(DVec3::new(sine * x, sine * y, cosine), eta);
    let photon = Photon {
        medium: 1,
        depth: 0.0,
        aside: DVec2::ZERO,
        direction,
        flight,
        weight: 1.0 - reflected,
        scattered: false,
    };
    (reflected < 1.0).then_some(photon)
}

/// Out of the matter itself, into any direction. The number says which layer, and how deep in it.
fn emerging(
    slab: &Slab<'_>,
    until: &[f64],
    ends: &[[f64; 2]],
    even: f64,
    flight: f64,
    generator: &mut Pcg64Mcg,
) -> Photon {
    let wanted = even * until[until.len() - 1];
    let layer = until.partition_point(|sum| *sum <= wanted).min(until.len() - 1);
    let before = if layer == 0 { 0.0 } else { until[layer - 1] };
    let share = ((wanted - before) / (until[layer] - before)).clamp(0.0, 1.0);
    let [top, bottom] = ends[layer];
    // The depth above which a linear density holds this share.
    let root = (top * top + share * (bottom - top) * (bottom + top)).max(0.0).sqrt();
    let depth = (share * (top + bottom) / (top + root)).min(1.0) * slab.thickness(layer + 1);
    let cosine = 2.0 * uniform(generator) - 1.0;
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let (x, y) = Turn::get().angle(generator.next_u64() as u32);
    let direction = DVec3::new(sine * x, sine * y, cosine);
    Photon { medium: layer + 1, depth, aside: DVec2::ZERO, direction, flight, weight: 1.0, scattered: true }
}
