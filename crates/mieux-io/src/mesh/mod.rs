//! Surfaces made of triangles, and the files they come in: PLY, OBJ and glTF 2.0.
//!
//! Whatever a file declares, memory grows with the bytes that are there. A mesh that comes out of here has finite vertices,
//! indices in range and no flat triangles; how far it is from a closed surface is in its [`MeshReport`].

mod gltf_file;
mod obj;
mod ply;
mod topology;

use std::path::{Path, PathBuf};

pub use topology::Topology;

use crate::scene::transform::{cross, norm};

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

/// What was found in a mesh file, beyond the mesh.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MeshReport {
    /// Triangles without area, which were left out.
    pub flat: usize,
    /// Vertices whose normal has no direction; if there are any, all normals of the mesh were left out.
    pub lost_normals: usize,
    /// How the triangles hang together, before the flat ones were left out.
    pub topology: Topology,
}

/// Why there is no mesh.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// The file cannot be opened or read.
    #[error("the mesh `{}` cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The name ends in nothing that is known.
    #[error("`{}` is no mesh that can be read: its name ends in none of .ply, .obj, .gltf, .glb", path.display())]
    Kind {
        /// The file.
        path: PathBuf,
    },
    /// The file does not keep to its format.
    #[error("the mesh `{}` is damaged or not supported: {problem}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// A vertex that is nowhere.
    #[error("the mesh `{}` has a vertex that is not finite: vertex {vertex} (from 0) is at {at:?}", path.display())]
    Vertex {
        /// The file.
        path: PathBuf,
        /// Which, from 0.
        vertex: usize,
        /// Its coordinates.
        at: [f32; 3],
    },
    /// A triangle between vertices that are not there.
    #[error("the mesh `{}` has {vertices} vertices, but triangle {triangle} (from 0) asks for vertex {index}", path.display())]
    Index {
        /// The file.
        path: PathBuf,
        /// Which triangle, from 0.
        triangle: usize,
        /// What it asks for.
        index: i64,
        /// How many there are.
        vertices: usize,
    },
    /// Nothing to see.
    #[error("the mesh `{}` has no triangle with an area (of {read} in the file)", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
        /// Triangles read, all of them flat.
        read: usize,
    },
}

/// Reads a mesh by what its name ends in.
///
/// All objects of an OBJ file and all nodes of a glTF scene become one mesh, in the frame of the file. Polygons are cut into
/// triangles from their first corner. Normals and texture coordinates are kept only if all parts have them.
///
/// # Errors
/// [`MeshError`].
pub fn read_mesh(path: &Path) -> Result<(TriangleMesh, MeshReport), MeshError> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let raw = match ending.as_deref() {
        Some("ply") => ply::read(path)?,
        Some("obj") => obj::read(path)?,
        Some("gltf" | "glb") => gltf_file::read(path)?,
        _ => return Err(MeshError::Kind { path: path.into() }),
    };
    finish(path, raw)
}

/// A mesh as the file has it.
#[derive(Debug, Default)]
struct RawMesh {
    positions: Vec<[f32; 3]>,
    /// As many as positions, or none.
    normals: Vec<[f32; 3]>,
    /// As many as positions, or none.
    uvs: Vec<[f32; 2]>,
    triangles: Vec<[u32; 3]>,
}

/// Area of the parallelogram in `f64`, exactly zero for corners in a line that `f32` can show.
fn twice_area(positions: &[[f32; 3]], [a, b, c]: [u32; 3]) -> f64 {
    let at = |i: u32| positions[i as usize].map(f64::from);
    let (a, b, c) = (at(a), at(b), at(c));
    norm(cross(std::array::from_fn(|i| b[i] - a[i]), std::array::from_fn(|i| c[i] - a[i])))
}

fn finish(path: &Path, raw: RawMesh) -> Result<(TriangleMesh, MeshReport), MeshError> {
    let RawMesh { positions, normals, uvs, mut triangles } = raw;
    if let Some(vertex) = positions.iter().position(|p| p.iter().any(|c| !c.is_finite())) {
        return Err(MeshError::Vertex { path: path.into(), vertex, at: positions[vertex] });
    }
    let vertices = positions.len();
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&index) = corners.iter().find(|&&i| i as usize >= vertices) {
            return Err(MeshError::Index { path: path.into(), triangle, index: i64::from(index), vertices });
        }
    }
    let topology = Topology::of(&positions, &triangles);
    let read = triangles.len();
    triangles.retain(|&t| twice_area(&positions, t) > 0.0);
    if triangles.is_empty() {
        return Err(MeshError::Empty { path: path.into(), read });
    }
    let (normals, lost_normals) = unit_normals(normals, vertices);
    let uvs = (uvs.len() == vertices && uvs.iter().flatten().all(|c| c.is_finite())).then_some(uvs);
    let report = MeshReport { flat: read - triangles.len(), lost_normals, topology };
    Ok((TriangleMesh { positions, normals, uvs, triangles }, report))
}

/// Normals of unit length, or none if one of them has no direction; and how many have none.
fn unit_normals(mut normals: Vec<[f32; 3]>, vertices: usize) -> (Option<Vec<[f32; 3]>>, usize) {
    if normals.len() != vertices {
        return (None, 0);
    }
    let mut lost = 0;
    for normal in &mut normals {
        let wide = normal.map(f64::from);
        let length = norm(wide);
        if length.is_finite() && length > 0.0 {
            *normal = wide.map(|c| (c / length) as f32);
        } else {
            lost += 1;
        }
    }
    ((lost == 0).then_some(normals), lost)
}

#[cfg(test)]
mod tests;
