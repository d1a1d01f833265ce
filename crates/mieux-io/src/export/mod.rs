//! Materials as other people's renderers take them: one file per format, each by its own rules.
//!
//! A [`Subject`] holds what is known of a material over wavelength. [`write`] makes the files of one [`Format`] of it,
//! and says what the format has lost on the way: [`Loss`] compares what a reader gets back with the spectra that went in.

mod channels;
mod cycles;
mod eradiate;
mod gltf;
mod loss;
mod materialx;
mod mdl;
mod mitsuba;
mod openpbr;
mod pbrt;
#[cfg(test)]
mod testing;
mod text;
mod usd;

use mieux_optics::phase::{PhaseError, PhaseFunction, SpectralPhase};
use mieux_optics::spectrum::{Sampled, WavelengthGrid};
use serde::{Deserialize, Serialize};

use crate::netcdf::NetCdfError;
use crate::quantity::format_length;
use channels::Channels;
pub use loss::{Errors, Held, Loss, PhaseLoss};

/// Vacuum wavelength at which a single refractive index is taken if it is known there, m: the helium d line.
const INDEX_WAVELENGTH: f64 = 587.56e-9;

/// What can be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// Scenes of Mitsuba 3.
    Mitsuba,
    /// Scenes of pbrt-v4.
    Pbrt,
    /// A script for Blender that makes a material for Cycles.
    Cycles,
    /// MaterialX with `anisotropic_vdf`.
    MaterialX,
    /// MaterialX with `open_pbr_surface`.
    OpenPbr,
    /// glTF with the drafts of volume scattering.
    Gltf,
    /// OpenUSD with a MaterialX network.
    Usd,
    /// A module in NVIDIA's Material Definition Language.
    Mdl,
    /// Particle properties for Eradiate (NetCDF).
    Eradiate,
}

impl Format {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Mitsuba,
        Self::Pbrt,
        Self::Cycles,
        Self::MaterialX,
        Self::OpenPbr,
        Self::Gltf,
        Self::Usd,
        Self::Mdl,
        Self::Eradiate,
    ];

    /// As it is typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mitsuba => "mitsuba",
            Self::Pbrt => "pbrt",
            Self::Cycles => "cycles",
            Self::MaterialX => "materialx",
            Self::OpenPbr => "openpbr",
            Self::Gltf => "gltf",
            Self::Usd => "usd",
            Self::Mdl => "mdl",
            Self::Eradiate => "eradiate",
        }
    }

    /// Which phase functions go into it.
    pub fn phases(self) -> PhasesNeeded {
        match self {
            Self::Mitsuba | Self::Cycles => PhasesNeeded::One,
            Self::Eradiate => PhasesNeeded::All,
            _ => PhasesNeeded::None,
        }
    }

    /// Vacuum wavelengths that its renderer samples, m.
    fn range(self) -> (f64, f64) {
        match self {
            Self::Mitsuba | Self::Pbrt => (360e-9, 830e-9),
            _ => (0.0, f64::INFINITY),
        }
    }
}

/// Phase functions that a format needs; the others make do with the mean cosine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PhasesNeeded {
    /// None.
    None,
    /// At one wavelength.
    One,
    /// At every wavelength.
    All,
}

/// Phase functions that are there.
#[derive(Debug, Clone, PartialEq)]
pub enum Phases {
    /// None.
    None,
    /// At one vacuum wavelength, m.
    One {
        /// Where.
        wavelength_m: f64,
        /// The function.
        function: PhaseFunction,
    },
    /// At every wavelength of the grid.
    All(SpectralPhase),
}

/// What stays right where one asymmetry stands for all wavelengths.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kept {
    /// Reduced scattering `sigma_s (1 - g)`, which is what dense media show; `sigma_s` gives way.
    #[default]
    Reduced,
    /// `sigma_s`, which decides what light passes thin media unscattered; reduced scattering gives way.
    Scattering,
}

