//! Optical properties side by side, as they are shown, tabulated and plotted.

use std::collections::BTreeMap;
use std::path::Path;

use mieux_io::measured::{Measured, Property};
use mieux_io::plot::{Figure, Panel, Scale, Series};
use mieux_io::table::Table;
use mieux_optics::spectrum::{Sampled, WavelengthGrid};
use serde_json::{Map, Value, json};

use super::super::{JobError, OpticsSheet};

/// One of the things compared.
#[derive(Debug, Clone, PartialEq)]
pub struct Side {
    /// Name, as asked for, with the inputs that were set; or that of the file.
    pub name: String,
    /// What to call it in a legend.
    pub title: String,
    /// What is known of it, one value per wavelength, NaN where missing; in 1/m or plain.
    pub properties: Vec<(Property, Vec<f64>)>,
}

/// How far a side is from the first in one property, over the wavelengths at which both have a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// The property.
    pub property: Property,
    /// Mean of the ratio to the first side's value, a geometric mean; NaN for g.
    pub mean_ratio: f64,
    /// Largest factor by which they differ, at least 1; NaN for g.
    pub largest_factor: f64,
    /// Root mean square of the plain difference.
    pub rms: f64,
}

/// Two or three sides on one grid of wavelengths.
#[derive(Debug, Clone, PartialEq)]
pub struct CompareSheet {
    /// The wavelengths.
    pub grid: WavelengthGrid,
    /// The first is what the others are compared with.
    pub sides: Vec<Side>,
}

impl Side {
    /// A material; its title tells the inputs that were `set`.
    pub(super) fn computed(sheet: &OpticsSheet, set: &BTreeMap<String, f64>) -> Self {
        let b = &sheet.bulk;
        let of = |property| match property {
            Property::Scattering => b.sigma_s().to_vec(),
            Property::ReducedScattering => b.reduced_scattering(),
            Property::Absorption => b.sigma_a().to_vec(),
            Property::Extinction => b.sigma_t(),
            Property::Asymmetry => b.asymmetry().to_vec(),
            Property::IndexReal => b.n_real().to_vec(),
            Property::IndexImaginary => b.n_imag(),
        };
        let changed = sheet.material.inputs.iter().filter(|(input, _)| set.contains_key(&*input.name));
        let changed: Vec<String> =
            changed.map(|(input, value)| format!("{} {}", input.name, input.shown(*value))).collect();
        let title = match changed.as_slice() {
            [] => sheet.material.title.clone(),
            changed => format!("{} ({})", sheet.material.title, changed.join(", ")),
        };
        let properties = Property::ALL.into_iter().map(|property| (property, of(property))).collect();
        Self { name: sheet.material.name.clone(), title, properties }
    }

    /// Interpolated linearly to the grid; missing outside what was measured.
    pub(super) fn measured(path: &Path, measured: &Measured, grid: &WavelengthGrid) -> Self {
        let on_grid = |values: &Vec<f64>| {
            let known = measured.grid.iter().zip(values).filter(|(_, value)| value.is_finite());
            let (wavelengths, values): (Vec<f64>, Vec<f64>) = known.unzip();
            let known = WavelengthGrid::new(wavelengths).and_then(|grid| Sampled::new(grid, values));
            grid.iter().map(|w| known.as_ref().ok().and_then(|k| k.at(w)).unwrap_or(f64::NAN)).collect()
        };
        let name = path.display().to_string();
        let properties = measured.properties.iter().map(|(property, values)| (*property, on_grid(values))).collect();
        Self {
            title: path.file_stem().map_or_else(|| name.clone(), |s| s.to_string_lossy().into_owned()),
            name,
            properties,
        }
    }

    fn get(&self, property: Property) -> Option<&[f64]> {
        self.properties.iter().find(|(known, _)| *known == property).map(|(_, values)| values.as_slice())
    }
}

impl CompareSheet {
    pub(super) fn new(grid: WavelengthGrid, sides: Vec<Side>) -> Self {
        Self { grid, sides }
    }

