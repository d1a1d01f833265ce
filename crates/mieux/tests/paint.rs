//! Jobs about paints as values that can be written down.

use std::sync::atomic::AtomicBool;

use mieux::jobs::{Context, HoldOut, Job, JobError, PaintFit, PaintTarget};

fn job(text: &str) -> Result<Job, serde_json::Error> {
    serde_json::from_str(text)
}

#[test]
fn jobs_have_defaults_and_come_back_as_they_were() {
    let texts = [
        r#"{"job": "paint-fit", "measurements": ["a.json", "b.csv"]}"#,
        r#"{"job": "paint-fit", "measurements": ["a.json"], "hold_out": "repeats", "reference_hides": "80 um", "specular": 0.5}"#,
        r#"{"job": "paint-mix", "paints": "p.toml", "recipe": {"white": 7, "blue red shade": 3}, "thickness": "50um"}"#,
        r##"{"job": "paint-match", "paints": "p.toml", "target": "#c04030"}"##,
    ];
    for text in texts {
        let read = job(text).unwrap();
        assert_eq!(job(&serde_json::to_string(&read).unwrap()).unwrap(), read, "{text}");
    }
    let Job::PaintFit(fit) = job(texts[0]).unwrap() else { panic!() };
    assert_eq!(fit, PaintFit::new(vec!["a.json".into(), "b.csv".into()]));
    assert_eq!((fit.hold_out, fit.index), (HoldOut::None, 1.5));
    let Job::PaintMatch(wanted) = job(texts[3]).unwrap() else { panic!() };
    assert_eq!((wanted.target, wanted.at_most), (PaintTarget::Srgb([0xc0, 0x40, 0x30]), 4));
}

#[test]
fn what_is_no_job_is_refused() {
    for (text, expected) in [
        (r#"{"job": "paint-fit", "measurement": ["a.json"]}"#, "unknown field `measurement`"),
        (
            r#"{"job": "paint-mix", "paints": "p.toml", "recipe": {"white": 1}, "depth": "1mm"}"#,
            "unknown field `depth`",
        ),
        (r#"{"job": "paint-mix", "paints": "p.toml", "recipe": {"white": 1}, "thickness": "50"}"#, "has no unit"),
        (r#"{"job": "paint-match", "paints": "p.toml", "target": "lab:1,2"}"#, "a colour is as `lab:50,40,30`"),
    ] {
        let error = job(text).unwrap_err().to_string();
        assert!(error.contains(expected), "{text}: {error}");
    }
    let context = Context { sink: &|_| (), cancel: &AtomicBool::new(false) };
    let nothing = Job::PaintFit(PaintFit::new(vec![])).run(&context);
    assert!(matches!(nothing, Err(JobError::Paint(_))));
}
