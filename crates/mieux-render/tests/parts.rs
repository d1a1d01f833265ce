//! Parts of pictures are the same bits as the whole: windows, shards, renders that were interrupted; and what is asked for of
//! the noise holds in every tile.

mod common;

use std::sync::atomic::{AtomicU32, Ordering};

use common::spectrum;
use mieux_optics::spectrum::colour::luminance;
use mieux_render::film::{Film, Filter};
use mieux_render::integrator::features;
use mieux_render::light::constant;
use mieux_render::medium::Medium;
use mieux_render::render::{
    Exposure, Flow, Outcome, RenderError, RenderSettings, Shard, StopRule, expose, owned_tiles, worst_tile_noise,
};
use mieux_render::scene::{GlassScene, Prepared, glasses};

const SIZE: [u32; 2] = [50, 37];

fn milk() -> Prepared {
    let milk = Medium::new(
        spectrum([400.0, 150.0, 80.0]),
        spectrum([20.0, 2.0, 1.0]),
        spectrum([0.6, 0.5, 0.4]),
        spectrum([1.357, 1.347, 1.343]),
    );
    let glass = Medium::clear(constant(1.0).unwrap(), constant(1.52).unwrap()).unwrap();
    let mut wanted = GlassScene::new(vec![("milk".into(), milk)], glass);
    wanted.resolution = SIZE;
    Prepared::new(&glasses(&wanted).unwrap()).unwrap()
}

fn render(scene: &Prepared, stop: StopRule, exposure: &Exposure) -> Film {
    let settings = RenderSettings { seed: 5, stop, ..RenderSettings::default() };
    expose(scene, &settings, exposure, None, &|_| Flow::Continue, &mut |_| {}).unwrap().film
}

#[test]
fn a_window_is_cut_out_of_the_whole_to_the_bit() {
    let scene = milk();
    for (_, filter) in Filter::ALL {
        let exposure = Exposure { filter, bins: 3, ..Exposure::default() };
        let whole = render(&scene, StopRule::Samples(3), &exposure);
        for window in [[13, 5, 20, 30], [0, 0, 1, 1], [49, 36, 1, 1], [16, 16, 16, 16]] {
            let part = render(&scene, StopRule::Samples(3), &Exposure { crop: Some(window), ..exposure });
            let [left, top, width, height] = window;
            assert_eq!(part.resolution(), [width, height]);
            for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
                assert_eq!(part.pixel(x, y), whole.pixel(left + x, top + y), "{filter:?} {window:?} {x} {y}");
                let at = |film: &Film, x: u32, y: u32| 3 * (y * film.resolution()[0] + x) as usize;
                let (a, b) = (at(&part, x, y), at(&whole, left + x, top + y));
                assert_eq!(part.spectra()[a..a + 3], whole.spectra()[b..b + 3]);
            }
        }
    }
}

#[test]
fn shards_put_together_are_the_whole_to_the_bit() {
    let scene = milk();
    let exposure = Exposure { bins: 4, crop: Some([7, 3, 40, 30]), ..Exposure::default() };
    let whole = render(&scene, StopRule::Samples(5), &exposure);
    let mut merged = Film::with_bins([40, 30], 4);
    for index in 0..3 {
        let shard = Some(Shard { index, count: 3 });
        let part = render(&scene, StopRule::Samples(5), &Exposure { shard, ..exposure });
        let mut owned = 0;
        for [left, top, width, height] in owned_tiles([7, 3, 40, 30], shard) {
            for (x, y) in (top..top + height).flat_map(|y| (left..left + width).map(move |x| (x, y))) {
                merged.take(&part, x, y);
                owned += 1;
            }
        }
        assert_eq!(part.total_samples(), 5 * owned);
    }
    assert_eq!(merged, whole);
}

