//! The job behind `mieux invert`: from what slabs reflect and transmit to what they are made of.

mod sheet;

use std::path::{Path, PathBuf};

use mieux_io::output::OutputDir;
use mieux_io::quantity::Length;
use mieux_io::rxt::{Rxt, RxtRow};
use mieux_optics::transfer::inverse::{Estimate, InverseError, Inversion, Measured, Sample};
use serde::{Deserialize, Serialize};

use super::{Context, Event, JobError, Stage};
pub use sheet::{InvertSheet, Inverted};

/// Measured slabs to be inverted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Invert {
    /// What was measured.
    pub measured: Slabs,
    /// Refractive index of the sample; that of the file, or 1, when left out.
    #[serde(default)]
    pub refractive_index: Option<f64>,
    /// Refractive index of slides above and below; that of the file, or none, when left out.
    #[serde(default)]
    pub slide_index: Option<f64>,
    /// The asymmetry where it cannot be found; that of the file, or 0, when left out.
    #[serde(default)]
    pub asymmetry: Option<f64>,
    /// Thickness of the sample; that of the file, or 1 mm, when left out.
    #[serde(default)]
    pub thickness: Option<Length>,
    /// The optical thickness where it cannot be found; that of the file, or none, when left out.
    #[serde(default)]
    pub optical_thickness: Option<f64>,
    /// Standard error of total reflectance and transmittance, as shares.
    #[serde(default = "default_error")]
    pub error: f64,
    /// Standard error of the unscattered transmittance, as a part of it.
    #[serde(default = "default_unscattered_error")]
    pub unscattered_error: f64,
    /// Streams followed in both hemispheres.
    #[serde(default = "default_streams")]
    pub streams: usize,
    /// Whether measurements with integrating spheres count as corrected for these already.
    #[serde(default)]
    pub corrected: bool,
    /// Folder for table and plot; nothing is written when left out.
    #[serde(default)]
    pub output: Option<PathBuf>,
}

fn default_error() -> f64 {
    Invert::DEFAULT_ERROR
}

fn default_unscattered_error() -> f64 {
    Invert::DEFAULT_UNSCATTERED_ERROR
}

fn default_streams() -> usize {
    Invert::DEFAULT_STREAMS
}

/// Where measurements come from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Slabs {
    /// An `.rxt` file.
    File(PathBuf),
    /// One slab: shares of the light that falls along its normal.
    One {
        /// Total reflectance.
        #[serde(default)]
        reflectance: Option<f64>,
        /// Total transmittance.
        #[serde(default)]
        transmittance: Option<f64>,
        /// Unscattered transmittance.
        #[serde(default)]
        unscattered: Option<f64>,
    },
}

impl Invert {
    /// Standard error of total shares unless another is given.
    pub const DEFAULT_ERROR: f64 = 0.002;
    /// Relative standard error of the unscattered share unless another is given.
    pub const DEFAULT_UNSCATTERED_ERROR: f64 = 0.05;
    /// Streams unless another number is given.
    pub const DEFAULT_STREAMS: usize = 32;

    /// With everything else as the measurements say.
    pub fn new(measured: Slabs) -> Self {
        Self {
            measured,
            refractive_index: None,
            slide_index: None,
            asymmetry: None,
            thickness: None,
            optical_thickness: None,
            error: Self::DEFAULT_ERROR,
            unscattered_error: Self::DEFAULT_UNSCATTERED_ERROR,
            streams: Self::DEFAULT_STREAMS,
            corrected: false,
            output: None,
        }
    }

    fn check(&self) -> Result<(), JobError> {
        let named = [("error", self.error), ("unscattered_error", self.unscattered_error)];
        for (name, value) in named {
            if !(value >= 0.0 && value.is_finite()) {
                let allowed = "a standard error is 0 or more and finite";
                return Err(JobError::Value { name, value: value.to_string(), allowed });
            }
        }
        Ok(())
    }

    fn rows(&self) -> Result<(String, Vec<RxtRow>), JobError> {
        match &self.measured {
            Slabs::File(path) => {
                let file = Rxt::read(path)?;
                if file.spheres > 0 && !self.corrected {
                    return Err(JobError::Spheres { path: path.clone(), spheres: file.spheres });
                }
                Ok((name(path), file.rows))
            }
            Slabs::One { reflectance, transmittance, unscattered } => {
                let row = RxtRow {
                    line: 0,
                    wavelength: None,
                    reflectance: *reflectance,
                    transmittance: *transmittance,
                    unscattered: *unscattered,
                    refractive_index: 1.0,
                    slide_index: 1.0,
                    thickness: 1e-3,
                    asymmetry: None,
                    optical_thickness: None,
                    specular_in_reflectance: 1.0,
                    unscattered_in_transmittance: 1.0,
                };
                Ok(("One slab".to_owned(), vec![row]))
            }
        }
    }

