//! The job behind `mieux substances NAME`: the refractive index of one substance over wavelength.

use std::path::PathBuf;

use mieux_io::index_file::{IndexDatabase, read_index_file};
use mieux_io::nearest_names;
use mieux_io::output::OutputDir;
use mieux_io::plot::{Figure, Panel, Scale, Series};
use mieux_io::quantity::parse_wavelengths;
use mieux_io::table::Table;
use mieux_optics::Complex64;
use mieux_optics::medium::absorption_coefficient;
use mieux_optics::spectrum::WavelengthGrid;
use mieux_optics::substance::{Conditions, Dispersion, Solute, Substance, SubstanceEntry, SubstanceError};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::{Context, Event, JobError, Stage, wavelengths};

/// The refractive index of a substance over wavelength. One of `name`, `index_file`, and `index_db` with `page`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SubstanceIndex {
    /// A substance that is known.
    #[serde(default)]
    pub name: Option<String>,
    /// A file of the refractiveindex.info database or of the same form.
    #[serde(default)]
    pub index_file: Option<PathBuf>,
    /// A folder with that database.
    #[serde(default)]
    pub index_db: Option<PathBuf>,
    /// A page of it: shelf, book and page joined by `/`.
    #[serde(default)]
    pub page: Option<String>,
    /// Temperature, degrees Celsius; 20, or what comes nearest, when left out.
    #[serde(default)]
    pub temperature: Option<f64>,
    /// Salinity, g/kg; none when left out.
    #[serde(default)]
    pub salinity: Option<f64>,
    /// Take the imaginary part for zero where a file or page does not give one.
    #[serde(default)]
    pub transparent: bool,
    /// As typed: `400nm:700nm:25nm` or `450nm,550nm`.
    #[serde(default)]
    pub wavelengths: Option<String>,
    /// Folder for table and plot; nothing is written when left out.
    #[serde(default)]
    pub output: Option<PathBuf>,
}

impl SubstanceIndex {
    /// How many wavelengths are shown of what has none of the usual ones.
    const POINTS: u32 = 25;

    pub(super) fn run(&self, context: &Context<'_>) -> Result<SubstanceReport, JobError> {
        let (title, sources, substance) = self.substance()?;
        let grid = self.grid(&substance)?;
        let index: Vec<Complex64> = grid.iter().map(|w| substance.index(w)).collect::<Result<_, _>>()?;
        let sheet = SubstanceSheet { title, sources, substance, grid, index };
        let mut files = Vec::new();
        if let Some(folder) = &self.output {
            let dir = OutputDir::create(folder)?;
            context.say(Event::Begin(Stage::Write));
            let (table, svg) = (sheet.table()?, sheet.figure().to_svg()?);
            files.push(dir.write("substance.csv", |out| table.write_csv(out))?);
            files.push(dir.write("substance.svg", |out| out.write_all(svg.as_bytes()))?);
            dir.commit();
            context.say(Event::End(Stage::Write));
        }
        Ok(SubstanceReport { sheet, files })
    }

    /// A heading, keys of the sources, and the substance.
    fn substance(&self) -> Result<(String, Vec<&'static str>, Substance), JobError> {
        match (&self.name, &self.index_file, &self.index_db, &self.page) {
            (Some(name), None, None, None) => {
                if self.transparent {
                    return Err(Self::only("transparent", "a file or page"));
                }
                let entry = SubstanceEntry::named(name).ok_or_else(|| {
                    let nearest = nearest_names(name, Substance::NAMES);
                    JobError::NoSuchSubstance { name: name.clone(), help: nearest_substances(&nearest) }
                })?;
                let typical = entry.typical();
                if self.temperature.is_some() && entry.temperature.is_none() {
                    return Err(Self::only("temperature", "substances on which it acts"));
                }
                if self.salinity.is_some() && entry.salinity.is_none() {
                    return Err(Self::only("salinity", "substances on which it acts"));
                }
                let conditions = Conditions {
                    temperature_c: self.temperature.unwrap_or(typical.temperature_c),
                    salinity: self.salinity.unwrap_or(typical.salinity),
                };
                Ok((entry.about.to_owned(), entry.sources.to_vec(), entry.substance(conditions)?))
            }
            (None, Some(file), None, None) => self.dispersive(file.display().to_string(), read_index_file(file)?),
            (None, None, Some(folder), Some(page)) => {
                let database = IndexDatabase::open(folder)?;
                let page = database.find(page)?;
                self.dispersive(format!("{}: {}", page.name, page.title), database.read(page)?)
            }
            _ => Err(JobError::Value {
                name: "substance",
                value: "given several times or not at all".into(),
                allowed: "one of a name, a file, and a database with a page",
            }),
        }
    }

