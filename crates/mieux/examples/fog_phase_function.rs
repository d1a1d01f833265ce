//! Lorenz-Mie theory of water droplets against the published fit for fog (`jendersie2023s`), over the diameter.
//!
//! `cargo run --release -p mieux --example fog_phase_function -- docs` writes the figures and the table of
//! docs/fog-phase-function.md.

use std::error::Error;
use std::io::Write;
use std::path::PathBuf;

use mieux::io::output::OutputDir;
use mieux::io::plot::{Figure, Panel, Scale, Series};
use mieux::io::table::Table;
use mieux::optics::Complex64;
use mieux::optics::medium::{Inclusion, Medium};
use mieux::optics::mie::scatter_sphere;
use mieux::optics::particle::{LogNormal, SizeDistribution, Weighting};
use mieux::optics::phase::{HenyeyGreenstein, PhaseFunction, WaterDroplet, compare};
use mieux::optics::substance::{Substance, Water};
use rayon::prelude::*;

const GREEN: f64 = 550e-9;
const AIR: Complex64 = Complex64::ONE;
const SMALLEST: f64 = 0.01e-6;
const JOINTS: [f64; 3] = [0.1e-6, 1.5e-6, 5e-6];
/// Diameters of the curve of mean cosines, and of that of distances, which takes a phase function each.
const FINE: u32 = 1200;
const COARSE: u32 = 120;
/// Geometric standard deviation, by number, of the droplets that are averaged; four wavelengths away from one size.
const SPREAD: f64 = 1.1;

type Outcome<T> = Result<T, Box<dyn Error + Send + Sync>>;

fn main() -> Outcome<()> {
    let folder = std::env::args().nth(1).map_or_else(|| PathBuf::from("out"), PathBuf::from);
    let dir = OutputDir::create(&folder)?;
    let cosines = cosines()?;
    let distances = distances()?;
    let table = table(&distances)?;
    let figure = figure(&cosines, &distances);
    let svg = figure.to_svg()?;
    dir.write("fog-phase-function.svg", |out| out.write_all(svg.as_bytes()))?;
    dir.write("fog-phase-function.csv", |out| table.write_csv(out))?;
    dir.commit();
    Ok(std::io::stdout().write_all(table.to_text(4).as_bytes())?)
}

/// Geometric from the smallest to the largest of the fit, with both sides of every joint.
fn diameters(count: u32) -> Vec<f64> {
    let ratio = WaterDroplet::MAX_DIAMETER_M / SMALLEST;
    let mut all: Vec<f64> =
        (0..count).map(|i| SMALLEST * ratio.powf(f64::from(i) / f64::from(count - 1)).min(ratio)).collect();
    all.extend(JOINTS.iter().flat_map(|joint| [joint * (1.0 - 1e-9), *joint, joint * (1.0 + 1e-9)]));
    all.sort_by(f64::total_cmp);
    all
}

fn water(wavelength: f64) -> Outcome<Complex64> {
    Ok(Substance::Water(Water::ROOM).index(wavelength)?)
}

/// Mean cosines over the diameter.
struct Cosines {
    diameters: Vec<f64>,
    green: Vec<f64>,
    visible: Vec<f64>,
    fit: Vec<f64>,
}

fn cosines() -> Outcome<Cosines> {
    let diameters = diameters(FINE);
    let green = |d: &f64| Ok(scatter_sphere(0.5 * d, GREEN, AIR, water(GREEN)?)?.asymmetry);
    let visible = |d: &f64| visible(*d);
    let fit = |d: &f64| Ok(WaterDroplet::new(*d)?.asymmetry());
    Ok(Cosines {
        green: diameters.par_iter().map(green).collect::<Outcome<_>>()?,
        visible: diameters.par_iter().map(visible).collect::<Outcome<_>>()?,
        fit: diameters.iter().map(fit).collect::<Outcome<_>>()?,
        diameters,
    })
}

/// Mean cosine of a droplet in visible light, each wavelength by how much of it is scattered.
fn visible(diameter: f64) -> Outcome<f64> {
    let (mut scattering, mut forward) = (0.0, 0.0);
    for wavelength in (0..=30).map(|i| 400e-9 + 10e-9 * f64::from(i)) {
        let found = scatter_sphere(0.5 * diameter, wavelength, AIR, water(wavelength)?)?;
        scattering += found.scattering;
        forward += found.scattering * found.asymmetry;
    }
    Ok(forward / scattering)
}

/// How far from Lorenz-Mie theory the fit is, and a Henyey-Greenstein lobe of the right mean cosine.
struct Distance {
    diameter: f64,
    g: f64,
    visible_g: f64,
    fit_g: f64,
    /// Root mean square difference of logarithms, and share of the light elsewhere: of the fit, of the lobe.
    fit: [f64; 2],
    lobe: [f64; 2],
    /// Of the fit, from the green light of a single size.
    single: [f64; 2],
}

fn distances() -> Outcome<Vec<Distance>> {
    diameters(COARSE).into_par_iter().map(distance).collect()
}

