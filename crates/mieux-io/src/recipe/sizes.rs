//! Size distributions as written in a recipe.

use std::collections::BTreeMap;
use std::path::Path;

use mieux_optics::particle::{
    Gamma, LogNormal, MixedSizes, ModifiedGamma, ParticleError, PowerLaw, RosinRammler, SizeDistribution,
    TransformedLogNormal, Weighting,
};
use serde::Deserialize;
use toml::Spanned;

use super::RecipeError;
use super::schema::{Place, Source};
use super::scope::{Number, Scope};
use super::size_table::{self, SizeTableError};
use crate::quantity::Length;
use crate::text_error::TextError;

/// All keys a size distribution may have; which of them belong together is checked by kind.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SizeSpec {
    kind: Spanned<String>,
    radius: Option<Spanned<String>>,
    weighting: Option<Spanned<String>>,
    mean: Option<Spanned<String>>,
    deviation: Option<Spanned<String>>,
    coefficient_of_variation: Option<Spanned<Number>>,
    median: Option<Spanned<String>>,
    geometric_deviation: Option<Spanned<Number>>,
    mean_ratio: Option<Spanned<Number>>,
    deviation_ratio: Option<Spanned<Number>>,
    mode: Option<Spanned<String>>,
    alpha: Option<Spanned<Number>>,
    gamma: Option<Spanned<Number>>,
    minimum: Option<Spanned<String>>,
    maximum: Option<Spanned<String>>,
    effective_radius: Option<Spanned<String>>,
    effective_variance: Option<Spanned<Number>>,
    exponent: Option<Spanned<Number>>,
    scale: Option<Spanned<String>>,
    spread: Option<Spanned<Number>>,
    file: Option<Spanned<String>>,
    part: Option<Vec<Spanned<SizeSpec>>>,
    share: Option<Spanned<Number>>,
}

const KINDS: &str = "monodisperse (radius), log-normal (weighting; mean and deviation or coefficient_of_variation, \
                     or median and geometric_deviation; minimum, maximum), \
                     gamma (effective_radius, effective_variance; minimum, maximum), \
                     modified-gamma (mode, alpha, gamma; minimum, maximum), \
                     power-law (exponent, maximum; minimum), rosin-rammler (scale, spread; minimum, maximum), \
                     transformed-log-normal (maximum, mean_ratio, deviation_ratio), table (weighting, file), \
                     sum (weighting, part)";

/// Reads a size distribution by itself: the keys that a recipe has under `size_distribution`, as TOML. `file` names it in errors, and
/// tables lie beside it.
///
/// # Errors
/// [`RecipeError::Text`].
pub fn parse_size_distribution(file: &str, text: &str) -> Result<SizeDistribution, RecipeError> {
    let source = Source { file, text };
    let spec: SizeSpec = toml::from_str(text).map_err(|e| TextError::from_toml(file, text, &e))?;
    let scope = Scope::new(source, &[], &BTreeMap::new())?;
    Ok(size_distribution(Place { source, scope: &scope }, &Spanned::new(0..text.len(), spec))?)
}

/// The kinds of size distributions, with their keys, in a line.
pub const SIZE_KINDS: &str = KINDS;

pub(super) fn size_distribution(
    place: Place<'_>,
    spec: &Spanned<SizeSpec>,
) -> Result<SizeDistribution, Box<TextError>> {
    if let Some(share) = &spec.get_ref().share {
        return Err(place.error(share.span(), "only the parts of a sum have a `share`"));
    }
    read(place, spec)
}

fn read(place: Place<'_>, spec: &Spanned<SizeSpec>) -> Result<SizeDistribution, Box<TextError>> {
    let reader = Reader { place, spec };
    match spec.get_ref().kind.get_ref().as_str() {
        "monodisperse" => reader.monodisperse(),
        "log-normal" => reader.log_normal(),
        "gamma" => reader.gamma(),
        "modified-gamma" => reader.modified_gamma(),
        "power-law" => reader.power_law(),
        "rosin-rammler" => reader.rosin_rammler(),
        "table" => reader.table(),
        "sum" => reader.sum(),
        "transformed-log-normal" => reader.transformed_log_normal(),
        other => {
            let message = format!("there is no size distribution of the kind `{other}`");
            Err(place.error(spec.get_ref().kind.span(), message).with_help(format!("kinds: {KINDS}")))
        }
    }
}

struct Reader<'a> {
    place: Place<'a>,
    spec: &'a Spanned<SizeSpec>,
}

