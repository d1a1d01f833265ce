//! Simple shapes: boxes, spheres, disks.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::{GeometryError, Mesh, ProfilePoint, revolution};

/// A closed box between two corners (m), sharp-edged.
///
/// # Errors
/// [`GeometryError::Length`] unless every side is positive and finite.
pub fn cuboid(low: [f64; 3], high: [f64; 3]) -> Result<Mesh, GeometryError> {
    for k in 0..3 {
        positive("the side of a box", high[k] - low[k])?;
    }
    let vertices = (0..8)
        .map(|i: usize| std::array::from_fn(|k| if i >> k & 1 == 1 { high[k] as f32 } else { low[k] as f32 }))
        .collect();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh::new(vertices, triangles, None)
}

/// A closed sphere. Rays meet the sphere itself; where triangles are wanted there are `2 rings` around and `rings` from pole
/// to pole, `rings >= 2`.
///
/// # Errors
/// [`GeometryError::Length`] for a radius that is not positive and finite, [`GeometryError::Segments`].
pub fn sphere(centre: [f64; 3], radius: f64, rings: u32) -> Result<Mesh, GeometryError> {
    positive("the radius of a sphere", radius)?;
    if !(2..=10_000).contains(&rings) {
        return Err(GeometryError::Segments { segments: rings });
    }
    let outline: Vec<_> = (0..=rings)
        .map(|i| {
            let angle = PI * f64::from(i) / f64::from(rings);
            let end = i == 0 || i == rings;
            ProfilePoint::smooth(if end { 0.0 } else { radius * angle.sin() }, -radius * angle.cos())
        })
        .collect();
    Ok(revolution(&outline, 2 * rings)?.translated(centre).round(DVec3::from_array(centre), radius))
}

/// A flat round disk facing up; open, so only for opaque surfaces.
///
/// # Errors
/// [`GeometryError::Length`] for a radius that is not positive and finite, [`GeometryError::Segments`].
pub fn disk(centre: [f64; 3], radius: f64, segments: u32) -> Result<Mesh, GeometryError> {
    positive("the radius of a disk", radius)?;
    if !(3..=100_000).contains(&segments) {
        return Err(GeometryError::Segments { segments });
    }
    let mut vertices = vec![centre.map(|v| v as f32)];
    for k in 0..segments {
        let (sin, cos) = (TAU * f64::from(k) / f64::from(segments)).sin_cos();
        let at = [centre[0] + radius * cos, centre[1] + radius * sin, centre[2]];
        vertices.push(at.map(|v| v as f32));
    }
    let triangles = (0..segments).map(|k| [0, 1 + k, 1 + (k + 1) % segments]).collect();
    Mesh::new(vertices, triangles, None)
}

pub(super) fn positive(what: &'static str, value: f64) -> Result<(), GeometryError> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(GeometryError::Length { what, value, rule: "must be positive and finite" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_is_closed_and_round() {
        let mesh = sphere([1.0, 2.0, 3.0], 0.5, 64).unwrap();
        assert!(mesh.is_closed());
        assert!((mesh.signed_volume() / (4.0 / 3.0 * PI * 0.125) - 1.0).abs() < 5e-3);
        for (v, n) in mesh.vertices().iter().zip(mesh.normals().unwrap()) {
            let out = [v[0] - 1.0, v[1] - 2.0, v[2] - 3.0];
            let along: f32 = (0..3).map(|k| out[k] * n[k]).sum();
            assert!((along - 0.5).abs() < 1e-3);
        }
    }

    #[test]
    fn a_disk_is_open_and_faces_up() {
        let mesh = disk([0.0; 3], 1.0, 128).unwrap();
        assert!(!mesh.is_closed());
        assert!((mesh.area() / PI - 1.0).abs() < 1e-3);
        let [a, b, c] = mesh.corners(0);
        assert!((b - a).cross(c - a).z > 0.0);
    }

    #[test]
    fn sizes_are_checked() {
        assert!(cuboid([0.0; 3], [1.0, 0.0, 1.0]).is_err());
        assert!(sphere([0.0; 3], -1.0, 8).is_err());
        assert!(sphere([0.0; 3], 1.0, 1).is_err());
        assert!(disk([0.0; 3], f64::NAN, 8).is_err());
    }
}
