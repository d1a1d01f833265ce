//! What is said about one object, with a check that all of it was understood.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use super::xml::Element;
use crate::scene::Transform;
use crate::scene::description::{Outside, Place, RgbKind, Spectrum};
use crate::scene::transform::norm;
use crate::text_error::{TextError, did_you_mean, nearest_names};

pub(super) type Result<T> = std::result::Result<T, Box<TextError>>;

/// An element that makes an object, such as `shape` or `bsdf`.
pub(super) struct Properties {
    pub element: Rc<Element>,
    /// The plugin.
    pub kind: String,
    used: Vec<Cell<bool>>,
    asked: RefCell<Vec<&'static str>>,
}

impl Properties {
    pub fn of(element: &Rc<Element>) -> Result<Self> {
        let tag = &element.tag;
        let kind = element.get("type").ok_or_else(|| element.error(format!("`{tag}` needs a `type`")))?;
        let used = element.children.iter().map(|_| Cell::new(false)).collect();
        Ok(Self { element: element.clone(), kind: kind.to_owned(), used, asked: RefCell::default() })
    }

    pub fn place(&self) -> Place {
        let error = self.element.error("");
        Place { file: error.name.clone(), line: error.line, column: error.column }
    }

    /// The child of that name, of any tag.
    pub fn child(&self, name: &'static str) -> Option<&Rc<Element>> {
        self.asked.borrow_mut().push(name);
        let (child, used) = self.element.children.iter().zip(&self.used).find(|(c, _)| c.get("name") == Some(name))?;
        used.set(true);
        Some(child)
    }

    /// All children with one of these tags that have not been asked for, which now they have.
    pub fn rest(&self, tags: &[&str]) -> Vec<Rc<Element>> {
        let mut found = Vec::new();
        for (child, used) in self.element.children.iter().zip(&self.used) {
            if !used.get() && tags.contains(&child.tag.as_str()) {
                used.set(true);
                found.push(child.clone());
            }
        }
        found
    }

    /// Lets anything of that name be, whatever it says.
    pub fn ignore(&self, names: &[&'static str]) {
        for name in names {
            self.child(name);
        }
    }

    /// Nothing may be left that was not asked for.
    pub fn finish(&self) -> Result<()> {
        for (child, used) in self.element.children.iter().zip(&self.used) {
            if used.get() {
                continue;
            }
            let (tag, kind) = (&self.element.tag, &self.kind);
            let known = self.asked.borrow();
            let Some(name) = child.get("name") else {
                return Err(child.error(format!("the {tag} `{kind}` can have no `{}` here", child.tag)));
            };
            let error =
                child.error_at("name", format!("the parameter `{name}` of the {tag} `{kind}` is not supported"));
            let near = did_you_mean(&nearest_names(name, known.iter().copied()));
            return Err(if near.is_empty() && !known.is_empty() {
                error.with_help(format!("known here: {}", known.join(", ")))
            } else {
                error.with_help(near)
            });
        }
        Ok(())
    }

    /// Of a kind that is known but not supported, or unknown.
    pub fn unsupported(&self, known: &[&str]) -> Box<TextError> {
        let (tag, kind) = (&self.element.tag, &self.kind);
        let near = did_you_mean(&nearest_names(kind, known.iter().copied()));
        let help = format!("supported: {}", known.join(", "));
        let error = self.element.error_at("type", format!("the {tag} `{kind}` is not supported"));
        error.with_help(if near.is_empty() { help } else { format!("{near} {help}") })
    }

    fn value<'a>(&self, child: &'a Element, tags: &[&str]) -> Result<&'a str> {
        let name = child.get("name").unwrap_or_default();
        if !tags.contains(&child.tag.as_str()) {
            let message = format!("`{name}` is a `{}`, and should be a `{}`", child.tag, tags[0]);
            return Err(child.error(message));
        }
        only(child, &["name", "value"])?;
        child.get("value").ok_or_else(|| child.error(format!("`{name}` has no `value`")))
    }

    pub fn float(&self, name: &'static str) -> Result<Option<f64>> {
        let Some(child) = self.child(name) else { return Ok(None) };
        number(child, "value", self.value(child, &["float", "integer"])?).map(Some)
    }

    /// A number that `allowed` says yes to; `range` says which those are.
    pub fn float_in(
        &self,
        name: &'static str,
        default: f64,
        range: &str,
        allowed: impl Fn(f64) -> bool,
    ) -> Result<f64> {
        let value = self.float(name)?.unwrap_or(default);
        if allowed(value) {
            return Ok(value);
        }
        let child = self.child(name).unwrap_or(&self.element);
        Err(child.error_at("value", format!("`{name}` is {value}, and should be {range}")))
    }

    pub fn integer(&self, name: &'static str) -> Result<Option<i64>> {
        let Some(child) = self.child(name) else { return Ok(None) };
        let value = self.value(child, &["integer"])?;
        let wrong = |_| child.error_at("value", format!("`{value}` is not a whole number"));
        value.trim().parse().map(Some).map_err(wrong)
    }

    pub fn boolean(&self, name: &'static str) -> Result<Option<bool>> {
        let Some(child) = self.child(name) else { return Ok(None) };
        match self.value(child, &["boolean"])?.trim().to_lowercase().as_str() {
            "true" => Ok(Some(true)),
            "false" => Ok(Some(false)),
            other => Err(child.error_at("value", format!("`{other}` is neither `true` nor `false`"))),
        }
    }

    pub fn string(&self, name: &'static str) -> Result<Option<String>> {
        let Some(child) = self.child(name) else { return Ok(None) };
        Ok(Some(self.value(child, &["string"])?.to_owned()))
    }

    pub fn vector(&self, name: &'static str) -> Result<Option<[f64; 3]>> {
        let Some(child) = self.child(name) else { return Ok(None) };
        if !["point", "vector"].contains(&child.tag.as_str()) {
            return Err(child.error(format!("`{name}` is a `{}`, and should be a `point`", child.tag)));
        }
        only(child, &["name", "value", "x", "y", "z"])?;
        axes(child, None).map(Some)
    }

    pub fn transform(&self, name: &'static str) -> Result<Transform> {
        let Some(child) = self.child(name) else { return Ok(Transform::IDENTITY) };
        if child.tag != "transform" {
            return Err(child.error(format!("`{name}` is a `{}`, and should be a `transform`", child.tag)));
        }
        transform(child)
    }

    /// What shines, in sRGB stands for an illuminant; else for `kind`.
    pub fn spectrum(&self, name: &'static str, kind: RgbKind) -> Result<Option<Spectrum>> {
        self.child(name).map(|child| spectrum(child, kind)).transpose()
    }
}

