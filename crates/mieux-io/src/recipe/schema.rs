//! The shape of a recipe file, and the way from it to a medium, every mistake pointed at.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;

use mieux_optics::material::Input;
use mieux_optics::material::milk::Milk;
use mieux_optics::medium::Medium;
use serde::Deserialize;
use toml::Spanned;

use super::inclusion::{InclusionSpec, read_inclusions};
use super::scope::{InputEntry, Number, Scope};
use super::substance::{Around, SoluteSpec, made};
use crate::quantity::parse_mass_density;
use crate::text_error::TextError;

/// Temperature of a mixture that does not name one, degrees Celsius.
const ROOM_TEMPERATURE: f64 = 20.0;

/// A recipe's text in order, every value with its place.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Document {
    pub(super) title: Option<String>,
    pub(super) about: Option<String>,
    model: Option<Spanned<String>>,
    inputs: Option<Spanned<BTreeMap<Spanned<String>, Spanned<InputEntry>>>>,
    #[serde(default)]
    derived: BTreeMap<Spanned<String>, Spanned<Number>>,
    temperature: Option<Spanned<Number>>,
    index_db: Option<Spanned<String>>,
    host: Option<Spanned<SubstanceSpec>>,
    #[serde(default)]
    inclusion: Vec<Spanned<InclusionSpec>>,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct SubstanceSpec {
    substance: Option<Spanned<String>>,
    refractive_index: Option<Spanned<String>>,
    index_file: Option<Spanned<String>>,
    index_page: Option<Spanned<String>>,
    transparent: Option<Spanned<bool>>,
    temperature: Option<Spanned<Number>>,
    salinity: Option<Spanned<Number>>,
    #[serde(default)]
    solute: Vec<SoluteSpec>,
    density: Option<Spanned<String>>,
}

/// A text under its name, to make errors of places in it.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub(super) file: &'a str,
    pub(super) text: &'a str,
}

impl Source<'_> {
    pub(super) fn error(&self, span: Range<usize>, message: impl ToString) -> Box<TextError> {
        TextError::new(self.file, self.text, span, message.to_string())
    }
}

/// Where a value is looked up: the text it stands in and what names mean there.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) source: Source<'a>,
    pub(super) scope: &'a Scope,
}

impl<'a> Place<'a> {
    pub(super) fn error(&self, span: Range<usize>, message: impl ToString) -> Box<TextError> {
        self.source.error(span, message)
    }

    pub(super) fn number(&self, number: &Spanned<Number>) -> Result<f64, Box<TextError>> {
        self.scope.number(self.source, number)
    }

    pub(super) fn text<'t>(&self, text: &'t Spanned<String>) -> Result<Cow<'t, str>, Box<TextError>> {
        self.scope.text(self.source, text)
    }
}

impl Document {
    pub(super) fn read(source: Source<'_>) -> Result<Self, Box<TextError>> {
        toml::from_str(source.text).map_err(|e| TextError::from_toml(source.file, source.text, &e))
    }

    /// The inputs, with the values the recipe gives them.
    pub(super) fn inputs(&self, source: Source<'_>) -> Result<Vec<(Input, f64)>, Box<TextError>> {
        let given = self.inputs.iter().flat_map(|inputs| inputs.get_ref());
        if let Some(model) = &self.model {
            return model_inputs(source, model, given);
        }
        let mut inputs = Vec::new();
        for (name, entry) in given {
            let InputEntry::Declared(spec) = entry.get_ref() else {
                let message = "an input of a mixture is declared by a table: unit, default, minimum, maximum, about";
                return Err(source.error(entry.span(), message));
            };
            let input = spec.input(source, name)?;
            inputs.push((name.span().start, input));
        }
        // In the order in which they are written, which is that of people.
        inputs.sort_by_key(|(start, _)| *start);
        Ok(inputs.into_iter().map(|(_, input)| (input.clone(), input.default)).collect())
    }

    /// The model, if the recipe is one with other inputs.
    pub(super) fn has_model(&self) -> bool {
        self.model.is_some()
    }

    /// The mixture, its inputs having these values.
    pub(super) fn mixture(&self, source: Source<'_>, inputs: &[(Input, f64)]) -> Result<Medium, Box<TextError>> {
        let scope = Scope::new(source, inputs, &self.derived)?;
        let place = Place { source, scope: &scope };
        let Some(host) = &self.host else {
            let message = "a recipe needs either a `model` or a `[host]`";
            let help = "for example: model = \"milk\", or [host] with substance = \"water\"";
            return Err(source.error(0..0, message).with_help(help));
        };
        let around = Around { temperature: self.temperature(place)?, database: self.index_db.as_ref() };
        let density = &host.get_ref().density;
        let host = made!(host).read(place, around)?;
        let density = density
            .as_ref()
            .map(|text| parse_mass_density(&place.text(text)?).map_err(|e| place.error(text.span(), e)));
        let inclusions = read_inclusions(place, &self.inclusion, around, density.transpose()?)?;
        let span = self.inclusion.first().map_or(0..0, Spanned::span);
        Medium::new(host, inclusions).map_err(|e| source.error(span, e))
    }

    fn temperature(&self, place: Place<'_>) -> Result<f64, Box<TextError>> {
        let Some(number) = &self.temperature else { return Ok(ROOM_TEMPERATURE) };
        let value = place.number(number)?;
        if (-60.0..=100.0).contains(&value) {
            return Ok(value);
        }
        Err(place.error(number.span(), format!("temperature {value} degC is out of range: -60 to 100 degC")))
    }

    /// Refuses what a recipe with a model cannot have.
    pub(super) fn refuse_mixture(&self, source: Source<'_>) -> Result<(), Box<TextError>> {
        let misplaced = self.host.as_ref().map(Spanned::span);
        let misplaced = misplaced.or_else(|| self.inclusion.first().map(Spanned::span));
        let misplaced = misplaced.or_else(|| self.derived.keys().next().map(Spanned::span));
        match misplaced.or_else(|| self.temperature.as_ref().map(Spanned::span)) {
            None => Ok(()),
            Some(span) => Err(source.error(span, "a recipe with a `model` takes everything else from its `[inputs]`")),
        }
    }
}

/// The inputs of a model, with the values given.
fn model_inputs<'a>(
    source: Source<'_>,
    model: &Spanned<String>,
    given: impl Iterator<Item = (&'a Spanned<String>, &'a Spanned<InputEntry>)>,
) -> Result<Vec<(Input, f64)>, Box<TextError>> {
    if model.get_ref() != "milk" {
        let message = format!("there is no model called `{}`", model.get_ref());
        return Err(source.error(model.span(), message).with_help("models: milk"));
    }
    let mut inputs: Vec<(Input, f64)> = Milk::INPUTS.into_iter().map(|input| (input.clone(), input.default)).collect();
    for (name, entry) in given {
        let Some((input, value)) = inputs.iter_mut().find(|(input, _)| input.name == *name.get_ref()) else {
            let known = Milk::INPUTS.map(|input| input.name);
            let message = format!("the model milk has no input `{}`", name.get_ref());
            return Err(source.error(name.span(), message).with_help(format!("inputs: {}", known.join(", "))));
        };
        let InputEntry::Value(given) = entry.get_ref() else {
            return Err(source.error(entry.span(), "an input of a model is a number"));
        };
        *value = input.check(*given).map_err(|e| source.error(entry.span(), e))?;
    }
    Ok(inputs)
}
