//! Glasses of liquid on a table in a studio.

use super::{Body, Scene, SceneError, Surface};
use crate::camera::Pinhole;
use crate::geometry::{DrinkingGlass, Mesh};
use crate::light::{Dome, Environment, Pattern, SoftBox, Studio};
use crate::medium::Medium;
use mieux_optics::spectrum::{Sampled, WavelengthGrid};

/// One or more glasses in a row, each with its own liquid, photographed from a little above.
#[derive(Debug, Clone, PartialEq)]
pub struct GlassScene {
    /// What is in the glasses, from left to right; at least one. Name and medium of each.
    pub liquids: Vec<(String, Medium)>,
    /// What the glasses are made of.
    pub glass: Medium,
    /// Their shape.
    pub shape: DrinkingGlass,
    /// Height of the liquid above the table, m.
    pub level: f64,
    /// Width and height of the picture, pixels.
    pub resolution: [u32; 2],
    /// Shortest and longest wavelength rendered, m.
    pub wavelength_range: (f64, f64),
}

/// The glass wins over what is in it.
const LIQUID: i32 = 0;
const GLASS: i32 = 10;
/// The glasses stand this far above the table, m: they touch it nowhere, so that no two surfaces coincide.
const FOOT_GAP: f64 = 20e-6;

impl GlassScene {
    /// Quarter-litre tumblers, four fifths full, in a picture of 320 x 240, rendered from 380 to 775 nm.
    pub fn new(liquids: Vec<(String, Medium)>, glass: Medium) -> Self {
        Self {
            liquids,
            glass,
            shape: DrinkingGlass::default(),
            level: 0.084,
            resolution: [320, 240],
            wavelength_range: (380e-9, 775e-9),
        }
    }
}

/// Builds the scene: glasses on a grey table that sweeps up behind them, under a large soft box from the upper left
/// and a weaker one from the right.
///
/// # Errors
/// [`SceneError`] without liquids, or for a shape or picture that cannot be.
pub fn glasses(wanted: &GlassScene) -> Result<Scene, SceneError> {
    let count = wanted.liquids.len();
    if count == 0 {
        return Err(SceneError::NoLiquids);
    }
    let (glass, liquid) = (wanted.shape.glass()?, wanted.shape.liquid(wanted.level)?);
    let pitch = 2.5 * wanted.shape.outer_radius;
    let mut bodies = Vec::with_capacity(2 * count);
    for (k, (name, medium)) in wanted.liquids.iter().enumerate() {
        let place = [(k as f64 - 0.5 * (count - 1) as f64) * pitch, 0.0, FOOT_GAP];
        let body = |name: String, mesh: &Mesh, medium: &Medium, priority| Body {
            name,
            mesh: mesh.translated(place),
            medium: medium.clone(),
            priority,
        };
        bodies.push(body(format!("glass of {name}"), &glass, &wanted.glass, GLASS));
        bodies.push(body(name.clone(), &liquid, medium, LIQUID));
    }
    let row = pitch * (count - 1) as f64 + 2.0 * wanted.shape.outer_radius;
    let camera = camera(wanted, row)?;
    let reach = 0.6 + row;
    let table = Surface { name: "table".into(), mesh: sweep(reach)?, reflectance: table_grey(wanted)? };
    let environment = studio()?;
    Ok(Scene { camera, environment, bodies, surfaces: vec![table], wavelength_range: wanted.wavelength_range })
}

/// Looks down a little, from far enough that the row fills the picture.
fn camera(wanted: &GlassScene, row: f64) -> Result<Pinhole, SceneError> {
    let [width, height] = wanted.resolution.map(f64::from);
    let field_of_view: f64 = 24.0;
    let half = (0.5 * field_of_view.to_radians()).tan();
    let across = 1.25 * row + 0.02;
    let up = 1.62 * wanted.shape.height;
    let distance = (0.5 * up / half).max(0.5 * across / (half * width / height));
    let tilt: f64 = 20f64.to_radians();
    let target = [0.0, 0.0, 0.46 * wanted.shape.height];
    let position = [0.0, -distance * tilt.cos(), target[2] + distance * tilt.sin()];
    Ok(Pinhole::new(position, target, [0.0, 0.0, 1.0], field_of_view, wanted.resolution)?)
}

