//! The job behind `mieux sizes`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use mieux_io::output::OutputDir;
use mieux_io::plot::{Figure, Panel, Scale, Series};
use mieux_io::recipe::{Recipe, RecipeError, parse_setting, parse_size_distribution};
use mieux_io::table::Table;
use mieux_optics::particle::{SizeDistribution, Summary, WeightedSummary, Weighting};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::{Context, Event, JobError, Stage};

/// Kinds of distributions that can be named.
const KINDS: [&str; 9] = [
    "gamma",
    "log-normal",
    "modified-gamma",
    "monodisperse",
    "power-law",
    "rosin-rammler",
    "sum",
    "table",
    "transformed-log-normal",
];

/// Rows of a table.
const ROWS: u32 = 200;

/// What a size distribution amounts to in every weighting.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sizes {
    /// A kind of distribution, a built-in material, or the path of a recipe.
    pub of: String,
    /// `key=value`: what a recipe has under `size_distribution`, or inputs of the material.
    #[serde(default)]
    pub set: Vec<String>,
    /// In what the table counts up: number, surface, volume or intensity; volume when left out.
    #[serde(default)]
    pub weighting: Option<String>,
    /// Folder for tables and a plot; nothing is written when left out.
    #[serde(default)]
    pub output: Option<PathBuf>,
}

/// One distribution, and what it amounts to.
#[derive(Debug, Clone, PartialEq)]
pub struct Population {
    /// What has these sizes.
    pub name: String,
    /// The sizes.
    pub sizes: SizeDistribution,
    /// In numbers.
    pub summary: Summary,
    /// Whether sizes are radii, of spheres, or lengths.
    pub radii: bool,
}

/// What [`Sizes`] leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct SizesReport {
    /// What was asked about.
    pub title: String,
    /// In what tables count up.
    pub weighting: Weighting,
    /// Every distribution.
    pub populations: Vec<Population>,
    /// The files written.
    pub files: Vec<PathBuf>,
}

impl Sizes {
    /// Of a kind of distribution with its keys, or of a material with some inputs set.
    pub fn new(of: impl Into<String>) -> Self {
        Self { of: of.into(), set: Vec::new(), weighting: None, output: None }
    }

    pub(super) fn run(&self, context: &Context<'_>) -> Result<SizesReport, JobError> {
        let weighting = match &self.weighting {
            None => Weighting::Volume,
            Some(name) => Weighting::named(name).ok_or_else(|| JobError::Weighting { name: name.clone() })?,
        };
        let (title, populations) = if KINDS.contains(&self.of.as_str()) {
            let sizes = parse_size_distribution("command line", &self.toml())?;
            (self.of.clone(), vec![Population::new(self.of.clone(), sizes, true)])
        } else {
            let set: Result<BTreeMap<_, _>, RecipeError> = self.set.iter().map(|text| parse_setting(text)).collect();
            let material = Recipe::find(&self.of)?.material(&set?)?;
            let populations = material.medium.inclusions().iter().map(|inclusion| {
                let radii = inclusion.shape.form() == mieux_optics::particle::Form::Sphere;
                Population::new(inclusion.name.clone(), inclusion.sizes.clone(), radii)
            });
            (material.title.clone(), populations.collect())
        };
        let mut report = SizesReport { title, weighting, populations, files: Vec::new() };
        if let Some(folder) = &self.output {
            let dir = OutputDir::create(folder)?;
            context.say(Event::Begin(Stage::Write));
            report.files = report.write(&dir)?;
            dir.commit();
            context.say(Event::End(Stage::Write));
        }
        Ok(report)
    }

    /// The distribution as a recipe would have it.
    fn toml(&self) -> String {
        let mut text = format!("kind = {:?}\n", self.of);
        for setting in &self.set {
            let (key, value) = setting.split_once('=').unwrap_or((setting, ""));
            let (key, value) = (key.trim(), value.trim());
            let plain = value.parse::<f64>().is_ok() || value.starts_with(['[', '{', '"', '\'']);
            text += &if plain { format!("{key} = {value}\n") } else { format!("{key} = {value:?}\n") };
        }
        text
    }
}

impl Population {
    fn new(name: String, sizes: SizeDistribution, radii: bool) -> Self {
        let summary = sizes.summary();
        Self { name, sizes, summary, radii }
    }

    /// Radii (um), densities by number, surface and volume (1/um), and the share below in a weighting; empty where all
    /// particles have one size.
    ///
    /// # Errors
    /// [`JobError::Particle`] where there are infinitely many vanishingly small particles.
    pub fn table(&self, weighting: Weighting) -> Result<Table, JobError> {
        let radii = self.radii_m(weighting)?;
        let microns: Vec<f64> = radii.iter().map(|r| r * 1e6).collect();
        let name = if self.radii { "radius" } else { "length" };
        let mut table = Table::new(self.name.clone()).with_column(name, "um", microns)?;
        for w in [Weighting::Number, Weighting::Surface, Weighting::Volume] {
            let Ok(densities) = self.sizes.densities(w, &radii) else { continue };
            let densities = densities.into_iter().map(|d| d * 1e-6).collect();
            table = table.with_column(format!("{w}_density"), "per_um", densities)?;
        }
        let below: Result<Vec<f64>, _> = radii.iter().map(|r| self.sizes.share_below(weighting, *r)).collect();
        Ok(table.with_column(format!("{weighting}_below"), "", below?)?)
    }