/// A material over wavelength, and how it is to be written.
#[derive(Debug, Clone, PartialEq)]
pub struct Subject {
    /// Name, from which those of files and nodes are made.
    pub name: String,
    /// What to call it in a heading.
    pub title: String,
    /// Where the numbers come from, in a line.
    pub source: String,
    /// Vacuum wavelengths.
    pub grid: WavelengthGrid,
    /// Scattering coefficient, 1/m.
    pub sigma_s: Vec<f64>,
    /// Absorption coefficient, 1/m.
    pub sigma_a: Vec<f64>,
    /// Mean cosine of scattering.
    pub asymmetry: Vec<f64>,
    /// Real part of the refractive index.
    pub refractive_index: Vec<f64>,
    /// Phase functions, as far as [`Format::phases`] asks for them.
    pub phases: Phases,
    /// Length of a scene unit, m.
    pub metres_per_unit: f64,
    /// What stays right where one asymmetry stands for all wavelengths.
    pub kept: Kept,
    /// Write reduced scattering and isotropic phase functions.
    pub isotropic: bool,
    /// Formats that are drafts may be written.
    pub drafts: bool,
}

/// What was written.
#[derive(Debug, Clone, PartialEq)]
pub struct Written {
    /// Names and bytes of the files, the principal one first.
    pub files: Vec<(String, Vec<u8>)>,
    /// In which form the coefficients are held, with units.
    pub form: String,
    /// What a reader gets back.
    pub held: Held,
    /// How far that is from what is known.
    pub loss: Loss,
    /// What became of the phase function.
    pub phase: PhaseLoss,
    /// What to know besides.
    pub remarks: Vec<String>,
}

