//! The jobs of slabs.

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;

use mieux::jobs::{
    Context, Event, Job, JobError, PhaseName, Report, Sample, Slab, SlabCompare, SlabCompareSheet, SlabError,
    SlabLight, SlabSheet, Solver, Stage,
};
use mieux::optics::transfer::{DiscreteOrdinates, Incidence, Layer, Moments, Shares, Stack};

fn run(job: Job) -> Result<Report, JobError> {
    job.run(&Context { sink: &|_| {}, cancel: &AtomicBool::new(false) })
}

fn sheet(slab: Slab) -> Result<SlabSheet, JobError> {
    let Report::Slab(report) = run(Job::Slab(slab))? else { panic!() };
    Ok(report.sheet)
}

fn comparison(slab: Slab) -> Result<SlabCompareSheet, JobError> {
    let Report::SlabCompare(report) = run(Job::SlabCompare(SlabCompare { slab }))? else { panic!() };
    Ok(report.sheet)
}

fn medium(albedo: f64, g: Option<f64>, phase: &str, tau: &str) -> Slab {
    let tau = tau.split(',').map(|tau| tau.parse().unwrap()).collect();
    Slab::new(Sample::Medium { albedo, g, phase: PhaseName::from(phase.to_owned()), tau, index: None })
}

fn material(name: &str, thickness: &str) -> Slab {
    let thickness = thickness.split(',').map(|thickness| thickness.parse().unwrap()).collect();
    Slab::new(Sample::Material { material: name.into(), set: [].into(), thickness, index: None })
}

fn indexed(mut slab: Slab, n: f64) -> Slab {
    match &mut slab.sample {
        Sample::Medium { index, .. } | Sample::Material { index, .. } => *index = Some(n),
        Sample::Layers { .. } => panic!(),
    }
    slab
}

fn one(slab: Slab) -> Shares {
    sheet(slab).unwrap().answers[0].shares
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() < tolerance, "{found} for {expected}");
}

/// Van de Hulst's slab, to the digits that three published codes of discrete ordinates agree in.
#[test]
fn van_de_hulst_s_slab() {
    let shares = one(medium(0.9, Some(0.75), "hg", "2"));
    close(shares.reflectance, 0.09739464, 1e-7);
    close(shares.transmittance, 0.66095770, 1e-7);
    close(shares.transmittance_unscattered, (-2.0f64).exp(), 1e-12);
    close(shares.reflectance + shares.transmittance + shares.absorptance, 1.0, 1e-12);
    assert_eq!(shares.reflectance_specular, 0.0);
}

/// Chandrasekhar's H function, and the half-space under a surface by adding-doubling (`ad`, 32 points).
#[test]
fn half_spaces() {
    close(one(medium(0.5, None, "isotropic", "inf")).reflectance, 0.1152258777, 1e-8);
    close(one(medium(0.99, None, "isotropic", "inf")).reflectance, 0.7527207172, 1e-8);
    let diffuse = Slab { light: SlabLight::Diffuse, ..medium(0.95, None, "isotropic", "inf") };
    close(one(diffuse).reflectance, 0.59666878, 1e-7);
    close(one(indexed(medium(0.9, None, "isotropic", "inf"), 1.5)).reflectance, 0.25994, 2e-4);
    let lossless = one(indexed(medium(1.0, Some(0.9), "hg", "inf"), 1.4));
    close(lossless.reflectance, 1.0, 1e-9);
    let clear = one(medium(0.0, Some(0.0), "hg", "inf"));
    assert_eq!((clear.reflectance, clear.transmittance), (0.0, 0.0));
}

/// A clear slab of glass in air: the incoherent sum over reflections, `2 F / (1 + F)` and its rest.
#[test]
fn clear_slabs_reflect_as_fresnel_says() {
    let f = (0.5f64 / 2.5).powi(2);
    let shares = one(indexed(medium(0.0, None, "isotropic", "0"), 1.5));
    close(shares.reflectance, 2.0 * f / (1.0 + f), 1e-12);
    close(shares.reflectance_specular, shares.reflectance, 1e-12);
    close(shares.transmittance, (1.0 - f) / (1.0 + f), 1e-12);
    // The same glass as two slides around nothing that differs from them.
    let slides = Slab { slides: Some(1.5), ..indexed(medium(0.0, None, "isotropic", "0"), 1.5) };
    close(one(slides).reflectance, shares.reflectance, 1e-12);
    // In a liquid of its own index it is not there.
    let immersed = Slab { index_outside: 1.5, ..indexed(medium(0.0, None, "isotropic", "0"), 1.5) };
    close(one(immersed).transmittance, 1.0, 1e-12);
}

