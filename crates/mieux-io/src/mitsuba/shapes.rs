//! Shapes, what their surfaces do, and lights.

use std::path::Path;
use std::rc::Rc;

use super::Importer;
use super::properties::{Properties, Result};
use super::xml::Element;
use crate::mesh::{TriangleMesh, read_mesh};
use crate::scene::description::{EnvironmentImage, Finish, Geometry, Light, RgbKind, Shape, Spectrum};
use crate::scene::transform::normalise;

/// Refractive indices of visible light that go by name.
const INDICES: [(&str, f64); 23] = [
    ("vacuum", 1.0),
    ("helium", 1.000_036),
    ("hydrogen", 1.000_132),
    ("air", 1.000_277),
    ("carbon dioxide", 1.000_45),
    ("water", 1.333),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("carbon tetrachloride", 1.461),
    ("glycerol", 1.4729),
    ("benzene", 1.501),
    ("silicone oil", 1.52045),
    ("bromine", 1.661),
    ("water ice", 1.31),
    ("fused quartz", 1.458),
    ("pyrex", 1.47),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("bk7", 1.5046),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.575),
    ("diamond", 2.419),
];
const SHAPES: [&str; 7] = ["obj", "ply", "sphere", "rectangle", "disk", "cube", "cylinder"];
const FINISHES: [&str; 7] =
    ["diffuse", "conductor", "dielectric", "thindielectric", "roughdielectric", "null", "twosided"];
const LIGHTS: [&str; 5] = ["constant", "envmap", "point", "spot", "directional"];

impl Importer {
    pub(super) fn shape(&mut self, element: &Rc<Element>) -> Result<()> {
        let p = Properties::of(element)?;
        let to_world = p.transform("to_world")?;
        let mut flip_normals = p.boolean("flip_normals")?.unwrap_or(false);
        let mut open = None;
        let geometry = match p.kind.as_str() {
            "obj" | "ply" => {
                let (mesh, hole) = self.mesh(&p)?;
                open = hole;
                Geometry::Mesh(mesh)
            }
            "sphere" => Geometry::Sphere {
                centre: p.vector("center")?.unwrap_or([0.0; 3]),
                radius: p.float_in("radius", 1.0, "more than 0", |r| r > 0.0)?,
            },
            "rectangle" => Geometry::Rectangle,
            "disk" => Geometry::Disk,
            "cube" => Geometry::Cube,
            "cylinder" => Geometry::Cylinder {
                from: p.vector("p0")?.unwrap_or([0.0; 3]),
                to: p.vector("p1")?.unwrap_or([0.0, 0.0, 1.0]),
                radius: p.float_in("radius", 1.0, "more than 0", |r| r > 0.0)?,
            },
            _ => return Err(p.unsupported(&SHAPES)),
        };
        // A mirrored frame turns triangles over, which normals of the file's own would not show.
        if matches!(&geometry, Geometry::Mesh(_)) && to_world.determinant() < 0.0 {
            flip_normals = !flip_normals;
        }
        let interior = self.medium_of(&p, "interior")?;
        let exterior = self.medium_of(&p, "exterior")?;
        let mut finish = None;
        let mut emission = None;
        for child in p.rest(&["bsdf", "emitter", "ref"]) {
            let object = self.object(&child)?;
            match object.tag.as_str() {
                "bsdf" if finish.is_none() => finish = Some(self.finish(&object)?),
                "emitter" if emission.is_none() => emission = Some(Self::area(&object)?),
                "bsdf" | "emitter" => return Err(child.error(format!("the shape has a `{}` already", object.tag))),
                tag => return Err(child.error(format!("a `{tag}` has no place in a shape"))),
            }
        }
        p.finish()?;
        let name = match element.get("id") {
            Some(id) => id.to_owned(),
            None => format!("{} {}", p.kind, self.out.shapes.len() + 1),
        };
        if let (Some(edges), Some(_)) = (open, interior) {
            let message = format!(
                "the mesh `{name}` has a medium inside but is not closed: {edges} of its edges are open, shared by more than two triangles, or between triangles that face opposite ways"
            );
            return Err(element.error(message).with_help("close the surface, or take the medium out"));
        }
        let grey = Finish::Diffuse { reflectance: Spectrum::Constant(0.5), two_sided: false };
        self.out.shapes.push(Shape {
            name,
            geometry,
            to_world,
            flip_normals,
            finish: finish.unwrap_or(grey),
            interior,
            exterior,
            changes_medium: interior.is_some() || exterior.is_some(),
            emission,
            priority: None,
            place: p.place(),
        });
        Ok(())
    }

