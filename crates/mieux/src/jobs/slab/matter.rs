//! What layers are made of, as the solvers need it: albedo, moments and, for photons, phase functions.

use std::f64::consts::PI;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use mieux_io::recipe::Material;
use mieux_io::slab_file::phase::{self, PhaseChoice, PhaseTable};
use mieux_optics::medium::MediumError;
use mieux_optics::phase::{HenyeyGreenstein, Isotropic, PhaseFunction, Rayleigh, Tabulated};
use mieux_optics::spectrum::WavelengthGrid;
use mieux_optics::transfer::{Layer, Moments};
use rayon::prelude::*;

use super::super::{Context, JobError, Stage};
use super::SlabError;

/// Least relative tolerance of tables over angle: the error of `1 - g`, half of it, stays below that of counting millions
/// of photons.
const TABLE: f64 = 1e-3;

/// What the solvers of this run ask of phase functions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted {
    /// The highest Legendre moment.
    pub degree: usize,
    /// Whether photons will be scattered.
    pub functions: bool,
    /// Relative tolerance of the integral over particle sizes.
    pub tolerance: f64,
}

/// How light is scattered.
#[derive(Debug, Clone)]
pub(super) struct Scattering {
    pub moments: Moments,
    /// Where photons were asked for.
    pub function: Option<PhaseFunction>,
}

impl Scattering {
    /// Also says what was done to a table, if it was one.
    pub fn chosen(choice: &PhaseChoice, wanted: Wanted) -> Result<(Self, Option<String>), JobError> {
        let plain = |function: PhaseFunction, moments: Moments| {
            (Self { moments, function: wanted.functions.then_some(function) }, None)
        };
        Ok(match choice {
            PhaseChoice::Hg { g } => plain(HenyeyGreenstein::new(*g)?.into(), Moments::henyey_greenstein(*g)?),
            PhaseChoice::Isotropic => plain(Isotropic.into(), Moments::isotropic()),
            PhaseChoice::Rayleigh => plain(Rayleigh.into(), Moments::of(&Rayleigh.into(), 3)?),
            PhaseChoice::File(path) => {
                let (scattering, note) = tabulated(path, wanted)?;
                (scattering, Some(note))
            }
        })
    }
}

/// The phase function of a file, and what was done to it.
fn tabulated(path: &Path, wanted: Wanted) -> Result<(Scattering, String), JobError> {
    let name = path.display();
    match phase::read(path)? {
        PhaseTable::Angles { degrees, values } => {
            let angles: Vec<f64> =
                degrees.iter().map(|angle| if *angle == 180.0 { PI } else { angle.to_radians() }).collect();
            let (rows, largest) = (values.len(), values.iter().copied().fold(0.0, f64::max));
            let place = values.iter().position(|value| *value == largest).unwrap_or(0);
            let function: PhaseFunction = Tabulated::new(angles, values)?.into();
            let integral = largest / function.value(degrees[place].to_radians().cos());
            let note = format!(
                "{name}: {rows} angles, divided by their integral over the sphere, {integral:.6}; g = {:.6}",
                function.asymmetry()
            );
            let moments = Moments::of(&function, wanted.degree + 1)?;
            Ok((Scattering { moments, function: wanted.functions.then_some(function) }, note))
        }
        PhaseTable::Moments { moments, first } => {
            let divided = if first == 1.0 { String::new() } else { format!(", divided by the first, {first}") };
            let moments = Moments::new(moments)?;
            let note = format!(
                "{name}: {} Legendre moments{divided}; g = {:.6}",
                moments.as_slice().len(),
                moments.asymmetry()
            );
            let function = if wanted.functions { Some(from_moments(&moments)?) } else { None };
            Ok((Scattering { moments, function }, note))
        }
    }
}

