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
    for name in ["whole-milk", "skim-milk", "low-fat-milk", "water", "inputs: fat"] {
        assert!(materials.contains(name), "{materials}");
    }
    let milk = text(&mieux(folder.path(), &["materials", "whole-milk"]).stdout);
    for part in ["wt.-%", "0 to 60", "fat globules", "375 nm to 775 nm"] {
        assert!(milk.contains(part), "{milk}");
    }
    let recipe = mieux(folder.path(), &["materials", "whole-milk", "--recipe"]).stdout;
    std::fs::write(folder.path().join("my.toml"), &recipe).unwrap();
    assert!(mieux(folder.path(), &["optics", "my.toml", "--wavelengths", "550nm"]).status.success());
    let scenes = text(&mieux(folder.path(), &["scenes"]).stdout);
    assert!(scenes.contains("milk-components") && scenes.contains("560x210"), "{scenes}");
}

#[test]
fn substances_are_listed_and_shown() {
    let folder = tempfile::tempdir().unwrap();
    let list = text(&mieux(folder.path(), &["substances"]).stdout);
    for part in ["sea-ice-brine", "temperature -30 to -2 degC", "44.3 nm to 2 m; warren2008", "riboflavin"] {
        assert!(list.contains(part), "{list}");
    }
    let json = mieux(folder.path(), &["substances", "--format", "json"]);
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert!(json["substances"].as_array().unwrap().iter().any(|s| s["name"] == "ice"), "{json}");
    let file = "DATA:\n- type: formula 5\n  wavelength_range: 0.4 0.8\n  coefficients: 1.5\n";
    std::fs::write(folder.path().join("my.yml"), file).unwrap();
    let words = ["substances", "--index-file", "my.yml", "--transparent", "--format", "json", "-o", "out"];
    let json: serde_json::Value = serde_json::from_slice(&mieux(folder.path(), &words).stdout).unwrap();
    assert_eq!((&json["n_real"][0], &json["wavelength_nm"][0]), (&1.5.into(), &400.0.into()));
    assert_eq!(listing(&folder.path().join("out")), ["substance.csv", "substance.svg"]);
    for (words, part) in [
        (&["substances", "wter"][..], "did you mean `water`"),
        (&["substances", "--index-file", "my.yml"], "give `--transparent`"),
        (&["substances", "water", "--salinity", "50"], "salinity 50 g/kg is out of range: 0 to 35 g/kg"),
        (&["substances", "water", "--wavelengths", "900nm"], "375 nm to 775 nm"),
    ] {
        let output = mieux(folder.path(), words);
        assert_eq!(output.status.code(), Some(2));
        assert!(flat(&output).contains(part), "{}", flat(&output));
    }
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
    assert_eq!(
        listing(&folder.path().join("made/here")),
        [
            "optics.csv",
            "optics.json",
            "optics.nc",
            "optics.parquet",
            "optics.svg",
            "phase.csv",
            "phase.svg",
            "swatches.svg"
        ]
    );
}

