//! Inverted slabs as they are shown, tabulated, plotted and written down.

use mieux_io::plot::{self, inversion_figure};
use mieux_io::rxt::RxtRow;
use mieux_io::table::Table;
use mieux_optics::transfer::inverse::{Estimate, Found, InverseError, Sample};
use serde_json::{Value, json};

use super::JobError;

/// Slabs and what they are made of.
#[derive(Debug, Clone, PartialEq)]
pub struct InvertSheet {
    /// Where the measurements come from.
    pub title: String,
    /// Standard error of the total shares.
    pub error: f64,
    /// Relative standard error of the unscattered share.
    pub unscattered_error: f64,
    /// The slabs.
    pub rows: Vec<Inverted>,
}

/// A slab and what it is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct Inverted {
    /// What was measured.
    pub row: RxtRow,
    /// What was taken for granted.
    pub sample: Sample,
    /// Of the sample, m.
    pub thickness: f64,
    /// What was found, or why nothing was.
    pub outcome: Result<Found, InverseError>,
}

impl Inverted {
    /// A coefficient in 1/mm. Of a sample without end only ratios are known: its reduced scattering counts as 1/mm.
    fn per_millimetre(&self, pick: fn(&Found) -> Estimate) -> Estimate {
        let Ok(found) = &self.outcome else { return Estimate { value: f64::NAN, error: f64::NAN } };
        let length = if found.optical_thickness.is_finite() { self.thickness * 1e3 } else { 1.0 };
        let Estimate { value, error } = pick(found);
        Estimate { value: value / length, error: error / length }
    }

    fn asymmetry(&self) -> Estimate {
        self.outcome.as_ref().map_or(Estimate { value: f64::NAN, error: f64::NAN }, |found| found.asymmetry)
    }

    /// Why what was found is not what was measured; `None` where it is.
    pub fn remark(&self) -> Option<String> {
        match &self.outcome {
            Ok(found) => found.misfit.map(|misfit| misfit.to_string()),
            Err(error) => Some(error.to_string()),
        }
    }

    /// 0: solved, 1: the nearest, 2: nothing.
    fn flag(&self) -> u8 {
        match &self.outcome {
            Ok(found) => u8::from(found.misfit.is_some()),
            Err(_) => 2,
        }
    }
}

/// A column of the table: a name, a unit, and what a row has in it.
type Column = (&'static str, &'static str, fn(&Inverted) -> f64);

const COLUMNS: [Column; 12] = [
    ("mu_a", "1/mm", |r| r.per_millimetre(|f| f.absorption).value),
    ("mu_a_error", "1/mm", |r| r.per_millimetre(|f| f.absorption).error),
    ("mu_s_reduced", "1/mm", |r| r.per_millimetre(|f| f.reduced_scattering).value),
    ("mu_s_reduced_error", "1/mm", |r| r.per_millimetre(|f| f.reduced_scattering).error),
    ("mu_s", "1/mm", |r| r.per_millimetre(|f| f.scattering).value),
    ("mu_s_error", "1/mm", |r| r.per_millimetre(|f| f.scattering).error),
    ("g", "", |r| r.asymmetry().value),
    ("g_error", "", |r| r.asymmetry().error),
    ("albedo", "", |r| r.outcome.as_ref().map_or(f64::NAN, |f| f.albedo)),
    ("optical_thickness", "", |r| r.outcome.as_ref().map_or(f64::NAN, |f| f.optical_thickness)),
    ("residual", "", |r| r.outcome.as_ref().map_or(f64::NAN, |f| f.residual)),
    ("flag", "", |r| f64::from(r.flag())),
];

impl InvertSheet {
    fn column(&self, pick: fn(&Inverted) -> f64) -> Vec<f64> {
        self.rows.iter().map(pick).collect()
    }

    /// Wavelengths in nm, or numbers of rows where some have none.
    fn axis(&self) -> (&'static str, &'static str, Vec<f64>) {
        let wavelengths: Option<Vec<f64>> =
            self.rows.iter().map(|r| r.row.wavelength.map(|w| (w * 1e15).round() * 1e-6)).collect();
        match wavelengths {
            Some(wavelengths) => ("wavelength", "nm", wavelengths),
            None => ("row", "", (1..=self.rows.len()).map(|i| i as f64).collect()),
        }
    }

