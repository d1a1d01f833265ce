//! Whole scenes as TOML: a camera, lights, media and objects.
//!
//! ```toml
//! title = "Milk in a ball"
//!
//! [camera]
//! from = ["0m", "10cm", "50cm"]
//! to = ["0m", "0m", "0m"]
//! up = [0, 1, 0]                # unless given
//! fov = 40                      # degrees across the width
//! size = "640x480"
//!
//! [[light]]                     # point, directional, environment, sky, studio
//! kind = "directional"
//! direction = [0, -1, -1]
//! irradiance = 3                # white, in W/m²; or three of red, green, blue
//!
//! [media.milk]
//! material = "whole-milk"       # a name, or a recipe beside this file; `*` is the material asked for
//! set = { fat = 1.5 }
//! density = 1                   # unless given: a factor on its coefficients
//! grid = "cloud.nrrd"           # if its density differs from place to place
//!
//! [[object]]
//! mesh = "bunny.ply"            # or `shape`: sphere, cube, rectangle, disk, with radius or half side 1 before `size`
//! size = "20cm"                 # its largest extent
//! at = ["0m", "0m", "0m"]       # of its middle; the origin unless given
//! finish = "dielectric"         # unless given, if it has a medium inside; or diffuse, null
//! inside = "milk"
//! ```

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use super::description::{
    Camera, Component, Description, EnvironmentImage, Finish, FovAxis, Geometry, Haze, Light, MaterialChoice, Medium,
    MediumKind, Place, ReconstructionFilter, RgbKind, Shape, Sky, Spectrum,
};
use super::transform::{Transform, normalise};
use crate::grid::read_grid;
use crate::image::read_radiance;
use crate::mesh::{TriangleMesh, read_mesh};
use crate::quantity::{Length, Size};
use crate::text_error::{TextError, did_you_mean, nearest_names};

