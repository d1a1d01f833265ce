//! `mieux substances`: what can be typed, and what is printed.

use std::io::{self, Write};
use std::path::PathBuf;

use clap::Args;
use mieux::jobs::{SubstanceIndex, SubstanceReport, format_range, substances_json};
use mieux::optics::substance::{Solute, SubstanceEntry};

use crate::args::Format;
use crate::failure::Failure;

const EXAMPLES: &str = "\
Examples:
  mieux substances
  mieux substances water --temperature 5 --salinity 35 --wavelengths 400nm:700nm:50nm
  mieux substances ice --wavelengths 300nm,1um,3um -o out/ice
  mieux substances --index-file my.yml --transparent
  mieux substances --index-db refractiveindex.info-database --page TiO2/Devore-o --transparent

With -o, DIR holds substance.csv and the plot substance.svg.

JSON keys of one substance: substance, title, sources (keys of references.bib), notes (what had to
be put right in the data), and arrays wavelength_nm, n_real, n_imag, absorption_per_m. Of the list:
substances, an array of name, about, wavelength_nm (first and last, null where it is known at all),
temperature_degC and salinity_g_per_kg (lowest and highest, null where they do not act), sources;
and solutes.";

/// List the substances that are known, or show the refractive index of one
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct SubstancesArgs {
    /// A substance [default: list them all]
    pub name: Option<String>,
    /// A file of the refractiveindex.info database, or of the same form
    #[arg(long, value_name = "FILE", conflicts_with_all = ["name", "index_db"])]
    index_file: Option<PathBuf>,
    /// A folder with that database
    #[arg(long, value_name = "DIR", requires = "page", conflicts_with = "name")]
    index_db: Option<PathBuf>,
    /// A page of the database, as in `main/TiO2/Devore-o`
    #[arg(long, value_name = "PAGE", requires = "index_db")]
    page: Option<String>,
    /// Take the imaginary part for zero where the file or page gives none
    #[arg(long)]
    transparent: bool,
    /// Temperature in degrees Celsius [default: 20, or what comes nearest]
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true)]
    temperature: Option<f64>,
    /// Salinity in g/kg [default: 0]
    #[arg(long, value_name = "G/KG", allow_hyphen_values = true)]
    salinity: Option<f64>,
    /// Wavelengths in vacuum, as in `400nm:700nm:25nm` or `450nm,550nm` [default: 375nm:775nm:25nm as far as known]
    #[arg(long, value_name = "WAVELENGTHS")]
    wavelengths: Option<String>,
    /// How to print the result
    #[arg(long, value_enum, default_value = "table")]
    pub format: Format,
    /// Folder for table and plot
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

impl SubstancesArgs {
    /// The job, or nothing where all are to be listed.
    pub fn job(self) -> Option<SubstanceIndex> {
        if self.name.is_none() && self.index_file.is_none() && self.index_db.is_none() {
            return None;
        }
        Some(SubstanceIndex {
            name: self.name,
            index_file: self.index_file,
            index_db: self.index_db,
            page: self.page,
            temperature: self.temperature,
            salinity: self.salinity,
            transparent: self.transparent,
            wavelengths: self.wavelengths,
            output: self.output,
        })
    }
}

/// The wavelengths (m) for which an entry is known in its typical state; `None` for all.
fn range(entry: &SubstanceEntry) -> Option<(f64, f64)> {
    entry.substance(entry.typical()).ok().and_then(|substance| substance.wavelength_range())
}

pub fn list(format: Format) -> Result<(), Failure> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    match format {
        Format::Table => {
            for entry in SubstanceEntry::ALL {
                let wavelengths = range(&entry).map_or("all wavelengths".into(), |(a, b)| format_range(a, b));
                writeln!(out, "{:<19} {}", entry.name, entry.about)?;
                let mut line = wavelengths;
                for (name, unit, range) in
                    [("temperature", "degC", entry.temperature), ("salinity", "g/kg", entry.salinity)]
                {
                    if let Some((low, high)) = range {
                        line += &format!("; {name} {low} to {high} {unit}");
                    }
                }
                if !entry.sources.is_empty() {
                    line += &format!("; {}", entry.sources.join(" "));
                }
                writeln!(out, "    {line}")?;
            }
            writeln!(
                out,
                "\nSolutes: {}. More, and how to add to them, is in docs/substances.md.",
                Solute::NAMES.join(", ")
            )?;
        }
        Format::Csv => {
            writeln!(out, "name,about,from_nm,to_nm,sources")?;
            for entry in SubstanceEntry::ALL {
                let (first, last) = range(&entry)
                    .map_or((String::new(), String::new()), |(a, b)| (nm(a).to_string(), nm(b).to_string()));
                let sources = entry.sources.join(" ");
                writeln!(out, "{},\"{}\",{first},{last},{sources}", entry.name, entry.about)?;
            }
        }
        Format::Json => writeln!(out, "{:#}", substances_json())?,
    }
    Ok(out.flush()?)
}

/// Nanometres without what the change of unit has left.
fn nm(wavelength_m: f64) -> String {
    ((wavelength_m * 1e15).round() / 1e6).to_string()
}

pub fn show(report: &SubstanceReport, format: Format) -> Result<(), Failure> {
    let mut out = io::BufWriter::new(io::stdout().lock());
    match format {
        Format::Table => {
            write!(out, "{}", report.sheet.table()?.to_text(6))?;
            for note in report.sheet.notes() {
                writeln!(out, "Note: {note}.")?;
            }
            for file in &report.files {
                writeln!(out, "{}", file.display())?;
            }
        }
        Format::Csv => report.sheet.table()?.write_csv(&mut out)?,
        Format::Json => writeln!(out, "{:#}", report.sheet.json())?,
    }
    Ok(out.flush()?)
}
