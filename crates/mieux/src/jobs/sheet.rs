//! The optical properties of one material, as they are shown, tabulated, plotted and rendered.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};

use mieux_io::output::OutputDir;
use mieux_io::plot::{OpticsPlot, optics_svg};
use mieux_io::recipe::Material;
use mieux_io::table::Table;
use mieux_optics::medium::{BulkOptics, Medium};
use mieux_optics::spectrum::WavelengthGrid;
use rayon::prelude::*;
use serde_json::json;

use super::{Context, Event, JobError, Stage};

/// One substance in a material, and how much of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Made {
    /// What it is.
    pub what: String,
    /// Volume per volume of the material.
    pub volume_fraction: f64,
}

/// A material and its optical properties on a grid of wavelengths.
#[derive(Debug, Clone, PartialEq)]
pub struct OpticsSheet {
    /// The material.
    pub material: Material,
    /// Its properties.
    pub bulk: BulkOptics,
    /// Relative tolerance that was asked of the integral over sizes.
    pub tolerance: f64,
}

impl OpticsSheet {
    /// Computes the properties wavelength by wavelength, reporting progress.
    ///
    /// # Errors
    /// [`JobError::Medium`], or [`JobError::Cancelled`].
    pub(super) fn compute(
        material: Material,
        grid: &WavelengthGrid,
        tolerance: f64,
        context: &Context<'_>,
    ) -> Result<Self, JobError> {
        context.say(Event::Begin(Stage::Optics));
        let (total, done) = (grid.len() as u64, AtomicU64::new(0));
        let at: Result<Vec<_>, JobError> = grid
            .as_slice()
            .par_iter()
            .map(|&wavelength| {
                if context.is_cancelled() {
                    return Err(JobError::Cancelled);
                }
                let at = material.medium.optics_at(wavelength, tolerance);
                context.count(Stage::Optics, done.fetch_add(1, Ordering::Relaxed) + 1, total);
                at.map_err(|source| JobError::Medium { material: material.name.clone(), source })
            })
            .collect();
        context.say(Event::End(Stage::Optics));
        let bulk = BulkOptics::new(grid.clone(), &at?)?;
        Ok(Self { material, bulk, tolerance })
    }

    /// What the material is made of, the host first.
    pub fn made_of(&self) -> Vec<Made> {
        made_of(&self.material.medium)
    }

    /// The properties at the wavelength nearest to the one given (m): wavelength (m), reduced scattering (1/m),
    /// absorption (1/m), asymmetry, extinction (1/m).
    pub fn nearest(&self, wavelength_m: f64) -> [f64; 5] {
        let wavelengths = self.bulk.grid().as_slice();
        let distance = |i: &usize| (wavelengths[*i] - wavelength_m).abs();
        let i = (0..wavelengths.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0);
        let (s, a, g) = (self.bulk.sigma_s()[i], self.bulk.sigma_a()[i], self.bulk.asymmetry()[i]);
        [wavelengths[i], s * (1.0 - g), a, g, s + a]
    }

    /// What makes the properties doubtful, in words: particles too near to each other to scatter independently.
    pub fn warnings(&self) -> Vec<String> {
        let longest = self.bulk.grid().range().1;
        let mut warnings: Vec<String> = self.material.medium.doubts(longest).iter().map(ToString::to_string).collect();
        let error = self.bulk.relative_error();
        for (what, error) in [("scattering", error.scattering), ("reduced scattering", error.reduced)] {
            if error > 2.0 * self.tolerance {
                let tolerance = self.tolerance;
                warnings.push(format!(
                    "{what} is known to {error:.1e} where {tolerance:.0e} was asked: spheres of thousands of wavelengths resonate \
                     too finely"
                ));
            }
        }
        warnings
    }

