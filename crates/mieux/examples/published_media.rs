//! Computed materials beside what others have published and measured.
//!
//! `cargo run --release -p mieux --example published_media` prints the tables of docs/published-media.md and docs/sea-ice.md. The
//! numbers of others are read from `../shared/data` (or `$MIEUX_SHARED/data`); without them ours stand alone.

use std::collections::BTreeMap;
use std::error::Error;
use std::io::Write;

use mieux::io::recipe::{MATERIALS, Recipe};
use mieux::optics::medium::BulkOptics;
use mieux::optics::spectrum::{WavelengthGrid, stiles_burch1959};

type Outcome<T> = Result<T, Box<dyn Error>>;
/// Inputs and their values.
type Settings = &'static [(&'static str, f64)];

/// Seas whose properties were published: our name, theirs.
const SEAS: [(&str, &str); 3] =
    [("sea-atlantic", "AtlanticSeaWater"), ("sea-baltic", "BalticSeaWater"), ("sea-north", "NorthSeaWater")];
/// Measured liquids: theirs, our material and its inputs.
const LIQUIDS: [(&str, &str, Settings); 5] = [
    ("Skimmilk", "skim-milk", &[]),
    ("Wholemilk", "whole-milk", &[]),
    ("Lowfat Milk", "low-fat-milk", &[]),
    ("Reduced Milk", "whole-milk", &[("fat", 2.0)]),
    ("Regular Milk", "whole-milk", &[("fat", 3.3)]),
];

fn main() -> Outcome<()> {
    let mut out = std::io::stdout().lock();
    seas(&mut out)?;
    liquids(&mut out)?;
    intralipid(&mut out)?;
    sea_ice(&mut out)
}