/// No attributes but these.
pub(super) fn only(element: &Element, known: &[&str]) -> Result<()> {
    match element.attributes.iter().find(|a| !known.contains(&a.name.as_str())) {
        None => Ok(()),
        Some(a) => {
            let message = format!("`{}` has no attribute `{}`", element.tag, a.name);
            let near = did_you_mean(&nearest_names(&a.name, known.iter().copied()));
            Err(element.error_at(&a.name, message).with_help(near))
        }
    }
}

fn number(element: &Element, attribute: &str, text: &str) -> Result<f64> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(element.error_at(attribute, format!("`{}` is not a number", text.trim()))),
    }
}

/// Numbers with spaces or commas between them.
pub(super) fn numbers(element: &Element, attribute: &str) -> Result<Vec<f64>> {
    let text = element.get(attribute);
    let text = text.ok_or_else(|| element.error(format!("`{}` needs `{attribute}`", element.tag)))?;
    let parts = text.split(|c: char| c == ',' || c.is_whitespace()).filter(|p| !p.is_empty());
    parts.map(|p| number(element, attribute, p)).collect()
}

fn triple(element: &Element, attribute: &str) -> Result<[f64; 3]> {
    let found = numbers(element, attribute)?;
    <[f64; 3]>::try_from(found.as_slice())
        .map_err(|_| element.error_at(attribute, format!("{} numbers where three should be", found.len())))
}

/// `value="1, 2, 3"` or `x="1" y="2" z="3"`; what is missing is `default`, or an error.
fn axes(element: &Element, default: Option<f64>) -> Result<[f64; 3]> {
    if element.get("value").is_some() {
        return match numbers(element, "value")?.as_slice() {
            &[x, y, z] => Ok([x, y, z]),
            &[all] if element.tag == "scale" => Ok([all; 3]),
            other => Err(element.error_at("value", format!("{} numbers where three should be", other.len()))),
        };
    }
    let mut found = [0.0; 3];
    for (axis, name) in found.iter_mut().zip(["x", "y", "z"]) {
        *axis = match (element.get(name), default) {
            (Some(text), _) => number(element, name, text)?,
            (None, Some(default)) => default,
            (None, None) => return Err(element.error(format!("`{}` needs `{name}`", element.tag))),
        };
    }
    Ok(found)
}

