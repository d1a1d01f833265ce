//! What a render is of: a material in a glass, glasses in a row, or a scene with a camera of its own.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

use mieux_io::mitsuba::{is_mitsuba, read_mitsuba};
use mieux_io::quantity::{Size, format_length};
use mieux_io::recipe::{Material, Recipe, RecipeError};
use mieux_io::scene::description::Description;
use mieux_io::scene::{SceneFile, Subject};
use mieux_optics::medium::{BulkOptics, DEFAULT_TOLERANCE, Medium as OpticsMedium};
use mieux_optics::phase::SpectralPhase;
use mieux_optics::spectrum::{Sampled, SpectrumError, WavelengthGrid};
use mieux_optics::substance::Substance;
use mieux_render::light::constant;
use mieux_render::medium::{Medium, Phase};
use mieux_render::render::RenderError;
use mieux_render::scene::{GlassScene, Scene, glasses};

use super::staging::{self, Staged};
use super::{Context, JobError, OpticsSheet, wavelengths};

/// What has the index of air to a part in a thousand is fog, and does not bend light.
const AIRY: f64 = 1e-3;
/// Of the phase functions of fogs.
const PHASE_TOLERANCE: f64 = 1e-2;

/// What a render is of.
pub(super) struct Wanted {
    pub(super) name: String,
    pub(super) title: String,
    /// Of the picture unless another is asked for.
    pub(super) size: Size,
    /// From left to right, or in the order of the scene.
    materials: Vec<Material>,
    set: Set,
}

/// Where the materials are.
enum Set {
    Glasses,
    Described(Box<Description>),
}

impl Wanted {
    /// What the subject of a job names, with inputs of its materials set.
    pub(super) fn find(subject: &str, set: &BTreeMap<String, f64>) -> Result<Self, JobError> {
        let path = Path::new(subject);
        if is_mitsuba(path) {
            let values: Vec<(String, String)> = set.iter().map(|(k, v)| (k.clone(), v.to_string())).collect();
            let description = read_mitsuba(path, &values).map_err(RecipeError::from)?;
            let name = path.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned());
            return Self::described(name, description, &BTreeMap::new());
        }
        match Subject::find(subject)? {
            Subject::Material(recipe) => {
                let material = recipe.material(set)?;
                let (name, title) = (material.name.clone(), recipe.title().to_owned());
                Ok(Self { name, title, size: SceneFile::glass()?.size, materials: vec![material], set: Set::Glasses })
            }
            Subject::Scene(name, scene) => {
                let materials = materials_of(&name, &scene, set)?;
                Ok(Self { name, title: scene.title, size: scene.size, materials, set: Set::Glasses })
            }
            Subject::Whole(name, description) => Self::described(name, *description, set),
        }
    }

    /// Inputs that are set count for every material that has them.
    fn described(name: String, description: Description, set: &BTreeMap<String, f64>) -> Result<Self, JobError> {
        let mut materials = Vec::with_capacity(description.materials.len());
        let mut used = Vec::new();
        for choice in &description.materials {
            let recipe = choice.recipe.as_deref();
            let recipe = recipe.ok_or_else(|| staging::fault(&choice.place, "no material was asked for"))?;
            let recipe = Recipe::find(recipe)?;
            let has = |input: &String| recipe.inputs().iter().any(|(i, _)| i.name == *input);
            let mut inputs: BTreeMap<String, f64> = choice.set.iter().cloned().collect();
            for (input, value) in set.iter().filter(|(input, _)| has(input)) {
                inputs.insert(input.clone(), *value);
                used.push(input.clone());
            }
            materials.push(recipe.material(&inputs)?);
        }
        if let Some(input) = set.keys().find(|input| !used.contains(input)) {
            return Err(JobError::NoSuchInput { scene: name, input: input.clone() });
        }
        let [width, height] = description.camera.size;
        Ok(Self {
            name,
            title: description.title.clone(),
            size: format!("{width}x{height}").parse()?,
            materials,
            set: Set::Described(Box::new(description)),
        })
    }

    /// The properties of the materials.
    pub(super) fn sheets(&self, context: &Context<'_>) -> Result<Vec<OpticsSheet>, JobError> {
        let mut sheets = Vec::with_capacity(self.materials.len());
        for material in &self.materials {
            let grid = wavelengths::usual([&material.medium]);
            sheets.push(OpticsSheet::compute(material.clone(), &grid, DEFAULT_TOLERANCE, context)?);
        }
        Ok(sheets)
    }

    /// The scene, and what was assumed.
    pub(super) fn scene(&self, sheets: &[OpticsSheet], size: Size) -> Result<(Scene, Vec<String>), JobError> {
        let mut notes = notes(sheets);
        match &self.set {
            Set::Glasses => Ok((build(sheets, size)?, notes)),
            Set::Described(description) => {
                let known: Vec<Medium> = sheets.iter().map(known).collect::<Result<_, _>>()?;
                let Staged { scene, notes: more } = staging::stage(description, &known, [size.width(), size.height()])?;
                notes.extend(more);
                Ok((scene, notes))
            }
        }
    }

    /// A number that changes with any property of the materials, and with what is described (the hash of Fowler, Noll and Vo).
    pub(super) fn fingerprint(&self, sheets: &[OpticsSheet]) -> u64 {
        let mut hash = 0xcbf2_9ce4_8422_2325_u64;
        let mut add = |byte: u8| hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        for sheet in sheets {
            let bulk = &sheet.bulk;
            for values in [bulk.grid().as_slice(), bulk.sigma_s(), bulk.sigma_a(), bulk.asymmetry(), bulk.n_real()] {
                values.iter().flat_map(|v| v.to_bits().to_le_bytes()).for_each(&mut add);
            }
        }
        if let Set::Described(description) = &self.set {
            // Nothing is kept of the text: meshes and grids are long.
            let _ = write!(Each(add), "{description:?}");
        }
        hash
    }
}

