//! The dispersion formulas of the refractiveindex.info database (`polyanskiy2024`).

use super::super::error::DispersionError;

/// Which formula.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Sellmeier,
    SellmeierSquared,
    Polynomial,
    RefractiveIndexInfo,
    Cauchy,
    Gases,
    Herzberger,
    Retro,
    Exotic,
}

/// The real part of a refractive index as a formula in the wavelength, which holds over a range.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula {
    kind: Kind,
    coefficients: Vec<f64>,
    range_m: (f64, f64),
}

impl Formula {
    /// Formula `number` (1 to 9) with coefficients for wavelengths in micrometres, between two wavelengths in metres.
    ///
    /// With `L` the wavelength in micrometres and `C1, C2, ...` the coefficients, those left out being zero:
    ///
    /// 1. Sellmeier: `n^2 - 1 = C1 + sum C2 L^2/(L^2 - C3^2)`
    /// 2. Sellmeier-2: `n^2 - 1 = C1 + sum C2 L^2/(L^2 - C3)`
    /// 3. polynomial: `n^2 = C1 + sum C2 L^C3`
    /// 4. RefractiveIndex.INFO: `n^2 = C1 + C2 L^C3/(L^2 - C4^C5) + C6 L^C7/(L^2 - C8^C9) + sum C10 L^C11`
    /// 5. Cauchy: `n = C1 + sum C2 L^C3`
    /// 6. gases: `n - 1 = C1 + sum C2/(C3 - L^-2)`
    /// 7. Herzberger: `n = C1 + C2/(L^2 - 0.028) + C3/(L^2 - 0.028)^2 + C4 L^2 + C5 L^4 + C6 L^6`
    /// 8. retro: `(n^2 - 1)/(n^2 + 2) = C1 + C2 L^2/(L^2 - C3) + C4 L^2`
    /// 9. exotic: `n^2 = C1 + C2/(L^2 - C3) + C4 (L - C5)/((L - C5)^2 + C6)`
    ///
    /// # Errors
    /// [`DispersionError`]: another number, coefficients that are not finite or not as many as the formula takes, or a
    /// range that is none.
    pub fn new(number: u32, coefficients: Vec<f64>, range_m: (f64, f64)) -> Result<Self, DispersionError> {
        let (kind, expected, enough) = Self::form(number, coefficients.len())?;
        if !enough {
            return Err(DispersionError::Coefficients { number, expected, given: coefficients.len() });
        }
        if let Some(&value) = coefficients.iter().find(|c| !c.is_finite()) {
            return Err(DispersionError::Coefficient { value });
        }
        if !(range_m.0 > 0.0 && range_m.1 >= range_m.0 && range_m.1.is_finite()) {
            return Err(DispersionError::Range { range_m });
        }
        Ok(Self { kind, coefficients, range_m })
    }

    fn form(number: u32, given: usize) -> Result<(Kind, &'static str, bool), DispersionError> {
        let pairs = ("one and pairs of", given % 2 == 1);
        let (kind, (expected, enough)) = match number {
            1 => (Kind::Sellmeier, pairs),
            2 => (Kind::SellmeierSquared, pairs),
            3 => (Kind::Polynomial, pairs),
            4 => (
                Kind::RefractiveIndexInfo,
                ("1, 5, 9 and pairs of", matches!(given, 1 | 5) || given >= 9 && given % 2 == 1),
            ),
            5 => (Kind::Cauchy, pairs),
            6 => (Kind::Gases, pairs),
            7 => (Kind::Herzberger, ("1 to 6", (1..=6).contains(&given))),
            8 => (Kind::Retro, ("1 to 4", (1..=4).contains(&given))),
            9 => (Kind::Exotic, ("1 to 6", (1..=6).contains(&given))),
            _ => return Err(DispersionError::Number { number }),
        };
        Ok((kind, expected, enough))
    }

    /// The wavelengths (m) between which it holds.
    pub fn range(&self) -> (f64, f64) {
        self.range_m
    }

    /// The real part at a wavelength in metres, or `None` outside the range. Not a number where the formula would need
    /// the root of a negative one.
    ///
    /// The ends give way by one part in 1e12, as those of tables do.
    pub fn at(&self, wavelength_m: f64) -> Option<f64> {
        let (first, last) = self.range_m;
        (wavelength_m >= first * (1.0 - 1e-12) && wavelength_m <= last * (1.0 + 1e-12))
            .then(|| self.value(wavelength_m * 1e6))
    }

