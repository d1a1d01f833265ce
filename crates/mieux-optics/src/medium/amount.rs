//! How much of an inclusion there is, as people say it, and the volume fraction that it comes to.

/// How much of an inclusion there is in a medium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Amount {
    /// Volume of particles per volume of medium.
    VolumeFraction(f64),
    /// Mass of particles per mass of medium, 0 to 1 (weight percent over 100).
    MassFraction(f64),
    /// Particles per volume of medium, 1/m^3.
    NumberDensity(f64),
    /// Mass of particles per volume of medium, kg/m^3 (which is g/L).
    MassConcentration(f64),
}

/// What a medium holds of one inclusion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Portion<'a> {
    /// Name of the inclusion, for messages.
    pub name: &'a str,
    /// How much of it.
    pub amount: Amount,
    /// Density of its particles, kg/m^3; needed where masses are spoken of.
    pub density: Option<f64>,
    /// Mean volume of its particles, m^3; needed where they are counted.
    pub mean_volume: Option<f64>,
}

/// Why an amount is no volume fraction.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AmountError {
    /// A mass without a density.
    #[error("a mass of {name} can only be a volume with the density of {}", if *host { "the host" } else { "its particles" })]
    Density {
        /// Name of the inclusion whose amount it is.
        name: String,
        /// Whether it is the host's density that is missing.
        host: bool,
    },
    /// Particles that have no mean volume, or whose mean volume was not given.
    #[error("a number of {name} can only be a volume where the particles have a mean volume")]
    MeanVolume {
        /// Name of the inclusion.
        name: String,
    },
    /// An amount that there cannot be.
    #[error("{what} {value} of {name} {must}")]
    Value {
        /// Name of the inclusion.
        name: String,
        /// Which quantity.
        what: &'static str,
        /// What was given, SI.
        value: f64,
        /// What would do.
        must: &'static str,
    },
    /// Amounts that together leave no room for a host.
    #[error("the inclusions together take up {total} of the volume, more than 1")]
    Overfull {
        /// Sum of the volume fractions.
        total: f64,
    },
}

