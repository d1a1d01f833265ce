//! glTF 2.0, as text with buffers beside it or inside, or as one binary file.

use std::fs::File;
use std::io::Read;
use std::path::{Component, Path};

use base64::Engine;
use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::Mode;
use gltf::{Accessor, Node, Primitive, Semantic};

use super::{MeshError, RawMesh};

/// Larger files are not read, bytes.
const MAX_BYTES: u64 = 4 << 30;
/// Nodes of nodes of nodes: not deeper than this.
const MAX_DEPTH: usize = 64;
/// Meshes may stand in many places; not in more than this.
const MAX_NODES: usize = 100_000;
/// And not with more triangles in all.
const MAX_TRIANGLES: usize = 200_000_000;

type Matrix = [[f64; 4]; 4];

pub(super) fn read(path: &Path) -> Result<RawMesh, MeshError> {
    let bytes = read_bytes(path)?;
    let error = |problem: String| MeshError::Format { path: path.into(), problem };
    let gltf::Gltf { document, mut blob } = gltf::Gltf::from_slice(&bytes).map_err(|e| error(e.to_string()))?;
    drop(bytes);
    let mut buffers = Vec::new();
    for buffer in document.buffers() {
        let data = match buffer.source() {
            gltf::buffer::Source::Bin => blob.take().ok_or_else(|| error("the binary part is missing".into()))?,
            gltf::buffer::Source::Uri(uri) => read_uri(path, uri)?,
        };
        if data.len() < buffer.length() {
            let (index, length, found) = (buffer.index(), buffer.length(), data.len());
            return Err(error(format!("buffer {index} should have {length} bytes and has {found}")));
        }
        buffers.push(data);
    }
    let mut reader = Reader { path, buffers, mesh: RawMesh::default(), nodes: 0, all_normals: true, all_uvs: true };
    let scene = document.default_scene().or_else(|| document.scenes().next());
    let scene = scene.ok_or_else(|| error("there is no scene in it".into()))?;
    for node in scene.nodes() {
        reader.node(&node, &crate::scene::Transform::IDENTITY.0, 0)?;
    }
    let mut mesh = reader.mesh;
    if !reader.all_normals {
        mesh.normals.clear();
    }
    if !reader.all_uvs {
        mesh.uvs.clear();
    }
    Ok(mesh)
}

fn read_bytes(path: &Path) -> Result<Vec<u8>, MeshError> {
    let error = |source| MeshError::Read { path: path.into(), source };
    let mut bytes = Vec::new();
    File::open(path).map_err(error)?.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(error)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(error(std::io::Error::other("it is larger than 4 GiB")));
    }
    Ok(bytes)
}

/// A buffer from inside the text, or from a file beside it.
fn read_uri(path: &Path, uri: &str) -> Result<Vec<u8>, MeshError> {
    let error = |problem: String| MeshError::Format { path: path.into(), problem };
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, text) = data.split_once(";base64,").ok_or_else(|| error("a data URI is not base64".into()))?;
        let decoded = base64::engine::general_purpose::STANDARD.decode(text);
        return decoded.map_err(|e| error(format!("a data URI is not base64: {e}")));
    }
    let name = uri.replace("%20", " ");
    let beside = Path::new(&name);
    let plain = beside.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
    if !plain || name.contains(':') || name.is_empty() {
        return Err(error(format!("the buffer `{uri}` is not a file beside or below it")));
    }
    read_bytes(&path.parent().unwrap_or(Path::new(".")).join(beside))
}

struct Reader<'a> {
    path: &'a Path,
    buffers: Vec<Vec<u8>>,
    mesh: RawMesh,
    nodes: usize,
    all_normals: bool,
    all_uvs: bool,
}

