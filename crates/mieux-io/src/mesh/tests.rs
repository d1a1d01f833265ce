use std::io::Write;
use std::path::PathBuf;

use proptest::prelude::*;

use super::*;

/// Writes a file of that name into a folder that goes with it.
fn file(name: &str, bytes: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::File::create(&path).unwrap().write_all(bytes).unwrap();
    (folder, path)
}

fn read(name: &str, bytes: &[u8]) -> Result<(TriangleMesh, MeshReport), MeshError> {
    let (_folder, path) = file(name, bytes);
    read_mesh(&path)
}

const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// Counterclockwise from outside.
const FACES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn ply_text(faces: &[[u32; 3]]) -> String {
    let mut text = String::from("ply\nformat ascii 1.0\ncomment a tetrahedron\nelement vertex 4\n");
    text += "property float x\nproperty float y\nproperty float z\nproperty uchar red\n";
    text += &format!("element face {}\nproperty list uchar int vertex_indices\nend_header\n", faces.len());
    for [x, y, z] in CORNERS {
        text += &format!("{x} {y} {z} 7\n");
    }
    for [a, b, c] in faces {
        text += &format!("3 {a} {b} {c}\n");
    }
    text
}

fn ply_bytes(big: bool) -> Vec<u8> {
    let order = if big { "big" } else { "little" };
    let mut bytes = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty double z\n\
         element face 4\nproperty list uchar uint vertex_index\nend_header\n"
    )
    .into_bytes();
    for [x, y, z] in CORNERS {
        for c in [x, y] {
            bytes.extend(if big { c.to_be_bytes() } else { c.to_le_bytes() });
        }
        bytes.extend(if big { f64::from(z).to_be_bytes() } else { f64::from(z).to_le_bytes() });
    }
    for face in FACES {
        bytes.push(3);
        for i in face {
            bytes.extend(if big { i.to_be_bytes() } else { i.to_le_bytes() });
        }
    }
    bytes
}

fn gltf_text() -> String {
    let mut buffer = Vec::new();
    CORNERS.iter().flatten().for_each(|c| buffer.extend(c.to_le_bytes()));
    FACES.iter().flatten().for_each(|&i| buffer.extend((i as u16).to_le_bytes()));
    let data = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, &buffer);
    serde_json::json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"children": [1], "translation": [10.0, 0.0, 0.0]}, {"mesh": 0, "scale": [2.0, 2.0, -2.0]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
        "buffers": [{"byteLength": 72, "uri": format!("data:application/octet-stream;base64,{data}")}]
    })
    .to_string()
}

fn obj_text() -> String {
    let mut text = String::from("mtllib none.mtl\no one\n");
    CORNERS.iter().for_each(|[x, y, z]| text += &format!("v {x} {y} {z}\n"));
    text += "usemtl x\n";
    FACES.iter().for_each(|[a, b, c]| text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1));
    text
}

fn volume(mesh: &TriangleMesh) -> f64 {
    let six = |&t: &[u32; 3]| {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize].map(f64::from));
        crate::scene::transform::dot(a, cross(b, c))
    };
    mesh.triangles.iter().map(six).sum::<f64>() / 6.0
}

