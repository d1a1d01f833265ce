//! Triangle meshes.

use std::collections::HashMap;

use glam::{DVec3, Vec3};

use super::GeometryError;

/// Triangles over shared vertices (m), counter-clockwise seen from outside; optionally one unit normal per vertex,
/// interpolated for reflection and refraction as frisvad2012 (4.2.2) describes.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    vertices: Vec<[f32; 3]>,
    normals: Option<Vec<[f32; 3]>>,
    triangles: Vec<[u32; 3]>,
    ball: Option<Ball>,
}

/// The sphere that a mesh stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ball {
    pub(crate) centre: DVec3,
    pub(crate) radius: f64,
}

impl Mesh {
    /// Takes vertices in metres, triangles as indices into them, and optional vertex normals (made unit length).
    /// Triangles without an area are dropped.
    ///
    /// # Errors
    /// [`GeometryError`] for a vertex or normal that is not finite (or a normal of no length), an index out of
    /// range, a wrong number of normals, or when no triangle is left.
    pub fn new(
        vertices: Vec<[f32; 3]>,
        triangles: Vec<[u32; 3]>,
        normals: Option<Vec<[f32; 3]>>,
    ) -> Result<Self, GeometryError> {
        let finite = |(index, value): (usize, &[f32; 3])| {
            if value.iter().all(|v| v.is_finite()) {
                Ok(())
            } else {
                Err(GeometryError::NotFinite { index, value: *value })
            }
        };
        vertices.iter().enumerate().try_for_each(finite)?;
        let normals = normals.map(|n| unit_normals(n, vertices.len())).transpose()?;
        let mut kept = Vec::with_capacity(triangles.len());
        for (triangle, corners) in triangles.iter().enumerate() {
            if let Some(&index) = corners.iter().find(|&&i| i as usize >= vertices.len()) {
                return Err(GeometryError::IndexOutOfRange { triangle, index, vertices: vertices.len() });
            }
            let [a, b, c] = corners.map(|i| position(&vertices, i));
            if (b - a).cross(c - a).length_squared() > 0.0 {
                kept.push(*corners);
            }
        }
        if kept.is_empty() {
            return Err(GeometryError::Empty);
        }
        Ok(Self { vertices, normals, triangles: kept, ball: None })
    }

    /// The same mesh, standing for a sphere: rays meet that instead of the triangles.
    pub(super) fn round(self, centre: DVec3, radius: f64) -> Self {
        Self { ball: Some(Ball { centre, radius }), ..self }
    }

    /// The same mesh, standing for nothing but its triangles.
    pub fn faceted(self) -> Self {
        Self { ball: None, ..self }
    }

    /// The sphere that rays meet instead of the triangles.
    pub(crate) fn ball(&self) -> Option<Ball> {
        self.ball
    }

    /// Vertices, m.
    pub fn vertices(&self) -> &[[f32; 3]] {
        &self.vertices
    }

    /// One unit normal per vertex, if the surface is to look smooth.
    pub fn normals(&self) -> Option<&[[f32; 3]]> {
        self.normals.as_deref()
    }