/// A flat table that rises behind the glasses into a wall with a wide rounding: no horizon. The rounding has facets too
/// fine to be seen.
fn sweep(reach: f64) -> Result<Mesh, SceneError> {
    let (radius, steps) = (0.5 * reach, 240u32);
    let behind = 0.35 * reach;
    let mut outline = vec![[-2.0 * reach, 0.0], [behind, 0.0]];
    for k in 1..=steps {
        let (sin, cos) = (std::f64::consts::FRAC_PI_2 * f64::from(k) / f64::from(steps)).sin_cos();
        outline.push([behind + radius * sin, radius * (1.0 - cos)]);
    }
    outline.push([behind + radius, radius + reach]);
    let (mut vertices, mut triangles) = (vec![], vec![]);
    for (k, [y, z]) in (0u32..).zip(outline) {
        vertices.extend([-3.0 * reach, 3.0 * reach].map(|x| [x, y, z].map(|v| v as f32)));
        if k > 0 {
            let b = 2 * k;
            triangles.extend([[b - 2, b - 1, b + 1], [b - 2, b + 1, b]]);
        }
    }
    Ok(Mesh::new(vertices, triangles, None)?)
}

/// A middling grey, a little warm.
fn table_grey(wanted: &GlassScene) -> Result<Sampled, SceneError> {
    let medium = |source| SceneError::Medium { name: "table".into(), source };
    let (low, high) = wanted.wavelength_range;
    let grid = WavelengthGrid::new(vec![100e-9, 400e-9, 550e-9, 700e-9, 10e-6]);
    grid.and_then(|grid| Sampled::new(grid, vec![0.26, 0.26, 0.27, 0.28, 0.28])).map_err(|_| {
        medium(crate::medium::MediumError::Range { what: "reflectance", known_m: (low, high), asked_m: (low, high) })
    })
}

fn studio() -> Result<Environment, SceneError> {
    // Much light from one side, little from the others: turbid things show their colour only where light can leave
    // another way than it came. Under an even sky everything that absorbs nothing is white.
    let dome = Dome { nadir: 0.18, horizon: 0.3, zenith: 0.5 };
    let key = SoftBox::new([-0.8, -0.75, 0.8], [0.8, 0.8], 0.4, 1.6)?;
    let fill = SoftBox::new([1.0, -0.3, 0.5], [0.35, 0.8], 0.5, 0.3)?;
    Ok(Environment::daylight(Pattern::Studio(Studio::new(dome, vec![key, fill])?)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Prepared;

    fn water() -> Medium {
        Medium::grey(0.0, 0.0, 0.0, 1.33).unwrap()
    }

    fn glass() -> Medium {
        Medium::grey(0.0, 1.0, 0.0, 1.52).unwrap()
    }

    #[test]
    fn one_and_seven_glasses_can_be_rendered() {
        for count in [1, 7] {
            let wanted = GlassScene::new(vec![("water".into(), water()); count], glass());
            let scene = glasses(&wanted).unwrap();
            assert_eq!(scene.bodies.len(), 2 * count);
            let prepared = Prepared::new(&scene).unwrap();
            assert!(prepared.camera_interior().is_empty());
            // In the middle of a glass is liquid, in its wall glass and liquid.
            let x = -0.5 * (count - 1) as f64 * 2.5 * wanted.shape.outer_radius;
            assert_eq!(prepared.interior_at(glam::DVec3::new(x, 0.0, 0.05)).bodies(), [1]);
            let wall = x + wanted.shape.inner_radius() + 0.3 * wanted.shape.wall;
            assert_eq!(prepared.interior_at(glam::DVec3::new(wall, 0.0, 0.05)).bodies(), [0, 1]);
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        assert_eq!(glasses(&GlassScene::new(vec![], glass())), Err(SceneError::NoLiquids));
        let full = GlassScene { level: 0.2, ..GlassScene::new(vec![("w".into(), water())], glass()) };
        assert!(matches!(glasses(&full), Err(SceneError::Geometry(_))));
    }
}
