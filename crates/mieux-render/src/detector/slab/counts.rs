//! What has been counted, and how well it is known.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

/// A mean over all photons.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Estimate {
    /// The mean.
    pub value: f64,
    /// Its standard error, from the differences between batches; with it, squares added, the share of one photon, as no
    /// less can be seen (where none came the batches do not differ); and what was lost. Infinite for one batch.
    pub error: f64,
}

/// Radiance that leaves in bins of direction, for an irradiance of 1 on the horizontal (or 1 of power emitted per
/// area), in the half-space it leaves into. Light that was never scattered is left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Radiance {
    bins: [usize; 2],
    values: Vec<Estimate>,
}

impl Radiance {
    /// In a bin: cosines from `cosine / n` to `(cosine + 1) / n` of the n bins, against the normal; azimuths around
    /// `360 azimuth / m` degrees, that of the beam's way being 0. `None` outside. 1/sr.
    pub fn at(&self, cosine: usize, azimuth: usize) -> Option<Estimate> {
        let [cosines, azimuths] = self.bins;
        (cosine < cosines && azimuth < azimuths).then(|| self.values[cosine * azimuths + azimuth])
    }
}

/// Where the photons went, as shares of what fell onto the top (or was emitted).
#[derive(Debug, Clone, PartialEq)]
pub struct SlabCounts {
    /// Photons sent.
    pub photons: u64,
    /// Times they were scattered in layers.
    pub collisions: u64,
    /// All that left upward, the surface's own reflection included.
    pub reflectance: Estimate,
    /// All that passed the last plane and stayed below.
    pub transmittance: Estimate,
    /// All that stayed in the layers.
    pub absorptance: Estimate,
    /// What stayed in each layer, from the top down.
    pub absorptance_of_layers: Vec<Estimate>,
    /// The part of the reflectance that was never scattered.
    pub reflectance_specular: Estimate,
    /// The part of the transmittance that was never scattered, neither inside nor by the ground.
    pub transmittance_unscattered: Estimate,
    /// Reflectance, transmittance, absorptance and loss together: 1 within its error, which comes from the roulette.
    pub balance: Estimate,
    /// Carried by photons that were given up; they may have gone anywhere, so every error holds it.
    pub lost: f64,
    /// Power emitted per area, in the unit of the emission times sr; 1 for light from above.
    pub power: f64,
    /// The light that left upward, if bins were asked for.
    pub radiance_up: Option<Radiance>,
    /// The light that passed the last plane downward, before the ground takes or returns it.
    pub radiance_down: Option<Radiance>,
}

/// What a batch counts: how many layers and bins.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    pub layers: usize,
    pub bins: Option<[usize; 2]>,
}

impl Layout {
    fn bin_count(self) -> usize {
        self.bins.map_or(0, |[cosines, azimuths]| cosines * azimuths)
    }
}

/// Where weight can go, before the layers and the bins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Slot {
    Up,
    Down,
    UpUnscattered,
    DownUnscattered,
    Lost,
    /// What the batch has in all; filled in at its end.
    Balance,
    Absorbed,
}

const SLOTS: usize = Slot::Absorbed as usize + 1;

/// The sums of one batch.
#[derive(Debug, Clone)]
pub(super) struct Tally {
    layout: Layout,
    /// Slots, layers, bins of the light that goes up, and down.
    sums: Vec<f64>,
    pub collisions: u64,
}

impl Tally {
    pub fn new(layout: Layout) -> Self {
        Self { layout, sums: vec![0.0; SLOTS + layout.layers + 2 * layout.bin_count()], collisions: 0 }
    }

    pub fn count(&mut self, slot: Slot, weight: f64) {
        self.sums[slot as usize] += weight;
    }

    pub fn absorb(&mut self, layer: usize, weight: f64) {
        self.sums[SLOTS + layer] += weight;
    }

    /// Scattered light that leaves in a direction, up or down.
    pub fn leave(&mut self, direction: DVec3, weight: f64) {
        let Some([cosines, azimuths]) = self.layout.bins else { return };
        let cosine = ((direction.z.abs() * cosines as f64) as usize).min(cosines - 1);
        let turn = direction.y.atan2(direction.x) / TAU;
        let azimuth = (turn * azimuths as f64).round().rem_euclid(azimuths as f64) as usize % azimuths;
        let side = if direction.z > 0.0 { self.layout.bin_count() } else { 0 };
        self.sums[SLOTS + self.layout.layers + side + cosine * azimuths + azimuth] += weight;
    }