#[test]
fn one_tetrahedron_reads_alike_from_all_formats() {
    let files = [
        ("a.ply", ply_text(&FACES).into_bytes(), 1.0),
        ("b.PLY", ply_bytes(false), 1.0),
        ("c.ply", ply_bytes(true), 1.0),
        ("d.obj", obj_text().into_bytes(), 1.0),
        // Mirrored, and yet its outside is outside.
        ("e.gltf", gltf_text().into_bytes(), 8.0),
    ];
    for (name, bytes, grown) in files {
        let (mesh, report) = read(name, &bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!((mesh.positions.len(), mesh.triangles.len(), report.flat), (4, 4, 0), "{name}");
        assert!(report.topology.is_closed(), "{name}: {report:?}");
        assert!((volume(&mesh) - grown / 6.0).abs() < 1e-5, "{name}: {}", volume(&mesh));
    }
}

#[test]
fn parts_of_a_mirrored_node_stand_where_the_node_does() {
    let (mesh, _) = read("e.gltf", gltf_text().as_bytes()).unwrap();
    assert_eq!(mesh.positions[3], [10.0, 0.0, -2.0]);
    assert_eq!(mesh.positions[1], [12.0, 0.0, 0.0]);
}

#[test]
fn open_turned_and_crowded_surfaces_are_told_apart() {
    let topology = |faces: &[[u32; 3]]| read("t.ply", ply_text(faces).as_bytes()).unwrap().1.topology;
    assert_eq!(topology(&FACES[..3]).boundary_edges, 3);
    let mut turned = FACES;
    turned[3].swap(0, 1);
    assert_eq!(topology(&turned).turned_edges, 3);
    let crowded = [FACES.as_slice(), &FACES[..1]].concat();
    assert_eq!(topology(&crowded).crowded_edges, 3);
    assert!(!topology(&crowded).is_closed());
}

#[test]
fn vertices_at_one_place_are_welded() {
    let mut text = String::new();
    for face in FACES {
        face.iter().for_each(|&i| text += &format!("v {:?}\n", CORNERS[i as usize]).replace(['[', ']', ','], ""));
    }
    (0..4).for_each(|n| text += &format!("f {} {} {}\n", 3 * n + 1, 3 * n + 2, 3 * n + 3));
    let (mesh, report) = read("soup.obj", text.as_bytes()).unwrap();
    assert_eq!(mesh.positions.len(), 12);
    assert!(report.topology.is_closed());
    assert_eq!(report.topology.vertices, 4);
}

#[test]
fn flat_triangles_are_left_out_and_counted() {
    let faces = [FACES.as_slice(), &[[1, 1, 2]]].concat();
    let (mesh, report) = read("f.ply", ply_text(&faces).as_bytes()).unwrap();
    assert_eq!((mesh.triangles.len(), report.flat), (4, 1));
    assert!(report.topology.is_closed());
    let error = read("f.ply", ply_text(&[[1, 1, 2]]).as_bytes()).unwrap_err();
    assert!(matches!(error, MeshError::Empty { read: 1, .. }), "{error}");
}

#[test]
fn bad_elements_are_named() {
    let says = |name: &str, text: &str, words: &[&str]| {
        let error = read(name, text.as_bytes()).unwrap_err().to_string();
        words.iter().for_each(|w| assert!(error.contains(w), "`{error}` does not say `{w}`"));
    };
    says("n.ply", &ply_text(&FACES).replace("0 1 0 7", "0 nan 0 7"), &["n.ply", "vertex 2", "finite"]);
    says("n.ply", &ply_text(&[[0, 1, 2], [0, 1, 9]]), &["triangle 1", "vertex 9", "4 vertices"]);
    says("n.ply", &ply_text(&FACES).replace("3 0 1 3", "3 0 -1 3"), &["face 1", "vertex -1"]);
    says("n.ply", &ply_text(&FACES).replace("0 0 1 7\n", ""), &["n.ply"]);
    says("n.ply", "ply\nformat ascii 1.0\nelement vertex 0\nend_header\n", &["no element `face`"]);
    says("n.obj", "v 0 0 0\nv 1 0 0\nf 1 2 3\n", &["n.obj", "face vertex index out of bounds"]);
    says("n.stl", "solid", &["n.stl", ".ply, .obj, .gltf, .glb"]);
    says("n.gltf", &gltf_text().replace("\"count\":4", "\"count\":400000000"), &["accessor 0", "beyond its buffer"]);
    let outside = gltf_text().replace("data:application/octet-stream;base64,", "../../secret");
    says("n.gltf", &outside, &["not a file beside"]);
}

#[test]
fn a_declared_size_without_the_bytes_costs_nothing() {
    for count in ["4000000000", "18446744073709551615"] {
        let text = ply_text(&FACES).replace("element vertex 4", &format!("element vertex {count}"));
        assert!(read("huge.ply", text.as_bytes()).is_err());
        let mut bytes = ply_bytes(false);
        let at = bytes.windows(8).position(|w| w == b"vertex 4").unwrap();
        bytes.splice(at + 7..at + 8, count.bytes());
        assert!(read("huge.ply", &bytes).is_err());
    }
}

proptest! {
    #[test]
    fn damaged_files_end_in_an_answer(
        which in 0..5_usize, at in 0.0..1.0_f64, byte: u8, kind in 0..3_u8, more in 0.0..1.0_f64,
    ) {
        let (name, mut bytes) = [
            ("a.ply", ply_text(&FACES).into_bytes()),
            ("b.ply", ply_bytes(false)),
            ("c.ply", ply_bytes(true)),
            ("d.obj", obj_text().into_bytes()),
            ("e.gltf", gltf_text().into_bytes()),
        ][which].clone();
        crate::testing::damage(&mut bytes, at, byte, kind, more);
        if let Ok((mesh, _)) = read(name, &bytes) {
            prop_assert!(mesh.positions.iter().flatten().all(|c| c.is_finite()));
            prop_assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < mesh.positions.len()));
        }
    }
}
