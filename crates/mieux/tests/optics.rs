//! What `mieux optics -o` and `mieux compare` leave, held against itself and against what must follow.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use mieux::io::measured::Property;
use mieux::jobs::{Compare, CompareReport, Context, Job, JobError, Optics, Report};

fn run(job: &Job) -> Result<Report, JobError> {
    job.run(&Context { sink: &|_| {}, cancel: &AtomicBool::new(false) })
}

fn compared(job: Compare) -> CompareReport {
    match run(&Job::Compare(job)).unwrap() {
        Report::Compare(report) => *report,
        other => panic!("{other:?}"),
    }
}

fn milk_into(folder: &Path) -> BTreeMap<String, String> {
    let optics = Optics { output: Some(folder.into()), tolerance: 1e-3, ..Optics::new("skim-milk") };
    let Report::Optics(report) = run(&Job::Optics(optics)).unwrap() else { panic!() };
    let name = |path: &std::path::PathBuf| path.file_name().unwrap().to_string_lossy().into_owned();
    report
        .files
        .iter()
        .map(|path| (name(path), String::from_utf8_lossy(&std::fs::read(path).unwrap()).into()))
        .collect()
}

#[test]
fn a_folder_holds_every_form_and_the_phase_functions_agree_with_g() {
    let folder = tempfile::tempdir().unwrap();
    let files = milk_into(&folder.path().join("milk"));
    for name in ["optics.csv", "optics.json", "optics.nc", "optics.svg", "phase.csv", "phase.svg", "swatches.svg"] {
        assert!(files.contains_key(name), "{name}: {:?}", files.keys());
    }
    let rows = |name: &str| -> Vec<Vec<f64>> {
        let lines = files[name].lines().filter(|line| !line.starts_with('#')).skip(1);
        lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect()
    };
    // g of the table of properties against that of the table of phase functions, by the rule of trapezes over cosines.
    let (properties, phase) = (rows("optics.csv"), rows("phase.csv"));
    let mu = |row: &[f64]| row[0].to_radians().cos();
    for (i, at) in properties.iter().enumerate() {
        let moment = |power: i32| -> f64 {
            let value = |row: &[f64]| row[i + 1] * mu(row).powi(power);
            let panel = |w: &[Vec<f64>]| 0.5 * (value(&w[0]) + value(&w[1])) * (mu(&w[0]) - mu(&w[1]));
            2.0 * std::f64::consts::PI * phase.windows(2).map(panel).sum::<f64>()
        };
        assert!(
            (moment(0) - 1.0).abs() < 2e-3 && (moment(1) - at[5]).abs() < 6e-3,
            "{at:?}: {} {}",
            moment(0),
            moment(1)
        );
    }
    let json: serde_json::Value = serde_json::from_str(&files["optics.json"]).unwrap();
    let colours = json["layer_colours"].as_array().unwrap();
    assert_eq!(colours.len(), 7);
    let lightness = |i: usize, key: &str| {
        let hex = colours[i][key].as_str().unwrap();
        (1..7).step_by(2).map(|k| u32::from_str_radix(&hex[k..k + 2], 16).unwrap()).sum::<u32>()
    };
    for (i, colour) in colours.iter().enumerate() {
        let (with, without) = (lightness(i, "with_surface_reflection"), lightness(i, "without_surface_reflection"));
        assert!(with > without, "{colour}");
        if colour["ground"] == "white" {
            assert!(without >= lightness(i - 1, "without_surface_reflection"), "{colour}");
        }
    }
}

#[cfg(feature = "parquet")]
#[test]
fn parquet_begins_and_ends_as_it_must() {
    let folder = tempfile::tempdir().unwrap();
    milk_into(folder.path());
    let bytes = std::fs::read(folder.path().join("optics.parquet")).unwrap();
    assert!(bytes.starts_with(b"PAR1") && bytes.ends_with(b"PAR1"));
}

#[test]
fn a_material_beside_itself_and_beside_its_own_table() {
    let folder = tempfile::tempdir().unwrap();
    milk_into(folder.path());
    let job = Compare {
        other: Some("skim-milk".into()),
        measured: Some(folder.path().join("optics.csv")),
        tolerance: 1e-3,
        output: Some(folder.path().join("compare")),
        ..Compare::new("skim-milk")
    };
    let report = compared(job);
    assert_eq!(report.sheet.sides.len(), 3);
    for side in [1, 2] {
        let differences = report.sheet.differences(side);
        assert_eq!(differences.len(), Property::ALL.len());
        for d in differences {
            let same = d.property == Property::Asymmetry || (d.mean_ratio - 1.0).abs() < 1e-9;
            assert!(same && d.rms < 1e-9 * 1e6, "{d:?}");
        }
    }
    assert_eq!(report.files.len(), 3);
}

#[test]
fn more_fat_scatters_more() {
    let job = Compare {
        set_other: BTreeMap::from([("fat".into(), 3.5)]),
        other: Some("whole-milk".into()),
        set: BTreeMap::from([("fat".into(), 0.5)]),
        wavelengths: Some("450nm,550nm,650nm".into()),
        ..Compare::new("whole-milk")
    };
    let report = compared(job);
    assert!(report.sheet.differences(1)[0].mean_ratio > 3.0);
    assert!(report.sheet.sides[0].title.contains("fat 0.5 wt.-%"));
}

#[test]
fn a_comparison_with_nothing_says_so() {
    let error = run(&Job::Compare(Compare::new("water"))).unwrap_err().to_string();
    assert!(error.contains("--measured"), "{error}");
    let job = Compare { measured: Some("nowhere.csv".into()), ..Compare::new("water") };
    assert!(run(&Job::Compare(job)).unwrap_err().to_string().contains("nowhere.csv"));
}
