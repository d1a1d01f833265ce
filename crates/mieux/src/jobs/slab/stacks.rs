//! From what was asked for to the stacks that are solved: one for each thickness and wavelength.

use std::path::Path;
use std::sync::atomic::AtomicU64;

use mieux_io::quantity::{format_length, significant};
use mieux_io::recipe::{Material, Recipe};
use mieux_io::slab_file::layers::{self, LayerSpec};
use mieux_io::slab_file::phase::PhaseChoice;
use mieux_optics::phase::{Isotropic, PhaseFunction};
use mieux_optics::spectrum::WavelengthGrid;
use mieux_optics::transfer::{Ground, Layer, Stack};

use super::super::{Context, Event, JobError, Stage, wavelengths};
use super::matter::{Count, Scattering, SpectralMatter, Wanted};
use super::{Sample, Slab, SlabError};

/// The optical thickness of a half-space, of which even without absorption no more than 1e-12 would be seen to pass.
pub(super) const ENDLESS: f64 = 1e14;

/// How thick a piece is.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Extent {
    /// Optical thickness, possibly infinite.
    Optical(f64),
    /// Metres, possibly infinite.
    Metres(f64),
    /// As thick as was asked for.
    AskedFor,
}

/// What a piece is made of.
#[derive(Debug, Clone)]
enum Matter {
    Grey { albedo: f64, scattering: Scattering, index: f64 },
    Pane { index: f64 },
    Spectral { matter: usize, index: Option<f64> },
}

/// A layer before its thickness and wavelength are known.
#[derive(Debug, Clone)]
struct Piece {
    matter: Matter,
    extent: Extent,
}

/// One of the slabs that are asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// What tells it from the others: "1 mm", "tau = 2", "half-space"; empty where there is one.
    pub label: String,
    /// Metres, of all layers together; infinite for a half-space, `None` where a layer has no length.
    pub thickness_m: Option<f64>,
}

/// All that is to be solved, and what to call it.
#[derive(Debug, Clone)]
pub(super) struct Stacks {
    pub title: String,
    /// Name and inputs of the material that was asked for.
    pub material: Option<Material>,
    pub grid: Option<WavelengthGrid>,
    pub cases: Vec<Case>,
    /// Case by case, wavelength by wavelength.
    pub stacks: Vec<Stack>,
    /// Of the layers of each stack; empty unless photons were asked for.
    pub functions: Vec<Vec<PhaseFunction>>,
    /// What was done to tables of phase functions.
    pub notes: Vec<String>,
}

/// The pieces of a sample, and the materials they refer to.
struct Parts {
    title: String,
    asked_for: Option<Material>,
    pieces: Vec<Piece>,
    materials: Vec<Material>,
    /// Thicknesses that were asked for, each a case: metres, or optical for an abstract medium.
    extents: Vec<Extent>,
    notes: Vec<String>,
}

impl Stacks {
    pub fn build(slab: &Slab, wanted: Wanted, context: &Context<'_>) -> Result<Self, JobError> {
        let parts = Parts::of(&slab.sample, wanted)?;
        let grid = match (&slab.wavelengths, parts.materials.is_empty()) {
            (Some(_), true) => {
                let with = "an abstract medium, which is alike at all of them".to_owned();
                return Err(SlabError::Meaningless { what: "a choice of wavelengths", with }.into());
            }
            (text, false) => Some(wavelengths::chosen(text.as_ref(), parts.materials.iter().map(|m| &m.medium))?),
            (None, true) => None,
        };
        check_extents(slab, &parts)?;
        let matters = spectra(&parts.materials, grid.as_ref(), wanted, context)?;
        let mut found = Self {
            title: parts.title.clone(),
            material: parts.asked_for.clone(),
            cases: parts.extents.iter().map(|extent| parts.case(*extent)).collect(),
            stacks: Vec::new(),
            functions: Vec::new(),
            notes: parts.notes.clone(),
            grid,
        };
        for extent in &parts.extents {
            for wavelength in 0..found.grid.as_ref().map_or(1, WavelengthGrid::len) {
                let layers = parts.pieces.iter().map(|piece| piece.layer(*extent, wavelength, &matters));
                let (layers, functions): (Vec<Layer>, Vec<Option<PhaseFunction>>) = layers.unzip();
                let endless = layers.last().is_some_and(|layer| layer.optical_thickness == ENDLESS);
                let (stack, before, after) = surrounded(slab, layers, endless);
                stack.check()?;
                found.stacks.push(stack);
                let pane = |count| std::iter::repeat_n(PhaseFunction::from(Isotropic), count);
                if wanted.functions {
                    let own = functions.into_iter().map(|function| function.unwrap_or(Isotropic.into()));
                    found.functions.push(pane(before).chain(own).chain(pane(after)).collect());
                }
            }
        }
        Ok(found)
    }
}

