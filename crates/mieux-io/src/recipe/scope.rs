//! What names mean in a recipe: its inputs, what it derives from them, and formulas of both.
//!
//! Wherever a recipe takes a number or a quantity, it takes a formula in its place: a text that begins with `=`, as in
//! `"= fat / 100"` or `"= diameter / 2 um"`, the unit last.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

use exmex::{Express, FlatEx, FloatOpsFactory, MatchLiteral};
use mieux_optics::material::Input;
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, MapAccess, Visitor};
use toml::Spanned;

use super::schema::Source;
use crate::text_error::{TextError, did_you_mean, nearest_names};

exmex::literal_matcher_from_pattern!(Decimal, r"^([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?");
type Formula = FlatEx<f64, FloatOpsFactory<f64>, Decimal>;

/// Longest formula read, bytes.
const MAX_FORMULA: usize = 1000;

/// Words with a meaning of their own in formulas.
const WORDS: [&str; 31] = [
    "atan2", "min", "max", "abs", "signum", "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh",
    "asinh", "acosh", "atanh", "floor", "round", "ceil", "trunc", "fract", "exp", "sqrt", "cbrt", "ln", "log2",
    "log10", "PI", "E", "TAU",
];

/// Reads a formula. Names are put into braces first: without them `minerals` would be read as `min erals`.
fn read(text: &str) -> Result<Formula, String> {
    if text.contains(['{', '}']) {
        return Err("there are no braces in formulas".into());
    }
    let mut braced = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let length = match first {
            '0'..='9' | '.' => Decimal::is_literal(rest).map_or(1, str::len),
            c if c.is_alphabetic() || c == '_' => {
                rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len())
            }
            c => c.len_utf8(),
        };
        let (word, after) = rest.split_at(length);
        let named = word.starts_with(|c: char| c.is_alphabetic() || c == '_') && !WORDS.contains(&word);
        braced += &if named { format!("{{{word}}}") } else { word.to_owned() };
        rest = after;
    }
    Formula::parse(&braced).map_err(|error| error.to_string())
}

/// A number, or a formula for one.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Number {
    Value(f64),
    Formula(String),
}

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl Visitor<'_> for Either {
            type Value = Number;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, or a formula such as \"= fat / 100\"")
            }

            fn visit_f64<E>(self, value: f64) -> Result<Number, E> {
                Ok(Number::Value(value))
            }

            fn visit_i64<E>(self, value: i64) -> Result<Number, E> {
                Ok(Number::Value(value as f64))
            }

            fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Number, E> {
                match text.trim().strip_prefix('=') {
                    Some(formula) => Ok(Number::Formula(formula.into())),
                    None => Err(E::invalid_type(serde::de::Unexpected::Str(text), &self)),
                }
            }
        }
        deserializer.deserialize_any(Either)
    }
}

/// An input as a recipe declares it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct InputSpec {
    #[serde(default)]
    unit: String,
    default: Spanned<f64>,
    minimum: f64,
    maximum: f64,
    about: String,
}

impl InputSpec {
    /// The input of that name.
    pub(super) fn input(&self, source: Source<'_>, name: &Spanned<String>) -> Result<Input, Box<TextError>> {
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let text = name.get_ref();
        if !text.chars().all(plain) || !text.starts_with(|c: char| c.is_ascii_alphabetic()) {
            let message = format!("`{text}` cannot name an input: letters, digits and _ do, a letter first");
            return Err(source.error(name.span(), message));
        }
        if WORDS.contains(&text.as_str()) {
            return Err(source.error(name.span(), format!("`{text}` has a meaning of its own in formulas")));
        }
        let input = Input {
            name: text.clone().into(),
            unit: self.unit.clone().into(),
            default: *self.default.get_ref(),
            minimum: self.minimum,
            maximum: self.maximum,
            about: self.about.clone().into(),
        };
        input.check(input.default).map_err(|error| source.error(self.default.span(), error))?;
        Ok(input)
    }
}

/// What stands under a name in `[inputs]`: the value of a model's input, or the declaration of a mixture's.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum InputEntry {
    Value(f64),
    Declared(Box<InputSpec>),
}