/// Backings: nothing is lost over white without absorption; a gap of air keeps what total reflection keeps.
#[test]
fn backings_return_light() {
    let over = |backing: &str, contact: bool| {
        let slab = indexed(medium(0.8, Some(0.5), "hg", "1"), 1.5);
        one(Slab { backing: backing.parse().unwrap(), contact, ..slab })
    };
    let reflectances = ["black", "0.3", "70%", "white"].map(|backing| over(backing, false).reflectance);
    assert!(reflectances.is_sorted(), "{reflectances:?}");
    close(over("white", false).transmittance, 0.0, 1e-12);
    close(over("mirror:1", false).transmittance, 0.0, 1e-12);
    assert!(over("white", true).reflectance != over("white", false).reflectance);
    assert!(over("mirror:0.9", false).reflectance_specular > over("black", false).reflectance_specular);
}

#[test]
fn oblique_light_is_another_question() {
    let of = |light| one(Slab { light, ..indexed(medium(0.9, Some(0.75), "hg", "1"), 1.4) });
    let stack = Stack::slab(Layer::new(1.0, 0.9, Moments::henyey_greenstein(0.75).unwrap()).with_index(1.4));
    let solver = DiscreteOrdinates::default();
    for angle in [0.0f64, 30.0, 89.0] {
        let exact = solver.shares(&stack, Incidence::Beam(angle.to_radians().cos())).unwrap();
        assert_eq!(of(SlabLight::Angle(angle)), exact);
    }
    assert_eq!(of(SlabLight::Diffuse), solver.shares(&stack, Incidence::Diffuse).unwrap());
}

fn written(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path.to_string_lossy().into_owned()
}

/// Rayleigh's phase function by its name, as moments, and as values over angle in a scale of their own.
#[test]
fn a_phase_function_may_come_from_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let moments = written(folder.path(), "moments.csv", "degree,moment\n0,2\n1,0\n2,0.2\n");
    let values: String = (0..=1800)
        .map(|i| 0.1 * f64::from(i))
        .map(|angle| format!("{angle},{}\n", 7.0 * (1.0 + angle.to_radians().cos().powi(2))))
        .collect();
    let values = written(folder.path(), "angles.csv", &format!("angle_deg,phase\n{values}"));
    let expected = one(medium(0.9, None, "rayleigh", "1"));
    for (file, tolerance) in [(moments, 1e-12), (values, 1e-6)] {
        let sheet = sheet(medium(0.9, None, &file, "1")).unwrap();
        close(sheet.answers[0].shares.reflectance, expected.reflectance, tolerance);
        assert!(sheet.notes[0].contains("divided by"), "{:?}", sheet.notes);
    }
    // 7 (1 + mu^2) over the sphere is 112 pi / 3.
    let note = &sheet(medium(0.9, None, &folder.path().join("angles.csv").to_string_lossy(), "1")).unwrap().notes[0];
    assert!(note.contains("117.28"), "{note}");
}