    fn dispersive(
        &self,
        title: String,
        dispersion: Dispersion,
    ) -> Result<(String, Vec<&'static str>, Substance), JobError> {
        if self.temperature.is_some() || self.salinity.is_some() {
            return Err(Self::only("temperature or salinity", "substances known by name"));
        }
        let dispersion = if self.transparent { dispersion.assume_transparent() } else { dispersion };
        Ok((title, Vec::new(), dispersion.into()))
    }

    fn only(name: &'static str, allowed: &'static str) -> JobError {
        JobError::Belongs { name, to: allowed }
    }

    /// The wavelengths asked for, or the usual ones as far as there is data, or some of those for which there is.
    fn grid(&self, substance: &Substance) -> Result<WavelengthGrid, JobError> {
        if let Some(text) = &self.wavelengths {
            return Ok(parse_wavelengths(text)?);
        }
        let usual = WavelengthGrid::frisvad2007();
        let Some((first, last)) = substance.wavelength_range().filter(|(first, last)| first <= last) else {
            return Ok(usual);
        };
        if let Some(known) = wavelengths::known([(first, last)]) {
            return Ok(known);
        }
        let steps = f64::from(Self::POINTS - 1);
        let between = |i: u32| first * (last / first).powf(f64::from(i) / steps);
        let mut wavelengths: Vec<f64> = (0..Self::POINTS).map(between).collect();
        wavelengths.dedup();
        Ok(WavelengthGrid::new(wavelengths)?)
    }
}

/// What may have been meant.
fn nearest_substances(nearest: &[&str]) -> String {
    let list = "`mieux substances` lists them all";
    match nearest {
        [] => list.into(),
        names => format!("did you mean `{}`? {list}", names.join("` or `")),
    }
}

impl From<SubstanceError> for JobError {
    fn from(error: SubstanceError) -> Self {
        Self::Substance(Box::new(error))
    }
}

/// A substance and its refractive index on a grid of wavelengths.
#[derive(Debug, Clone, PartialEq)]
pub struct SubstanceSheet {
    /// What it is.
    pub title: String,
    /// Keys of the sources.
    pub sources: Vec<&'static str>,
    /// The substance.
    pub substance: Substance,
    /// The wavelengths.
    pub grid: WavelengthGrid,
    /// Its index at each.
    pub index: Vec<Complex64>,
}

impl SubstanceSheet {
    fn nanometres(&self) -> Vec<f64> {
        self.grid.iter().map(|w| (w * 1e9 * 1e6).round() / 1e6).collect()
    }

    fn real(&self) -> Vec<f64> {
        self.index.iter().map(|n| n.re).collect()
    }

    fn imaginary(&self) -> Vec<f64> {
        self.index.iter().map(|n| n.im).collect()
    }

    fn absorption(&self) -> Vec<f64> {
        self.index.iter().zip(self.grid.iter()).map(|(n, w)| absorption_coefficient(*n, w)).collect()
    }

    /// What had to be put right in its data, in words.
    pub fn notes(&self) -> Vec<String> {
        self.substance.notes().iter().map(ToString::to_string).collect()
    }

