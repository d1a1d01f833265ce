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

/// Light that leaves in rings around where a pencil beam falls in, for a power of 1 that falls in. Light that was never
/// scattered is left out.
#[derive(Debug, Clone, PartialEq)]
pub struct RadialCounts {
    edges: Vec<f64>,
    /// Per area of each ring.
    values: Vec<Estimate>,
    /// What left beyond the last ring.
    pub beyond: Estimate,
}

impl RadialCounts {
    /// Inner and outer radius of each ring, m, and the power that left there per area, 1/m^2.
    pub fn rings(&self) -> impl Iterator<Item = ([f64; 2], Estimate)> + '_ {
        self.edges.windows(2).map(|ends| [ends[0], ends[1]]).zip(self.values.iter().copied())
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
    /// Where light left upward, if rings were asked for.
    pub radial_up: Option<RadialCounts>,
    /// Where light passed the last plane downward, before the ground takes or returns it.
    pub radial_down: Option<RadialCounts>,
}

/// What a batch counts: how many layers and bins, and rings between which radii.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout<'a> {
    pub layers: usize,
    pub bins: Option<[usize; 2]>,
    /// Radii of the edges, m; none without rings.
    pub edges: &'a [f64],
}

impl Layout<'_> {
    fn bin_count(self) -> usize {
        self.bins.map_or(0, |[cosines, azimuths]| cosines * azimuths)
    }

    /// As many as edges: within the first there may be a hole, beyond the last is all the rest.
    fn first_ring(self, up: bool) -> usize {
        SLOTS + self.layers + 2 * self.bin_count() + if up { 0 } else { self.edges.len() }
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
pub(super) struct Tally<'a> {
    layout: Layout<'a>,
    /// Slots, layers, bins of the light that goes up, and down; rings of the light that goes up, and down.
    sums: Vec<f64>,
    pub collisions: u64,
}

impl<'a> Tally<'a> {
    pub fn new(layout: Layout<'a>) -> Self {
        let places = layout.first_ring(false) + layout.edges.len();
        Self { layout, sums: vec![0.0; places], collisions: 0 }
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

    /// Scattered light that leaves at a distance (m) from where it fell in, up or down.
    pub fn place(&mut self, distance: f64, up: bool, weight: f64) {
        let edges = self.layout.edges;
        // Within a hole nothing is counted.
        if let Some(ring) = edges.partition_point(|edge| *edge <= distance).checked_sub(1) {
            self.sums[self.layout.first_ring(up) + ring] += weight;
        }
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
pub(super) struct Totals<'a> {
    layout: Layout<'a>,
    batches: u64,
    mean: Vec<f64>,
    deviation: Vec<f64>,
    collisions: u64,
}

impl<'a> Totals<'a> {
    pub fn new(layout: Layout<'a>) -> Self {
        let zeros = Tally::new(layout).sums;
        Self { layout, batches: 0, mean: zeros.clone(), deviation: zeros, collisions: 0 }
    }

    /// One batch more; mean and deviation are carried on as they are, which keeps their digits (`welford1962`).
    pub fn add(&mut self, tally: &Tally<'_>) {
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
            radial_up: self.radial(true, size, lost),
            radial_down: self.radial(false, size, lost),
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

    fn radial(&self, up: bool, size: u64, lost: f64) -> Option<RadialCounts> {
        let (edges, first) = (self.layout.edges, self.layout.first_ring(up));
        let last = edges.len().checked_sub(1)?;
        let ring = |ring: usize| {
            let area = PI * (edges[ring + 1] - edges[ring]) * (edges[ring + 1] + edges[ring]);
            self.estimate(first + ring, 1.0 / (size as f64 * area), lost / area)
        };
        Some(RadialCounts {
            edges: edges.to_vec(),
            values: (0..last).map(ring).collect(),
            beyond: self.estimate(first + last, 1.0 / size as f64, lost),
        })
    }
}
