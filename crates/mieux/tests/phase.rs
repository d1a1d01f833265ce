//! The jobs of phase functions.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use mieux::io::quantity::{Length, RefractiveIndex};
use mieux::jobs::{Comparand, Context, FitKind, Job, JobError, Mie, Phase, PhaseModel, PhaseSheet, Report};

fn run(job: Phase) -> Result<PhaseSheet, JobError> {
    let Report::Phase(report) = Job::Phase(job).run(&Context { sink: &|_| {}, cancel: &AtomicBool::new(false) })?
    else {
        panic!()
    };
    Ok(report.sheet)
}

fn length(text: &str) -> Length {
    text.parse().unwrap()
}

fn fog(diameter: &str) -> PhaseModel {
    PhaseModel::Fog { diameter: length(diameter) }
}

fn mie(diameter: &str, particle: Option<&str>) -> PhaseModel {
    let particle = particle.map(|index| index.parse().unwrap());
    PhaseModel::Mie { diameter: length(diameter), wavelength: Length::GREEN, host: RefractiveIndex::VACUUM, particle }
}

/// The sphere of `mieux mie`: the same values at the same angles by another way through the program.
#[test]
fn one_sphere_is_that_of_the_mie_job() {
    let job = Phase {
        angles: Some("0:180:1.5".parse().unwrap()),
        tolerance: 1e-4,
        ..Phase::new(mie("10um", Some("1.5+1e-3i")))
    };
    let sheet = run(job).unwrap();
    let job = Job::Mie(Mie {
        angles: Some("0:180:1.5".parse().unwrap()),
        ..Mie::new(length("5um"), Length::GREEN, "1.5+1e-3i".parse().unwrap())
    });
    let Report::Mie(report) = job.run(&Context { sink: &|_| {}, cancel: &AtomicBool::new(false) }).unwrap() else {
        panic!()
    };
    let exact = &report.sheet.directional.as_ref().unwrap().mueller;
    for ((value, exact), angle) in sheet.values(&sheet.function.phase).iter().zip(exact).zip(&sheet.degrees) {
        // The table is linear between its angles, which minima feel most.
        assert!((value - exact.p11).abs() < 2e-3 * exact.p11 + 2e-4, "{angle}: {value} {}", exact.p11);
    }
    let lack = (1.0 - sheet.function.phase.asymmetry()) / (1.0 - report.sheet.scattering.asymmetry);
    assert!((lack - 1.0).abs() < 1e-4, "{lack}");
}

#[test]
fn comparisons_say_how_far_and_fits_are_nearer_than_guesses() {
    let compare = vec![
        Comparand::Model(fog("10um")),
        Comparand::Fit(FitKind::HgDraine),
        Comparand::Fit(FitKind::Hg),
        Comparand::Model(mie("10um", None)),
    ];
    let sheet = run(Phase { compare: compare.clone(), ..Phase::new(mie("10um", None)) }).unwrap();
    // What would be compared with itself is left out.
    assert_eq!(sheet.compared.iter().map(|c| c.other.name.as_str()).collect::<Vec<_>>(), ["fog", "hg-draine", "hg"]);
    let [published, fitted, hg] = [0, 1, 2].map(|i| sheet.compared[i].comparison.rms_log10);
    assert!(fitted < published && published < hg, "{fitted} {published} {hg}");
    let kept = run(Phase { compare, keep_asymmetry: true, ..Phase::new(mie("10um", None)) }).unwrap();
    for compared in kept.compared.iter().filter(|c| c.fitted) {
        assert!(compared.comparison.delta_asymmetry.abs() < 1e-9);
    }
    let json = kept.json();
    assert_eq!(json["comparisons"][1]["fitted"], true);
    assert!((json["comparisons"][2]["parameters"]["g"].as_f64().unwrap() - json["asymmetry"].as_f64().unwrap()) < 1e-9);
    assert!((json["legendre_moments"][0].as_f64().unwrap() - 1.0).abs() < 1e-12);
    assert!((json["legendre_moments"][1].as_f64().unwrap() - json["asymmetry"].as_f64().unwrap()).abs() < 1e-9);
}

