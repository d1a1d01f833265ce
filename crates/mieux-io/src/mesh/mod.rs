//! Surfaces made of triangles, and the files they come in.

/// Triangles over shared vertices.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TriangleMesh {
    /// Metres in the mesh's frame; every number is finite.
    pub positions: Vec<[f32; 3]>,
    /// One for each vertex, of unit length, where the file has them.
    pub normals: Option<Vec<[f32; 3]>>,
    /// One for each vertex, where the file has them.
    pub uvs: Option<Vec<[f32; 2]>>,
    /// Three vertices each, counterclockwise from outside; every index is in range, no triangle is flat.
    pub triangles: Vec<[u32; 3]>,
}
