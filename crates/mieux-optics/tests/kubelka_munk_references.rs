//! Kubelka's and Munk's films and Saunderson's correction against independently computed values (`reference_cases.csv`, which
//! names the source of each row).

mod shared;

use mieux_optics::transfer::kubelka_munk::{Film, Saunderson};

/// The number after `name=` in the inputs of a row.
fn input(inputs: &str, name: &str) -> f64 {
    let found = inputs.split([' ', ';']).find_map(|word| word.strip_prefix(name)?.strip_prefix('=')?.parse().ok());
    found.unwrap_or_else(|| panic!("no {name} in {inputs}"))
}

fn film(inputs: &str, quantity: &str) -> f64 {
    let film = Film::new(input(inputs, "K"), input(inputs, "S"), input(inputs, "d")).expect("a film");
    match quantity {
        "Rinf" => film.reflectance_infinite(),
        "R" => film.reflectance_over(input(inputs, "Rg")).expect("a backing"),
        "T" => film.transmittance(),
        other => panic!("unknown quantity {other}"),
    }
}

fn surface(inputs: &str) -> f64 {
    let surface = Saunderson::directional(input(inputs, "n"), 1.0).expect("an index");
    assert!((surface.external - input(inputs, "k1")).abs() < 1e-15, "{inputs}");
    let inside = input(inputs, "Ri");
    let measured = surface.measured(inside);
    assert!((surface.internal(measured).expect("a reflectance") - inside).abs() < 1e-12);
    measured
}

#[test]
fn every_film_and_surface_of_the_shared_table_is_met() {
    let Some(text) = shared::text("transfer/reference_cases.csv") else { return };
    let mut met = 0;
    for fields in csv::Reader::from_reader(text.as_bytes()).records() {
        let fields = fields.expect("a row");
        let ours = match &fields[1] {
            "KM" => film(&fields[2], &fields[3]),
            "Saunderson" => surface(&fields[2]),
            _ => continue,
        };
        let value: f64 = fields[4].parse().expect("a number");
        let allowed: f64 = fields[5].parse().expect("a tolerance");
        assert!((ours - value).abs() <= allowed, "{fields:?}: {ours}");
        met += 1;
    }
    assert!(met >= 7, "only {met} rows were found");
}
