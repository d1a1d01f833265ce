//! `mieux sizes`, and what recipes say about particles, as typed.

use std::process::{Command, Output};

fn mieux(folder: &std::path::Path, args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_mieux")).args(args).current_dir(folder).output().unwrap()
}

/// All that was printed, with the line breaks of error frames taken out.
fn text(output: &Output) -> String {
    let all = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    let words = all.split(|c: char| c.is_whitespace() || "│╰╭─×·".contains(c)).filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join(" ")
}

#[test]
fn a_distribution_is_shown_in_every_weighting() {
    let folder = tempfile::tempdir().unwrap();
    let args = ["sizes", "log-normal", "weighting=number", "median=1um", "geometric_deviation=2", "-o", "out"];
    let output = mieux(folder.path(), &args);
    assert!(output.status.success(), "{}", text(&output));
    // Median by volume: exp(3 ln(2)^2) um; effective radius: exp(2.5 ln(2)^2) um.
    for part in ["number", "surface", "volume", "intensity", "4.226", "3.324", "z-average"] {
        assert!(text(&output).contains(part), "{part}: {}", text(&output));
    }
    let table = std::fs::read_to_string(folder.path().join("out/sizes.csv")).unwrap();
    assert!(
        table.contains("radius_um,number_density_per_um,surface_density_per_um,volume_density_per_um,volume_below")
    );
    assert!(folder.path().join("out/sizes.svg").exists() && folder.path().join("out/sizes.json").exists());
}

#[test]
fn mistakes_are_told() {
    let folder = tempfile::tempdir().unwrap();
    for (args, expected) in [
        (&["sizes", "log-normal", "median=1um", "geometric_deviation=2"][..], "weighting"),
        (&["sizes", "power-law", "exponent=4", "minimum=2um", "maximum=1um"][..], "below the maximum"),
        (&["sizes", "monodisperse", "radius=1um", "--weighting", "mass"][..], "no weighting `mass`"),
        (&["sizes", "log-normol"][..], "log-normol"),
    ] {
        let output = mieux(folder.path(), args);
        assert!(!output.status.success() && text(&output).contains(expected), "{args:?}: {}", text(&output));
    }
}

/// Dense small particles are doubted in words, and corrected ones are not.
#[test]
fn dense_particles_are_doubted() {
    let folder = tempfile::tempdir().unwrap();
    let recipe = |packing: &str| {
        format!(
            "[host]\nrefractive_index = \"1.33\"\n[[inclusion]]\nname = \"beads\"\nrefractive_index = \"1.59\"\n\
             volume_fraction = 0.3\n{packing}\nsize_distribution = {{ kind = \"monodisperse\", radius = \"100 nm\" }}\n"
        )
    };
    std::fs::write(folder.path().join("dense.toml"), recipe("")).unwrap();
    std::fs::write(folder.path().join("packed.toml"), recipe("packing = \"percus-yevick\"")).unwrap();
    let [dense, packed] = ["dense.toml", "packed.toml"].map(|file| mieux(folder.path(), &["optics", file]));
    assert!(dense.status.success() && packed.status.success());
    assert!(text(&dense).contains("warning: beads may not scatter independently"), "{}", text(&dense));
    assert!(!text(&packed).contains("warning"));
}
