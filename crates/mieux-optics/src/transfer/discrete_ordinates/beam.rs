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
        let above = plan.media[plan.above].index;
        let paths = plan.layers.iter().zip(&plan.stack.layers).map(|(scaled, layer)| {
            let depth = match thickness {
                Thickness::Scaled => scaled.thickness,
                Thickness::True => layer.optical_thickness,
            };
            let inside = refracted_cosine(cosine, above, plan.media[scaled.medium].index);
            inside.map_or((1.0, 0.0), |inside| (inside, (-depth / inside).exp()))
        });
        let paths: Vec<(f64, f64)> = paths.collect();
        let shares: Vec<f64> = plan.planes.iter().map(|plane| plane.reflectance(cosine, above)).collect();

        // What each plane and all below it send back, from the ground up.
        let mirror = match plan.stack.ground {
            Ground::Mirror(share) => share,
            Ground::Black | Ground::Lambertian(_) => 0.0,
        };
        let mut beyond = vec![mirror; shares.len()];
        for j in (0..shares.len()).rev() {
            let here = shares[j] + divided((1.0 - shares[j]).powi(2) * beyond[j], 1.0 - shares[j] * beyond[j]);
            if j > 0 {
                beyond[j - 1] = here * paths[j - 1].1.powi(2);
            } else {
                return Self::descend(flux, here, &paths, &shares, &beyond);
            }
        }
        Self { layers: Vec::new(), reflected: 0.0, on_ground: flux }
    }

    fn descend(flux: f64, reflectance: f64, paths: &[(f64, f64)], shares: &[f64], beyond: &[f64]) -> Self {
        let mut down = flux;
        let mut layers = Vec::with_capacity(paths.len());
        for (j, (share, beyond)) in shares.iter().zip(beyond).enumerate() {
            down = divided((1.0 - share) * down, 1.0 - share * beyond);
            if let Some(&(cosine, fade)) = paths.get(j) {
                // `beyond` is seen from the top of the layer; what comes up at its bottom faded once less.
                let up = if fade > 0.0 { down * beyond / fade } else { 0.0 };
                layers.push(BeamInLayer { cosine, down, up });
                down *= fade;
            }
        }
        Self { layers, reflected: flux * reflectance, on_ground: down }
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
