//! A beam and all its reflections: what the planes divide and the layers leave.

use super::super::super::fresnel::dielectric_reflectance;
use super::divided;

/// A beam of flux 1 on the horizontal.
pub(super) struct Line {
    pub layers: Vec<InLayer>,
    /// Goes back above.
    pub reflected: f64,
    /// Falls onto the ground.
    pub on_ground: f64,
}

/// Fluxes on the horizontal.
#[derive(Debug, Clone, Copy)]
pub(super) struct InLayer {
    /// 1 where the beam does not enter.
    pub cosine: f64,
    /// At the top.
    pub down: f64,
    /// At the bottom.
    pub up: f64,
}

/// From the first of the indices into the last, through layers of the given optical thicknesses between them, onto a mirror
/// that reflects the given share.
pub(super) fn line(indices: &[f64], thickness: &[f64], cosine: f64, mirror: f64) -> Line {
    let planes = thickness.len() + 1;
    let sine2 = (1.0 - cosine) * (1.0 + cosine);
    let inner = |n: f64| {
        let ratio = indices[0] / n;
        if ratio == 1.0 {
            return cosine;
        }
        (1.0 - ratio * ratio * sine2).max(0.0).sqrt()
    };
    let cosines: Vec<f64> = indices.iter().map(|&n| inner(n)).collect();
    let shares: Vec<f64> =
        (0..planes).map(|j| dielectric_reflectance(cosines[j], indices[j + 1] / indices[j])).collect();
    let fades: Vec<f64> =
        thickness.iter().zip(&cosines[1..]).map(|(t, c)| if *c > 0.0 { (-t / c).exp() } else { 0.0 }).collect();

    // What each plane and all below it send back, from the ground up; and what comes from beyond it alone.
    let (mut here, mut beyond) = (vec![0.0; planes], vec![mirror; planes]);
    for j in (0..planes).rev() {
        here[j] = shares[j] + divided((1.0 - shares[j]).powi(2) * beyond[j], 1.0 - shares[j] * beyond[j]);
        if j > 0 {
            beyond[j - 1] = here[j] * fades[j - 1] * fades[j - 1];
        }
    }
    let mut down = 1.0;
    let mut layers = Vec::with_capacity(thickness.len());
    for j in 0..planes {
        down = divided((1.0 - shares[j]) * down, 1.0 - shares[j] * beyond[j]);
        if j < thickness.len() {
            let cosine = if cosines[j + 1] > 0.0 { cosines[j + 1] } else { 1.0 };
            layers.push(InLayer { cosine, down, up: down * fades[j] * here[j + 1] });
            down *= fades[j];
        }
    }
    Line { layers, reflected: here[0], on_ground: down }
}
