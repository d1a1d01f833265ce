//! Layers on each other, from top to bottom, as TOML.
//!
//! ```toml
//! title = "Milk in a cuvette"   # may be left out
//!
//! [[layer]]
//! pane = 1.52                   # clear, of this refractive index; `tau` if it absorbs
//!
//! [[layer]]
//! material = "whole-milk"       # or a recipe beside this file; `*` is the material asked for
//! set = { fat = 1.5 }
//! thickness = "1mm"
//!
//! [[layer]]
//! albedo = 0.9                  # an abstract medium
//! g = 0.75                      # or `phase`: hg, isotropic, rayleigh, or a file beside this one
//! tau = 2
//! index = 1.4                   # 1 unless given
//! ```

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::Spanned;

use super::phase::PhaseChoice;
use super::{SlabFileError, read_text};
use crate::quantity::Thickness;
use crate::recipe::{Material, Recipe, RecipeError, as_file};
use crate::text_error::TextError;

/// Stands for the material that was asked for.
const ASKED_FOR: &str = "*";
/// More layers than this are taken for a slip of the pen.
const MAX_LAYERS: usize = 1000;

/// What a file of layers says.
#[derive(Debug, Clone, PartialEq)]
pub struct LayersFile {
    /// What to call it in a heading.
    pub title: Option<String>,
    /// From the top down; at least one.
    pub layers: Vec<LayerSpec>,
}

/// One layer.
#[derive(Debug, Clone, PartialEq)]
pub enum LayerSpec {
    /// The material that was asked for, as thick as was asked for.
    AskedFor,
    /// A material.
    Material {
        /// What it is.
        material: Box<Material>,
        /// How thick it is; endless only for the last layer.
        thickness: Thickness,
    },
    /// Something that scatters and absorbs alike at all wavelengths.
    Medium {
        /// Single-scattering albedo, in [0, 1].
        albedo: f64,
        /// Phase function.
        phase: PhaseChoice,
        /// Optical thickness, from 0 up; infinite only for the last layer.
        tau: f64,
        /// Real refractive index.
        index: f64,
    },
    /// Something clear, which may absorb.
    Pane {
        /// Real refractive index.
        index: f64,
        /// Optical thickness, from 0 up.
        tau: f64,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    title: Option<String>,
    #[serde(default)]
    layer: Vec<Spanned<Entry>>,
}

/// All keys a layer may have; which of them belong together is checked by kind.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    material: Option<Spanned<String>>,
    set: Option<Spanned<BTreeMap<String, f64>>>,
    thickness: Option<Spanned<String>>,
    pane: Option<Spanned<f64>>,
    albedo: Option<Spanned<f64>>,
    g: Option<Spanned<f64>>,
    tau: Option<Spanned<f64>>,
    index: Option<Spanned<f64>>,
    phase: Option<Spanned<String>>,
}

const KINDS: &str = "a layer is a material (material, set, thickness), a pane (pane, tau), or an abstract medium (albedo, \
                     g or phase, tau, index)";

/// Reads a file; materials and phase functions in files are looked for beside it.
///
/// # Errors
/// [`SlabFileError`], with line and column.
pub fn read(path: &Path) -> Result<LayersFile, SlabFileError> {
    let text = read_text("layers", path)?;
    Ok(parse(&path.to_string_lossy(), path.parent().unwrap_or(Path::new("")), &text)?)
}

/// Reads a text; `file` names it in errors, and `folder` is where other files are looked for.
///
/// # Errors
/// [`TextError`] with the place.
pub fn parse(file: &str, folder: &Path, text: &str) -> Result<LayersFile, Box<TextError>> {
    let document: Document = toml::from_str(text).map_err(|e| TextError::from_toml(file, text, &e))?;
    let count = document.layer.len();
    if !(1..=MAX_LAYERS).contains(&count) {
        let message = format!("{count} layers; from 1 to {MAX_LAYERS} can lie on each other");
        return Err(TextError::new(file, text, 0..0, message).with_help(format!("[[layer]] begins one; {KINDS}")));
    }
    let reader = Reader { file, folder, text };
    let layers = document.layer.iter().enumerate().map(|(i, entry)| reader.layer(entry, i + 1 == count));
    Ok(LayersFile { title: document.title, layers: layers.collect::<Result<_, _>>()? })
}

struct Reader<'a> {
    file: &'a str,
    folder: &'a Path,
    text: &'a str,
}

