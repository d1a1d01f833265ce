//! Light that is lost on a straight way and does not come back: Bouguer, Lambert and Beer.
//!
//! Chemists count absorbance in powers of ten, physicists in powers of e, and both call it absorbance; here they are two
//! types, [`Decadic`] and [`Napierian`], and so are the molar coefficients made of them.

use std::f64::consts::LN_10;

/// Avogadro's constant, 1/mol (exact since 2019).
pub const AVOGADRO: f64 = 6.022_140_76e23;

/// Why a number of this theory was refused. Carries the offending value.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum BeerLambertError {
    /// A quantity that cannot be negative, nor endless.
    #[error("the {quantity} {value} is not a finite number from 0 up")]
    Negative {
        /// Which.
        quantity: &'static str,
        /// The offending value, SI.
        value: f64,
    },
    /// A transmittance beyond what can be.
    #[error("the transmittance {value} is not above 0 and at most 1")]
    Transmittance {
        /// The offending value.
        value: f64,
    },
    /// Nothing absorbs, so no concentration follows.
    #[error("a molar absorption coefficient or path of 0 tells no concentration")]
    NothingAbsorbs,
}

fn natural(quantity: &'static str, value: f64) -> Result<f64, BeerLambertError> {
    if value >= 0.0 && value.is_finite() { Ok(value) } else { Err(BeerLambertError::Negative { quantity, value }) }
}

/// Absorbance to the base e, which is optical thickness: `-ln T`.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Napierian(f64);

/// Absorbance to the base 10, as spectrophotometers show it: `-log10 T`.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Decadic(f64);

impl Napierian {
    /// # Errors
    /// [`BeerLambertError::Negative`].
    pub fn new(value: f64) -> Result<Self, BeerLambertError> {
        natural("absorbance", value).map(Self)
    }

    /// Of a coefficient (1/m; absorption, or extinction where scattered light counts as lost) over a path (m).
    ///
    /// # Errors
    /// [`BeerLambertError::Negative`].
    pub fn over(coefficient: f64, path: f64) -> Result<Self, BeerLambertError> {
        Self::new(natural("coefficient", coefficient)? * natural("path", path)?)
    }

    /// Of what lets this share of the light through, in (0, 1].
    ///
    /// # Errors
    /// [`BeerLambertError::Transmittance`].
    pub fn from_transmittance(value: f64) -> Result<Self, BeerLambertError> {
        if value > 0.0 && value <= 1.0 { Ok(Self(-value.ln())) } else { Err(BeerLambertError::Transmittance { value }) }
    }

    /// The number itself.
    pub fn value(self) -> f64 {
        self.0
    }

    /// Share of the light that passes, in [0, 1].
    pub fn transmittance(self) -> f64 {
        (-self.0).exp()
    }

    /// Share of the light that stays, in [0, 1]; keeps its digits where little stays.
    pub fn absorptance(self) -> f64 {
        -(-self.0).exp_m1()
    }

    /// The coefficient (1/m) that has this absorbance over a path (m).
    ///
    /// # Errors
    /// [`BeerLambertError::Negative`] for the path, [`BeerLambertError::NothingAbsorbs`] for one of 0.
    pub fn coefficient(self, path: f64) -> Result<f64, BeerLambertError> {
        if natural("path", path)? > 0.0 { Ok(self.0 / path) } else { Err(BeerLambertError::NothingAbsorbs) }
    }
}

impl Decadic {
    /// # Errors
    /// [`BeerLambertError::Negative`].
    pub fn new(value: f64) -> Result<Self, BeerLambertError> {
        natural("absorbance", value).map(Self)
    }

    /// The number itself.
    pub fn value(self) -> f64 {
        self.0
    }

    /// Share of the light that passes, in [0, 1].
    pub fn transmittance(self) -> f64 {
        Napierian::from(self).transmittance()
    }
}

impl From<Decadic> for Napierian {
    fn from(absorbance: Decadic) -> Self {
        Self(absorbance.0 * LN_10)
    }
}

impl From<Napierian> for Decadic {
    fn from(absorbance: Napierian) -> Self {
        Self(absorbance.0 / LN_10)
    }
}

/// Mean length of a straight way, m, in matter of this coefficient (1/m): of absorption, scattering or both. Endless where
/// the coefficient is 0. With `sigma_a + sigma_s (1 - g)` it is the transport mean free path.
///
/// # Errors
/// [`BeerLambertError::Negative`].
pub fn mean_free_path(coefficient: f64) -> Result<f64, BeerLambertError> {
    natural("coefficient", coefficient).map(|coefficient| 1.0 / coefficient)
}

/// What one mole does: an absorption coefficient to the base e for every mol/m³. Napierian inside, m²/mol.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MolarAbsorption(f64);

impl MolarAbsorption {
    /// From the Napierian coefficient, m²/mol.
    ///
    /// # Errors
    /// [`BeerLambertError::Negative`].
    pub fn napierian(value: f64) -> Result<Self, BeerLambertError> {
        natural("molar absorption coefficient", value).map(Self)
    }

    /// From the decadic coefficient, m²/mol.
    ///
    /// # Errors
    /// [`BeerLambertError::Negative`].
    pub fn decadic(value: f64) -> Result<Self, BeerLambertError> {
        natural("molar absorption coefficient", value).map(|value| Self(value * LN_10))
    }