impl Reader<'_> {
    fn monodisperse(&self) -> Result<SizeDistribution, Box<TextError>> {
        self.only(&["radius"])?;
        let radius = self.length("radius", self.spec.get_ref().radius.as_ref())?;
        SizeDistribution::monodisperse(radius).map_err(|e| self.whole(e))
    }

    fn log_normal(&self) -> Result<SizeDistribution, Box<TextError>> {
        self.only(&[
            "weighting",
            "mean",
            "deviation",
            "coefficient_of_variation",
            "median",
            "geometric_deviation",
            "minimum",
            "maximum",
        ])?;
        let spec = self.spec.get_ref();
        let weighting = self.weighting()?;
        let sizes = match (&spec.mean, &spec.median) {
            (Some(_), None) => {
                let mean = self.length("mean", spec.mean.as_ref())?;
                let deviation = match (&spec.deviation, &spec.coefficient_of_variation) {
                    (Some(_), None) => self.length("deviation", spec.deviation.as_ref())?,
                    (None, Some(cv)) => self.place.number(cv)? * mean,
                    _ => return Err(self.whole("with `mean` give either `deviation` or `coefficient_of_variation`")),
                };
                LogNormal::from_mean(weighting, mean, deviation)
            }
            (None, Some(_)) => {
                let median = self.length("median", spec.median.as_ref())?;
                let deviation = self.number("geometric_deviation", spec.geometric_deviation.as_ref())?;
                LogNormal::from_median(weighting, median, deviation)
            }
            _ => return Err(self.whole("give either `mean` or `median`")),
        };
        let (minimum, maximum) = self.limits()?;
        let sizes = sizes.and_then(|s| s.truncated(minimum, maximum)).map_err(|e| self.whole(e))?;
        Ok(SizeDistribution::LogNormal(sizes))
    }

    fn modified_gamma(&self) -> Result<SizeDistribution, Box<TextError>> {
        self.only(&["mode", "alpha", "gamma", "minimum", "maximum"])?;
        let spec = self.spec.get_ref();
        let mode = self.length("mode", spec.mode.as_ref())?;
        let alpha = self.number("alpha", spec.alpha.as_ref())?;
        let gamma = self.number("gamma", spec.gamma.as_ref())?;
        let (minimum, maximum) = self.limits()?;
        let sizes = ModifiedGamma::new(mode, alpha, gamma).and_then(|s| s.truncated(minimum, maximum));
        Ok(SizeDistribution::ModifiedGamma(sizes.map_err(|e| self.whole(e))?))
    }

    fn gamma(&self) -> Result<SizeDistribution, Box<TextError>> {
        self.only(&["effective_radius", "effective_variance", "minimum", "maximum"])?;
        let spec = self.spec.get_ref();
        let radius = self.length("effective_radius", spec.effective_radius.as_ref())?;
        let variance = self.number("effective_variance", spec.effective_variance.as_ref())?;
        let (minimum, maximum) = self.limits()?;
        let sizes = Gamma::new(radius, variance).and_then(|s| s.truncated(minimum, maximum));
        Ok(SizeDistribution::Gamma(sizes.map_err(|e| self.whole(e))?))
    }

    fn power_law(&self) -> Result<SizeDistribution, Box<TextError>> {
        self.only(&["exponent", "minimum", "maximum"])?;
        let spec = self.spec.get_ref();
        let exponent = self.number("exponent", spec.exponent.as_ref())?;
        self.length("maximum", spec.maximum.as_ref())?;
        let (minimum, maximum) = self.limits()?;
        let sizes = PowerLaw::new(exponent, minimum, maximum).map_err(|e| self.whole(e))?;
        Ok(SizeDistribution::PowerLaw(sizes))
    }

    fn rosin_rammler(&self) -> Result<SizeDistribution, Box<TextError>> {
        self.only(&["scale", "spread", "minimum", "maximum"])?;
        let spec = self.spec.get_ref();
        let scale = self.length("scale", spec.scale.as_ref())?;
        let spread = self.number("spread", spec.spread.as_ref())?;
        let (minimum, maximum) = self.limits()?;
        let sizes = RosinRammler::new(scale, spread).and_then(|s| s.truncated(minimum, maximum));
        Ok(SizeDistribution::RosinRammler(sizes.map_err(|e| self.whole(e))?))
    }

    /// From a file beside the recipe.
    fn table(&self) -> Result<SizeDistribution, Box<TextError>> {
        self.only(&["weighting", "file"])?;
        let weighting = self.weighting()?;
        let file = self.spec.get_ref().file.as_ref().ok_or_else(|| self.whole("`file` is missing"))?;
        let folder = Path::new(self.place.source.file).parent().unwrap_or(Path::new(""));
        match size_table::read(&folder.join(file.get_ref()), weighting) {
            Ok(table) => Ok(SizeDistribution::Tabulated(table)),
            Err(SizeTableError::Read(message)) => Err(self.place.error(file.span(), message)),
            Err(SizeTableError::Text(error)) => Err(error),
        }
    }

    fn sum(&self) -> Result<SizeDistribution, Box<TextError>> {
        self.only(&["weighting", "part"])?;
        let weighting = self.weighting()?;
        let mut parts = Vec::new();
        for part in self.spec.get_ref().part.iter().flatten() {
            let share = part.get_ref().share.as_ref();
            let share = share.ok_or_else(|| self.place.error(part.span(), "each part of a sum has a `share`"))?;
            parts.push((self.place.number(share)?, read(self.place, part)?));
        }
        Ok(SizeDistribution::Mixture(MixedSizes::new(weighting, parts).map_err(|e| self.whole(e))?))
    }

    /// Smallest and largest radius, m; nothing is cut off where they are not given.
    fn limits(&self) -> Result<(f64, f64), Box<TextError>> {
        let spec = self.spec.get_ref();
        let minimum = spec.minimum.as_ref().map_or(Ok(0.0), |s| self.length("minimum", Some(s)))?;
        let maximum = spec.maximum.as_ref().map_or(Ok(f64::INFINITY), |s| self.length("maximum", Some(s)))?;
        Ok((minimum, maximum))
    }

    fn transformed_log_normal(&self) -> Result<SizeDistribution, Box<TextError>> {
        self.only(&["maximum", "mean_ratio", "deviation_ratio"])?;
        let spec = self.spec.get_ref();
        let maximum = self.length("maximum", spec.maximum.as_ref())?;
        let mean = self.number("mean_ratio", spec.mean_ratio.as_ref())?;
        let deviation = self.number("deviation_ratio", spec.deviation_ratio.as_ref())?;
        let sizes = TransformedLogNormal::new(maximum, mean, deviation).map_err(|e: ParticleError| self.whole(e))?;
        Ok(SizeDistribution::TransformedLogNormal(sizes))
    }

    fn weighting(&self) -> Result<Weighting, Box<TextError>> {
        let help = "weightings: number, surface, volume, intensity";
        let Some(weighting) = &self.spec.get_ref().weighting else {
            return Err(self.whole("the `weighting` is missing: what the distribution counts").with_help(help));
        };
        Weighting::named(weighting.get_ref()).ok_or_else(|| {
            let message = format!("there is no weighting `{}`", weighting.get_ref());
            self.place.error(weighting.span(), message).with_help(help)
        })
    }

    /// Refuses keys that have no meaning for the kind.
    fn only(&self, allowed: &[&str]) -> Result<(), Box<TextError>> {
        let spec = self.spec.get_ref();
        let texts = [
            ("radius", &spec.radius),
            ("weighting", &spec.weighting),
            ("mean", &spec.mean),
            ("deviation", &spec.deviation),
            ("median", &spec.median),
            ("mode", &spec.mode),
            ("minimum", &spec.minimum),
            ("maximum", &spec.maximum),
            ("effective_radius", &spec.effective_radius),
            ("scale", &spec.scale),
            ("file", &spec.file),
        ];
        let numbers = [
            ("coefficient_of_variation", &spec.coefficient_of_variation),
            ("geometric_deviation", &spec.geometric_deviation),
            ("alpha", &spec.alpha),
            ("gamma", &spec.gamma),
            ("mean_ratio", &spec.mean_ratio),
            ("deviation_ratio", &spec.deviation_ratio),
            ("effective_variance", &spec.effective_variance),
            ("exponent", &spec.exponent),
            ("spread", &spec.spread),
        ];
        let parts = spec.part.iter().flatten().map(|part| ("part", part.span()));
        let given = texts.iter().filter_map(|(name, value)| value.as_ref().map(|v| (*name, v.span())));
        let given = given.chain(numbers.iter().filter_map(|(name, value)| value.as_ref().map(|v| (*name, v.span()))));
        for (name, span) in given.chain(parts) {
            if !allowed.contains(&name) {
                let message = format!("`{name}` has no meaning for the kind `{}`", spec.kind.get_ref());
                return Err(self.place.error(span, message).with_help(format!("kinds: {KINDS}")));
            }
        }
        Ok(())
    }

    fn length(&self, key: &str, value: Option<&Spanned<String>>) -> Result<f64, Box<TextError>> {
        let value = value.ok_or_else(|| self.whole(format!("`{key}` is missing")))?;
        let text = self.place.text(value)?;
        let length = Length::parse_positive(&text).map_err(|e| self.place.error(value.span(), e))?;
        Ok(length.metres())
    }

    fn number(&self, key: &str, value: Option<&Spanned<Number>>) -> Result<f64, Box<TextError>> {
        self.place.number(value.ok_or_else(|| self.whole(format!("`{key}` is missing")))?)
    }

    fn whole(&self, message: impl ToString) -> Box<TextError> {
        self.place.error(self.spec.span(), message)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::super::Recipe;
    use mieux_optics::particle::SizeDistribution;

    fn parse(file: &str, sizes: &str) -> Result<SizeDistribution, String> {
        let text = format!(
            "[host]\nsubstance = \"air\"\n[[inclusion]]\nsubstance = \"water\"\nvolume_fraction = 1e-6\nsize_distribution = {{ {sizes} }}\n"
        );
        let recipe = Recipe::parse("my", file, &text).map_err(|e| e.to_string())?;
        let medium = recipe.material(&BTreeMap::new()).unwrap().medium;
        Ok(medium.inclusions()[0].sizes.clone())
    }

    #[test]
    fn every_kind_is_read() {
        for (sizes, effective) in [
            ("kind = 'gamma', effective_radius = '10 um', effective_variance = 0.1", 10e-6),
            ("kind = 'power-law', exponent = 0, minimum = '0.001 nm', maximum = '4 um'", 3e-6),
            ("kind = 'rosin-rammler', scale = '9 um', spread = 200, minimum = '1 um'", 8.97e-6),
            (
                "kind = 'sum', weighting = 'surface', part = [{ share = 1, kind = 'monodisperse', radius = '1 um' }, \
                 { share = '= 1 + 2', kind = 'monodisperse', radius = '2 um' }]",
                1.75e-6,
            ),
        ] {
            let found = parse("my.toml", sizes).unwrap().effective_radius().unwrap();
            assert!((found / effective - 1.0).abs() < 1e-3, "{sizes}: {found:e}");
        }
    }

    #[test]
    fn a_table_lies_beside_the_recipe() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("beads.csv"), "radius_um,density\n1,1\n3,1\n").unwrap();
        let file = folder.path().join("my.toml");
        let sizes = "kind = 'table', weighting = 'number', file = 'beads.csv'";
        let found = parse(&file.to_string_lossy(), sizes).unwrap().mean_radius(1.0, 0.0).unwrap();
        assert!((found / 2e-6 - 1.0).abs() < 1e-8);
        std::fs::write(folder.path().join("beads.csv"), "radius_um,density\n1,1\n3,many\n").unwrap();
        let error = parse(&file.to_string_lossy(), sizes).unwrap_err();
        assert!(error.contains("beads.csv, line 3, column 3: `many` is no number"), "{error}");
        let error =
            parse(&file.to_string_lossy(), "kind = 'table', weighting = 'number', file = 'no.csv'").unwrap_err();
        assert!(error.contains("line 6") && error.contains("no.csv"), "{error}");
    }

    #[test]
    fn mistakes_are_pointed_at() {
        for (sizes, expected) in [
            ("kind = 'power-law', exponent = 4, maximum = '1 um'", "cannot be normalised"),
            ("kind = 'power-law', exponent = 4, minimum = '2 um', maximum = '1 um'", "below the maximum"),
            ("kind = 'power-law', exponent = 4, minimum = '2 um'", "`maximum` is missing"),
            ("kind = 'gamma', effective_radius = '1 um', effective_variance = 0.7", "between 0 and 0.5"),
            ("kind = 'monodisperse', radius = '1 um', exponent = 3", "no meaning"),
            ("kind = 'monodisperse', radius = '1 um', share = 3", "only the parts of a sum"),
            ("kind = 'sum', weighting = 'volume', part = [{ kind = 'monodisperse', radius = '1 um' }]", "`share`"),
            ("kind = 'sum', weighting = 'volume'", "some must be positive"),
            ("kind = 'table', weighting = 'mass', file = 'a.csv'", "no weighting `mass`"),
        ] {
            let error = parse("my.toml", sizes).unwrap_err();
            assert!(error.contains("line 6") && error.contains(expected), "{sizes}: {error}");
        }
    }
}