    /// As a table, with units in the column names and what was computed in its head.
    ///
    /// # Errors
    /// Never for a sheet that was computed; the table checks the lengths of its columns.
    pub fn table(&self) -> Result<Table, JobError> {
        let b = &self.bulk;
        let mut table = Table::new(self.material.title.clone()).with_metadata("material", self.material.name.clone());
        for (input, value) in &self.material.inputs {
            table = table.with_metadata(&*input.name, input.shown(*value));
        }
        let error = b.relative_error();
        for (what, error) in
            [("scattering", error.scattering), ("reduced scattering", error.reduced), ("absorption", error.absorption)]
        {
            table =
                table.with_metadata(format!("relative error of {what} by the size integral"), format!("{error:.1e}"));
        }
        for warning in self.warnings() {
            table = table.with_metadata("warning", warning);
        }
        let columns = [
            ("wavelength", "nm", self.nanometres()),
            ("sigma_s", "per_m", b.sigma_s().to_vec()),
            ("sigma_a", "per_m", b.sigma_a().to_vec()),
            ("sigma_t", "per_m", b.sigma_t()),
            ("reduced_scattering", "per_m", b.reduced_scattering()),
            ("g", "", b.asymmetry().to_vec()),
            ("n_real", "", b.n_real().to_vec()),
            ("n_imag", "", b.n_imag()),
        ];
        for (name, unit, values) in columns {
            table = table.with_column(name, unit, values)?;
        }
        Ok(table)
    }

    /// As JSON: arrays of one length.
    pub fn json(&self) -> serde_json::Value {
        let b = &self.bulk;
        let inputs: BTreeMap<&str, f64> = self.material.inputs.iter().map(|(i, v)| (&*i.name, *v)).collect();
        json!({
            "material": self.material.name,
            "inputs": inputs,
            "wavelength_nm": self.nanometres(),
            "sigma_s_per_m": b.sigma_s(),
            "sigma_a_per_m": b.sigma_a(),
            "sigma_t_per_m": b.sigma_t(),
            "g": b.asymmetry(),
            "n_real": b.n_real(),
            "n_imag": b.n_imag(),
            "relative_error": {
                "sigma_s": b.relative_error().scattering,
                "reduced_scattering": b.relative_error().reduced,
                "sigma_a": b.relative_error().absorption,
            },
            "warnings": self.warnings(),
        })
    }

    /// The figure, as SVG.
    ///
    /// # Errors
    /// [`JobError::Plot`].
    pub fn svg(&self) -> Result<String, JobError> {
        let b = &self.bulk;
        let reduced = b.reduced_scattering();
        let plot = OpticsPlot {
            sigma_s: b.sigma_s(),
            reduced_scattering: &reduced,
            sigma_a: b.sigma_a(),
            asymmetry: b.asymmetry(),
            refractive_index: Some(b.n_real()),
        };
        Ok(optics_svg(&self.material.title, &self.nanometres(), &plot)?)
    }

    /// Writes `STEM.csv` and `STEM.svg`.
    pub(super) fn write(&self, dir: &OutputDir, stem: &str) -> Result<Vec<PathBuf>, JobError> {
        let (table, svg) = (self.table()?, self.svg()?);
        Ok(vec![
            dir.write(&format!("{stem}.csv"), |out| table.write_csv(out))?,
            dir.write(&format!("{stem}.svg"), |out| out.write_all(svg.as_bytes()))?,
        ])
    }

    /// The wavelengths in nanometres, a round number staying round.
    fn nanometres(&self) -> Vec<f64> {
        self.bulk.grid().iter().map(|w| (w * 1e9 * 1e6).round() / 1e6).collect()
    }
}

/// What a medium is made of, the host first.
pub fn made_of(medium: &Medium) -> Vec<Made> {
    let occupied: f64 = medium.inclusions().iter().map(|i| i.volume_fraction).sum();
    let host = medium.host().describe();
    let inclusions = medium.inclusions().iter();
    std::iter::once(Made { what: host, volume_fraction: 1.0 - occupied })
        .chain(inclusions.map(|i| Made { what: i.name.clone(), volume_fraction: i.volume_fraction }))
        .collect()
}