/// One step after the other.
fn transform(element: &Element) -> Result<Transform> {
    only(element, &["name"])?;
    let mut whole = Transform::IDENTITY;
    for step in &element.children {
        let known: &[&str] = match step.tag.as_str() {
            "translate" | "scale" => &["x", "y", "z", "value"],
            "rotate" => &["x", "y", "z", "value", "angle"],
            "lookat" => &["origin", "target", "up"],
            "matrix" => &["value"],
            other => {
                let help = "supported: translate, scale, rotate, lookat, matrix";
                return Err(step.error(format!("`{other}` is no step of a transform")).with_help(help));
            }
        };
        only(step, known)?;
        let next = match step.tag.as_str() {
            "translate" => Transform::translate(axes(step, Some(0.0))?),
            "scale" => Transform::scale(axes(step, Some(1.0))?),
            "rotate" => {
                let angle = step.get("angle").ok_or_else(|| step.error("`rotate` needs an `angle` in degrees"))?;
                let angle = number(step, "angle", angle)?.to_radians();
                let axis = axes(step, Some(0.0))?;
                if (norm(axis) - 1.0).abs() > 1e-4 {
                    // Mitsuba 3.9 does not normalise it, and shears what it should turn.
                    let message = format!("the axis of the rotation is {} long, and should be 1", norm(axis));
                    return Err(step.error(message).with_help("Mitsuba does not make it 1, and would shear"));
                }
                Transform::rotate(axis, angle).ok_or_else(|| step.error("this axis has no length"))?
            }
            "lookat" => {
                let up = if step.get("up").is_some() { triple(step, "up")? } else { [0.0, 1.0, 0.0] };
                let pose = Transform::look_at(triple(step, "origin")?, triple(step, "target")?, up);
                pose.ok_or_else(|| step.error("`origin` is `target`, or `up` points along the line between them"))?
            }
            _ => matrix(step)?,
        };
        whole = whole.then(&next);
    }
    if !whole.is_affine_and_invertible() {
        return Err(element.error("this transform flattens or projects, and cannot be undone"));
    }
    Ok(whole)
}

fn matrix(step: &Element) -> Result<Transform> {
    let values = numbers(step, "value")?;
    let size = match values.len() {
        16 => 4,
        9 => 3,
        n => return Err(step.error_at("value", format!("{n} numbers where 16 or 9 should be"))),
    };
    let mut m = Transform::IDENTITY;
    for (i, row) in values.chunks(size).enumerate() {
        m.0[i][..size].copy_from_slice(row);
    }
    Ok(m)
}

/// A spectrum in any of the ways to write one.
pub(super) fn spectrum(element: &Rc<Element>, kind: RgbKind) -> Result<Spectrum> {
    let reads = match element.tag.as_str() {
        "float" | "integer" => {
            only(element, &["name", "value"])?;
            let value = one(element)?;
            // A number for a light is a white one.
            match kind {
                RgbKind::Illuminant => Spectrum::Rgb { rgb: [value; 3], kind },
                _ => Spectrum::Constant(value),
            }
        }
        "rgb" => {
            only(element, &["name", "value"])?;
            let found = numbers(element, "value")?;
            let rgb = match found.as_slice() {
                [all] => [*all; 3],
                [r, g, b] => [*r, *g, *b],
                _ => return Err(element.error_at("value", format!("{} numbers where three should be", found.len()))),
            };
            Spectrum::Rgb { rgb, kind }
        }
        "spectrum" if element.get("type").is_some() => plugin(element)?,
        "spectrum" => {
            only(element, &["name", "value", "filename"])?;
            match (element.get("value"), element.get("filename")) {
                (Some(text), None) if text.contains(':') => pairs(element, text)?,
                (Some(_), None) => Spectrum::Constant(one(element)?),
                (None, Some(name)) => file(element, name)?,
                _ => return Err(element.error("a `spectrum` needs either `value` or `filename`")),
            }
        }
        "texture" => {
            let help = "write a `spectrum` or an `rgb` in its place";
            return Err(element.error("textures are not supported").with_help(help));
        }
        other => return Err(element.error(format!("a `{other}` is not a spectrum"))),
    };
    let values: Vec<f64> = match &reads {
        Spectrum::Constant(value) => vec![*value],
        Spectrum::Sampled { nodes, .. } => nodes.iter().map(|n| n.1).collect(),
        Spectrum::Rgb { rgb, .. } => rgb.to_vec(),
        Spectrum::Blackbody { scale, .. } | Spectrum::D65 { scale } => vec![*scale],
    };
    if let Some(low) = values.iter().find(|&&v| v < 0.0) {
        return Err(element.error(format!("a spectrum cannot be negative, as here: {low}")));
    }
    if let (RgbKind::Reflectance, Some(high)) = (kind, values.iter().find(|&&v| v > 1.0)) {
        return Err(element.error(format!("this is a share of the light, and cannot be more than 1, as here: {high}")));
    }
    Ok(reads)
}

