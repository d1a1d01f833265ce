//! The job behind `mieux mie --batch`: a table of spheres, however long.

use std::f64::consts::PI;
use std::io;
use std::path::PathBuf;
use std::time::Instant;

use mieux_io::output::{WriteSeek, write_atomic};
use mieux_io::rows::{ByteRecord, Columns, RowReader, Rows, RowsError, append_fields, append_numbers};
use mieux_optics::Complex64;
use mieux_optics::mie::{MieError, PlaneWave, ScatteringDefinition, Sphere, SphereScattering, scatter_spheres};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{Context, Definition, Event, JobError, Stage};

/// Rows in memory at a time; twice as many, as the next are read while these are computed.
const BLOCK: usize = 1 << 16;

/// Rows that one thread computes at a time. Spheres are computed several abreast, neighbours in size together, so it is
/// this number and not that of the threads that decides over the last bits.
const SLICE: usize = 1 << 12;

/// A table of homogeneous spheres, a row each: columns added, everything else carried through.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MieBatch {
    /// Comma-separated values with the columns [`MieBatch::COLUMNS`], in any order and among any others.
    pub input: PathBuf,
    /// The same rows, with the columns [`MieBatch::RESULTS`] added.
    pub output: PathBuf,
    /// What scattering means where the host absorbs.
    #[serde(default)]
    pub definition: Definition,
    /// Threads; all cores when left out. Does not change the result.
    #[serde(default)]
    pub threads: Option<usize>,
}

/// What [`MieBatch`] leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct MieBatchReport {
    /// How many spheres were computed.
    pub rows: u64,
    /// How long it took, s.
    pub seconds: f64,
    /// The table.
    pub output: PathBuf,
}

impl MieBatch {
    /// The columns that a table must have; wavelengths are in vacuum.
    pub const COLUMNS: [&str; 6] = ["radius_um", "wavelength_um", "host_re", "host_im", "particle_re", "particle_im"];

    /// The columns that are added.
    pub const RESULTS: [&str; 7] = ["c_ext_m2", "c_sca_m2", "c_abs_m2", "q_ext", "q_sca", "q_abs", "g"];

    /// A table with everything left to its default.
    pub fn new(input: impl Into<PathBuf>, output: impl Into<PathBuf>) -> Self {
        Self { input: input.into(), output: output.into(), definition: Definition::default(), threads: None }
    }

    pub(in crate::jobs) fn run(&self, context: &Context<'_>) -> Result<MieBatchReport, JobError> {
        let start = Instant::now();
        let reader = RowReader::open(&self.input, &Self::COLUMNS, &Self::RESULTS)?;
        let threads = self.threads.unwrap_or(0);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|e| JobError::Threads { threads, reason: e.to_string() })?;
        context.say(Event::Begin(Stage::Spheres));
        let (mut rows, mut failure) = (0, None);
        let written = write_atomic(&self.output, |out| match self.stream(reader, &pool, out, context) {
            Ok(count) => {
                rows = count;
                Ok(())
            }
            Err(Stopped::Output(error)) => Err(error),
            Err(Stopped::Job(error)) => {
                failure = Some(error);
                Err(io::Error::other("the input is at fault"))
            }
        });
        if let Some(error) = failure {
            return Err(*error);
        }
        written?;
        context.say(Event::End(Stage::Spheres));
        Ok(MieBatchReport { rows, seconds: start.elapsed().as_secs_f64(), output: self.output.clone() })
    }

    /// Reads, computes and writes block by block, the next block being read while one is computed; returns how many rows
    /// there were.
    fn stream(
        &self,
        mut reader: RowReader,
        pool: &rayon::ThreadPool,
        out: &mut dyn WriteSeek,
        context: &Context<'_>,
    ) -> Result<u64, Stopped> {
        let mut line = Vec::new();
        append_fields(&mut line, reader.header());
        for name in Self::RESULTS {
            line.push(b',');
            line.extend_from_slice(name.as_bytes());
        }
        line.push(b'\n');
        out.write_all(&line)?;
        let (columns, size, definition) = (reader.columns().clone(), reader.size(), self.definition.into());
        let (mut rows, mut next) = (Rows::default(), Rows::default());
        let mut slices: Vec<Slice> = Vec::new();
        slices.resize_with(BLOCK.div_ceil(SLICE), Slice::default);
        reader.read(&mut rows, BLOCK)?;
        let mut done = 0;
        while !rows.as_slice().is_empty() {
            if context.is_cancelled() {
                return Err(JobError::Cancelled.into());
            }
            let compute = || {
                let work = slices.par_iter_mut().zip(rows.as_slice().par_chunks(SLICE));
                work.for_each(|(slice, rows)| slice.result = slice.compute(rows, &columns, definition));
            };
            let (read, ()) = pool.install(|| rayon::join(|| reader.read(&mut next, BLOCK), compute));
            for slice in &mut slices[..rows.as_slice().len().div_ceil(SLICE)] {
                std::mem::replace(&mut slice.result, Ok(()))?;
                out.write_all(&slice.text)?;
            }
            // Only now, so that of two mistakes the first is told.
            read?;
            done += rows.as_slice().len() as u64;
            let total = size.map(|size| (done as f64 * size as f64 / rows.end() as f64) as u64);
            let total = total.map(|total| if next.as_slice().is_empty() { done } else { total.max(done) });
            context.say(Event::Progress { stage: Stage::Spheres, done, total, samples_per_pixel: None, noise: None });
            std::mem::swap(&mut rows, &mut next);
        }
        Ok(done)
    }
}

