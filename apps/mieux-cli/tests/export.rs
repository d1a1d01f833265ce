//! `mieux export` as people meet it.

#![allow(clippy::print_stdout)]

use std::path::Path;
use std::process::{Command, Output};

const FORMATS: [(&str, &str); 9] = [
    ("mitsuba", "skim-milk.xml"),
    ("pbrt", "skim-milk.pbrt"),
    ("cycles", "skim-milk.py"),
    ("materialx", "skim-milk.mtlx"),
    ("openpbr", "skim-milk.openpbr.mtlx"),
    ("gltf", "skim-milk.gltf"),
    ("usd", "skim-milk.usda"),
    ("mdl", "skim_milk.mdl"),
    ("eradiate", "skim-milk.nc"),
];

fn mieux(folder: &Path, words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mieux")).arg("export").args(words).current_dir(folder).output().unwrap()
}

/// Error text with the line breaks of its frame taken out.
fn flat(output: &Output) -> String {
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    let words = stderr.split(|c: char| c.is_whitespace() || "│╰╭─×·".contains(c)).filter(|w| !w.is_empty());
    words.collect::<Vec<_>>().join(" ")
}

#[test]
fn every_format_is_written_and_owns_up_to_its_losses() {
    let folder = tempfile::tempdir().unwrap();
    for (format, file) in FORMATS {
        let output = mieux(
            folder.path(),
            &[
                "skim-milk",
                "--to",
                format,
                "--draft",
                "--wavelengths",
                "400nm:700nm:50nm",
                "--format",
                "json",
                "-o",
                format,
            ],
        );
        assert!(output.status.success(), "{format}: {}", flat(&output));
        let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let written = std::fs::read(folder.path().join(format).join(file)).unwrap();
        let text = String::from_utf8_lossy(&written);
        assert!(text.contains("error of sigma_s' = sigma_s (1 - g): at most"), "{format}: {text}");
        let error = |key: &str| answer[key]["largest"].as_f64().unwrap();
        let reduced = error("relative_error_of_reduced_scattering");
        // Spectra hold the material; three channels cannot.
        let spectral = ["mitsuba", "pbrt", "eradiate"].contains(&format);
        assert!(if spectral { reduced < 2e-3 } else { reduced > 0.02 && reduced < 1.0 }, "{format}: {reduced}");
        println!("{format}: {reduced} {}", error("relative_error_of_sigma_a"));
    }
}

#[test]
fn the_table_shows_units_and_losses_and_csv_both_sides() {
    let folder = tempfile::tempdir().unwrap();
    let words = ["skim-milk", "--to", "pbrt", "--scale", "0.01", "--wavelengths", "400nm:700nm:100nm"];
    let output = mieux(folder.path(), &words);
    assert!(output.status.success(), "{}", flat(&output));
    let shown = String::from_utf8(output.stdout).unwrap();
    for part in
        ["1/m", "one scene unit = 0.01 m", "sigma_s'", "sigma_a", "largest error", "skim-milk.pbrt", "reduced ones"]
    {
        assert!(shown.contains(part), "{part}: {shown}");
    }
    assert!(folder.path().join("out/skim-milk-pbrt/skim-milk-scene.pbrt").is_file());
    let output = mieux(folder.path(), &[&words[..], &["--format", "csv"]].concat());
    let csv = String::from_utf8(output.stdout).unwrap();
    assert!(csv.contains("held_sigma_a_per_m") && csv.lines().filter(|l| !l.starts_with('#')).count() == 5, "{csv}");
}

#[test]
fn what_cannot_be_written_is_said_plainly() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("infrared.toml"),
        "title = \"A suspension\"\nabout = \"The same at every wavelength.\"\n\
         [host]\nrefractive_index = \"1.33\"\n[[inclusion]]\nname = \"spheres\"\nrefractive_index = \"1.5\"\n\
         volume_fraction = 0.01\n[inclusion.size_distribution]\nkind = \"monodisperse\"\nradius = \"200 nm\"\n",
    )
    .unwrap();
    for (words, said) in [
        (&["skim-milk", "--to", "gltf"][..], "--draft"),
        (&["skim-milk", "--to", "renderman"][..], "possible values: mitsuba"),
        (&["water", "--to", "pbrt"][..], "scatters nothing"),
        (&["skim-milk", "--to", "pbrt", "--scale", "-1"][..], "no length"),
        (&["skim-milk", "--to", "pbrt", "--scale", "nan"][..], "no length"),
        (&["infrared.toml", "--to", "mitsuba", "--wavelengths", "500nm,900nm"][..], "900 nm lies outside"),
        (&["skim-milk", "--to", "usd", "--wavelengths", "500nm:600nm:25nm"][..], "what makes red"),
        (&["skim-mlk", "--to", "usd"][..], "skim-milk"),
    ] {
        let output = mieux(folder.path(), words);
        assert_eq!(output.status.code(), Some(2), "{words:?}");
        assert!(flat(&output).contains(said), "{words:?}: {}", flat(&output));
        assert!(!folder.path().join("out").exists(), "{words:?}");
    }
}