/// Volume fractions of all inclusions of a medium, in their order. `host_density` (kg/m^3) is needed where mass fractions are given.
///
/// A number density times the mean volume, and a mass concentration over the density of the particles, are volume fractions.
/// Mass fractions `w_i` are `v_i rho_i / rho`, where the density of the medium `rho = sum v_j rho_j + (1 - sum v_j) rho_host` has the
/// others `j` in it: with `V` and `M` the sums of volume fractions and of partial densities of those that are not given by
/// mass fraction,
/// `rho = (M + (1 - V) rho_host) / (1 - sum w_i + rho_host sum w_i / rho_i)`, and `v_i = w_i rho / rho_i`.
///
/// # Errors
/// [`AmountError`].
pub fn volume_fractions(portions: &[Portion<'_>], host_density: Option<f64>) -> Result<Vec<f64>, AmountError> {
    let by_mass: Vec<&Portion<'_>> =
        portions.iter().filter(|p| matches!(p.amount, Amount::MassFraction(w) if w != 0.0)).collect();
    let medium = match by_mass.first() {
        None => 0.0,
        Some(first) => medium_density(portions, host_density, first.name)?,
    };
    let fractions: Vec<f64> = portions.iter().map(|p| p.volume_fraction(medium)).collect::<Result<_, _>>()?;
    let total: f64 = fractions.iter().sum();
    if total > 1.0 + 1e-12 { Err(AmountError::Overfull { total }) } else { Ok(fractions) }
}

/// Density of the medium, kg/m^3. `asking` is the inclusion on whose behalf.
fn medium_density(portions: &[Portion<'_>], host: Option<f64>, asking: &str) -> Result<f64, AmountError> {
    let missing = || AmountError::Density { name: asking.into(), host: true };
    let host = host.filter(|density| *density > 0.0 && density.is_finite()).ok_or_else(missing)?;
    let (mut mass_share, mut over_density, mut volume, mut mass) = (0.0, 0.0, 0.0, 0.0);
    for portion in portions {
        if let Amount::MassFraction(share) = portion.amount {
            portion.check("mass fraction", share, 1.0, "must lie between 0 and 1")?;
            mass_share += share;
            over_density += share / portion.density()?;
        } else {
            let fraction = portion.volume_fraction(0.0)?;
            volume += fraction;
            mass += fraction * portion.density()?;
        }
    }
    if mass_share > 1.0 + 1e-12 || volume > 1.0 {
        return Err(AmountError::Overfull { total: mass_share.max(volume) });
    }
    Ok((mass + (1.0 - volume) * host) / (1.0 - mass_share + host * over_density))
}

impl Portion<'_> {
    /// With the density of the medium (kg/m^3), which only mass fractions need.
    fn volume_fraction(&self, medium: f64) -> Result<f64, AmountError> {
        const NOT_NEGATIVE: &str = "must be finite and not negative";
        let fraction = match self.amount {
            Amount::VolumeFraction(value) => {
                return self.check("volume fraction", value, 1.0, "must lie between 0 and 1");
            }
            Amount::MassFraction(0.0) => 0.0,
            Amount::MassFraction(value) => {
                self.check("mass fraction", value, 1.0, "must lie between 0 and 1")? * medium / self.density()?
            }
            Amount::NumberDensity(value) => {
                let missing = || AmountError::MeanVolume { name: self.name.into() };
                self.check("number density", value, f64::MAX, NOT_NEGATIVE)? * self.mean_volume.ok_or_else(missing)?
            }
            Amount::MassConcentration(value) => {
                self.check("mass concentration", value, f64::MAX, NOT_NEGATIVE)? / self.density()?
            }
        };
        self.check("the volume fraction", fraction, 1.0 + 1e-12, "comes out above 1")
    }

    fn density(&self) -> Result<f64, AmountError> {
        match self.density {
            None => Err(AmountError::Density { name: self.name.into(), host: false }),
            Some(density) if density > 0.0 && density.is_finite() => Ok(density),
            Some(value) => {
                Err(AmountError::Value { name: self.name.into(), what: "density", value, must: "must be positive" })
            }
        }
    }

    fn check(&self, what: &'static str, value: f64, most: f64, must: &'static str) -> Result<f64, AmountError> {
        if value >= 0.0 && value <= most {
            Ok(value)
        } else {
            Err(AmountError::Value { name: self.name.into(), what, value, must })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn portion(amount: Amount, density: Option<f64>) -> Portion<'static> {
        Portion { name: "beads", amount, density, mean_volume: Some(4e-18) }
    }

    #[test]
    fn every_way_of_saying_it_comes_to_the_same() {
        let one = |amount, host| volume_fractions(&[portion(amount, Some(1050.0))], host).map(|v| v[0]);
        assert_eq!(one(Amount::VolumeFraction(0.1), None), Ok(0.1));
        assert!((one(Amount::NumberDensity(1e15), None).unwrap() - 4e-3).abs() < 1e-15);
        assert!((one(Amount::MassConcentration(21.0), None).unwrap() - 0.02).abs() < 1e-15);
        let (w, host) = (0.1, 998.0);
        let expected = w / 1050.0 / (w / 1050.0 + (1.0 - w) / host);
        assert!((one(Amount::MassFraction(w), Some(host)).unwrap() / expected - 1.0).abs() < 1e-14);
    }

    /// Weighing the mixture gives the mass fractions back.
    #[test]
    fn several_amounts_are_solved_together() {
        let amounts = [
            (Amount::MassFraction(0.2), 4230.0),
            (Amount::VolumeFraction(0.05), 1050.0),
            (Amount::MassFraction(0.1), 915.0),
            (Amount::MassConcentration(30.0), 2650.0),
        ];
        let portions = amounts.map(|(amount, density)| portion(amount, Some(density)));
        let v = volume_fractions(&portions, Some(1000.0)).unwrap();
        let masses: Vec<f64> = v.iter().zip(amounts).map(|(v, (_, density))| v * density).collect();
        let total = masses.iter().sum::<f64>() + (1.0 - v.iter().sum::<f64>()) * 1000.0;
        assert!((masses[0] / total - 0.2).abs() < 1e-12 && (masses[2] / total - 0.1).abs() < 1e-12);
        assert!((v[1] - 0.05).abs() < 1e-15 && (masses[3] - 30.0).abs() < 1e-12);
    }

    #[test]
    fn what_is_missing_or_impossible_is_told() {
        let one = |p: Portion<'_>, host| volume_fractions(&[p], host).unwrap_err().to_string();
        let tenth = Amount::MassFraction(0.1);
        assert_eq!(
            one(portion(tenth, None), Some(1e3)),
            "a mass of beads can only be a volume with the density of its particles"
        );
        assert_eq!(
            one(portion(tenth, Some(1e3)), None),
            "a mass of beads can only be a volume with the density of the host"
        );
        let uncounted = Portion { mean_volume: None, ..portion(Amount::NumberDensity(1e9), None) };
        assert!(one(uncounted, None).contains("mean volume"));
        assert!(one(portion(Amount::VolumeFraction(1.5), None), None).contains("1.5"));
        assert!(one(portion(Amount::NumberDensity(1e18), None), None).contains("above 1"));
        assert!(one(portion(Amount::MassFraction(-0.1), Some(1.0)), Some(1.0)).contains("-0.1"));
        let half = portion(Amount::MassFraction(0.6), Some(1e3));
        assert!(matches!(volume_fractions(&[half, half], Some(1e3)), Err(AmountError::Overfull { .. })));
    }
}
