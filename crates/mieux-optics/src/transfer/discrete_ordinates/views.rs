//! Where and whither radiance is asked for, and the answer.

use pulp::Simd;

use super::plan::Plan;
use crate::lanes::Re;
use crate::transfer::{Stack, TransferError};

/// A height in a stack.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// Just above the first plane, in the medium above.
    Above,
    /// At this optical depth from the top, in a layer. A depth between two layers belongs to the lower one; 0 is just
    /// below the first plane, the depth of the whole stack just above the last.
    Depth(f64),
    /// Just below the last plane, before the ground.
    Below,
}

/// The directions and heights at which radiance is asked for: all combinations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Views<'a> {
    /// Where.
    pub places: &'a [Place],
    /// Cosines of the directions in which the light travels, against the downward normal, in the medium of the place: in
    /// (0, 1] downward, in [-1, 0) upward.
    pub cosines: &'a [f64],
    /// The directions' azimuths from that in which the beam travels, rad.
    pub azimuths: &'a [f64],
}

/// Radiances, in the unit of the light per steradian. The beam itself and its mirror images, which come from single
/// directions, are left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Radiances {
    pub(super) values: Vec<f64>,
    pub(super) cosines: usize,
    pub(super) azimuths: usize,
}

impl Radiances {
    /// At the place, the cosine and the azimuth of these numbers in the lists of [`Views`]; `None` beyond their ends.
    pub fn get(&self, place: usize, cosine: usize, azimuth: usize) -> Option<f64> {
        let inside = cosine < self.cosines && azimuth < self.azimuths;
        inside.then(|| self.values.get((place * self.cosines + cosine) * self.azimuths + azimuth).copied())?
    }

    /// All, the azimuth changing fastest, then the cosine, then the place.
    pub fn as_slice(&self) -> &[f64] {
        &self.values
    }
}

impl Views<'_> {
    pub(super) fn check(&self) -> Result<(), TransferError> {
        if let Some(&value) = self.cosines.iter().find(|c| !(c.abs() > 0.0 && c.abs() <= 1.0)) {
            return Err(TransferError::Cosine { value });
        }
        match self.azimuths.iter().find(|a| !a.is_finite()) {
            Some(&value) => Err(TransferError::Azimuth { value }),
            None => Ok(()),
        }
    }
}

/// A depth found in its layer.
#[derive(Debug, Clone, Copy)]
struct Inside {
    layer: usize,
    /// From the top of the layer.
    depth: f64,
}

impl Inside {
    /// A depth at a plane belongs to the layer below, that of the bottom to the last.
    fn find(stack: &Stack, depth: f64) -> Result<Self, TransferError> {
        let last = stack.layers.len().saturating_sub(1);
        let mut rest = depth;
        if depth >= 0.0 {
            for (layer, thickness) in stack.layers.iter().map(|layer| layer.optical_thickness).enumerate() {
                // What is left after subtracting the layers above carries their rounding.
                let slack = 1e-12 * depth;
                if rest < thickness || (layer == last && rest <= thickness + slack) {
                    return Ok(Self { layer, depth: rest.min(thickness) });
                }
                rest -= thickness;
            }
        }
        Err(TransferError::Depth { layer: last, value: depth })
    }
}

/// The depths at which layers are cut.
pub(super) struct Cuts {
    /// By layer, ascending, from its top.
    pub depths: Vec<Vec<f64>>,
    /// The layer of each depth asked for, and its number among the cuts there; `None` for what is no depth.
    pub asked: Vec<Option<(usize, usize)>>,
}

impl Cuts {
    /// A cut for every depth asked for; the same twice is one.
    pub fn new(stack: &Stack, asked: impl IntoIterator<Item = Option<f64>>) -> Result<Self, TransferError> {
        let mut found = Vec::new();
        let mut depths = vec![Vec::new(); stack.layers.len()];
        for depth in asked {
            let inside = depth.map(|depth| Inside::find(stack, depth)).transpose()?;
            if let Some(inside) = inside {
                depths[inside.layer].push(inside.depth);
            }
            found.push(inside);
        }
        for depths in &mut depths {
            depths.sort_by(f64::total_cmp);
            depths.dedup();
        }
        let number = |inside: &Inside| depths[inside.layer].partition_point(|depth| *depth < inside.depth);
        let asked = found.iter().map(|inside| inside.as_ref().map(|inside| (inside.layer, number(inside)))).collect();
        Ok(Self { depths, asked })
    }

    /// The cuts of each layer in scaled depth, the same in every lane.
    #[inline(always)]
    pub fn scaled<S: Simd>(&self, simd: S, plan: &Plan) -> Vec<Vec<Re<S>>> {
        let mut cuts = Vec::with_capacity(self.depths.len());
        for (depths, layer) in self.depths.iter().zip(&plan.layers) {
            let mut scaled = Vec::with_capacity(depths.len());
            for depth in depths {
                scaled.push(Re::splat(simd, depth * layer.stretch));
            }
            cuts.push(scaled);
        }
        cuts
    }
}
