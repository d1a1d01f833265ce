//! The light of one direction that was never scattered: it fades in the layers and is divided by the planes.

use super::super::{Ground, streams::refracted_cosine};
use super::plan::Plan;

/// A beam and all its reflections. Fluxes are onto the horizontal.
#[derive(Debug, Clone)]
pub(in crate::transfer) struct BeamLine {
    /// Of each layer.
    pub layers: Vec<BeamInLayer>,
    /// Goes back above.
    pub reflected: f64,
    /// Reaches the ground, or the half-space below.
    pub on_ground: f64,
}

#[derive(Debug, Clone, Copy)]
pub(in crate::transfer) struct BeamInLayer {
    /// 1 where the beam does not enter.
    pub cosine: f64,
    /// At the top.
    pub down: f64,
    /// At the bottom.
    pub up: f64,
}

/// How thick a layer is to the beam.
pub(in crate::transfer) enum Thickness {
    /// As the sweep has it: the forward peak is not scattered.
    Scaled,
    /// As it is.
    True,
}

impl BeamLine {
    /// Of a beam of the given flux that falls onto the top with the given cosine above.
    pub fn new(plan: &Plan, cosine: f64, flux: f64, thickness: &Thickness) -> Self {
        let above = plan.frame.media[plan.frame.above].index;
        let share = |plane: usize| plan.frame.planes[plane].reflectance(cosine, above);
        let mut layers = Vec::with_capacity(plan.layers.len());
        for (scaled, layer) in plan.layers.iter().zip(&plan.stack.layers) {
            let depth = match thickness {
                Thickness::Scaled => scaled.thickness,
                Thickness::True => layer.optical_thickness,
            };
            let inside = refracted_cosine(cosine, above, plan.frame.media[scaled.medium].index);
            let (cosine, fade) = inside.map_or((1.0, 0.0), |inside| (inside, (-depth / inside).exp()));
            layers.push(BeamInLayer { cosine, down: fade, up: 0.0 });
        }
        // What each plane and all below it send back, from the ground up; `up` keeps it for the layer above.
        let mut beyond = match plan.stack.ground {
            Ground::Mirror(share) => share,
            Ground::Black | Ground::Lambertian(_) => 0.0,
        };
        let mirror = beyond;
        for (j, layer) in layers.iter_mut().enumerate().rev() {
            layer.up = Self::through(share(j + 1), beyond);
            beyond = layer.up * layer.down * layer.down;
        }
        let reflected = flux * Self::through(share(0), beyond);
        // And down: `down` was how much a layer lets through.
        let mut down = flux;
        for (j, layer) in layers.iter_mut().enumerate() {
            let (fade, back) = (layer.down, layer.up);
            let share = share(j);
            down = divided((1.0 - share) * down, 1.0 - share * back * fade * fade);
            (layer.down, layer.up) = (down, down * fade * back);
            down *= fade;
        }
        let last = share(layers.len());
        let on_ground = divided((1.0 - last) * down, 1.0 - last * mirror);
        Self { layers, reflected, on_ground }
    }

    /// What a plane sends back with what lies beyond it.
    fn through(share: f64, beyond: f64) -> f64 {
        share + divided((1.0 - share).powi(2) * beyond, 1.0 - share * beyond)
    }
}

impl BeamInLayer {
    /// Fluxes down and up at a depth in a layer of the given thickness.
    pub fn at(&self, depth: f64, thickness: f64) -> [f64; 2] {
        [self.down * (-depth / self.cosine).exp(), self.up * (-(thickness - depth).max(0.0) / self.cosine).exp()]
    }
}

/// A beam that does not enter a layer between total reflections has nothing to be divided by.
fn divided(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}
