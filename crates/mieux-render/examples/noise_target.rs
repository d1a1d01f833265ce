//! What it takes to bring the noise down everywhere: all pixels alike until the worst tile is good enough, against each tile
//! until it is good enough by itself; whether the noise said is the error found; and whether stopping on an estimate shifts
//! the picture.
//!
//! `cargo run --release -p mieux-render --example noise_target [-- NOISE]`, a minute or two on two cores.

#![allow(clippy::print_stdout, clippy::unwrap_used)]

use mieux_optics::spectrum::colour::luminance;
use mieux_render::film::Film;
use mieux_render::light::constant;
use mieux_render::medium::Medium;
use mieux_render::render::{Exposure, Flow, RenderSettings, StopRule, render_prepared, worst_tile_noise};
use mieux_render::scene::{GlassScene, Prepared, glasses};

const SEEDS: u64 = 8;
const REFERENCE: u64 = 512;

fn main() {
    let wanted = std::env::args().nth(1).map_or(0.2, |text| text.parse().unwrap());
    let scene = milk();
    let expose = |seed: u64, stop: StopRule, film: Option<Film>| {
        let settings = RenderSettings { seed, stop, ..RenderSettings::default() };
        render_prepared(&scene, &settings, film, &|_| Flow::Continue).unwrap().film
    };
    let count = scene.camera().resolution().iter().map(|&n| u64::from(n)).product::<u64>() as f64;
    let worst = |film: &Film| worst_tile_noise(film, &Exposure::default());
    println!("wanted: a mean relative error per pixel of {:.1} % in every tile", 100.0 * wanted);
    let mut even = expose(1, StopRule::Samples(16), None);
    while worst(&even) > wanted {
        let next = even.samples().1 + 8;
        even = expose(1, StopRule::Samples(next), Some(even));
    }
    let films: Vec<Film> = (1..=SEEDS).map(|seed| expose(seed, StopRule::Noise(wanted), None)).collect();
    let one = &films[0];
    for (name, film) in [("all alike", &even), ("by tiles", one)] {
        println!(
            "{name:>10}: {:7.1} samples per pixel on average ({} to {}), worst tile {:.2} %, picture {:.2} %",
            film.total_samples() as f64 / count,
            film.samples().0,
            film.samples().1,
            100.0 * worst(film),
            100.0 * film.noise()
        );
    }
    println!("samples saved: {:.2} times fewer", even.total_samples() as f64 / one.total_samples() as f64);
    let reference = expose(1_000, StopRule::Samples(REFERENCE), None);
    errors(&films, &reference, wanted);
    bias(&films, &reference);
}

/// What the films say of their errors against what they are, from `reference`, whose own error is taken off.
fn errors(films: &[Film], reference: &Film, wanted: f64) {
    let [width, height] = reference.resolution();
    let mean = reference.pixels().iter().map(|p| luminance(p.mean())).sum::<f64>() / f64::from(width * height);
    let scale = |x, y| luminance(reference.pixel(x, y).unwrap().mean()).max(0.01 * mean);
    let (mut said, mut found, mut most) = (0.0, 0.0, 0.0f64);
    let tiles = (0..height).step_by(16).flat_map(|y| (0..width).step_by(16).map(move |x| (x, y)));
    let mut count = 0.0;
    for (left, top) in tiles {
        let (mut tile, mut n) = (0.0, 0.0);
        for (x, y) in (top..(top + 16).min(height)).flat_map(|y| (left..(left + 16).min(width)).map(move |x| (x, y))) {
            let truth = reference.pixel(x, y).unwrap();
            let square = |f: &Film| (luminance(f.pixel(x, y).unwrap().mean()) - luminance(truth.mean())).powi(2);
            let square = films.iter().map(square).sum::<f64>() / films.len() as f64 - truth.luminance_error().powi(2);
            let error = square.max(0.0).sqrt() / scale(x, y);
            let given = |f: &Film| f.pixel(x, y).unwrap().luminance_error();
            said += films.iter().map(given).sum::<f64>() / films.len() as f64 / scale(x, y);
            found += error;
            tile += error;
            n += 1.0;
        }
        count += n;
        most = most.max(tile / n);
    }
    println!(
        "root mean square error over {} pictures: {:.2} % per pixel (they say {:.2} %), worst tile {:.2} % ({:.2} of what is wanted)",
        films.len(),
        100.0 * found / count,
        100.0 * said / count,
        100.0 * most,
        most / wanted
    );
}

/// The mean of the films against the reference, whose errors come from the spread over films and from the reference.
fn bias(films: &[Film], reference: &Film) {
    let n = films.len() as f64;
    let (mut off, mut variance, mut sum) = ([0.0; 3], [0.0; 3], [0.0; 3]);
    for (i, truth) in reference.pixels().iter().enumerate() {
        for c in 0..3 {
            let values: Vec<f64> = films.iter().map(|f| f.pixels()[i].mean()[c]).collect();
            let mean = values.iter().sum::<f64>() / n;
            off[c] += mean - truth.mean()[c];
            variance[c] += values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0) / n;
            variance[c] += truth.variance_of_mean()[c];
            sum[c] += truth.mean()[c];
        }
    }
    let share = |value: f64, c: usize| 100.0 * value / sum[c];
    let text: [String; 3] =
        std::array::from_fn(|c| format!("{:+.3} +- {:.3} %", share(off[c], c), share(variance[c].sqrt(), c)));
    println!(
        "mean of {} pictures against {REFERENCE} samples per pixel: bias R, G, B {}",
        films.len(),
        text.join(", ")
    );
}

fn milk() -> Prepared {
    let spectrum = |[blue, green, red]: [f64; 3]| {
        use mieux_optics::spectrum::{Sampled, WavelengthGrid};
        let grid = WavelengthGrid::new(vec![300e-9, 450e-9, 550e-9, 650e-9, 900e-9]).unwrap();
        Sampled::new(grid, vec![blue, blue, green, red, red]).unwrap()
    };
    let milk = Medium::new(
        spectrum([4_000.0, 1_500.0, 800.0]),
        spectrum([20.0, 2.0, 1.0]),
        spectrum([0.6, 0.5, 0.4]),
        spectrum([1.357, 1.347, 1.343]),
    );
    let glass = Medium::clear(constant(1.0).unwrap(), constant(1.52).unwrap()).unwrap();
    let mut wanted = GlassScene::new(vec![("milk".into(), milk)], glass);
    wanted.resolution = [64, 48];
    Prepared::new(&glasses(&wanted).unwrap()).unwrap()
}
