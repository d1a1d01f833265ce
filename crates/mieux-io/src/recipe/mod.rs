//! Recipes: what a material is made of, as TOML. The built-in materials are such files.

mod builtin;
mod inclusion;
mod schema;
mod scope;
mod size_table;
mod sizes;
mod substance;

use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};

use mieux_optics::material::milk::Milk;
use mieux_optics::material::{Input, MaterialError};
use mieux_optics::medium::Medium;

use crate::text_error::{TextError, did_you_mean, nearest_names};
use schema::{Document, Source};

pub use builtin::MATERIALS;
pub use sizes::{SIZE_KINDS, parse_size_distribution};

/// Largest recipe or scene file read, bytes.
pub const MAX_TEXT: u64 = 1 << 20;

/// Why there is no material.
#[derive(Debug, thiserror::Error)]
pub enum RecipeError {
    /// Nothing built in has that name.
    #[error("there is no {what} called `{name}`")]
    Unknown {
        /// `material`, or `material or scene`.
        what: &'static str,
        /// What was asked for.
        name: String,
        /// What to do instead.
        help: String,
    },
    /// A recipe file that cannot be read.
    #[error("the recipe `{}` cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A recipe that says something impossible, with the place.
    #[error(transparent)]
    Text(#[from] Box<TextError>),
    /// A setting that is not `name=number`.
    #[error("`{text}` is not a setting; write `name=number`, as in `fat=1.5`")]
    Setting {
        /// What was typed.
        text: String,
    },
    /// A setting of an input that the material does not have.
    #[error("{material} has no input `{input}`")]
    NoSuchInput {
        /// Name of the material.
        material: String,
        /// The input asked for.
        input: String,
        /// What to do instead.
        help: String,
    },
    /// Inputs that make no material.
    #[error("{material}: {source}")]
    Material {
        /// Name of the material.
        material: String,
        /// What is wrong.
        source: MaterialError,
    },
}

/// A recipe as read: a model with its inputs, or a mixture, which may declare inputs of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Recipe {
    name: String,
    /// What errors call the text.
    file: String,
    text: String,
    document: Document,
    inputs: Vec<(Input, f64)>,
}

/// A material ready to be computed.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Name, as asked for: `whole-milk`, or the stem of the recipe's file name.
    pub name: String,
    /// What to call it in a heading.
    pub title: String,
    /// The inputs and their values.
    pub inputs: Vec<(Input, f64)>,
    /// What it is made of.
    pub medium: Medium,
}

impl Recipe {
    /// The built-in material of that name, or the recipe in the file of that path (anything that ends in `.toml` or has
    /// a folder in it).
    ///
    /// # Errors
    /// [`RecipeError`]: unknown (with the nearest names), unreadable, or wrong (with the place).
    pub fn find(name_or_path: &str) -> Result<Self, RecipeError> {
        if let Some((name, text)) = MATERIALS.iter().find(|(name, _)| *name == name_or_path) {
            return Self::parse(name, name, text);
        }
        let Some(path) = as_file(name_or_path) else {
            let names = MATERIALS.iter().map(|(name, _)| *name);
            return Err(unknown("material", name_or_path, names, "`mieux materials` lists them all"));
        };
        Self::parse(&stem(path), name_or_path, &read_text(path)?)
    }

    /// Reads a recipe from its text. `file` names it in errors.
    ///
    /// # Errors
    /// [`RecipeError::Text`].
    pub fn parse(name: &str, file: &str, text: &str) -> Result<Self, RecipeError> {
        let source = Source { file, text };
        let document = Document::read(source)?;
        let inputs = document.inputs(source)?;
        let (name, file, text) = (name.to_owned(), file.to_owned(), text.to_owned());
        let recipe = Self { name, file, text, document, inputs };
        // A mistake shows when the recipe is read, not when it is used.
        recipe.medium(&recipe.inputs)?;
        Ok(recipe)
    }