/// Moments can be those of no function without negative values, which photons notice.
#[test]
fn photons_need_a_phase_function() {
    let folder = tempfile::tempdir().unwrap();
    let photons = |text: &str| {
        let file = written(folder.path(), "moments.csv", text);
        sheet(Slab { solver: Solver::MonteCarlo, photons: Some(40_000), ..medium(0.9, None, &file, "1") })
    };
    let error = photons("degree,moment\n0,1\n1,0.6\n2,0.1\n").unwrap_err();
    assert!(matches!(error, JobError::Slab(SlabError::NegativePhase { .. })), "{error}");
    let error = photons("degree,moment\n0,1\n1,0.9\n2,0.1\n").unwrap_err();
    assert!(matches!(error, JobError::Transfer(_)), "{error}");
    let file = written(folder.path(), "moments.csv", "degree,moment\n0,1\n1,0.6\n2,0.1\n");
    let compared = comparison(medium(0.9, None, &file, "1")).unwrap();
    assert!(compared.trials.iter().all(|trial| trial.solver != Solver::MonteCarlo));
    assert!(matches!(compared.refused.as_slice(), [(Solver::MonteCarlo, reason)] if reason.contains("negative")));
    let found = photons("degree,moment\n0,1\n1,0\n2,0.1\n").unwrap().answers[0];
    let expected = one(medium(0.9, None, "rayleigh", "1")).reflectance;
    assert!((found.shares.reflectance - expected).abs() < 4.0 * found.errors.unwrap().reflectance);
}

/// Milk by two ways that share only the particles: moments summed exactly, and photons scattered by a table over angle.
#[test]
fn milk_is_the_same_to_streams_and_photons() {
    let slab = Slab {
        wavelengths: Some("450nm,650nm".into()),
        photons: Some(20_000),
        backing: "0.5".parse().unwrap(),
        ..material("whole-milk", "0.2mm")
    };
    let sheet = comparison(slab).unwrap();
    let solvers: Vec<Solver> = sheet.trials.iter().map(|trial| trial.solver).collect();
    assert!(solvers.contains(&Solver::DiscreteOrdinates) && solvers.contains(&Solver::MonteCarlo));
    for trial in &sheet.trials {
        assert!(trial.wall_s > 0.0);
        match trial.solver {
            Solver::DiscreteOrdinates => {
                // Streams are shared out between light that can leave and light that cannot, and the peak has fewer.
                assert!(sheet.largest_differences(trial).iter().all(|d| *d < 5e-4 && *d > 0.0), "{trial:?}");
                assert_eq!(trial.largest_deviation(&sheet.reference), None);
            }
            // The same streams: what differs is what is shared out, as above.
            Solver::Adding => {
                assert!(sheet.largest_differences(trial).iter().all(|d| *d < 5e-4 && *d > 0.0), "{trial:?}");
            }
            Solver::KubelkaMunk | Solver::Diffusion => {
                assert!(sheet.largest_differences(trial).iter().all(|d| *d < 0.15 && *d > 1e-3), "{trial:?}");
            }
            Solver::MonteCarlo => {
                let deviation = trial.largest_deviation(&sheet.reference).unwrap();
                assert!(deviation < 4.5 && deviation > 0.0, "{deviation}");
            }
            Solver::Auto => panic!("the choice is no solver"),
        }
    }
    let json = sheet.json();
    assert_eq!(json["solvers"].as_array().unwrap().len(), sheet.trials.len());
    assert_eq!(json["solvers"][0]["difference_reflectance"].as_array().unwrap().len(), 2);
}

/// Without planes to share them out between, 32 streams are plenty.
#[test]
fn streams_agree_where_nothing_refracts() {
    let at = |streams| {
        let slab = indexed(material("whole-milk", "0.2mm"), 1.0);
        sheet(Slab { streams: Some(streams), wavelengths: Some("650nm".into()), ..slab }).unwrap().answers[0].shares
    };
    let (few, many) = (at(32), at(64));
    close(few.reflectance, many.reflectance, 1e-5);
    close(few.transmittance, many.transmittance, 1e-5);
}

