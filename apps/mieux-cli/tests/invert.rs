//! `mieux invert` as people meet it.

#![allow(clippy::print_stdout)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn mieux(folder: &Path, words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mieux")).arg("invert").args(words).current_dir(folder).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Error text with the line breaks of its frame taken out.
fn flat(output: &Output) -> String {
    let stderr = text(&output.stderr);
    stderr
        .split(|c: char| c.is_whitespace() || "│╰╭─×·".contains(c))
        .filter(|w| !w.is_empty())
        .collect::<Vec<_>>()
        .join(" ")
}

fn json(folder: &Path, words: &[&str]) -> serde_json::Value {
    let output = mieux(folder, &[words, &["--format", "json"]].concat());
    assert!(output.status.success(), "{}", flat(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// A reference file; `None` when there is none and nobody insists.
fn shared(name: &str) -> Option<PathBuf> {
    let folder = std::env::var("MIEUX_SHARED")
        .map_or_else(|_| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared"), PathBuf::from);
    let file = folder.join("data/transfer").join(name);
    if file.is_file() {
        return Some(file.canonicalize().unwrap());
    }
    assert!(
        std::env::var("MIEUX_REQUIRE_SHARED").is_ok_and(|v| v != "1") || std::env::var("MIEUX_REQUIRE_SHARED").is_err(),
        "{} is missing",
        file.display()
    );
    None
}

const HEAD: &str = "IAD1\n1.4 1.5 1.0 1.0 2.0 0.99\n0\n203.2 25.4 12.7 12.7 0.96\n203.2 25.4 12.7 12.7 0.96\n";

#[test]
fn one_slab_from_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let words = ["--reflectance", "0.4", "--transmittance", "0.1", "--unscattered", "0.002", "--thickness", "2mm"];
    let found = json(folder.path(), &words);
    // The published answer (0.4346, 3.9791, 0.3116) is for 1 mm.
    for (key, value) in [("mu_a_per_mm", 0.4346 / 2.0), ("mu_s_reduced_per_mm", 3.9791 / 2.0), ("g", 0.3116)] {
        let ours = found[key][0].as_f64().unwrap();
        assert!((ours / value - 1.0).abs() < 1e-3, "{key}: {ours}");
    }
    assert!(found["mu_a_error_per_mm"][0].as_f64().unwrap() > 0.0 && found["g_error"][0].as_f64().unwrap() > 0.0);
    assert_eq!((found["flag"][0].as_f64(), &found["remarks"][0]), (Some(0.0), &serde_json::Value::Null));
    let table = text(&mieux(folder.path(), &["--reflectance", "0.4", "--index", "1.4", "--g", "0.9"]).stdout);
    assert!(table.contains("mu_a") && table.contains("units of the reduced scattering"), "{table}");
    let nearest = text(&mieux(folder.path(), &["--reflectance", "0.7", "--transmittance", "0.4"]).stdout);
    assert!(nearest.contains("this slab: reflectance and transmittance add up to 1.1"), "{nearest}");
}

/// Every wavelength of every file has an answer, and only what cannot be is flagged.
#[test]
fn published_files_invert_at_every_wavelength() {
    let folder = tempfile::tempdir().unwrap();
    for (name, rows) in
        [("iad_basic_A.rxt", 5), ("iad_newton.rxt", 6), ("iad_sample_A.rxt", 21), ("iad_uterus.rxt", 251)]
    {
        let Some(file) = shared(name) else { return };
        let found = json(folder.path(), &[file.to_str().unwrap()]);
        let of = |key: &str| found[key].as_array().unwrap().clone();
        let flags: Vec<f64> = of("flag").iter().map(|v| v.as_f64().unwrap()).collect();
        println!("{name}: {} rows, {} flagged", flags.len(), flags.iter().filter(|f| **f > 0.0).count());
        assert!(flags.len() == rows && flags.iter().all(|flag| *flag < 2.0), "{name}: {flags:?} {:?}", of("remarks"));
        assert!(of("mu_a_per_mm").iter().all(|v| v.as_f64().is_some_and(|v| v >= 0.0)), "{name}");
    }
}

/// The remarks of `iad_basic_A.rxt` say what its reflectances were computed with (32 points): the reduced scattering is 1/mm,
/// the absorption this. (They are those of slabs without end, as a reflectance alone is taken.)
#[test]
fn computed_slabs_lead_back_to_what_they_were_computed_with() {
    let folder = tempfile::tempdir().unwrap();
    let Some(file) = shared("iad_basic_A.rxt") else { return };
    let found = json(folder.path(), &[file.to_str().unwrap(), "--streams", "64"]);
    for (i, absorption) in [0.1, 0.3, 0.5, 0.7, 0.9].into_iter().enumerate() {
        let ours = found["mu_a_per_mm"][i].as_f64().unwrap();
        println!("{ours} for {absorption}");
        assert!((ours / absorption - 1.0).abs() < 1e-3, "{ours} for {absorption}");
        assert!((found["mu_s_reduced_per_mm"][i].as_f64().unwrap() - 1.0).abs() < 1e-9);
    }
}

#[test]
fn files_are_written_and_plotted() {
    let folder = tempfile::tempdir().unwrap();
    let rows = "L r t\n500 0.3 0.2\n510 0.31 0.2\n520 0.32 0.9\n530 -0.1 0.2\n";
    std::fs::write(folder.path().join("a.rxt"), format!("{HEAD}{rows}")).unwrap();
    let output = mieux(folder.path(), &["a.rxt", "--g", "0.8", "-o", "out"]);
    assert!(output.status.success(), "{}", flat(&output));
    let shown = text(&output.stdout);
    assert!(shown.contains("row 3 (line 9): reflectance and transmittance add up to 1.22"), "{shown}");
    assert!(shown.contains("row 4 (line 10): the reflectance -0.1 is not a share"), "{shown}");
    let csv = std::fs::read_to_string(folder.path().join("out/inversion.csv")).unwrap();
    assert!(csv.contains("wavelength_nm,mu_a_per_mm,mu_a_error_per_mm"), "{csv}");
    let svg = std::fs::read_to_string(folder.path().join("out/inversion.svg")).unwrap();
    assert!(svg.contains("Wavelength (nm)") && !svg.contains("NaN"));
    assert!(folder.path().join("out/inversion.json").is_file());
}

#[test]
fn what_is_wrong_is_said_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, body: &str| std::fs::write(folder.path().join(name), body).unwrap();
    write("count.rxt", &format!("{HEAD}2\n500 0.3 0.2\n510 0.3 0.2 0.1 0.4\n"));
    write("sphere.rxt", &format!("{}2\n500 0.3 0.2\n", HEAD.replace("\n0\n", "\n1\n")));
    let refused = |words: &[&str], part: &str| {
        let output = mieux(folder.path(), words);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {}", flat(&output));
        assert!(flat(&output).contains(part), "{words:?}: {}", flat(&output));
    };
    refused(&["count.rxt", "-o", "out"], "line 8, column 1: the row has 5 numbers, not 2 (or 3 with a wavelength)");
    refused(&["sphere.rxt"], "--corrected");
    assert!(mieux(folder.path(), &["sphere.rxt", "--corrected"]).status.success());
    refused(&["none.rxt"], "cannot be read");
    refused(&[], "FILE");
    refused(&["count.rxt", "--reflectance", "0.4"], "cannot be used with");
    refused(&["--transmittance", "0.4"], "measure the total reflectance as well");
    refused(&["--reflectance", "1.4"], "not a share between 0 and 1");
    refused(&["--reflectance", "0.4", "--index", "0"], "refractive index 0");
    refused(&["--reflectance", "0.4", "--g", "1"], "g = 1");
    refused(&["--reflectance", "0.4", "--streams", "7"], "even number");
    refused(&["--reflectance", "0.4", "--error=-1"], "standard error");
    refused(&["--reflectance", "0.4", "--thickness", "0mm"], "more than zero");
    assert!(!folder.path().join("out").exists());
}
