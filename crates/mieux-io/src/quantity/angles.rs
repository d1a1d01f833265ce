//! Scattering angles in equal steps.

use std::fmt;
use std::str::FromStr;

use super::{QuantityError, shifted, split_number};

/// Scattering angles from one to another in equal steps, in degrees: "0:180:0.5". Both ends lie in 0 to 180, 0 being
/// forward, and the last is included where the step allows. A single number is that one angle.
///
/// What is printed parses to the same bits.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Angles {
    from: f64,
    to: f64,
    step: f64,
}

impl Angles {
    /// The most angles there may be.
    pub const MAX_COUNT: usize = 10_000_000;

    /// How many there are.
    pub fn count(&self) -> usize {
        // What rounding may have taken from the last step is given back.
        ((self.to - self.from) / self.step * (1.0 + 1e-12) + 1e-9) as usize + 1
    }

    /// The angles in degrees, ascending; round numbers stay round.
    pub fn degrees(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.count()).map(|i| {
            let angle = self.from + i as f64 * self.step;
            let round = (angle * 1e9).round() / 1e9;
            if (round - angle).abs() < 1e-12 { round } else { angle.min(self.to) }
        })
    }

    /// The cosines of the angles. Angles that mirror each other about 90 degrees have cosines that do, to the bit.
    pub fn cosines(&self) -> impl Iterator<Item = f64> + '_ {
        self.degrees().map(|angle| match angle {
            90.0 => 0.0,
            a if a > 90.0 => -(180.0 - a).to_radians().cos(),
            a => a.to_radians().cos(),
        })
    }
}

impl FromStr for Angles {
    type Err = QuantityError;

    fn from_str(text: &str) -> Result<Self, QuantityError> {
        let text = text.trim();
        let form = || QuantityError::Form {
            text: text.to_owned(),
            expected: "angles are from:to:step in degrees, as in `0:180:0.5`",
        };
        let number = |part: &str| {
            let (number, rest) = split_number(part.trim());
            if number.is_empty() || !rest.trim().is_empty() { None } else { shifted(number, 0) }
        };
        let parts: Vec<&str> = text.split(':').collect();
        let (from, to, step) = match parts.as_slice() {
            [one] => number(one).map(|angle| (angle, angle, 1.0)),
            [from, to, step] => number(from).zip(number(to)).zip(number(step)).map(|((a, b), c)| (a, b, c)),
            _ => None,
        }
        .ok_or_else(form)?;
        let out_of_range = |allowed| Err(QuantityError::OutOfRange { text: text.to_owned(), allowed });
        if ![from, to].into_iter().all(|angle| (0.0..=180.0).contains(&angle)) {
            return out_of_range("scattering angles lie between 0 (forward) and 180 degrees (backward)");
        }
        if to < from {
            return out_of_range("angles run from the smaller to the larger one");
        }
        if !(step > 0.0 && step.is_finite()) {
            return out_of_range("the step between angles is more than 0 degrees");
        }
        if (to - from) / step >= Self::MAX_COUNT as f64 {
            return out_of_range("there may be at most 10 million angles; take a larger step");
        }
        Ok(Self { from: from + 0.0, to: to + 0.0, step })
    }
}

impl fmt::Display for Angles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.from, self.to, self.step)
    }
}

impl TryFrom<String> for Angles {
    type Error = QuantityError;

    fn try_from(text: String) -> Result<Self, QuantityError> {
        text.parse()
    }
}

impl From<Angles> for String {
    fn from(angles: Angles) -> Self {
        angles.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn angles(text: &str) -> Angles {
        text.parse().unwrap()
    }

    #[test]
    fn both_ends_are_included_and_round_numbers_stay_round() {
        let half: Vec<f64> = angles("0:180:0.5").degrees().collect();
        assert_eq!((half.len(), half[0], half[1], half[360]), (361, 0.0, 0.5, 180.0));
        for (i, angle) in angles("0:180:0.1").degrees().enumerate() {
            assert_eq!(angle, format!("{i}e-1").parse::<f64>().unwrap());
        }
        assert_eq!(angles(" 10 : 11 : 0.4 ").degrees().collect::<Vec<_>>(), [10.0, 10.4, 10.8]);
        assert_eq!(angles("90").degrees().collect::<Vec<_>>(), [90.0]);
        let thirds: Vec<f64> = angles("0:180:0.3333333333333333").degrees().collect();
        assert_eq!((thirds.len(), thirds[540]), (541, 180.0));
        assert_eq!(angles("0:180:2e-5").count(), 9_000_001);
    }

    #[test]
    fn cosines_mirror_each_other() {
        let cosines: Vec<f64> = angles("0:180:0.1").cosines().collect();
        assert_eq!((cosines[0], cosines[900], cosines[1800]), (1.0, 0.0, -1.0));
        for (i, cosine) in cosines.iter().enumerate() {
            assert!((cosine - (i as f64 / 10.0).to_radians().cos()).abs() < 1e-15);
        }
        let mirrored = (0..=900).filter(|&i| cosines[i] == -cosines[1800 - i]).count();
        assert!(mirrored > 400, "{mirrored}");
    }

    #[test]
    fn what_makes_no_angles_says_why() {
        for (text, part) in [
            ("", "from:to:step"),
            ("0:180", "from:to:step"),
            ("a:b:c", "from:to:step"),
            ("0deg:180deg:1deg", "from:to:step"),
            ("0:181:1", "between 0"),
            ("-1:180:1", "between 0"),
            ("1e999", "between 0"),
            ("90:0:1", "smaller"),
            ("0:180:0", "step"),
            ("0:180:-1", "step"),
            ("0:180:1e-9", "10 million"),
            ("0:180:1.8e-5", "10 million"),
            ("0:180:1e-999", "step"),
        ] {
            let error = text.parse::<Angles>().unwrap_err().to_string();
            assert!(error.contains(part), "{text}: {error}");
        }
    }

    #[test]
    fn what_is_printed_parses_to_the_same() {
        for text in ["0:180:0.5", "12.25:13:1e-7", "0:0:180"] {
            assert_eq!(angles(&angles(text).to_string()), angles(text));
        }
    }
}
