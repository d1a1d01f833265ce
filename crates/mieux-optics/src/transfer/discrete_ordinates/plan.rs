//! A stack made ready for the sweep: streams, scaled layers, what each plane reflects.

use super::super::{
    Moments, Stack,
    fresnel::reflectance_of_pair,
    streams::{Stream, Streams, refracted_cosine},
};

/// A stack as the sweep sees it.
#[derive(Debug, Clone)]
pub(in crate::transfer) struct Plan<'a> {
    pub stack: &'a Stack,
    /// The different refractive indices, each with its streams; more streams the greater the index.
    pub media: Vec<Medium>,
    /// Into `media`.
    pub above: usize,
    pub below: usize,
    pub layers: Vec<Scaled>,
    /// Above each layer and below the last.
    pub planes: Vec<Plane>,
}

#[derive(Debug, Clone, PartialEq)]
pub(in crate::transfer) struct Medium {
    pub index: f64,
    pub streams: Vec<Stream>,
}

impl Medium {
    /// How many Legendre functions the streams can tell apart: as many as there are streams in both hemispheres, or fewer
    /// where refraction leaves wider gaps between them than a Gauss rule has.
    fn degrees(&self) -> usize {
        use std::f64::consts::PI;
        let mut angles: Vec<f64> = self.streams.iter().map(|stream| stream.cosine.acos()).collect();
        angles.sort_by(f64::total_cmp);
        let ends = [angles.first().map_or(PI, |a| 2.0 * a), angles.last().map_or(PI, |a| PI - 2.0 * a)];
        let gap = angles.windows(2).map(|pair| pair[1] - pair[0]).chain(ends).fold(0.0, f64::max);
        // In the rule itself the widest gap is up to 2.16 / degrees times pi.
        let resolved = (2.2 * PI / gap) as usize;
        resolved.clamp(2, 2 * self.streams.len())
    }
}

/// A layer whose forward peak counts as light that was not scattered (delta-M; `wiscombe1977`).
#[derive(Debug, Clone)]
pub(in crate::transfer) struct Scaled {
    /// Into [`Plan::media`].
    pub medium: usize,
    pub thickness: f64,
    pub albedo: f64,
    /// `1 - albedo`, with all its digits.
    pub loss: f64,
    /// What is left of the moments, as many as the streams of this medium can tell apart.
    pub moments: Vec<f64>,
    /// Scaled over true optical depth.
    pub stretch: f64,
}

/// What lies between two media.
#[derive(Debug, Clone)]
pub(in crate::transfer) struct Plane {
    /// Indices before and beyond.
    pub indices: [f64; 2],
    /// `2 R / (1 - R)` for the streams that pass it; `None` where nothing changes.
    pub resistance: Option<Vec<f64>>,
}

impl<'a> Plan<'a> {
    /// Of a checked stack.
    pub fn new(stack: &'a Stack, streams: usize, cut_peak: bool) -> Self {
        let nodes = Streams::new(streams, stack);
        let mut media: Vec<Medium> = Vec::new();
        let mut place = |index: f64| {
            let known = media.iter().position(|medium| medium.index == index);
            known.unwrap_or_else(|| {
                media.push(Medium { index, streams: nodes.within(index) });
                media.len() - 1
            })
        };
        let above = place(stack.above);
        let homes: Vec<usize> = stack.layers.iter().map(|layer| place(layer.refractive_index)).collect();
        let below = place(stack.below);
        let layers = stack.layers.iter().zip(&homes).map(|(layer, &medium)| {
            let count = if media.len() == 1 { 2 * media[medium].streams.len() } else { media[medium].degrees() };
            let scaling = Scaling::new(layer.albedo, &layer.moments, count, cut_peak);
            Scaled {
                medium,
                thickness: layer.optical_thickness * scaling.thickness,
                albedo: scaling.albedo,
                loss: scaling.loss,
                moments: scaling.moments,
                stretch: scaling.thickness,
            }
        });
        let layers = layers.collect();
        let path: Vec<usize> = [above].into_iter().chain(homes).chain([below]).collect();
        let planes = path.windows(2).map(|pair| plane(&media[pair[0]], &media[pair[1]])).collect();
        Self { stack, media, above, below, layers, planes }
    }

    /// Whether this can be swept abreast with another: the same planes at which the index changes, and as many streams.
    pub fn is_like(&self, other: &Self) -> bool {
        let counts = |plan: &Self| (plan.above, plan.below, plan.media.len(), plan.layers.len());
        let mut media = self.media.iter().zip(&other.media);
        let mut layers = self.layers.iter().zip(&other.layers);
        counts(self) == counts(other)
            && media.all(|(one, two)| one.streams.len() == two.streams.len())
            && layers.all(|(one, two)| one.medium == two.medium)
    }
}

struct Scaling {
    thickness: f64,
    albedo: f64,
    loss: f64,
    moments: Vec<f64>,
}

impl Scaling {
    fn new(albedo: f64, moments: &Moments, count: usize, cut_peak: bool) -> Self {
        let peak = if cut_peak { moments.get(count) } else { 0.0 };
        let thickness = 1.0 - peak * albedo;
        if peak >= 1.0 || thickness <= 0.0 {
            // Nothing but a forward peak: nothing is scattered.
            return Self { thickness: 1.0 - albedo, albedo: 0.0, loss: 1.0, moments: vec![1.0] };
        }
        Self {
            thickness,
            albedo: albedo * (1.0 - peak) / thickness,
            loss: (1.0 - albedo) / thickness,
            moments: (0..count).map(|degree| (moments.get(degree) - peak) / (1.0 - peak)).collect(),
        }
    }
}

fn plane(before: &Medium, beyond: &Medium) -> Plane {
    let indices = [before.index, beyond.index];
    if before.index == beyond.index {
        return Plane { indices, resistance: None };
    }
    let eta = beyond.index / before.index;
    let pairs = before.streams.iter().zip(&beyond.streams);
    let resistance = pairs.map(|(here, there)| {
        let share = reflectance_of_pair(here.cosine, there.cosine, eta);
        2.0 * share / (1.0 - share)
    });
    Plane { indices, resistance: Some(resistance.collect()) }
}

impl Plane {
    /// The share reflected of light with this cosine in the medium of index `from`, whichever side that is on or
    /// whether it is on neither.
    pub fn reflectance(&self, cosine: f64, from: f64) -> f64 {
        let [before, beyond] = self.indices;
        if before == beyond {
            return 0.0;
        }
        match (refracted_cosine(cosine, from, before), refracted_cosine(cosine, from, beyond)) {
            (Some(here), Some(there)) => reflectance_of_pair(here, there, beyond / before),
            _ => 1.0,
        }
    }
}
