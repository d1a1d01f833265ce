//! The shape of a recipe file, and the way from it to a medium, every mistake pointed at.

use std::collections::BTreeMap;
use std::ops::Range;

use mieux_optics::material::milk::Milk;
use mieux_optics::medium::{Inclusion, Medium};
use mieux_optics::substance::Substance;
use serde::Deserialize;
use toml::Spanned;

use super::sizes::{SizeSpec, size_distribution};
use super::{Kind, Recipe};
use crate::quantity::parse_complex_index;
use crate::text_error::{TextError, did_you_mean, nearest_names};

/// Temperature of a mixture that does not name one, degrees Celsius.
const ROOM_TEMPERATURE: f64 = 20.0;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    title: Option<String>,
    about: Option<String>,
    model: Option<Spanned<String>>,
    inputs: Option<Spanned<BTreeMap<Spanned<String>, Spanned<f64>>>>,
    temperature: Option<Spanned<f64>>,
    host: Option<Spanned<SubstanceSpec>>,
    #[serde(default)]
    inclusion: Vec<Spanned<InclusionSpec>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SubstanceSpec {
    substance: Option<Spanned<String>>,
    refractive_index: Option<Spanned<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct InclusionSpec {
    name: Option<String>,
    substance: Option<Spanned<String>>,
    refractive_index: Option<Spanned<String>>,
    volume_fraction: Spanned<f64>,
    size_distribution: Spanned<SizeSpec>,
}

/// A text under its name, to make errors of places in it.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    file: &'a str,
    text: &'a str,
}

impl Source<'_> {
    pub(super) fn error(&self, span: Range<usize>, message: impl ToString) -> Box<TextError> {
        TextError::new(self.file, self.text, span, message.to_string())
    }
}

/// Reads a recipe; `file` names it in errors.
pub(super) fn read(name: &str, file: &str, text: &str) -> Result<Recipe, Box<TextError>> {
    let source = Source { file, text };
    let document: Document = toml::from_str(text).map_err(|e| TextError::from_toml(file, text, &e))?;
    let kind = match &document.model {
        Some(model) => read_model(source, model, &document)?,
        None => Kind::Mixture(read_mixture(source, &document)?),
    };
    Ok(Recipe {
        name: name.into(),
        title: document.title.unwrap_or_else(|| name.into()),
        about: document.about.unwrap_or_default(),
        kind,
    })
}

fn read_model(source: Source<'_>, model: &Spanned<String>, document: &Document) -> Result<Kind, Box<TextError>> {
    if model.get_ref() != "milk" {
        let message = format!("there is no model called `{}`", model.get_ref());
        return Err(source.error(model.span(), message).with_help("models: milk"));
    }
    let misplaced = document.host.as_ref().map(Spanned::span);
    let misplaced = misplaced.or_else(|| document.inclusion.first().map(Spanned::span));
    if let Some(span) = misplaced.or_else(|| document.temperature.as_ref().map(Spanned::span)) {
        let message = "a recipe with a `model` takes everything else from its `[inputs]`";
        return Err(source.error(span, message));
    }
    let mut values = Milk::INPUTS.map(|input| input.default);
    for (name, value) in document.inputs.iter().flat_map(|inputs| inputs.get_ref()) {
        let Some(index) = Milk::INPUTS.iter().position(|input| input.name == name.get_ref()) else {
            let known = Milk::INPUTS.map(|input| input.name);
            let message = format!("the model milk has no input `{}`", name.get_ref());
            return Err(source.error(name.span(), message).with_help(format!("inputs: {}", known.join(", "))));
        };
        values[index] = Milk::INPUTS[index].check(*value.get_ref()).map_err(|e| source.error(value.span(), e))?;
    }
    Ok(Kind::Milk(values))
}

fn read_mixture(source: Source<'_>, document: &Document) -> Result<Medium, Box<TextError>> {
    if let Some(inputs) = &document.inputs {
        return Err(source.error(inputs.span(), "`[inputs]` belongs to a recipe with a `model`"));
    }
    let Some(host) = &document.host else {
        let message = "a recipe needs either a `model` or a `[host]`";
        let help = "for example: model = \"milk\", or [host] with substance = \"water\"";
        return Err(source.error(0..0, message).with_help(help));
    };
    let temperature = match &document.temperature {
        Some(value) if !(0.0..=30.0).contains(value.get_ref()) => {
            let message = format!("temperature {} degC is out of range: 0 to 30 degC", value.get_ref());
            return Err(source.error(value.span(), message));
        }
        Some(value) => *value.get_ref(),
        None => ROOM_TEMPERATURE,
    };
    let spec = host.get_ref();
    let index = spec.refractive_index.as_ref();
    let host = read_substance(source, host.span(), spec.substance.as_ref(), index, temperature)?;
    let mut inclusions = Vec::new();
    for entry in &document.inclusion {
        inclusions.push(read_inclusion(source, entry, temperature)?);
    }
    let span = document.inclusion.first().map_or(0..0, Spanned::span);
    Medium::new(host, inclusions).map_err(|e| source.error(span, e))
}

fn read_inclusion(
    source: Source<'_>,
    entry: &Spanned<InclusionSpec>,
    temperature: f64,
) -> Result<Inclusion, Box<TextError>> {
    let spec = entry.get_ref();
    let index = spec.refractive_index.as_ref();
    let substance = read_substance(source, entry.span(), spec.substance.as_ref(), index, temperature)?;
    let volume_fraction = *spec.volume_fraction.get_ref();
    if !(0.0..=1.0).contains(&volume_fraction) {
        let message = format!("the volume fraction {volume_fraction} must lie between 0 and 1");
        return Err(source.error(spec.volume_fraction.span(), message));
    }
    let sizes = size_distribution(source, &spec.size_distribution)?;
    let name = spec.name.clone().unwrap_or_else(|| format!("{} particles", substance.name()));
    Ok(Inclusion::new(name, substance, sizes, volume_fraction))
}

fn read_substance(
    source: Source<'_>,
    whole: Range<usize>,
    name: Option<&Spanned<String>>,
    index: Option<&Spanned<String>>,
    temperature: f64,
) -> Result<Substance, Box<TextError>> {
    match (name, index) {
        (Some(name), None) => Substance::named(name.get_ref(), temperature).ok_or_else(|| {
            let nearest = nearest_names(name.get_ref(), Substance::NAMES);
            let message = format!("there is no substance called `{}`", name.get_ref());
            let help = format!("{} known: {}", did_you_mean(&nearest), Substance::NAMES.join(", "));
            source.error(name.span(), message).with_help(help.trim_start())
        }),
        (None, Some(index)) => {
            let value = parse_complex_index(index.get_ref()).map_err(|e| source.error(index.span(), e))?;
            Ok(Substance::Constant(value))
        }
        _ => Err(source.error(whole, "give either a `substance` or a `refractive_index`")),
    }
}
