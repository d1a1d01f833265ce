//! K and S of 13 artists' paints (Kimera) from measured masstones and tints: what a fit reaches, and what it cannot.
//!
//! Every pigment has one recipe of tint, measured three times, so a pigment whose tint is left out has its masstone alone, and
//! that holds K/S and nothing of S.

#![allow(clippy::print_stdout)]

mod shared;

use mieux_optics::paint::{
    FitOptions, Leftover, Measurements, Paint, PaintFit, PaintSet, Recipe, Sample, Surface, fit,
};
use mieux_optics::spectrum::{Sampled, WavelengthGrid};
use mieux_optics::transfer::kubelka_munk::{Film, Saunderson};

fn read(path: &str) -> Option<Measurements> {
    let text = shared::text(path)?;
    let entries: Vec<serde_json::Value> = serde_json::from_str(&text).expect("a list");
    let numbers = |value: &serde_json::Value, scale: f64| -> Vec<f64> {
        value.as_array().expect("numbers").iter().map(|v| v.as_f64().expect("a number") * scale).collect()
    };
    let grid = WavelengthGrid::new(numbers(&entries[0]["values"], 1e-9)).expect("a grid");
    let samples = entries[1..].iter().map(|entry| {
        let name = entry["name"].as_str().expect("a name").to_owned();
        let recipe = match entry.get("components").and_then(|parts| parts.as_object()) {
            Some(parts) => {
                Recipe::new(parts.iter().map(|(name, share)| (name.clone(), share.as_f64().expect("a share"))))
            }
            None => Ok(Recipe::pure(&name)),
        };
        Sample { name, recipe: recipe.expect("a recipe"), reflectance: numbers(&entry["reflectance"], 0.01) }
    });
    Some(Measurements::new(grid, samples.collect()).expect("measurements"))
}

fn kimera() -> Option<Measurements> {
    Some(read("paint/kimera_masstone.json")?.and(read("paint/kimera_mix1.json")?).expect("the same wavelengths"))
}

fn options() -> FitOptions {
    FitOptions::new(Surface::FitSpecular(Saunderson::directional(1.5, 1.0).expect("an index")))
}

fn mean(leftovers: &[Leftover]) -> f64 {
    leftovers.iter().map(|left| left.ciede2000).sum::<f64>() / leftovers.len() as f64
}

fn show(title: &str, leftovers: &[Leftover]) {
    println!("{title}");
    for left in leftovers {
        println!("  {:<40} CIEDE2000 {:6.2}   rms {:.4}", left.name, left.ciede2000, left.rms);
    }
    println!("  mean {:.3}", mean(leftovers));
}

/// The place of a sample among those of the same name, from 0.
fn repeat(all: &Measurements, index: usize) -> usize {
    all.samples()[..index].iter().filter(|sample| sample.name == all.samples()[index].name).count()
}

fn is_tint(sample: &Sample) -> bool {
    sample.recipe.parts().len() > 1
}

/// Fitted: all masstones and the first measurement of each tint. Foretold: the second and third of each tint.
#[test]
fn tints_measured_again_are_foretold() {
    let Some(all) = kimera() else { return };
    let fitted = all.filtered(|i, sample| !is_tint(sample) || repeat(&all, i) == 0);
    let rest = all.filtered(|i, sample| is_tint(sample) && repeat(&all, i) > 0);
    assert_eq!((fitted.samples().len(), rest.samples().len()), (39 + 12, 24));
    let found = fit(&fitted, &options()).expect("a fit");
    println!("specular {:.3} +- {:.3}", found.paints.surface().specular, found.specular_error);
    show("fitted", &found.leftovers);
    let foretold = found.predict(&rest).expect("the same paints");
    show("held out: second and third measurement of each tint", &foretold);
    assert_eq!(found.paints.reference(), "white");
    assert!(found.ratio_only.is_empty());
    assert!(mean(&foretold) < 1.0 && foretold.iter().all(|left| left.ciede2000 < 3.0));
    for paint in found.paints.paints() {
        assert!(paint.k.iter().chain(&paint.s).all(|v| *v > 0.0 && v.is_finite()), "{}", paint.name);
    }
}

