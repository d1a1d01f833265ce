//! Renders glasses of milk-like liquids and writes a picture, to judge looks and speed by eye.
//!
//! `cargo run --release -p mieux-render --example preview -- FILE.ppm [whole|skimmed|water|row] [WIDTHxHEIGHT] [NOISE or SPP]`
//! A last number below 1 is a noise to reach, above it a number of samples per pixel; `similarity`, `diffusion` and
//! `dispersion` anywhere switch those on.
#![allow(clippy::print_stdout)]

use std::error::Error;
use std::time::Instant;

use mieux_optics::spectrum::{
    Sampled, WavelengthGrid,
    colour::{luminance, srgb_encode},
};
use mieux_render::medium::Medium;
use mieux_render::render::{Flow, RenderSettings, StopRule, render};
use mieux_render::scene::{GlassScene, glasses};

type Fallible<T> = Result<T, Box<dyn Error>>;

fn spectrum(nm: &[f64], values: &[f64]) -> Fallible<Sampled> {
    Ok(Sampled::new(WavelengthGrid::new(nm.iter().map(|w| w * 1e-9).collect())?, values.to_vec())?)
}

fn liquid(name: &str) -> Fallible<(String, Medium)> {
    let n = spectrum(&[380.0, 480.0, 587.56, 780.0], &[1.357, 1.351, 1.347, 1.343])?;
    let grid = [380.0, 450.0, 550.0, 650.0, 780.0];
    let medium = match name {
        "whole" => Medium::new(
            spectrum(&grid, &[58_500.0, 60_500.0, 57_837.0, 54_000.0, 49_000.0])?,
            spectrum(&grid, &[24.0, 17.0, 6.08, 3.6, 3.6])?,
            spectrum(&grid, &[0.945, 0.951, 0.9544, 0.957, 0.959])?,
            n,
        ),
        "skimmed" => Medium::new(
            spectrum(&grid, &[4_300.0, 2_300.0, 1_283.0, 820.0, 500.0])?,
            spectrum(&grid, &[16.0, 10.0, 1.5, 1.2, 2.4])?,
            spectrum(&grid, &[0.27, 0.24, 0.20, 0.18, 0.16])?,
            n,
        ),
        "water" => {
            let n = spectrum(&[380.0, 480.0, 587.56, 780.0], &[1.343, 1.337, 1.333, 1.329])?;
            Medium::clear(spectrum(&grid, &[0.011, 0.0092, 0.057, 0.34, 2.36])?, n).ok_or("water")?
        }
        other => return Err(format!("no liquid '{other}'").into()),
    };
    Ok((name.to_string(), medium))
}

fn main() -> Fallible<()> {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut switch = |name: &str| {
        let found = arguments.iter().position(|a| a == name);
        found.map(|i| arguments.remove(i)).is_some()
    };
    let mut settings = RenderSettings::default();
    settings.transport.similarity = switch("similarity");
    settings.transport.diffusion = switch("diffusion");
    settings.transport.dispersion = switch("dispersion");
    let argument = |i: usize, default: &str| arguments.get(i).cloned().unwrap_or(default.to_string());
    let names = match argument(1, "whole").as_str() {
        "row" => vec!["water", "skimmed", "whole"],
        "seven" => vec!["water", "water", "skimmed", "skimmed", "whole", "whole", "whole"],
        name => vec![Box::leak(name.to_string().into_boxed_str()) as &str],
    };
    let liquids = names.into_iter().map(liquid).collect::<Fallible<Vec<_>>>()?;
    let glass = Medium::clear(
        spectrum(&[380.0, 450.0, 550.0, 650.0, 780.0], &[4.3, 1.2, 1.06, 2.4, 6.0])?,
        spectrum(&[380.0, 450.0, 587.56, 780.0], &[1.540, 1.532, 1.5234, 1.5176])?,
    );
    let mut wanted = GlassScene::new(liquids, glass.ok_or("glass")?);
    let size = argument(2, "480x360");
    let (width, height) = size.split_once('x').ok_or("a size such as 480x360")?;
    wanted.resolution = [width.parse()?, height.parse()?];
    let goal: f64 = argument(3, "16").parse()?;
    settings.stop = if goal < 1.0 { StopRule::Noise(goal) } else { StopRule::Samples(goal as u64) };
    let start = Instant::now();
    let rendered = render(&glasses(&wanted)?, &settings, None, &|_| Flow::Continue)?;
    let seconds = start.elapsed().as_secs_f64();
    let s = rendered.statistics;
    println!("{seconds:.2} s, {} samples per pixel, noise {:.4}", rendered.film.samples().0, rendered.noise);
    println!("{s:?}");
    println!(
        "{:.1} collisions per path, {:.2} us per path and thread",
        s.collisions as f64 / s.paths as f64,
        1e6 * seconds * rayon::current_num_threads() as f64 / s.paths as f64
    );
    let mean = rendered.film.pixels().iter().map(|p| luminance(p.mean())).sum::<f64>();
    println!("mean luminance {:.5}", mean / rendered.film.pixels().len() as f64);
    let [w, h] = wanted.resolution;
    for (what, x, y) in [("corner", w / 10, h / 10), ("table", w / 10, h * 8 / 10), ("middle", w / 2, h / 2)] {
        let relative = |i: u32| {
            let pixel = rendered.film.pixel(x + i % 16, y + i / 16).copied().unwrap_or_default();
            pixel.luminance_error() / luminance(pixel.mean())
        };
        println!("noise in the {what}: {:.4}", (0..256).map(relative).sum::<f64>() / 256.0);
    }
    let mut picture = format!("P6 {} {} 255\n", wanted.resolution[0], wanted.resolution[1]).into_bytes();
    for pixel in rendered.film.pixels() {
        picture.extend(pixel.mean().map(|v| (255.0 * srgb_encode(v) + 0.5) as u8));
    }
    std::fs::write(argument(0, "preview.ppm"), picture)?;
    Ok(())
}
