//! PLY, as text or bytes of either order.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use serde::de::{Error, IgnoredAny, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_ply::PlyReader;

use super::{MeshError, RawMesh};

#[derive(Deserialize)]
struct Vertex {
    x: f32,
    y: f32,
    z: f32,
    #[serde(default)]
    nx: Option<f32>,
    #[serde(default)]
    ny: Option<f32>,
    #[serde(default)]
    nz: Option<f32>,
    #[serde(default, alias = "s", alias = "texture_u")]
    u: Option<f32>,
    #[serde(default, alias = "t", alias = "texture_v")]
    v: Option<f32>,
}

#[derive(Deserialize)]
struct Face {
    #[serde(alias = "vertex_index")]
    vertex_indices: Vec<i64>,
}

/// Vertices, each taken apart as it comes.
#[derive(Default)]
struct Vertices(RawMesh);

/// Triangles, polygons being cut as they come.
#[derive(Default)]
struct Faces(Vec<[u32; 3]>);

impl<'de> Deserialize<'de> for Vertices {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Rows;
        impl<'de> Visitor<'de> for Rows {
            type Value = Vertices;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("rows of vertices")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut rows: A) -> Result<Vertices, A::Error> {
                let mut mesh = RawMesh::default();
                while let Some(row) =
                    rows.next_element::<Vertex>().map_err(|e| at("vertex", mesh.positions.len(), e))?
                {
                    mesh.positions.push([row.x, row.y, row.z]);
                    if let (Some(x), Some(y), Some(z)) = (row.nx, row.ny, row.nz) {
                        mesh.normals.push([x, y, z]);
                    }
                    if let (Some(u), Some(v)) = (row.u, row.v) {
                        mesh.uvs.push([u, v]);
                    }
                }
                Ok(Vertices(mesh))
            }
        }
        deserializer.deserialize_seq(Rows)
    }
}

impl<'de> Deserialize<'de> for Faces {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Rows;
        impl<'de> Visitor<'de> for Rows {
            type Value = Faces;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("rows of faces")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut rows: A) -> Result<Faces, A::Error> {
                let (mut faces, mut triangles) = (0, Vec::new());
                while let Some(row) = rows.next_element::<Face>().map_err(|e| at("face", faces, e))? {
                    let corner = |i: usize| {
                        let index = row.vertex_indices[i];
                        let message = || A::Error::custom(format!("face {faces} (from 0) asks for vertex {index}"));
                        u32::try_from(index).map_err(|_| message())
                    };
                    for last in 2..row.vertex_indices.len() {
                        triangles.push([corner(0)?, corner(last - 1)?, corner(last)?]);
                    }
                    faces += 1;
                }
                Ok(Faces(triangles))
            }
        }
        deserializer.deserialize_seq(Rows)
    }
}

fn at<E: Error>(what: &str, number: usize, error: E) -> E {
    E::custom(format!("{what} {number} (from 0): {error}"))
}

pub(super) fn read(path: &Path) -> Result<RawMesh, MeshError> {
    let file = File::open(path).map_err(|source| MeshError::Read { path: path.into(), source })?;
    let error = |problem: String| MeshError::Format { path: path.into(), problem };
    let told = |e: serde_ply::DeserializeError| error(e.0.to_string());
    let mut reader = PlyReader::from_reader(BufReader::with_capacity(1 << 20, file)).map_err(told)?;
    let (mut mesh, mut triangles) = (None, None);
    while let Some(element) = reader.current_element() {
        match element.name.as_str() {
            "vertex" if mesh.is_none() => mesh = Some(reader.next_element::<Vertices>().map_err(told)?.0),
            "face" if triangles.is_none() => triangles = Some(reader.next_element::<Faces>().map_err(told)?.0),
            // Rows without a property would come without end.
            _ if element.properties.is_empty() => {
                return Err(error(format!("the element `{}` has no property", element.name)));
            }
            _ => {
                reader.next_element::<IgnoredRows>().map_err(told)?;
            }
        }
    }
    let mut mesh = mesh.ok_or_else(|| error("there is no element `vertex`".into()))?;
    mesh.triangles = triangles.ok_or_else(|| error("there is no element `face`: it is a cloud of points".into()))?;
    Ok(mesh)
}

struct IgnoredRows;

impl<'de> Deserialize<'de> for IgnoredRows {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Rows;
        impl<'de> Visitor<'de> for Rows {
            type Value = IgnoredRows;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("rows")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut rows: A) -> Result<IgnoredRows, A::Error> {
                while rows.next_element::<std::collections::HashMap<String, IgnoredAny>>()?.is_some() {}
                Ok(IgnoredRows)
            }
        }
        deserializer.deserialize_seq(Rows)
    }
}
