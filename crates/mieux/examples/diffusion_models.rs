//! The diffusion models against photons: how much light leaves at which distance from a pencil beam. And diffusion
//! through layers against discrete ordinates.
//!
//! `cargo run --release -p mieux --example diffusion_models -- docs` writes the figure and the table of docs/diffusion.md;
//! a number after the folder is that of the photons for each medium (400 000 without).

use std::error::Error;
use std::f64::consts::PI;
use std::io::Write;
use std::path::PathBuf;

use mieux::io::output::OutputDir;
use mieux::io::plot::{Figure, Panel, Scale, Series};
use mieux::io::table::Table;
use mieux::optics::phase::{HenyeyGreenstein, PhaseFunction};
use mieux::optics::transfer::diffusion::{DiffusionMedium, DiffusionModel, Profile, shares};
use mieux::optics::transfer::{DiscreteOrdinates, Incidence, Layer, Moments, Stack};
use mieux::render::detector::slab::{Rings, SlabWalk};
use mieux::render::render::Flow;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Reduced albedo, g, relative index, and what it is like.
const CASES: [(f64, f64, f64, &str); 4] = [
    (0.9977, 0.954, 1.347, "whole milk at 550 nm: reduced albedo 0.9977, g 0.954, index 1.347"),
    (0.99, 0.0, 1.0, "reduced albedo 0.99, isotropic, no surface"),
    (0.9, 0.8, 1.5, "reduced albedo 0.9, g 0.8, index 1.5"),
    (0.5, 0.0, 1.3, "reduced albedo 0.5, isotropic, index 1.3"),
];

/// Rings from 0.02 to 30 transport mean free paths, by factors.
const RINGS: u32 = 24;
const FIRST: f64 = 0.02;
const LAST: f64 = 30.0;

/// Ranges of distance over which differences are averaged, in transport mean free paths.
const RANGES: [[f64; 2]; 3] = [[0.02, 1.0], [1.0, 4.0], [4.0, 12.0]];

struct Measured {
    /// Middle of each ring, in transport mean free paths.
    middles: Vec<f64>,
    /// Power per area and its error, for light that has entered, times the square of the path.
    values: Vec<f64>,
    errors: Vec<f64>,
    total: f64,
}

struct Modelled {
    model: DiffusionModel,
    /// Mean over each ring, as measured.
    values: Vec<f64>,
    total: f64,
}

fn main() -> Outcome<()> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().map_or_else(|| PathBuf::from("out"), PathBuf::from);
    let photons: u64 = arguments.next().map_or(Ok(400_000), |text| text.parse())?;
    let dir = OutputDir::create(&folder)?;
    let mut figure = Figure::new("Light around a pencil beam: diffusion models and photons", 2);
    let mut report = String::new();
    let mut columns: Vec<(String, Vec<f64>)> = Vec::new();
    for (index, (albedo, g, eta, name)) in CASES.into_iter().enumerate() {
        let medium = DiffusionMedium::new(1.0 - albedo, albedo / (1.0 - g), g, eta)?;
        let measured = measure(&medium, photons)?;
        let modelled: Vec<Modelled> =
            DiffusionModel::ALL.into_iter().map(|model| of_model(model, &medium)).collect::<Outcome<_>>()?;
        figure = panels(figure, name, &measured, &modelled);
        report += &summary(name, &medium, &measured, &modelled)?;
        if index == 0 {
            columns.push(("distance".into(), measured.middles.clone()));
        }
        columns.push((format!("photons_{index}"), measured.values));
        columns.push((format!("error_{index}"), measured.errors));
        for of in modelled {
            columns.push((format!("{}_{index}", of.model.name().replace('-', "_")), of.values));
        }
    }
    let svg = figure.to_svg()?;
    dir.write("diffusion.svg", |out| out.write_all(svg.as_bytes()))?;
    let mut table = Table::new(
        "Power that leaves per area around a pencil beam that has entered, per transport mean free path squared",
    );
    for (index, (_, _, _, name)) in CASES.into_iter().enumerate() {
        table = table.with_metadata(format!("medium {index}"), name);
    }
    for (name, values) in columns {
        table = table.with_column(&name, "", values)?;
    }
    dir.write("diffusion.csv", |out| table.write_csv(out))?;
    dir.commit();
    report += &layers()?;
    Ok(std::io::stdout().write_all(report.as_bytes())?)
}

fn edges() -> Vec<f64> {
    (0..=RINGS).map(|k| FIRST * (LAST / FIRST).powf(f64::from(k) / f64::from(RINGS))).collect()
}

/// Coefficients are per transport mean free path, so that lengths are in its units.
fn measure(medium: &DiffusionMedium, photons: u64) -> Outcome<Measured> {
    let phase = PhaseFunction::from(HenyeyGreenstein::new(medium.asymmetry())?);
    let depth = 200.0;
    let layer = Layer::new(depth * medium.sigma_t(), medium.albedo(), Moments::of(&phase, 2)?);
    let eta = medium.relative_index();
    let stack = Stack { below: eta, ..Stack::slab(layer.with_index(eta)) };
    let mut walk = SlabWalk::new(stack, vec![phase], Incidence::NORMAL, photons, 1);
    walk.rings = Some(Rings { edges: edges(), thickness: vec![depth] });
    let counts = walk.run(&mut |_| Flow::Continue)?;
    let rings: Vec<_> = counts.radial_up.as_ref().map(|found| found.rings().collect()).unwrap_or_default();
    let entering = medium.entering();
    Ok(Measured {
        middles: rings.iter().map(|([from, to], _)| (from * to).sqrt()).collect(),
        values: rings.iter().map(|(_, found)| found.value / entering).collect(),
        errors: rings.iter().map(|(_, found)| found.error / entering).collect(),
        total: (counts.reflectance.value - counts.reflectance_specular.value) / entering,
    })
}