impl Reader<'_> {
    fn error(&self, problem: String) -> MeshError {
        MeshError::Format { path: self.path.into(), problem }
    }

    fn node(&mut self, node: &Node<'_>, parent: &Matrix, depth: usize) -> Result<(), MeshError> {
        self.nodes += 1;
        if depth > MAX_DEPTH || self.nodes > MAX_NODES {
            return Err(self.error(format!("its nodes are more than {MAX_NODES}, or more than {MAX_DEPTH} deep")));
        }
        let m = node.transform().matrix();
        // The file has columns, here are rows.
        let local: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(m[j][i])));
        let to_world = crate::scene::Transform(local).then(&crate::scene::Transform(*parent)).0;
        if let Some(mesh) = node.mesh() {
            for primitive in mesh.primitives() {
                let name = format!("primitive {} of mesh {}", primitive.index(), mesh.index());
                self.primitive(&primitive, &name, &to_world)?;
            }
        }
        for child in node.children() {
            self.node(&child, &to_world, depth + 1)?;
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: &Primitive<'_>, name: &str, to_world: &Matrix) -> Result<(), MeshError> {
        if matches!(primitive.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
            return Ok(());
        }
        let positions = primitive.get(&Semantic::Positions);
        let positions = positions.ok_or_else(|| self.error(format!("{name} has no positions")))?;
        self.check(&positions, name)?;
        for semantic in [Semantic::Normals, Semantic::TexCoords(0)] {
            if let Some(accessor) = primitive.get(&semantic) {
                self.check(&accessor, name)?;
            }
        }
        if let Some(indices) = primitive.indices() {
            self.check(&indices, name)?;
        }
        let base = self.mesh.positions.len();
        let transform = crate::scene::Transform(*to_world);
        let mirrored = transform.determinant() < 0.0;
        let buffers = &self.buffers;
        let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(Vec::as_slice));
        let found = reader.read_positions().into_iter().flatten();
        let mut points: Vec<[f32; 3]> = found.map(|p| transform.point(p.map(f64::from)).map(|c| c as f32)).collect();
        let count = points.len();
        let mut normals: Vec<[f32; 3]> = Vec::new();
        if let Some(found) = reader.read_normals() {
            normals.extend(found.map(|n| turn_normal(to_world, n.map(f64::from))));
        }
        let mut uvs: Vec<[f32; 2]> = Vec::new();
        if let Some(found) = reader.read_tex_coords(0) {
            uvs.extend(found.into_f32());
        }
        let corners: Vec<u32> = match reader.read_indices() {
            Some(found) => found.into_u32().collect(),
            None => (0..count as u32).collect(),
        };
        let mut triangles = triangles(primitive.mode(), &corners);
        if let Some((triangle, index)) =
            triangles.iter().enumerate().find_map(|(n, t)| Some((n, *t.iter().find(|&&i| i as usize >= count)?)))
        {
            let problem = format!("triangle {triangle} (from 0) of {name} asks for vertex {index} of {count}");
            return Err(self.error(problem));
        }
        if self.mesh.triangles.len() + triangles.len() > MAX_TRIANGLES || base + count > u32::MAX as usize {
            return Err(self.error(format!("it has more than {MAX_TRIANGLES} triangles")));
        }
        for t in &mut triangles {
            if mirrored {
                t.swap(1, 2);
            }
            *t = t.map(|i| i + base as u32);
        }
        self.all_normals &= normals.len() == count;
        self.all_uvs &= uvs.len() == count;
        self.mesh.positions.append(&mut points);
        self.mesh.normals.append(&mut normals);
        self.mesh.uvs.append(&mut uvs);
        self.mesh.triangles.append(&mut triangles);
        Ok(())
    }

    /// That all bytes an accessor asks for are there: the reader takes them for granted.
    fn check(&self, accessor: &Accessor<'_>, name: &str) -> Result<(), MeshError> {
        let problem = |what: &str| Err(self.error(format!("accessor {} of {name} {what}", accessor.index())));
        if accessor.sparse().is_some() {
            return problem("is sparse, which is not supported");
        }
        let Some(view) = accessor.view() else {
            return problem("has no data");
        };
        let size = accessor.size();
        let stride = view.stride().unwrap_or(size);
        if accessor.count() == 0 {
            return problem("is empty");
        }
        if stride < size || accessor.dimensions() == Dimensions::Mat2 {
            return problem("has elements that overlap");
        }
        let needed = (accessor.count() - 1)
            .checked_mul(stride)
            .and_then(|n| n.checked_add(size))
            .and_then(|n| n.checked_add(accessor.offset()));
        let whole = self.buffers.get(view.buffer().index()).map_or(0, Vec::len);
        let in_view = needed.is_some_and(|n| n <= view.length());
        let in_buffer = view.offset().checked_add(view.length()).is_some_and(|end| end <= whole);
        if !(in_view && in_buffer) {
            return problem("reaches beyond its buffer");
        }
        if accessor.data_type() == DataType::F32 || accessor.dimensions() != Dimensions::Vec3 {
            return Ok(());
        }
        problem("has whole numbers where fractions should be")
    }
}

/// A normal goes by the cofactors of the matrix.
fn turn_normal(m: &Matrix, n: [f64; 3]) -> [f32; 3] {
    use crate::scene::transform::cross;
    let row = |i: usize| [m[i][0], m[i][1], m[i][2]];
    let cofactors = [cross(row(1), row(2)), cross(row(2), row(0)), cross(row(0), row(1))];
    let flip = crate::scene::Transform(*m).determinant().signum();
    cofactors.map(|c| (flip * crate::scene::transform::dot(c, n)) as f32)
}

fn triangles(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let turned = |(n, t): (usize, &[u32])| if n % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] };
            corners.windows(3).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => corners.windows(2).skip(1).map(|t| [corners[0], t[0], t[1]]).collect(),
        _ => corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }
}
