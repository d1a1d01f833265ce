//! Paints whose K and S are known, and what becomes of them when they are mixed.

use super::{PaintError, Recipe};
use crate::spectrum::colour::Daylight;
use crate::spectrum::{Lab, SpectrumError, WavelengthGrid};
use crate::transfer::kubelka_munk::{Chart, Film, KubelkaMunkError, Saunderson, thickness_for};

/// One paint.
#[derive(Debug, Clone, PartialEq)]
pub struct Paint {
    /// What it is called.
    pub name: String,
    /// Absorption at every wavelength, above 0, relative to S of the reference.
    pub k: Vec<f64>,
    /// Scattering, likewise.
    pub s: Vec<f64>,
    /// Standard error of the logarithm of K, as a fit has it; empty when it is not known.
    pub k_error: Vec<f64>,
    /// Of that of S.
    pub s_error: Vec<f64>,
}

/// Paints at the same wavelengths, under the same surface.
#[derive(Debug, Clone, PartialEq)]
pub struct PaintSet {
    grid: WavelengthGrid,
    surface: Saunderson,
    reference: String,
    scattering: Option<f64>,
    paints: Vec<Paint>,
}

impl PaintSet {
    /// `reference` is the paint whose S is 1 at every wavelength.
    ///
    /// # Errors
    /// [`PaintError::Length`], [`PaintError::Twice`], [`PaintError::Spectrum`] for K or S that is not a finite number from 0
    /// up, [`PaintError::Film`] for the surface, [`PaintError::Unknown`] for the reference.
    pub fn new(
        grid: WavelengthGrid,
        surface: Saunderson,
        reference: String,
        paints: Vec<Paint>,
    ) -> Result<Self, PaintError> {
        for (i, paint) in paints.iter().enumerate() {
            if paints[..i].iter().any(|other| other.name == paint.name) {
                return Err(PaintError::Twice { paint: paint.name.clone() });
            }
            for values in [&paint.k, &paint.s] {
                let (found, expected) = (values.len(), grid.len());
                if found != expected {
                    return Err(PaintError::Length { sample: paint.name.clone(), found, expected });
                }
                if let Some((wavelength_m, &value)) =
                    grid.iter().zip(values).find(|(_, v)| !(**v >= 0.0 && v.is_finite()))
                {
                    return Err(SpectrumError::Value { wavelength_m, value }.into());
                }
            }
        }
        if !paints.iter().any(|paint| paint.name == reference) {
            return Err(PaintError::Unknown { paint: reference });
        }
        Ok(Self { grid, surface: surface.checked()?, reference, scattering: None, paints })
    }

    /// With the scattering coefficient S of the reference, 1/m, which gives every K and S its unit.
    ///
    /// # Errors
    /// [`PaintError::Film`] unless it is finite and above 0.
    pub fn with_scattering(self, value: f64) -> Result<Self, PaintError> {
        if !(value > 0.0 && value.is_finite()) {
            return Err(
                KubelkaMunkError::Negative { quantity: "scattering coefficient of the reference", value }.into()
            );
        }
        Ok(Self { scattering: Some(value), ..self })
    }

    /// The same paints at those of their wavelengths that lie within a range (m), both ends included.
    ///
    /// # Errors
    /// [`PaintError::Spectrum`] when none does.
    pub fn within(&self, (from, to): (f64, f64)) -> Result<Self, PaintError> {
        let inside: Vec<bool> =
            self.grid.iter().map(|w| w >= from * (1.0 - 1e-12) && w <= to * (1.0 + 1e-12)).collect();
        let keep = |values: &[f64]| {
            values.iter().zip(&inside).filter(|(_, inside)| **inside).map(|(value, _)| *value).collect::<Vec<f64>>()
        };
        let paints = self.paints.iter().map(|paint| Paint {
            name: paint.name.clone(),
            k: keep(&paint.k),
            s: keep(&paint.s),
            k_error: keep(&paint.k_error),
            s_error: keep(&paint.s_error),
        });
        Ok(Self { grid: WavelengthGrid::new(keep(self.grid.as_slice()))?, paints: paints.collect(), ..self.clone() })
    }

    /// The wavelengths, m.
    pub fn grid(&self) -> &WavelengthGrid {
        &self.grid
    }

    /// The surface of every sample.
    pub fn surface(&self) -> Saunderson {
        self.surface
    }

    /// Name of the paint whose S is the unit.
    pub fn reference(&self) -> &str {
        &self.reference
    }

    /// S of the reference, 1/m, where it is known.
    pub fn scattering(&self) -> Option<f64> {
        self.scattering
    }

    /// The paints.
    pub fn paints(&self) -> &[Paint] {
        &self.paints
    }

    /// How the CIE 1931 observer sees these wavelengths under D65.
    pub fn daylight(&self) -> Daylight {
        Daylight::new(&self.grid)
    }

    /// K and S of a mixture, relative to S of the reference, at every wavelength.
    ///
    /// # Errors
    /// [`PaintError::Unknown`].
    pub fn mixture(&self, recipe: &Recipe) -> Result<Vec<(f64, f64)>, PaintError> {
        let mut sum = vec![(0.0, 0.0); self.grid.len()];
        for (name, share) in recipe.parts() {
            let paint = self.paints.iter().find(|paint| paint.name == *name);
            let paint = paint.ok_or_else(|| PaintError::Unknown { paint: name.clone() })?;
            for (sum, (k, s)) in sum.iter_mut().zip(paint.k.iter().zip(&paint.s)) {
                *sum = (sum.0 + share * k, sum.1 + share * s);
            }
        }
        Ok(sum)
    }