/// Takes text byte by byte.
struct Each<F>(F);

impl<F: FnMut(u8)> Write for Each<F> {
    fn write_str(&mut self, text: &str) -> std::fmt::Result {
        text.bytes().for_each(&mut self.0);
        Ok(())
    }
}

fn materials_of(name: &str, scene: &SceneFile, set: &BTreeMap<String, f64>) -> Result<Vec<Material>, JobError> {
    let mut recipes = Vec::with_capacity(scene.glasses.len());
    for glass in &scene.glasses {
        let glass = glass.as_ref().ok_or_else(|| JobError::NoMaterial { scene: name.into() })?;
        recipes.push(Recipe::find(glass)?);
    }
    let has = |recipe: &Recipe, input: &str| recipe.inputs().iter().any(|(i, _)| i.name == input);
    if let Some(input) = set.keys().find(|input| !recipes.iter().any(|r| has(r, input))) {
        return Err(JobError::NoSuchInput { scene: name.into(), input: input.clone() });
    }
    let settings = |recipe: &Recipe| set.clone().into_iter().filter(|(k, _)| has(recipe, k)).collect();
    recipes.iter().map(|recipe| Ok(recipe.material(&settings(recipe))?)).collect()
}

/// Constant beyond the first and last wavelength, as far as pictures reach.
fn beyond(spectrum: &Sampled) -> Result<Sampled, SpectrumError> {
    let (first, last) = staging::RANGE;
    let (mut wavelengths, mut values) = (spectrum.grid().as_slice().to_vec(), spectrum.values().to_vec());
    if wavelengths[0] > first {
        wavelengths.insert(0, first);
        values.insert(0, values[0]);
    }
    if wavelengths[wavelengths.len() - 1] < last {
        wavelengths.push(last);
        values.push(values[values.len() - 1]);
    }
    Sampled::new(WavelengthGrid::new(wavelengths)?, values)
}

/// What is said of materials that are not known as far as pictures reach.
fn notes(sheets: &[OpticsSheet]) -> Vec<String> {
    let usual = WavelengthGrid::frisvad2007().range();
    let partly = sheets.iter().filter(|sheet| sheet.bulk.grid().range() != usual);
    partly
        .map(|sheet| {
            let (from, to) = sheet.bulk.grid().range();
            let (from, to) = (format_length(from), format_length(to));
            format!(
                "{} is known from {from} to {to}; beyond, its properties are taken as at the nearer end",
                sheet.material.name
            )
        })
        .collect()
}

/// The scene of glasses filled with the materials of the sheets.
fn build(sheets: &[OpticsSheet], size: Size) -> Result<Scene, JobError> {
    let glass = OpticsMedium::new(Substance::SodaLimeGlass, Vec::new())
        .and_then(|glass| glass.bulk_optics(&WavelengthGrid::regular(370e-9, 790e-9, 10e-9)?, DEFAULT_TOLERANCE))
        .map_err(|source| JobError::Medium { material: "glass".into(), source })?;
    let mut liquids = Vec::with_capacity(sheets.len());
    for sheet in sheets {
        liquids.push((sheet.material.title.clone(), medium(&sheet.bulk)?));
    }
    let mut wanted = GlassScene::new(liquids, medium(&glass)?);
    wanted.resolution = [size.width(), size.height()];
    Ok(glasses(&wanted).map_err(RenderError::from)?)
}

fn medium(bulk: &BulkOptics) -> Result<Medium, JobError> {
    let spectrum = |values: &[f64]| beyond(&Sampled::new(bulk.grid().clone(), values.to_vec())?);
    Ok(Medium::new(
        spectrum(bulk.sigma_s())?,
        spectrum(bulk.sigma_a())?,
        spectrum(bulk.asymmetry())?,
        spectrum(bulk.n_real())?,
    ))
}

/// A material of a scene. What light comes into straight is seen in single scattering, where bows and glories are: it gets
/// its own phase functions; of what is turbid behind a surface only the mean cosine shows.
fn known(sheet: &OpticsSheet) -> Result<Medium, JobError> {
    let mut made = medium(&sheet.bulk)?;
    if made.n.values().iter().all(|n| (n - 1.0).abs() < AIRY) {
        let failed = |source| JobError::Medium { material: sheet.material.name.clone(), source };
        if let Some(one) = constant(1.0) {
            made.n = one;
        }
        if sheet.bulk.sigma_s().iter().any(|s| *s > 0.0) {
            let grid = sheet.bulk.grid();
            let phase = sheet.material.medium.spectral_phase(grid, PHASE_TOLERANCE).map_err(failed)?;
            made.parts[0].phase = Phase::Spectral(Arc::new(reaching(phase)?));
        }
    }
    Ok(made)
}

/// The nearest function holds beyond the ends.
fn reaching(phase: SpectralPhase) -> Result<SpectralPhase, JobError> {
    let (mut grid, mut functions) = (phase.grid().as_slice().to_vec(), phase.functions().to_vec());
    let (first, last) = staging::RANGE;
    if grid[0] > first {
        grid.insert(0, first);
        functions.insert(0, functions[0].clone());
    }
    if grid[grid.len() - 1] < last {
        grid.push(last);
        functions.push(functions[functions.len() - 1].clone());
    }
    Ok(SpectralPhase::new(WavelengthGrid::new(grid)?, functions)?)
}
