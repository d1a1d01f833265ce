//! The jobs of one particle and of tables of them.

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use mieux::jobs::{Coat, Context, Event, Job, JobError, Mie, MieBatch, Report, Stage};

fn sphere(radius: &str, particle: &str) -> Mie {
    Mie::new(radius.parse().unwrap(), "550nm".parse().unwrap(), particle.parse().unwrap())
}

fn run(job: Job) -> Result<Report, JobError> {
    job.run(&Context { sink: &|_| {}, cancel: &AtomicBool::new(false) })
}

fn json(job: Mie) -> serde_json::Value {
    let Report::Mie(report) = run(Job::Mie(job)).unwrap() else { panic!() };
    let mut bytes = Vec::new();
    report.sheet.write_json(&mut bytes).unwrap();
    serde_json::from_slice(&bytes).unwrap()
}

/// Table 1 of Du (2004), Appl. Opt. 43, 1951; asymmetry is not given there.
#[test]
fn efficiencies_agree_with_a_published_table() {
    for (x, index, q_ext, q_sca) in [(10.0, "0.75", 2.232265, 2.232265), (1e4, "10+10i", 2.005914, 1.795393)] {
        let value = json(sphere(&format!("{}nm", x * 550.0 / std::f64::consts::TAU), index));
        for (key, expected) in [("q_ext", q_ext), ("q_sca", q_sca), ("size_parameter", x)] {
            let found = value[key].as_f64().unwrap();
            assert!((found - expected).abs() < 1e-6, "{key}: {found} is not {expected}");
        }
    }
}

/// The keys agree with each other as physics has it.
#[test]
fn json_is_consistent() {
    let job = Mie {
        host: "1.33".parse().unwrap(),
        angles: Some("0:180:0.25".parse().unwrap()),
        ..sphere("0.5um", "1.5+0.01i")
    };
    let value = json(job);
    let number = |key: &str| value[key].as_f64().unwrap();
    let array =
        |key: &str| -> Vec<f64> { value[key].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect() };
    let complex = |key: &str| -> Vec<[f64; 2]> { serde_json::from_value(value[key].clone()).unwrap() };
    assert!((number("c_ext_m2") / (number("c_sca_m2") + number("c_abs_m2")) - 1.0).abs() < 1e-12);
    let area = std::f64::consts::PI * 0.25e-12;
    for name in ["ext", "sca", "abs"] {
        assert!((number(&format!("q_{name}")) * area / number(&format!("c_{name}_m2")) - 1.0).abs() < 1e-12);
    }
    let angles = array("angle_deg");
    assert_eq!((angles.len(), angles[1], angles[720]), (721, 0.25, 180.0));
    // The phase function integrates to 1, and its mean cosine is g.
    let (p, step) = (array("phase_per_sr"), 0.25f64.to_radians());
    let integral = |f: &dyn Fn(f64) -> f64| -> f64 {
        let term = |(a, p): (&f64, &f64)| std::f64::consts::TAU * p * f(a.to_radians()) * a.to_radians().sin() * step;
        angles.iter().zip(&p).map(term).sum()
    };
    assert!((integral(&|_| 1.0) - 1.0).abs() < 1e-4, "{}", integral(&|_| 1.0));
    assert!((integral(&f64::cos) - number("g")).abs() < 1e-4);
    // Backward amplitudes are the radar cross section over k; both polarisations agree there.
    let (s1, s2) = (complex("s1"), complex("s2"));
    let back = s1[720][0].powi(2) + s1[720][1].powi(2);
    let x = number("size_parameter");
    assert!((4.0 * back / (x * x) / number("q_back") - 1.0).abs() < 1e-9);
    assert!((s1[720][0] + s2[720][0]).abs() < 1e-9 * back.sqrt());
    // Matrix elements follow from the amplitudes.
    for i in [0, 100, 333, 720] {
        let (i1, i2) = (s1[i][0].powi(2) + s1[i][1].powi(2), s2[i][0].powi(2) + s2[i][1].powi(2));
        let scale = p[i] / (i1 + i2);
        assert!((array("p12")[i] - scale * (i2 - i1)).abs() < 1e-9 * p[i]);
        let cross = s2[i][0] * s1[i][0] + s2[i][1] * s1[i][1];
        assert!((array("p33")[i] - 2.0 * scale * cross).abs() < 1e-9 * p[i]);
    }
    for (one, other) in [("p11", "phase_per_sr"), ("p22", "p11"), ("p21", "p12"), ("p44", "p33")] {
        assert_eq!(array(one), array(other));
    }
    assert!(array("p34").iter().zip(array("p43")).all(|(a, b)| *a == -b));
}

