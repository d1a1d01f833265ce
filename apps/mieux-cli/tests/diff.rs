//! `mieux diff` as people meet it: pictures of one thing, of two things, and what are no pictures.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output};

use mieux::io::image::write_exr_channels;

fn mieux(folder: &Path, words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mieux")).args(words).current_dir(folder).output().unwrap()
}

fn render(folder: &Path, subject: &str, seed: &str, out: &str) {
    let words = ["render", subject, "--size", "40x36", "--spp", "32", "--seed", seed, "-o", out];
    let output = mieux(folder, &words);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn noise_agrees_water_differs_and_the_same_samples_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    render(folder, "whole-milk", "1", "a");
    render(folder, "whole-milk", "2", "b");
    render(folder, "water", "3", "c");
    let diff = |first: &str, second: &str, more: &[&str]| {
        let [first, second] = [first, second].map(|name| format!("{name}/picture.exr"));
        let output = mieux(folder, &[&["diff", &first, &second], more].concat());
        (output.status.code().unwrap(), String::from_utf8(output.stdout).unwrap())
    };
    let (code, text) = diff("a", "b", &["-o", "map"]);
    assert!(code == 0 && text.contains("agree within their noise") && text.contains("difference.png"), "{code} {text}");
    for file in ["difference.png", "difference.exr", "blocks.csv"] {
        assert!(folder.join("map").join(file).is_file(), "{file}");
    }
    let blocks = std::fs::read_to_string(folder.join("map/blocks.csv")).unwrap();
    assert_eq!(blocks.lines().count(), 1 + 3 * 3);
    assert!(blocks.contains("\n32,32,8,4,32,"), "{blocks}");
    let (code, text) = diff("a", "c", &["--format", "json"]);
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert!(
        code == 3 && json["verdict"] == "differ" && json["bias"][0].as_f64().unwrap().abs() > 0.01,
        "{code} {text}"
    );
    assert_eq!(diff("a", "a", &[]).0, 4);
}

#[test]
fn what_cannot_be_compared_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let write = |name: &str, width: u32, variance: Option<f32>| {
        let mut channels = BTreeMap::new();
        for c in ["R", "G", "B"] {
            channels.insert(c.to_owned(), vec![0.5; 16 * width as usize]);
            variance.map(|v| channels.insert(format!("variance.{c}"), vec![v; 16 * width as usize]));
        }
        write_exr_channels(&folder.join(name), width, 16, channels, "").unwrap();
    };
    write("a.exr", 16, Some(1e-4));
    write("wide.exr", 17, Some(1e-4));
    write("bare.exr", 16, None);
    write("few.exr", 16, Some(f32::INFINITY));
    std::fs::write(folder.join("text.exr"), "no picture").unwrap();
    for (other, parts) in [
        ("wide.exr", ["16x16", "17x16"]),
        ("bare.exr", ["variance.R", "mieux render"]),
        ("few.exr", ["eight", "samples"]),
        ("text.exr", ["text.exr", "OpenEXR"]),
        ("none.exr", ["none.exr", "cannot be read"]),
    ] {
        let output = mieux(folder, &["diff", "a.exr", other, "-o", "out"]);
        let error: String = String::from_utf8(output.stderr).unwrap().split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(matches!(output.status.code(), Some(1 | 2)), "{other}: {error}");
        assert!(parts.iter().all(|part| error.contains(part)), "{other}: {error}");
        assert!(!folder.join("out").exists(), "{other}");
    }
}
