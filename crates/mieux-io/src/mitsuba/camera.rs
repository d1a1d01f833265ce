//! The camera with its film and sampler.

use std::rc::Rc;

use super::Importer;
use super::properties::{Properties, Result};
use super::xml::Element;
use crate::scene::Transform;
use crate::scene::description::{Camera, FovAxis, ReconstructionFilter};

/// Largest width or height of a picture.
const MAX_SIZE: i64 = 65_536;
/// Most pixels of a picture.
const MAX_PIXELS: i64 = 1 << 28;
/// Millimetres of film from corner to corner, for focal lengths: that of 36 by 24.
const FILM_DIAGONAL: f64 = 43.266_615_305_567_87;

pub(super) fn none() -> Camera {
    Camera {
        to_world: Transform::IDENTITY,
        fov: 2.0 * (FILM_DIAGONAL / 100.0).atan(),
        fov_axis: FovAxis::Diagonal,
        principal_point: [0.0; 2],
        size: [768, 576],
        crop: None,
        filter: ReconstructionFilter::Gaussian { stddev: 0.5 },
        clip: Some([0.01, 1e4]),
        medium: None,
        spp: Some(4),
        seed: None,
        max_depth: None,
    }
}

impl Importer {
    pub(super) fn camera(&mut self, element: &Rc<Element>) -> Result<()> {
        let p = Properties::of(element)?;
        if p.kind != "perspective" {
            return Err(p.unsupported(&["perspective"]));
        }
        let mut camera = none();
        camera.to_world = p.transform("to_world")?;
        if p.child("fov").is_some() {
            let degrees = p.float_in("fov", 0.0, "between 0 and 180 degrees", |f| f > 0.0 && f < 180.0)?;
            camera.fov = degrees.to_radians();
            camera.fov_axis = FovAxis::X;
        } else if let Some(text) = p.string("focal_length")? {
            let millimetres = text.strip_suffix("mm").unwrap_or(&text).trim().parse::<f64>().ok();
            let millimetres = millimetres.filter(|f| f.is_finite() && *f > 0.0);
            let wrong = || element.error(format!("`focal_length` is `{text}`, and should be such as `50mm`"));
            camera.fov = 2.0 * (FILM_DIAGONAL / (2.0 * millimetres.ok_or_else(wrong)?)).atan();
        }
        if let Some(axis) = p.string("fov_axis")? {
            camera.fov_axis = match axis.as_str() {
                "x" => FovAxis::X,
                "y" => FovAxis::Y,
                "smaller" => FovAxis::Smaller,
                "larger" => FovAxis::Larger,
                "diagonal" => FovAxis::Diagonal,
                _ => {
                    let error = element.error(format!("`fov_axis` is `{axis}`"));
                    return Err(error.with_help("one of x, y, smaller, larger, diagonal"));
                }
            };
        }
        let distance = |d: f64| d > 0.0;
        let near = p.float_in("near_clip", 0.01, "more than 0", distance)?;
        camera.clip = Some([near, p.float_in("far_clip", 1e4, "more than `near_clip`", |f| f > near)?]);
        // Mitsuba shifts the film, and so the axis the other way, as rays of its version 3.9.1 show.
        let offset = |name: &'static str| -> Result<f64> { Ok(0.0 - p.float(name)?.unwrap_or(0.0)) };
        camera.principal_point = [offset("principal_point_offset_x")?, offset("principal_point_offset_y")?];
        p.ignore(&["shutter_open", "shutter_close"]);
        camera.medium = self.medium_child(&p)?;
        for film in p.rest(&["film"]) {
            Self::film(&film, &mut camera)?;
        }
        for sampler in p.rest(&["sampler"]) {
            Self::sampler(&sampler, &mut camera)?;
        }
        p.finish()?;
        self.out.camera = camera;
        Ok(())
    }

    /// The medium that something is in: a child with or without the name `medium`.
    pub(super) fn medium_child(&mut self, p: &Properties) -> Result<Option<usize>> {
        if let Some(found) = self.medium_of(p, "medium")? {
            return Ok(Some(found));
        }
        let rest = p.rest(&["medium", "ref"]);
        let tag = &p.element.tag;
        if let Some(second) = rest.get(1) {
            return Err(second.error(format!("the {tag} is in a medium already")));
        }
        let Some(child) = rest.first() else { return Ok(None) };
        let object = self.object(child)?;
        if object.tag != "medium" {
            return Err(child.error(format!("a `{}` has no place in a {tag}", object.tag)));
        }
        self.medium(&object).map(Some)
    }