fn shared(name: &str) -> Vec<Vec<String>> {
    let folder = std::env::var("MIEUX_SHARED").unwrap_or_else(|_| "../shared".into());
    let text = std::fs::read_to_string(format!("{folder}/data/optics/{name}")).unwrap_or_default();
    text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn computed(material: &str, settings: &[(&str, f64)], grid: &WavelengthGrid) -> Outcome<BulkOptics> {
    let settings: BTreeMap<String, f64> = settings.iter().map(|(name, value)| ((*name).into(), *value)).collect();
    Ok(Recipe::find(material)?.material(&settings)?.medium.bulk_optics(grid, 1e-4)?)
}

/// Red, green and blue means as in 2007.
fn rgb(optics: &BulkOptics, values: &[f64], weight: impl Fn(usize) -> f64) -> Outcome<[f64; 3]> {
    Ok(stiles_burch1959().average(&optics.spectrum(values)?, weight))
}

fn seas(out: &mut impl Write) -> Outcome<()> {
    let published = shared("frisvad2007_published_media.csv");
    writeln!(
        out,
        "\n| sea | sigma_s (1/m), R G B | published | ratio | g, R G B | published |\n|---|---|---|---|---|---|"
    )?;
    for (ours, theirs) in SEAS {
        let b = computed(ours, &[], &WavelengthGrid::frisvad2007())?;
        let (scattering, g) = (rgb(&b, b.sigma_s(), |_| 1.0)?, rgb(&b, b.asymmetry(), |i| b.sigma_s()[i])?);
        let row = published.iter().find(|row| row[0] == theirs);
        let numbers = |i: usize| -> Vec<f64> {
            row.map_or(Vec::new(), |row| row[i].split(' ').filter_map(|v| v.parse().ok()).collect())
        };
        let (their_s, their_g) = (numbers(3), numbers(4));
        let ratio: Vec<f64> = scattering.iter().zip(&their_s).map(|(a, b)| a / b).collect();
        writeln!(
            out,
            "| {ours} | {} | {} | {} | {} | {} |",
            words(&scattering, 4),
            words(&their_s, 4),
            words(&ratio, 3),
            words(&g, 4),
            words(&their_g, 4)
        )?;
    }
    Ok(())
}

fn liquids(out: &mut impl Write) -> Outcome<()> {
    let measured = shared("measured_liquids_mm-1.csv");
    writeln!(
        out,
        "\n| measured | source | sigma_s' (1/mm), R G B | ours | ratio | sigma_a (1/m), R G B | ours |\n|---|---|---|---|---|---|---|"
    )?;
    for (theirs, material, settings) in LIQUIDS {
        let b = computed(material, settings, &WavelengthGrid::frisvad2007())?;
        let reduced = rgb(&b, &b.reduced_scattering(), |_| 1.0)?.map(|v| 1e-3 * v);
        let absorption = rgb(&b, b.sigma_a(), |_| 1.0)?;
        let Some(row) = measured.iter().find(|row| row[0] == theirs) else { continue };
        let numbers = |from: usize, factor: f64| -> Vec<f64> {
            row[from..from + 3].iter().filter_map(|v| v.parse::<f64>().ok()).map(|v| v * factor).collect()
        };
        let (their_s, their_a) = (numbers(1, 1.0), numbers(4, 1e3));
        let ratio: Vec<f64> = reduced.iter().zip(&their_s).map(|(a, b)| a / b).collect();
        writeln!(
            out,
            "| {theirs} | {} | {} | {} | {} | {} | {} |",
            row[7],
            words(&their_s, 3),
            words(&reduced, 3),
            words(&ratio, 3),
            words(&their_a, 3),
            words(&absorption, 3)
        )?;
    }
    Ok(())
}

/// Fits to measurements by Michels et al. (2008), tables 3 and 4, of Intralipid 20 %.
fn intralipid(out: &mut impl Write) -> Outcome<()> {
    let grid = WavelengthGrid::regular(400e-9, 750e-9, 50e-9)?;
    let b = computed("intralipid", &[("stock", 100.0)], &grid)?;
    writeln!(
        out,
        "\n| wavelength (nm) | sigma_s (1/mm) | measured | ratio | g | measured |\n|---|---|---|---|---|---|"
    )?;
    for (i, wavelength) in grid.iter().enumerate() {
        let nm = 1e9 * wavelength;
        let (scattering, g) = (3.873e8 * nm.powf(-2.397), 1.090 - 6.812e-4 * nm);
        let ours = 1e-3 * b.sigma_s()[i];
        writeln!(
            out,
            "| {nm:.0} | {ours:.1} | {scattering:.1} | {:.3} | {:.4} | {g:.4} |",
            ours / scattering,
            b.asymmetry()[i]
        )?;
    }
    Ok(())
}

/// Reduced scattering of first-year ice at 550 nm, its brine shaped and salted in several ways.
fn sea_ice(out: &mut impl Write) -> Outcome<()> {
    let grid = WavelengthGrid::new(vec![550e-9])?;
    let reduced = |recipe: &Recipe, settings: &[(&str, f64)]| -> Outcome<f64> {
        let settings = settings.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
        Ok(recipe.material(&settings)?.medium.bulk_optics(&grid, 1e-3)?.reduced_scattering()[0])
    };
    let text = MATERIALS.iter().find(|(name, _)| *name == "ice-first-year").map_or("", |(_, text)| *text);
    let variant = |from: &str, to: &str| Recipe::parse("variant", "variant", &text.replace(from, to));
    let shaped = Recipe::find("ice-first-year")?;
    let volume = variant("exponent = 0.67 } }", "exponent = 0.67 }, equivalent = \"volume\" }")?;
    let bubbles = text.replace("0.02 * brine", "brine").replace("0.06 * brine", "0").replace("0.92 * brine", "0");
    let bubbles = Recipe::parse("variant", "variant", &bubbles)?;
    writeln!(out, "\n| brine | sigma_s' at 550 nm (1/m) | without air |\n|---|---|---|")?;
    for (name, recipe) in [
        ("volume-to-area spheres, as printed", &shaped),
        ("spheres of the same volume", &volume),
        ("all in bubbles", &bubbles),
    ] {
        writeln!(out, "| {name} | {:.2} | {:.2} |", reduced(recipe, &[])?, reduced(recipe, &[("air", 0.0)])?)?;
    }
    let cold = Recipe::find("sea-ice")?;
    writeln!(out, "\n| temperature (degC) | sigma_s' at 550 nm (1/m) | without air |\n|---|---|---|")?;
    for temperature in [-2.0, -5.0, -10.0, -15.0, -20.0, -25.0, -30.0] {
        let at = ("temperature", temperature);
        writeln!(
            out,
            "| {temperature} | {:.2} | {:.2} |",
            reduced(&cold, &[at])?,
            reduced(&cold, &[at, ("air", 0.0)])?
        )?;
    }
    Ok(())
}

fn words(values: &[f64], digits: usize) -> String {
    values.iter().map(|value| mieux::io::quantity::significant(*value, digits)).collect::<Vec<_>>().join(" ")
}
