//! Media and their phase functions.

use std::rc::Rc;

use super::Importer;
use super::properties::{Properties, Result, numbers, spectrum};
use super::xml::Element;
use crate::grid::read_vol;
use crate::scene::Transform;
use crate::scene::description::{
    BlendWeight, Coefficients, Grid, GridFilter, MediumKind, Optics, Phase, RgbKind, Spectrum,
};

const PHASES: [&str; 5] = ["hg", "isotropic", "rayleigh", "tabphase", "blendphase"];
/// Phase functions of phase functions: not deeper than this.
const MAX_BLENDS: usize = 16;
/// Grids in a scene: each is read where it is named.
const MAX_GRIDS: usize = 64;

/// A quantity in space.
enum Volume {
    Constant(Spectrum),
    Grid(Grid),
}

impl Importer {
    pub(super) fn medium_kind(&mut self, element: &Rc<Element>) -> Result<MediumKind> {
        let p = Properties::of(element)?;
        if !["homogeneous", "heterogeneous"].contains(&p.kind.as_str()) {
            return Err(p.unsupported(&["homogeneous", "heterogeneous"]));
        }
        let albedo = self.volume(&p, "albedo", RgbKind::Reflectance)?;
        let albedo = albedo.unwrap_or(Volume::Constant(Spectrum::Constant(0.75)));
        let extinction = self.volume(&p, "sigma_t", RgbKind::Unbounded)?;
        let extinction = extinction.unwrap_or(Volume::Constant(Spectrum::Constant(1.0)));
        let scale = p.float_in("scale", 1.0, "at least 0", |s| s >= 0.0)?;
        p.ignore(&["sample_emitters", "has_spectral_extinction", "majorant_resolution_factor"]);
        let mut phases = Vec::new();
        for child in p.rest(&["phase", "ref"]) {
            let object = self.object(&child)?;
            if object.tag != "phase" {
                return Err(child.error(format!("a `{}` has no place in a medium", object.tag)));
            }
            phases.push((child, self.phase(&object)?));
        }
        if let [_, (second, _), ..] = phases.as_slice() {
            return Err(second.error("the medium has a phase function already"));
        }
        p.finish()?;
        let phase = phases.pop().map_or(Phase::Isotropic, |(_, phase)| phase);
        let make = |extinction, albedo| Optics {
            coefficients: Coefficients::ExtinctionAlbedo { extinction, albedo },
            scale,
            index: Spectrum::Constant(1.0),
            phase: phase.clone(),
            emission: None,
        };
        Ok(match (extinction, albedo) {
            (Volume::Constant(extinction), Volume::Constant(albedo)) => {
                MediumKind::Homogeneous(make(extinction, albedo))
            }
            (Volume::Grid(density), Volume::Constant(albedo)) => {
                let optics = make(Spectrum::Constant(1.0), albedo);
                MediumKind::Grid { optics, density, albedo: None, emission: None }
            }
            (Volume::Grid(density), Volume::Grid(albedo)) => {
                let optics = make(Spectrum::Constant(1.0), Spectrum::Constant(1.0));
                MediumKind::Grid { optics, density, albedo: Some(albedo), emission: None }
            }
            (Volume::Constant(_), Volume::Grid(_)) => {
                let help = "make `sigma_t` a `gridvolume` too, of one value";
                return Err(element.error("`albedo` is a grid and `sigma_t` is not").with_help(help));
            }
        })
    }

    fn volume(&mut self, p: &Properties, name: &'static str, kind: RgbKind) -> Result<Option<Volume>> {
        let Some(child) = p.child(name).cloned() else { return Ok(None) };
        let object = self.object(&child)?;
        if object.tag != "volume" {
            return Ok(Some(Volume::Constant(spectrum(&object, kind)?)));
        }
        let v = Properties::of(&object)?;
        let volume = match v.kind.as_str() {
            "constvolume" => {
                let value = v.spectrum("value", kind)?.unwrap_or(Spectrum::Constant(1.0));
                v.ignore(&["to_world"]);
                Volume::Constant(value)
            }
            "gridvolume" => Volume::Grid(self.grid(&v)?),
            _ => return Err(v.unsupported(&["constvolume", "gridvolume"])),
        };
        v.finish()?;
        if let (Volume::Grid(grid), RgbKind::Reflectance) = (&volume, kind)
            && let Some(high) = grid.values.iter().find(|&&a| a > 1.0)
        {
            return Err(object.error(format!("an albedo cannot be more than 1, as in the grid here: {high}")));
        }
        Ok(Some(volume))
    }