fn of_model(model: DiffusionModel, medium: &DiffusionMedium) -> Outcome<Modelled> {
    let profile = Profile::new(model, medium)?;
    // Boole's rule over the logarithm of the distance.
    let mean = |ends: &[f64]| {
        let step = (ends[1] / ends[0]).ln() / 4.0;
        let at = |k: f64| {
            let r = ends[0] * (k * step).exp();
            2.0 * PI * r * r * profile.reflectance(r)
        };
        let power = 2.0 * step / 45.0 * (7.0 * (at(0.0) + at(4.0)) + 32.0 * (at(1.0) + at(3.0)) + 12.0 * at(2.0));
        power / (PI * (ends[1] - ends[0]) * (ends[1] + ends[0]))
    };
    Ok(Modelled { model, values: edges().windows(2).map(mean).collect(), total: profile.total() })
}

fn panels(figure: Figure, name: &str, measured: &Measured, modelled: &[Modelled]) -> Figure {
    let axis = "Distance (transport mean free paths)";
    let middles = &measured.middles;
    let power = |values: &[f64]| -> Vec<(f64, f64)> {
        middles.iter().zip(values).map(|(r, value)| (*r, 2.0 * PI * r * r * value)).collect()
    };
    let ratio = |values: &[f64]| -> Vec<(f64, f64)> {
        // Where photons are too few, nothing is compared.
        let known = |k: &usize| measured.errors[*k] < 0.1 * measured.values[*k];
        (0..middles.len()).filter(known).map(|k| (middles[k], values[k] / measured.values[k])).collect()
    };
    let mut left = Panel::new(name, axis, "Power per unit of ln r").with_scales(Scale::Log, Scale::Linear);
    let mut right = Panel::new("Models over photons", axis, "Ratio").with_scales(Scale::Log, Scale::Log);
    for of in modelled {
        left = left.with_series(Series::new(of.model.name(), power(&of.values)));
        right = right.with_series(Series::new("", ratio(&of.values)));
    }
    let left = left.with_series(Series::new("photons", power(&measured.values)));
    figure.with_panel(left).with_panel(right)
}

/// For each model its total, and by how much it is off in each range: the power that is missing or too much there, over what
/// is there, as it is and with its energy made right.
fn summary(name: &str, medium: &DiffusionMedium, measured: &Measured, modelled: &[Modelled]) -> Outcome<String> {
    let exact = medium.exact_total()?;
    let mut text = format!("{name}\n  total {exact:.4}, of photons {:.4}\n", measured.total);
    let edges = edges();
    for of in modelled {
        let scale = exact / of.total;
        text += &format!("  {:<19} total {:.4}", of.model.name(), of.total);
        for [from, to] in RANGES {
            let (mut there, mut off, mut off_scaled) = (0.0, 0.0, 0.0);
            for (k, ends) in edges.windows(2).enumerate() {
                if measured.middles[k] > from && measured.middles[k] < to {
                    let area = ends[1] * ends[1] - ends[0] * ends[0];
                    there += area * measured.values[k];
                    off += area * (of.values[k] - measured.values[k]).abs();
                    off_scaled += area * (scale * of.values[k] - measured.values[k]).abs();
                }
            }
            text += &format!("  {from} to {to}: {:5.1} % ({:5.1} %)", 100.0 * off / there, 100.0 * off_scaled / there);
        }
        text += "\n";
    }
    Ok(text)
}

/// Reflectance and transmittance of one layer by diffusion less those by discrete ordinates.
fn layers() -> Outcome<String> {
    let albedos = [0.3, 0.5, 0.7, 0.9, 0.99, 0.999, 1.0];
    let mut text = String::new();
    for (incidence, name) in [(Incidence::NORMAL, "along the normal"), (Incidence::Diffuse, "diffuse")] {
        for (index, g) in [(1.0, 0.0), (1.5, 0.0), (1.5, 0.8)] {
            text +=
                &format!("layer of index {index}, g {g}, light {name}: R and T, diffusion less discrete ordinates\n");
            text += &format!("  thickness  {}\n", albedos.map(|albedo| format!("albedo {albedo:<9}")).join(" "));
            for thickness in [0.1, 0.5, 1.0, 2.0, 5.0, 10.0, 30.0] {
                text += &format!("  {thickness:<9} ");
                for reduced in albedos {
                    let albedo = reduced / (1.0 - g + reduced * g);
                    let layer = Layer::new(thickness / (1.0 - albedo * g), albedo, Moments::henyey_greenstein(g)?);
                    let stack = Stack::slab(layer.with_index(index));
                    let (ours, exact) =
                        (shares(&stack, incidence)?, DiscreteOrdinates::default().shares(&stack, incidence)?);
                    let [r, t] = [ours.reflectance - exact.reflectance, ours.transmittance - exact.transmittance];
                    text += &format!(" {r:+.4} {t:+.4} ");
                }
                text += "\n";
            }
        }
    }
    Ok(text)
}
