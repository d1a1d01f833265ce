//! Scattering efficiencies over radius, phase functions in polar coordinates, and slabs of milk.
//!
//! `cargo run --release -p mieux --example scattering_figures -- docs` writes the figures of docs/scattering-figures.md and
//! docs/milk-slab.md.

use std::error::Error;
use std::f64::consts::PI;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use mieux::io::output::OutputDir;
use mieux::io::plot::{Figure, Panel, PolarPanel, Scale, Series, srgb_hex};
use mieux::io::quantity::significant;
use mieux::jobs::{Context, Job, Report, Sample, Slab, SlabSheet};
use mieux::optics::Complex64;
use mieux::optics::medium::{Inclusion, Medium};
use mieux::optics::mie::scatter_sphere;
use mieux::optics::particle::SizeDistribution;
use mieux::optics::phase::{HenyeyGreenstein, Isotropic, PhaseFunction, Rayleigh};
use mieux::optics::substance::Substance;
use mieux::optics::transfer::Shares;

const WAVELENGTH: f64 = 500e-9;
const VACUUM: Complex64 = Complex64::ONE;
const INDICES: [f64; 6] = [1.05, 1.1, 1.2, 1.33, 1.5, 2.0];
const RADII: u32 = 700;
const THICKNESSES: [&str; 3] = ["1mm", "1cm", "10cm"];

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    let folder = std::env::args().nth(1).map_or_else(|| PathBuf::from("out"), PathBuf::from);
    let dir = OutputDir::create(&folder)?;
    let figures = [
        ("scattering-efficiency", efficiencies()?),
        ("polar-phase-functions", phase_functions()?),
        ("milk-slab", milk()?),
    ];
    for (name, figure) in figures {
        let svg = figure.to_svg()?;
        dir.write(&format!("{name}.svg"), |out| out.write_all(svg.as_bytes()))?;
    }
    dir.commit();
    Ok(())
}

/// Of spheres without absorption in light of 500 nm: scattering over geometric cross section, and reduced scattering by a
/// volume of particles, on which hiding depends.
fn efficiencies() -> Outcome<Figure> {
    let radii: Vec<f64> = (0..RADII).map(|i| 10e-9 * 1e4f64.powf(f64::from(i) / f64::from(RADII - 1))).collect();
    let axis = "Radius (µm)";
    let mut efficiency =
        Panel::new("Scattering efficiency", axis, "Q = C/πr²").with_scales(Scale::Log, Scale::LinearOver(0.0, 6.0));
    let mut log_efficiency = Panel::new("The same, logarithmic", axis, "Q = C/πr²").with_scales(Scale::Log, Scale::Log);
    let mut hiding =
        Panel::new("Reduced scattering of a volume of particles", axis, "σₛ(1 − g) per volume share (1/µm)")
            .with_scales(Scale::Log, Scale::LinearOver(0.0, 1.0));
    let mut asymmetry = Panel::new("Mean cosine", axis, "g").with_scales(Scale::Log, Scale::LinearOver(0.0, 1.0));
    for m in INDICES {
        let found: Result<Vec<_>, _> =
            radii.iter().map(|r| scatter_sphere(*r, WAVELENGTH, VACUUM, Complex64::new(m, 0.0))).collect();
        let found = found?;
        let series = |value: &dyn Fn(usize) -> f64| {
            Series::new(format!("m = {m}"), radii.iter().enumerate().map(|(i, r)| (1e6 * r, value(i))))
        };
        let q = |i: usize| found[i].scattering / (PI * radii[i] * radii[i]);
        let reduced = |i: usize| 1e-6 * q(i) * (1.0 - found[i].asymmetry) * 0.75 / radii[i];
        efficiency = efficiency.with_series(series(&q));
        log_efficiency = log_efficiency.with_series(series(&|i| if q(i) > 1e-6 { q(i) } else { f64::NAN }));
        hiding = hiding.with_series(series(&reduced));
        asymmetry = asymmetry.with_series(series(&|i| found[i].asymmetry));
        let best = (0..radii.len()).max_by(|a, b| reduced(*a).total_cmp(&reduced(*b))).unwrap_or(0);
        show(&format!(
            "m = {m}: at most Q = {}; hides most at a radius of {} um, {} /um; Q at 100 um {}",
            significant((0..radii.len()).map(q).fold(0.0, f64::max), 3),
            significant(1e6 * radii[best], 3),
            significant(reduced(best), 3),
            significant(q(radii.len() - 1), 4)
        ))?;
    }
    Ok(Figure::new("Spheres in light of 500 nm, by relative refractive index m", 2)
        .with_panel(efficiency)
        .with_panel(log_efficiency)
        .with_panel(hiding)
        .with_panel(asymmetry))
}

