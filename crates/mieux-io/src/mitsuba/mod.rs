//! Scenes of Mitsuba 3, as XML.
//!
//! Read is what stands for the same thing here: cameras `perspective`; film `hdrfilm` with its filters; shapes `obj`, `ply`,
//! `sphere`, `rectangle`, `disk`, `cube`, `cylinder`; surfaces `diffuse`, `conductor`, `dielectric`, `thindielectric`,
//! `roughdielectric`, `null`, `twosided`; lights `area`, `constant`, `envmap`, `point`, `spot`, `directional`; media
//! `homogeneous` and `heterogeneous` with `gridvolume` and `constvolume`; phase functions `hg`, `isotropic`, `rayleigh`,
//! `tabphase`, `blendphase`; spectra; `include`, `default`, `path`, `alias`, `ref`. Everything else is an error with its
//! line and column. Which integrator or sampler is asked for does not matter; how deep its paths go and how many samples it
//! takes do.
//!
//! Scenes of Mitsuba have no unit of length: here it is the metre, and coefficients of media are per metre. Its media have
//! no refractive index of their own, which is 1 here; boundaries carry both of theirs.

mod camera;
mod media;
mod properties;
mod shapes;
mod xml;

use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use properties::{Properties, Result, only};
use xml::{Element, Source};

use crate::scene::description::{Description, Medium};
use crate::text_error::{TextError, did_you_mean, nearest_names};

/// Larger texts are not read, bytes.
const MAX_TEXT: u64 = 16 << 20;
/// Files in files in files: not deeper than this.
const MAX_INCLUDES: usize = 15;
/// Nor more of them in all.
const MAX_FILES: usize = 200;
/// No value grows longer than this by what is put in for its `$names`.
const MAX_VALUE: usize = 16 << 20;
/// A reference to a reference to a reference: not longer than this.
const MAX_REFERENCES: usize = 64;
/// Elements that the main scene itself has.
const SCENE_TAGS: [&str; 12] = [
    "sensor",
    "integrator",
    "shape",
    "bsdf",
    "emitter",
    "medium",
    "phase",
    "default",
    "include",
    "path",
    "alias",
    "spectrum",
];

/// Whether a file looks like one of Mitsuba's: its name ends in `.xml`.
pub fn is_mitsuba(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("xml"))
}

/// Reads a scene. `set` gives values to its `$names`, before its own defaults.
///
/// # Errors
/// [`TextError`], with the place in the file, or in the file it includes.
pub fn read_mitsuba(path: &Path, set: &[(String, String)]) -> Result<Description> {
    let mut loader = Loader {
        values: set.iter().cloned().collect(),
        objects: HashMap::new(),
        top: Vec::new(),
        files: 0,
        folders: Vec::new(),
    };
    let name = path.to_string_lossy().into_owned();
    let text = read_text(path).map_err(|problem| TextError::new(&name, "", 0..0, problem))?;
    loader.file(Rc::new(Source { name, text }), 0)?;
    Importer::new(loader).run(path)
}

fn read_text(path: &Path) -> std::result::Result<String, String> {
    let told = |e: std::io::Error| format!("`{}` cannot be read: {e}", path.display());
    let mut text = String::new();
    File::open(path).map_err(told)?.take(MAX_TEXT + 1).read_to_string(&mut text).map_err(told)?;
    if text.len() as u64 > MAX_TEXT {
        return Err(format!("`{}` is larger than 16 MiB", path.display()));
    }
    Ok(text)
}

/// A file named by an element lies beside the file the element is in.
fn beside(element: &Element, name: &str) -> PathBuf {
    Path::new(&element.source.name).parent().unwrap_or(Path::new("")).join(name)
}

/// Puts files together: includes, values, names.
struct Loader {
    values: HashMap<String, String>,
    objects: HashMap<String, Rc<Element>>,
    top: Vec<Rc<Element>>,
    files: usize,
    folders: Vec<PathBuf>,
}

impl Loader {
    fn file(&mut self, source: Rc<Source>, depth: usize) -> Result<()> {
        let root = xml::parse(&source)?;
        self.files += 1;
        if root.tag != "scene" {
            return Err(root.error(format!("the outermost element is `{}`, and should be `scene`", root.tag)));
        }
        only(&root, &["version"])?;
        let version = root.get("version").ok_or_else(|| root.error("`scene` needs a `version`, such as 3.0.0"))?;
        let major: Option<u32> = version.split('.').next().and_then(|m| m.trim().parse().ok());
        if !major.is_some_and(|m| (2..=3).contains(&m)) {
            let help = "scenes of Mitsuba 2 and 3 are read; Mitsuba 3 itself can upgrade older ones";
            return Err(root.error_at("version", format!("the version is {version}")).with_help(help));
        }
        for child in &root.children {
            self.top_element(child, depth)?;
        }
        Ok(())
    }

