//! What stands where: colour, direction and distance of what is seen first, for denoisers and for putting pictures together.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::geometry::{Accelerator, Ray};
use crate::light::relative_d65;
use crate::scene::{Owner, Prepared};

/// The first surface in each pixel, averaged over [`FEATURE_RAYS`] rays spread evenly over the pixel's square.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Features {
    /// Linear sRGB of the surface under D65: the reflectance where it is diffuse, 1 where a body's surface reflects and
    /// refracts, 0 where nothing is met.
    pub albedo: [f64; 3],
    /// The normal, towards the camera, in the scene's axes; shorter than 1 where a pixel sees several, 0 where nothing is
    /// met.
    pub normal: [f64; 3],
    /// Distance along the ray, m, averaged over the rays that meet something; infinite where none does.
    pub depth: f64,
}

/// Rays a pixel, a square number.
pub const FEATURE_RAYS: u32 = SIDE * SIDE;

const SIDE: u32 = 4;

/// The features of a window `[left, top, width, height]` of the picture, row by row. They follow from the scene alone.
pub fn features(scene: &Prepared, [left, top, width, height]: [u32; 4]) -> Vec<Features> {
    let row = |y: u32| {
        let mut colours = BTreeMap::new();
        (left..left + width).map(|x| pixel(scene, x, y, &mut colours)).collect::<Vec<_>>()
    };
    (top..top + height).into_par_iter().flat_map_iter(row).collect()
}

fn pixel(scene: &Prepared, x: u32, y: u32, colours: &mut BTreeMap<u16, [f64; 3]>) -> Features {
    let mut sum = Features { albedo: [0.0; 3], normal: [0.0; 3], depth: 0.0 };
    let mut met = 0.0;
    for i in 0..FEATURE_RAYS {
        let inside = |n: u32| (f64::from(n) + 0.5) / f64::from(SIDE);
        let ray = scene.camera().ray(f64::from(x) + inside(i % SIDE), f64::from(y) + inside(i / SIDE));
        let Some(one) = first(scene, &ray, colours) else { continue };
        met += 1.0;
        sum.depth += one.depth;
        for c in 0..3 {
            sum.albedo[c] += one.albedo[c] / f64::from(FEATURE_RAYS);
            sum.normal[c] += one.normal[c] / f64::from(FEATURE_RAYS);
        }
    }
    Features { depth: if met > 0.0 { sum.depth / met } else { f64::INFINITY }, ..sum }
}

fn first(scene: &Prepared, ray: &Ray, colours: &mut BTreeMap<u16, [f64; 3]>) -> Option<Features> {
    let hit = scene.accelerator().intersect(ray, f64::INFINITY, Accelerator::NONE)?;
    let (_, smooth) = scene.accelerator().normals(&hit);
    let normal = if smooth.dot(ray.direction) > 0.0 { -smooth } else { smooth };
    let albedo = match scene.owner(hit.owner) {
        Owner::Body(_) => [1.0; 3],
        Owner::Surface(surface) => *colours.entry(surface).or_insert_with(|| colour(scene, surface)),
    };
    Some(Features { albedo, normal: normal.to_array(), depth: hit.t })
}

/// A reflectance under daylight.
fn colour(scene: &Prepared, surface: u16) -> [f64; 3] {
    const TURNS: u32 = 256;
    let (observer, light) = (scene.observer(), relative_d65());
    let mut rgb = [0.0; 3];
    for i in 0..TURNS {
        let wavelengths = observer.wavelengths((f64::from(i) + 0.5) / f64::from(TURNS));
        let reflectance = scene.reflectance(surface, &wavelengths);
        let seen = std::array::from_fn(|k| reflectance[k] * light.at(wavelengths[k]).unwrap_or(0.0));
        let one = observer.colour(&wavelengths, &seen);
        (0..3).for_each(|c| rgb[c] += one[c] / f64::from(TURNS));
    }
    rgb
}