/// A line of text on the terminal.
fn show(line: &str) -> Outcome<()> {
    use std::io::Write;
    Ok(writeln!(std::io::stdout(), "{line}")?)
}

/// In groups: without and with one parameter, and of spheres small and large.
fn phase_functions() -> Outcome<Figure> {
    let hg =
        |g: f64| -> Outcome<(String, PhaseFunction)> { Ok((format!("g = {g}"), HenyeyGreenstein::new(g)?.into())) };
    let sphere = |radius: f64| -> Outcome<(String, PhaseFunction)> {
        let sizes = SizeDistribution::monodisperse(radius)?;
        let substance = Substance::Constant(Complex64::new(1.33, 0.0));
        let sphere = Inclusion::new("sphere", substance, sizes, 1e-6);
        let medium = Medium::new(Substance::Constant(VACUUM), vec![sphere])?;
        Ok((format!("r = {} µm", significant(1e6 * radius, 3)), medium.phase_at(WAVELENGTH, 1e-3)?))
    };
    let groups: [(&str, Vec<(String, PhaseFunction)>); 3] = [
        ("Isotropic, Rayleigh", vec![("isotropic".into(), Isotropic.into()), ("Rayleigh".into(), Rayleigh.into())]),
        ("Henyey-Greenstein", vec![hg(0.3)?, hg(0.6)?, hg(0.9)?]),
        ("Spheres, m = 1.33", vec![sphere(0.05e-6)?, sphere(0.25e-6)?, sphere(2e-6)?]),
    ];
    let angles: Vec<f64> = (0..=360).map(|i| 0.5 * f64::from(i)).collect();
    let mut figure = Figure::new("Phase functions", 2);
    for (title, functions) in groups {
        let values = |function: &PhaseFunction| -> Vec<(f64, f64)> {
            angles.iter().map(|angle| (*angle, function.value(angle.to_radians().cos()))).collect()
        };
        let mut curves = functions.iter().map(|(_, function)| values(function));
        let first = curves.next().unwrap_or_default();
        let polar = curves.fold(PolarPanel::new("log₁₀ of the phase function (1/sr)", first), PolarPanel::with_curve);
        let plain = functions.iter().fold(
            Panel::new(title, "Scattering angle (degrees)", "Phase function (1/sr)")
                .with_scales(Scale::ScatteringAngle, Scale::Log),
            |panel, (name, function)| panel.with_series(Series::new(name, values(function))),
        );
        figure = figure.with_polar_panel(polar).with_panel(plain);
    }
    Ok(figure)
}

/// Skim and whole milk over black and over white: reflectance over wavelength, and colours.
fn milk() -> Outcome<Figure> {
    let mut figure = Figure::new("Slabs of milk over black and over white", 2);
    let mut patches = Vec::new();
    for (material, name) in [("skim-milk", "Skim milk"), ("whole-milk", "Whole milk")] {
        for backing in ["black", "white"] {
            let sheet = slab(material, backing)?;
            let nanometres: Vec<f64> = sheet.grid.iter().flat_map(|grid| grid.iter().map(|w| 1e9 * w)).collect();
            let reflectance: fn(&Shares) -> f64 = |shares| shares.reflectance;
            let mut panel = Panel::new(format!("{name} over {backing}"), "Wavelength in vacuum (nm)", "Reflectance")
                .with_scales(Scale::Linear, Scale::LinearOver(0.0, 1.0));
            for (case, answers) in sheet.cases.iter().zip(sheet.answers.chunks(nanometres.len())) {
                let points = nanometres.iter().copied().zip(answers.iter().map(|a| reflectance(&a.shares)));
                panel = panel.with_series(Series::new(case.label.clone(), points));
            }
            figure = figure.with_panel(panel);
            for patch in sheet.patches() {
                show(&format!("{name}, {} over {backing}: {}", patch.label, srgb_hex(patch.reflected)))?;
                let thickness = patch.label.replace(' ', "\u{a0}");
                patches.push((format!("{name} {thickness} over {backing}"), patch.reflected));
            }
        }
    }
    Ok(patches.into_iter().fold(figure, |figure, (label, colour)| figure.with_swatch(label, colour)))
}

fn slab(material: &str, backing: &str) -> Outcome<SlabSheet> {
    let thickness = THICKNESSES.iter().map(|text| text.parse()).collect::<Result<_, _>>()?;
    let sample = Sample::Material { material: material.into(), set: [].into(), thickness, index: None };
    let job = Job::Slab(Slab { backing: backing.parse()?, ..Slab::new(sample) });
    match job.run(&Context { sink: &|_| {}, cancel: &AtomicBool::new(false) })? {
        Report::Slab(report) => Ok(report.sheet),
        _ => Err("a slab has the report of a slab".into()),
    }
}
