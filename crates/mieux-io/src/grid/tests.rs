use std::io::Write;

use proptest::prelude::*;

use super::*;
use crate::scene::Transform;

const VALUES: [f32; 12] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0];

fn read(files: &[(&str, Vec<u8>)]) -> Result<Grid, GridError> {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    read_grid(&folder.path().join(files[0].0))
}

fn vol() -> Vec<u8> {
    let mut bytes = b"VOL\x03".to_vec();
    [1, 2, 3, 2, 1].iter().for_each(|w: &i32| bytes.extend(w.to_le_bytes()));
    [0.0, 0.0, -1.0, 2.0, 3.0, 1.0_f32].iter().for_each(|c| bytes.extend(c.to_le_bytes()));
    VALUES.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
    bytes
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut out = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    out.write_all(bytes).unwrap();
    out.finish().unwrap()
}

fn nrrd(kind: &str, encoding: &str, endian: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = format!(
        "NRRD0004\n# a comment\ntype: {kind}\ndimension: 3\nsizes: 2 3 2\nencoding: {encoding}\nendian: {endian}\n\
         key:=value\nspacings: 1 2 4\nspace units: \"mm\" \"mm\" \"mm\"\n\n"
    )
    .into_bytes();
    bytes.extend(data);
    bytes
}

fn nrrds() -> Vec<Vec<u8>> {
    let little: Vec<u8> = VALUES.iter().flat_map(|v| v.to_le_bytes()).collect();
    let big: Vec<u8> = VALUES.iter().flat_map(|v| f64::from(*v).to_be_bytes()).collect();
    let short: Vec<u8> = VALUES.iter().flat_map(|v| (*v as u16).to_be_bytes()).collect();
    let bytes: Vec<u8> = VALUES.iter().map(|v| *v as u8).collect();
    vec![
        nrrd("float", "raw", "little", &little),
        nrrd("double", "gzip", "big", &gzip(&big)),
        nrrd("unsigned short", "raw", "big", &short),
        nrrd("uchar", "raw", "little", &bytes),
        nrrd("float", "ascii", "little", b"0 1 2 3\n4 5, 6 7 8 9 1e1 11"),
    ]
}

fn own(change: impl Fn(String) -> String) -> Vec<(&'static str, Vec<u8>)> {
    let head = "data = \"g.raw\"\ndims = [2, 3, 2]\ntype = \"i16\"\nendian = \"big\"\ncompression = \"gzip\"\n\
                size = [\"2 cm\", \"1m\", \"4 mm\"]\norigin = [\"-1 cm\", \"0 m\", \"3 m\"]\n";
    let data: Vec<u8> = VALUES.iter().flat_map(|v| (*v as i16).to_be_bytes()).collect();
    vec![("g.toml", change(head.into()).into_bytes()), ("g.raw", gzip(&data))]
}

#[test]
fn one_grid_reads_alike_from_all_formats() {
    for (n, bytes) in nrrds().into_iter().enumerate() {
        let grid = read(&[("g.nrrd", bytes)]).unwrap_or_else(|e| panic!("{n}: {e}"));
        assert_eq!((grid.dims, grid.values.as_slice()), ([2, 3, 2], VALUES.as_slice()), "{n}");
        let far = grid.to_world.point([1.0; 3]);
        for (found, expected) in far.iter().zip([2e-3, 6e-3, 8e-3]) {
            assert!((found - expected).abs() < 1e-15, "{far:?}");
        }
    }
    let grid = read(&[("g.vol", vol())]).unwrap();
    assert_eq!((grid.dims, grid.values.as_slice()), ([2, 3, 2], VALUES.as_slice()));
    assert_eq!((grid.to_world.point([0.0; 3]), grid.to_world.point([1.0; 3])), ([0.0, 0.0, -1.0], [2.0, 3.0, 1.0]));
    let grid = read(&own(|t| t)).unwrap();
    assert_eq!((grid.dims, grid.values.as_slice()), ([2, 3, 2], VALUES.as_slice()));
    assert_eq!(grid.to_world.point([0.0; 3]), [-0.01, 0.0, 3.0]);
    assert_eq!(grid.to_world.vector([1.0; 3]), [0.02, 1.0, 0.004]);
}

#[test]
fn samples_with_an_origin_stand_in_the_middles_of_cells() {
    let text = String::from_utf8(nrrds().pop().unwrap()).unwrap();
    let text = text.replace("spacings: 1 2 4", "space directions: (0,1,0) (2,0,0) (0,0,4)\nspace origin: (10,20,30)");
    let grid = read(&[("g.nrrd", text.into_bytes())]).unwrap();
    let first = grid.to_world.point([0.25, 1.0 / 6.0, 0.25]);
    for (found, expected) in first.iter().zip([0.01, 0.02, 0.03]) {
        assert!((found - expected).abs() < 1e-15, "{first:?}");
    }
}

#[test]
fn what_is_wrong_is_said() {
    let says = |files: &[(&str, Vec<u8>)], word: &str| {
        let error = read(files).unwrap_err().to_string();
        assert!(error.contains(word), "`{error}` does not say `{word}`");
    };
    says(&[("g.nrrd", nrrds()[0][..180].to_vec())], "fewer than its 12 values");
    says(&[("g.nrrd", nrrd("float", "raw", "little", &[0xff; 48]))], "not finite");
    says(&[("g.nrrd", nrrd("block", "raw", "little", b""))], "`block`");
    let mut huge = vol();
    huge[8..20].copy_from_slice(&[0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff, 0x7f]);
    says(&[("g.vol", huge)], "2147483647 x 2147483647");
    // Within the limit, and yet not there.
    let mut large = vol();
    large[8..20].copy_from_slice(&[0, 2, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0]);
    says(&[("g.vol", large)], "fewer than its 134217728 values");
    says(&own(|t| t.replace("\"1m\"", "\"1\"")), "g.toml, line 6");
    says(&own(|t| t.replace("g.raw", "../g.raw")), "beside the header");
    says(&own(|t| t.replace("endian", "endain")), "line 4");
    says(&[("g.vdb", Vec::new())], ".nrrd, .vol, .toml");
    assert_eq!(read(&[("g.vol", vol())]).unwrap().to_world.determinant(), 12.0);
    assert_eq!(Transform::default(), Transform::IDENTITY);
}

proptest! {
    #[test]
    fn damaged_files_end_in_an_answer(
        which in 0..7_usize, at in 0.0..1.0_f64, byte: u8, kind in 0..3_u8, more in 0.0..1.0_f64, head: bool,
    ) {
        let mut files: Vec<(&str, Vec<u8>)> = match which {
            0..5 => vec![("g.nrrd", nrrds().swap_remove(which))],
            5 => vec![("g.vol", vol())],
            _ => own(|t| t),
        };
        let which = if head { 0 } else { files.len() - 1 };
        crate::testing::damage(&mut files[which].1, at, byte, kind, more);
        if let Ok(grid) = read(&files) {
            prop_assert_eq!(grid.values.len(), grid.dims.iter().product::<usize>());
            prop_assert!(grid.values.iter().all(|v| v.is_finite()));
        }
    }
}