    /// Name, as asked for.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What to call it in a heading.
    pub fn title(&self) -> &str {
        self.document.title.as_deref().unwrap_or(&self.name)
    }

    /// What it is, in a sentence.
    pub fn about(&self) -> &str {
        self.document.about.as_deref().unwrap_or_default()
    }

    /// The recipe itself.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The inputs, with the values the recipe gives them.
    pub fn inputs(&self) -> &[(Input, f64)] {
        &self.inputs
    }

    /// The material with some inputs set to other values.
    ///
    /// # Errors
    /// [`RecipeError::NoSuchInput`], [`RecipeError::Material`], or [`RecipeError::Text`] where a formula goes wrong with
    /// these values.
    pub fn material(&self, settings: &BTreeMap<String, f64>) -> Result<Material, RecipeError> {
        let mut inputs = self.inputs.clone();
        for (name, &value) in settings {
            match inputs.iter_mut().find(|(input, _)| input.name == *name) {
                Some((input, slot)) => *slot = input.check(value).map_err(|source| self.refused(source))?,
                None => return Err(self.no_such_input(name, &inputs)),
            }
        }
        let medium = self.medium(&inputs)?;
        Ok(Material { name: self.name.clone(), title: self.title().to_owned(), inputs, medium })
    }

    fn medium(&self, inputs: &[(Input, f64)]) -> Result<Medium, RecipeError> {
        let source = Source { file: &self.file, text: &self.text };
        if self.document.has_model() {
            self.document.refuse_mixture(source)?;
            let milk = Milk::new(std::array::from_fn(|i| inputs[i].1));
            return milk.and_then(|milk| milk.medium()).map_err(|source| self.refused(source));
        }
        Ok(self.document.mixture(source, inputs)?)
    }

    fn refused(&self, source: MaterialError) -> RecipeError {
        RecipeError::Material { material: self.name.clone(), source }
    }

    fn no_such_input(&self, name: &str, inputs: &[(Input, f64)]) -> RecipeError {
        let names: Vec<&str> = inputs.iter().map(|(input, _)| &*input.name).collect();
        let help = if names.is_empty() {
            "its recipe has no inputs; to change it, write a recipe file of your own".to_string()
        } else {
            format!("it has {}", names.join(", "))
        };
        RecipeError::NoSuchInput { material: self.name.clone(), input: name.into(), help }
    }
}

/// Parses a setting "name=number".
///
/// # Errors
/// [`RecipeError::Setting`].
pub fn parse_setting(text: &str) -> Result<(String, f64), RecipeError> {
    let error = || RecipeError::Setting { text: text.into() };
    let (name, value) = text.split_once('=').ok_or_else(error)?;
    let value: f64 = value.trim().parse().map_err(|_| error())?;
    if name.trim().is_empty() || !value.is_finite() {
        return Err(error());
    }
    Ok((name.trim().into(), value))
}

/// What was named, if it names a file rather than something built in: it ends in `.toml` or has a folder in it.
pub(crate) fn as_file(name_or_path: &str) -> Option<&Path> {
    let path = Path::new(name_or_path);
    let is_file = path.extension().is_some_and(|e| e == "toml") || path.components().count() > 1;
    is_file.then_some(path)
}

/// What a file is called without its folder and ending.
pub(crate) fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// The error for a name that is not known, with the nearest that are.
pub(crate) fn unknown<'a>(
    what: &'static str,
    name: &str,
    known: impl Iterator<Item = &'a str>,
    where_to_look: &str,
) -> RecipeError {
    let nearest = nearest_names(name, known);
    let hint = if nearest.is_empty() { String::new() } else { did_you_mean(&nearest) + " " };
    let help = format!("{hint}{where_to_look}; a file of your own is named with its ending, as in `my.toml`");
    RecipeError::Unknown { what, name: name.into(), help }
}