    /// The formula itself, at a wavelength in micrometres.
    fn value(&self, l: f64) -> f64 {
        let c = |i: usize| self.coefficients.get(i - 1).copied().unwrap_or(0.0);
        let l2 = l * l;
        match self.kind {
            Kind::Sellmeier => (1.0 + self.sum(|b, d| b * l2 / (l2 - d * d))).sqrt(),
            Kind::SellmeierSquared => (1.0 + self.sum(|b, d| b * l2 / (l2 - d))).sqrt(),
            Kind::Polynomial => self.sum(|b, d| b * l.powf(d)).sqrt(),
            Kind::RefractiveIndexInfo => {
                let resonance = |i: usize| match c(i) {
                    0.0 => 0.0,
                    strength => strength * l.powf(c(i + 1)) / (l2 - c(i + 2).powf(c(i + 3))),
                };
                let rest: f64 = (10..=self.coefficients.len()).step_by(2).map(|i| c(i) * l.powf(c(i + 1))).sum();
                (c(1) + resonance(2) + resonance(6) + rest).sqrt()
            }
            Kind::Cauchy => self.sum(|b, d| b * l.powf(d)),
            Kind::Gases => 1.0 + self.sum(|b, d| b / (d - 1.0 / l2)),
            Kind::Herzberger => {
                let q = 1.0 / (l2 - 0.028);
                c(1) + c(2) * q + c(3) * q * q + c(4) * l2 + c(5) * l2 * l2 + c(6) * l2 * l2 * l2
            }
            Kind::Retro => {
                let t = c(1) + c(2) * l2 / (l2 - c(3)) + c(4) * l2;
                ((1.0 + 2.0 * t) / (1.0 - t)).sqrt()
            }
            Kind::Exotic => {
                let d = l - c(5);
                (c(1) + c(2) / (l2 - c(3)) + c(4) * d / (d * d + c(6))).sqrt()
            }
        }
    }

    /// The first coefficient and a term for each pair after it.
    fn sum(&self, term: impl Fn(f64, f64) -> f64) -> f64 {
        let (first, pairs) = (self.coefficients[0], self.coefficients[1..].chunks_exact(2));
        first + pairs.map(|pair| term(pair[0], pair[1])).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(number: u32, coefficients: &[f64], wavelength_um: f64) -> f64 {
        Formula::new(number, coefficients.to_vec(), (0.1e-6, 100e-6)).unwrap().at(wavelength_um * 1e-6).unwrap()
    }

    #[test]
    fn each_formula_gives_what_its_source_prints() {
        // Fused silica at the d line, 1.45846 (`malitson1965`); the same with squared resonances.
        let silica = [0.0, 0.6961663, 0.0684043, 0.4079426, 0.1162414, 0.8974794, 9.896161];
        assert!((at(1, &silica, 0.587_561_8) - 1.45846).abs() < 5e-6);
        let squared = [0.0, 0.6961663, 0.0684043f64.powi(2), 0.4079426, 0.1162414f64.powi(2), 0.8974794, 97.934];
        assert!((at(2, &squared, 0.587_561_8) - 1.45846).abs() < 5e-6);
        // Rutile at 589.3 nm, ordinary: 2.613 (`devore1951`).
        assert!((at(4, &[5.913, 0.2441, 0.0, 0.0803, 1.0, 0.0, 0.0, 0.0, 1.0], 0.5893) - 2.613).abs() < 1e-3);
        // Standard air at 589.3 nm: 1.000 277 (`ciddor1996`).
        let air = [0.0, 0.05792105, 238.0185, 0.00167917, 57.362];
        assert!((at(6, &air, 0.5893) - 1.000_277).abs() < 5e-7);
        // By hand, at 2 um.
        assert!((at(3, &[2.0, 0.5, 1.0, 4.0, -2.0], 2.0) - 2.0).abs() < 1e-15);
        assert!((at(4, &[1.0, 3.0, 1.0, 2.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.5, 2.0], 2.0) - 6f64.sqrt()).abs() < 1e-15);
        assert!((at(5, &[1.5, 0.04, -2.0], 2.0) - 1.51).abs() < 1e-15);
        let q: f64 = 1.0 / 3.972;
        let herzberger = 3.0 + q + 2.0 * q * q + 0.04 + 0.016 + 0.0064;
        assert!((at(7, &[3.0, 1.0, 2.0, 0.01, 0.001, 0.0001], 2.0) - herzberger).abs() < 1e-14);
        // (n^2 - 1)/(n^2 + 2) = 0.1 + 0.3 * 4/3 - 0.01 * 4 = 0.46.
        assert!((at(8, &[0.1, 0.3, 1.0, -0.01], 2.0) - (1.92f64 / 0.54).sqrt()).abs() < 1e-14);
        assert!((at(9, &[2.0, 3.0, 1.0, 1.0, 1.0, 0.25], 2.0) - 3.8f64.sqrt()).abs() < 1e-14);
    }

    #[test]
    fn nothing_is_extrapolated_and_nonsense_is_refused() {
        let cauchy = Formula::new(5, vec![1.5], (0.4e-6, 0.7e-6)).unwrap();
        assert_eq!(cauchy.at(0.4e-6), Some(1.5));
        assert_eq!((cauchy.at(0.39e-6), cauchy.at(0.71e-6), cauchy.at(f64::NAN)), (None, None, None));
        let refused =
            |number, coefficients: &[f64], range| Formula::new(number, coefficients.to_vec(), range).unwrap_err();
        let range = (0.4e-6, 0.7e-6);
        assert_eq!(refused(10, &[1.0], range), DispersionError::Number { number: 10 });
        assert!(matches!(refused(1, &[0.0, 1.0], range), DispersionError::Coefficients { given: 2, .. }));
        assert!(matches!(refused(4, &[0.0; 7], range), DispersionError::Coefficients { given: 7, .. }));
        assert!(matches!(refused(5, &[f64::NAN], range), DispersionError::Coefficient { .. }));
        assert!(matches!(refused(5, &[1.5], (0.7e-6, 0.4e-6)), DispersionError::Range { .. }));
        // A root of a negative number is no number.
        assert!(Formula::new(3, vec![-1.0], range).unwrap().at(0.5e-6).unwrap().is_nan());
    }
}