/// The layers between slides, in the medium outside, over the backing; and how many panes were added above and below.
fn surrounded(slab: &Slab, mut layers: Vec<Layer>, endless: bool) -> (Stack, usize, usize) {
    let (mut before, mut after) = (0, 0);
    if let Some(index) = slab.slides {
        layers.insert(0, Layer::pane(index, 0.0));
        before = 1;
        if !endless {
            layers.push(Layer::pane(index, 0.0));
            after = 1;
        }
    }
    let last = layers.last().map_or(1.0, |layer| layer.refractive_index);
    let outside = slab.index_outside;
    let (below, ground) = match (endless, slab.contact) {
        (true, _) => (last, Ground::Black),
        (false, true) => (last, slab.backing.ground()),
        (false, false) => (outside, slab.backing.ground()),
    };
    (Stack { above: outside, layers, below, ground }, before, after)
}

/// That only the last layer has no end, and that there is something below for a backing to be.
fn check_extents(slab: &Slab, parts: &Parts) -> Result<(), JobError> {
    let layers = parts.pieces.len();
    let endless = |piece: &Piece, asked_for: Extent| match piece.extent.or(asked_for) {
        Extent::Optical(value) | Extent::Metres(value) => value.is_infinite(),
        Extent::AskedFor => false,
    };
    for extent in &parts.extents {
        if let Some(above) = parts.pieces[..layers - 1].iter().position(|piece| endless(piece, *extent)) {
            return Err(SlabError::EndlessAbove { layer: above + 1, layers }.into());
        }
    }
    let all = parts.extents.iter().all(|extent| endless(&parts.pieces[layers - 1], *extent));
    let what = if slab.backing.ground() != Ground::Black { "a backing" } else { "contact with a backing" };
    if all && (slab.backing.ground() != Ground::Black || slab.contact) {
        let with = "a half-space, below which there is nothing".to_owned();
        return Err(SlabError::Meaningless { what, with }.into());
    }
    Ok(())
}

fn spectra(
    materials: &[Material],
    grid: Option<&WavelengthGrid>,
    wanted: Wanted,
    context: &Context<'_>,
) -> Result<Vec<SpectralMatter>, JobError> {
    let Some(grid) = grid else { return Ok(Vec::new()) };
    context.say(Event::Begin(Stage::Optics));
    let count = Count { stage: Stage::Optics, done: AtomicU64::new(0), total: (grid.len() * materials.len()) as u64 };
    let all = materials.iter().map(|material| SpectralMatter::compute(material, grid, wanted, &count, context));
    let all = all.collect::<Result<_, _>>()?;
    context.say(Event::End(Stage::Optics));
    Ok(all)
}

impl Extent {
    fn or(self, asked_for: Self) -> Self {
        if self == Self::AskedFor { asked_for } else { self }
    }
}

impl Piece {
    /// The layer at a wavelength, and its phase function where there is one.
    fn layer(&self, asked_for: Extent, at: usize, matters: &[SpectralMatter]) -> (Layer, Option<PhaseFunction>) {
        let extent = self.extent.or(asked_for);
        match &self.matter {
            Matter::Pane { index } => (Layer::pane(*index, extent.optical(1.0)), None),
            Matter::Grey { albedo, scattering, index } => {
                let layer = Layer::new(extent.optical(1.0), *albedo, scattering.moments.clone());
                (layer.with_index(*index), scattering.function.clone())
            }
            Matter::Spectral { matter, index } => {
                let matter = &matters[*matter];
                let layer = matter.layer(at, extent.optical(matter.extinction(at)));
                (layer.with_index(index.unwrap_or(matter.index[at])), matter.scattering[at].function.clone())
            }
        }
    }
}

impl Extent {
    /// Optical thickness of matter with this extinction coefficient (1/m).
    fn optical(self, extinction: f64) -> f64 {
        match self {
            Self::Optical(value) if value.is_finite() => value,
            Self::Metres(value) if value.is_finite() => value * extinction,
            Self::AskedFor => 0.0,
            _ => ENDLESS,
        }
    }

    fn label(self) -> String {
        match self {
            Self::Optical(value) | Self::Metres(value) if value.is_infinite() => "half-space".into(),
            Self::Optical(value) => format!("tau = {}", significant(value, 5)),
            Self::Metres(value) => format_length(value),
            Self::AskedFor => String::new(),
        }
    }
}

