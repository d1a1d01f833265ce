//! A phase function beside others, as they are shown, tabulated, plotted and written down.

use mieux_io::plot::comparison_figure;
use mieux_io::quantity::{Angles, significant};
use mieux_io::table::Table;
use mieux_optics::phase::{Comparison, PhaseFunction, compare};
use serde_json::{Map, Value, json};

use super::{JobError, Named, model};

/// Equal steps over angle in a plot, at least and at most.
const FEWEST_PLOTTED: usize = 720;
const MOST_PLOTTED: usize = 3600;

/// A phase function, and what it was compared with.
#[derive(Debug, Clone, PartialEq)]
pub struct PhaseSheet {
    /// The function.
    pub function: Named,
    /// The others.
    pub compared: Vec<Compared>,
    /// Angles at which values are given, degrees.
    pub degrees: Vec<f64>,
    /// The highest Legendre moment that is given.
    pub moments: u32,
    cosines: Vec<f64>,
}

/// Another phase function, and how far it is from the first.
#[derive(Debug, Clone, PartialEq)]
pub struct Compared {
    /// The function.
    pub other: Named,
    /// Whether it was fitted to the first.
    pub fitted: bool,
    /// How far it is.
    pub comparison: Comparison,
}

impl PhaseSheet {
    pub(super) fn new(function: Named, angles: Option<Angles>, moments: u32) -> Self {
        let (degrees, cosines): (Vec<f64>, Vec<f64>) = match angles {
            Some(angles) => (angles.degrees().collect(), angles.cosines().collect()),
            None => (0..=36u32).map(|i| 5.0 * f64::from(i)).map(|angle| (angle, cosine(angle))).unzip(),
        };
        Self { function, compared: Vec::new(), degrees, moments, cosines }
    }

    pub(super) fn compare(&mut self, other: Named, fitted: bool) {
        let comparison = compare(&self.function.phase, &other.phase);
        self.compared.push(Compared { other, fitted, comparison });
    }

    /// Values in 1/sr at the angles.
    pub fn values(&self, phase: &PhaseFunction) -> Vec<f64> {
        self.cosines.iter().map(|mu| phase.value(*mu)).collect()
    }

    /// Legendre moments from degree 0 on.
    pub fn legendre_moments(&self, phase: &PhaseFunction) -> Vec<f64> {
        phase.legendre_moments(self.moments)
    }

    /// Names and values of the parameters of a function, in SI; none of a table.
    pub fn parameters(phase: &PhaseFunction) -> Vec<(&'static str, f64)> {
        model::parameters(phase)
    }

    /// The values in 1/sr, one column per function and one row per angle, with the rest as remarks.
    ///
    /// # Errors
    /// Never; the table checks the lengths of its columns.
    pub fn table(&self) -> Result<Table, JobError> {
        let phase = &self.function.phase;
        let mut table = Table::new(self.function.title.clone())
            .with_metadata("asymmetry", format!("{}", phase.asymmetry()))
            .with_metadata("legendre_moments", words(&self.legendre_moments(phase)));
        if let Some(source) = phase.source() {
            table = table.with_metadata("source", source);
        }
        for Compared { other, fitted, comparison: c } in &self.compared {
            let kind = if *fitted { "fit " } else { "" };
            let parameters: Vec<String> =
                Self::parameters(&other.phase).into_iter().map(|(name, value)| format!("{name} = {value}")).collect();
            let text = format!(
                "{}; asymmetry {}, rms_log10 {:.3e}, max_log10 {:.3e}, total_variation {:.3e}{}",
                other.title,
                other.phase.asymmetry(),
                c.rms_log10,
                c.max_log10,
                c.total_variation,
                if parameters.is_empty() { String::new() } else { format!("; {}", parameters.join(", ")) }
            );
            table = table.with_metadata(format!("{kind}{}", other.name), text);
        }
        table = table.with_column("angle", "deg", self.degrees.clone())?.with_column(
            "phase",
            "1/sr",
            self.values(phase),
        )?;
        for Compared { other, .. } in &self.compared {
            table = table.with_column(other.name.replace('-', "_"), "1/sr", self.values(&other.phase))?;
        }
        Ok(table)
    }

