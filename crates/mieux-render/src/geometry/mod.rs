//! Shapes: triangle meshes, bodies of revolution, a drinking glass, and the tree that finds triangles.

mod accelerator;
mod ball;
mod drinking_glass;
mod mesh;
mod revolution;
mod shapes;
mod triangle;

pub use accelerator::{Accelerator, Hit};
pub use drinking_glass::DrinkingGlass;
pub use mesh::Mesh;
pub use revolution::{ProfilePoint, revolution};
pub use shapes::{cuboid, disk, sphere};

use glam::DVec3;

/// A half-line: all points `origin + t direction`, `t > 0`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it starts, m.
    pub origin: DVec3,
    /// Where it goes; a unit vector.
    pub direction: DVec3,
}

impl Ray {
    /// The point at distance `t` (m).
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }
}

/// What can be wrong with a shape.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GeometryError {
    /// A vertex or a normal is not finite.
    #[error("vertex {index} of the mesh is not finite: {value:?}")]
    NotFinite {
        /// Which vertex.
        index: usize,
        /// What was found.
        value: [f32; 3],
    },
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} names vertex {index}, but there are {vertices} vertices")]
    IndexOutOfRange {
        /// Which triangle.
        triangle: usize,
        /// The offending index.
        index: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// There must be one normal per vertex.
    #[error("{vertices} vertices but {normals} normals")]
    NormalCount {
        /// Number of vertices.
        vertices: usize,
        /// Number of normals.
        normals: usize,
    },
    /// Nothing is left once degenerate triangles are dropped.
    #[error("the mesh has no triangle with an area")]
    Empty,
    /// A length that must be positive and finite, or smaller than another, is not.
    #[error("{what} = {value} m {rule}")]
    Length {
        /// Which length.
        what: &'static str,
        /// Its value, m.
        value: f64,
        /// What is asked of it.
        rule: &'static str,
    },
    /// A profile needs at least three points, must begin and end on the axis, and may not lie beyond it.
    #[error("profile point {index} at (r, z) = ({r}, {z}) m: {rule}")]
    Profile {
        /// Which point.
        index: usize,
        /// Its distance from the axis, m.
        r: f64,
        /// Its height, m.
        z: f64,
        /// What is asked of it.
        rule: &'static str,
    },
    /// A body of revolution needs at least three segments, and so does a disk.
    #[error("{segments} segments around the axis; between 3 and 100000 are needed")]
    Segments {
        /// The offending number.
        segments: u32,
    },
}