/// More milk is whiter, and skim milk over black bluer than over white.
#[test]
fn milk_looks_like_milk() {
    let over =
        |backing: &str| sheet(Slab { backing: backing.parse().unwrap(), ..material("skim-milk", "1mm,1cm,inf") });
    assert!(matches!(over("white"), Ok(ref sheet) if sheet.cases.len() == 3));
    let (black, white) = (over("black").unwrap(), over("white").unwrap());
    let [thin, _, endless] = black.patches().try_into().unwrap();
    assert!(thin.reflected[2] > 1.2 * thin.reflected[0], "{thin:?}");
    assert!(endless.reflected[1] > 0.6 && endless.transmitted == [0.0; 3], "{endless:?}");
    let over_white = &white.patches()[0].reflected;
    assert!(over_white[2] / over_white[0] < thin.reflected[2] / thin.reflected[0]);
    // Below a half-space nothing can be seen.
    for (b, w) in black.answers.iter().zip(&white.answers).skip(34) {
        close(b.shares.reflectance, w.shares.reflectance, 1e-12);
    }
    let json = black.json();
    assert_eq!(json["reflectance"].as_array().unwrap().len(), 51);
    assert_eq!(json["wavelength_nm"][0], 375.0);
    assert!(json["thickness_m"][50].is_null() && json["thickness_m"][0] == 1e-3);
    assert_eq!(json["swatches"].as_array().unwrap().len(), 3);
}

/// What the material's own interfaces do is that of its host: water reflects 2 % at each face.
#[test]
fn water_is_clear_and_shines_a_little() {
    let sheet = sheet(material("water", "1cm")).unwrap();
    for answer in &sheet.answers {
        let shares = answer.shares;
        close(shares.reflectance, shares.reflectance_specular, 1e-12);
        assert!((0.035..0.043).contains(&shares.reflectance_specular), "{shares:?}");
    }
}

#[test]
fn layers_lie_on_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let layered = |text: &str, name: Option<&str>, thickness: &[&str]| {
        let layers = written(folder.path(), "layers.toml", text).into();
        let thickness = thickness.iter().map(|text| text.parse().unwrap()).collect();
        sheet(Slab::new(Sample::Layers { layers, material: name.map(Into::into), set: [].into(), thickness }))
    };
    // Two halves are a whole.
    let half = "[[layer]]\nalbedo = 0.9\ng = 0.75\ntau = 1\n";
    let whole = layered(&half.repeat(2), None, &[]).unwrap();
    close(whole.answers[0].shares.reflectance, 0.09739464, 1e-7);
    assert!(whole.grid.is_none());
    // A cuvette by layers, and by slides.
    let cuvette = "[[layer]]\npane = 1.5\n[[layer]]\nmaterial = \"*\"\n[[layer]]\npane = 1.5\n";
    let by_layers = layered(cuvette, Some("skim-milk"), &["1mm", "2mm"]).unwrap();
    let by_slides = sheet(Slab { slides: Some(1.5), ..material("skim-milk", "1mm,2mm") }).unwrap();
    assert_eq!(by_layers.answers, by_slides.answers);
    // Named in the file, it is the same.
    let named = cuvette.replace("\"*\"", "\"skim-milk\"\nthickness = \"1mm\"");
    let named = layered(&named, None, &[]).unwrap();
    assert_eq!(named.answers[..], by_slides.answers[..17]);
    close(named.cases[0].thickness_m.unwrap(), 1e-3, 1e-15);

    let error = layered(&half.repeat(2), Some("skim-milk"), &["1mm"]).unwrap_err();
    assert!(matches!(error, JobError::Slab(SlabError::NoPlace { .. })), "{error}");
    let error = layered(cuvette, None, &[]).unwrap_err();
    assert!(error.to_string().contains("the material is missing"), "{error}");
    let error = layered(cuvette, Some("skim-milk"), &["inf"]).unwrap_err();
    assert!(matches!(error, JobError::Slab(SlabError::EndlessAbove { layer: 2, layers: 3 })), "{error}");
}

