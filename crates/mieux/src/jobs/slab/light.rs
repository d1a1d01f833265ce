//! How light falls in, and what lies below.

use std::fmt;
use std::str::FromStr;

use mieux_io::quantity::{QuantityError, parse_fraction};
use mieux_optics::transfer::{Ground, Incidence};
use serde::{Deserialize, Serialize};

use super::super::JobError;

/// How light falls onto a slab.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SlabLight {
    /// From one direction: the angle with the normal in the medium outside, degrees, from 0 up to but without 90.
    Angle(f64),
    /// With equal radiance from all directions.
    Diffuse,
}

impl Default for SlabLight {
    fn default() -> Self {
        Self::Angle(0.0)
    }
}

impl SlabLight {
    pub(super) fn incidence(self) -> Result<Incidence, JobError> {
        match self {
            Self::Diffuse => Ok(Incidence::Diffuse),
            Self::Angle(angle) if (0.0..90.0).contains(&angle) => Ok(Incidence::Beam(angle.to_radians().cos())),
            Self::Angle(angle) => Err(JobError::Value {
                name: "angle",
                value: angle.to_string(),
                allowed: "light falls in at 0 (along the normal) up to but not at 90 degrees",
            }),
        }
    }
}

impl fmt::Display for SlabLight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Angle(angle) => write!(f, "parallel at {angle} degrees"),
            Self::Diffuse => f.write_str("diffuse"),
        }
    }
}

/// What lies below a slab. Parses "black", "white", a reflectance such as "0.4" or "40%", "mirror:0.9".
///
/// What is printed parses to the same value.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Backing(Ground);

impl Default for Backing {
    fn default() -> Self {
        Self(Ground::Black)
    }
}

impl Backing {
    /// As the solvers take it.
    pub fn ground(self) -> Ground {
        self.0
    }
}

impl FromStr for Backing {
    type Err = QuantityError;

    fn from_str(text: &str) -> Result<Self, QuantityError> {
        let text = text.trim();
        let none = |text: &str| text.trim_end_matches('%').trim().parse::<f64>() == Ok(0.0);
        let share = |text: &str| match parse_fraction(text) {
            _ if none(text) => Ok(0.0),
            Err(QuantityError::NotANumber { .. }) => Err(QuantityError::Form {
                text: text.to_owned(),
                expected: "a backing is `black`, `white`, a reflectance from 0 to 1, or `mirror:` and a reflectance",
            }),
            other => other,
        };
        Ok(Self(match text {
            "black" => Ground::Black,
            "white" => Ground::Lambertian(1.0),
            _ => match text.strip_prefix("mirror:") {
                Some(rest) => Ground::Mirror(share(rest)?),
                None => match share(text)? {
                    0.0 => Ground::Black,
                    reflectance => Ground::Lambertian(reflectance),
                },
            },
        }))
    }
}

impl fmt::Display for Backing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Ground::Black => f.write_str("black"),
            Ground::Lambertian(1.0) => f.write_str("white"),
            Ground::Lambertian(share) => write!(f, "{share}"),
            Ground::Mirror(share) => write!(f, "mirror:{share}"),
        }
    }
}

impl TryFrom<String> for Backing {
    type Error = QuantityError;

    fn try_from(text: String) -> Result<Self, QuantityError> {
        text.parse()
    }
}

impl From<Backing> for String {
    fn from(backing: Backing) -> Self {
        backing.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn backings_are_printed_as_they_are_typed() {
        for (text, ground) in [
            ("black", Ground::Black),
            ("white", Ground::Lambertian(1.0)),
            ("0.4", Ground::Lambertian(0.4)),
            ("mirror:0.9", Ground::Mirror(0.9)),
        ] {
            let backing: Backing = text.parse().unwrap();
            assert_eq!((backing.ground(), backing.to_string().as_str()), (ground, text));
        }
        assert_eq!("40%".parse::<Backing>().unwrap().ground(), Ground::Lambertian(0.4));
        assert_eq!("0".parse::<Backing>().unwrap().ground(), Ground::Black);
        for text in ["grey", "1.5", "-0.1", "mirror:2", "mirror:", ""] {
            assert!(text.parse::<Backing>().is_err(), "{text}");
        }
    }

    #[test]
    fn light_falls_in_from_above() {
        assert_eq!(SlabLight::Angle(0.0).incidence().unwrap(), Incidence::Beam(1.0));
        for angle in [-1.0, 90.0, f64::NAN] {
            assert!(SlabLight::Angle(angle).incidence().is_err(), "{angle}");
        }
    }
}