/// A table over angle of the sum of Legendre polynomials, fine enough for the highest of them.
fn from_moments(moments: &Moments) -> Result<PhaseFunction, JobError> {
    let list = moments.as_slice();
    let steps = (64 * list.len()).clamp(720, 1 << 16);
    let angles: Vec<f64> = (0..=steps).map(|i| PI * i as f64 / steps as f64).collect();
    let value = |angle: &f64| {
        let mu = angle.cos();
        let (mut before, mut here, mut sum) = (0.0, 1.0, 0.0);
        for (degree, moment) in list.iter().enumerate() {
            let l = degree as f64;
            sum += (2.0 * l + 1.0) * moment * here;
            (before, here) = (here, ((2.0 * l + 1.0) * mu * here - l * before) / (l + 1.0));
        }
        sum
    };
    let values: Vec<f64> = angles.par_iter().map(value).collect();
    let largest = values.iter().copied().fold(0.0, f64::max);
    // What rounding leaves of a zero is not negative.
    if let Some(i) = values.iter().position(|value| *value < -1e-12 * largest) {
        return Err(SlabError::NegativePhase { angle_deg: angles[i].to_degrees() }.into());
    }
    Ok(Tabulated::new(angles, values.into_iter().map(|value| value.max(0.0)).collect())?.into())
}

/// A material at each wavelength.
#[derive(Debug, Clone)]
pub(super) struct SpectralMatter {
    pub sigma_s: Vec<f64>,
    pub sigma_a: Vec<f64>,
    /// Of the host.
    pub index: Vec<f64>,
    pub scattering: Vec<Scattering>,
}

/// Counts wavelengths of all materials together.
pub(super) struct Count {
    /// What is being counted.
    pub stage: Stage,
    pub done: AtomicU64,
    pub total: u64,
}

impl SpectralMatter {
    /// Extinction coefficient at a wavelength of the grid, 1/m.
    pub fn extinction(&self, at: usize) -> f64 {
        self.sigma_s[at] + self.sigma_a[at]
    }

    /// A layer of it at a wavelength of the grid, with the host's refractive index.
    pub fn layer(&self, at: usize, optical_thickness: f64) -> Layer {
        let extinction = self.extinction(at);
        let albedo = if extinction > 0.0 { self.sigma_s[at] / extinction } else { 0.0 };
        let moments = if albedo > 0.0 { self.scattering[at].moments.clone() } else { Moments::isotropic() };
        Layer::new(optical_thickness, albedo, moments).with_index(self.index[at])
    }

    pub fn compute(
        material: &Material,
        grid: &WavelengthGrid,
        wanted: Wanted,
        count: &Count,
        context: &Context<'_>,
    ) -> Result<Self, JobError> {
        let failed = |source| JobError::Medium { material: material.name.clone(), source };
        let at: Result<Vec<_>, JobError> = grid
            .as_slice()
            .par_iter()
            .map(|&wavelength| {
                if context.is_cancelled() {
                    return Err(JobError::Cancelled);
                }
                let medium = &material.medium;
                let scattering = medium.scattering_at(wavelength, wanted.tolerance).map_err(failed)?;
                let index = medium.host().index(wavelength).map_err(|e| failed(MediumError::from(e)))?.re;
                let moments = Moments::new(scattering.legendre_moments(wanted.degree).map_err(failed)?)?;
                let function = match wanted.functions {
                    true => Some(scattering.phase_function(wanted.tolerance.max(TABLE)).map_err(failed)?),
                    false => None,
                };
                context.count(count.stage, count.done.fetch_add(1, Ordering::Relaxed) + 1, count.total);
                Ok((*scattering.optics(), index, Scattering { moments, function }))
            })
            .collect();
        let mut matter = Self { sigma_s: vec![], sigma_a: vec![], index: vec![], scattering: vec![] };
        for (optics, index, scattering) in at? {
            matter.sigma_s.push(optics.sigma_s);
            matter.sigma_a.push(optics.sigma_a);
            matter.index.push(index);
            matter.scattering.push(scattering);
        }
        Ok(matter)
    }
}