#[test]
fn definitions_differ_where_the_host_absorbs() {
    let job = |definition: &str| {
        let text = format!(
            r#"{{"radius":"20 µm","wavelength":"550nm","host":"1.33+1e-3i","particle":"1.5","definition":"{definition}"}}"#
        );
        serde_json::from_str::<Mie>(&text).unwrap()
    };
    let (ours, theirs) = (json(job("frisvad2007")), json(job("mishchenko-yang2018")));
    assert_eq!(ours["scattering_definition"], "frisvad2007");
    assert_eq!(theirs["scattering_definition"], "mishchenko-yang2018");
    assert!(theirs["q_sca"].as_f64().unwrap() > 1.1 * ours["q_sca"].as_f64().unwrap());
    assert_eq!(ours["size_parameter"].as_array().unwrap().len(), 2);
    let text = r#"{"job":"mie","radius":"1um","wavelength":"1um","particle":"1.5","colour":1}"#;
    assert!(serde_json::from_str::<Job>(text).is_err());
}

fn coat(radius: &str, index: &str) -> Coat {
    format!("{radius}:{index}").parse().unwrap()
}

/// A water core in soot, 1 % soot by volume, after Yang (2003), Appl. Opt. 42, 1710, as tabulated by n-mie 3a.
#[test]
fn a_coated_sphere_agrees_with_a_published_table() {
    let nanometres = |x: f64| format!("{:e}nm", x * 550.0 / std::f64::consts::TAU);
    let soot = coat(&nanometres(10.1), "1.59+0.66i");
    let value = json(Mie { layers: vec![soot], ..sphere(&nanometres(10.066556046521), "1.33") });
    for (key, expected) in [("q_ext", 2.11636), ("q_sca", 1.92025), ("q_back", 0.215581)] {
        let found = value[key].as_f64().unwrap();
        assert!((found / expected - 1.0).abs() < 5e-6, "{key}: {found} is not {expected}");
    }
    assert!((value["size_parameter"].as_f64().unwrap() - 10.1).abs() < 1e-9);
}

/// Layers of one index are one sphere.
#[test]
fn layers_alike_are_no_layers() {
    let layers = vec![coat("300nm", "1.5+0.01i"), coat("0.5um", "1.5+0.01i")];
    let angles = Some("0:180:10".parse().unwrap());
    let layered = json(Mie { layers, angles, ..sphere("0.2um", "1.5+0.01i") });
    let whole = json(Mie { angles, ..sphere("0.5um", "1.5+0.01i") });
    for key in ["c_ext_m2", "q_abs", "q_back", "g", "radius_m"] {
        let (a, b) = (layered[key].as_f64().unwrap(), whole[key].as_f64().unwrap());
        assert!((a / b - 1.0).abs() < 1e-10, "{key}: {a} {b}");
    }
    for i in 0..19 {
        let at = |value: &serde_json::Value| value["phase_per_sr"][i].as_f64().unwrap();
        assert!((at(&layered) / at(&whole) - 1.0).abs() < 1e-9, "{i}");
    }
}

#[test]
fn layers_ascend() {
    let job = Mie { layers: vec![coat("600nm", "1.4"), coat("600nm", "1.3")], ..sphere("0.5um", "1.5") };
    let error = run(Job::Mie(job)).unwrap_err();
    assert!(matches!(error, JobError::Layers { number: 2, .. }), "{error:?}");
}

const HEAD: &str = "name,particle_im,particle_re,host_im,host_re,wavelength_um,radius_um";

/// Rows of spheres from small to large, absorbing and not, in a random order.
fn table(rows: usize) -> String {
    let mut text = format!("{HEAD}\n");
    for i in 0..rows {
        let u = (i as f64 * 0.618_033_988_749_895).fract();
        let (radius, im) = (0.01 * 10f64.powf(3.0 * u), if i % 3 == 0 { 0.01 * u } else { 0.0 });
        text += &format!(
            "\"row, {i}\",{im},{},{},1.33,0.55,{radius}\n",
            1.4 + 0.2 * u,
            if i % 5 == 0 { 1e-5 } else { 0.0 }
        );
    }
    text
}

fn batch(folder: &Path, name: &str, threads: usize) -> MieBatch {
    MieBatch { threads: Some(threads), ..MieBatch::new(folder.join("in.csv"), folder.join(name)) }
}