    /// As JSON.
    pub fn json(&self) -> Value {
        let mut value = self.described(&self.function);
        value.insert("angle_deg".into(), json!(self.degrees));
        value.insert("phase_per_sr".into(), json!(self.values(&self.function.phase)));
        let comparisons: Vec<Value> = self
            .compared
            .iter()
            .map(|Compared { other, fitted, comparison: c }| {
                let mut value = self.described(other);
                value.insert("fitted".into(), json!(fitted));
                value.insert("delta_asymmetry".into(), json!(c.delta_asymmetry));
                value.insert("rms_log10".into(), json!(c.rms_log10));
                value.insert("max_log10".into(), json!(c.max_log10));
                value.insert("total_variation".into(), json!(c.total_variation));
                value.insert("phase_per_sr".into(), json!(self.values(&other.phase)));
                Value::Object(value)
            })
            .collect();
        value.insert("comparisons".into(), Value::Array(comparisons));
        Value::Object(value)
    }

    /// What the function is by itself.
    fn described(&self, named: &Named) -> Map<String, Value> {
        let phase = &named.phase;
        let parameters: Map<String, Value> =
            Self::parameters(phase).into_iter().map(|(name, value)| (name.to_owned(), json!(value))).collect();
        let mut value = Map::new();
        value.insert("phase".into(), json!(named.name));
        value.insert("title".into(), json!(named.title));
        value.insert("parameters".into(), Value::Object(parameters));
        value.insert("source".into(), json!(phase.source()));
        value.insert("asymmetry".into(), json!(phase.asymmetry()));
        value.insert("legendre_moments".into(), json!(self.legendre_moments(phase)));
        value
    }

    /// The figure, as SVG.
    ///
    /// # Errors
    /// [`JobError::Plot`].
    pub fn svg(&self) -> Result<String, JobError> {
        // A table asks for angles as fine as its own, as far as a picture can show them.
        let all = || std::iter::once(&self.function).chain(self.compared.iter().map(|c| &c.other));
        let bins = all().map(|named| match &named.phase {
            PhaseFunction::Tabulated(table) => table.grid().len(),
            _ => 0,
        });
        let count = bins.max().unwrap_or(0).clamp(FEWEST_PLOTTED, MOST_PLOTTED);
        let step = 180.0 / count as f64;
        let mut angles: Vec<f64> = (0..=20).map(|i| step * 0.7f64.powi(20 - i)).filter(|a| *a < step).collect();
        angles.insert(0, 0.0);
        angles.extend((1..count).map(|i| step * i as f64));
        angles.push(180.0);
        let curve = |named: &Named| {
            let label = if named == &self.function { short(named) } else { named.name.clone() };
            (label, angles.iter().map(|angle| named.phase.value(cosine(*angle))).collect::<Vec<f64>>())
        };
        let mut curves: Vec<(String, Vec<f64>)> = all().map(curve).collect();
        for (compared, (label, _)) in self.compared.iter().zip(curves.iter_mut().skip(1)) {
            if compared.fitted {
                label.push_str(" fit");
            }
        }
        Ok(comparison_figure(&self.function.title, &angles, &curves).to_svg()?)
    }
}

/// A name that fits into a legend.
fn short(named: &Named) -> String {
    match named.name.rsplit(['/', '\\']).next() {
        Some(stem) if stem.chars().count() <= 24 => stem.to_owned(),
        _ => "this one".to_owned(),
    }
}

fn cosine(degrees: f64) -> f64 {
    if degrees > 90.0 { -(180.0 - degrees).to_radians().cos() } else { degrees.to_radians().cos() }
}

fn words(values: &[f64]) -> String {
    values.iter().map(|value| significant(*value, 6)).collect::<Vec<_>>().join(" ")
}
