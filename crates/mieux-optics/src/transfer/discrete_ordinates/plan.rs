//! A stack made ready for the sweep: streams, scaled layers, what each plane reflects.

use std::rc::Rc;

use super::super::{
    Layer, Moments, Stack,
    fresnel::reflectance_of_pair,
    streams::{Stream, Streams, greatest_index, refracted_cosine},
};

/// A stack as the sweep sees it.
#[derive(Debug, Clone)]
pub(in crate::transfer) struct Plan<'a> {
    pub stack: &'a Stack,
    pub frame: Rc<Frame>,
    pub layers: Vec<Scaled<'a>>,
}

/// What of a plan follows from the number of streams, the refractive indices, and which layers are active.
#[derive(Debug)]
pub(in crate::transfer) struct Frame {
    /// The different refractive indices, each with its streams; more streams the greater the index.
    pub media: Vec<Medium>,
    /// Into `media`.
    pub above: usize,
    pub below: usize,
    /// Of each layer, into `media`.
    homes: Vec<usize>,
    /// Above each layer and below the last.
    pub planes: Vec<Plane>,
    /// The greatest index with streams of its own.
    greatest: f64,
}

#[derive(Debug, Clone, PartialEq)]
pub(in crate::transfer) struct Medium {
    pub index: f64,
    pub streams: Vec<Stream>,
    /// How many Legendre functions the streams can tell apart.
    degrees: usize,
}

/// How many Legendre functions streams under refraction can tell apart: as many as there are in both hemispheres, or fewer where
/// refraction leaves wider gaps between them than a Gauss rule has.
fn resolved_degrees(streams: &[Stream]) -> usize {
    use std::f64::consts::PI;
    let mut angles: Vec<f64> = streams.iter().map(|stream| stream.cosine.acos()).collect();
    angles.sort_by(f64::total_cmp);
    let ends = [angles.first().map_or(PI, |a| 2.0 * a), angles.last().map_or(PI, |a| PI - 2.0 * a)];
    let gap = angles.windows(2).map(|pair| pair[1] - pair[0]).chain(ends).fold(0.0, f64::max);
    // In the rule itself the widest gap is up to 2.16 / degrees times pi.
    let resolved = (2.2 * PI / gap) as usize;
    resolved.clamp(2, 2 * streams.len())
}

/// A layer whose forward peak counts as light that was not scattered (delta-M; `wiscombe1977`).
#[derive(Debug, Clone)]
pub(in crate::transfer) struct Scaled<'a> {
    /// Into [`Frame::media`].
    pub medium: usize,
    pub thickness: f64,
    pub albedo: f64,
    /// `1 - albedo`, with all its digits.
    pub loss: f64,
    /// Scaled over true optical depth.
    pub stretch: f64,
    /// How many moments count: as many as the streams of this medium can tell apart.
    pub degrees: usize,
    /// All there are, and what of each is the peak's.
    moments: &'a Moments,
    peak: f64,
}

/// What lies between two media.
#[derive(Debug, Clone)]
pub(in crate::transfer) struct Plane {
    /// Indices before and beyond.
    pub indices: [f64; 2],
    /// `2 R / (1 - R)` for the streams that pass it; `None` where nothing changes.
    pub resistance: Option<Vec<f64>>,
}

impl Frame {
    /// Of a checked stack.
    pub fn new(streams: usize, stack: &Stack) -> Self {
        let nodes = Streams::new(streams, stack);
        let outside = [stack.above, stack.below];
        let one_index =
            stack.layers.iter().map(|layer| layer.refractive_index).chain(outside).all(|n| n == stack.above);
        let mut media: Vec<Medium> = Vec::new();
        let mut place = |index: f64| {
            let known = media.iter().position(|medium| medium.index == index);
            known.unwrap_or_else(|| {
                let streams = nodes.within(index);
                let degrees = if one_index { 2 * streams.len() } else { resolved_degrees(&streams) };
                media.push(Medium { index, streams, degrees });
                media.len() - 1
            })
        };
        let above = place(stack.above);
        let homes: Vec<usize> = stack.layers.iter().map(|layer| place(layer.refractive_index)).collect();
        let below = place(stack.below);
        let path: Vec<usize> = [above].into_iter().chain(homes.iter().copied()).chain([below]).collect();
        let planes = path.windows(2).map(|pair| plane(&media[pair[0]], &media[pair[1]])).collect();
        Self { media, above, below, homes, planes, greatest: greatest_index(stack) }
    }