/// What is approximate says so, and gives another picture.
#[test]
fn an_approximate_render_is_labelled() {
    let folder = tempfile::tempdir().unwrap();
    let render = |words: &[&str]| {
        let all = ["render", "whole-milk", "--size", "24x18", "--spp", "4"];
        text(&mieux(folder.path(), &[&all[..], words].concat()).stdout)
    };
    let approximate = render(&["--approximate", "diffusion", "-o", "fast"]);
    assert!(approximate.contains("approximate: ") && approximate.contains("docs/diffusion.md"), "{approximate}");
    assert!(!render(&["-o", "exact"]).contains("approximate"));
    let picture = |name: &str| std::fs::read(folder.path().join(name).join("picture.png")).unwrap();
    assert_ne!(picture("fast"), picture("exact"));
    let wrong = mieux(folder.path(), &["render", "whole-milk", "--approximate", "magic"]);
    assert!(!wrong.status.success() && flat(&wrong).contains("diffusion"), "{}", flat(&wrong));
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

const SPHERE: [&str; 9] =
    ["mie", "--radius", "0.5um", "--wavelength", "550nm", "--host", "1.33", "--particle", "1.5+0.01i"];

#[test]
fn one_particle_prints_json_csv_and_a_table() {
    let folder = tempfile::tempdir().unwrap();
    let json = mieux(folder.path(), &[&SPHERE[..], &["--angles", "0:180:0.5", "--format", "json"]].concat());
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    for key in ["c_ext_m2", "c_sca_m2", "c_abs_m2", "q_ext", "q_sca", "q_abs", "q_back", "g", "size_parameter"] {
        assert!(json[key].is_f64(), "{key}");
    }
    assert_eq!(json["scattering_definition"], "frisvad2007");
    for key in ["angle_deg", "s1", "s2", "phase_per_sr", "p11", "p12", "p21", "p22", "p33", "p34", "p43", "p44"] {
        assert_eq!(json[key].as_array().unwrap().len(), 361, "{key}");
    }

    let csv = text(&mieux(folder.path(), &[&SPHERE[..], &["--format", "csv"]].concat()).stdout);
    assert!(csv.contains("\nc_ext_m2,c_sca_m2,c_abs_m2,q_ext,q_sca,q_abs,q_back,g,size_parameter\n1.3"), "{csv}");
    let csv = text(&mieux(folder.path(), &[&SPHERE[..], &["--angles", "90", "--format", "csv"]].concat()).stdout);
    assert!(csv.contains("# q_ext: 1.68") && csv.contains("\nangle_deg,phase_per_sr,p12_per_sr"), "{csv}");
    assert_eq!(csv.lines().filter(|line| !line.starts_with('#')).count(), 2);
    let table = text(&mieux(folder.path(), &[&SPHERE[..], &["--angles", "0:180:30"]].concat()).stdout);
    for part in ["radius 500 nm", "1.5+0.01i", "550 nm", "µm²", "asymmetry g", "1/sr", "120"] {
        assert!(table.contains(part), "{part}: {table}");
    }
    assert!(!table.contains("absorbs"), "{table}");
    let table =
        text(&mieux(folder.path(), &[&SPHERE[..5], &["--particle", "1.5", "--host", "1.3+1e-4i"]].concat()).stdout);
    assert!(table.contains("The host absorbs") && table.contains("frisvad2007"), "{table}");
    assert!(listing(folder.path()).is_empty());

    let written = mieux(folder.path(), &[&SPHERE[..], &["--angles", "0:180:1", "-o", "out"]].concat());
    assert!(written.status.success(), "{}", text(&written.stderr));
    let files = ["angles.csv", "efficiencies.svg", "mie.csv", "mie.json", "phase-function.svg", "polarisation.svg"];
    assert_eq!(listing(&folder.path().join("out")), files);
}

#[test]
fn a_table_of_spheres_goes_through() {
    let folder = tempfile::tempdir().unwrap();
    let rows =
        "# made up\nid,particle_re,particle_im,host_re,host_im,wavelength_um,radius_um\na,1.5,0.01,1.33,0,0.55,0.5\n";
    std::fs::write(folder.path().join("in.csv"), rows).unwrap();
    let output = mieux(folder.path(), &["mie", "--batch", "in.csv", "-o", "out.csv", "--threads", "2"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("1 particles in") && text(&output.stdout).contains("out.csv"));
    let table = std::fs::read_to_string(folder.path().join("out.csv")).unwrap();
    let one = mieux(folder.path(), &[&SPHERE[..], &["--format", "json"]].concat());
    let one: serde_json::Value = serde_json::from_slice(&one.stdout).unwrap();
    let last: Vec<&str> = table.lines().nth(1).unwrap().split(',').collect();
    assert_eq!(&last[..7], ["a", "1.5", "0.01", "1.33", "0", "0.55", "0.5"]);
    for (i, key) in ["c_ext_m2", "c_sca_m2", "c_abs_m2", "q_ext", "q_sca", "q_abs", "g"].iter().enumerate() {
        let (found, expected): (f64, f64) = (last[7 + i].parse().unwrap(), one[key].as_f64().unwrap());
        assert!((found / expected - 1.0).abs() < 1e-12, "{key}: {found} {expected}");
    }
}

#[test]
fn a_phase_function_prints_json_csv_and_a_table_and_draws() {
    let folder = tempfile::tempdir().unwrap();
    let words = ["phase", "mie", "--diameter", "10um", "--compare", "hg,fog", "--angles", "0:180:1"];
    let json = mieux(folder.path(), &[&words[..], &["--format", "json"]].concat());
    let json: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!((&json["phase"], &json["comparisons"][0]["phase"]), (&"mie".into(), &"hg".into()));
    for value in [&json, &json["comparisons"][0], &json["comparisons"][1]] {
        assert_eq!(value["phase_per_sr"].as_array().unwrap().len(), 181);
        assert_eq!(value["legendre_moments"].as_array().unwrap().len(), 9);
        assert!(value["asymmetry"].is_f64());
    }
    assert_eq!(json["angle_deg"].as_array().unwrap().len(), 181);
    assert!(json["comparisons"][0]["parameters"]["g"].is_f64() && json["comparisons"][1]["rms_log10"].is_f64());

    let csv = text(&mieux(folder.path(), &[&words[..], &["--format", "csv"]].concat()).stdout);
    assert!(csv.contains("\nangle_deg,phase_per_sr,hg_per_sr,fog_per_sr\n0,137"), "{csv}");
    assert!(csv.contains("# fit hg: ") && csv.contains("# asymmetry: 0.8"), "{csv}");
    let table = text(&mieux(folder.path(), &["phase", "hg", "--g", "0.9", "--moments", "3"]).stdout);
    for part in ["Henyey-Greenstein (g = 0.9)", "1 0.9 0.81 0.729\n", "1/sr", "175"] {
        assert!(table.contains(part), "{part}: {table}");
    }
    let table = text(&mieux(folder.path(), &["phase", "whole-milk", "--set", "fat=1.5", "--compare", "hg"]).stdout);
    for part in ["Whole milk at 550 nm", "hg fit", "light elsewhere"] {
        assert!(table.contains(part), "{part}: {table}");
    }
    let calm = text(&mieux(folder.path(), &["phase", "water", "--wavelength", "450nm"]).stdout);
    assert!(calm.contains("scatters nothing"), "{calm}");
    assert!(listing(folder.path()).is_empty());

    let written = mieux(folder.path(), &[&words[..], &["-o", "out"]].concat());
    assert!(written.status.success(), "{}", text(&written.stderr));
    assert_eq!(listing(&folder.path().join("out")), ["phase-function.svg", "phase.csv", "phase.json"]);
    let svg = std::fs::read_to_string(folder.path().join("out/phase-function.svg")).unwrap();
    assert!(svg.contains("hg fit") && svg.contains("fog") && svg.len() < 600_000, "{}", svg.len());
}

#[test]
fn bad_phase_functions_get_one_clear_error_and_write_nothing() {
    let cases: &[(&[&str], &[&str])] = &[
        (&["hg"], &["`hg` needs `--g`"]),
        (&["hg", "--g", "1"], &["g = 1", "between -1 and 1"]),
        (&["hg", "--g", "-1.5"], &["g = -1.5"]),
        (&["hg", "--g", "0.5", "--diameter", "1um"], &["`--diameter` means nothing to `hg`"]),
        (&["hg", "--g", "0.5", "--compare", "fog"], &["`fog` needs `--diameter`"]),
        (&["hg", "--g", "0.5", "--keep-asymmetry"], &["--compare"]),
        (&["double-hg", "--weight", "1.5", "--g1", "0.5", "--g2", "0"], &["weight 1.5"]),
        (&["draine", "--g", "0.5", "--alpha", "-1"], &["alpha = -1"]),
        (&["fog", "--diameter", "60um"], &["60 um", "at most 50 um"]),
        (&["fog", "--diameter", "10"], &["`10` has no unit"]),
        (&["fogg", "--diameter", "10um"], &["`fogg`", "did you mean `fog`"]),
        (&["whole-mlk"], &["did you mean `whole-milk`"]),
        (&["whole-milk", "--set", "sugar=1"], &["no input `sugar`"]),
        (&["whole-milk", "--wavelength", "2um"], &["2000 nm is outside the data"]),
        (&["nowhere.toml"], &["nowhere.toml", "cannot be read"]),
        (&["fournier-forand", "--index", "1.1"], &["slope", "backward"]),
        (&["fournier-forand", "--index", "1.1", "--slope", "6"], &["slope 6", "between 3 and 5"]),
        (&["mie", "--diameter", "1um", "--particle", "1.5-1i"], &["--particle", "absorbs"]),
        (&["mie", "--diameter", "1um", "--tolerance", "0"], &["tolerance 0", "1e-12"]),
        (&["mie", "--diameter", "1um", "--moments", "1e9"], &["--moments"]),
    ];
    for (words, parts) in cases {
        let folder = tempfile::tempdir().unwrap();
        let output = mieux(folder.path(), &[&["phase"], *words].concat());
        let error = flat(&output);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {error}");
        assert!(output.stdout.is_empty() && !error.contains("panicked"), "{words:?}: {error}");
        for part in *parts {
            assert!(error.contains(part), "{words:?}: wanted {part:?} in {error}");
        }
        assert!(listing(folder.path()).is_empty(), "{words:?}");
    }
}

#[test]
fn completions_know_the_commands() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish"] {
        let script = text(&mieux(folder.path(), &["completions", shell]).stdout);
        assert!(script.contains("mishchenko-yang2018") && script.contains("batch"), "{shell}");
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
    let tables = [
        ("ok.csv", "radius_um,wavelength_um,host_re,host_im,particle_re,particle_im\n0.5,0.55,1.33,0,1.5,0\n"),
        ("radius.csv", "radius_um,wavelength_um,host_re,host_im,particle_re,particle_im\n-5,0.55,1.33,0,1.5,0\n"),
        ("letter.csv", "radius_um,wavelength_um,host_re,host_im,particle_re,particle_im\n0.5,0.55,1.33,o,1.5,0\n"),
        ("column.csv", "radius_um,wavelength_nm,host_re,host_im,particle_re,particle_im\n5,0.55,1.33,0,1.5,0\n"),
        ("again.csv", "radius_um,wavelength_um,host_re,host_im,particle_re,particle_im,g\n5,0.55,1.33,0,1.5,0,1\n"),
        ("empty.csv", ""),
    ];
    let light: &[&str] = &["--wavelength", "550nm", "--particle", "1.5"];
    let mie = |rest: &[&'static str]| [&["mie"], rest, light].concat();
    let batch = |input: &'static str| vec!["mie", "--batch", input, "-o", "out.csv"];
    let mie_cases: &[(Vec<&str>, &[&str])] = &[
        (mie(&["--radius", "5"]), &["--radius", "`5` has no unit"]),
        (mie(&["--radius", "-5um"]), &["--radius", "`-5um` is out of range"]),
        (mie(&["--radius", "0um"]), &["--radius", "more than zero"]),
        (mie(&["--radius", "1km"]), &["size parameter", "outside"]),
        (mie(&["--radius", "1um", "--host", "1.3-1i"]), &["--host", "absorbs"]),
        (mie(&["--radius", "1mm", "--host", "1.3+1i", "-o", "out"]), &["the host absorbs"]),
        (mie(&["--radius", "1um", "--host", "water"]), &["--host", "`water`"]),
        (mie(&["--radius", "1um", "--layer", "1.2um"]), &["--layer", "`600nm:1.45`"]),
        (mie(&["--radius", "1um", "--layer", "2um:1.4", "--layer", "1.5um:1.3"]), &["layer 2", "1.5 µm", "2 µm"]),
        (mie(&["--radius", "1um", "--layer", "900nm:1.4", "-o", "out"]), &["layer 1", "900 nm", "1 µm"]),
        (mie(&["--radius", "1um", "--angles", "0:190:1"]), &["--angles", "between 0", "180"]),
        (mie(&["--radius", "1um", "--angles", "-1:90:1"]), &["--angles", "between 0"]),
        (mie(&["--radius", "1um", "--angles", "0:180:0"]), &["--angles", "step"]),
        (mie(&["--radius", "1um", "--angles", "0:180:1e-9"]), &["--angles", "10 million"]),
        (mie(&["--radius", "1um", "--angles", "0:180"]), &["--angles", "`0:180:0.5`"]),
        (mie(&["--radius", "1um", "--definition", "bohren"]), &["--definition", "frisvad2007", "mishchenko-yang2018"]),
        (mie(&["--radius", "1um", "--threads", "2"]), &["--batch"]),
        (mie(&["--radius", "1um", "-o", "typo.toml"]), &["`typo.toml` is not a folder"]),
        (vec!["mie", "--radius", "1um"], &["--wavelength", "--particle"]),
        (vec!["mie", "--batch", "ok.csv"], &["--output"]),
        (vec!["mie", "--batch", "ok.csv", "-o", "out.csv", "--radius", "1um"], &["cannot be used with"]),
        (vec!["mie", "--batch", "ok.csv", "-o", "no/out.csv"], &["no/out.csv", "cannot be written"]),
        (batch("nowhere.csv"), &["nowhere.csv", "cannot be read"]),
        (batch("radius.csv"), &["radius.csv, line 2", "`radius_um`", "`-5`"]),
        (batch("letter.csv"), &["letter.csv, line 2", "`host_im`", "`o` is not a number"]),
        (batch("column.csv"), &["no column `wavelength_um`", "there is a column `wavelength_nm`;", "particle_im"]),
        (batch("again.csv"), &["`g` already"]),
        (batch("empty.csv"), &["empty.csv", "column names"]),
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
    for (words, parts) in cases.iter().copied().chain(mie_cases.iter().map(|(w, p)| (&w[..], *p))) {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in recipes.iter().map(|(n, t)| (n, t.as_str())).chain(tables.iter().map(|(n, t)| (n, *t))) {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        let before = listing(folder.path());
        let output = mieux(folder.path(), words);
        let error = flat(&output);
        assert!(matches!(output.status.code(), Some(1 | 2)), "{words:?}: {:?}", output.status);
        assert!(output.stdout.is_empty(), "{words:?}: {}", text(&output.stdout));
        for part in parts {
            assert!(error.contains(part), "{words:?}: wanted {part:?} in {error}");
        }
        assert!(!error.contains("panicked"), "{error}");
        assert_eq!(listing(folder.path()), before, "{words:?}");
    }
}