    fn sample(&self, row: &RxtRow) -> Sample {
        Sample {
            refractive_index: self.refractive_index.unwrap_or(row.refractive_index),
            slide_index: self.slide_index.unwrap_or(row.slide_index),
            asymmetry: self.asymmetry.or(row.asymmetry).unwrap_or(0.0),
            optical_thickness: self.optical_thickness.or(row.optical_thickness),
            specular_in_reflectance: row.specular_in_reflectance,
            unscattered_in_transmittance: row.unscattered_in_transmittance,
        }
    }

    fn compute(&self, context: &Context<'_>) -> Result<InvertSheet, JobError> {
        self.check()?;
        let (title, rows) = self.rows()?;
        context.say(Event::Begin(Stage::Optics));
        let mut inverted = Vec::with_capacity(rows.len());
        let mut ready: Option<(Sample, Inversion)> = None;
        for (i, row) in rows.iter().enumerate() {
            if context.is_cancelled() {
                return Err(JobError::Cancelled);
            }
            let sample = self.sample(row);
            let thickness = self.thickness.map_or(row.thickness, Length::metres);
            if !(thickness > 0.0 && thickness.is_finite()) {
                let allowed = "a sample is thicker than 0";
                return Err(JobError::Value { name: "thickness", value: format!("{} mm", thickness * 1e3), allowed });
            }
            let known = ready.take().filter(|(known, _)| *known == sample);
            let (_, inversion) = ready.insert(match known {
                Some(known) => known,
                None => (sample, Inversion::new(sample, self.streams)?),
            });
            let outcome = match inversion.invert(&self.measured(row)) {
                Ok(found) => Ok(found),
                // What cannot be of a whole file says so once; of one row, in its place.
                Err(error @ InverseError::Transfer(_)) => return Err(error.into()),
                Err(error) if rows.len() == 1 => return Err(error.into()),
                Err(error) => Err(error),
            };
            inverted.push(Inverted { row: row.clone(), sample, thickness, outcome });
            context.count(Stage::Optics, i as u64 + 1, rows.len() as u64);
        }
        context.say(Event::End(Stage::Optics));
        Ok(InvertSheet { title, error: self.error, unscattered_error: self.unscattered_error, rows: inverted })
    }

    fn measured(&self, row: &RxtRow) -> Measured {
        let total = |value: Option<f64>| value.map(|value| Estimate { value, error: self.error });
        Measured {
            reflectance: total(row.reflectance),
            transmittance: total(row.transmittance),
            unscattered: row.unscattered.map(|value| Estimate { value, error: (self.unscattered_error * value).abs() }),
        }
    }

    pub(super) fn run(&self, context: &Context<'_>) -> Result<InvertReport, JobError> {
        let dir = self.output.as_deref().map(OutputDir::create).transpose()?;
        let sheet = self.compute(context)?;
        let mut files = Vec::new();
        if let Some(dir) = dir {
            context.say(Event::Begin(Stage::Write));
            let (table, json) = (sheet.table()?, sheet.json());
            files.push(dir.write("inversion.csv", |out| table.write_csv(out))?);
            files.push(dir.write("inversion.json", |out| Ok(serde_json::to_writer_pretty(out, &json)?))?);
            if let Some(svg) = sheet.svg()? {
                files.push(dir.write("inversion.svg", |out| out.write_all(svg.as_bytes()))?);
            }
            dir.commit();
            context.say(Event::End(Stage::Write));
        }
        Ok(InvertReport { sheet, files })
    }
}

/// What a file is called in a heading.
fn name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// What [`Invert`] leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct InvertReport {
    /// The slabs.
    pub sheet: InvertSheet,
    /// The files written.
    pub files: Vec<PathBuf>,
}

#[cfg(test)]
mod tests {
    use super::super::Job;
    use super::*;

    #[test]
    fn is_written_down_and_read_back() {
        let text =
            r#"{"job": "invert", "measured": {"one": {"reflectance": 0.4}}, "thickness": "2 mm", "asymmetry": 0.9}"#;
        let job: Job = serde_json::from_str(text).unwrap();
        let Job::Invert(invert) = &job else { panic!("{job:?}") };
        assert_eq!(invert.measured, Slabs::One { reflectance: Some(0.4), transmittance: None, unscattered: None });
        assert_eq!((invert.streams, invert.error), (Invert::DEFAULT_STREAMS, Invert::DEFAULT_ERROR));
        let again: Job = serde_json::from_str(&serde_json::to_string(&job).unwrap()).unwrap();
        assert_eq!(job, again);
        assert!(serde_json::from_str::<Job>(&text.replace("asymmetry", "asymetry")).is_err());
    }
}
