//! Spectra as files say them, laid out over the rendered wavelengths.

use mieux_io::scene::description::{Outside, RgbKind, Spectrum};
use mieux_optics::spectrum::upsample::reflectance_of;
use mieux_optics::spectrum::{Sampled, WavelengthGrid};
use mieux_render::light::relative_d65;

use super::{JobError, RANGE, flat};

/// What a spectrum is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Light: nothing beyond what is known.
    Light,
    /// A property of matter.
    Matter,
}

/// Step of what is computed, m.
const STEP: f64 = 5e-9;
/// Where what ends falls to nothing, m: less than is drawn between two wavelengths.
const EDGE: f64 = 1e-12;

/// A spectrum over all rendered wavelengths.
pub(super) fn sampled(spectrum: &Spectrum, kind: Kind) -> Result<Sampled, JobError> {
    match spectrum {
        Spectrum::Constant(value) => flat(*value),
        Spectrum::Sampled { nodes, outside } => from_nodes(nodes, *outside),
        Spectrum::Rgb { rgb, kind: of } => from_rgb(*rgb, *of, kind),
        Spectrum::Blackbody { temperature, scale } => computed(|w| scale * planck(w, *temperature)),
        Spectrum::D65 { scale } => {
            let d65 = relative_d65();
            computed(|w| scale * d65.at(w).unwrap_or(0.0))
        }
    }
}

fn computed(f: impl Fn(f64) -> f64) -> Result<Sampled, JobError> {
    let grid = WavelengthGrid::regular(RANGE.0, RANGE.1, STEP)?;
    let values = grid.iter().map(f).collect();
    Ok(Sampled::new(grid, values)?)
}

fn from_nodes(nodes: &[(f64, f64)], outside: Outside) -> Result<Sampled, JobError> {
    let (Some(first), Some(last)) = (nodes.first(), nodes.last()) else { return flat(0.0) };
    let (mut all, beyond) = (nodes.to_vec(), |v: f64| if outside == Outside::Nearest { v } else { 0.0 });
    if first.0 > RANGE.0 {
        let edge = (first.0 - EDGE, beyond(first.1));
        let start = (RANGE.0 * (1.0 - 1e-9)).min(edge.0 - EDGE);
        all.splice(0..0, [(start, edge.1), edge]);
    }
    if last.0 < RANGE.1 {
        let edge = (last.0 + EDGE, beyond(last.1));
        all.extend([edge, ((RANGE.1 * (1.0 + 1e-9)).max(edge.0 + EDGE), edge.1)]);
    }
    let (wavelengths, values) = all.into_iter().unzip();
    Ok(Sampled::new(WavelengthGrid::new(wavelengths)?, values)?)
}

fn from_rgb(rgb: [f64; 3], of: RgbKind, kind: Kind) -> Result<Sampled, JobError> {
    if of == RgbKind::Reflectance {
        return Ok(reflectance_of(rgb));
    }
    // In the middle of what a reflectance can be, colours are smoothest.
    let scale = 2.0 * rgb.iter().fold(0f64, |m, v| m.max(*v));
    if scale <= 0.0 || scale.is_nan() {
        return flat(0.0);
    }
    let shape = reflectance_of(rgb.map(|v| v / scale));
    let d65 = relative_d65();
    let lit = of == RgbKind::Illuminant || kind == Kind::Light;
    computed(|w| scale * shape.at(w).unwrap_or(0.0) * if lit { d65.at(w).unwrap_or(0.0) } else { 1.0 })
}

/// Planck's radiance, W/(m² sr) per nanometre, at a wavelength (m) and a temperature (K).
fn planck(wavelength: f64, temperature: f64) -> f64 {
    const H: f64 = 6.626_070_15e-34;
    const C: f64 = 299_792_458.0;
    const K: f64 = 1.380_649e-23;
    let exponent = H * C / (wavelength * K * temperature);
    2.0 * H * C * C / wavelength.powi(5) / exponent.exp_m1() * 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_ends_ends() {
        let nodes = vec![(500e-9, 2.0), (600e-9, 4.0)];
        let light = sampled(&Spectrum::Sampled { nodes: nodes.clone(), outside: Outside::Zero }, Kind::Light).unwrap();
        assert_eq!(light.at(450e-9), Some(0.0));
        assert!((light.at(550e-9).unwrap() - 3.0).abs() < 1e-9);
        let index = sampled(&Spectrum::Sampled { nodes, outside: Outside::Nearest }, Kind::Matter).unwrap();
        assert!((index.at(380e-9).unwrap() - 2.0).abs() < 1e-9 && (index.at(780e-9).unwrap() - 4.0).abs() < 1e-9);
        // The sun's surface is brightest in the green.
        assert!(planck(500e-9, 5772.0) > planck(400e-9, 5772.0) && planck(500e-9, 5772.0) > planck(700e-9, 5772.0));
    }
}