    /// A mesh, and how many of its edges keep it from being closed.
    fn mesh(&mut self, p: &Properties) -> Result<(TriangleMesh, Option<usize>)> {
        let name = p.string("filename")?;
        let name = name.ok_or_else(|| p.element.error(format!("the shape `{}` needs a `filename`", p.kind)))?;
        p.ignore(&["flip_tex_coords"]);
        let flat = p.boolean("face_normals")?.unwrap_or(false);
        let path = self.loader.find(&p.element, &name);
        let named = p.child("filename").unwrap_or(&p.element).clone();
        let ends = path.extension().is_some_and(|e| e.eq_ignore_ascii_case(&p.kind));
        if !ends {
            return Err(named.error_at("value", format!("the name of an {} file should end in .{}", p.kind, p.kind)));
        }
        let (mut mesh, report) = read_mesh(&path).map_err(|e| named.error_at("value", e.to_string()))?;
        if flat {
            mesh.normals = None;
        }
        if report.flat > 0 {
            self.out.notes.push(format!("`{name}`: {} triangles without area were left out", report.flat));
        }
        if report.lost_normals > 0 {
            let lost = report.lost_normals;
            self.out.notes.push(format!("`{name}`: its normals are not used, since {lost} have no direction"));
        }
        let t = report.topology;
        let open = (!t.is_closed()).then_some(t.boundary_edges + t.crowded_edges + t.turned_edges);
        Ok((mesh, open))
    }

    pub(super) fn finish(&self, element: &Rc<Element>) -> Result<Finish> {
        let p = Properties::of(element)?;
        let smooth = |p: &Properties| -> Result<()> {
            for name in ["specular_reflectance", "specular_transmittance"] {
                match p.spectrum(name, RgbKind::Reflectance)? {
                    None | Some(Spectrum::Constant(1.0) | Spectrum::Rgb { rgb: [1.0, 1.0, 1.0], .. }) => {}
                    Some(_) => {
                        let child = p.child(name).unwrap_or(&p.element);
                        let help = "1 is; tinted surfaces do not keep to the laws of reflection";
                        return Err(child.error(format!("`{name}` is not supported")).with_help(help));
                    }
                }
            }
            Ok(())
        };
        let finish = match p.kind.as_str() {
            "diffuse" => {
                let reflectance = p.spectrum("reflectance", RgbKind::Reflectance)?;
                Finish::Diffuse { reflectance: reflectance.unwrap_or(Spectrum::Constant(0.5)), two_sided: false }
            }
            "null" => Finish::Null,
            "conductor" => {
                smooth(&p)?;
                let (n, k) = Self::metal(&p)?;
                Finish::Conductor { n, k, roughness: 0.0, two_sided: false }
            }
            "dielectric" | "roughdielectric" => {
                smooth(&p)?;
                let roughness = if p.kind == "dielectric" { 0.0 } else { Self::alpha(&p)? };
                let interior = Some(Spectrum::Constant(Self::index(&p, "int_ior", 1.5046)?));
                let exterior = Some(Spectrum::Constant(Self::index(&p, "ext_ior", 1.000_277)?));
                Finish::Dielectric { interior, exterior, roughness }
            }
            "thindielectric" => {
                smooth(&p)?;
                let n = Self::index(&p, "int_ior", 1.5046)? / Self::index(&p, "ext_ior", 1.000_277)?;
                Finish::ThinDielectric { n: Spectrum::Constant(n) }
            }
            "twosided" => self.two_sided(&p)?,
            _ => return Err(p.unsupported(&FINISHES)),
        };
        p.finish()?;
        Ok(finish)
    }

    fn two_sided(&self, p: &Properties) -> Result<Finish> {
        let inner = p.rest(&["bsdf", "ref"]);
        let [inner] = inner.as_slice() else {
            let message = format!("`twosided` has {} surfaces, and should have one", inner.len());
            return Err(p.element.error(message));
        };
        let object = self.object(inner)?;
        if object.tag != "bsdf" || object.get("type") == Some("twosided") {
            return Err(inner.error("inside `twosided` should be a `bsdf` of one side"));
        }
        match self.finish(&object)? {
            Finish::Diffuse { reflectance, .. } => Ok(Finish::Diffuse { reflectance, two_sided: true }),
            Finish::Conductor { n, k, roughness, .. } => Ok(Finish::Conductor { n, k, roughness, two_sided: true }),
            _ => Err(inner.error("light passes through this surface, which has two sides as it is")),
        }
    }

    fn alpha(p: &Properties) -> Result<f64> {
        let distribution = p.string("distribution")?.unwrap_or_else(|| "beckmann".into());
        if distribution != "ggx" {
            let at = p.child("distribution").unwrap_or(&p.element);
            let message = format!("microfacets distributed by `{distribution}` are not supported");
            return Err(at.error(message).with_help("add <string name=\"distribution\" value=\"ggx\"/>"));
        }
        p.ignore(&["sample_visible"]);
        p.float_in("alpha", 0.1, "between 0 and 1", |a| a > 0.0 && a <= 1.0)
    }

    fn index(p: &Properties, name: &'static str, default: f64) -> Result<f64> {
        match p.child(name).cloned() {
            Some(child) if child.tag == "string" => {
                let value = p.string(name)?.unwrap_or_default();
                let known = INDICES.iter().find(|(n, _)| *n == value.to_lowercase());
                let names: Vec<_> = INDICES.iter().map(|(n, _)| *n).collect();
                let unknown = || {
                    let error = child.error_at("value", format!("no refractive index goes by the name `{value}`"));
                    error.with_help(format!("a number, or one of {}", names.join(", ")))
                };
                Ok(known.ok_or_else(unknown)?.1)
            }
            _ => p.float_in(name, default, "more than 0", |n| n > 0.0),
        }
    }