    fn grid(&mut self, v: &Properties) -> Result<Grid> {
        self.grids += 1;
        if self.grids > MAX_GRIDS {
            return Err(v.element.error(format!("the scene has more than {MAX_GRIDS} grids")));
        }
        let name = v.string("filename")?.ok_or_else(|| v.element.error("a `gridvolume` needs a `filename`"))?;
        let path = self.loader.find(&v.element, &name);
        let named = v.child("filename").unwrap_or(&v.element).clone();
        let mut grid = read_vol(&path).map_err(|e| named.error_at("value", e.to_string()))?;
        let own = grid.to_world;
        let boxed = v.boolean("use_grid_bbox")?.unwrap_or(false);
        let first = if boxed { own } else { Transform::IDENTITY };
        grid.to_world = first.then(&v.transform("to_world")?);
        grid.filter = match v.string("filter_type")?.as_deref() {
            None | Some("trilinear") => GridFilter::Trilinear,
            Some("nearest") => GridFilter::Nearest,
            Some(other) => {
                let message = format!("`filter_type` is `{other}`");
                return Err(v.element.error(message).with_help("one of trilinear, nearest"));
            }
        };
        match v.string("wrap_mode")?.as_deref() {
            None | Some("clamp") => {}
            Some(other) => {
                return Err(v.element.error(format!("the `wrap_mode` `{other}` is not supported; clamp is")));
            }
        }
        v.ignore(&["raw", "accel"]);
        if let Some(low) = grid.values.iter().find(|&&d| d < 0.0) {
            return Err(named.error_at("value", format!("the grid has a negative value: {low}")));
        }
        Ok(grid)
    }

    pub(super) fn phase(&mut self, element: &Rc<Element>) -> Result<Phase> {
        self.phase_at(element, 0)
    }

    fn phase_at(&mut self, element: &Rc<Element>, depth: usize) -> Result<Phase> {
        if depth > MAX_BLENDS {
            return Err(element.error(format!("phase functions are blended more than {MAX_BLENDS} deep")));
        }
        let p = Properties::of(element)?;
        let phase = match p.kind.as_str() {
            "isotropic" => Phase::Isotropic,
            "rayleigh" => Phase::Rayleigh,
            "hg" => Phase::HenyeyGreenstein { g: p.float_in("g", 0.8, "between -1 and 1", |g| g > -1.0 && g < 1.0)? },
            "tabphase" => {
                let child = p.child("values").ok_or_else(|| element.error("`tabphase` needs `values`"))?;
                let values = numbers(child, "value")?;
                let sum: f64 = values.iter().sum();
                if values.len() < 2 || values.iter().any(|&v| v < 0.0) || !(sum > 0.0 && sum.is_finite()) {
                    let message = "a phase function needs two values or more, none negative and not all zero";
                    return Err(child.error_at("value", message));
                }
                let step = 2.0 / (values.len() - 1) as f64;
                let mut cosines: Vec<f64> = (0..values.len()).map(|i| step * i as f64 - 1.0).collect();
                cosines[values.len() - 1] = 1.0;
                Phase::Tabulated { cosines, values }
            }
            "blendphase" => {
                let weight = match self.volume(&p, "weight", RgbKind::Reflectance)? {
                    Some(Volume::Constant(Spectrum::Constant(w))) => BlendWeight::Constant(w),
                    Some(Volume::Grid(grid)) => BlendWeight::Grid(grid),
                    _ => return Err(element.error("`blendphase` needs a `weight`: a number, or a `gridvolume`")),
                };
                let parts = p.rest(&["phase", "ref"]);
                let [a, b] = parts.as_slice() else {
                    let message = format!("`blendphase` has {} phase functions, and should have two", parts.len());
                    return Err(element.error(message));
                };
                let mut part = |child: &Rc<Element>| {
                    let object = self.object(child)?;
                    if object.tag != "phase" {
                        return Err(child.error(format!("a `{}` is no phase function", object.tag)));
                    }
                    self.phase_at(&object, depth + 1).map(Box::new)
                };
                Phase::Blend { weight, a: part(a)?, b: part(b)? }
            }
            _ => return Err(p.unsupported(&PHASES)),
        };
        p.finish()?;
        Ok(phase)
    }
}