pub(crate) fn read_text(path: &Path) -> Result<String, RecipeError> {
    let error = |source| RecipeError::Read { path: path.into(), source };
    let mut text = String::new();
    let file = std::fs::File::open(path).map_err(error)?;
    file.take(MAX_TEXT + 1).read_to_string(&mut text).map_err(error)?;
    if text.len() as u64 > MAX_TEXT {
        return Err(error(std::io::Error::other("it is larger than 1 MiB, which no recipe is")));
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        Recipe::parse("my", "my.toml", text).unwrap_err().to_string()
    }

    #[test]
    fn every_built_in_material_reads_and_computes() {
        let grid = mieux_optics::spectrum::WavelengthGrid::new(vec![450e-9, 650e-9]).unwrap();
        for (name, _) in MATERIALS {
            let recipe = Recipe::find(name).unwrap();
            assert!(!recipe.title().is_empty() && !recipe.about().is_empty(), "{name}");
            recipe.material(&BTreeMap::new()).unwrap().medium.bulk_optics(&grid, 1e-3).unwrap();
        }
        assert!(MATERIALS.is_sorted());
    }

    #[test]
    fn settings_change_inputs() {
        let recipe = Recipe::find("whole-milk").unwrap();
        let set = |name: &str, value| recipe.material(&BTreeMap::from([(name.to_string(), value)]));
        assert_eq!(set("fat", 1.5).unwrap().inputs[0].1, 1.5);
        assert!(matches!(set("fat", -1.0), Err(RecipeError::Material { .. })));
        assert!(matches!(set("fat", 101.0), Err(RecipeError::Material { .. })));
        assert!(matches!(set("fats", 1.0), Err(RecipeError::NoSuchInput { .. })));
        assert_eq!(parse_setting(" fat = 1.5").unwrap(), ("fat".into(), 1.5));
        for text in ["fat", "fat=abc", "=1", "fat=", "fat=inf"] {
            assert!(parse_setting(text).is_err(), "{text}");
        }
    }

    #[test]
    fn an_unknown_name_offers_the_nearest() {
        let RecipeError::Unknown { help, .. } = Recipe::find("whle-milk").unwrap_err() else { panic!() };
        assert!(help.starts_with("did you mean `whole-milk`"), "{help}");
        assert!(matches!(Recipe::find("nowhere/my.toml"), Err(RecipeError::Read { .. })));
    }

    const EMULSION: &str = r#"
title = "Emulsion"
[host]
substance = "water"
[[inclusion]]
name = "oil"
refractive_index = "1.46+4e-6i"
volume_fraction = 0.04
size_distribution = { kind = "log-normal", weighting = "volume", mean = "1.2 um", deviation = "0.6um" }
[[inclusion]]
substance = "casein"
volume_fraction = 0.02
size_distribution = { kind = "monodisperse", radius = "80 nm" }
"#;

    #[test]
    fn a_mixture_reads() {
        let recipe = Recipe::parse("my", "my.toml", EMULSION).unwrap();
        let material = recipe.material(&BTreeMap::new()).unwrap();
        assert_eq!(material.medium.inclusions().len(), 2);
        assert!(material.inputs.is_empty());
        assert!(recipe.material(&BTreeMap::from([("fat".into(), 1.0)])).is_err());
    }

    /// As [`EMULSION`], with inputs.
    const OIL: &str = r#"[inputs]
oil = { unit = "vol.-%", default = 4, minimum = 0, maximum = 50, about = "oil" }
[derived]
share = "= oil / whole"
whole = "= 10 ^ 2"
[host]
substance = "water"
[[inclusion]]
refractive_index = "1.46"
volume_fraction = "= share"
size_distribution = { kind = "monodisperse", radius = "= (1 + share) / 2 um" }
"#;

    #[test]
    fn a_mixture_has_inputs_of_its_own() {
        let recipe = Recipe::parse("my", "my.toml", OIL).unwrap();
        let oil = |settings: &[(&str, f64)]| {
            let settings = settings.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
            recipe.material(&settings)
        };
        let material = oil(&[("oil", 10.0)]).unwrap();
        let inclusion = &material.medium.inclusions()[0];
        assert_eq!(inclusion.volume_fraction, 0.1);
        assert_eq!(inclusion.sizes, mieux_optics::particle::SizeDistribution::monodisperse(0.55e-6).unwrap());
        assert_eq!((material.inputs[0].1, &*material.inputs[0].0.unit), (10.0, "vol.-%"));
        assert!(oil(&[]).unwrap().medium.inclusions()[0].volume_fraction == 0.04);
        assert!(oil(&[("oil", 0.0)]).unwrap().medium.inclusions().is_empty());
        assert!(matches!(oil(&[("oil", 51.0)]), Err(RecipeError::Material { .. })));
        assert!(matches!(oil(&[("fat", 1.0)]), Err(RecipeError::NoSuchInput { .. })));
    }

    #[test]
    fn mistakes_are_pointed_at() {
        let cases = [
            (EMULSION.replace("volume_fraction = 0.04", "volume_fracton = 0.04"), 8, "unknown field `volume_fracton`"),
            (EMULSION.replace("0.04", "-0.04"), 8, "-0.04"),
            (EMULSION.replace("0.04", "0.99"), 8, "more than 1"),
            (EMULSION.replace("80 nm", "-80 nm"), 13, "-80 nm"),
            (EMULSION.replace("80 nm", "80"), 13, "no unit"),
            (EMULSION.replace("\"casein\"", "\"caesin\""), 11, "no substance called `caesin`"),
            (EMULSION.replace("4e-6i", "-4e-6i"), 7, ""),
            (EMULSION.replace("\"volume\"", "\"mass\""), 9, "weighting"),
            (EMULSION.replace("deviation = \"0.6um\"", "minimum = \"1um\""), 9, "deviation"),
            (EMULSION.replace("\"monodisperse\", ", "\"monodisperse\", mean = \"1um\", "), 13, "`mean`"),
            (EMULSION.replace("title =", "title"), 2, ""),
            ("model = \"milk\"\n[inputs]\nfat = 101\n".into(), 3, "out of range"),
            ("model = \"milk\"\n[inputs]\nfat = \"abc\"\n".into(), 3, ""),
            ("model = \"milk\"\n[inputs]\nfta = 1\n".into(), 3, "no input `fta`"),
            ("model = \"mlik\"\n".into(), 1, "no model called `mlik`"),
            ("model = \"milk\"\n[host]\nsubstance = \"water\"\n".into(), 2, "model"),
            ("title = \"nothing\"\n".into(), 1, "host"),
            (EMULSION.replace("0.04", "\"= oil / 100\""), 8, "`oil` is neither an input"),
            (EMULSION.replace("0.04", "\"= 4 / \""), 8, "the formula `4 /`"),
            (EMULSION.replace("0.04", "\"4\""), 8, "a formula such as"),
            (OIL.replace("default = 4", "default = 400"), 2, "out of range"),
            (OIL.replace("maximum", "most"), 2, "`most`"),
            (OIL.replace("oil =", "exp ="), 2, "a meaning of its own"),
            (OIL.replace("oil =", "\"o-l\" ="), 2, "cannot name an input"),
            (OIL.replace("share = \"= oil", "share = \"= share"), 4, "depends on itself"),
            (OIL.replace("share =", "oil ="), 4, "an input already"),
            (OIL.replace("oil = {", "oil = 3 #"), 2, "declared by a table"),
        ];
        for (text, line, part) in cases {
            let message = message(&text);
            assert!(message.contains(&format!("line {line},")) && message.contains(part), "{message}\n{text}");
        }
    }

    const BREW: &str = r#"index_db = "base"
[host]
substance = "water"
salinity = 10
temperature = 5
solute = [{ name = "riboflavin", concentration = "1.7 mg/L" }]
[[inclusion]]
index_file = "mine.yml"
transparent = true
volume_fraction = 0.01
size_distribution = { kind = "monodisperse", radius = "80 nm" }
[[inclusion]]
index_page = "SiO2/Malitson"
transparent = true
volume_fraction = 0.01
size_distribution = { kind = "monodisperse", radius = "80 nm" }
"#;

    /// The recipe beside the files that it names, which go when it is dropped.
    fn brew(text: &str) -> Result<(tempfile::TempDir, Recipe), RecipeError> {
        let folder = tempfile::tempdir().unwrap();
        let data = folder.path().join("base/data/main");
        std::fs::create_dir_all(&data).unwrap();
        let silica = "DATA:\n- type: formula 5\n  wavelength_range: 0.3 0.8\n  coefficients: 1.46\n";
        std::fs::write(folder.path().join("mine.yml"), silica.replace("1.46", "1.5")).unwrap();
        std::fs::write(folder.path().join("broken.yml"), "DATA:\n- type: tabulated n\n  data: |\n    0.5 x\n").unwrap();
        std::fs::write(data.join("M.yml"), silica).unwrap();
        let catalogue =
            "- SHELF: main\n  content:\n  - BOOK: SiO2\n    content:\n    - PAGE: Malitson\n      data: main/M.yml\n";
        std::fs::write(folder.path().join("base/catalog-nk.yml"), catalogue).unwrap();
        let path = folder.path().join("my.toml");
        std::fs::write(&path, text).unwrap();
        let recipe = Recipe::find(path.to_str().unwrap())?;
        Ok((folder, recipe))
    }

    #[test]
    fn substances_come_from_files_and_pages_and_have_things_dissolved_in_them() {
        let (_folder, recipe) = brew(BREW).unwrap();
        let material = recipe.material(&BTreeMap::new()).unwrap();
        let medium = &material.medium;
        let n = |i: usize| medium.inclusions()[i].substance.index(550e-9).unwrap();
        assert_eq!((n(0).re, n(1).re, n(0).im), (1.5, 1.46, 0.0));
        assert_eq!(medium.host().describe(), "salt water with 0.0017 kg/m^3 riboflavin");
        assert!(medium.host().index(450e-9).unwrap().im > 4e-7);
    }

    #[test]
    fn mistakes_about_substances_are_pointed_at() {
        for (text, line, part) in [
            (BREW.replace("salinity = 10", "salinity = 50"), 4, "salinity 50 g/kg is out of range"),
            (BREW.replace("temperature = 5", "temperature = 50"), 5, "temperature 50 degC is out of range"),
            (BREW.replace("\"water\"", "\"casein\""), 5, "`temperature` does not act on casein"),
            (BREW.replace("riboflavin", "ink"), 6, "no solute called `ink`"),
            (BREW.replace("1.7 mg/L", "1.7 mg"), 6, "`mg`"),
            (BREW.replace("mine.yml", "yours.yml"), 8, "cannot be read"),
            (BREW.replace("mine.yml", "broken.yml"), 8, "line 4, column 5: `x` is not a finite number"),
            (BREW.replace("Malitson", "Malison"), 13, "no page `SiO2/Malison`"),
            (BREW.replace("index_db = \"base\"", ""), 13, "say where it is"),
            (BREW.replace("\"base\"", "\"bass\""), 1, "no refractiveindex.info database"),
            (BREW.replace("index_page =", "index_file = \"mine.yml\"\nindex_page ="), 12, "give one of"),
            (BREW.replace("index_file = \"mine.yml\"", "refractive_index = \"1.5\""), 9, "`transparent` belongs"),
        ] {
            let message = brew(&text).unwrap_err().to_string();
            assert!(message.contains(&format!("my.toml, line {line},")) && message.contains(part), "{message}\n{text}");
        }
    }
}