fn distance(diameter: f64) -> Outcome<Distance> {
    let sizes = LogNormal::from_median(Weighting::Number, 0.5 * diameter, SPREAD)?;
    let exact = droplets(SizeDistribution::LogNormal(sizes))?;
    let single = droplets(SizeDistribution::monodisperse(0.5 * diameter)?)?;
    let fit: PhaseFunction = WaterDroplet::new(diameter)?.into();
    let lobe = HenyeyGreenstein::new(exact.asymmetry())?.into();
    let far = |exact: &PhaseFunction, other: &PhaseFunction| {
        let c = compare(exact, other);
        [c.rms_log10, c.total_variation]
    };
    Ok(Distance {
        diameter,
        g: exact.asymmetry(),
        visible_g: visible(diameter)?,
        fit_g: fit.asymmetry(),
        fit: far(&exact, &fit),
        lobe: far(&exact, &lobe),
        single: far(&single, &fit),
    })
}

fn droplets(sizes: SizeDistribution) -> Outcome<PhaseFunction> {
    let water = Substance::Water(Water::ROOM);
    let droplets = Inclusion::new("droplets", water, sizes, 1e-6);
    Ok(Medium::new(Substance::Constant(AIR), vec![droplets])?.phase_at(GREEN, 2e-3)?)
}

fn figure(cosines: &Cosines, distances: &[Distance]) -> Figure {
    let axis = "Diameter (µm)";
    let over = |values: &[f64]| -> Vec<(f64, f64)> {
        cosines.diameters.iter().map(|d| d * 1e6).zip(values.iter().copied()).collect()
    };
    let of = |value: fn(&Distance) -> f64| -> Vec<(f64, f64)> {
        distances.iter().map(|d| (d.diameter * 1e6, value(d))).collect()
    };
    let cosine = |title: &str, g: Scale| {
        Panel::new(title, axis, "Mean cosine g")
            .with_scales(Scale::Log, g)
            .with_series(Series::new("Mie, 550 nm", over(&cosines.green)))
            .with_series(Series::new("Mie, 400 to 700 nm", over(&cosines.visible)))
            .with_series(Series::new("fog fit", over(&cosines.fit)))
    };
    let difference: Vec<f64> = cosines.fit.iter().zip(&cosines.visible).map(|(a, b)| a - b).collect();
    let panel = |title: &str, label: &str, scale: Scale| Panel::new(title, axis, label).with_scales(Scale::Log, scale);
    Figure::new("Water droplets in air: Lorenz-Mie theory and the fog fit", 2)
        .with_panel(cosine("Mean cosine", Scale::LinearOver(0.0, 1.0)))
        .with_panel(
            panel("Mean cosine of the fit less that of Mie, 400 to 700 nm", "Difference of g", Scale::Linear)
                .with_series(Series::new("", over(&difference))),
        )
        .with_panel(
            panel("Distance from Mie at 550 nm", "rms of log₁₀ p, over solid angle", Scale::LinearOver(0.0, 0.6))
                .with_series(Series::new("fog fit, sizes ± 10 %", of(|d| d.fit[0])))
                .with_series(Series::new("HG of the same g", of(|d| d.lobe[0])))
                .with_series(Series::new("fog fit, one size", of(|d| d.single[0]))),
        )
        .with_panel(
            panel("Light that goes elsewhere", "Total variation", Scale::LinearOver(0.0, 0.6))
                .with_series(Series::new("fog fit, sizes ± 10 %", of(|d| d.fit[1])))
                .with_series(Series::new("HG of the same g", of(|d| d.lobe[1])))
                .with_series(Series::new("fog fit, one size", of(|d| d.single[1]))),
        )
}

fn table(distances: &[Distance]) -> Outcome<Table> {
    let of = |value: fn(&Distance) -> f64| distances.iter().map(value).collect::<Vec<f64>>();
    let columns: [(&str, &str, Vec<f64>); 10] = [
        ("diameter", "um", of(|d| d.diameter * 1e6)),
        ("g_mie", "", of(|d| d.g)),
        ("g_mie_visible", "", of(|d| d.visible_g)),
        ("g_fit", "", of(|d| d.fit_g)),
        ("rms_log10_fit", "", of(|d| d.fit[0])),
        ("total_variation_fit", "", of(|d| d.fit[1])),
        ("rms_log10_hg", "", of(|d| d.lobe[0])),
        ("total_variation_hg", "", of(|d| d.lobe[1])),
        ("rms_log10_fit_one_size", "", of(|d| d.single[0])),
        ("total_variation_fit_one_size", "", of(|d| d.single[1])),
    ];
    let mut table = Table::new("Water droplets in air at 550 nm against the fog fit of jendersie2023s")
        .with_metadata("sizes", format!("log-normal by number, geometric standard deviation {SPREAD}"));
    for (name, unit, values) in columns {
        table = table.with_column(name, unit, values)?;
    }
    Ok(table)
}