    /// From the decadic coefficient as tables of chemistry give it, L/(mol cm), of which one is 0.1 m²/mol.
    ///
    /// # Errors
    /// [`BeerLambertError::Negative`].
    pub fn per_molar_centimetre(value: f64) -> Result<Self, BeerLambertError> {
        Self::decadic(0.1 * value)
    }

    /// From the absorption cross section of one molecule, m².
    ///
    /// # Errors
    /// [`BeerLambertError::Negative`].
    pub fn from_cross_section(value: f64) -> Result<Self, BeerLambertError> {
        natural("cross section", value).map(|value| Self(value * AVOGADRO))
    }

    /// To the base e, m²/mol.
    pub fn to_napierian(self) -> f64 {
        self.0
    }

    /// To the base 10, m²/mol.
    pub fn to_decadic(self) -> f64 {
        self.0 / LN_10
    }

    /// Absorption cross section of one molecule, m².
    pub fn cross_section(self) -> f64 {
        self.0 / AVOGADRO
    }

    /// The concentration, mol/m³, that has this absorbance over a path (m), where nothing else absorbs.
    ///
    /// # Errors
    /// [`BeerLambertError::NothingAbsorbs`], or [`BeerLambertError::Negative`] for the path.
    pub fn concentration(self, absorbance: impl Into<Napierian>, path: f64) -> Result<f64, BeerLambertError> {
        if self.0 == 0.0 {
            return Err(BeerLambertError::NothingAbsorbs);
        }
        Ok(absorbance.into().coefficient(path)? / self.0)
    }
}

/// Absorption coefficient, 1/m, of a solution: substances and their concentrations (mol/m³, which is mmol/L), each of
/// which absorbs as if the others were not there.
///
/// # Errors
/// [`BeerLambertError::Negative`].
pub fn mixture(substances: &[(MolarAbsorption, f64)]) -> Result<f64, BeerLambertError> {
    substances.iter().try_fold(0.0, |sum, (molar, concentration)| {
        Ok(sum + molar.to_napierian() * natural("concentration", *concentration)?)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_absorbance_of_one_lets_a_tenth_through() {
        let one = Decadic::new(1.0).unwrap();
        assert!((one.transmittance() - 0.1).abs() < 1e-15);
        let napierian: Napierian = one.into();
        assert!((napierian.value() - LN_10).abs() < 1e-15 && (napierian.absorptance() - 0.9).abs() < 1e-15);
        assert!((Decadic::from(napierian).value() - 1.0).abs() < 1e-15);
        assert!((Napierian::from_transmittance(0.1).unwrap().value() - LN_10).abs() < 1e-15);
    }

    #[test]
    fn little_absorption_keeps_its_digits_and_much_ends_in_darkness() {
        assert!((Napierian::over(1e-8, 1e-8).unwrap().absorptance() / 1e-16 - 1.0).abs() < 1e-14);
        assert_eq!(Napierian::over(1e6, 1.0).unwrap().transmittance(), 0.0);
        assert_eq!(mean_free_path(0.0).unwrap(), f64::INFINITY);
        assert_eq!(mean_free_path(250.0).unwrap(), 4e-3);
    }

    /// NADH at 340 nm, 6220 L/(mol cm): 0.1 mmol/L in a cuvette of 1 cm reads 0.622.
    #[test]
    fn a_cuvette_reads_what_a_chemist_expects() {
        let nadh = MolarAbsorption::per_molar_centimetre(6220.0).unwrap();
        let absorbance = Napierian::over(mixture(&[(nadh, 0.1)]).unwrap(), 0.01).unwrap();
        assert!((Decadic::from(absorbance).value() - 0.622).abs() < 1e-12);
        assert!((nadh.concentration(absorbance, 0.01).unwrap() - 0.1).abs() < 1e-12);
        assert!((nadh.concentration(Decadic::new(0.622).unwrap(), 0.01).unwrap() - 0.1).abs() < 1e-12);
        // 3.82e-21 m2 for every 1000 m2/mol (decadic): ln 10 / N_A.
        assert!((MolarAbsorption::decadic(1000.0).unwrap().cross_section() / 3.823_53e-21 - 1.0).abs() < 1e-5);
        let of_molecule = MolarAbsorption::from_cross_section(nadh.cross_section()).unwrap();
        assert!((of_molecule.to_decadic() - 622.0).abs() < 1e-9);
    }

    #[test]
    fn what_cannot_be_is_refused() {
        for value in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(Napierian::new(value).is_err() && Decadic::new(value).is_err() && mean_free_path(value).is_err());
            assert!(MolarAbsorption::decadic(value).is_err() && Napierian::over(1.0, value).is_err());
        }
        for value in [0.0, 1.1, -0.1, f64::NAN] {
            assert_eq!(Napierian::from_transmittance(value).is_err(), value != 1.0, "{value}");
        }
        let nothing = MolarAbsorption::napierian(0.0).unwrap();
        assert_eq!(nothing.concentration(Napierian(1.0), 1.0), Err(BeerLambertError::NothingAbsorbs));
        assert!(mixture(&[(nothing, -1.0)]).is_err());
    }
}