fn one(element: &Element) -> Result<f64> {
    match numbers(element, "value")?.as_slice() {
        &[value] => Ok(value),
        other => Err(element.error_at("value", format!("{} numbers where one should be", other.len()))),
    }
}

fn sampled(element: &Element, nodes: Vec<(f64, f64)>) -> Result<Spectrum> {
    let nodes: Vec<_> = nodes.into_iter().map(|(nm, value)| (nm * 1e-9, value)).collect();
    if nodes.len() < 2 || nodes[0].0 <= 0.0 || nodes.windows(2).any(|w| w[1].0 <= w[0].0) {
        return Err(element.error("a spectrum needs at least two wavelengths, in nanometres and ascending"));
    }
    Ok(Spectrum::Sampled { nodes, outside: Outside::Zero })
}

/// `400:0.1, 700:0.2`, wavelengths in nanometres.
fn pairs(element: &Element, text: &str) -> Result<Spectrum> {
    let parts = text.split(|c: char| c == ',' || c.is_whitespace()).filter(|p| !p.is_empty());
    let pair = |p: &str| {
        let wrong = || element.error_at("value", format!("`{p}` is not `wavelength:value`"));
        let (nm, value) = p.split_once(':').ok_or_else(wrong)?;
        Ok((number(element, "value", nm)?, number(element, "value", value)?))
    };
    sampled(element, parts.map(pair).collect::<Result<_>>()?)
}

/// Lines of a wavelength in nanometres and a value.
fn file(element: &Rc<Element>, name: &str) -> Result<Spectrum> {
    let path = super::beside(element, name);
    let text = super::read_text(&path).map_err(|e| element.error_at("filename", e))?;
    let mut nodes = Vec::new();
    for (row, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.is_empty() {
            continue;
        }
        let wrong = || element.error_at("filename", format!("line {} of `{name}` is not two numbers", row + 1));
        let found: Vec<f64> =
            line.split_whitespace().map(|p| p.parse()).collect::<std::result::Result<_, _>>().map_err(|_| wrong())?;
        match found.as_slice() {
            &[nm, value] if nm.is_finite() && value.is_finite() => nodes.push((nm, value)),
            _ => return Err(wrong()),
        }
    }
    sampled(element, nodes)
}

fn plugin(element: &Rc<Element>) -> Result<Spectrum> {
    let p = Properties::of(element)?;
    only(element, &["type", "name", "id"])?;
    let list = |name: &'static str| -> Result<Vec<f64>> {
        let child = p.child(name).ok_or_else(|| element.error(format!("`{}` needs `{name}`", p.kind)))?;
        numbers(child, "value")
    };
    let positive = |v: f64| v > 0.0;
    let reads = match p.kind.as_str() {
        "uniform" => Spectrum::Constant(p.float("value")?.unwrap_or(1.0)),
        "d65" => Spectrum::D65 { scale: p.float("scale")?.unwrap_or(1.0) },
        "blackbody" => Spectrum::Blackbody {
            temperature: p.float_in("temperature", 5000.0, "more than 0 kelvin", positive)?,
            scale: 1.0,
        },
        "regular" => {
            let (from, to) = match p.child("range") {
                Some(range) => match numbers(range, "value")?.as_slice() {
                    &[from, to] => (from, to),
                    _ => return Err(range.error_at("value", "`range` should be two wavelengths")),
                },
                None => (
                    p.float_in("wavelength_min", 360.0, "more than 0 nm", positive)?,
                    p.float_in("wavelength_max", 830.0, "more than 0 nm", positive)?,
                ),
            };
            let values = list("values")?;
            let step = (to - from) / (values.len().max(2) - 1) as f64;
            sampled(element, values.into_iter().enumerate().map(|(i, v)| (from + step * i as f64, v)).collect())?
        }
        "irregular" => {
            let (wavelengths, values) = (list("wavelengths")?, list("values")?);
            if wavelengths.len() != values.len() {
                let (w, v) = (wavelengths.len(), values.len());
                return Err(element.error(format!("{w} wavelengths and {v} values")));
            }
            sampled(element, wavelengths.into_iter().zip(values).collect())?
        }
        _ => return Err(p.unsupported(&["uniform", "regular", "irregular", "d65", "blackbody"])),
    };
    p.finish()?;
    Ok(reads)
}