/// The samples at every so many-th wavelength only.
fn thinned(all: &Measurements, step: usize) -> Measurements {
    let thin = |values: &[f64]| values.iter().copied().step_by(step).collect::<Vec<f64>>();
    let samples = all.samples().iter().map(|s| Sample { reflectance: thin(&s.reflectance), ..s.clone() });
    let grid = WavelengthGrid::new(thin(all.grid().as_slice())).expect("a grid");
    Measurements::new(grid, samples.collect()).expect("measurements")
}

/// Tints measured at few wavelengths: S of each pigment there, between them interpolated; K everywhere from that and the
/// masstone. Foretold: the tints at all wavelengths.
fn foretold_from_few(all: &Measurements, step: usize) -> Vec<Leftover> {
    let few = thinned(all, step);
    let found = fit(&few, &options()).expect("a fit");
    let surface = found.paints.surface();
    let paint = |paint: &Paint| {
        let log_s = Sampled::new(few.grid().clone(), paint.s.iter().map(|s| s.ln()).collect()).expect("a spectrum");
        let (first, last) = (few.grid().range().0, few.grid().range().1);
        let s: Vec<f64> = all.grid().iter().map(|w| log_s.at(w.clamp(first, last)).expect("inside").exp()).collect();
        let pure: Vec<&Sample> =
            all.samples().iter().filter(|sample| sample.recipe == Recipe::pure(&paint.name)).collect();
        let ratio = |i: usize| {
            let mean = pure.iter().map(|sample| sample.reflectance[i]).sum::<f64>() / pure.len() as f64;
            Film::ratio(surface.internal(mean).expect("brighter than the surface")).expect("a reflectance")
        };
        let k = s.iter().enumerate().map(|(i, s)| s * ratio(i)).collect();
        Paint { name: paint.name.clone(), k, s, k_error: vec![], s_error: vec![] }
    };
    let paints = found.paints.paints().iter().map(paint).collect();
    let set = PaintSet::new(all.grid().clone(), surface, "white".into(), paints).expect("paints");
    let whole = PaintFit { paints: set, ..found };
    whole.predict(&all.filtered(|_, sample| is_tint(sample))).expect("the same paints")
}

/// Of 170 wavelengths 153 or more are never looked at in the tints.
#[test]
fn tints_are_foretold_between_a_few_wavelengths() {
    let Some(all) = kimera() else { return };
    for (step, most) in [(10, 0.5), (20, 1.5), (34, 3.0)] {
        let foretold = foretold_from_few(&all, step);
        show(&format!("tints known at {} wavelengths", 170usize.div_ceil(step)), &foretold);
        assert!(mean(&foretold) < most, "{step}: {}", mean(&foretold));
    }
}

/// Each tint left out in turn, all three measurements of it. The pigment then has its masstone alone: the fit says that its S is
/// not known, and the tint is foretold with what is believed of any pigment.
#[test]
fn a_tint_left_out_altogether_is_known_to_be_unknown() {
    let Some(all) = kimera() else { return };
    let white = all.samples().iter().find(|sample| sample.name == "white").expect("white").recipe.clone();
    let names: Vec<String> = all.paints().into_iter().filter(|name| *name != "white").map(str::to_owned).collect();
    assert_eq!((names.len(), white.parts().len()), (12, 1));
    let of = |sample: &Sample, name: &str| is_tint(sample) && sample.recipe.parts().iter().any(|part| part.0 == name);
    let surface = Saunderson::directional(1.5, 1.0).expect("an index").with_specular(0.13);
    let mut foretold = Vec::new();
    for name in &names {
        let kept = all.filtered(|_, sample| !of(sample, name));
        let found = fit(&kept, &FitOptions::new(Surface::Given(surface))).expect("a fit");
        assert_eq!(found.ratio_only, std::slice::from_ref(name));
        let paint = found.paints.paints().iter().find(|paint| paint.name == *name).expect("it");
        let unsure = paint.s_error.iter().sum::<f64>() / paint.s_error.len() as f64;
        // Within a factor of five, which is the belief that the fit began with.
        assert!(unsure > 1.5, "{name}: {unsure}");
        foretold.extend(found.predict(&all.filtered(|_, sample| of(sample, name))).expect("the same paints"));
    }
    show("left out altogether", &foretold);
}
