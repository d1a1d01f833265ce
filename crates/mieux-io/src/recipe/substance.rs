//! A substance as a recipe names it: by name, by index, by file, by page, with what is dissolved in it.

use std::ops::Range;
use std::path::Path;

use mieux_optics::substance::{
    Concentration, Conditions, Dispersion, Solute, Substance, SubstanceEntry, SubstanceError,
};
use serde::Deserialize;
use toml::Spanned;

use super::schema::Place;
use super::scope::Number;
use crate::index_file::{IndexDatabase, IndexFileError, read_index_file};
use crate::quantity::{parse_complex_index, parse_concentration};
use crate::text_error::{TextError, did_you_mean, nearest_names};

/// Something dissolved.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SoluteSpec {
    name: Spanned<String>,
    concentration: Spanned<String>,
}

/// The keys of a host or inclusion that say what it is made of.
pub(super) struct Made<'a> {
    pub(super) substance: Option<&'a Spanned<String>>,
    pub(super) refractive_index: Option<&'a Spanned<String>>,
    pub(super) index_file: Option<&'a Spanned<String>>,
    pub(super) index_page: Option<&'a Spanned<String>>,
    pub(super) transparent: Option<&'a Spanned<bool>>,
    pub(super) temperature: Option<&'a Spanned<Number>>,
    pub(super) salinity: Option<&'a Spanned<Number>>,
    pub(super) solute: &'a [SoluteSpec],
    /// The host or inclusion.
    pub(super) whole: Range<usize>,
}

/// What a host or inclusion is made of.
macro_rules! made {
    ($entry:expr) => {{
        let spec = $entry.get_ref();
        $crate::recipe::substance::Made {
            substance: spec.substance.as_ref(),
            refractive_index: spec.refractive_index.as_ref(),
            index_file: spec.index_file.as_ref(),
            index_page: spec.index_page.as_ref(),
            transparent: spec.transparent.as_ref(),
            temperature: spec.temperature.as_ref(),
            salinity: spec.salinity.as_ref(),
            solute: &spec.solute,
            whole: $entry.span(),
        }
    }};
}
pub(super) use made;

/// What holds for the whole recipe.
#[derive(Clone, Copy)]
pub(super) struct Around<'a> {
    /// Temperature of what names none, degrees Celsius.
    pub(super) temperature: f64,
    /// The folder with the database of indices.
    pub(super) database: Option<&'a Spanned<String>>,
}