/// Why a material cannot be written in a format.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// Nothing to write.
    #[error("{name} scatters nothing at these wavelengths; what is only clear or coloured needs no volume scattering")]
    NoScattering {
        /// Name of the material.
        name: String,
    },
    /// A wavelength that the renderer never looks at.
    #[error(
        "{format} renders between {} and {}, and {} lies outside; give other wavelengths, as in `400nm:700nm:25nm`",
        format_length(*from_m), format_length(*to_m), format_length(*wavelength_m)
    )]
    Wavelength {
        /// The format.
        format: &'static str,
        /// The wavelength, m.
        wavelength_m: f64,
        /// The shortest that would do, m.
        from_m: f64,
        /// The longest, m.
        to_m: f64,
    },
    /// Wavelengths from which no colour can be made.
    #[error(
        "the wavelengths hold {:.0} % of what makes {channel}, too little for a colour; give for example `400nm:700nm:25nm`, or a single one for grey",
        100.0 * share
    )]
    Channel {
        /// Red, green or blue.
        channel: &'static str,
        /// Share of its weight that lies between the first and the last wavelength.
        share: f64,
    },
    /// A draft that was not asked for.
    #[error(
        "volume scattering in glTF is a draft, which few programs read yet; give `--draft` to write it all the same"
    )]
    Draft,
    /// A scale that is none.
    #[error("a scene unit of {metres} m is no length; give metres per unit, as in `--scale 0.01` for centimetres")]
    Scale {
        /// What was given, m.
        metres: f64,
    },
    /// Phase functions that were not given.
    #[error("{format} needs the phase function, which is not there")]
    NoPhase {
        /// The format.
        format: &'static str,
    },
    /// A phase function that resists.
    #[error(transparent)]
    Phase(#[from] PhaseError),
    /// A data set that cannot be written.
    #[error(transparent)]
    NetCdf(#[from] NetCdfError),
}

/// Writes a material in a format; nothing touches the disk yet.
///
/// # Errors
/// [`ExportError`].
pub fn write(format: Format, subject: &Subject) -> Result<Written, ExportError> {
    if !(subject.metres_per_unit > 0.0 && subject.metres_per_unit.is_finite()) {
        return Err(ExportError::Scale { metres: subject.metres_per_unit });
    }
    if !subject.sigma_s.iter().any(|s| *s > 0.0) {
        return Err(ExportError::NoScattering { name: subject.name.clone() });
    }
    let (from_m, to_m) = format.range();
    let slack = 1e-12;
    if let Some(wavelength_m) = subject.grid.iter().find(|w| *w < from_m * (1.0 - slack) || *w > to_m * (1.0 + slack)) {
        return Err(ExportError::Wavelength { format: format.name(), wavelength_m, from_m, to_m });
    }
    match format {
        Format::Mitsuba => mitsuba::write(subject),
        Format::Pbrt => pbrt::write(subject),
        Format::Cycles => cycles::write(subject),
        Format::MaterialX => materialx::write(subject),
        Format::OpenPbr => openpbr::write(subject),
        Format::Gltf => gltf::write(subject),
        Format::Usd => usd::write(subject),
        Format::Mdl => mdl::write(subject),
        Format::Eradiate => eradiate::write(subject),
    }
}

impl Subject {
    /// `sigma_s (1 - g)`, 1/m.
    pub fn reduced(&self) -> Vec<f64> {
        self.sigma_s.iter().zip(&self.asymmetry).map(|(s, g)| s * (1.0 - g)).collect()
    }

    /// The one asymmetry that stands for all wavelengths: the mean, weighted by scattering.
    fn mean_asymmetry(&self) -> f64 {
        if self.isotropic {
            return 0.0;
        }
        let total: f64 = self.sigma_s.iter().sum();
        self.sigma_s.iter().zip(&self.asymmetry).map(|(s, g)| s * g).sum::<f64>() / total
    }

    /// What is averaged or written in place of `sigma_s` where one asymmetry `g` stands for all wavelengths, 1/m.
    fn scattering_for(&self, g: f64) -> Vec<f64> {
        match self.kept {
            Kept::Scattering if !self.isotropic => self.sigma_s.clone(),
            _ => self.reduced().into_iter().map(|s| s / (1.0 - g)).collect(),
        }
    }

    /// A wavelength (m) and the refractive index there: the d line, or the middle of the grid.
    fn index(&self) -> (f64, f64) {
        let grid = self.grid.as_slice();
        let middle = grid.len() / 2;
        let there = (grid[middle], self.refractive_index[middle]);
        let sampled = Sampled::new(self.grid.clone(), self.refractive_index.clone());
        match sampled.ok().and_then(|n| n.at(INDEX_WAVELENGTH)) {
            Some(n) => (INDEX_WAVELENGTH, n),
            None => there,
        }
    }

    /// The one phase function, and its wavelength.
    fn phase(&self, format: Format) -> Result<(f64, &PhaseFunction), ExportError> {
        match &self.phases {
            Phases::One { wavelength_m, function } => Ok((*wavelength_m, function)),
            _ => Err(ExportError::NoPhase { format: format.name() }),
        }
    }

    /// What three channels of colour hold, with the mean asymmetry for all.
    fn channels(&self) -> Result<Colours, ExportError> {
        self.channels_for(text::rounded(self.mean_asymmetry()))
    }

    /// What three channels of colour hold, with one asymmetry `g` for all.
    fn channels_for(&self, g: f64) -> Result<Colours, ExportError> {
        let channels = Channels::new(&self.grid)?;
        let sigma_s = channels.average(&self.grid, &self.scattering_for(g));
        let sigma_a = channels.average(&self.grid, &self.sigma_a);
        Ok(Colours { channels, sigma_s, sigma_a, asymmetry: g })
    }
}

/// Coefficients in 1/m by channel (linear sRGB), and one asymmetry.
struct Colours {
    channels: Channels,
    sigma_s: [f64; 3],
    sigma_a: [f64; 3],
    asymmetry: f64,
}

impl Colours {
    /// What a reader gets back at each wavelength: what its channel holds.
    fn held(&self, sigma_s: [f64; 3], sigma_a: [f64; 3], asymmetry: f64) -> Held {
        let of = |values: [f64; 3]| {
            self.channels.of_wavelengths().iter().map(|c| c.map_or(f64::NAN, |c| values[c])).collect::<Vec<f64>>()
        };
        let (sigma_s, sigma_a) = (of(sigma_s), of(sigma_a));
        let asymmetry = sigma_s.iter().map(|s| if s.is_nan() { f64::NAN } else { asymmetry }).collect();
        Held { sigma_s, sigma_a, asymmetry }
    }

    /// Rounded to what single precision holds.
    fn rounded(&self) -> Held {
        self.held(self.sigma_s.map(text::rounded), self.sigma_a.map(text::rounded), self.asymmetry)
    }
}