type Lengths = [Spanned<String>; 3];
type Result<T> = std::result::Result<T, Box<TextError>>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    title: Option<String>,
    about: Option<String>,
    camera: CameraText,
    #[serde(default)]
    light: Vec<Spanned<LightText>>,
    #[serde(default)]
    media: BTreeMap<String, Spanned<MediumText>>,
    #[serde(default)]
    object: Vec<Spanned<ObjectText>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraText {
    from: Lengths,
    to: Spanned<Lengths>,
    up: Option<[f64; 3]>,
    fov: Spanned<f64>,
    size: Spanned<String>,
    medium: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Colour {
    White(f64),
    Rgb([f64; 3]),
}

#[derive(Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase", deny_unknown_fields)]
enum LightText {
    Point { position: Lengths, intensity: Colour },
    Directional { direction: [f64; 3], irradiance: Colour },
    Environment { radiance: Option<Colour>, image: Option<String>, scale: Option<f64> },
    Sky { elevation: f64, azimuth: Option<f64>, turbidity: Option<f64>, aerosol: Option<f64>, sun: Option<bool> },
    Studio {},
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MediumText {
    material: String,
    #[serde(default)]
    set: BTreeMap<String, f64>,
    density: Option<f64>,
    grid: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ObjectText {
    name: Option<String>,
    mesh: Option<Spanned<String>>,
    shape: Option<Spanned<String>>,
    size: Spanned<String>,
    at: Option<Lengths>,
    finish: Option<Spanned<String>>,
    reflectance: Option<Colour>,
    inside: Option<Spanned<String>>,
    priority: Option<i32>,
}

/// Whether a text looks like a whole scene: it has a table `camera`.
pub fn is_whole_scene(text: &str) -> bool {
    text.parse::<toml::Table>().is_ok_and(|table| table.contains_key("camera"))
}

/// Reads a whole scene from its text. Files it names lie beside `path`.
///
/// # Errors
/// [`TextError`] with the place.
pub fn parse_whole_scene(path: &Path, text: &str) -> Result<Description> {
    let name = path.to_string_lossy().into_owned();
    let document: Document = toml::from_str(text).map_err(|e| TextError::from_toml(&name, text, &e))?;
    let mut reader = Reader { path, name: &name, text, names: document.media.keys().cloned().collect() };
    let (mut materials, mut media, mut notes) = (Vec::new(), Vec::new(), Vec::new());
    for (label, said) in document.media {
        media.push(reader.medium(label, said, &mut materials)?);
    }
    let camera = reader.camera(document.camera)?;
    let lights: Result<Vec<Light>> = document.light.into_iter().map(|l| reader.light(l)).collect();
    let mut shapes = Vec::new();
    for (n, said) in document.object.into_iter().enumerate() {
        shapes.push(reader.object(n, said, &mut notes)?);
    }
    let title = document.title.unwrap_or_else(|| path.file_stem().unwrap_or_default().to_string_lossy().into_owned());
    let about = document.about.unwrap_or_default();
    Ok(Description { title, about, camera, materials, media, lights: lights?, shapes, notes })
}

struct Reader<'a> {
    path: &'a Path,
    name: &'a str,
    text: &'a str,
    names: Vec<String>,
}

impl Reader<'_> {
    fn error(&self, span: Range<usize>, message: impl Into<String>) -> Box<TextError> {
        TextError::new(self.name, self.text, span, message)
    }

    fn place(&self, span: Range<usize>) -> Place {
        let error = self.error(span, "");
        Place { file: self.name.into(), line: error.line, column: error.column }
    }

    fn beside(&self, name: &str) -> std::path::PathBuf {
        self.path.parent().unwrap_or(Path::new("")).join(name)
    }

    /// Three lengths, which may be negative.
    fn lengths(&self, said: &Lengths) -> Result<[f64; 3]> {
        let mut metres = [0.0; 3];
        for (metres, said) in metres.iter_mut().zip(said) {
            let text = said.get_ref().trim();
            let (sign, text) = text.strip_prefix('-').map_or((1.0, text), |rest| (-1.0, rest));
            let length: Length = text.parse().map_err(|e| self.error(said.span(), format!("{e}")))?;
            *metres = sign * length.metres();
        }
        Ok(metres)
    }

    fn known_medium(&self, said: &Spanned<String>) -> Result<usize> {
        let wanted = said.get_ref();
        self.names.iter().position(|n| n == wanted).ok_or_else(|| {
            let near = did_you_mean(&nearest_names(wanted, self.names.iter().map(String::as_str)));
            self.error(said.span(), format!("there is no medium `{wanted}`")).with_help(near)
        })
    }

    fn colour(&self, colour: Colour, kind: RgbKind, span: Range<usize>) -> Result<Spectrum> {
        let rgb = match colour {
            Colour::White(value) => [value; 3],
            Colour::Rgb(rgb) => rgb,
        };
        let most = if kind == RgbKind::Reflectance { 1.0 } else { f64::MAX };
        match rgb.iter().find(|v| !(0.0..=most).contains(*v)) {
            None => Ok(Spectrum::Rgb { rgb, kind }),
            Some(v) if most == 1.0 => Err(self.error(span, format!("the reflectance {v} is not between 0 and 1"))),
            Some(v) => Err(self.error(span, format!("the light {v} is not zero or more"))),
        }
    }

    fn camera(&self, said: CameraText) -> Result<Camera> {
        let (origin, target) = (self.lengths(&said.from)?, self.lengths(said.to.get_ref())?);
        let pose = Transform::look_at(origin, target, said.up.unwrap_or([0.0, 1.0, 0.0]));
        let degrees = *said.fov.get_ref();
        if !(degrees > 0.0 && degrees < 180.0) {
            return Err(self.error(said.fov.span(), format!("{degrees} degrees are not between 0 and 180")));
        }
        let size: Size = said.size.get_ref().parse().map_err(|e| self.error(said.size.span(), format!("{e}")))?;
        let along = "the camera looks along `up`, or from where to where is the same";
        Ok(Camera {
            to_world: pose.ok_or_else(|| self.error(said.to.span(), along))?,
            fov: degrees.to_radians(),
            fov_axis: FovAxis::X,
            principal_point: [0.0; 2],
            size: [size.width(), size.height()],
            crop: None,
            filter: ReconstructionFilter::Box,
            clip: None,
            medium: said.medium.as_ref().map(|m| self.known_medium(m)).transpose()?,
            spp: None,
            seed: None,
            max_depth: None,
        })
    }

    fn light(&self, said: Spanned<LightText>) -> Result<Light> {
        let span = said.span();
        let wrong = |message: String| self.error(span.clone(), message);
        let shining = |colour| self.colour(colour, RgbKind::Illuminant, span.clone());
        match said.into_inner() {
            LightText::Studio {} => Ok(Light::Studio),
            LightText::Point { position, intensity } => {
                let position = self.lengths(&position)?;
                Ok(Light::Point { position, intensity: shining(intensity)?, medium: None })
            }
            LightText::Directional { direction, irradiance } => {
                let direction = normalise(direction).ok_or_else(|| wrong("`direction` has no length".into()))?;
                Ok(Light::Directional { direction, irradiance: shining(irradiance)? })
            }
            LightText::Environment { radiance: Some(colour), image: None, scale: None } => {
                Ok(Light::Environment { radiance: shining(colour)? })
            }
            LightText::Environment { radiance: None, image: Some(image), scale } => {
                let path = self.beside(&image);
                let (size, rgb) = read_radiance(&path).map_err(|e| wrong(e.to_string()))?;
                let scale = scale.unwrap_or(1.0);
                if !(scale >= 0.0 && scale.is_finite()) {
                    return Err(wrong(format!("the scale {scale} is not zero or more and finite")));
                }
                let to_world = Transform::IDENTITY;
                Ok(Light::EnvironmentImage(EnvironmentImage { size, rgb, scale, to_world, path }))
            }
            LightText::Environment { .. } => {
                Err(wrong("an environment has either `radiance`, or `image` and maybe `scale`".into()))
            }
            LightText::Sky { elevation, azimuth, turbidity, aerosol, sun } => {
                let haze = match (turbidity, aerosol) {
                    (None, None) => Haze::Turbidity(3.0),
                    (Some(t), None) if (1.0..=30.0).contains(&t) => Haze::Turbidity(t),
                    (None, Some(a)) if (0.0..=10.0).contains(&a) => Haze::AerosolOpticalThickness(a),
                    _ => return Err(wrong("give `turbidity`, 1 to 30, or `aerosol`, 0 to 10".into())),
                };
                let azimuth = azimuth.unwrap_or(0.0);
                if !((-90.0..=90.0).contains(&elevation) && azimuth.is_finite()) {
                    return Err(wrong(format!("the sun's elevation {elevation} is not between -90 and 90 degrees")));
                }
                Ok(Light::Sky(Sky {
                    sun_elevation: elevation.to_radians(),
                    sun_azimuth: azimuth.to_radians(),
                    haze,
                    ground_albedo: Spectrum::Constant(0.0),
                    sun: sun.unwrap_or(true),
                    scale: 1.0,
                    to_world: Transform::IDENTITY,
                }))
            }
        }
    }

    fn medium(
        &mut self,
        name: String,
        said: Spanned<MediumText>,
        materials: &mut Vec<MaterialChoice>,
    ) -> Result<Medium> {
        let span = said.span();
        let place = self.place(span.clone());
        let said = said.into_inner();
        let density = said.density.unwrap_or(1.0);
        if !(density >= 0.0 && density.is_finite()) {
            return Err(self.error(span, format!("the density {density} is not zero or more and finite")));
        }
        let material = materials.len();
        let beside = self.beside(&said.material);
        let is_file = said.material.ends_with(".toml");
        let recipe = if is_file { beside.to_string_lossy().into_owned() } else { said.material };
        materials.push(MaterialChoice {
            recipe: (recipe != "*").then_some(recipe),
            set: said.set.into_iter().collect(),
            place: place.clone(),
        });
        let kind = match said.grid {
            None => MediumKind::Material { material, density },
            Some(file) => {
                let grid = read_grid(&self.beside(&file)).map_err(|e| self.error(span.clone(), e.to_string()))?;
                let mut grid = grid;
                if let Some(low) = grid.values.iter().find(|&&v| v < 0.0) {
                    return Err(self.error(span, format!("the grid has a negative density: {low}")));
                }
                grid.values.iter_mut().for_each(|v| *v *= density as f32);
                MediumKind::Mixture(vec![Component { material, density: grid }])
            }
        };
        Ok(Medium { name, kind, place })
    }

    fn object(&self, n: usize, said: Spanned<ObjectText>, notes: &mut Vec<String>) -> Result<Shape> {
        let span = said.span();
        let place = self.place(span.clone());
        let said = said.into_inner();
        let size = Length::parse_positive(said.size.get_ref());
        let size = size.map_err(|e| self.error(said.size.span(), format!("{e}")))?.metres();
        let interior = said.inside.as_ref().map(|m| self.known_medium(m)).transpose()?;
        let half = Transform::scale([size / 2.0; 3]);
        let (geometry, own) = match (&said.mesh, &said.shape) {
            (Some(file), None) => self.mesh(file, size, interior.is_some(), notes)?,
            (None, Some(shape)) => match shape.get_ref().as_str() {
                "sphere" => (Geometry::Sphere { centre: [0.0; 3], radius: 1.0 }, half),
                "cube" => (Geometry::Cube, half),
                "rectangle" => (Geometry::Rectangle, half),
                "disk" => (Geometry::Disk, half),
                other => {
                    let error = self.error(shape.span(), format!("there is no shape `{other}`"));
                    return Err(error.with_help("one of sphere, cube, rectangle, disk"));
                }
            },
            _ => return Err(self.error(span, "an object has either a `mesh` or a `shape`")),
        };
        if interior.is_some() && matches!(geometry, Geometry::Rectangle | Geometry::Disk) {
            return Err(self.error(span, "this shape has no inside, and so no medium in it"));
        }
        let at = said.at.as_ref().map_or(Ok([0.0; 3]), |at| self.lengths(at))?;
        let default = if interior.is_some() { "dielectric" } else { "diffuse" };
        let named = said.finish.as_ref().map_or(default, |f| f.get_ref().as_str());
        let finish = match (named, said.reflectance) {
            ("diffuse", colour) => Finish::Diffuse {
                reflectance: self.colour(colour.unwrap_or(Colour::White(0.5)), RgbKind::Reflectance, span)?,
                two_sided: true,
            },
            ("dielectric", None) => Finish::Dielectric { interior: None, exterior: None, roughness: 0.0 },
            ("null", None) => Finish::Null,
            (_, Some(_)) => return Err(self.error(span, "only a diffuse object has a `reflectance`")),
            (other, _) => {
                let span = said.finish.as_ref().map_or(span, Spanned::span);
                let error = self.error(span, format!("there is no finish `{other}`"));
                return Err(error.with_help("one of diffuse, dielectric, null"));
            }
        };
        Ok(Shape {
            name: said.name.unwrap_or_else(|| format!("object {}", n + 1)),
            geometry,
            to_world: own.then(&Transform::translate(at)),
            flip_normals: false,
            finish,
            interior,
            exterior: None,
            changes_medium: interior.is_some(),
            emission: None,
            priority: said.priority,
            place,
        })
    }

    /// A mesh, and what brings its middle to the origin and its largest extent to `size`.
    fn mesh(
        &self,
        file: &Spanned<String>,
        size: f64,
        filled: bool,
        notes: &mut Vec<String>,
    ) -> Result<(Geometry, Transform)> {
        let wrong = |message: String| self.error(file.span(), message);
        let (mesh, report) = read_mesh(&self.beside(file.get_ref())).map_err(|e| wrong(e.to_string()))?;
        let t = report.topology;
        if filled && !t.is_closed() {
            let edges = t.boundary_edges + t.crowded_edges + t.turned_edges;
            let message = format!(
                "this mesh has a medium inside but is not closed: {edges} of its edges are open, crowded or turned"
            );
            return Err(wrong(message).with_help("close the surface, or take `inside` out"));
        }
        if report.flat > 0 {
            notes.push(format!("`{}`: {} triangles without area were left out", file.get_ref(), report.flat));
        }
        let (low, high) = bounds(&mesh);
        let extent = (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max);
        let middle: [f64; 3] = std::array::from_fn(|i| -0.5 * (low[i] + high[i]));
        let to_world = Transform::translate(middle).then(&Transform::scale([size / extent; 3]));
        Ok((Geometry::Mesh(mesh), to_world))
    }
}

/// Of the vertices that triangles use.
fn bounds(mesh: &TriangleMesh) -> ([f64; 3], [f64; 3]) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for &corner in mesh.triangles.iter().flatten() {
        for (i, &c) in mesh.positions[corner as usize].iter().enumerate() {
            low[i] = low[i].min(f64::from(c));
            high[i] = high[i].max(f64::from(c));
        }
    }
    (low, high)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SCENE: &str = r#"title = "Milk in a ball"
[camera]
from = ["0m", "-10cm", "50cm"]
to = ["0m", "0m", "0m"]
fov = 40
size = "64x48"
medium = "air"
[[light]]
kind = "directional"
direction = [0, -2, 0]
irradiance = 3
[[light]]
kind = "sky"
elevation = 30
[[light]]
kind = "studio"
[media.air]
material = "*"
[media.milk]
material = "whole-milk"
set = { fat = 1.5 }
density = 2
[[object]]
shape = "sphere"
size = "10cm"
at = ["1cm", "0m", "0m"]
inside = "milk"
priority = 1
[[object]]
mesh = "m.obj"
size = "20cm"
reflectance = [0.1, 0.2, 0.3]
"#;

    fn read(text: &str) -> Result<Description> {
        let folder = tempfile::tempdir().unwrap();
        let mesh = "v 5 0 0\nv 9 0 0\nv 5 2 0\nv 100 100 100\nf 1 2 3\n";
        std::fs::write(folder.path().join("m.obj"), mesh).unwrap();
        parse_whole_scene(&folder.path().join("scene.toml"), text)
    }

    #[test]
    fn a_scene_is_read_whole() {
        assert!(is_whole_scene(SCENE) && !is_whole_scene("glasses = [\"water\"]\nsize = \"10x10\""));
        let scene = read(SCENE).unwrap();
        assert_eq!((scene.camera.size, scene.camera.medium, scene.lights.len()), ([64, 48], Some(0), 3));
        assert_eq!(scene.camera.to_world.point([0.0; 3]), [0.0, -0.1, 0.5]);
        assert_eq!(scene.materials[0].recipe, None);
        assert_eq!(scene.materials[1].set, [("fat".to_owned(), 1.5)]);
        assert_eq!(scene.media[1].kind, MediumKind::Material { material: 1, density: 2.0 });
        let ball = &scene.shapes[0];
        assert_eq!((ball.interior, ball.priority, ball.place.line), (Some(1), Some(1), 23));
        assert!((ball.to_world.point([1.0, 0.0, 0.0])[0] - 0.06).abs() < 1e-15);
        assert!(matches!(ball.finish, Finish::Dielectric { interior: None, .. }));
        // The vertex that no triangle uses does not count.
        let far = scene.shapes[1].to_world.point([9.0, 2.0, 0.0]);
        assert!((far[0] - 0.1).abs() < 1e-12 && (far[1] - 0.05).abs() < 1e-12, "{far:?}");
    }

    #[test]
    fn mistakes_are_pointed_at() {
        for (from, to, line, words) in [
            ("\"-10cm\"", "\"-10\"", 3, "no unit"),
            ("fov = 40", "fov = 400", 5, "400 degrees"),
            ("size = \"64x48\"", "size = \"64\"", 6, "64"),
            ("medium = \"air\"", "medium = \"milc\"", 7, "`milc`"),
            ("[0, -2, 0]", "[0, 0, 0]", 8, "no length"),
            ("elevation = 30", "elevation = 300", 12, "300"),
            ("density = 2", "density = -2", 19, "-2"),
            ("\"sphere\"", "\"ball\"", 24, "`ball`"),
            ("\"m.obj\"", "\"n.obj\"", 30, "n.obj"),
            ("reflectance = [0.1, 0.2, 0.3]", "inside = \"milk\"", 30, "not closed"),
            ("[0.1, 0.2, 0.3]", "2", 29, "between 0 and 1"),
            ("priority = 1", "prioritty = 1", 28, "prioritty"),
        ] {
            let error = read(&SCENE.replacen(from, to, 1)).unwrap_err();
            assert!(error.message.contains(words), "`{error}` does not say `{words}`");
            assert_eq!(error.line, line, "{to}: {error}");
        }
    }

    proptest! {
        #[test]
        fn damaged_scenes_end_in_an_answer(at in 0.0..1.0_f64, byte: u8, kind in 0..3_u8, more in 0.0..1.0_f64) {
            let mut bytes = SCENE.as_bytes().to_vec();
            crate::testing::damage(&mut bytes, at, byte, kind, more);
            let _ = read(&String::from_utf8_lossy(&bytes));
        }
    }
}