    /// Reflectance of an opaque mixture as the instrument would measure it, at every wavelength.
    ///
    /// # Errors
    /// [`PaintError::Unknown`].
    pub fn reflectance(&self, recipe: &Recipe) -> Result<Vec<f64>, PaintError> {
        let mixture = self.mixture(recipe)?;
        mixture
            .into_iter()
            .map(|(k, s)| Ok(self.surface.measured(Film::new(k, s, 0.0)?.reflectance_infinite())))
            .collect()
    }

    /// That of a film (m) over a backing of known reflectance in optical contact, the same at every wavelength.
    ///
    /// # Errors
    /// [`PaintError::Relative`] when [`PaintSet::scattering`] is not known, [`PaintError::Unknown`], [`PaintError::Film`].
    pub fn reflectance_over(&self, recipe: &Recipe, thickness: f64, backing: f64) -> Result<Vec<f64>, PaintError> {
        let unit = self.scattering.ok_or_else(|| PaintError::Relative { reference: self.reference.clone() })?;
        let over = |(k, s): (f64, f64)| {
            let film = Film::new(unit * k, unit * s, thickness)?;
            Ok(self.surface.measured(film.reflectance_over(backing)?))
        };
        self.mixture(recipe)?.into_iter().map(over).collect()
    }

    /// The thickness (m) at which a mixture hides a chart to this ratio of luminances (D65, CIE 1931, surface included).
    ///
    /// # Errors
    /// As [`PaintSet::reflectance_over`], and [`KubelkaMunkError::NeverHides`].
    pub fn hiding_thickness(&self, recipe: &Recipe, chart: Chart, wanted: f64) -> Result<f64, PaintError> {
        let unit = self.scattering.ok_or_else(|| PaintError::Relative { reference: self.reference.clone() })?;
        let daylight = self.daylight();
        let mixture = self.mixture(recipe)?;
        let luminance = |thickness: f64, backing: f64| {
            let over = |(k, s): &(f64, f64)| {
                let film = Film::new(unit * k, unit * s, thickness)?;
                Ok::<_, KubelkaMunkError>(self.surface.measured(film.reflectance_over(backing)?))
            };
            let reflectance: Vec<f64> = mixture.iter().map(over).collect::<Result<_, _>>()?;
            Ok::<_, KubelkaMunkError>(daylight.xyz(&reflectance)[1])
        };
        let ratio = |thickness: f64| Ok(luminance(thickness, chart.black)? / luminance(thickness, chart.white)?);
        Ok(thickness_for(wanted, 0.1 / unit, ratio)?)
    }

    /// L*a*b* of a reflectance at the wavelengths of the paints.
    pub fn lab(&self, reflectance: &[f64]) -> Lab {
        self.daylight().lab(reflectance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set() -> PaintSet {
        let grid = WavelengthGrid::regular(400e-9, 700e-9, 10e-9).unwrap();
        let flat = |name: &str, k: f64, s: f64| Paint {
            name: name.into(),
            k: vec![k; grid.len()],
            s: vec![s; grid.len()],
            k_error: vec![],
            s_error: vec![],
        };
        let paints = vec![flat("white", 0.002, 1.0), flat("black", 3.0, 0.3)];
        let surface = Saunderson::directional(1.5, 1.0).unwrap();
        PaintSet::new(grid.clone(), surface, "white".into(), paints).unwrap()
    }

    #[test]
    fn a_thick_film_is_opaque_and_hides_at_its_thickness() {
        let set = set().with_scattering(1e5).unwrap();
        let grey = Recipe::new([("white".into(), 0.95), ("black".into(), 0.05)]).unwrap();
        let opaque = set.reflectance(&grey).unwrap();
        let thick = set.reflectance_over(&grey, 1e-2, 0.0).unwrap();
        assert!(opaque.iter().zip(&thick).all(|(a, b)| (a - b).abs() < 1e-9));
        let thickness = set.hiding_thickness(&grey, Chart::default(), 0.98).unwrap();
        let y = |backing: f64| set.daylight().xyz(&set.reflectance_over(&grey, thickness, backing).unwrap())[1];
        assert!((y(0.0) / y(0.8) - 0.98).abs() < 1e-9, "{thickness}");
        assert!(thickness > 1e-6 && thickness < 1e-3);
    }

    #[test]
    fn a_part_of_the_spectrum_is_a_set_of_its_own() {
        let part = set().within((500e-9, 600e-9)).unwrap();
        assert_eq!((part.grid().len(), part.paints()[0].k.len(), part.reference()), (11, 11, "white"));
        assert!(set().within((800e-9, 900e-9)).is_err());
    }

    #[test]
    fn grey_paint_is_grey() {
        let set = set();
        let lab = set.lab(&set.reflectance(&Recipe::pure("black")).unwrap());
        assert!(lab.chroma() < 1e-9 && lab.l < 35.0, "{lab:?}");
    }

    #[test]
    fn relative_paints_have_no_thickness_and_strangers_are_named() {
        let set = set();
        let white = Recipe::pure("white");
        assert!(matches!(set.reflectance_over(&white, 1e-3, 0.0), Err(PaintError::Relative { .. })));
        assert_eq!(set.reflectance(&Recipe::pure("blu")), Err(PaintError::Unknown { paint: "blu".into() }));
        assert!(set.with_scattering(0.0).is_err());
    }
}