    fn film(element: &Rc<Element>, camera: &mut Camera) -> Result<()> {
        let p = Properties::of(element)?;
        if !["hdrfilm", "specfilm"].contains(&p.kind.as_str()) {
            return Err(p.unsupported(&["hdrfilm"]));
        }
        let whole = |name: &'static str, default: i64, low: i64| -> Result<i64> {
            let value = p.integer(name)?.unwrap_or(default);
            if (low..=MAX_SIZE).contains(&value) {
                return Ok(value);
            }
            let message = format!("`{name}` is {value}, and should be between {low} and {MAX_SIZE}");
            Err(p.child(name).unwrap_or(element).error_at("value", message))
        };
        let (width, height) = (whole("width", 768, 1)?, whole("height", 576, 1)?);
        if width * height > MAX_PIXELS {
            return Err(element.error(format!("{width} by {height} is more than {MAX_PIXELS} pixels")));
        }
        let (x, y) = (whole("crop_offset_x", 0, 0)?, whole("crop_offset_y", 0, 0)?);
        let (w, h) = (whole("crop_width", width, 1)?, whole("crop_height", height, 1)?);
        if x + w > width || y + h > height {
            return Err(element.error(format!("the crop {w}x{h} at {x}, {y} reaches beyond {width}x{height}")));
        }
        camera.size = [width as u32, height as u32];
        if (x, y, w, h) != (0, 0, width, height) {
            camera.crop = Some([x as u32, y as u32, w as u32, h as u32]);
        }
        p.ignore(&["pixel_format", "component_format", "file_format", "banner", "sample_border", "compensate"]);
        p.ignore(&["high_quality_edges"]);
        for filter in p.rest(&["rfilter"]) {
            camera.filter = Self::filter(&filter)?;
        }
        p.finish()
    }

    fn filter(element: &Rc<Element>) -> Result<ReconstructionFilter> {
        let p = Properties::of(element)?;
        let positive = |v: f64| v > 0.0 && v <= 64.0;
        let filter = match p.kind.as_str() {
            "box" => ReconstructionFilter::Box,
            "tent" => ReconstructionFilter::Tent { radius: p.float_in("radius", 1.0, "between 0 and 64", positive)? },
            "gaussian" => {
                ReconstructionFilter::Gaussian { stddev: p.float_in("stddev", 0.5, "between 0 and 64", positive)? }
            }
            "mitchell" => {
                let third = 1.0 / 3.0;
                let finite = |v: f64| v.is_finite();
                let (b, c) = (p.float_in("B", third, "", finite)?, p.float_in("C", third, "", finite)?);
                ReconstructionFilter::Mitchell { b, c }
            }
            "catmullrom" => ReconstructionFilter::CatmullRom,
            "lanczos" => {
                let lobes = p.integer("lobes")?.unwrap_or(3);
                if !(1..=64).contains(&lobes) {
                    return Err(element.error(format!("`lobes` is {lobes}, and should be between 1 and 64")));
                }
                ReconstructionFilter::Lanczos { lobes: lobes as u32 }
            }
            _ => return Err(p.unsupported(&["box", "tent", "gaussian", "mitchell", "catmullrom", "lanczos"])),
        };
        p.finish()?;
        Ok(filter)
    }

    fn sampler(element: &Rc<Element>, camera: &mut Camera) -> Result<()> {
        let p = Properties::of(element)?;
        let known = ["independent", "stratified", "multijitter", "orthogonal", "ldsampler"];
        if !known.contains(&p.kind.as_str()) {
            return Err(p.unsupported(&known));
        }
        let count = p.integer("sample_count")?.unwrap_or(4);
        let count = u32::try_from(count).ok().filter(|&c| c > 0);
        camera.spp = Some(count.ok_or_else(|| element.error("`sample_count` should be at least 1"))?);
        camera.seed = p.integer("seed")?.map(|s| s as u64);
        p.ignore(&["jitter", "strength"]);
        p.finish()
    }
}
