//! The job behind `mieux mie`: light and one particle.

mod batch;
mod definition;
mod figures;
mod particle;
mod sheet;

use std::path::PathBuf;
use std::str::FromStr;

use mieux_io::output::OutputDir;
use mieux_io::quantity::{Angles, Length, QuantityError, RefractiveIndex};
use mieux_optics::mie::PlaneWave;
use serde::{Deserialize, Serialize};

use super::{Context, Event, JobError, Stage};
pub use batch::{MieBatch, MieBatchReport};
pub use definition::Definition;
pub use particle::Particle;
pub use sheet::{Directional, MieSheet};

/// Light and one particle: a sphere, or a sphere with layers around it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mie {
    /// Radius of the sphere, or of the core when there are layers.
    pub radius: Length,
    /// Wavelength in vacuum.
    pub wavelength: Length,
    /// Refractive index around the particle; vacuum when left out.
    #[serde(default = "vacuum")]
    pub host: RefractiveIndex,
    /// Refractive index of the sphere, or of the core when there are layers.
    pub particle: RefractiveIndex,
    /// Layers around the core, from the inside outward.
    #[serde(default)]
    pub layers: Vec<Coat>,
    /// Scattering angles for amplitudes and phase function; none when left out.
    #[serde(default)]
    pub angles: Option<Angles>,
    /// What scattering means where the host absorbs.
    #[serde(default)]
    pub definition: Definition,
    /// Folder for tables and plots; nothing is written when left out.
    #[serde(default)]
    pub output: Option<PathBuf>,
}

fn vacuum() -> RefractiveIndex {
    RefractiveIndex::VACUUM
}

/// A layer around what lies inside it. Parses "600nm:1.45".
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Coat {
    /// Outer radius of the layer, measured from the centre of the particle.
    pub radius: Length,
    /// Refractive index of the layer.
    pub index: RefractiveIndex,
}

impl FromStr for Coat {
    type Err = QuantityError;

    fn from_str(text: &str) -> Result<Self, QuantityError> {
        let Some((radius, index)) = text.split_once(':') else {
            let expected = "a layer is its outer radius and its refractive index, as in `600nm:1.45`";
            return Err(QuantityError::Form { text: text.trim().to_owned(), expected });
        };
        Ok(Self { radius: Length::parse_positive(radius)?, index: index.parse()? })
    }
}

impl Mie {
    /// A homogeneous sphere in vacuum, and nothing written.
    pub fn new(radius: Length, wavelength: Length, particle: RefractiveIndex) -> Self {
        Self {
            radius,
            wavelength,
            host: RefractiveIndex::VACUUM,
            particle,
            layers: Vec::new(),
            angles: None,
            definition: Definition::default(),
            output: None,
        }
    }

    /// The particle in its wave.
    fn particle(&self) -> Result<Particle, JobError> {
        let mut below = self.radius;
        for (i, layer) in self.layers.iter().enumerate() {
            if layer.radius <= below {
                return Err(JobError::Layers { number: i + 1, radius: layer.radius, below });
            }
            below = layer.radius;
        }
        let wave = PlaneWave::new(self.wavelength.metres(), self.host.value())?.with_definition(self.definition.into());
        let core = (self.radius.metres(), self.particle.value());
        let layers = self.layers.iter().map(|layer| (layer.radius.metres(), layer.index.value()));
        Particle::new(wave, core, layers)
    }

    pub(super) fn run(&self, context: &Context<'_>) -> Result<MieReport, JobError> {
        let particle = self.particle()?;
        let dir = self.output.as_deref().map(OutputDir::create).transpose()?;
        let sheet = MieSheet::compute(self.clone(), &particle)?;
        let mut files = Vec::new();
        if let Some(dir) = dir {
            let figures = figures::figures(&sheet, &particle, context)?;
            context.say(Event::Begin(Stage::Write));
            let table = sheet.table()?;
            files.push(dir.write("mie.csv", |out| table.write_csv(out))?);
            if let Some(table) = sheet.angle_table()? {
                files.push(dir.write("angles.csv", |out| table.write_csv(out))?);
            }
            files.push(dir.write("mie.json", |out| sheet.write_json(out))?);
            for (name, svg) in figures {
                files.push(dir.write(name, |out| out.write_all(svg.as_bytes()))?);
            }
            dir.commit();
            context.say(Event::End(Stage::Write));
        }
        Ok(MieReport { sheet, files })
    }
}

/// What [`Mie`] leaves.
#[derive(Debug, Clone, PartialEq)]
pub struct MieReport {
    /// What the particle does to light.
    pub sheet: MieSheet,
    /// The files written.
    pub files: Vec<PathBuf>,
}
