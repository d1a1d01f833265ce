//! Bodies of revolution about the z axis.

use std::f64::consts::TAU;

use super::{GeometryError, Mesh};

/// A corner of the outline that is turned about the z axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfilePoint {
    /// Distance from the axis, m; at least 0.
    pub r: f64,
    /// Height, m.
    pub z: f64,
    /// Whether the surface has a sharp edge here; else its normal turns smoothly.
    pub crease: bool,
    /// Outward normal (r, z) where it is known, as on an arc; else the mean of the two stretches that meet here. Not used
    /// at creases and on the axis.
    pub normal: Option<[f64; 2]>,
}

impl ProfilePoint {
    /// A point where the surface is smooth.
    pub fn smooth(r: f64, z: f64) -> Self {
        Self { r, z, crease: false, normal: None }
    }

    /// A point where the surface has an edge.
    pub fn crease(r: f64, z: f64) -> Self {
        Self { r, z, crease: true, normal: None }
    }
}

/// Turns an outline about the z axis into a closed mesh with `segments` facets around.
///
/// The outline runs from the axis to the axis with the body on its left: out along the underside, up the outside, in
/// along the top. It must not cross itself. Only its first and last points lie on the axis.
///
/// # Errors
/// [`GeometryError::Profile`] for fewer than three points, a point that is not finite, beyond the axis, or on it
/// where it should not be (or the reverse), or that repeats the one before; [`GeometryError::Segments`].
pub fn revolution(profile: &[ProfilePoint], segments: u32) -> Result<Mesh, GeometryError> {
    check(profile, segments)?;
    let mut turned = Turned { segments, ..Default::default() };
    let last = profile.len() - 1;
    let mut previous =
        turned.ring(profile[0], [0.0, if profile[1].r > 0.0 { normal(profile, 0)[1].signum() } else { 1.0 }]);
    for (i, point) in profile.iter().enumerate().skip(1) {
        let before = normal(profile, i - 1);
        if i == last {
            let ring = turned.ring(*point, [0.0, before[1].signum()]);
            turned.band(previous, ring);
        } else if point.crease {
            let ring = turned.ring(*point, before);
            turned.band(previous, ring);
            previous = turned.ring(*point, normal(profile, i));
        } else {
            let after = normal(profile, i);
            let mean = [before[0] + after[0], before[1] + after[1]];
            let ring = turned.ring(*point, point.normal.unwrap_or(mean));
            turned.band(previous, ring);
            previous = ring;
        }
    }
    Mesh::new(turned.vertices, turned.triangles, Some(turned.normals))
}

fn check(profile: &[ProfilePoint], segments: u32) -> Result<(), GeometryError> {
    if !(3..=100_000).contains(&segments) {
        return Err(GeometryError::Segments { segments });
    }
    let bad = |index: usize, rule| {
        let (r, z) = profile.get(index).map_or((f64::NAN, f64::NAN), |p| (p.r, p.z));
        Err(GeometryError::Profile { index, r, z, rule })
    };
    if profile.len() < 3 {
        return bad(profile.len(), "an outline has at least three points");
    }
    for (i, point) in profile.iter().enumerate() {
        let end = i == 0 || i == profile.len() - 1;
        let finite = point.normal.is_none_or(|[nr, nz]| nr.is_finite() && nz.is_finite());
        if !(point.r.is_finite() && point.z.is_finite() && finite && point.r >= 0.0) {
            return bad(i, "coordinates are finite and r is not negative");
        }
        if end != (point.r == 0.0) {
            return bad(i, "the first and last points lie on the axis, and no other");
        }
        if i > 0 && (profile[i - 1].r, profile[i - 1].z) == (point.r, point.z) {
            return bad(i, "it repeats the point before");
        }
    }
    Ok(())
}

/// Outward unit normal (r, z) of the outline between points `i` and `i + 1`.
fn normal(profile: &[ProfilePoint], i: usize) -> [f64; 2] {
    let (dr, dz) = (profile[i + 1].r - profile[i].r, profile[i + 1].z - profile[i].z);
    let length = dr.hypot(dz);
    [dz / length, -dr / length]
}

/// A ring of vertices, or the single vertex on the axis.
#[derive(Clone, Copy)]
struct Ring {
    first: u32,
    pole: bool,
}

#[derive(Default)]
struct Turned {
    segments: u32,
    vertices: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Turned {
    fn ring(&mut self, point: ProfilePoint, [nr, nz]: [f64; 2]) -> Ring {
        let first = self.vertices.len() as u32;
        let pole = point.r == 0.0;
        for k in 0..if pole { 1 } else { self.segments } {
            let (sin, cos) = (TAU * f64::from(k) / f64::from(self.segments)).sin_cos();
            self.vertices.push([point.r * cos, point.r * sin, point.z].map(|v| v as f32));
            self.normals.push([nr * cos, nr * sin, nz].map(|v| v as f32));
        }
        Ring { first, pole }
    }

    fn band(&mut self, a: Ring, b: Ring) {
        for k in 0..self.segments {
            let next = (k + 1) % self.segments;
            let at = |ring: Ring, k: u32| ring.first + if ring.pole { 0 } else { k };
            let [a0, a1, b0, b1] = [at(a, k), at(a, next), at(b, k), at(b, next)];
            if !a.pole {
                self.triangles.push([a0, a1, b1]);
            }
            if !b.pole {
                self.triangles.push([a0, b1, b0]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn a_cylinder_is_closed_and_has_its_volume() {
        let outline = [
            ProfilePoint::smooth(0.0, 0.0),
            ProfilePoint::crease(0.5, 0.0),
            ProfilePoint::crease(0.5, 2.0),
            ProfilePoint::smooth(0.0, 2.0),
        ];
        let mesh = revolution(&outline, 512).unwrap();
        assert!(mesh.is_closed());
        assert!((mesh.signed_volume() / (PI * 0.5) - 1.0).abs() < 1e-4);
        // Around the side normals point straight out, on the lids straight up or down.
        for (v, n) in mesh.vertices().iter().zip(mesh.normals().unwrap()) {
            assert!((n[2].abs() - 1.0).abs() < 1e-6 || (n[2].abs() < 1e-6 && v[0] * n[0] + v[1] * n[1] > 0.0));
        }
    }

    #[test]
    fn bad_outlines_are_refused() {
        let p = ProfilePoint::smooth;
        let good = [p(0.0, 0.0), p(1.0, 0.5), p(0.0, 1.0)];
        assert!(revolution(&good, 3).unwrap().is_closed());
        assert_eq!(revolution(&good, 2), Err(GeometryError::Segments { segments: 2 }));
        for bad in [
            vec![],
            vec![p(0.0, 0.0), p(0.0, 1.0)],
            vec![p(0.1, 0.0), p(1.0, 0.5), p(0.0, 1.0)],
            vec![p(0.0, 0.0), p(-1.0, 0.5), p(0.0, 1.0)],
            vec![p(0.0, 0.0), p(1.0, f64::NAN), p(0.0, 1.0)],
            vec![p(0.0, 0.0), p(1.0, 0.5), p(1.0, 0.5), p(0.0, 1.0)],
            vec![p(0.0, 0.0), p(1.0, 0.5), p(0.0, 0.7), p(1.0, 0.8), p(0.0, 1.0)],
        ] {
            assert!(matches!(revolution(&bad, 8), Err(GeometryError::Profile { .. })), "{bad:?}");
        }
    }
}