    fn metal(p: &Properties) -> Result<(Spectrum, Spectrum)> {
        let material = p.string("material")?;
        let (eta, k) = (p.spectrum("eta", RgbKind::Unbounded)?, p.spectrum("k", RgbKind::Unbounded)?);
        match (material.as_deref(), eta, k) {
            (None, Some(n), Some(k)) => Ok((n, k)),
            (None | Some("none"), None, None) => Ok((Spectrum::Constant(0.0), Spectrum::Constant(1.0))),
            (None, _, _) => Err(p.element.error("a `conductor` needs both `eta` and `k`")),
            (Some(other), _, _) => {
                let at = p.child("material").unwrap_or(&p.element);
                let help = "give its index as the spectra `eta` and `k`, or `none` for a mirror";
                Err(at.error_at("value", format!("the metal `{other}` is not known by name")).with_help(help))
            }
        }
    }

    fn area(element: &Rc<Element>) -> Result<Spectrum> {
        let p = Properties::of(element)?;
        if p.kind != "area" {
            return Err(p.unsupported(&["area"]));
        }
        let radiance = p.spectrum("radiance", RgbKind::Illuminant)?;
        p.finish()?;
        Ok(radiance.unwrap_or_else(white))
    }

    pub(super) fn light(&mut self, element: &Rc<Element>) -> Result<()> {
        let p = Properties::of(element)?;
        let light = match p.kind.as_str() {
            "constant" => {
                Light::Environment { radiance: p.spectrum("radiance", RgbKind::Illuminant)?.unwrap_or_else(white) }
            }
            "envmap" => self.environment(&p)?,
            "point" => {
                let position = match p.vector("position")? {
                    Some(at) if p.child("to_world").is_none() => at,
                    None => p.transform("to_world")?.point([0.0; 3]),
                    Some(_) => return Err(element.error("a `point` has either `position` or `to_world`")),
                };
                let intensity = p.spectrum("intensity", RgbKind::Illuminant)?.unwrap_or_else(white);
                Light::Point { position, intensity, medium: self.medium_child(&p)? }
            }
            "spot" => {
                let to_world = p.transform("to_world")?;
                let cutoff = p.float_in("cutoff_angle", 20.0, "between 0 and 180 degrees", |a| a > 0.0 && a < 180.0)?;
                let beam = 0.75 * cutoff;
                let beam = p.float_in("beam_width", beam, "at most `cutoff_angle`", |b| b >= 0.0 && b <= cutoff)?;
                Light::Spot {
                    position: to_world.point([0.0; 3]),
                    direction: normalise(to_world.vector([0.0, 0.0, 1.0])).unwrap_or([0.0, 0.0, 1.0]),
                    intensity: p.spectrum("intensity", RgbKind::Illuminant)?.unwrap_or_else(white),
                    cutoff: cutoff.to_radians(),
                    beam_width: beam.to_radians(),
                    medium: self.medium_child(&p)?,
                }
            }
            "directional" => {
                let along = match p.vector("direction")? {
                    Some(along) if p.child("to_world").is_none() => along,
                    None => p.transform("to_world")?.vector([0.0, 0.0, 1.0]),
                    Some(_) => return Err(element.error("a `directional` has either `direction` or `to_world`")),
                };
                let direction = normalise(along).ok_or_else(|| element.error("`direction` has no length"))?;
                let irradiance = p.spectrum("irradiance", RgbKind::Illuminant)?.unwrap_or_else(white);
                Light::Directional { direction, irradiance }
            }
            "area" => return Err(element.error("an `area` light stands inside the shape that shines")),
            _ => return Err(p.unsupported(&LIGHTS)),
        };
        p.ignore(&["sampling_weight"]);
        p.finish()?;
        self.out.lights.push(light);
        Ok(())
    }

    fn environment(&self, p: &Properties) -> Result<Light> {
        let name = p.string("filename")?.ok_or_else(|| p.element.error("an `envmap` needs a `filename`"))?;
        let path = self.loader.find(&p.element, &name);
        let named = p.child("filename").unwrap_or(&p.element);
        let wrong = |problem: String| named.error_at("value", problem);
        let (size, rgb) = read_picture(&path).map_err(wrong)?;
        p.ignore(&["mis_compensation"]);
        let scale = p.float_in("scale", 1.0, "at least 0", |s| s >= 0.0)?;
        Ok(Light::EnvironmentImage(EnvironmentImage { size, rgb, scale, to_world: p.transform("to_world")?, path }))
    }
}

type Picture = ([u32; 2], Vec<[f32; 3]>);

fn read_picture(path: &Path) -> std::result::Result<Picture, String> {
    crate::image::read_radiance(path).map_err(|e| e.to_string())
}

/// What a light sends out unless something else is said.
fn white() -> Spectrum {
    Spectrum::Rgb { rgb: [1.0; 3], kind: RgbKind::Illuminant }
}