    /// The sums, with those that follow from others.
    fn closed(&self) -> Vec<f64> {
        let mut sums = self.sums.clone();
        let absorbed: f64 = sums[SLOTS..SLOTS + self.layout.layers].iter().sum();
        sums[Slot::Absorbed as usize] = absorbed;
        let [up, down, lost] = [Slot::Up, Slot::Down, Slot::Lost].map(|slot| sums[slot as usize]);
        sums[Slot::Balance as usize] = up + down + lost + absorbed;
        sums
    }
}

/// The sums of all batches and of their squared deviations.
#[derive(Debug)]
pub(super) struct Totals {
    layout: Layout,
    batches: u64,
    mean: Vec<f64>,
    deviation: Vec<f64>,
    collisions: u64,
}

impl Totals {
    pub fn new(layout: Layout) -> Self {
        let zeros = Tally::new(layout).sums;
        Self { layout, batches: 0, mean: zeros.clone(), deviation: zeros, collisions: 0 }
    }

    /// One batch more; mean and deviation are carried on as they are, which keeps their digits (`welford1962`).
    pub fn add(&mut self, tally: &Tally) {
        self.batches += 1;
        self.collisions += tally.collisions;
        let count = self.batches as f64;
        for ((mean, deviation), sum) in self.mean.iter_mut().zip(&mut self.deviation).zip(tally.closed()) {
            let before = sum - *mean;
            *mean += before / count;
            *deviation += before * (sum - *mean);
        }
    }

    /// Batches of `size` photons, of `power` together.
    pub fn counts(&self, size: u64, power: f64) -> SlabCounts {
        let lost = self.mean[Slot::Lost as usize] / size as f64;
        let slot = |slot: Slot| self.estimate(slot as usize, 1.0 / size as f64, lost);
        SlabCounts {
            photons: self.batches * size,
            collisions: self.collisions,
            reflectance: slot(Slot::Up),
            transmittance: slot(Slot::Down),
            absorptance: slot(Slot::Absorbed),
            absorptance_of_layers: (0..self.layout.layers)
                .map(|layer| self.estimate(SLOTS + layer, 1.0 / size as f64, lost))
                .collect(),
            reflectance_specular: slot(Slot::UpUnscattered),
            transmittance_unscattered: slot(Slot::DownUnscattered),
            balance: Estimate {
                value: self.mean[Slot::Balance as usize] / size as f64,
                error: self.deviation_of_mean(Slot::Balance as usize) / size as f64,
            },
            lost,
            power,
            radiance_up: self.radiance(0, size, lost),
            radiance_down: self.radiance(1, size, lost),
        }
    }

    fn estimate(&self, place: usize, scale: f64, lost: f64) -> Estimate {
        // One photon among all batches.
        let least = 1.0 / self.batches as f64;
        let error = self.deviation_of_mean(place).hypot(least) * scale + lost;
        Estimate { value: self.mean[place] * scale, error }
    }

    fn deviation_of_mean(&self, place: usize) -> f64 {
        let count = self.batches as f64;
        if self.batches < 2 {
            return f64::INFINITY;
        }
        (self.deviation[place] / (count * (count - 1.0))).max(0.0).sqrt()
    }

    fn radiance(&self, side: usize, size: u64, lost: f64) -> Option<Radiance> {
        let [cosines, azimuths] = self.layout.bins?;
        let first = SLOTS + self.layout.layers + side * self.layout.bin_count();
        let values = (0..cosines * azimuths).map(|bin| {
            let cosine = ((bin / azimuths) as f64 + 0.5) / cosines as f64;
            // The integral of the cosine over the bin's solid angle.
            let projected = cosine * 2.0 * PI / (cosines * azimuths) as f64;
            self.estimate(first + bin, 1.0 / (size as f64 * projected), lost)
        });
        Some(Radiance { bins: [cosines, azimuths], values: values.collect() })
    }
}
