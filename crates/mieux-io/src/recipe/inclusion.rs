//! Inclusions as written in a recipe: substance, coats, shape, sizes and how much of them.

use mieux_optics::medium::{
    Amount, AmountError, Coat, CoatExtent, Inclusion, Packing, Portion, SizedBy, volume_fractions,
};
use mieux_optics::particle::{AspectRatio, Equivalence, Form, Shape};
use serde::Deserialize;
use toml::Spanned;

use super::schema::Place;
use super::scope::Number;
use super::sizes::{SizeSpec, size_distribution};
use super::substance::{Around, SoluteSpec, made};
use crate::quantity::{Length, QuantityError, parse_mass_density, parse_number_density};
use crate::text_error::TextError;

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct InclusionSpec {
    name: Option<String>,
    substance: Option<Spanned<String>>,
    refractive_index: Option<Spanned<String>>,
    index_file: Option<Spanned<String>>,
    index_page: Option<Spanned<String>>,
    transparent: Option<Spanned<bool>>,
    temperature: Option<Spanned<Number>>,
    salinity: Option<Spanned<Number>>,
    #[serde(default)]
    solute: Vec<SoluteSpec>,
    volume_fraction: Option<Spanned<Number>>,
    weight_percent: Option<Spanned<Number>>,
    number_density: Option<Spanned<String>>,
    mass_concentration: Option<Spanned<String>>,
    density: Option<Spanned<String>>,
    size_distribution: Spanned<SizeSpec>,
    shape: Option<Spanned<ShapeSpec>>,
    #[serde(default)]
    coat: Vec<Spanned<CoatSpec>>,
    sized_by: Option<Spanned<String>>,
    packing: Option<Spanned<String>>,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct ShapeSpec {
    kind: Spanned<String>,
    aspect_ratio: Option<Spanned<Number>>,
    aspect_power: Option<Spanned<AspectSpec>>,
    equivalent: Option<Spanned<String>>,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct AspectSpec {
    at_1mm: Spanned<Number>,
    exponent: Spanned<Number>,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct CoatSpec {
    substance: Option<Spanned<String>>,
    refractive_index: Option<Spanned<String>>,
    index_file: Option<Spanned<String>>,
    index_page: Option<Spanned<String>>,
    transparent: Option<Spanned<bool>>,
    temperature: Option<Spanned<Number>>,
    salinity: Option<Spanned<Number>>,
    #[serde(default)]
    solute: Vec<SoluteSpec>,
    thickness: Option<Spanned<String>>,
    radius_ratio: Option<Spanned<Number>>,
    volume_share: Option<Spanned<Number>>,
}

/// All inclusions, their amounts solved together. `host_density` is in kg/m^3.
pub(super) fn read_inclusions(
    place: Place<'_>,
    entries: &[Spanned<InclusionSpec>],
    around: Around<'_>,
    host_density: Option<f64>,
) -> Result<Vec<Inclusion>, Box<TextError>> {
    let mut inclusions = Vec::new();
    let mut amounts = Vec::new();
    for entry in entries {
        inclusions.push(read_inclusion(place, entry, around)?);
        amounts.push(read_amount(place, entry)?);
    }
    let portions: Vec<Portion<'_>> = inclusions
        .iter()
        .zip(&amounts)
        .map(|(inclusion, (amount, density))| {
            let counted = matches!(amount, Amount::NumberDensity(_));
            let mean_volume = if counted { inclusion.mean_volume().ok() } else { None };
            Portion { name: &inclusion.name, amount: *amount, density: *density, mean_volume }
        })
        .collect();
    let fractions = volume_fractions(&portions, host_density).map_err(|error| {
        let name = match &error {
            AmountError::Density { name, .. } | AmountError::MeanVolume { name } | AmountError::Value { name, .. } => {
                Some(name)
            }
            AmountError::Overfull { .. } => None,
        };
        let at = inclusions.iter().position(|inclusion| Some(&inclusion.name) == name).unwrap_or(0);
        let help = match &error {
            AmountError::Density { host: true, .. } => Some("give `density` in [host], as in density = \"998 kg/m3\""),
            AmountError::Density { host: false, .. } => Some("give its `density`, as in density = \"1.05 g/cm3\""),
            AmountError::MeanVolume { .. } => Some("a `minimum` in its size distribution would make the number finite"),
            _ => None,
        };
        let text = place.error(entries[at].get_ref().amount_span(entries[at].span()), &error);
        match help {
            Some(help) => text.with_help(help),
            None => text,
        }
    })?;
    for (inclusion, fraction) in inclusions.iter_mut().zip(fractions) {
        inclusion.volume_fraction = fraction;
    }
    Ok(inclusions)
}

impl InclusionSpec {
    /// Where it says how much there is of it.
    fn amount_span(&self, whole: std::ops::Range<usize>) -> std::ops::Range<usize> {
        let numbers = [&self.volume_fraction, &self.weight_percent].into_iter().flatten().map(Spanned::span);
        let texts = [&self.number_density, &self.mass_concentration].into_iter().flatten().map(Spanned::span);
        numbers.chain(texts).next().unwrap_or(whole)
    }
}

/// All but the amount.
fn read_inclusion(
    place: Place<'_>,
    entry: &Spanned<InclusionSpec>,
    around: Around<'_>,
) -> Result<Inclusion, Box<TextError>> {
    let spec = entry.get_ref();
    let substance = made!(entry).read(place, around)?;
    let sizes = size_distribution(place, &spec.size_distribution)?;
    let name = spec.name.clone().unwrap_or_else(|| format!("{} particles", substance.name()));
    let mut inclusion = Inclusion::new(name, substance, sizes, 0.0);
    if let Some(shape) = &spec.shape {
        inclusion.shape = read_shape(place, shape)?;
    }
    for coat in &spec.coat {
        inclusion.coats.push(read_coat(place, coat, around)?);
    }
    if let Some(sized_by) = &spec.sized_by {
        if spec.coat.is_empty() {
            return Err(place.error(sized_by.span(), "only coated particles are `sized_by` their core or outside"));
        }
        inclusion.sized_by = word(place, sized_by, "size", &[("core", SizedBy::Core), ("outside", SizedBy::Outside)])?;
    }
    if let Some(packing) = &spec.packing {
        let known = [("independent", Packing::Independent), ("percus-yevick", Packing::PercusYevick)];
        inclusion.packing = word(place, packing, "packing", &known)?;
    }
    if let (Some(shape), Form::Ellipsoid | Form::Cylinder | Form::HexagonalPrism) =
        (&spec.shape, inclusion.shape.form())
    {
        if !spec.coat.is_empty() {
            return Err(place.error(shape.span(), "only spheres can have coats"));
        }
        if inclusion.packing != Packing::Independent {
            return Err(place.error(shape.span(), "only spheres can be corrected for their packing"));
        }
    }
    Ok(inclusion)
}

/// How much, and the density in kg/m^3 if it is said.
fn read_amount(place: Place<'_>, entry: &Spanned<InclusionSpec>) -> Result<(Amount, Option<f64>), Box<TextError>> {
    let spec = entry.get_ref();
    let quantity = |text: &Spanned<String>, parse: fn(&str) -> Result<f64, QuantityError>| {
        parse(&place.text(text)?).map_err(|e| place.error(text.span(), e))
    };
    let amount = match (&spec.volume_fraction, &spec.weight_percent, &spec.number_density, &spec.mass_concentration) {
        (Some(number), None, None, None) => {
            let value = place.number(number)?;
            if !(0.0..=1.0).contains(&value) {
                let message = format!("the volume fraction {value} must lie between 0 and 1");
                return Err(place.error(number.span(), message));
            }
            Amount::VolumeFraction(value)
        }
        (None, Some(number), None, None) => {
            let value = place.number(number)?;
            if !(0.0..=100.0).contains(&value) {
                let message = format!("the weight percent {value} must lie between 0 and 100");
                return Err(place.error(number.span(), message));
            }
            Amount::MassFraction(value / 100.0)
        }
        (None, None, Some(text), None) => Amount::NumberDensity(quantity(text, parse_number_density)?),
        (None, None, None, Some(text)) => Amount::MassConcentration(quantity(text, parse_mass_density)?),
        _ => {
            let message = "an inclusion has one amount: `volume_fraction`, `weight_percent`, `number_density`, or \
                           `mass_concentration`";
            return Err(place.error(entry.span(), message));
        }
    };
    let density = spec.density.as_ref().map(|text| quantity(text, parse_mass_density)).transpose()?;
    Ok((amount, density))
}

fn read_shape(place: Place<'_>, spec: &Spanned<ShapeSpec>) -> Result<Shape, Box<TextError>> {
    let ShapeSpec { kind, aspect_ratio, aspect_power, equivalent } = spec.get_ref();
    let forms = [
        ("sphere", Form::Sphere),
        ("ellipsoid", Form::Ellipsoid),
        ("cylinder", Form::Cylinder),
        ("hexagonal-prism", Form::HexagonalPrism),
    ];
    let form = word(place, kind, "shape", &forms)?;
    let aspect = match (aspect_ratio, aspect_power) {
        (None, None) if form == Form::Sphere => return Ok(Shape::SPHERE),
        (Some(_), _) | (_, Some(_)) if form == Form::Sphere => {
            return Err(place.error(spec.span(), "a sphere has no aspect ratio"));
        }
        (Some(ratio), None) => AspectRatio::Constant(place.number(ratio)?),
        (None, Some(power)) => {
            let power = power.get_ref();
            AspectRatio::Power { factor: place.number(&power.at_1mm)?, exponent: place.number(&power.exponent)? }
        }
        _ => {
            let help = "for example aspect_ratio = 5, or aspect_power = { at_1mm = 10.3, exponent = 0.67 }";
            let message = "a shape has either an `aspect_ratio` (length over width) or an `aspect_power`";
            return Err(place.error(spec.span(), message).with_help(help));
        }
    };
    let shape = Shape::new(form, aspect).map_err(|e| place.error(spec.span(), e))?;
    let Some(equivalent) = equivalent else { return Ok(shape) };
    let known =
        [("volume-to-area", Equivalence::VolumeToArea), ("volume", Equivalence::Volume), ("area", Equivalence::Area)];
    Ok(shape.with_equivalence(word(place, equivalent, "equivalent sphere", &known)?))
}

fn read_coat(place: Place<'_>, entry: &Spanned<CoatSpec>, around: Around<'_>) -> Result<Coat, Box<TextError>> {
    let CoatSpec { thickness, radius_ratio, volume_share, .. } = entry.get_ref();
    let substance = made!(entry).read(place, around)?;
    let extent = match (thickness, radius_ratio, volume_share) {
        (Some(text), None, None) => {
            let length = Length::parse_positive(&place.text(text)?).map_err(|e| place.error(text.span(), e))?;
            CoatExtent::Thickness(length.metres())
        }
        (None, Some(number), None) => CoatExtent::RadiusRatio(place.number(number)?),
        (None, None, Some(number)) => CoatExtent::VolumeShare(place.number(number)?),
        _ => {
            let message = "a coat has one of `thickness`, `radius_ratio` (inside over outside), and `volume_share`";
            return Err(place.error(entry.span(), message));
        }
    };
    Coat::new(substance, extent).map_err(|e| place.error(entry.span(), e))
}

/// One of some words.
fn word<T: Copy>(
    place: Place<'_>,
    text: &Spanned<String>,
    what: &str,
    known: &[(&str, T)],
) -> Result<T, Box<TextError>> {
    known.iter().find(|(name, _)| *name == text.get_ref()).map(|(_, value)| *value).ok_or_else(|| {
        let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
        let message = format!("there is no {what} `{}`", text.get_ref());
        place.error(text.span(), message).with_help(format!("known: {}", names.join(", ")))
    })
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::super::Recipe;
    use mieux_optics::medium::{Medium, Packing, SizedBy};
    use mieux_optics::particle::{Form, sphere_volume};

    fn medium(inclusion: &str) -> Medium {
        let text = format!("[host]\nsubstance = \"water\"\ndensity = \"998 kg/m3\"\n[[inclusion]]\n{inclusion}");
        Recipe::parse("my", "my.toml", &text).unwrap().material(&BTreeMap::new()).unwrap().medium
    }

    fn message(inclusion: &str) -> String {
        let text = format!("[host]\nsubstance = \"water\"\n[[inclusion]]\nrefractive_index = \"1.5\"\n{inclusion}");
        Recipe::parse("my", "my.toml", &text).unwrap_err().to_string()
    }

    const BEAD: &str =
        "refractive_index = \"1.59\"\nsize_distribution = { kind = \"monodisperse\", radius = \"0.5 um\" }\n";

    #[test]
    fn amounts_come_to_volume_fractions() {
        let fraction = |amount: &str| medium(&format!("{BEAD}{amount}")).inclusions()[0].volume_fraction;
        assert_eq!(fraction("volume_fraction = 0.25"), 0.25);
        let close = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
        close(fraction("number_density = \"1e9/cm3\""), 1e15 * sphere_volume(0.5e-6));
        close(fraction("mass_concentration = \"21 g/L\"\ndensity = \"1.05 g/mL\""), 0.02);
        let expected = (0.1 / 1.05) / (0.1 / 1.05 + 0.9 / 0.998);
        close(fraction("weight_percent = 10\ndensity = \"1.05 g/cm3\""), expected);
    }

    #[test]
    fn shapes_coats_and_packing_are_read() {
        let rods = "volume_fraction = 0.1\nrefractive_index = \"1.5\"\n\
                    shape = { kind = \"cylinder\", aspect_power = { at_1mm = 10.3, exponent = 0.67 }, equivalent = \"volume\" }\n\
                    size_distribution = { kind = \"power-law\", exponent = 1.96, minimum = \"0.5mm\", maximum = \"14.6mm\" }";
        let medium_of_rods = medium(rods);
        let shape = medium_of_rods.inclusions()[0].shape;
        assert_eq!(shape.form(), Form::Cylinder);
        assert!((shape.aspect_ratio(1e-3) - 10.3).abs() < 1e-12);
        let coated = format!(
            "{BEAD}volume_fraction = 0.1\nsized_by = \"core\"\npacking = \"percus-yevick\"\n\
             coat = [{{ substance = \"casein\", thickness = \"20 nm\" }}, {{ refractive_index = \"1.4\", volume_share = 0.1 }}]"
        );
        let coated = medium(&coated);
        let inclusion = &coated.inclusions()[0];
        assert_eq!((inclusion.coats.len(), inclusion.sized_by), (2, SizedBy::Core));
        assert_eq!(inclusion.packing, Packing::PercusYevick);
    }

    #[test]
    fn mistakes_are_pointed_at() {
        let sizes = "size_distribution = { kind = \"monodisperse\", radius = \"1 um\" }\n";
        for (text, expected) in [
            ("", "one amount"),
            ("volume_fraction = 0.1\nweight_percent = 1", "one amount"),
            ("weight_percent = 1", "density of the host"),
            ("mass_concentration = \"1 g/L\"", "my.toml, line 6, column 22: a mass of"),
            ("number_density = \"1e9\"", "no unit"),
            ("number_density = \"1e20/cm3\"", "above 1"),
            ("volume_fraction = 1.1", "must lie between 0 and 1"),
            ("volume_fraction = 0.1\nshape = { kind = \"cube\" }", "no shape `cube`"),
            ("volume_fraction = 0.1\nshape = { kind = \"cylinder\" }", "aspect_ratio"),
            ("volume_fraction = 0.1\nshape = { kind = \"cylinder\", aspect_ratio = -1 }", "must be positive"),
            ("volume_fraction = 0.1\nsized_by = \"core\"", "only coated"),
            ("volume_fraction = 0.1\ncoat = [{ substance = \"water\" }]", "a coat has one of"),
            ("volume_fraction = 0.1\ncoat = [{ substance = \"water\", radius_ratio = 2 }]", "between 0 and 1"),
            ("volume_fraction = 0.6\npacking = \"percus-yevick\"", "above 0.5"),
            ("volume_fraction = 0.1\npacking = \"loose\"", "no packing `loose`"),
        ] {
            let message = message(&format!("{sizes}{text}"));
            assert!(message.contains(expected), "{text}: {message}");
        }
    }
}
