//! The diffusion models against published formulas, evaluated independently (`reference_cases.csv`, which names the source
//! of each row).

#![allow(clippy::print_stdout)]

mod shared;

use mieux_optics::transfer::diffusion::{BetterDipole, Boundary, DiffusionMedium, Dipole, PhotonBeam};

/// The number after a name, as in `mua=.0011 mus_prime=2.55 /mm n=1.3 r=0.1 mm`.
fn number(inputs: &str, name: &str) -> f64 {
    let word = inputs.split_whitespace().find_map(|word| word.strip_prefix(name)?.strip_prefix('='));
    word.and_then(|word| word.parse().ok()).unwrap_or_else(|| panic!("no {name} in {inputs}"))
}

/// Whole milk of `jensen2001`, in the millimetres of the table; isotropic, so that scattering is reduced scattering.
fn milk(inputs: &str) -> DiffusionMedium {
    let [absorption, scattering] = ["mua", "mus_prime"].map(|name| number(inputs, name));
    DiffusionMedium::new(1e3 * absorption, 1e3 * scattering, 0.0, number(inputs, "n")).expect("a medium")
}

/// A medium known by its reduced albedo.
fn of_albedo(inputs: &str, name: &str) -> DiffusionMedium {
    let albedo = number(inputs, name);
    DiffusionMedium::new(1.0 - albedo, albedo, 0.0, number(inputs, "n")).expect("a medium")
}

/// What the models say of a row, value by value; `None` for what is not asked of them. Per square millimetre where it is
/// per area.
fn answer(category: &str, inputs: &str) -> Option<Vec<f64>> {
    let per_area = |value: f64| vec![1e-6 * value];
    Some(match category {
        "dipole Jensen2001" => {
            per_area(Dipole::new(&milk(inputs), Boundary::Groenhuis).reflectance(1e-3 * number(inputs, "r")))
        }
        "dipole d'Eon2012 better" => per_area(BetterDipole::new(&milk(inputs)).reflectance(1e-3 * number(inputs, "r"))),
        "dipole total Jensen2001" => vec![Dipole::new(&of_albedo(inputs, "alpha_prime"), Boundary::Groenhuis).total()],
        "PBD (pbrt-v3 form)" => {
            let beam = PhotonBeam::new(&of_albedo(inputs, "a")).expect("a medium");
            vec![beam.total_multiple(), beam.single().total()]
        }
        _ => return None,
    })
}

#[test]
fn every_diffusion_row_of_the_shared_table_is_met() {
    let Some(text) = shared::text("transfer/reference_cases.csv") else { return };
    let mut met = 0;
    for fields in csv::Reader::from_reader(text.as_bytes()).records() {
        let fields = fields.expect("a row");
        let Some(ours) = answer(&fields[1], &fields[2]) else { continue };
        let values: Vec<f64> = fields[4].split(';').map(|value| value.trim().parse().expect("a number")).collect();
        assert_eq!(ours.len(), values.len());
        let allowed: f64 = fields[5].parse().expect("a number");
        for (ours, value) in ours.iter().zip(values) {
            println!("{}: {ours:.10e} for {value:.10e}, off by {:.1e}", &fields[0], (ours - value).abs());
            // The profiles are small numbers given to ten digits: their tolerance is relative.
            let allowed = if allowed < 1e-8 { allowed * value } else { allowed };
            assert!((ours - value).abs() <= allowed, "{fields:?}: {ours}");
        }
        met += 1;
    }
    assert!(met >= 8, "only {met} rows were found");
}