    /// Properties that more than one side has.
    fn shared(&self) -> impl Iterator<Item = Property> + '_ {
        let has = |property: &Property| self.sides.iter().filter(|side| side.get(*property).is_some()).count() > 1;
        Property::ALL.into_iter().filter(has)
    }

    /// How far the side of that number is from the first, property by property.
    pub fn differences(&self, side: usize) -> Vec<Difference> {
        let difference = |property: Property| {
            let (a, b) = (self.sides[0].get(property)?, self.sides.get(side)?.get(property)?);
            let pairs: Vec<(f64, f64)> =
                a.iter().copied().zip(b.iter().copied()).filter(|(a, b)| a.is_finite() && b.is_finite()).collect();
            let logs = pairs.iter().filter(|(a, b)| *a > 0.0 && *b > 0.0).map(|(a, b)| (b / a).ln());
            let logs: Vec<f64> = if property == Property::Asymmetry { Vec::new() } else { logs.collect() };
            let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
            let squares: Vec<f64> = pairs.iter().map(|(a, b)| (a - b).powi(2)).collect();
            Some(Difference {
                property,
                mean_ratio: mean(&logs).exp(),
                largest_factor: logs.iter().map(|l| l.abs()).reduce(f64::max).map_or(f64::NAN, f64::exp),
                rms: mean(&squares).sqrt(),
            })
        };
        Property::ALL.into_iter().filter_map(difference).collect()
    }

    fn nanometres(&self) -> Vec<f64> {
        self.grid.iter().map(|w| (w * 1e9 * 1e6).round() / 1e6).collect()
    }

    fn title(&self) -> String {
        self.sides.iter().map(|side| side.title.as_str()).collect::<Vec<_>>().join(" and ")
    }

    /// Letters for the sides, in their order, with what they stand for.
    pub fn legend(&self) -> Vec<(char, &str)> {
        ('a'..).zip(self.sides.iter().map(|side| side.title.as_str())).collect()
    }

    /// One column for each property that sides share and each side, with the differences as remarks.
    ///
    /// # Errors
    /// Never; the table checks the lengths of its columns.
    pub fn table(&self) -> Result<Table, JobError> {
        let mut table = Table::new(self.title());
        for (letter, title) in self.legend() {
            table = table.with_metadata(letter, title);
        }
        for (i, side) in self.sides.iter().enumerate().skip(1) {
            for d in self.differences(i) {
                let ratio = if d.mean_ratio.is_nan() {
                    String::new()
                } else {
                    format!(
                        "{:.4} times that of {}, apart by at most a factor of {:.4}; ",
                        d.mean_ratio, self.sides[0].title, d.largest_factor
                    )
                };
                let rms = format!("rms difference {:.3e} {}", d.rms, d.property.unit());
                table = table.with_metadata(
                    format!("{} of {}", d.property.name(), side.title),
                    format!("{ratio}{}", rms.trim_end()),
                );
            }
        }
        table = table.with_column("wavelength", "nm", self.nanometres())?;
        for property in self.shared() {
            for (letter, side) in ('a'..).zip(&self.sides) {
                if let Some(values) = side.get(property) {
                    let name = format!("{}_{letter}", property.name());
                    table = table.with_column(name, property.unit(), values.to_vec())?;
                }
            }
        }
        Ok(table)
    }

    /// As JSON.
    pub fn json(&self) -> Value {
        let values = |v: &[f64]| json!(v.iter().map(|v| v.is_finite().then_some(*v)).collect::<Vec<_>>());
        let sides = self.sides.iter().enumerate().map(|(i, side)| {
            let mut found: Map<String, Value> = side.properties.iter().map(|(property, v)| {
                let unit = if property.unit().is_empty() { "" } else { "_per_m" };
                (format!("{}{unit}", property.name()), values(v))
            }).collect();
            found.insert("name".into(), json!(side.name));
            found.insert("title".into(), json!(side.title));
            if i > 0 {
                let differences: Map<String, Value> = self.differences(i).into_iter().map(|d| {
                    let finite = |v: f64| v.is_finite().then_some(v);
                    let value = json!({"mean_ratio": finite(d.mean_ratio), "largest_factor": finite(d.largest_factor), "rms": finite(d.rms)});
                    (d.property.name().to_owned(), value)
                }).collect();
                found.insert("differences".into(), Value::Object(differences));
            }
            Value::Object(found)
        });
        json!({"wavelength_nm": self.nanometres(), "sides": sides.collect::<Vec<_>>()})
    }

    /// The figure, as SVG: a panel for each property that sides share, but those that follow from others.
    ///
    /// # Errors
    /// [`JobError::Plot`].
    pub fn svg(&self) -> Result<String, JobError> {
        let nanometres = self.nanometres();
        let mut figure = Figure::new(self.title(), 2);
        for property in self.shared() {
            let (title, y, scale) = match property {
                Property::Scattering => ("Scattering", "Coefficient σₛ (1/m)", Scale::Log),
                Property::ReducedScattering => ("Reduced scattering", "Coefficient σₛ′ (1/m)", Scale::Log),
                Property::Absorption => ("Absorption", "Coefficient σₐ (1/m)", Scale::Log),
                Property::Asymmetry => ("Asymmetry", "Mean cosine g", Scale::LinearOver(0.0, 1.0)),
                Property::IndexReal => ("Refractive index", "Real part n", Scale::Linear),
                Property::Extinction | Property::IndexImaginary => continue,
            };
            let mut panel = Panel::new(title, "Wavelength in vacuum (nm)", y).with_scales(Scale::Linear, scale);
            let mut shows = false;
            for side in &self.sides {
                if let Some(values) = side.get(property) {
                    shows |= values.iter().any(|v| v.is_finite() && (scale != Scale::Log || *v > 0.0));
                    panel = panel
                        .with_series(Series::new(&side.title, nanometres.iter().copied().zip(values.iter().copied())));
                }
            }
            if shows {
                figure = figure.with_panel(panel);
            }
        }
        Ok(figure.to_svg()?)
    }
}