impl<'de> Deserialize<'de> for InputEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = InputEntry;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, or a table that declares the input")
            }

            fn visit_f64<E>(self, value: f64) -> Result<InputEntry, E> {
                Ok(InputEntry::Value(value))
            }

            fn visit_i64<E>(self, value: i64) -> Result<InputEntry, E> {
                Ok(InputEntry::Value(value as f64))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<InputEntry, A::Error> {
                InputSpec::deserialize(MapAccessDeserializer::new(map)).map(|spec| InputEntry::Declared(Box::new(spec)))
            }
        }
        deserializer.deserialize_any(Either)
    }
}

/// Names and their values.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Scope(BTreeMap<String, f64>);

impl Scope {
    /// Inputs with their values, and what is derived from them, in whatever order it is written.
    pub(super) fn new(
        source: Source<'_>,
        inputs: &[(Input, f64)],
        derived: &BTreeMap<Spanned<String>, Spanned<Number>>,
    ) -> Result<Self, Box<TextError>> {
        let mut scope = Self(inputs.iter().map(|(input, value)| (input.name.to_string(), *value)).collect());
        for (name, value) in derived {
            if scope.0.contains_key(name.get_ref()) {
                return Err(source.error(name.span(), format!("`{}` is an input already", name.get_ref())));
            }
            // Without this a cycle would be reported as an unknown name.
            scope.refuse_cycles(source, derived, value, &mut vec![name.get_ref()])?;
        }
        let mut waiting: Vec<_> = derived.iter().collect();
        while !waiting.is_empty() {
            let before = waiting.len();
            let mut later = Vec::new();
            for (name, value) in waiting {
                let needs_other = |needed: &String| derived.keys().any(|n| n.get_ref() == needed);
                match &value.get_ref() {
                    Number::Formula(text) if scope.unknown(text).iter().any(needs_other) => later.push((name, value)),
                    _ => drop(scope.0.insert(name.get_ref().clone(), scope.number(source, value)?)),
                }
            }
            debug_assert!(later.len() < before, "cycles were refused");
            waiting = later;
        }
        Ok(scope)
    }

    fn refuse_cycles<'a>(
        &self,
        source: Source<'_>,
        derived: &'a BTreeMap<Spanned<String>, Spanned<Number>>,
        value: &'a Spanned<Number>,
        path: &mut Vec<&'a String>,
    ) -> Result<(), Box<TextError>> {
        let Number::Formula(text) = value.get_ref() else { return Ok(()) };
        for needed in self.unknown(text) {
            let Some((name, next)) = derived.iter().find(|(name, _)| *name.get_ref() == needed) else { continue };
            if path.contains(&name.get_ref()) {
                return Err(source.error(value.span(), format!("`{needed}` depends on itself")));
            }
            path.push(name.get_ref());
            self.refuse_cycles(source, derived, next, path)?;
            path.pop();
        }
        Ok(())
    }

    /// Names in a formula that have no value yet.
    fn unknown(&self, formula: &str) -> Vec<String> {
        let Ok(formula) = read(formula) else { return Vec::new() };
        formula.var_names().iter().filter(|name| !self.0.contains_key(*name)).cloned().collect()
    }

    /// The number, or what its formula gives.
    pub(super) fn number(&self, source: Source<'_>, number: &Spanned<Number>) -> Result<f64, Box<TextError>> {
        match number.get_ref() {
            Number::Value(value) => Ok(*value),
            Number::Formula(formula) => self.evaluate(formula).map_err(|e| e.at(source, number.span())),
        }
    }

    /// A text that is a quantity, its formula replaced by what it gives: `"= diameter / 2 um"` by `"0.5 um"`.
    pub(super) fn text<'a>(
        &self,
        source: Source<'_>,
        text: &'a Spanned<String>,
    ) -> Result<Cow<'a, str>, Box<TextError>> {
        let Some(formula) = text.get_ref().trim().strip_prefix('=') else { return Ok(text.get_ref().into()) };
        let (formula, unit) = match formula.trim_end().rsplit_once(char::is_whitespace) {
            Some((formula, unit)) if self.is_unit(unit) => (formula, unit),
            _ => (formula, ""),
        };
        let value = self.evaluate(formula).map_err(|e| e.at(source, text.span()))?;
        Ok(format!("{value:e} {unit}").trim_end().to_owned().into())
    }

    /// Whether the last word of a formula is a unit: it has letters, and is neither a name nor part of a sum.
    fn is_unit(&self, word: &str) -> bool {
        let part_of_a_sum = read(word).is_ok_and(|f| f.var_names().iter().any(|n| self.0.contains_key(n)));
        let number = word.starts_with(|c: char| c.is_ascii_digit() || c == '.');
        !number && word.contains(char::is_alphabetic) && !part_of_a_sum && !word.ends_with(')')
    }

    fn evaluate(&self, text: &str) -> Result<f64, FormulaError> {
        let error = |message: String, help| FormulaError { formula: text.trim().into(), message, help };
        if text.len() > MAX_FORMULA {
            return Err(error(format!("it is longer than {MAX_FORMULA} characters"), String::new()));
        }
        let formula = read(text).map_err(|message| error(message, String::new()))?;
        let mut values = Vec::new();
        for name in formula.var_names() {
            let Some(value) = self.0.get(name) else {
                let nearest = nearest_names(name, self.0.keys().map(String::as_str));
                let known = self.0.keys().cloned().collect::<Vec<_>>().join(", ");
                let known =
                    if known.is_empty() { "the recipe declares no inputs".into() } else { format!("known: {known}") };
                let help = format!("{} {known}", did_you_mean(&nearest)).trim_start().to_owned();
                return Err(error(format!("`{name}` is neither an input nor derived from one"), help));
            };
            values.push(*value);
        }
        let value = formula.eval(&values).map_err(|e| error(e.to_string(), String::new()))?;
        if value.is_finite() { Ok(value) } else { Err(error(format!("it gives {value}"), String::new())) }
    }
}

