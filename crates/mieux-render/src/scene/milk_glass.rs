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
    /// Share of light the table reflects, in [0, 1].
    pub table: f64,
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
    /// One liquid in a quarter-litre tumbler on a grey table; several side by side in vials on a darker one. Four fifths
    /// full, in a picture of 320 x 240, rendered from 380 to 775 nm.
    ///
    /// Vials, because what is compared should differ: a turbid liquid that fills a tumbler returns nearly all light it
    /// does not absorb, and its colour is that of absorption alone. Through 8 mm some red and yellow gets out on the
    /// other side where little scatters, and is lost on a dark table: protein turns bluish, skimmed milk greyer than
    /// whole.
    pub fn new(liquids: Vec<(String, Medium)>, glass: Medium) -> Self {
        let one = liquids.len() <= 1;
        let shape = if one { DrinkingGlass::default() } else { DrinkingGlass::vial() };
        Self {
            liquids,
            glass,
            shape,
            level: 0.8 * shape.height,
            table: if one { 0.27 } else { 0.15 },
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
            roughness: 0.0,
        };
        bodies.push(body(format!("glass of {name}"), &glass, &wanted.glass, GLASS));
        bodies.push(body(name.clone(), &liquid, medium, LIQUID));
    }
    let row = pitch * (count - 1) as f64 + 2.0 * wanted.shape.outer_radius;
    let camera = camera(wanted, row)?;
    let reach = 6.0 * wanted.shape.height + row;
    let table = Surface::diffuse("table", sweep(reach)?, table_grey(wanted)?);
    let environment = studio()?;
    let wavelength_range = wanted.wavelength_range;
    Ok(Scene { camera, environment, lamps: vec![], bodies, surfaces: vec![table], wavelength_range })
}

/// Looks down a little, from far enough that the row fills the picture.
fn camera(wanted: &GlassScene, row: f64) -> Result<Pinhole, SceneError> {
    let [width, height] = wanted.resolution.map(f64::from);
    let field_of_view: f64 = 24.0;
    let half = (0.5 * field_of_view.to_radians()).tan();
    let across = 1.25 * row + 0.6 * wanted.shape.outer_radius;
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

/// A grey, a little warm.
fn table_grey(wanted: &GlassScene) -> Result<Sampled, SceneError> {
    let medium = |source| SceneError::Medium { name: "table".into(), source };
    let (low, high) = wanted.wavelength_range;
    let grid = WavelengthGrid::new(vec![100e-9, 400e-9, 550e-9, 700e-9, 10e-6]);
    let grey = [0.96, 0.96, 1.0, 1.04, 1.04].map(|tint| (wanted.table * tint).min(1.0));
    grid.and_then(|grid| Sampled::new(grid, grey.to_vec())).map_err(|_| {
        medium(crate::medium::MediumError::Range { what: "reflectance", known_m: (low, high), asked_m: (low, high) })
    })
}

/// The light in which materials are shown: a soft dome, a large soft box from the upper left, a weaker one from the right.
///
/// # Errors
/// Never with these numbers.
pub fn studio() -> Result<Environment, SceneError> {
    // Much light from one side, little from the others: turbid things show their colour only where light can leave
    // another way than it came. Under an even sky everything that absorbs nothing is white.
    let dome = Dome { nadir: 0.24, horizon: 0.4, zenith: 0.66 };
    let key = SoftBox::new([-0.8, -0.75, 0.8], [0.8, 0.8], 0.4, 2.1)?;
    let fill = SoftBox::new([1.0, -0.3, 0.5], [0.35, 0.8], 0.5, 0.4)?;
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
            assert_eq!(prepared.interior_at(glam::DVec3::new(x, 0.0, 0.5 * wanted.level)).bodies(), [1]);
            let wall = x + wanted.shape.inner_radius() + 0.3 * wanted.shape.wall;
            assert_eq!(prepared.interior_at(glam::DVec3::new(wall, 0.0, 0.5 * wanted.level)).bodies(), [0, 1]);
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        assert_eq!(glasses(&GlassScene::new(vec![], glass())), Err(SceneError::NoLiquids));
        let full = GlassScene { level: 0.2, ..GlassScene::new(vec![("w".into(), water())], glass()) };
        assert!(matches!(glasses(&full), Err(SceneError::Geometry(_))));
    }
}