    /// As a table, with units in the column names and the rest in its head.
    ///
    /// # Errors
    /// Never; the table checks the lengths of its columns.
    pub fn table(&self) -> Result<Table, JobError> {
        let mut table = Table::new(self.title.clone()).with_metadata("substance", self.substance.describe());
        if !self.sources.is_empty() {
            table = table.with_metadata("sources", self.sources.join(" "));
        }
        if let Some((first, last)) = self.substance.wavelength_range() {
            table = table.with_metadata("known from", format_range(first, last));
        }
        for note in self.notes() {
            table = table.with_metadata("note", note);
        }
        let columns = [
            ("wavelength", "nm", self.nanometres()),
            ("n_real", "", self.real()),
            ("n_imag", "", self.imaginary()),
            ("absorption", "per_m", self.absorption()),
        ];
        for (name, unit, values) in columns {
            table = table.with_column(name, unit, values)?;
        }
        Ok(table)
    }

    /// As JSON: arrays of one length.
    pub fn json(&self) -> serde_json::Value {
        json!({
            "substance": self.substance.describe(),
            "title": self.title,
            "sources": self.sources,
            "notes": self.notes(),
            "wavelength_nm": self.nanometres(),
            "n_real": self.real(),
            "n_imag": self.imaginary(),
            "absorption_per_m": self.absorption(),
        })
    }

    /// Real part, imaginary part and absorption over wavelength.
    pub fn figure(&self) -> Figure {
        let nanometres = self.nanometres();
        let (first, last) = self.grid.range();
        let x = if last > 5.0 * first { Scale::Log } else { Scale::Linear };
        let absorbs = self.index.iter().any(|n| n.im > 0.0);
        let y = if absorbs { Scale::Log } else { Scale::Linear };
        // Logarithmic axes end at 1e-10, above what ice absorbs.
        let faint = self.index.iter().any(|n| n.im > 0.0 && n.im < 1e-9);
        let (label, scale) = if faint { ("Imaginary part k (10⁻⁹)", 1e9) } else { ("Imaginary part k", 1.0) };
        let imaginary = self.imaginary().iter().map(|k| k * scale).collect();
        let panel = |title: &str, label: &str, y, values: Vec<f64>| {
            Panel::new(title, "Wavelength in vacuum (nm)", label)
                .with_scales(x, y)
                .with_series(Series::new(label, nanometres.iter().copied().zip(values)))
        };
        Figure::new(&self.title, 2)
            .with_panel(panel("Refraction", "Real part n", Scale::Linear, self.real()))
            .with_panel(panel("Absorption", label, y, imaginary))
            .with_panel(panel("Absorption coefficient", "4πk/λ (1/m)", y, self.absorption()))
    }
}

/// The substances and solutes that are known, as JSON.
pub fn substances_json() -> serde_json::Value {
    let nm = |wavelength_m: f64| (wavelength_m * 1e15).round() / 1e6;
    let entries: Vec<_> = SubstanceEntry::ALL
        .iter()
        .map(|entry| {
            let range = entry.substance(entry.typical()).ok().and_then(|substance| substance.wavelength_range());
            json!({
                "name": entry.name,
                "about": entry.about,
                "wavelength_nm": range.map(|(first, last)| [nm(first), nm(last)]),
                "temperature_degC": entry.temperature,
                "salinity_g_per_kg": entry.salinity,
                "sources": entry.sources,
            })
        })
        .collect();
    json!({ "substances": entries, "solutes": Solute::NAMES })
}

/// Two wavelengths (m) in the unit that suits the first.
pub fn format_range(first: f64, last: f64) -> String {
    use mieux_io::quantity::format_length;
    format!("{} to {}", format_length(first), format_length(last))
}

/// What [`SubstanceIndex`] leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct SubstanceReport {
    /// The index.
    pub sheet: SubstanceSheet,
    /// The files written.
    pub files: Vec<PathBuf>,
}
