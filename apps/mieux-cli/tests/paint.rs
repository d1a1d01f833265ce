//! `mieux paint` as people meet it.

use std::path::Path;
use std::process::{Command, Output};

fn mieux(folder: &Path, words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mieux")).args(words).current_dir(folder).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// Error text with the line breaks of its frame taken out.
fn flat(output: &Output) -> String {
    let stderr = text(&output.stderr);
    let words = stderr.split(|c: char| c.is_whitespace() || "│╰╭─×·".contains(c));
    words.filter(|w| !w.is_empty()).collect::<Vec<_>>().join(" ")
}

/// K and S of a made-up paint at a wavelength in nm.
fn paint(name: &str, nm: f64) -> (f64, f64) {
    let step = |at: f64| 1.0 / (1.0 + ((nm - at) / 15.0).exp());
    match name {
        "white" => (0.003, 1.0),
        "yellow" => (0.01 + 1.5 * step(490.0), 0.4),
        _ => (0.05 + 2.0 * (1.0 - step(560.0)), 0.15),
    }
}

/// Opaque, without surface.
fn reflectance(recipe: &[(&str, f64)], nm: f64) -> f64 {
    let total: f64 = recipe.iter().map(|part| part.1).sum();
    let (k, s) = recipe.iter().fold((0.0, 0.0), |(k, s), (name, amount)| {
        let (of_k, of_s) = paint(name, nm);
        (k + amount / total * of_k, s + amount / total * of_s)
    });
    1.0 + k / s - ((k / s) * (k / s + 2.0)).sqrt()
}

const HEADERS: [&str; 5] = ["white", "yellow", "deep blue", "white:0.7+yellow:0.3", "white:3+deep blue:1"];

fn parts(header: &str) -> Vec<(&str, f64)> {
    header
        .split('+')
        .map(|part| part.split_once(':').map_or((part, 1.0), |(name, amount)| (name, amount.parse().unwrap())))
        .collect()
}

/// A file of measurements, and the paints fitted to it in `out/paints.toml`.
fn fitted(folder: &Path) -> Output {
    let mut csv = format!("wavelength_nm,{}\n", HEADERS.join(","));
    for nm in (400..=700).step_by(10) {
        let values: Vec<String> =
            HEADERS.iter().map(|header| reflectance(&parts(header), f64::from(nm)).to_string()).collect();
        csv += &format!("{nm},{}\n", values.join(","));
    }
    std::fs::write(folder.join("m.csv"), csv).unwrap();
    // A binder of index 1 has no surface.
    mieux(folder, &["paint", "fit", "m.csv", "--index", "1", "--reference-hides", "100um", "-o", "out"])
}

#[test]
fn paints_are_fitted_mixed_and_matched() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let fit = fitted(path);
    let table = text(&fit.stdout);
    assert!(fit.status.success(), "{}", text(&fit.stderr));
    for part in ["mean, fitted", "white:0.7+yellow:0.3", "relative to S of white, which is", "paints.toml"] {
        assert!(table.contains(part), "{table}");
    }
    for file in ["paints.toml", "residuals.csv", "coefficients.svg", "swatches.svg"] {
        assert!(path.join("out").join(file).exists(), "{file}");
    }
    let residuals = std::fs::read_to_string(path.join("out/residuals.csv")).unwrap();
    assert_eq!(residuals.lines().count(), 6);

    // A mixture that was not measured.
    let words = ["paint", "mix", "yellow=0.5", "deep blue=0.5", "--paints", "out/paints.toml", "--format", "json"];
    let json: serde_json::Value = serde_json::from_slice(&mieux(path, &words).stdout).unwrap();
    for (nm, value) in json["wavelength_nm"].as_array().unwrap().iter().zip(json["reflectance"].as_array().unwrap()) {
        let expected = reflectance(&[("yellow", 0.5), ("deep blue", 0.5)], nm.as_f64().unwrap());
        assert!((value.as_f64().unwrap() - expected).abs() < 0.02, "{nm}: {value} for {expected}");
    }
    assert!(json["srgb"].as_str().unwrap().starts_with('#') && json["hiding_thickness_m"].as_f64().unwrap() > 1e-6);

    // Its colour is found again, and the recipe with it.
    let lab: Vec<String> = json["lab"].as_array().unwrap().iter().map(ToString::to_string).collect();
    let target = format!("lab:{}", lab.join(","));
    let words = ["paint", "match", &target, "--paints", "out/paints.toml", "--at-most", "2", "--format", "json"];
    let json: serde_json::Value = serde_json::from_slice(&mieux(path, &words).stdout).unwrap();
    assert!(json["ciede2000"].as_f64().unwrap() < 0.1, "{json}");
    assert!((json["recipe"]["yellow"].as_f64().unwrap() - 0.5).abs() < 0.02, "{json}");
    let table = text(&mieux(path, &["paint", "match", "#808040", "--paints", "out/paints.toml"]).stdout);
    assert!(table.contains("CIEDE2000") && table.contains("% yellow") && !table.contains('\x1b'), "{table}");
}