    /// Three vertex indices per triangle.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The corners of a triangle, exact in `f64`; `triangle` must be below the number of triangles.
    pub(crate) fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|i| position(&self.vertices, i))
    }

    /// Whether every edge is shared by exactly two triangles that run through it in opposite senses. Vertices at the
    /// same place count as one, so creases with doubled vertices do not matter.
    pub fn is_closed(&self) -> bool {
        if self.ball.is_some() {
            return true;
        }
        let mut places = HashMap::new();
        let place: Vec<u32> = self
            .vertices
            .iter()
            .map(|v| {
                let next = places.len() as u32;
                *places.entry(v.map(|x| (x + 0.0).to_bits())).or_insert(next)
            })
            .collect();
        let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
        for corners in &self.triangles {
            for k in 0..3 {
                let (a, b) = (place[corners[k] as usize], place[corners[(k + 1) % 3] as usize]);
                *edges.entry((a, b)).or_insert(0) += 1;
            }
        }
        edges.iter().all(|(&(a, b), &count)| count == 1 && edges.get(&(b, a)) == Some(&1))
    }

    /// Volume enclosed, m^3; negative when the triangles face inward. Meaningful for closed meshes.
    pub fn signed_volume(&self) -> f64 {
        (0..self.triangles.len()).map(|t| self.corners(t)).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
    }

    /// Surface area, m^2.
    pub fn area(&self) -> f64 {
        (0..self.triangles.len()).map(|t| self.corners(t)).map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum()
    }

    /// Smallest and largest coordinates, m.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.vertices
            .iter()
            .map(|v| Vec3::from_array(*v).as_dvec3())
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
    }

    /// The same mesh with its points (m) and the directions of its normals taken elsewhere. Points are rounded to `f32`, the
    /// same way for the same vertex; a mirrored mesh must be [`Self::turned`].
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn mapped(
        &self,
        point: impl Fn([f64; 3]) -> [f64; 3],
        normal: impl Fn([f64; 3]) -> [f64; 3],
    ) -> Result<Self, GeometryError> {
        let vertices = self.vertices.iter().map(|v| point(v.map(f64::from)).map(|x| x as f32)).collect();
        // Normals may be scaled beyond what `f32` holds before they are made unit vectors.
        let unit = |n: &[f32; 3]| DVec3::from_array(normal(n.map(f64::from))).normalize_or_zero().as_vec3().to_array();
        Self::new(vertices, self.triangles.clone(), self.normals.as_ref().map(|n| n.iter().map(unit).collect()))
    }

    /// The same mesh with its inside out; a sphere is one of facets then.
    pub fn turned(mut self) -> Self {
        self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        self.normals.iter_mut().flatten().for_each(|n| *n = n.map(|x| -x));
        self.ball = None;
        self
    }

    /// The same mesh moved by an offset (m); coordinates are rounded to `f32`, the same way for the same vertex.
    pub fn translated(&self, offset: [f64; 3]) -> Self {
        let mut moved = self.clone();
        if let Some(ball) = &mut moved.ball {
            ball.centre += DVec3::from_array(offset);
        }
        for vertex in &mut moved.vertices {
            (0..3).for_each(|k| vertex[k] = (f64::from(vertex[k]) + offset[k]) as f32);
        }
        moved
    }
}

fn position(vertices: &[[f32; 3]], index: u32) -> DVec3 {
    Vec3::from_array(vertices[index as usize]).as_dvec3()
}

fn unit_normals(normals: Vec<[f32; 3]>, vertices: usize) -> Result<Vec<[f32; 3]>, GeometryError> {
    if normals.len() != vertices {
        return Err(GeometryError::NormalCount { vertices, normals: normals.len() });
    }
    let unit = |(index, value): (usize, [f32; 3])| match Vec3::from_array(value).as_dvec3().try_normalize() {
        Some(n) => Ok(n.as_vec3().to_array()),
        None => Err(GeometryError::NotFinite { index, value }),
    };
    normals.into_iter().enumerate().map(unit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;

    #[test]
    fn a_box_is_closed_and_an_open_box_is_not() {
        let mesh = cuboid([0.0; 3], [1.0, 2.0, 3.0]).unwrap();
        assert!(mesh.is_closed());
        assert!((mesh.signed_volume() - 6.0).abs() < 1e-12);
        assert!((mesh.area() - 22.0).abs() < 1e-12);
        let open = Mesh::new(mesh.vertices().to_vec(), mesh.triangles()[1..].to_vec(), None).unwrap();
        assert!(!open.is_closed());
        let mut twisted = mesh.triangles().to_vec();
        twisted[0].swap(0, 1);
        assert!(!Mesh::new(mesh.vertices().to_vec(), twisted, None).unwrap().is_closed());
    }

    #[test]
    fn bad_meshes_are_refused() {
        let v = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(
            Mesh::new(v.clone(), vec![[0, 1, 3]], None),
            Err(GeometryError::IndexOutOfRange { triangle: 0, index: 3, vertices: 3 })
        );
        assert_eq!(Mesh::new(v.clone(), vec![[0, 1, 1]], None), Err(GeometryError::Empty));
        assert_eq!(Mesh::new(v.clone(), vec![], None), Err(GeometryError::Empty));
        let mut w = v.clone();
        w[1][2] = f32::NAN;
        assert!(matches!(Mesh::new(w, vec![[0, 1, 2]], None), Err(GeometryError::NotFinite { index: 1, .. })));
        let normals = Some(vec![[0.0; 3]; 3]);
        assert!(matches!(Mesh::new(v.clone(), vec![[0, 1, 2]], normals), Err(GeometryError::NotFinite { .. })));
        let normals = Some(vec![[1.0; 3]; 2]);
        assert!(matches!(Mesh::new(v.clone(), vec![[0, 1, 2]], normals), Err(GeometryError::NormalCount { .. })));
        let dropped = Mesh::new(v, vec![[0, 1, 2], [0, 0, 1]], None).unwrap();
        assert_eq!(dropped.triangles().len(), 1);
    }
}