#[test]
fn kept_or_interrupted_the_end_is_the_same() {
    let scene = milk();
    for stop in [StopRule::Samples(7), StopRule::Noise(0.25)] {
        let exposure = Exposure { bins: 2, ..Exposure::default() };
        let settings = RenderSettings { seed: 5, stop, ..RenderSettings::default() };
        let whole = render(&scene, stop, &exposure);
        for every in [1, 5, 17] {
            let count = AtomicU32::new(0);
            let turn = |flow| {
                let last = (count.fetch_add(1, Ordering::Relaxed) + 1).is_multiple_of(every);
                if last { flow } else { Flow::Continue }
            };
            let mut shown = Vec::new();
            let keep = &mut |film: &Film| shown.push(film.total_samples());
            let kept = expose(&scene, &settings, &exposure, None, &|_| turn(Flow::Keep), keep).unwrap();
            assert_eq!((&kept.film, kept.outcome), (&whole, Outcome::Finished), "{stop:?} every {every}");
            assert!(!shown.is_empty() && shown.windows(2).all(|w| w[0] < w[1]));
            // Stopped so often, and taken up each time from nothing but the parts of the film.
            let mut film = None;
            loop {
                let run = expose(&scene, &settings, &exposure, film, &|_| turn(Flow::Stop), &mut |_| {}).unwrap();
                let parts = Film::from_parts(SIZE, run.film.pixels().to_vec()).unwrap();
                let parts = parts.with_spectra(2, run.film.spectra().to_vec()).unwrap();
                film = Some(parts.with_floor(run.film.floor()).unwrap());
                if run.outcome == Outcome::Finished {
                    break;
                }
            }
            assert_eq!(film.as_ref(), Some(&whole), "{stop:?} stopped every {every}");
        }
    }
}

#[test]
fn noise_is_reached_in_every_tile_by_fewer_samples() {
    let scene = milk();
    let exposure = Exposure::default();
    let film = render(&scene, StopRule::Noise(0.15), &exposure);
    assert!(worst_tile_noise(&film, &exposure) <= 0.15 && film.noise() <= 0.15);
    let mut even = render(&scene, StopRule::Samples(film.samples().0), &exposure);
    let mut samples = film.samples().0;
    while worst_tile_noise(&even, &exposure) > 0.15 {
        samples += 4;
        even = render(&scene, StopRule::Samples(samples), &exposure);
    }
    assert!(even.total_samples() > film.total_samples(), "{} {}", even.total_samples(), film.total_samples());
}

/// A filter moves light between neighbours and neither adds nor loses any.
#[test]
fn filters_leave_the_mean() {
    let scene = milk();
    let mean = |filter| {
        let film = render(&scene, StopRule::Samples(64), &Exposure { filter, ..Exposure::default() });
        film.pixels().iter().map(|p| luminance(p.mean())).sum::<f64>() / film.pixels().len() as f64
    };
    let by_box = mean(Filter::Box);
    for (name, filter) in Filter::ALL {
        assert!((mean(filter) / by_box - 1.0).abs() < 0.03, "{name}: {} {by_box}", mean(filter));
    }
}

#[test]
fn features_are_of_what_is_there() {
    let scene = milk();
    let all = features(&scene, [0, 0, SIZE[0], SIZE[1]]);
    let part = features(&scene, [11, 9, 5, 4]);
    for (i, one) in part.iter().enumerate() {
        assert_eq!(one, &all[(9 + i / 5) * SIZE[0] as usize + 11 + i % 5]);
    }
    for one in &all {
        let length = one.normal.iter().map(|n| n * n).sum::<f64>();
        assert!(length <= 1.0 + 1e-9 && one.depth > 0.0, "{one:?}");
        assert!(one.albedo.iter().all(|a| (-0.01..=1.01).contains(a)), "{one:?}");
        assert_eq!(one.depth.is_infinite(), one.albedo == [0.0; 3] && length == 0.0);
    }
    assert!(all.iter().any(|f| f.albedo == [1.0; 3] && f.depth.is_finite()), "the glass");
}

#[test]
fn impossible_parts_are_refused() {
    let scene = milk();
    let go = |exposure: Exposure, film| {
        expose(&scene, &RenderSettings::default(), &exposure, film, &|_| Flow::Continue, &mut |_| {}).unwrap_err()
    };
    for window in [[0, 0, 0, 5], [40, 0, 11, 5], [0, 37, 1, 1], [u32::MAX, 0, 2, 1]] {
        let error = go(Exposure { crop: Some(window), ..Exposure::default() }, None);
        assert!(matches!(error, RenderError::Crop { .. }), "{error}");
    }
    let shard = Some(Shard { index: 2, count: 2 });
    assert_eq!(go(Exposure { shard, ..Exposure::default() }, None), RenderError::Shard { index: 2, count: 2 });
    let error = go(Exposure { bins: 3, ..Exposure::default() }, Some(Film::new(SIZE)));
    assert_eq!(error, RenderError::Bins { film: 0, wanted: 3 });
}
