//! The driver: the same bits on any number of threads, interrupted or not; stop rules; errors.

#![allow(clippy::print_stdout)]

mod common;

use std::sync::atomic::{AtomicU32, Ordering};

use common::spectrum;
use mieux_optics::spectrum::colour::luminance;
use mieux_render::film::Film;
use mieux_render::light::constant;
use mieux_render::medium::Medium;
use mieux_render::render::{Flow, Outcome, RenderError, RenderSettings, StopRule, render, render_prepared};
use mieux_render::scene::{GlassScene, Prepared, Scene, SceneError, glasses};

fn small_glass() -> Scene {
    let milk = Medium::new(
        spectrum([4_000.0, 1_500.0, 800.0]),
        spectrum([20.0, 2.0, 1.0]),
        spectrum([0.6, 0.5, 0.4]),
        spectrum([1.357, 1.347, 1.343]),
    );
    let glass = Medium::clear(constant(1.0).unwrap(), constant(1.52).unwrap()).unwrap();
    let mut wanted = GlassScene::new(vec![("milk".into(), milk)], glass);
    wanted.resolution = [50, 37];
    glasses(&wanted).unwrap()
}

fn settings(stop: StopRule) -> RenderSettings {
    RenderSettings { seed: 5, stop, ..RenderSettings::default() }
}

fn on_threads(threads: usize, film: Option<Film>) -> Film {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let scene = small_glass();
    pool.install(|| render(&scene, &settings(StopRule::Samples(6)), film, &|_| Flow::Continue).unwrap().film)
}

#[test]
fn the_same_bits_on_one_two_and_three_threads_and_after_interruption() {
    let whole = on_threads(1, None);
    assert_eq!(whole, on_threads(2, None));
    assert_eq!(whole, on_threads(3, None));
    assert_eq!(whole.samples(), (6, 6));
    for stop_after in [1, 9, 20] {
        let tiles = AtomicU32::new(0);
        let sink = |_: &_| {
            if tiles.fetch_add(1, Ordering::Relaxed) + 1 >= stop_after { Flow::Stop } else { Flow::Continue }
        };
        let broken = render(&small_glass(), &settings(StopRule::Samples(6)), None, &sink).unwrap();
        assert_eq!(broken.outcome, Outcome::Stopped);
        assert!(broken.film.samples().0 < 6);
        let kept = Film::from_parts(broken.film.resolution(), broken.film.pixels().to_vec()).unwrap();
        assert_eq!(whole, on_threads(2, Some(kept)));
    }
}

#[test]
fn another_seed_is_another_picture_of_the_same_thing() {
    let scene = small_glass();
    let mean = |seed| {
        let settings = RenderSettings { seed, ..settings(StopRule::Samples(16)) };
        let film = render(&scene, &settings, None, &|_| Flow::Continue).unwrap().film;
        film.pixels().iter().map(|p| p.mean()[1]).sum::<f64>() / film.pixels().len() as f64
    };
    let (a, b) = (mean(1), mean(2));
    assert!(a != b && (a / b - 1.0).abs() < 0.02, "{a} {b}");
}

#[test]
fn noise_is_reached_and_progress_adds_up() {
    let last = AtomicU32::new(0);
    let sink = |p: &mieux_render::render::Progress| {
        assert!(p.samples <= p.pass_end && p.end.is_none_or(|end| end >= p.samples));
        last.fetch_max(p.samples as u32, Ordering::Relaxed);
        Flow::Continue
    };
    let rendered = render(&small_glass(), &settings(StopRule::Noise(0.2)), None, &sink).unwrap();
    assert_eq!(rendered.outcome, Outcome::Finished);
    assert!(rendered.noise <= 0.2 && rendered.noise == rendered.film.noise());
    assert_eq!(u64::from(last.into_inner()), rendered.film.total_samples());
    assert_eq!(rendered.statistics.paths, rendered.film.total_samples());
    assert_eq!(rendered.statistics.lost, 0);
}

/// The noise a film gives is the spread it claims to be: over 16 seeds, pixel by pixel, against what each film says of
/// itself. Both sides are mean squares over pixels; 15 degrees of freedom in each of 1850 pixels make the ratio sure to
/// about 1 %, and bright rare paths to a few.
#[test]
fn the_noise_given_is_the_spread_over_seeds() {
    let (scene, seeds, samples) = (Prepared::new(&small_glass()).unwrap(), 16u32, 32);
    let films: Vec<Film> = (0..seeds)
        .map(|seed| {
            let settings = RenderSettings { seed: 1000 + u64::from(seed), ..settings(StopRule::Samples(samples)) };
            render_prepared(&scene, &settings, None, &|_| Flow::Continue).unwrap().film
        })
        .collect();
    let n = f64::from(seeds);
    let (mut spread, mut given, mut noise) = (0.0, 0.0, 0.0);
    for pixel in 0..films[0].pixels().len() {
        let values: Vec<f64> = films.iter().map(|f| luminance(f.pixels()[pixel].mean())).collect();
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
        // Relative, as the noise is, so that bright pixels do not decide alone.
        spread += variance / (mean * mean);
        given += films.iter().map(|f| f.pixels()[pixel].luminance_error().powi(2)).sum::<f64>() / n / (mean * mean);
        noise += variance.sqrt() / mean / films[0].pixels().len() as f64;
    }
    let ratio = (given / spread).sqrt();
    let printed = films.iter().map(Film::noise).sum::<f64>() / n;
    println!("noise given over spread found: {ratio:.3} (mean squares), {:.3} (means)", printed / noise);
    assert!((0.95..1.15).contains(&ratio), "{ratio}");
    assert!((0.95..1.15).contains(&(printed / noise)), "{printed} {noise}");
}

#[test]
fn bad_settings_and_scenes_are_refused() {
    let scene = small_glass();
    let go = |scene: &Scene, stop, film| render(scene, &settings(stop), film, &|_| Flow::Continue);
    assert_eq!(go(&scene, StopRule::Samples(0), None), Err(RenderError::Samples { samples: 0 }));
    assert!(matches!(go(&scene, StopRule::Noise(0.0), None), Err(RenderError::Noise { .. })));
    assert!(matches!(go(&scene, StopRule::Noise(f64::NAN), None), Err(RenderError::Noise { .. })));
    let other = Some(Film::new([3, 3]));
    assert!(matches!(go(&scene, StopRule::Samples(1), other), Err(RenderError::Resolution { .. })));
    let error = |scene: Scene| match go(&scene, StopRule::Samples(1), None) {
        Err(RenderError::Scene(error)) => error,
        other => panic!("{other:?}"),
    };
    let mut open = scene.clone();
    open.bodies[1].mesh = scene.surfaces[0].mesh.clone();
    assert!(matches!(error(open), SceneError::NotClosed { name } if name == "milk"));
    let mut short = scene.clone();
    short.wavelength_range = (380e-9, 780e-9);
    short.bodies[1].medium.parts[0].phase = Medium::grey(0.0, 0.0, 1.0, 1.0).unwrap().parts[0].phase.clone();
    assert!(matches!(error(short), SceneError::Medium { .. }));
    let mut dark = scene.clone();
    dark.bodies[0].medium.parts[0].sigma_a = constant(-1.0).unwrap();
    assert!(error(dark).to_string().contains("sigma_a = -1"));
    let mut beyond = scene;
    beyond.wavelength_range = (300e-9, 700e-9);
    assert!(matches!(error(beyond), SceneError::Observer(_)));
}