#[test]
fn films_are_thin_or_opaque() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    assert!(fitted(path).status.success());
    let mix = |words: &[&str]| {
        let all = [&["paint", "mix", "white=1", "--paints", "out/paints.toml", "--format", "json"][..], words].concat();
        let output = mieux(path, &all);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        json["lab"][0].as_f64().unwrap()
    };
    let (opaque, black, white) =
        (mix(&[]), mix(&["--thickness", "10um"]), mix(&["--thickness", "10um", "--backing", "white"]));
    assert!(black < white && white < opaque, "{black} {white} {opaque}");
    // At 100 um it hides, as was said: over black it is 98 % as bright as over white.
    let (black, white) = (mix(&["--thickness", "100um"]), mix(&["--thickness", "100um", "--backing", "white"]));
    let luminance = |l: f64| ((l + 16.0) / 116.0).powi(3);
    assert!((luminance(black) / luminance(white) - 0.98).abs() < 1e-4);
}

#[test]
fn mistakes_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    assert!(fitted(path).status.success());
    std::fs::write(path.join("percent.csv"), "wavelength_nm,white\n400,90\n").unwrap();
    std::fs::write(path.join("dark.csv"), "wavelength_nm,black\n400,0.01\n").unwrap();
    std::fs::write(path.join("broken.json"), "[{\"type\": \"wavelengths\", \"value\": [400]}]").unwrap();
    let paints = ["--paints", "out/paints.toml"];
    for (words, expected) in [
        (
            &["paint", "fit", "percent.csv"][..],
            "percent.csv, line 2, column 2: the reflectance 90 is not between 0 and 1",
        ),
        (&["paint", "fit", "broken.json"], "unknown field `value`"),
        (&["paint", "fit", "missing.csv"], "cannot be read"),
        (
            &["paint", "fit", "dark.csv", "--specular", "1"],
            "sample `black` at 400 nm: the reflectance 0.01 is not above the 0.04",
        ),
        (&["paint", "fit", "m.csv", "--reference", "grey"], "no paint called `grey`"),
        (&["paint", "fit", "m.csv", "--index", "0.5"], "the refractive index 0.5 is not between 1 and 10"),
        (&["paint", "mix", "deep=1"], "did you mean `deep blue`?"),
        (&["paint", "mix", "white=-1"], "the amount -1 of `white`"),
        (&["paint", "mix", "white"], "`white` is no part of a recipe"),
        (&["paint", "mix", "white=1", "--thickness", "50"], "has no unit"),
        (&["paint", "mix", "white=1", "--backing", "white"], "--thickness"),
        (&["paint", "match", "#12345"], "a colour is as `#c04030`"),
        (&["paint", "match", "nowhere.csv"], "`nowhere.csv` cannot be read"),
        (&["paint", "match", "#123456", "--at-most", "9"], "9 is not in 1..=6"),
    ] {
        let words = if words[1] == "fit" { words.to_vec() } else { [words, &paints].concat() };
        let output = mieux(path, &words);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {}", text(&output.stderr));
        assert!(flat(&output).contains(expected), "{words:?}: {}", flat(&output));
    }
    // Without a unit there is no thickness.
    assert!(mieux(path, &["paint", "fit", "m.csv", "--index", "1", "-o", "plain"]).status.success());
    let output = mieux(path, &["paint", "mix", "white=1", "--thickness", "50um", "--paints", "plain/paints.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(flat(&output).contains("--reference-hides"), "{}", flat(&output));
}