/// Why there are no more rows.
enum Stopped {
    Output(io::Error),
    Job(Box<JobError>),
}

impl From<io::Error> for Stopped {
    fn from(error: io::Error) -> Self {
        Self::Output(error)
    }
}

impl From<JobError> for Stopped {
    fn from(error: JobError) -> Self {
        Self::Job(Box::new(error))
    }
}

impl From<RowsError> for Stopped {
    fn from(error: RowsError) -> Self {
        JobError::from(error).into()
    }
}

/// What one thread computes at a time, with memory that is used again.
struct Slice {
    radii: Vec<f64>,
    spheres: Vec<Sphere>,
    scattering: Vec<SphereScattering>,
    text: Vec<u8>,
    result: Result<(), RowsError>,
}

impl Default for Slice {
    fn default() -> Self {
        Self { radii: Vec::new(), spheres: Vec::new(), scattering: Vec::new(), text: Vec::new(), result: Ok(()) }
    }
}

impl Slice {
    fn compute(
        &mut self,
        rows: &[ByteRecord],
        columns: &Columns,
        definition: ScatteringDefinition,
    ) -> Result<(), RowsError> {
        self.radii.clear();
        self.spheres.clear();
        self.scattering.clear();
        self.text.clear();
        for row in rows {
            let numbers = columns.numbers(row)?;
            let sphere = sphere(&numbers, definition).map_err(|error| blame(row, columns, &error))?;
            // A division by a million is rounded once; a millionth would be rounded twice.
            self.radii.push(numbers[0] / 1e6);
            self.spheres.push(sphere);
        }
        scatter_spheres(&self.spheres, &mut self.scattering)
            .map_err(|error| blame(&rows[error.index], columns, &error.source))?;
        for ((row, radius), s) in rows.iter().zip(&self.radii).zip(&self.scattering) {
            let area = PI * radius * radius;
            append_fields(&mut self.text, row);
            let c = [s.extinction, s.scattering, s.absorption];
            append_numbers(&mut self.text, &[c[0], c[1], c[2], c[0] / area, c[1] / area, c[2] / area, s.asymmetry]);
            self.text.push(b'\n');
        }
        Ok(())
    }
}

/// The sphere of a row, whose numbers come in the order of [`MieBatch::COLUMNS`].
fn sphere(numbers: &[f64; 6], definition: ScatteringDefinition) -> Result<Sphere, MieError> {
    let [radius, wavelength, host_re, host_im, particle_re, particle_im] = *numbers;
    let wave = PlaneWave::new(wavelength / 1e6, Complex64::new(host_re, host_im))?.with_definition(definition);
    Sphere::new(wave, radius / 1e6, Complex64::new(particle_re, particle_im))
}

fn blame(row: &ByteRecord, columns: &Columns, error: &MieError) -> RowsError {
    let (column, problem) = culprit(error);
    columns.error(row, column, problem)
}

/// The column to blame, and what is wrong with its value.
fn culprit(error: &MieError) -> (usize, String) {
    match *error {
        MieError::Length { name: "wavelength", .. } => (1, "is no wavelength: it must be more than 0".into()),
        MieError::Length { .. } => (0, "is no radius: it must be more than 0".into()),
        MieError::Index { name, re, im } => {
            let part = usize::from(re > 0.0 && im < 0.0);
            let problem = ["the real part is more than 0, the modulus 1e-6 to 1e6", "the imaginary part is 0 or more"];
            let column = part + if name == "host" { 2 } else { 4 };
            (column, format!("is no part of a refractive index: {}", problem[part]))
        }
        _ => (0, format!("makes a particle that cannot be computed: {error}")),
    }
}
