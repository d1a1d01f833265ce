//! Size distributions as written in a recipe.

use mieux_optics::particle::{
    LogNormal, ModifiedGamma, ParticleError, SizeDistribution, TransformedLogNormal, Weighting,
};
use serde::Deserialize;
use toml::Spanned;

use super::schema::Source;
use crate::quantity::Length;
use crate::text_error::TextError;

/// All keys a size distribution may have; which of them belong together is checked by kind.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SizeSpec {
    kind: Spanned<String>,
    radius: Option<Spanned<String>>,
    weighting: Option<Spanned<String>>,
    mean: Option<Spanned<String>>,
    deviation: Option<Spanned<String>>,
    coefficient_of_variation: Option<Spanned<f64>>,
    median: Option<Spanned<String>>,
    geometric_deviation: Option<Spanned<f64>>,
    mean_ratio: Option<Spanned<f64>>,
    deviation_ratio: Option<Spanned<f64>>,
    mode: Option<Spanned<String>>,
    alpha: Option<Spanned<f64>>,
    gamma: Option<Spanned<f64>>,
    minimum: Option<Spanned<String>>,
    maximum: Option<Spanned<String>>,
}

const KINDS: &str = "monodisperse (radius), log-normal (weighting; mean and deviation or coefficient_of_variation, \
                     or median and geometric_deviation; minimum, maximum), \
                     modified-gamma (mode, alpha, gamma; minimum, maximum), \
                     transformed-log-normal (maximum, mean_ratio, deviation_ratio)";

pub(super) fn size_distribution(
    source: Source<'_>,
    spec: &Spanned<SizeSpec>,
) -> Result<SizeDistribution, Box<TextError>> {
    let reader = Reader { source, spec };
    match spec.get_ref().kind.get_ref().as_str() {
        "monodisperse" => reader.monodisperse(),
        "log-normal" => reader.log_normal(),
        "modified-gamma" => reader.modified_gamma(),
        "transformed-log-normal" => reader.transformed_log_normal(),
        other => {
            let message = format!("there is no size distribution of the kind `{other}`");
            Err(source.error(spec.get_ref().kind.span(), message).with_help(format!("kinds: {KINDS}")))
        }
    }
}

struct Reader<'a> {
    source: Source<'a>,
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
                    (None, Some(cv)) => cv.get_ref() * mean,
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
            return Err(self.whole("a log-normal needs its `weighting`: what the distribution counts").with_help(help));
        };
        Weighting::named(weighting.get_ref()).ok_or_else(|| {
            let message = format!("there is no weighting `{}`", weighting.get_ref());
            self.source.error(weighting.span(), message).with_help(help)
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
        ];
        let numbers = [
            ("coefficient_of_variation", &spec.coefficient_of_variation),
            ("geometric_deviation", &spec.geometric_deviation),
            ("alpha", &spec.alpha),
            ("gamma", &spec.gamma),
            ("mean_ratio", &spec.mean_ratio),
            ("deviation_ratio", &spec.deviation_ratio),
        ];
        let given = texts.iter().filter_map(|(name, value)| value.as_ref().map(|v| (*name, v.span())));
        let given = given.chain(numbers.iter().filter_map(|(name, value)| value.as_ref().map(|v| (*name, v.span()))));
        for (name, span) in given {
            if !allowed.contains(&name) {
                let message = format!("`{name}` has no meaning for the kind `{}`", spec.kind.get_ref());
                return Err(self.source.error(span, message).with_help(format!("kinds: {KINDS}")));
            }
        }
        Ok(())
    }

    fn length(&self, key: &str, value: Option<&Spanned<String>>) -> Result<f64, Box<TextError>> {
        let value = value.ok_or_else(|| self.whole(format!("`{key}` is missing")))?;
        let length = Length::parse_positive(value.get_ref()).map_err(|e| self.source.error(value.span(), e))?;
        Ok(length.metres())
    }

    fn number(&self, key: &str, value: Option<&Spanned<f64>>) -> Result<f64, Box<TextError>> {
        value.map(|v| *v.get_ref()).ok_or_else(|| self.whole(format!("`{key}` is missing")))
    }

    fn whole(&self, message: impl ToString) -> Box<TextError> {
        self.source.error(self.spec.span(), message)
    }
}
