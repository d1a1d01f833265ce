//! The phase functions that can be asked for, as they are written down.

use std::collections::BTreeMap;

use mieux_io::quantity::{Length, RefractiveIndex, format_length, significant};
use mieux_io::recipe::Recipe;
use mieux_optics::medium::{Inclusion, Medium, MediumError};
use mieux_optics::particle::SizeDistribution;
use mieux_optics::phase::{
    CornetteShanks, DoubleHenyeyGreenstein, Draine, FournierForand, HenyeyGreenstein, Isotropic, PhaseFunction,
    Rayleigh, WaterDroplet,
};
use mieux_optics::substance::{Substance, Water};
use serde::{Deserialize, Serialize};

use super::JobError;

/// A phase function by its name and parameters, or a particle or material to which Lorenz-Mie theory gives one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum PhaseModel {
    /// [`Isotropic`].
    Isotropic {},
    /// [`Rayleigh`].
    Rayleigh {},
    /// [`HenyeyGreenstein`].
    Hg {
        /// Mean cosine.
        g: f64,
    },
    /// [`DoubleHenyeyGreenstein`].
    DoubleHg {
        /// Share of the first lobe.
        weight: f64,
        /// Mean cosine of the first lobe.
        g1: f64,
        /// Mean cosine of the second lobe.
        g2: f64,
    },
    /// [`CornetteShanks`].
    CornetteShanks {
        /// Its parameter, which is not its mean cosine.
        g: f64,
    },
    /// [`Draine`].
    Draine {
        /// Its first parameter.
        g: f64,
        /// Its second parameter: 0 is Henyey-Greenstein's, 1 with `g = 0` Rayleigh's.
        alpha: f64,
    },
    /// [`FournierForand`], by the slope of the size distribution or the share that is scattered backward.
    FournierForand {
        /// Of the particles relative to water.
        refractive_index: f64,
        /// Slope of the size distribution.
        #[serde(default)]
        slope: Option<f64>,
        /// Share of the light scattered by more than 90 degrees.
        #[serde(default)]
        backscatter: Option<f64>,
    },
    /// [`WaterDroplet`].
    Fog {
        /// Of the droplet.
        diameter: Length,
    },
    /// One sphere, by Lorenz-Mie theory.
    Mie {
        /// Of the sphere.
        diameter: Length,
        /// In vacuum.
        #[serde(default = "green")]
        wavelength: Length,
        /// Refractive index around the sphere; vacuum when left out.
        #[serde(default = "vacuum")]
        host: RefractiveIndex,
        /// Refractive index of the sphere; that of water when left out.
        #[serde(default)]
        particle: Option<RefractiveIndex>,
    },
    /// Everything in a material that scatters, by Lorenz-Mie theory.
    Material {
        /// A built-in material, or the path of a recipe.
        material: String,
        /// Inputs that differ from the recipe's.
        #[serde(default)]
        set: BTreeMap<String, f64>,
        /// In vacuum.
        #[serde(default = "green")]
        wavelength: Length,
    },
}

/// 550 nm.
fn green() -> Length {
    Length::GREEN
}

fn vacuum() -> RefractiveIndex {
    RefractiveIndex::VACUUM
}

/// A phase function with what to call it.
#[derive(Debug, Clone, PartialEq)]
pub struct Named {
    /// In a few letters, as it is asked for: a column of a table is called so.
    pub name: String,
    /// In a line, with the parameters.
    pub title: String,
    /// The function.
    pub phase: PhaseFunction,
}

impl PhaseModel {
    /// As it is written down; of a material, the material's.
    pub fn name(&self) -> &str {
        match self {
            Self::Isotropic {} => "isotropic",
            Self::Rayleigh {} => "rayleigh",
            Self::Hg { .. } => "hg",
            Self::DoubleHg { .. } => "double-hg",
            Self::CornetteShanks { .. } => "cornette-shanks",
            Self::Draine { .. } => "draine",
            Self::FournierForand { .. } => "fournier-forand",
            Self::Fog { .. } => "fog",
            Self::Mie { .. } => "mie",
            Self::Material { material, .. } => material,
        }
    }