#[test]
fn a_material_has_the_mean_cosine_of_its_optics() {
    let set = BTreeMap::from([("fat".to_owned(), 1.5)]);
    let model = PhaseModel::Material { material: "whole-milk".into(), set, wavelength: Length::GREEN };
    let sheet = run(Phase::new(model)).unwrap();
    let optics: Job = serde_json::from_str(
        r#"{"job": "optics", "material": "whole-milk", "set": {"fat": 1.5}, "wavelengths": "550nm"}"#,
    )
    .unwrap();
    let Report::Optics(report) = optics.run(&Context { sink: &|_| {}, cancel: &AtomicBool::new(false) }).unwrap()
    else {
        panic!()
    };
    let g = report.sheet.bulk.asymmetry()[0];
    assert!((sheet.function.phase.asymmetry() - g).abs() < 1e-3 * (1.0 - g));
    assert!(sheet.function.title.contains("550 nm"), "{}", sheet.function.title);
}

#[test]
fn jobs_are_values_that_can_be_written_down() {
    let job = Job::Phase(Phase {
        compare: vec![Comparand::Fit(FitKind::TwoLobeHg), Comparand::Model(mie("3um", Some("1.4")))],
        angles: Some("0:180:0.5".parse().unwrap()),
        ..Phase::new(PhaseModel::Draine { g: 0.5, alpha: 2.0 })
    });
    let text = serde_json::to_string(&job).unwrap();
    assert!(text.contains(r#""compare":["two-lobe-hg",{"kind":"mie""#), "{text}");
    assert_eq!(serde_json::from_str::<Job>(&text).unwrap(), job);
    let read = |text: &str| serde_json::from_str::<Job>(text);
    let short = read(r#"{"job": "phase", "function": {"kind": "fog", "diameter": "10um"}}"#).unwrap();
    assert_eq!(short, Job::Phase(Phase::new(fog("10um"))));
    for wrong in [
        r#"{"job": "phase", "function": {"kind": "fog"}}"#,
        r#"{"job": "phase", "function": {"kind": "fog", "diameter": "10um", "g": 1}}"#,
        r#"{"job": "phase", "function": {"kind": "isotropic", "g": 1}}"#,
        r#"{"job": "phase", "function": {"kind": "fig"}}"#,
        r#"{"job": "phase", "function": {"kind": "rayleigh"}, "comapre": []}"#,
        r#"{"job": "phase", "function": {"kind": "rayleigh"}, "compare": ["hgg"]}"#,
    ] {
        assert!(read(wrong).is_err(), "{wrong}");
    }
}

#[test]
fn what_cannot_be_is_an_error_and_a_stop_is_heard() {
    let error = |model| run(Phase::new(model)).unwrap_err();
    assert!(matches!(error(PhaseModel::Hg { g: 1.0 }), JobError::Phase(_)));
    assert!(matches!(error(fog("51um")), JobError::Phase(_)));
    let fournier = |slope, backscatter| PhaseModel::FournierForand { refractive_index: 1.1, slope, backscatter };
    assert!(matches!(error(fournier(None, None)), JobError::SlopeOrBackscatter));
    assert!(matches!(error(fournier(Some(3.6), Some(0.02))), JobError::SlopeOrBackscatter));
    assert!(matches!(error(mie("0um", None)), JobError::Medium { .. }));
    let many = Phase { moments: 1_000_000, ..Phase::new(fog("1um")) };
    assert!(matches!(run(many).unwrap_err(), JobError::Value { name: "moments", .. }));
    let cancel = AtomicBool::new(false);
    cancel.store(true, Ordering::Relaxed);
    let job = Job::Phase(Phase { compare: vec![Comparand::Fit(FitKind::Hg)], ..Phase::new(fog("1um")) });
    assert!(matches!(job.run(&Context { sink: &|_| {}, cancel: &cancel }), Err(JobError::Cancelled)));
}
