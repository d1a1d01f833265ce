//! Light followed along one direction through all layers, when all that it gathers on its way is known.

use super::plan::Plan;
use crate::transfer::streams::refracted_cosine;

/// A direction, up and down, as refraction carries it through a stack.
#[derive(Debug, Clone)]
pub(super) struct Ray {
    /// In each layer; `None` where it is totally reflected.
    pub cosines: Vec<Option<f64>>,
    /// What each plane reflects of it.
    planes: Vec<f64>,
    enters: bool,
    leaves: bool,
}

/// What happens to a ray in a part of a layer.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Segment {
    /// The share that is left at the other end.
    pub fade: f64,
    /// What it has gathered downward at the bottom, and upward at the top.
    pub down: f64,
    pub up: f64,
}

/// What a ray meets at the ends of the stack; basic radiances.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Ends {
    /// Falls in from above.
    pub above: f64,
    /// Rises from the ground, or the half-space below.
    pub below: f64,
    /// The share that the ground reflects like a mirror.
    pub mirror: f64,
}

/// Basic radiances, down and up.
pub(super) type Pair = [f64; 2];

/// A ray at every height.
#[derive(Debug, Clone, Default)]
pub(super) struct Followed {
    pub above: Pair,
    /// Of each layer, at the bottom of each segment.
    pub cuts: Vec<Vec<Pair>>,
    pub below: Pair,
}

/// What comes up from below for what goes down: `share` of it, and `own`.
#[derive(Debug, Clone, Copy)]
struct Answer {
    share: f64,
    own: f64,
}

impl Ray {
    /// Of the direction that has this cosine in a medium of this index.
    pub fn new(plan: &Plan, cosine: f64, index: f64) -> Self {
        let inside = |medium: usize| refracted_cosine(cosine, index, plan.frame.media[medium].index);
        Self {
            cosines: plan.layers.iter().map(|layer| inside(layer.medium)).collect(),
            planes: plan.frame.planes.iter().map(|plane| plane.reflectance(cosine, index)).collect(),
            enters: inside(plan.frame.above).is_some(),
            leaves: inside(plan.frame.below).is_some(),
        }
    }

    /// `segments` by layer, from the top.
    pub fn follow(&self, segments: &[Vec<Segment>], ends: Ends) -> Followed {
        let below = if self.leaves { ends.below } else { 0.0 };
        let mut answer = Answer { share: ends.mirror, own: below };
        // From the ground up: what answers beyond each plane, and beyond each segment.
        let mut beyond_planes = Vec::with_capacity(self.planes.len());
        let mut beyond_segments = Vec::with_capacity(segments.len());
        for (j, reflected) in self.planes.iter().enumerate().rev() {
            beyond_planes.push(answer);
            answer = answer.through_plane(*reflected);
            if j > 0 {
                let mut beyond = Vec::with_capacity(segments[j - 1].len());
                for segment in segments[j - 1].iter().rev() {
                    beyond.push(answer);
                    answer = answer.through(segment);
                }
                beyond_segments.push(beyond);
            }
        }
        // And back down.
        let mut down = if self.enters { ends.above } else { 0.0 };
        let mut found = Followed { above: [down, answer.to(down)], ..Followed::default() };
        for (j, reflected) in self.planes.iter().enumerate() {
            let beyond = beyond_planes[self.planes.len() - 1 - j];
            down = divided((1.0 - reflected) * down + reflected * beyond.own, 1.0 - reflected * beyond.share);
            found.below = [down, beyond.to(down)];
            let Some(layer) = segments.get(j) else { break };
            let answers = beyond_segments[segments.len() - 1 - j].iter().rev();
            let mut cuts = Vec::with_capacity(layer.len());
            for (segment, beyond) in layer.iter().zip(answers) {
                down = segment.fade * down + segment.down;
                cuts.push([down, beyond.to(down)]);
            }
            found.cuts.push(cuts);
        }
        found
    }
}

impl Answer {
    fn to(self, down: f64) -> f64 {
        self.share * down + self.own
    }

    fn through(self, segment: &Segment) -> Self {
        let Segment { fade, down, up } = *segment;
        Self { share: fade * fade * self.share, own: fade * self.to(down) + up }
    }

    fn through_plane(self, reflected: f64) -> Self {
        if reflected == 0.0 {
            return self;
        }
        let (passed, left) = (1.0 - reflected, 1.0 - reflected * self.share);
        Self { share: reflected + divided(passed * passed * self.share, left), own: divided(passed * self.own, left) }
    }
}

/// Light between total reflections that nothing feeds has nothing to be divided by.
fn divided(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}