struct FormulaError {
    formula: String,
    message: String,
    help: String,
}

impl FormulaError {
    fn at(self, source: Source<'_>, span: std::ops::Range<usize>) -> Box<TextError> {
        let error = source.error(span, format!("the formula `{}`: {}", self.formula, self.message));
        if self.help.is_empty() { error } else { error.with_help(self.help) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scope(values: &[(&str, f64)]) -> Scope {
        Scope(values.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect())
    }

    fn text(scope: &Scope, text: &str) -> String {
        let source = Source { file: "my.toml", text };
        match scope.text(source, &Spanned::new(0..text.len(), text.to_owned())) {
            Ok(text) => text.into_owned(),
            Err(error) => error.message,
        }
    }

    #[test]
    fn formulas_of_quantities_end_in_their_unit() {
        let scope = scope(&[("diameter", 3.0), ("n", 2e9)]);
        assert_eq!(text(&scope, "1.5 um"), "1.5 um");
        assert_eq!(text(&scope, "= diameter / 2 um"), "1.5e0 um");
        assert_eq!(text(&scope, "=max(diameter, 4)*1e-1 mm"), "4e-1 mm");
        assert_eq!(text(&scope, "= n /cm3"), "2e9 /cm3");
        assert_eq!(text(&scope, "= diameter / 2"), "1.5e0");
        assert_eq!(text(&scope, "= 2 * diameter"), "6e0");
        assert_eq!(text(&scope, "= ln(diameter - 2) um"), "0e0 um");
        assert_eq!(text(&scope, "= 1E3 * n + max(2., n) * sqrt(4)"), "2.004e12");
        assert_eq!(text(&self::scope(&[("minerals", 3.0), ("expo", 2.0)]), "= expo * minerals / 1e6"), "6e-6");
        assert!(text(&scope, "= 2 * {n} um").contains("braces"));
        assert!(text(&scope, "= diametre / 2 um").contains("`diametre` is neither"));
        assert!(text(&scope, "= diameter / 0 um").contains("gives inf"));
        assert!(text(&scope, "= diameter / um").contains("formula"));
        assert!(text(&scope, "=").contains("formula"));
    }
}
