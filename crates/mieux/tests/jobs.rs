//! Jobs as any front end runs them.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use mieux::jobs::{Approximation, Context, Event, Job, Render, Report, Stage, Stop};

fn small(output: &std::path::Path) -> Render {
    Render {
        size: "32x24".parse().ok(),
        stop: Stop::Samples(12),
        output: Some(output.to_path_buf()),
        ..Render::new("skim-milk")
    }
}

/// Stopped after some tiles and taken up again, a render ends with the bits of one that was left alone.
#[test]
fn an_interrupted_render_resumes_to_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, parts) = (folder.path().join("whole"), folder.path().join("parts"));
    let calm = AtomicBool::new(false);
    Job::Render(small(&whole)).run(&Context { sink: &|_| {}, cancel: &calm }).unwrap();

    let (cancel, tiles) = (AtomicBool::new(false), AtomicU64::new(0));
    let sink = |event: Event| {
        let render = matches!(event, Event::Progress { stage: Stage::Render, .. });
        if render && tiles.fetch_add(1, Ordering::Relaxed) == 9 {
            cancel.store(true, Ordering::Relaxed);
        }
    };
    let Report::Render(report) = Job::Render(small(&parts)).run(&Context { sink: &sink, cancel: &cancel }).unwrap()
    else {
        panic!()
    };
    assert!(report.interrupted && report.samples.0 < 12);
    assert!(parts.join("render.checkpoint").exists());

    // Another job does not take it up.
    let other = Render { resume: true, seed: 1, ..small(&parts) };
    assert!(Job::Render(other).run(&Context { sink: &|_| {}, cancel: &calm }).is_err());

    let again = Render { resume: true, threads: Some(1), ..small(&parts) };
    Job::Render(again).run(&Context { sink: &|_| {}, cancel: &calm }).unwrap();
    for file in ["picture.exr", "picture.png"] {
        assert_eq!(std::fs::read(whole.join(file)).unwrap(), std::fs::read(parts.join(file)).unwrap(), "{file}");
    }
    assert!(!parts.join("render.checkpoint").exists());
}

/// A job is a value: written down and read back, it is the same; what it does not know it refuses.
#[test]
fn a_job_can_be_written_down() {
    let job = Job::Render(Render { stop: Stop::Noise(0.02), ..Render::new("whole-milk") });
    let text = serde_json::to_string(&job).unwrap();
    assert_eq!(serde_json::from_str::<Job>(&text).unwrap(), job);
    let fast = Job::Render(Render { approximate: Some(Approximation::Diffusion), ..Render::new("whole-milk") });
    let text = serde_json::to_string(&fast).unwrap();
    assert!(text.contains(r#""approximate":"diffusion""#), "{text}");
    assert_eq!(serde_json::from_str::<Job>(&text).unwrap(), fast);
    assert!(serde_json::from_str::<Job>(r#"{"job":"optics","material":"water"}"#).is_ok());
    assert!(serde_json::from_str::<Job>(r#"{"job":"optics","material":"water","colour":1}"#).is_err());
}
