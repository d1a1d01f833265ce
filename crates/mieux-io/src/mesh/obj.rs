//! Wavefront OBJ. Materials are not read: what a mesh is made of is said by the scene.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use super::{MeshError, RawMesh};

pub(super) fn read(path: &Path) -> Result<RawMesh, MeshError> {
    let file = File::open(path).map_err(|source| MeshError::Read { path: path.into(), source })?;
    let options = tobj::LoadOptions { single_index: true, triangulate: true, ..tobj::LoadOptions::default() };
    let mut reader = BufReader::with_capacity(1 << 20, file);
    let error = |problem: String| MeshError::Format { path: path.into(), problem };
    let no_materials = |_: &Path| Ok(Default::default());
    let (models, _) = tobj::load_obj_buf(&mut reader, &options, no_materials).map_err(|e| error(e.to_string()))?;
    let mut whole = RawMesh::default();
    for model in models {
        let mesh = model.mesh;
        let base = u32::try_from(whole.positions.len()).map_err(|_| error("more than 2³² vertices".into()))?;
        let known = mesh.positions.len() / 3;
        whole.positions.extend(mesh.positions.chunks_exact(3).map(|p| [p[0], p[1], p[2]]));
        whole.normals.extend(mesh.normals.chunks_exact(3).map(|n| [n[0], n[1], n[2]]));
        whole.uvs.extend(mesh.texcoords.chunks_exact(2).map(|t| [t[0], t[1]]));
        for corners in mesh.indices.chunks_exact(3) {
            if corners.iter().any(|&i| i as usize >= known) {
                return Err(error(format!("a face of `{}` asks for a vertex that is not there", model.name)));
            }
            let corner = |i: u32| base.checked_add(i).ok_or_else(|| error("more than 2³² vertices".into()));
            whole.triangles.push([corner(corners[0])?, corner(corners[1])?, corner(corners[2])?]);
        }
    }
    Ok(whole)
}