    fn top_element(&mut self, child: &Rc<Element>, depth: usize) -> Result<()> {
        if !SCENE_TAGS.contains(&child.tag.as_str()) {
            let near = did_you_mean(&nearest_names(&child.tag, SCENE_TAGS));
            return Err(child.error(format!("a scene has no `{}`", child.tag)).with_help(near));
        }
        if child.tag == "default" {
            only(child, &["name", "value"])?;
            let element = self.filled(child)?;
            let (Some(name), Some(value)) = (element.get("name"), element.get("value")) else {
                return Err(child.error("`default` needs `name` and `value`"));
            };
            self.values.entry(name.to_owned()).or_insert_with(|| value.to_owned());
            return Ok(());
        }
        let element = self.filled(child)?;
        match element.tag.as_str() {
            "include" => {
                only(&element, &["filename"])?;
                let name = element.get("filename").ok_or_else(|| child.error("`include` needs a `filename`"))?;
                if depth >= MAX_INCLUDES || self.files >= MAX_FILES {
                    let message = format!("files include files more than {MAX_INCLUDES} deep, or {MAX_FILES} in all");
                    return Err(child.error(message));
                }
                let path = self.find(&element, name);
                let text = read_text(&path).map_err(|e| child.error_at("filename", e))?;
                let name = path.to_string_lossy().into_owned();
                self.file(Rc::new(Source { name, text }), depth + 1)
            }
            "path" => {
                let value = element.get("value").ok_or_else(|| child.error("`path` needs a `value`"))?;
                self.folders.push(beside(&element, value));
                Ok(())
            }
            "alias" => {
                let (Some(id), Some(other)) = (element.get("id"), element.get("as")) else {
                    return Err(child.error("`alias` needs `id` and `as`"));
                };
                let object = self.objects.get(id).cloned();
                let object = object.ok_or_else(|| child.error_at("id", format!("nothing has the id `{id}`")))?;
                self.objects.insert(other.to_owned(), object);
                Ok(())
            }
            _ => {
                self.names(&element)?;
                self.top.push(element);
                Ok(())
            }
        }
    }

    /// Where a file is: beside the file that names it, or in a folder that a `path` has named.
    fn find(&self, element: &Element, name: &str) -> PathBuf {
        let first = beside(element, name);
        if first.exists() {
            return first;
        }
        self.folders.iter().map(|f| f.join(name)).find(|p| p.exists()).unwrap_or(first)
    }

    /// The element with all `$names` filled in.
    fn filled(&self, element: &Rc<Element>) -> Result<Rc<Element>> {
        let mut copy = Element::clone(element);
        for attribute in &mut copy.attributes {
            if attribute.value.contains('$') {
                attribute.value = self.fill(element, &attribute.name, &attribute.value)?;
            }
        }
        for child in &mut copy.children {
            *child = self.filled(child)?;
        }
        Ok(Rc::new(copy))
    }

    fn fill(&self, element: &Element, attribute: &str, text: &str) -> Result<String> {
        let mut out = String::new();
        let mut rest = text;
        while let Some(at) = rest.find('$') {
            out += &rest[..at];
            rest = &rest[at + 1..];
            let end = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
            let name = &rest[..end];
            let Some(value) = self.values.get(name) else {
                let near = did_you_mean(&nearest_names(name, self.values.keys().map(String::as_str)));
                let help = if near.is_empty() { "a `default` above would give it one".into() } else { near };
                return Err(element.error_at(attribute, format!("`${name}` has no value")).with_help(help));
            };
            out += value;
            if out.len() > MAX_VALUE {
                return Err(element.error_at(attribute, "this grows beyond 16 MiB by what is put in for its names"));
            }
            rest = &rest[end..];
        }
        Ok(out + rest)
    }

    fn names(&mut self, element: &Rc<Element>) -> Result<()> {
        if element.tag != "ref"
            && let Some(id) = element.get("id")
            && let Some(other) = self.objects.insert(id.to_owned(), element.clone())
        {
            let first = other.error("");
            let message = format!("the id `{id}` is taken, in {}, line {}", first.name, first.line);
            return Err(element.error_at("id", message));
        }
        element.children.iter().try_for_each(|c| self.names(c))
    }
}

