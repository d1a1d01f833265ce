//! Scenes as TOML: which materials stand in which glasses. The built-in scenes are such files.

pub mod description;
mod own;
pub(crate) mod transform;

use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use crate::quantity::Size;
use crate::recipe::{MATERIALS, Recipe, RecipeError, as_file, read_text, stem, unknown};
use crate::text_error::TextError;

pub use description::Description;
pub use own::{is_whole_scene, parse_whole_scene};
pub use transform::Transform;

/// Stands for the material that was asked for.
const ASKED_FOR: &str = "*";
/// Most glasses in a row.
const MAX_GLASSES: usize = 20;

/// Name and text of every built-in scene, in alphabetical order.
pub const SCENES: &[(&str, &str)] = &[
    ("glass", include_str!("../../../../data/scenes/glass.toml")),
    ("milk-components", include_str!("../../../../data/scenes/milk-components.toml")),
];

/// Glasses in a row.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneFile {
    /// What to call it in a heading.
    pub title: String,
    /// What it shows, in a sentence.
    pub about: String,
    /// Names or recipe files of the materials, from left to right; at least one. `None` stands for the material that was
    /// asked for.
    pub glasses: Vec<Option<String>>,
    /// Size of the picture unless another is asked for.
    pub size: Size,
}

/// What can be rendered: a material, which goes into a glass, or a scene.
#[derive(Debug, Clone, PartialEq)]
pub enum Subject {
    /// A material by its recipe.
    Material(Box<Recipe>),
    /// Glasses in a row, with the name of their scene.
    Scene(String, SceneFile),
    /// A scene with a camera of its own, with its name.
    Whole(String, Box<Description>),
}

impl Subject {
    /// The built-in material or scene of that name, or what is in the file of that path.
    ///
    /// # Errors
    /// [`RecipeError`], as for [`Recipe::find`].
    pub fn find(name_or_path: &str) -> Result<Self, RecipeError> {
        if let Some(scene) = SceneFile::built_in(name_or_path) {
            return Ok(Self::Scene(name_or_path.into(), scene?));
        }
        if let Some(path) = as_file(name_or_path) {
            let text = read_text(path)?;
            if is_whole_scene(&text) {
                return Ok(Self::Whole(stem(path), Box::new(parse_whole_scene(path, &text)?)));
            }
            if SceneFile::is_scene(&text) {
                let scene = SceneFile::parse(&stem(path), name_or_path, &text)?;
                return Ok(Self::Scene(stem(path), scene.beside(path)));
            }
        } else if !MATERIALS.iter().any(|(name, _)| *name == name_or_path) {
            let names = MATERIALS.iter().chain(SCENES).map(|(name, _)| *name);
            let where_to_look = "`mieux materials` and `mieux scenes` list them all";
            return Err(unknown("material or scene", name_or_path, names, where_to_look));
        }
        Ok(Self::Material(Box::new(Recipe::find(name_or_path)?)))
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    title: Option<String>,
    about: Option<String>,
    glasses: Spanned<Vec<String>>,
    size: Spanned<String>,
}

impl SceneFile {
    /// The built-in scene of that name.
    pub fn built_in(name: &str) -> Option<Result<Self, Box<TextError>>> {
        SCENES.iter().find(|(known, _)| *known == name).map(|(name, text)| Self::parse(name, name, text))
    }

    /// The built-in scene in which a material is shown when no scene is asked for.
    ///
    /// # Errors
    /// Never: the scene is part of the program, and a test reads it.
    pub fn glass() -> Result<Self, RecipeError> {
        Ok(Self::parse("glass", "glass", SCENES[0].1)?)
    }

    /// Takes recipe files named in a scene file to lie beside it.
    fn beside(mut self, path: &Path) -> Self {
        for glass in self.glasses.iter_mut().flatten() {
            if let (Some(file), Some(folder)) = (as_file(glass), path.parent()) {
                *glass = folder.join(file).to_string_lossy().into_owned();
            }
        }
        self
    }

    /// Whether a text looks like a scene rather than a recipe: it has a key `glasses`.
    pub fn is_scene(text: &str) -> bool {
        text.parse::<toml::Table>().is_ok_and(|table| table.contains_key("glasses"))
    }

    /// Reads a scene from its text. `file` names it in errors.
    ///
    /// # Errors
    /// [`TextError`] with the place.
    pub fn parse(name: &str, file: &str, text: &str) -> Result<Self, Box<TextError>> {
        let document: Document = toml::from_str(text).map_err(|e| TextError::from_toml(file, text, &e))?;
        let error = |span, message: String| TextError::new(file, text, span, message);
        let count = document.glasses.get_ref().len();
        if !(1..=MAX_GLASSES).contains(&count) {
            let message = format!("{count} glasses; between 1 and {MAX_GLASSES} can stand in a row");
            return Err(error(document.glasses.span(), message));
        }
        let size = document.size.get_ref().parse().map_err(|e| error(document.size.span(), format!("{e}")))?;
        let glasses = document.glasses.into_inner();
        Ok(Self {
            title: document.title.unwrap_or_else(|| name.into()),
            about: document.about.unwrap_or_default(),
            glasses: glasses.into_iter().map(|g| (g != ASKED_FOR).then_some(g)).collect(),
            size,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recipe::Recipe;

    #[test]
    fn built_in_scenes_read_and_their_materials_exist() {
        for (name, text) in SCENES {
            let scene = SceneFile::built_in(name).unwrap().unwrap();
            assert!(SceneFile::is_scene(text) && !scene.about.is_empty());
            for glass in scene.glasses.iter().flatten() {
                Recipe::find(glass).unwrap();
            }
        }
        assert_eq!(SceneFile::built_in("milk-components").unwrap().unwrap().glasses.len(), 7);
        assert_eq!(SceneFile::glass().unwrap().glasses, [None]);
        assert!(SceneFile::built_in("nowhere").is_none());
        assert!(!SceneFile::is_scene("model = \"milk\""));
    }

    #[test]
    fn mistakes_are_pointed_at() {
        for (text, line) in [
            ("glasses = []\nsize = \"10x10\"", 1),
            ("glasses = [\"water\"]\nsize = \"0x10\"", 2),
            ("glasses = [\"water\"]\nsize = \"10x10\"\ncolour = 1", 3),
        ] {
            assert_eq!(SceneFile::parse("s", "s.toml", text).unwrap_err().line, line, "{text}");
        }
    }
}