#[test]
fn a_table_is_the_same_on_any_number_of_threads_and_the_same_as_one_by_one() {
    let folder = tempfile::tempdir().unwrap();
    let rows = 70_000;
    std::fs::write(folder.path().join("in.csv"), table(rows)).unwrap();
    let told = Mutex::new(Vec::new());
    let sink = |event: Event| {
        if let Event::Progress { stage: Stage::Spheres, done, total, .. } = event {
            told.lock().unwrap().push((done, total.unwrap()));
        }
    };
    for threads in [1, 3] {
        let job = Job::MieBatch(batch(folder.path(), &format!("{threads}.csv"), threads));
        let Report::MieBatch(report) = job.run(&Context { sink: &sink, cancel: &AtomicBool::new(false) }).unwrap()
        else {
            panic!()
        };
        assert_eq!(report.rows, rows as u64);
    }
    let told = told.into_inner().unwrap();
    assert!(told.len() == 4 && told[1] == (rows as u64, rows as u64), "{told:?}");
    assert!(told[0].0 < told[0].1 && (told[0].1 as f64 / rows as f64 - 1.0).abs() < 0.05, "{told:?}");
    let text = std::fs::read_to_string(folder.path().join("1.csv")).unwrap();
    assert!(text == std::fs::read_to_string(folder.path().join("3.csv")).unwrap());
    let input = table(rows);
    let pairs: Vec<(&str, &str)> = input.lines().zip(text.lines()).collect();
    assert_eq!(pairs.len(), rows + 1);
    assert!(pairs.iter().all(|(before, after)| after.starts_with(before)));
    assert_eq!(pairs[0].1, format!("{HEAD},{}", MieBatch::RESULTS.join(",")));
    for (before, after) in pairs.iter().skip(1).step_by(997) {
        let field = |i: usize| before.rsplit(',').nth(i).unwrap();
        let one = json(Mie {
            host: format!("{}+{}i", field(2), field(3)).parse().unwrap(),
            ..sphere(&format!("{}um", field(0)), &format!("{}+{}i", field(4), field(5)))
        });
        for (i, key) in MieBatch::RESULTS.iter().rev().enumerate() {
            let found: f64 = after.rsplit(',').nth(i).unwrap().parse().unwrap();
            let of = |key: &str| one[key].as_f64().unwrap();
            let expected = of(key);
            let scale = match &key[..1] {
                "c" => of("c_sca_m2").max(of("c_abs_m2").abs()),
                "q" => of("q_sca").max(of("q_abs").abs()),
                _ => 1.0,
            };
            assert!((found - expected).abs() < 1e-10 * scale, "{before}: {key} {found} {expected}");
        }
    }
}

/// Spheres in one table may be as unlike each other as they can.
#[test]
fn sizes_far_apart_do_not_disturb_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = "radius_um,wavelength_um,host_re,host_im,particle_re,particle_im\n".to_owned();
    for i in 0..24 {
        text += &format!("{},0.55,1,0,1.33,0\n", 0.001 * 2f64.powi(i));
    }
    std::fs::write(folder.path().join("in.csv"), text).unwrap();
    run(Job::MieBatch(batch(folder.path(), "out.csv", 1))).unwrap();
    let text = std::fs::read_to_string(folder.path().join("out.csv")).unwrap();
    for line in text.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let one = json(sphere(&format!("{}um", fields[0]), "1.33"));
        let (q, g): (f64, f64) = (fields[9].parse().unwrap(), fields[12].parse().unwrap());
        assert!((q / one["q_ext"].as_f64().unwrap() - 1.0).abs() < 1e-10, "{line}");
        assert!((g - one["g"].as_f64().unwrap()).abs() < 1e-10, "{line}");
    }
}

#[test]
fn a_batch_that_stops_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("in.csv"), table(70_000)).unwrap();
    std::fs::write(folder.path().join("out.csv"), "before").unwrap();
    let cancel = AtomicBool::new(false);
    let sink = |event: Event| {
        if matches!(event, Event::Progress { .. }) {
            cancel.store(true, Ordering::Relaxed);
        }
    };
    let job = Job::MieBatch(batch(folder.path(), "out.csv", 2));
    let error = job.run(&Context { sink: &sink, cancel: &cancel }).unwrap_err();
    assert!(matches!(error, JobError::Cancelled));
    assert_eq!(std::fs::read_to_string(folder.path().join("out.csv")).unwrap(), "before");
    assert_eq!(folder.path().read_dir().unwrap().count(), 2);
}

/// Of two mistakes the first is told, whatever the number of threads.
#[test]
fn the_first_bad_row_is_told() {
    let folder = tempfile::tempdir().unwrap();
    for (bad, part) in [
        ("x,0,1.5,0,1.33,0.55,-0.5", "column `radius_um`: `-0.5` is no radius"),
        ("x,0,1.5,0,1.33,0,0.5", "column `wavelength_um`: `0` is no wavelength"),
        ("x,0,1.5,-1e-3,1.33,0.55,0.5", "column `host_im`: `-1e-3`"),
        ("x,0,0,0,1.33,0.55,0.5", "column `particle_re`: `0`"),
        ("x,-1,1.5,0,1.33,0.55,0.5", "column `particle_im`: `-1`"),
        ("x,0,1.5,0,1.33,0.55,1e9", "column `radius_um`: `1e9` makes a particle that cannot be computed: size"),
        ("x,0,1.5,0.1,1.33,0.55,1e4", "column `radius_um`: `1e4` makes a particle that cannot be computed: the host"),
        ("x,0,1.5,0,n,0.55,1e9", "column `host_re`: `n` is not a number"),
        ("x,0,1.5,0,1.33,0.55", "6 fields where there are 7 columns"),
    ] {
        let mut lines: Vec<String> = table(66_000).lines().map(str::to_owned).collect();
        lines[65_900] = "x,0,1.5,0,1.33,0.55,second mistake".into();
        lines[60_000] = bad.into();
        std::fs::write(folder.path().join("in.csv"), lines.join("\r\n")).unwrap();
        for threads in [1, 3] {
            let error = run(Job::MieBatch(batch(folder.path(), "out.csv", threads))).unwrap_err().to_string();
            assert!(error.contains("in.csv, line 60001") && error.contains(part), "{part}: {error}");
        }
        assert_eq!(folder.path().read_dir().unwrap().count(), 1);
    }
}