    /// Whether every slab counts as infinitely thick, so that coefficients are relative.
    fn endless(&self) -> bool {
        self.rows.iter().any(|r| r.outcome.as_ref().is_ok_and(|f| f.optical_thickness.is_infinite()))
    }

    /// A row a slab, a column a quantity.
    ///
    /// # Errors
    /// Never; the table checks the lengths of its columns.
    pub fn table(&self) -> Result<Table, JobError> {
        let mut table = Table::new(self.title.clone())
            .with_metadata("source", "prahl1993")
            .with_metadata("flag", "0: solved; 1: no slab has these shares, the nearest is given; 2: not inverted")
            .with_metadata(
                "errors",
                format!(
                    "standard, from {} in reflectance and transmittance and {} % of the unscattered transmittance",
                    self.error,
                    100.0 * self.unscattered_error
                ),
            );
        if self.endless() {
            table = table.with_metadata(
                "infinite samples",
                "where the optical thickness is infinite, coefficients are in units of the reduced scattering",
            );
        }
        if let Some(first) = self.rows.first() {
            table = table.with_metadata("sample", describe(first));
        }
        let (name, unit, values) = self.axis();
        table = table.with_column(name, unit, values)?;
        for (name, unit, pick) in COLUMNS {
            table = table.with_column(name, unit, self.column(pick))?;
        }
        Ok(table)
    }

    /// As JSON.
    pub fn json(&self) -> Value {
        let number = |value: f64| if value.is_finite() { json!(value) } else { Value::Null };
        let mut value = serde_json::Map::new();
        value.insert("measurements".into(), json!(self.title));
        let (name, unit, values) = self.axis();
        value.insert(if unit.is_empty() { name.into() } else { format!("{name}_{unit}") }, json!(values));
        for (name, unit, pick) in COLUMNS {
            let name = if unit.is_empty() { name.to_owned() } else { format!("{name}_per_mm") };
            value.insert(name, Value::Array(self.column(pick).into_iter().map(number).collect()));
        }
        let remarks: Vec<Option<String>> = self.rows.iter().map(Inverted::remark).collect();
        value.insert("remarks".into(), json!(remarks));
        let measured =
            |pick: fn(&RxtRow) -> Option<f64>| json!(self.rows.iter().map(|r| pick(&r.row)).collect::<Vec<_>>());
        value.insert("reflectance".into(), measured(|r| r.reflectance));
        value.insert("transmittance".into(), measured(|r| r.transmittance));
        value.insert("transmittance_unscattered".into(), measured(|r| r.unscattered));
        Value::Object(value)
    }

    /// The figure, as SVG; none of fewer than two slabs.
    ///
    /// # Errors
    /// [`JobError::Plot`].
    pub fn svg(&self) -> Result<Option<String>, JobError> {
        let [absorption, absorption_error, reduced, reduced_error, _, _, g, g_error, ..] =
            COLUMNS.map(|(_, _, pick)| self.column(pick));
        if self.rows.len() < 2 || !absorption.iter().any(|value| value.is_finite()) {
            return Ok(None);
        }
        let (name, _, x) = self.axis();
        let label = if name == "row" { "Row" } else { "Wavelength (nm)" };
        let of = |values, errors| plot::Measured { values, errors };
        let found = g_error.iter().any(|error| *error > 0.0);
        let asymmetry = found.then(|| of(&g[..], &g_error[..]));
        let figure = inversion_figure(
            &self.title,
            (label, &x),
            of(&absorption, &absorption_error),
            of(&reduced, &reduced_error),
            asymmetry,
        );
        Ok(Some(figure.to_svg()?))
    }
}

/// What was taken for granted.
fn describe(slab: &Inverted) -> String {
    let Sample { refractive_index, slide_index, asymmetry, .. } = slab.sample;
    let slides =
        if slide_index == 1.0 { "no slides".to_owned() } else { format!("between slides of index {slide_index}") };
    format!(
        "index {refractive_index}, {} mm thick, {slides}, g = {asymmetry} where it is not found",
        mieux_io::quantity::significant(slab.thickness * 1e3, 6)
    )
}
