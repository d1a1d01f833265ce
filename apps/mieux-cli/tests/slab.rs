//! `mieux slab` as people meet it.

use std::path::Path;
use std::process::{Command, Output};

fn slab(folder: &Path, words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mieux")).arg("slab").args(words).current_dir(folder).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Error text with the line breaks of its frame taken out.
fn flat(output: &Output) -> String {
    let stderr = text(&output.stderr);
    let words = stderr.split(|c: char| c.is_whitespace() || "│╰╭─×·".contains(c)).filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join(" ")
}

fn json(folder: &Path, words: &[&str]) -> serde_json::Value {
    let output = slab(folder, &[words, &["--format", "json"]].concat());
    assert!(output.status.success(), "{}", flat(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

const VAN_DE_HULST: [&str; 6] = ["--albedo", "0.9", "--g", "0.75", "--tau", "2"];
const KEYS: [&str; 5] =
    ["reflectance", "transmittance", "absorptance", "reflectance_specular", "transmittance_unscattered"];

#[test]
fn an_abstract_slab_has_its_keys_at_the_top() {
    let folder = tempfile::tempdir().unwrap();
    let value = json(folder.path(), &VAN_DE_HULST);
    assert!((value["reflectance"].as_f64().unwrap() - 0.09739464).abs() < 1e-7);
    assert!((value["transmittance"].as_f64().unwrap() - 0.66095770).abs() < 1e-7);
    assert_eq!(value["solver"], "discrete-ordinates");
    assert_eq!(value["streams"], 32);
    // The grey of that reflectance on the sRGB curve: 255 (1.055 0.09739^(1/2.4) - 0.055) = 88.1.
    assert_eq!(value["swatches"][0]["reflected"], "#585858");
    let photons = [&VAN_DE_HULST[..], &["--solver", "monte-carlo", "--photons", "50000", "--seed", "3"]].concat();
    let value = json(folder.path(), &photons);
    for key in KEYS {
        assert!(value[format!("{key}_se")].as_f64().unwrap() >= 0.0, "{key}");
    }
    let deviation = (value["reflectance"].as_f64().unwrap() - 0.09739464) / value["reflectance_se"].as_f64().unwrap();
    assert!(deviation.abs() < 4.0, "{deviation}");
}

#[test]
fn a_material_has_spectra_and_files() {
    let folder = tempfile::tempdir().unwrap();
    let words = ["whole-milk", "--set", "fat=1.5", "--thickness", "1mm,1cm", "-o", "out"];
    let value = json(folder.path(), &words);
    for key in KEYS.iter().chain(&["wavelength_nm", "thickness_m", "optical_thickness"]) {
        assert_eq!(value[key].as_array().unwrap().len(), 34, "{key}");
    }
    assert_eq!((&value["inputs"]["fat"], &value["material"]), (&1.5.into(), &"whole-milk".into()));
    let file = std::fs::read(folder.path().join("out/slab.json")).unwrap();
    assert_eq!(serde_json::from_slice::<serde_json::Value>(&file).unwrap(), value);
    let csv = std::fs::read_to_string(folder.path().join("out/slab.csv")).unwrap();
    assert!(csv.contains("thickness_m,optical_thickness,wavelength_nm,reflectance,transmittance"), "{csv}");
    assert!(csv.contains("# colour of 1 mm: reflected #"), "{csv}");
    assert_eq!(csv.lines().filter(|line| !line.starts_with('#')).count(), 35);
    assert!(std::fs::read_to_string(folder.path().join("out/slab.svg")).unwrap().contains("Whole milk"));
}

/// Into a pipe go words, not colours.
#[test]
fn a_table_names_colours_without_painting_them() {
    let folder = tempfile::tempdir().unwrap();
    let table = text(&slab(folder.path(), &["skim-milk", "--thickness", "1mm,inf", "--wavelengths", "550nm"]).stdout);
    for part in ["Skimmed milk", "32 streams", "reflectance", "half-space", "reflected #", "backing black"] {
        assert!(table.contains(part), "{part}: {table}");
    }
    assert!(!table.contains('\x1b'), "{table}");
}

#[test]
fn compare_is_a_word_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let output = slab(folder.path(), &[&["compare"], &VAN_DE_HULST[..], &["--photons", "20000"]].concat());
    let table = text(&output.stdout);
    for part in ["discrete-ordinates", "monte-carlo", "std errors", "wall", "processors", "64"] {
        assert!(table.contains(part), "{part}: {table} {}", flat(&output));
    }
    let words =
        ["compare", "skim-milk", "--thickness", "1mm", "--wavelengths", "550nm", "--photons", "5000", "-o", "out"];
    let value = json(folder.path(), &words);
    let trials = value["solvers"].as_array().unwrap();
    assert!(trials.len() >= 2);
    for trial in trials {
        assert!(trial["wall_s"].as_f64().unwrap() > 0.0);
        assert_eq!(trial["difference_reflectance"].as_array().unwrap().len(), 1);
        assert_eq!(trial.get("deviation_reflectance").is_some(), trial["solver"] == "monte-carlo");
    }
    assert!(folder.path().join("out/slab-compare.csv").exists());
    let output = slab(folder.path(), &[&["compare"], &VAN_DE_HULST[..], &["--solver", "monte-carlo"]].concat());
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn layers_are_read_and_their_mistakes_shown() {
    let folder = tempfile::tempdir().unwrap();
    let write = |text: &str| std::fs::write(folder.path().join("layers.toml"), text).unwrap();
    write("title = \"Cuvette\"\n[[layer]]\npane = 1.52\n[[layer]]\nmaterial = \"*\"\n[[layer]]\npane = 1.52\n");
    let value = json(folder.path(), &["skim-milk", "--thickness", "1mm", "--layers", "layers.toml"]);
    assert_eq!(value["reflectance"].as_array().unwrap().len(), 17);
    assert_eq!(value["title"], "Cuvette: Skimmed milk");
    write("[[layer]]\nalbedo = 0.9\ng = 0.5\ntau = 1\n[[layer]]\nmaterial = \"skm-milk\"\nthickness = \"1mm\"\n");
    let output = slab(folder.path(), &["--layers", "layers.toml", "-o", "out"]);
    let message = flat(&output);
    assert_eq!(output.status.code(), Some(2));
    assert!(message.contains("line 6, column 12") && message.contains("skim-milk"), "{message}");
    assert!(!folder.path().join("out").exists());
}

/// One clear error each, and nothing written.
#[test]
fn what_makes_no_slab_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("rows.csv"), "angle_deg,phase\n0,1\n90,x\n180,1\n").unwrap();
    std::fs::write(folder.path().join("moments.csv"), "degree,moment\n0,1\n1,0.9\n2,0.1\n").unwrap();
    let hg = |more: &[&'static str]| [&VAN_DE_HULST[..], more].concat();
    let cases: Vec<(Vec<&str>, &str)> = vec![
        (vec![], "a slab of what?"),
        (vec!["whole-milk", "--thickness=-1mm"], "-1mm"),
        (vec!["whole-milk", "--thickness", "1"], "no unit"),
        (vec!["whole-milk"], "how thick"),
        (vec!["whle-milk", "--thickness", "1mm"], "whole-milk"),
        (vec!["whole-milk", "--thickness", "1mm", "--set", "fta=1"], "fat"),
        (vec!["whole-milk", "--thickness", "1mm", "--albedo", "0.9"], "--albedo"),
        (vec!["whole-milk", "--thickness", "1mm", "--tau", "1"], "--tau"),
        (vec!["--thickness", "1mm"], "--thickness"),
        (vec!["--albedo", "1.2", "--g", "0", "--tau", "1"], "albedo = 1.2"),
        (vec!["--albedo", "0.9", "--g", "0"], "--tau"),
        (vec!["--g", "0", "--tau", "1"], "--albedo"),
        (vec!["--albedo", "0.9", "--g", "0", "--tau=-1"], "-1"),
        (vec!["--albedo", "0.9", "--tau", "1"], "g is missing"),
        (vec!["--albedo", "0.9", "--tau", "1", "--phase", "rows.csv"], "line 3, column 4"),
        (vec!["--albedo", "0.9", "--tau", "1", "--phase", "moments.csv"], "0.1 cannot be"),
        (vec!["--albedo", "0.9", "--tau", "1", "--phase", "none.csv"], "none.csv"),
        (hg(&["--phase", "isotropic"]), "g has no meaning"),
        (hg(&["--streams", "31"]), "31 streams"),
        (hg(&["--streams", "0"]), "0 streams"),
        (hg(&["--streams=-2"]), "-2"),
        (hg(&["--photons", "100"]), "photons has no meaning"),
        (hg(&["--solver", "monte-carlo", "--streams", "8"]), "streams has no meaning"),
        (hg(&["--solver", "magic"]), "monte-carlo"),
        (hg(&["--angle", "30", "--diffuse"]), "--diffuse"),
        (hg(&["--angle", "95"]), "angle = 95"),
        (hg(&["--backing", "grey"]), "black"),
        (hg(&["--backing", "1.5"]), "1.5"),
        (hg(&["--index", "0"]), "refractive index 0"),
        (hg(&["--layers", "l.toml"]), "--layers"),
    ];
    for (words, part) in cases {
        let output = slab(folder.path(), &[&words[..], &["-o", "out"]].concat());
        let message = flat(&output);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {message}");
        assert!(message.contains(part), "{words:?}: {message}");
        assert!(output.stdout.is_empty() && !folder.path().join("out").exists(), "{words:?}");
    }
}
