//! What was written, as it is shown.

use std::path::PathBuf;

use mieux_io::export::{Errors, Format, Subject, Written};
use mieux_io::table::Table;
use serde_json::{Value, json};

use super::JobError;

/// A material in a format, and what the format has lost.
#[derive(Debug, Clone, PartialEq)]
pub struct ExportSheet {
    /// The format.
    pub format: Format,
    /// What is known of the material.
    pub subject: Subject,
    /// What was written of it.
    pub written: Written,
}

/// What [`Export`](super::Export) leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct ExportReport {
    /// The material, what was written of it and what was lost.
    pub sheet: ExportSheet,
    /// The files written.
    pub files: Vec<PathBuf>,
}

impl ExportSheet {
    /// What is known beside what a reader of the files gets back, wavelength by wavelength; nothing where no channel of
    /// colour sees.
    ///
    /// # Errors
    /// Never; the table checks the lengths of its columns.
    pub fn table(&self) -> Result<Table, JobError> {
        let (subject, held) = (&self.subject, &self.written.held);
        let reduced: Vec<f64> = held.sigma_s.iter().zip(&held.asymmetry).map(|(s, g)| s * (1.0 - g)).collect();
        let mut table = Table::new(format!("{} for {}", subject.title, self.format.name()))
            .with_metadata("form", self.written.form.clone());
        for line in self.written.loss.lines() {
            if let Some((what, how)) = line.split_once(": ") {
                table = table.with_metadata(what.to_owned(), how.to_owned());
            }
        }
        let columns = [
            ("wavelength", "nm", subject.grid.iter().map(|w| (w * 1e9 * 1e6).round() / 1e6).collect()),
            ("reduced_scattering", "per_m", subject.reduced()),
            ("held_reduced_scattering", "per_m", reduced),
            ("sigma_s", "per_m", subject.sigma_s.clone()),
            ("held_sigma_s", "per_m", held.sigma_s.clone()),
            ("sigma_a", "per_m", subject.sigma_a.clone()),
            ("held_sigma_a", "per_m", held.sigma_a.clone()),
            ("g", "", subject.asymmetry.clone()),
            ("held_g", "", held.asymmetry.clone()),
        ];
        for (name, unit, values) in columns {
            table = table.with_column(name, unit, values)?;
        }
        Ok(table)
    }

    /// As JSON; `null` stands where no channel of colour sees a wavelength.
    pub fn json(&self, files: &[PathBuf]) -> Value {
        let (subject, written) = (&self.subject, &self.written);
        let errors = |e: Errors| json!({ "largest": e.largest, "rms": e.rms });
        let numbers = |values: &[f64]| -> Vec<Option<f64>> {
            values.iter().map(|v| if v.is_nan() { None } else { Some(*v) }).collect()
        };
        json!({
            "material": subject.name,
            "format": self.format.name(),
            "files": files.iter().map(|f| f.display().to_string()).collect::<Vec<_>>(),
            "metres_per_unit": subject.metres_per_unit,
            "form": written.form,
            "wavelength_nm": subject.grid.iter().map(|w| (w * 1e9 * 1e6).round() / 1e6).collect::<Vec<f64>>(),
            "sigma_s_per_m": subject.sigma_s,
            "sigma_a_per_m": subject.sigma_a,
            "g": subject.asymmetry,
            "n": subject.refractive_index,
            "held_sigma_s_per_m": numbers(&written.held.sigma_s),
            "held_sigma_a_per_m": numbers(&written.held.sigma_a),
            "held_g": numbers(&written.held.asymmetry),
            "relative_error_of_reduced_scattering": errors(written.loss.reduced),
            "relative_error_of_sigma_s": errors(written.loss.sigma_s),
            "relative_error_of_sigma_a": errors(written.loss.sigma_a),
            "error_of_g": errors(written.loss.asymmetry),
            "wavelengths_in_no_channel": written.loss.unseen,
            "phase_function": {
                "form": written.phase.form,
                "total_variation": written.phase.total_variation,
                "relative_error_of_one_minus_g": written.phase.one_minus_asymmetry,
            },
            "remarks": written.remarks,
        })
    }
}