/// Makes the description.
struct Importer {
    loader: Loader,
    out: Description,
    /// Media by the place of their element.
    media: HashMap<(String, usize), usize>,
    /// Ids in the order of the file.
    grids: usize,
}

impl Importer {
    fn new(loader: Loader) -> Self {
        let out = Description {
            title: String::new(),
            about: String::new(),
            camera: camera::none(),
            materials: Vec::new(),
            media: Vec::new(),
            lights: Vec::new(),
            shapes: Vec::new(),
            notes: Vec::new(),
        };
        Self { loader, out, media: HashMap::new(), grids: 0 }
    }

    fn run(mut self, path: &Path) -> Result<Description> {
        self.out.title = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut sensors = 0;
        let mut max_depth = None;
        for element in std::mem::take(&mut self.loader.top) {
            match element.tag.as_str() {
                "sensor" if sensors == 0 => {
                    sensors = 1;
                    self.camera(&element)?;
                }
                "sensor" => {
                    let place = element.error("");
                    self.out.notes.push(format!("the first camera is used, not the one in line {}", place.line));
                }
                "integrator" => max_depth = self.integrator(&element)?,
                "shape" => self.shape(&element)?,
                "emitter" => self.light(&element)?,
                "medium" => drop(self.medium(&element)?),
                // Looked at where they are referred to; a mistake in one that is not is a mistake all the same.
                "bsdf" => drop(self.finish(&element)?),
                "phase" => drop(self.phase(&element)?),
                _ => {}
            }
        }
        if sensors == 0 {
            let name = path.to_string_lossy();
            let help = "add a `sensor` of type `perspective`";
            return Err(TextError::new(&name, "", 0..0, "there is no camera in the scene").with_help(help));
        }
        self.out.camera.max_depth = max_depth;
        Ok(self.out)
    }

    fn integrator(&mut self, element: &Rc<Element>) -> Result<Option<u32>> {
        const KNOWN: [&str; 5] = ["path", "volpath", "volpathmis", "direct", "moment"];
        let p = Properties::of(element)?;
        if !["path", "volpath", "volpathmis"].contains(&p.kind.as_str()) {
            return Err(p.unsupported(&KNOWN[..3]));
        }
        p.ignore(&["rr_depth", "samples_per_pass", "block_size", "timeout"]);
        if p.boolean("hide_emitters")? == Some(true) {
            self.out.notes.push("lights are not hidden from the camera".into());
        }
        let depth = p.integer("max_depth")?.unwrap_or(-1);
        p.finish()?;
        Ok(u32::try_from(depth).ok())
    }

    /// What a `ref` stands for, or the element itself.
    fn object(&self, element: &Rc<Element>) -> Result<Rc<Element>> {
        let mut at = element.clone();
        for _ in 0..MAX_REFERENCES {
            if at.tag != "ref" {
                return Ok(at);
            }
            only(&at, &["id", "name"])?;
            let id = at.get("id").ok_or_else(|| at.error("`ref` needs an `id`"))?;
            let found = self.loader.objects.get(id).cloned();
            at = found.ok_or_else(|| {
                let near = nearest_names(id, self.loader.objects.keys().map(String::as_str));
                at.error_at("id", format!("nothing has the id `{id}`")).with_help(did_you_mean(&near))
            })?;
        }
        Err(element.error("this refers to itself"))
    }

    /// The medium that a parameter names, put among the media once.
    fn medium_of(&mut self, p: &Properties, name: &'static str) -> Result<Option<usize>> {
        let Some(child) = p.child(name).cloned() else { return Ok(None) };
        let object = self.object(&child)?;
        if object.tag != "medium" {
            return Err(child.error(format!("`{name}` is a `{}`, and should be a `medium`", object.tag)));
        }
        self.medium(&object).map(Some)
    }

    fn medium(&mut self, element: &Rc<Element>) -> Result<usize> {
        let key = (element.source.name.clone(), element.span.start);
        if let Some(&known) = self.media.get(&key) {
            return Ok(known);
        }
        let kind = self.medium_kind(element)?;
        let index = self.out.media.len();
        let name = element.get("id").map_or_else(|| format!("medium {}", index + 1), str::to_owned);
        let place = Properties::of(element)?.place();
        self.out.media.push(Medium { name, kind, place });
        self.media.insert(key, index);
        Ok(index)
    }
}

#[cfg(test)]
mod tests;