impl Made<'_> {
    /// The substance.
    pub(super) fn read(&self, place: Place<'_>, around: Around<'_>) -> Result<Substance, Box<TextError>> {
        let sources = (self.substance, self.refractive_index, self.index_file, self.index_page);
        let substance = match sources {
            (Some(name), None, None, None) => return self.dissolve(place, self.named(place, around, name)?),
            (None, Some(index), None, None) => {
                let text = place.text(index)?;
                Substance::Constant(parse_complex_index(&text).map_err(|e| place.error(index.span(), e))?)
            }
            (None, None, Some(file), None) => {
                let read = read_index_file(&beside(place, file.get_ref()));
                self.dispersive(read.map_err(|e| index_error(place, file.span(), &e))?)
            }
            (None, None, None, Some(page)) => self.dispersive(read_page(place, around, page)?),
            _ => {
                let message = "give one of `substance`, `refractive_index`, `index_file` and `index_page`";
                return Err(place.error(self.whole.clone(), message));
            }
        };
        for (key, span) in
            [("temperature", self.temperature.map(Spanned::span)), ("salinity", self.salinity.map(Spanned::span))]
        {
            if let Some(span) = span {
                return Err(place.error(span, format!("`{key}` acts on a `substance` only")));
            }
        }
        if let (Some(transparent), Some(_)) = (self.transparent, self.refractive_index) {
            return Err(place.error(transparent.span(), "`transparent` belongs to an `index_file` or `index_page`"));
        }
        self.dissolve(place, substance)
    }

    fn named(&self, place: Place<'_>, around: Around<'_>, name: &Spanned<String>) -> Result<Substance, Box<TextError>> {
        let Some(entry) = SubstanceEntry::named(name.get_ref()) else {
            let nearest = nearest_names(name.get_ref(), Substance::NAMES);
            let help = format!("{} known: {}", did_you_mean(&nearest), Substance::NAMES.join(", "));
            let error = SubstanceError::Unknown { name: name.get_ref().clone() };
            return Err(place.error(name.span(), error).with_help(help.trim_start()));
        };
        if let Some(transparent) = self.transparent {
            return Err(place.error(transparent.span(), "`transparent` belongs to an `index_file` or `index_page`"));
        }
        let mut conditions = Conditions::at(around.temperature);
        let mut given_at: [Option<Range<usize>>; 2] = [None, None];
        for (i, (key, given, acts, slot)) in [
            ("temperature", self.temperature, entry.temperature.is_some(), &mut conditions.temperature_c),
            ("salinity", self.salinity, entry.salinity.is_some(), &mut conditions.salinity),
        ]
        .into_iter()
        .enumerate()
        {
            let Some(number) = given else { continue };
            if !acts {
                return Err(place.error(number.span(), format!("`{key}` does not act on {}", entry.name)));
            }
            *slot = place.number(number)?;
            given_at[i] = Some(number.span());
        }
        entry.substance(conditions).map_err(|error| {
            let [temperature, salinity] = given_at;
            let at = match &error {
                SubstanceError::Condition { condition: "temperature", .. } => temperature,
                SubstanceError::Condition { .. } => salinity,
                _ => None,
            };
            place.error(at.unwrap_or(name.span()), error)
        })
    }

    fn dispersive(&self, dispersion: Dispersion) -> Substance {
        let transparent = self.transparent.is_some_and(|transparent| *transparent.get_ref());
        if transparent { dispersion.assume_transparent().into() } else { dispersion.into() }
    }

    fn dissolve(&self, place: Place<'_>, solvent: Substance) -> Result<Substance, Box<TextError>> {
        let mut solutes = Vec::with_capacity(self.solute.len());
        for SoluteSpec { name, concentration } in self.solute {
            let text = place.text(concentration)?;
            let amount: Concentration = parse_concentration(&text).map_err(|e| place.error(concentration.span(), e))?;
            let solute = Solute::named(name.get_ref(), amount).map_err(|error| {
                let unknown = matches!(error, SubstanceError::UnknownSolute { .. });
                let span = if unknown { name.span() } else { concentration.span() };
                place.error(span, error).with_help(format!("solutes: {}", Solute::NAMES.join(", ")))
            })?;
            solutes.push(solute);
        }
        Ok(solvent.with_solutes(solutes))
    }
}

/// A path as a recipe gives it: beside the recipe.
fn beside(place: Place<'_>, path: &str) -> std::path::PathBuf {
    Path::new(place.source.file).parent().unwrap_or(Path::new("")).join(path)
}

fn read_page(place: Place<'_>, around: Around<'_>, page: &Spanned<String>) -> Result<Dispersion, Box<TextError>> {
    let Some(folder) = around.database else {
        let message = "an `index_page` is a page of a database; say where it is";
        let help = "for example, above [host]: index_db = \"refractiveindex.info-database\"";
        return Err(place.error(page.span(), message).with_help(help));
    };
    let open = IndexDatabase::open(&beside(place, folder.get_ref()));
    let database = open.map_err(|e| index_error(place, folder.span(), &e))?;
    let read = database.find(page.get_ref()).and_then(|page| database.read(page));
    read.map_err(|e| index_error(place, page.span(), &e))
}

/// What is wrong in the file, at the place where the recipe names it.
fn index_error(place: Place<'_>, span: Range<usize>, error: &IndexFileError) -> Box<TextError> {
    let pointed = place.error(span, error);
    match error.help() {
        Some(help) => pointed.with_help(help),
        None => pointed,
    }
}