    /// The function, the integral over sizes and the table over angles within `tolerance`.
    pub(super) fn compute(&self, tolerance: f64) -> Result<Named, JobError> {
        let plain = |phase: PhaseFunction| (title(&phase), phase);
        let (title, phase) = match self {
            Self::Isotropic {} => plain(Isotropic.into()),
            Self::Rayleigh {} => plain(Rayleigh.into()),
            Self::Hg { g } => plain(HenyeyGreenstein::new(*g)?.into()),
            Self::DoubleHg { weight, g1, g2 } => plain(DoubleHenyeyGreenstein::new(*weight, *g1, *g2)?.into()),
            Self::CornetteShanks { g } => plain(CornetteShanks::new(*g)?.into()),
            Self::Draine { g, alpha } => plain(Draine::new(*g, *alpha)?.into()),
            Self::FournierForand { refractive_index, slope, backscatter } => plain(match (slope, backscatter) {
                (Some(slope), None) => FournierForand::new(*refractive_index, *slope)?.into(),
                (None, Some(share)) => FournierForand::from_backscatter(*refractive_index, *share)?.into(),
                _ => return Err(JobError::SlopeOrBackscatter),
            }),
            Self::Fog { diameter } => plain(WaterDroplet::new(diameter.metres())?.into()),
            Self::Mie { diameter, wavelength, host, particle } => {
                sphere(*diameter, *wavelength, *host, *particle, tolerance)?
            }
            Self::Material { material, set, wavelength } => {
                let material = Recipe::find(material)?.material(set)?;
                let phase = material.medium.phase_at(wavelength.metres(), tolerance);
                let phase = phase.map_err(|source| JobError::Medium { material: material.name.clone(), source })?;
                let idle = match &phase {
                    PhaseFunction::Isotropic(_) => ", which scatters nothing: taken for isotropic",
                    PhaseFunction::HenyeyGreenstein(_) => {
                        ", whose particles are too large for exact phase functions: Henyey-Greenstein of the same asymmetry"
                    }
                    _ => "",
                };
                (format!("{} at {}{idle}", material.title, format_length(wavelength.metres())), phase)
            }
        };
        Ok(Named { name: self.name().to_owned(), title, phase })
    }
}

fn sphere(
    diameter: Length,
    wavelength: Length,
    host: RefractiveIndex,
    particle: Option<RefractiveIndex>,
    tolerance: f64,
) -> Result<(String, PhaseFunction), JobError> {
    let water = Substance::Water(Water::ROOM);
    let substance = particle.map_or(water, |index| Substance::Constant(index.value()));
    let phase = || -> Result<PhaseFunction, MediumError> {
        let sizes = SizeDistribution::Monodisperse { radius_m: 0.5 * diameter.metres() };
        let sphere = Inclusion::new("sphere", substance, sizes, 1e-6);
        Medium::new(Substance::Constant(host.value()), vec![sphere])?.phase_at(wavelength.metres(), tolerance)
    };
    let phase = phase().map_err(|source| JobError::Medium { material: "mie".into(), source })?;
    let of = particle.map_or("water".to_owned(), |index| format!("n = {index}"));
    let (diameter, wavelength) = (format_length(diameter.metres()), format_length(wavelength.metres()));
    Ok((format!("Sphere of {diameter} across, {of}, in n = {host} at {wavelength}"), phase))
}

/// The function's name and its parameters as people read them.
pub(super) fn title(phase: &PhaseFunction) -> String {
    let parameters: Vec<String> = parameters(phase)
        .into_iter()
        .map(|(name, value)| match name.strip_suffix("_m") {
            Some(length) => format!("{length} {}", format_length(value)),
            None if name == "refractive_index" => format!("n = {}", significant(value, 5)),
            None => format!("{name} = {}", significant(value, 5)),
        })
        .collect();
    let name = match phase {
        PhaseFunction::WaterDroplet(_) => "Fog fit",
        PhaseFunction::Isotropic(_) => "Isotropic",
        other => other.name(),
    };
    if parameters.is_empty() { name.to_owned() } else { format!("{name} ({})", parameters.join(", ")) }
}

/// Names and values of the parameters, in SI; none of a table.
pub(super) fn parameters(phase: &PhaseFunction) -> Vec<(&'static str, f64)> {
    match phase {
        PhaseFunction::HenyeyGreenstein(hg) => vec![("g", hg.asymmetry())],
        PhaseFunction::DoubleHenyeyGreenstein(lobes) => {
            let (weight, g1, g2) = lobes.parameters();
            vec![("weight", weight), ("g1", g1), ("g2", g2)]
        }
        PhaseFunction::CornetteShanks(phase) => vec![("g", phase.parameter())],
        PhaseFunction::Draine(phase) => {
            let (g, alpha) = phase.parameters();
            vec![("g", g), ("alpha", alpha)]
        }
        PhaseFunction::HenyeyGreensteinDraine(lobes) => {
            let (g_d, alpha) = lobes.draine().parameters();
            let g_hg = lobes.henyey_greenstein().asymmetry();
            vec![("w_d", lobes.draine_weight()), ("g_hg", g_hg), ("g_d", g_d), ("alpha", alpha)]
        }
        PhaseFunction::WaterDroplet(droplet) => vec![("diameter_m", droplet.diameter())],
        PhaseFunction::FournierForand(phase) => {
            let (refractive_index, slope) = phase.parameters();
            vec![("refractive_index", refractive_index), ("slope", slope)]
        }
        _ => Vec::new(),
    }
}
