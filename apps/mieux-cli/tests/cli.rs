//! The program as people meet it.

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
    stderr
        .split(|c: char| c.is_whitespace() || "│╰╭─×·".contains(c))
        .filter(|w| !w.is_empty())
        .collect::<Vec<_>>()
        .join(" ")
}

/// Names of everything in a folder.
fn listing(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        folder.read_dir().unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn materials_and_scenes_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    let materials = text(&mieux(folder.path(), &["materials"]).stdout);
    for name in ["whole-milk", "skim-milk", "low-fat-milk", "water", "fat", "wt.-%", "0 to 60"] {
        assert!(materials.contains(name), "{materials}");
    }
    let scenes = text(&mieux(folder.path(), &["scenes"]).stdout);
    assert!(scenes.contains("milk-components") && scenes.contains("560x210"), "{scenes}");
}

#[test]
fn optics_prints_json_csv_and_a_table() {
    let folder = tempfile::tempdir().unwrap();
    let words = ["optics", "whole-milk", "--set", "fat=1.5", "--wavelengths", "400nm:700nm:25nm", "--format"];
    let json = mieux(folder.path(), &[&words[..], &["json"]].concat());
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(json["material"], "whole-milk");
    assert_eq!(json["inputs"]["fat"], 1.5);
    for key in ["wavelength_nm", "sigma_s_per_m", "sigma_a_per_m", "sigma_t_per_m", "g", "n_real", "n_imag"] {
        assert_eq!(json[key].as_array().unwrap().len(), 13, "{key}");
    }
    let sum = json["sigma_s_per_m"][6].as_f64().unwrap() + json["sigma_a_per_m"][6].as_f64().unwrap();
    assert!((json["sigma_t_per_m"][6].as_f64().unwrap() / sum - 1.0).abs() < 1e-12);

    let csv = text(&mieux(folder.path(), &[&words[..], &["csv"]].concat()).stdout);
    assert!(csv.contains("wavelength_nm,sigma_s_per_m,sigma_a_per_m"), "{csv}");
    let table = text(&mieux(folder.path(), &[&words[..], &["table"]].concat()).stdout);
    assert!(table.contains("Whole milk") && table.contains("per_m"), "{table}");
    assert!(listing(folder.path()).is_empty());

    let written = mieux(folder.path(), &["optics", "water", "-o", "made/here"]);
    assert!(written.status.success());
    assert_eq!(listing(&folder.path().join("made/here")), ["optics.csv", "optics.json", "optics.svg"]);
}

#[test]
fn a_render_writes_its_files_and_is_the_same_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let render = |out: &str, threads: &str| {
        let words =
            ["render", "water", "--size", "40x30", "--spp", "2", "--seed", "7", "--threads", threads, "-o", out];
        let output = mieux(folder.path(), &words);
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let summary = render("a", "1");
    for part in ["Pure water", "sigma_s'", "sigma_a", "mean free path", "2 samples per pixel", "relative error"] {
        assert!(summary.contains(part), "{summary}");
    }
    assert_eq!(listing(&folder.path().join("a")), ["optics.csv", "optics.svg", "picture.exr", "picture.png"]);
    render("b", "3");
    for file in ["picture.exr", "picture.png"] {
        let read = |out: &str| std::fs::read(folder.path().join(out).join(file)).unwrap();
        assert_eq!(read("a"), read("b"), "{file}");
    }
}

/// Every kind of bad input: one clear error, the right exit code, nothing written.
#[test]
fn bad_input_gets_one_clear_error_and_writes_nothing() {
    let recipe =
        |body: &str| format!("[host]\nsubstance = \"water\"\n[[inclusion]]\nrefractive_index = \"1.5\"\n{body}\n");
    let sizes = "size_distribution = { kind = \"monodisperse\", radius = \"1um\" }";
    let recipes = [
        ("typo.toml", "model = \"milk\"\n[inputs]\nfatt = 3\n".to_string()),
        (
            "radius.toml",
            recipe("volume_fraction = 0.1\nsize_distribution = { kind = \"monodisperse\", radius = \"-1um\" }"),
        ),
        ("negative.toml", recipe(&format!("volume_fraction = -0.1\n{sizes}"))),
        (
            "full.toml",
            recipe(&format!(
                "volume_fraction = 0.6\n{sizes}\n[[inclusion]]\nrefractive_index = \"1.4\"\nvolume_fraction = 0.6\n{sizes}"
            )),
        ),
        ("syntax.toml", "model = \"milk\n".to_string()),
    ];
    let cases: &[(&[&str], &[&str])] = &[
        (&["render", "whle-milk"], &["no material or scene called `whle-milk`", "did you mean `whole-milk`"]),
        (&["optics", "wather"], &["no material called `wather`", "`water`"]),
        (&["render", "whole-milk", "--set", "fat=-1"], &["fat = -1 wt.-%", "0 to 60"]),
        (&["render", "whole-milk", "--set", "fat=101"], &["fat = 101 wt.-%", "0 to 60"]),
        (&["render", "whole-milk", "--set", "fat=abc"], &["`fat=abc` is not a setting", "name=number"]),
        (&["optics", "whole-milk", "--set", "sugar=1"], &["no input `sugar`", "fat, protein"]),
        (&["render", "milk-components", "--set", "sugar=1"], &["no material of the scene", "`sugar`"]),
        (&["render", "glass"], &["shows a material of your choice"]),
        (&["render", "typo.toml"], &["line 3", "no input `fatt`", "typo.toml:3:1"]),
        (&["render", "radius.toml"], &["line 6", "-1um"]),
        (&["render", "negative.toml"], &["line 5", "-0.1", "between 0 and 1"]),
        (&["render", "full.toml"], &["1.2", "more than 1"]),
        (&["optics", "syntax.toml"], &["line 1"]),
        (&["optics", "nowhere.toml"], &["nowhere.toml", "cannot be read"]),
        (&["optics", "whole-milk", "--wavelengths", "900nm"], &["900 nm is outside the data", "375 nm to 775 nm"]),
        (&["optics", "whole-milk", "--wavelengths", "550"], &["no unit"]),
        (&["render", "whole-milk", "--spp", "0"], &["--spp", "0"]),
        (&["render", "whole-milk", "--spp", "1", "--time", "1s"], &["cannot be used with"]),
        (&["render", "whole-milk", "--size", "0x10"], &["--size"]),
        (&["render", "whole-milk", "--noise", "0%"], &["--noise"]),
        (&["render", "whole-milk", "-o", "typo.toml/out"], &["typo.toml", "folder"]),
        (&["optics", "whole-milk", "-o", "typo.toml"], &["`typo.toml` is not a folder"]),
        (&["render", "water", "--resume"], &["nothing to go on with", "--resume"]),
    ];
    for (words, parts) in cases {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in &recipes {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        let before = listing(folder.path());
        let output = mieux(folder.path(), words);
        let error = flat(&output);
        assert!(matches!(output.status.code(), Some(1 | 2)), "{words:?}: {:?}", output.status);
        assert!(output.stdout.is_empty(), "{words:?}: {}", text(&output.stdout));
        for part in *parts {
            assert!(error.contains(part), "{words:?}: wanted {part:?} in {error}");
        }
        assert!(!error.contains("panicked"), "{error}");
        assert_eq!(listing(folder.path()), before, "{words:?}");
    }
}