impl Parts {
    fn of(sample: &Sample, wanted: Wanted) -> Result<Self, JobError> {
        match sample {
            Sample::Medium { albedo, g, phase, tau, index } => {
                if !(0.0..=1.0).contains(albedo) {
                    let allowed = "the share of light that is scattered rather than absorbed lies between 0 and 1";
                    return Err(JobError::Value { name: "albedo", value: albedo.to_string(), allowed });
                }
                let choice = phase.with_asymmetry(*g)?;
                let (scattering, note) = Scattering::chosen(&choice, wanted)?;
                let title = format!("Medium of albedo {albedo}, {}", named(&choice));
                let matter = Matter::Grey { albedo: *albedo, scattering, index: index.unwrap_or(1.0) };
                if tau.is_empty() {
                    let wanted = "an optical thickness, as in 2, or inf";
                    return Err(SlabError::Missing { what: "tau", wanted }.into());
                }
                Ok(Self {
                    title,
                    asked_for: None,
                    pieces: vec![Piece { matter, extent: Extent::AskedFor }],
                    materials: Vec::new(),
                    extents: tau.iter().map(|tau| Extent::Optical(tau.value())).collect(),
                    notes: note.into_iter().collect(),
                })
            }
            Sample::Material { material, set, thickness, index } => {
                let material = Recipe::find(material)?.material(set)?;
                Ok(Self {
                    title: material.title.clone(),
                    asked_for: Some(material.clone()),
                    pieces: vec![Piece {
                        matter: Matter::Spectral { matter: 0, index: *index },
                        extent: Extent::AskedFor,
                    }],
                    materials: vec![material],
                    extents: asked_for(thickness)?,
                    notes: Vec::new(),
                })
            }
            Sample::Layers { layers, material, set, thickness } => {
                let material = material.as_ref().map(|name| Recipe::find(name)?.material(set)).transpose()?;
                Self::layers(layers, material, || asked_for(thickness), wanted)
            }
        }
    }

    fn layers(
        path: &Path,
        asked_for: Option<Material>,
        extents: impl Fn() -> Result<Vec<Extent>, JobError>,
        wanted: Wanted,
    ) -> Result<Self, JobError> {
        let file = layers::read(path)?;
        let name = || path.display().to_string();
        let has_place = file.layers.contains(&LayerSpec::AskedFor);
        let title = file.title.unwrap_or_else(|| format!("Layers of {}", name()));
        let mut parts = Self {
            title,
            asked_for: asked_for.clone(),
            pieces: Vec::new(),
            materials: Vec::new(),
            extents: vec![Extent::AskedFor],
            notes: Vec::new(),
        };
        match (asked_for, has_place) {
            (Some(material), true) => {
                parts.title = format!("{}: {}", parts.title, material.title);
                parts.materials.push(material);
                parts.extents = extents()?;
            }
            (Some(material), false) => {
                return Err(SlabError::NoPlace { layers: name(), material: material.name }.into());
            }
            (None, true) => {
                let wanted = "a layer of the file is `*`, which stands for it; name one, and its thickness";
                return Err(SlabError::Missing { what: "the material", wanted }.into());
            }
            (None, false) => {}
        }
        for spec in file.layers {
            let piece = parts.piece(spec, wanted)?;
            parts.pieces.push(piece);
        }
        Ok(parts)
    }

    fn piece(&mut self, spec: LayerSpec, wanted: Wanted) -> Result<Piece, JobError> {
        Ok(match spec {
            LayerSpec::AskedFor => {
                Piece { matter: Matter::Spectral { matter: 0, index: None }, extent: Extent::AskedFor }
            }
            LayerSpec::Pane { index, tau } => Piece { matter: Matter::Pane { index }, extent: Extent::Optical(tau) },
            LayerSpec::Medium { albedo, phase, tau, index } => {
                let (scattering, note) = Scattering::chosen(&phase, wanted)?;
                self.notes.extend(note);
                Piece { matter: Matter::Grey { albedo, scattering, index }, extent: Extent::Optical(tau) }
            }
            LayerSpec::Material { material, thickness } => {
                let known = self.materials.iter().position(|known| known.medium == material.medium);
                let matter = known.unwrap_or_else(|| {
                    self.materials.push(*material);
                    self.materials.len() - 1
                });
                Piece { matter: Matter::Spectral { matter, index: None }, extent: Extent::Metres(thickness.metres()) }
            }
        })
    }

    fn case(&self, extent: Extent) -> Case {
        let lengths = self.pieces.iter().map(|piece| match piece.extent.or(extent) {
            Extent::Metres(metres) => Some(metres),
            Extent::Optical(_) if matches!(piece.matter, Matter::Pane { .. }) => Some(0.0),
            _ => None,
        });
        Case { label: extent.label(), thickness_m: lengths.sum() }
    }
}

fn asked_for(thickness: &[mieux_io::quantity::Thickness]) -> Result<Vec<Extent>, JobError> {
    if thickness.is_empty() {
        let wanted = "how thick the material is, as in 1mm, or inf for a half-space";
        return Err(SlabError::Missing { what: "thickness", wanted }.into());
    }
    Ok(thickness.iter().map(|thickness| Extent::Metres(thickness.metres())).collect())
}

fn named(choice: &PhaseChoice) -> String {
    match choice {
        PhaseChoice::Hg { g } => format!("Henyey-Greenstein, g = {g}"),
        PhaseChoice::Isotropic => "isotropic".into(),
        PhaseChoice::Rayleigh => "Rayleigh".into(),
        PhaseChoice::File(path) => format!("phase function of {}", path.display()),
    }
}