    /// Whether it is also that of another stack, for the same number of streams.
    fn fits(&self, stack: &Stack) -> bool {
        let index = |medium: usize| self.media[medium].index;
        let mut layers = self.homes.iter().zip(&stack.layers);
        self.homes.len() == stack.layers.len()
            && [index(self.above), index(self.below)] == [stack.above, stack.below]
            && layers.all(|(home, layer)| index(*home) == layer.refractive_index)
            && self.greatest == greatest_index(stack)
    }
}

/// Makes plans. Those of stacks that follow each other with the same planes share their frame.
pub(in crate::transfer) struct Planner {
    streams: usize,
    cut_peak: bool,
    last: Option<Rc<Frame>>,
}

impl Planner {
    pub fn new(streams: usize, cut_peak: bool) -> Self {
        Self { streams, cut_peak, last: None }
    }

    /// Of a checked stack.
    pub fn plan<'a>(&mut self, stack: &'a Stack) -> Plan<'a> {
        let known = self.last.take().filter(|frame| frame.fits(stack));
        let frame = known.unwrap_or_else(|| Rc::new(Frame::new(self.streams, stack)));
        self.last = Some(Rc::clone(&frame));
        let layers = stack.layers.iter().zip(&frame.homes);
        let layers = layers.map(|(layer, &medium)| Scaled::new(layer, medium, &frame.media[medium], self.cut_peak));
        Plan { stack, layers: layers.collect(), frame }
    }
}

impl<'a> Plan<'a> {
    /// Of a checked stack.
    pub fn new(stack: &'a Stack, streams: usize, cut_peak: bool) -> Self {
        Planner::new(streams, cut_peak).plan(stack)
    }

    /// Whether this can be swept abreast with another: the same planes at which the index changes, and as many streams.
    pub fn is_like(&self, other: &Self) -> bool {
        let (one, two) = (&*self.frame, &*other.frame);
        let mut media = one.media.iter().zip(&two.media);
        std::ptr::eq(one, two)
            || (one.above, one.below, &one.homes, one.media.len())
                == (two.above, two.below, &two.homes, two.media.len())
                && media.all(|(one, two)| one.streams.len() == two.streams.len())
    }

    /// Whether it has the media of a frame, and so their tables.
    pub fn shares_media(&self, frame: &Rc<Frame>) -> bool {
        Rc::ptr_eq(&self.frame, frame) || self.frame.media == frame.media
    }
}

impl<'a> Scaled<'a> {
    fn new(layer: &'a Layer, medium: usize, streams: &Medium, cut_peak: bool) -> Self {
        let Layer { optical_thickness, albedo, ref moments, .. } = *layer;
        let degrees = streams.degrees;
        let peak = if cut_peak { moments.get(degrees) } else { 0.0 };
        let stretch = 1.0 - peak * albedo;
        if peak >= 1.0 || stretch <= 0.0 {
            // Nothing but a forward peak: nothing is scattered.
            let stretch = 1.0 - albedo;
            let thickness = optical_thickness * stretch;
            return Self { medium, thickness, albedo: 0.0, loss: 1.0, stretch, degrees: 1, moments, peak: 0.0 };
        }
        Self {
            medium,
            thickness: optical_thickness * stretch,
            albedo: albedo * (1.0 - peak) / stretch,
            loss: (1.0 - albedo) / stretch,
            stretch,
            degrees,
            moments,
            peak,
        }
    }

    /// What is left of the moment of a degree; 0 for those that do not count.
    #[inline]
    pub fn moment(&self, degree: usize) -> f64 {
        if degree < self.degrees { (self.moments.get(degree) - self.peak) / (1.0 - self.peak) } else { 0.0 }
    }

    /// `albedo (2 l + 1) chi_l`.
    #[inline]
    pub fn strength(&self, degree: usize) -> f64 {
        self.albedo * (2 * degree + 1) as f64 * self.moment(degree)
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