/// Figures of every kind: spectra, a curve over thickness, a bar.
#[test]
fn figures_show_what_there_is() {
    let svg = |slab| sheet(slab).unwrap().svg().unwrap();
    let spectra = svg(material("skim-milk", "1mm,1cm"));
    for part in ["Reflectance", "Transmittance", "Absorptance", "Wavelength", "1 mm", "10 mm", "reflected"] {
        assert!(spectra.contains(part), "{part}");
    }
    let curve = svg(Slab { wavelengths: Some("550nm".into()), ..material("skim-milk", "1mm,1cm,10cm") });
    assert!(curve.contains("Thickness (mm)") && curve.contains("absorptance"));
    let bar = svg(medium(0.9, Some(0.75), "hg", "2"));
    assert!(bar.contains("passed unscattered 13.53 %") && bar.contains("reflected"), "{bar}");
    for text in [spectra, curve, bar] {
        assert!(!text.contains("NaN"));
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let hg = || medium(0.9, Some(0.75), "hg", "2");
    let cases: Vec<(Slab, &str)> = vec![
        (medium(1.1, Some(0.5), "hg", "1"), "albedo = 1.1"),
        (medium(f64::NAN, Some(0.5), "hg", "1"), "albedo = NaN"),
        (medium(0.9, Some(1.0), "hg", "1"), "g = 1"),
        (medium(0.9, None, "hg", "1"), "g is missing"),
        (medium(0.9, Some(0.1), "rayleigh", "1"), "g has no meaning"),
        (medium(0.9, None, "nowhere.csv", "1"), "nowhere.csv"),
        (indexed(hg(), 0.0), "refractive index 0"),
        (Slab { streams: Some(33), ..hg() }, "33 streams"),
        (Slab { streams: Some(0), ..hg() }, "0 streams"),
        (Slab { photons: Some(100), ..hg() }, "photons has no meaning"),
        (Slab { streams: Some(8), solver: Solver::MonteCarlo, ..hg() }, "streams has no meaning"),
        (Slab { photons: Some(0), solver: Solver::MonteCarlo, ..hg() }, "photons = 0"),
        (Slab { light: SlabLight::Angle(90.0), ..hg() }, "angle = 90"),
        (Slab { wavelengths: Some("550nm".into()), ..hg() }, "wavelengths has no meaning"),
        (Slab { backing: "white".parse().unwrap(), ..medium(0.9, Some(0.1), "hg", "inf") }, "backing has no meaning"),
        (Slab { wavelengths: Some("5nm".into()), ..material("water", "1mm") }, "5 nm"),
        (Slab { tolerance: 0.0, ..material("whole-milk", "1mm") }, "tolerance"),
    ];
    let folder = tempfile::tempdir().unwrap();
    for (slab, part) in cases {
        let output = Some(folder.path().join("out"));
        let error = run(Job::Slab(Slab { output, ..slab })).unwrap_err().to_string();
        assert!(error.contains(part), "{part}: {error}");
        assert!(!folder.path().join("out").exists(), "{part}");
    }
}

#[test]
fn jobs_are_written_down_and_read_back() {
    let slab = Slab { light: SlabLight::Angle(30.0), ..material("skim-milk", "1mm,inf") };
    for job in [
        Job::Slab(slab.clone()),
        Job::SlabCompare(SlabCompare { slab }),
        Job::Slab(medium(0.9, None, "x.csv", "1,inf")),
    ] {
        let text = serde_json::to_string(&job).unwrap();
        assert_eq!(serde_json::from_str::<Job>(&text).unwrap(), job, "{text}");
    }
    let short = r#"{"job": "slab", "sample": {"kind": "material", "material": "water", "thickness": ["1mm"]}}"#;
    assert_eq!(serde_json::from_str::<Job>(short).unwrap(), Job::Slab(material("water", "1mm")));
    assert!(serde_json::from_str::<Job>(&short.replace("\"job\"", "\"colour\": 1, \"job\"")).is_err());
}

#[test]
fn a_job_can_be_stopped_and_says_how_far_it_is() {
    let events = Mutex::new(Vec::new());
    let sink = |event| events.lock().unwrap().push(event);
    let job =
        Job::Slab(Slab { solver: Solver::MonteCarlo, photons: Some(20_000), ..medium(0.9, Some(0.5), "hg", "1,2") });
    job.run(&Context { sink: &sink, cancel: &AtomicBool::new(false) }).unwrap();
    let counted = |event: &Event| match event {
        Event::Progress { stage: Stage::Photons, done, total, .. } => Some((*done, *total)),
        _ => None,
    };
    assert_eq!(events.lock().unwrap().iter().filter_map(counted).next_back(), Some((40_000, Some(40_000))));
    let stopped = job.run(&Context { sink: &|_| {}, cancel: &AtomicBool::new(true) });
    assert!(matches!(stopped, Err(JobError::Cancelled)));
}