    /// Evenly over the logarithm, from the first to the last thousandth, whatever is counted.
    fn radii_m(&self, weighting: Weighting) -> Result<Vec<f64>, JobError> {
        let first = self.sizes.quantile(Weighting::Number, 1e-3).or_else(|_| self.sizes.quantile(weighting, 1e-3))?;
        let last = self.sizes.quantile(Weighting::Volume, 0.999)?;
        if last <= first * (1.0 + 1e-9) {
            return Ok(vec![last]);
        }
        Ok((0..=ROWS).map(|i| first * (last / first).powf(f64::from(i) / f64::from(ROWS))).collect())
    }

    fn panel(&self, weighting: Weighting) -> Result<Panel, JobError> {
        let radii = self.radii_m(weighting)?;
        let label = if self.radii { "Radius (µm)" } else { "Length (µm)" };
        let mut panel =
            Panel::new(self.name.clone(), label, "Density over ln r").with_scales(Scale::Log, Scale::Linear);
        for w in [Weighting::Number, Weighting::Surface, Weighting::Volume] {
            let Ok(densities) = self.sizes.densities(w, &radii) else { continue };
            let points = radii.iter().zip(densities).map(|(r, d)| (r * 1e6, d * r));
            panel = panel.with_series(Series::new(format!("by {w}"), points));
        }
        Ok(panel)
    }

    fn json(&self) -> serde_json::Value {
        let weighted = |w: &WeightedSummary| {
            json!({
                "weighting": w.weighting.name(), "mean_m": w.mean, "deviation_m": w.deviation,
                "quantile_10_50_90_m": w.quantiles, "mode_m": w.mode,
            })
        };
        let s = &self.summary;
        json!({
            "name": self.name,
            "weighted": s.weighted.iter().map(weighted).collect::<Vec<_>>(),
            "effective_radius_m": s.effective_radius,
            "effective_variance": s.effective_variance,
            "mean_volume_m3": s.mean_volume,
            "specific_surface_per_m": s.specific_surface,
            "z_average_radius_m": s.z_average,
        })
    }
}

impl SizesReport {
    /// As JSON: every distribution with its numbers, SI; null where there is no such number.
    pub fn json(&self) -> serde_json::Value {
        json!({ "title": self.title, "populations": self.populations.iter().map(Population::json).collect::<Vec<_>>() })
    }

    /// `sizes.csv` (or `sizes-1.csv` and so on), `sizes.json`, and `sizes.svg` where there is something to draw.
    fn write(&self, dir: &OutputDir) -> Result<Vec<PathBuf>, JobError> {
        let mut files = Vec::new();
        let one = self.populations.len() == 1;
        let mut figure = Figure::new(format!("Sizes: {}", self.title), self.populations.len().clamp(1, 2));
        let mut drawn = false;
        for (i, population) in self.populations.iter().enumerate() {
            let name = if one { "sizes.csv".to_owned() } else { format!("sizes-{}.csv", i + 1) };
            let table = population.table(self.weighting)?;
            files.push(dir.write(&name, |out| table.write_csv(out))?);
            if table.rows() > 1 {
                figure = figure.with_panel(population.panel(self.weighting)?);
                drawn = true;
            }
        }
        let json = self.json();
        files.push(dir.write("sizes.json", |out| Ok(serde_json::to_writer_pretty(out, &json)?))?);
        if drawn {
            let svg = figure.to_svg()?;
            files.push(dir.write("sizes.svg", |out| out.write_all(svg.as_bytes()))?);
        }
        Ok(files)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_become_a_recipe() {
        let mut job = Sizes::new("log-normal");
        job.set = ["median=1 um", "geometric_deviation=1.5", "weighting=number"].map(String::from).to_vec();
        let sizes = parse_size_distribution("command line", &job.toml()).unwrap();
        assert!((sizes.quantile(Weighting::Number, 0.5).unwrap() / 1e-6 - 1.0).abs() < 1e-6);
        job.set.push("=3".into());
        assert!(parse_size_distribution("command line", &job.toml()).is_err());
    }

    #[test]
    fn every_kind_is_known() {
        for kind in KINDS {
            let error = parse_size_distribution("x", &format!("kind = {kind:?}\n")).unwrap_err().to_string();
            assert!(!error.contains("no size distribution of the kind"), "{kind}: {error}");
        }
    }
}
