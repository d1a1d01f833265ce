//! Hiding power over thickness, and two fluxes against many streams.
//!
//! `cargo run --release -p mieux --example kubelka_munk -- docs` writes the figures of docs/paints.md.

use std::error::Error;
use std::io::Write;
use std::path::PathBuf;

use mieux::io::output::OutputDir;
use mieux::io::plot::{Figure, Panel, Scale, Series};
use mieux::io::table::Table;
use mieux::optics::transfer::kubelka_munk::{Chart, Film, shares};
use mieux::optics::transfer::{DiscreteOrdinates, Incidence, Layer, Moments, Stack};

/// Of films: name, K and S, 1/mm.
const FILMS: [(&str, f64, f64); 4] = [
    ("white, K/S = 0.001", 0.06, 60.0),
    ("grey, K/S = 0.1", 6.0, 60.0),
    ("dark, K/S = 1", 60.0, 60.0),
    ("thin white, S = 15/mm", 0.015, 15.0),
];
const STREAMS: usize = 32;
const THICK: f64 = 1e5;

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    let folder = std::env::args().nth(1).map_or_else(|| PathBuf::from("out"), PathBuf::from);
    let dir = OutputDir::create(&folder)?;
    let hiding = hiding()?.to_svg()?;
    let (against, table) = against_streams()?;
    let against = against.to_svg()?;
    dir.write("paint-hiding.svg", |out| out.write_all(hiding.as_bytes()))?;
    dir.write("kubelka-munk-against-streams.svg", |out| out.write_all(against.as_bytes()))?;
    dir.write("kubelka-munk-against-streams.csv", |out| table.write_csv(out))?;
    dir.commit();
    Ok(std::io::stdout().write_all(table.to_text(4).as_bytes())?)
}

/// Contrast ratio, and what is seen over both halves of the chart, over thickness.
fn hiding() -> Outcome<Figure> {
    let chart = Chart::default();
    let micrometres: Vec<f64> = (0..=150).map(|i| f64::from(i) * 2.0).collect();
    let mut ratio =
        Panel::new("Contrast ratio over a chart of 0 and 0.8", "Thickness (µm)", "R over black / R over white")
            .with_scales(Scale::Linear, Scale::LinearOver(0.0, 1.0));
    for (name, k, s) in FILMS {
        let film = Film::new(1e3 * k, 1e3 * s, 0.0)?;
        let mut points = Vec::new();
        for um in &micrometres {
            points.push((*um, chart.contrast_ratio(&film.with_thickness(um * 1e-6)?)?));
        }
        ratio = ratio.with_series(Series::new(name, points));
    }
    let complete = micrometres.iter().map(|um| (*um, Chart::COMPLETE));
    ratio = ratio.with_series(Series::new("complete: 0.98", complete));
    let mut both = Panel::new("Reflectance of the grey film over both halves", "Thickness (µm)", "Reflectance")
        .with_scales(Scale::Linear, Scale::LinearOver(0.0, 0.8));
    let (_, k, s) = FILMS[1];
    let film = Film::new(1e3 * k, 1e3 * s, 0.0)?;
    for (name, backing) in [("over black", chart.black), ("over white", chart.white)] {
        let mut points = Vec::new();
        for um in &micrometres {
            points.push((*um, film.with_thickness(um * 1e-6)?.reflectance_over(backing)?));
        }
        both = both.with_series(Series::new(name, points));
    }
    Ok(Figure::new("Hiding power of films without surface", 2).with_panel(ratio).with_panel(both))
}

/// Reflectance of thick matter by two fluxes, by both pairs of K and S, and by many streams; over the albedo.
fn against_streams() -> Outcome<(Figure, Table)> {
    let mut albedos: Vec<f64> = (2..=38).map(|i| f64::from(i) / 40.0).collect();
    albedos.extend([0.97, 0.98, 0.99, 0.995, 0.998, 0.999]);
    let cases = [
        ("g 0, n 1, diffuse", 0.0, 1.0, Incidence::Diffuse),
        ("g 0.8, n 1, diffuse", 0.8, 1.0, Incidence::Diffuse),
        ("g 0, n 1, normal", 0.0, 1.0, Incidence::NORMAL),
        ("g 0, n 1.5, diffuse", 0.0, 1.5, Incidence::Diffuse),
    ];
    let mut reflectance = Panel::new("Thick, isotropic, index 1, diffuse light", "Albedo", "Reflectance")
        .with_scales(Scale::LinearOver(0.0, 1.0), Scale::LinearOver(0.0, 1.0));
    let mut errors = Panel::new("Two fluxes less 32 streams, relative", "Albedo", "Error (%)")
        .with_scales(Scale::LinearOver(0.0, 1.0), Scale::Linear);
    let mut table =
        Table::new("Reflectance of thick matter: two fluxes (K = 2 sigma_a, S = 3/4 sigma_s') against 32 streams")
            .with_column("albedo", "", albedos.clone())?;
    let solver = DiscreteOrdinates::with_streams(STREAMS)?;
    for (i, (name, g, index, incidence)) in cases.into_iter().enumerate() {
        let (mut two, mut many) = (Vec::new(), Vec::new());
        for &albedo in &albedos {
            let stack = Stack::slab(Layer::new(THICK, albedo, Moments::henyey_greenstein(g)?).with_index(index));
            two.push(shares(&stack, incidence)?.reflectance);
            many.push(solver.shares(&stack, incidence)?.reflectance);
        }
        let error: Vec<f64> = two.iter().zip(&many).map(|(two, many)| 100.0 * (two / many - 1.0)).collect();
        let over = |values: &[f64]| albedos.iter().copied().zip(values.to_vec()).collect::<Vec<_>>();
        errors = errors.with_series(Series::new(name, over(&error)));
        if i == 0 {
            let mut straight = Vec::new();
            for albedo in &albedos {
                straight.push(Film::along_the_normal(1.0 - albedo, *albedo, g, THICK)?.reflectance_infinite());
            }
            reflectance = reflectance
                .with_series(Series::new("32 streams", over(&many)))
                .with_series(Series::new("K = 2σₐ, S = ¾σₛ′", over(&two)))
                .with_series(Series::new("K = σₐ, S = ½σₛ′", over(&straight)));
        }
        let short = name.replace(", ", "_").replace(' ', "");
        table =
            table.with_column(format!("two_{short}"), "", two)?.with_column(format!("streams_{short}"), "", many)?;
    }
    let figure =
        Figure::new("Kubelka and Munk against the transfer equation", 2).with_panel(reflectance).with_panel(errors);
    Ok((figure, table))
}