impl Reader<'_> {
    fn error(&self, span: Range<usize>, message: impl ToString) -> Box<TextError> {
        TextError::new(self.file, self.text, span, message.to_string())
    }

    fn layer(&self, entry: &Spanned<Entry>, last: bool) -> Result<LayerSpec, Box<TextError>> {
        let spec = entry.get_ref();
        match (&spec.material, &spec.pane, &spec.albedo) {
            (Some(name), None, None) => self.material(entry, name, last),
            (None, Some(index), None) => {
                self.only(spec, "a pane", &["tau"])?;
                Ok(LayerSpec::Pane {
                    index: self.index(index)?,
                    tau: self.tau(spec.tau.as_ref(), false)?.unwrap_or(0.0),
                })
            }
            (None, None, Some(albedo)) => self.medium(entry, albedo, last),
            _ => {
                let message = "a layer has exactly one of `material`, `pane` and `albedo`";
                Err(self.error(entry.span(), message).with_help(KINDS))
            }
        }
    }

    fn material(
        &self,
        entry: &Spanned<Entry>,
        name: &Spanned<String>,
        last: bool,
    ) -> Result<LayerSpec, Box<TextError>> {
        let spec = entry.get_ref();
        if name.get_ref() == ASKED_FOR {
            self.only(spec, "the material asked for, `*`", &[])?;
            return Ok(LayerSpec::AskedFor);
        }
        self.only(spec, "a material", &["set", "thickness"])?;
        let Some(thickness) = &spec.thickness else {
            return Err(self.error(name.span(), "this layer has no `thickness`; give one, as in thickness = \"1mm\""));
        };
        let span = thickness.span();
        let thickness: Thickness = thickness.get_ref().parse().map_err(|e| self.error(span.clone(), e))?;
        if thickness == Thickness::Infinite && !last {
            return Err(self.error(span, "only the last layer can be endless"));
        }
        let found = match as_file(name.get_ref()) {
            Some(path) => Recipe::find(&self.folder.join(path).to_string_lossy()),
            None => Recipe::find(name.get_ref()),
        };
        let recipe = found.map_err(|e| self.recipe_error(name.span(), e))?;
        let none = BTreeMap::new();
        let (set, at) = spec.set.as_ref().map_or((&none, name.span()), |set| (set.get_ref(), set.span()));
        let material = recipe.material(set).map_err(|e| self.recipe_error(at, e))?;
        Ok(LayerSpec::Material { material: Box::new(material), thickness })
    }

    fn medium(&self, entry: &Spanned<Entry>, albedo: &Spanned<f64>, last: bool) -> Result<LayerSpec, Box<TextError>> {
        let spec = entry.get_ref();
        self.only(spec, "an abstract medium", &["albedo", "g", "tau", "index", "phase"])?;
        if !(0.0..=1.0).contains(albedo.get_ref()) {
            let message = format!("the albedo {} is not between 0 and 1", albedo.get_ref());
            return Err(self.error(albedo.span(), message));
        }
        let Some(tau) = self.tau(spec.tau.as_ref(), last)? else {
            return Err(self.error(entry.span(), "an abstract medium needs its optical thickness, `tau`"));
        };
        let word = spec.phase.as_ref().map_or("hg", |phase| phase.get_ref());
        let phase = match (word, &spec.g) {
            ("hg", Some(g)) if g.get_ref().abs() < 1.0 => PhaseChoice::Hg { g: *g.get_ref() },
            ("hg", Some(g)) => {
                let message = format!("asymmetry g = {} is not between -1 and 1 (both excluded)", g.get_ref());
                return Err(self.error(g.span(), message));
            }
            ("hg", None) => {
                let message = "the phase function `hg` needs `g`; or give `phase`: isotropic, rayleigh, or a file";
                return Err(self.error(entry.span(), message));
            }
            (word, Some(g)) => return Err(self.error(g.span(), format!("the phase function `{word}` takes no `g`"))),
            ("isotropic", None) => PhaseChoice::Isotropic,
            ("rayleigh", None) => PhaseChoice::Rayleigh,
            (path, None) => PhaseChoice::File(self.folder.join(PathBuf::from(path))),
        };
        let index = spec.index.as_ref().map_or(Ok(1.0), |index| self.index(index))?;
        Ok(LayerSpec::Medium { albedo: *albedo.get_ref(), phase, tau, index })
    }

    fn index(&self, index: &Spanned<f64>) -> Result<f64, Box<TextError>> {
        let value = *index.get_ref();
        if (0.1..=10.0).contains(&value) {
            return Ok(value);
        }
        Err(self.error(index.span(), format!("the refractive index {value} is not between 0.1 and 10")))
    }

    fn tau(&self, tau: Option<&Spanned<f64>>, endless: bool) -> Result<Option<f64>, Box<TextError>> {
        let Some(tau) = tau else { return Ok(None) };
        let value = *tau.get_ref();
        if value >= 0.0 && (value.is_finite() || endless) {
            return Ok(Some(value.abs()));
        }
        let allowed = if endless { "or inf" } else { "only an abstract medium that is the last layer can be endless" };
        Err(self
            .error(tau.span(), format!("the optical thickness {value} is not a finite number from 0 up; {allowed}")))
    }

    /// Refuses keys that have no meaning for the kind.
    fn only(&self, spec: &Entry, kind: &str, allowed: &[&str]) -> Result<(), Box<TextError>> {
        let numbers = [("albedo", &spec.albedo), ("g", &spec.g), ("tau", &spec.tau), ("index", &spec.index)];
        let given = numbers.iter().filter_map(|(name, value)| value.as_ref().map(|value| (*name, value.span())));
        let given = given.chain(spec.set.as_ref().map(|value| ("set", value.span())));
        let given = given.chain(spec.thickness.as_ref().map(|value| ("thickness", value.span())));
        let mut given = given.chain(spec.phase.as_ref().map(|value| ("phase", value.span())));
        match given.find(|(name, _)| !allowed.contains(name)) {
            Some((name, span)) => Err(self.error(span, format!("`{name}` has no meaning for {kind}")).with_help(KINDS)),
            None => Ok(()),
        }
    }

    fn recipe_error(&self, span: Range<usize>, error: RecipeError) -> Box<TextError> {
        let message = self.error(span, &error);
        match error {
            RecipeError::Unknown { help, .. } | RecipeError::NoSuchInput { help, .. } => message.with_help(help),
            _ => message,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CUVETTE: &str = r#"
[[layer]]
pane = 1.52
[[layer]]
material = "whole-milk"
set = { fat = 1.5 }
thickness = "1mm"
[[layer]]
albedo = 0.9
g = 0.75
tau = 2
index = 1.4
[[layer]]
material = "*"
"#;

    fn read(text: &str) -> Result<LayersFile, Box<TextError>> {
        parse("l.toml", Path::new("there"), text)
    }

    #[test]
    fn every_kind_of_layer_reads() {
        let file = read(CUVETTE).unwrap();
        assert_eq!(file.layers.len(), 4);
        assert_eq!(file.layers[0], LayerSpec::Pane { index: 1.52, tau: 0.0 });
        let LayerSpec::Material { material, thickness } = &file.layers[1] else { panic!() };
        assert_eq!((material.inputs[0].1, thickness.metres()), (1.5, 1e-3));
        let hg = PhaseChoice::Hg { g: 0.75 };
        assert_eq!(file.layers[2], LayerSpec::Medium { albedo: 0.9, phase: hg, tau: 2.0, index: 1.4 });
        assert_eq!(file.layers[3], LayerSpec::AskedFor);
        let LayerSpec::Medium { phase, tau, .. } =
            &read("[[layer]]\nalbedo = 1\ntau = inf\nphase = \"p.csv\"").unwrap().layers[0]
        else {
            panic!()
        };
        assert_eq!((phase, *tau), (&PhaseChoice::File("there/p.csv".into()), f64::INFINITY));
    }

    #[test]
    fn mistakes_are_pointed_at() {
        let cases = [
            (CUVETTE.replace("albedo = 0.9", "albedo = 1.9"), 9, "1.9"),
            (CUVETTE.replace("g = 0.75", "g = 1"), 10, "g = 1"),
            (CUVETTE.replace("g = 0.75\n", ""), 8, "needs `g`"),
            (CUVETTE.replace("g = 0.75", "g = 0.75\nphase = \"rayleigh\""), 10, "takes no `g`"),
            (CUVETTE.replace("tau = 2", "tau = -2"), 11, "-2"),
            (CUVETTE.replace("tau = 2", "tau = inf"), 11, "inf"),
            (CUVETTE.replace("tau = 2\n", ""), 8, "needs its optical thickness"),
            (CUVETTE.replace("index = 1.4", "index = 14"), 12, "14"),
            (CUVETTE.replace("1mm", "-1mm"), 7, "-1mm"),
            (CUVETTE.replace("1mm", "1"), 7, "no unit"),
            (CUVETTE.replace("1mm", "inf"), 7, "endless"),
            (CUVETTE.replace("thickness = \"1mm\"", ""), 5, "no `thickness`"),
            (CUVETTE.replace("whole-milk", "whle-milk"), 5, "whle-milk"),
            (CUVETTE.replace("fat = 1.5", "fta = 1.5"), 6, "no input `fta`"),
            (CUVETTE.replace("fat = 1.5", "fat = 150"), 6, "150"),
            (CUVETTE.replace("pane = 1.52", "pane = 1.52\ng = 0.5"), 4, "`g` has no meaning"),
            (CUVETTE.replace("pane = 1.52", "glass = 1.52"), 3, "unknown field `glass`"),
            (CUVETTE.replace("pane = 1.52", "tau = 1"), 2, "exactly one"),
            (CUVETTE.replace("pane = 1.52", "pane = 1.52\nalbedo = 0.5"), 2, "exactly one"),
            (CUVETTE.replace("\"*\"", "\"*\"\nthickness = \"1mm\""), 15, "`thickness` has no meaning"),
            ("title = \"none\"\n".to_owned(), 1, "0 layers"),
        ];
        for (text, line, part) in cases {
            let error = read(&text).unwrap_err();
            assert!(error.line == line && error.message.contains(part), "{error}\n{text}");
        }
        assert!(read(&CUVETTE.replace("whole-milk", "whle-milk")).unwrap_err().help.unwrap().contains("whole-milk"));
    }
}
