//! The surface of a film.

use super::{KubelkaMunkError, measured, share};
use crate::transfer::fresnel::{DiffuseReflectance, dielectric_reflectance};

/// Saunderson's correction (`saunderson1942`): what the surface does to light on its way in and out.
///
/// It takes the light inside, at the surface, to be Lambertian. Inside a film that absorbs it is steeper than that, and less
/// of it is reflected back in: at albedo 0.9 and index 1.5 (isotropic scattering, diffuse light, thick) the corrected
/// two-flux answer is 0.299 where the transfer equation has 0.260. Fitted and applied with the same numbers, most of this
/// error goes into K and S and comes out again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Saunderson {
    /// `k1`: share of the light from outside that the surface reflects, in [0, 1).
    pub external: f64,
    /// `k2`: share of the diffuse light from inside that it reflects, in [0, 1).
    pub internal: f64,
    /// How much of what the surface reflects an instrument counts, in [0, 1]: 1 with the specular component included, 0 with
    /// it excluded (and for 45/0), between for a surface that is not quite smooth.
    pub specular: f64,
}

impl Saunderson {
    /// No surface.
    pub const NONE: Self = Self { external: 0.0, internal: 0.0, specular: 0.0 };

    /// A smooth surface of a medium of this index, from 1 to 10, under light from one direction; the cosine of its angle with
    /// the normal, in (0, 1]. The specular component is included.
    ///
    /// # Errors
    /// [`KubelkaMunkError::RefractiveIndex`] or [`KubelkaMunkError::Share`].
    pub fn directional(index: f64, cosine: f64) -> Result<Self, KubelkaMunkError> {
        let moments = moments(index)?;
        let cosine = share("cosine", cosine)?;
        let external = dielectric_reflectance(cosine, index);
        Self { external, internal: moments.internal(), specular: 1.0 }.checked()
    }

    /// The same under diffuse light.
    ///
    /// # Errors
    /// [`KubelkaMunkError::RefractiveIndex`].
    pub fn diffuse(index: f64) -> Result<Self, KubelkaMunkError> {
        let moments = moments(index)?;
        Self { external: moments.external, internal: moments.internal(), specular: 1.0 }.checked()
    }

    /// The same for an instrument that counts this share of the specular component.
    pub fn with_specular(self, specular: f64) -> Self {
        Self { specular, ..self }
    }

    /// Itself, when it can be.
    ///
    /// # Errors
    /// [`KubelkaMunkError::Share`].
    pub fn checked(self) -> Result<Self, KubelkaMunkError> {
        for (quantity, value) in
            [("external reflectance k1", self.external), ("internal reflectance k2", self.internal)]
        {
            if share(quantity, value)? == 1.0 {
                return Err(KubelkaMunkError::Share { quantity, value });
            }
        }
        share("share of the specular component", self.specular)?;
        Ok(self)
    }

    /// The least there is to measure: over a film that sends nothing back.
    pub fn floor(&self) -> f64 {
        self.specular * self.external
    }

    /// What an instrument measures on a film of this reflectance (in [0, 1]) under its surface.
    pub fn measured(&self, internal: f64) -> f64 {
        let passed = (1.0 - self.external) * (1.0 - self.internal);
        self.floor() + passed * internal / (1.0 - self.internal * internal)
    }

    /// How fast that grows with the reflectance under the surface.
    pub fn slope(&self, internal: f64) -> f64 {
        let passed = (1.0 - self.external) * (1.0 - self.internal);
        let left = 1.0 - self.internal * internal;
        passed / (left * left)
    }

    /// The reflectance under the surface, strictly between 0 and 1, from a measured one, likewise.
    ///
    /// # Errors
    /// [`KubelkaMunkError::Reflectance`] for what is no reflectance, or more than any film under this surface has;
    /// [`KubelkaMunkError::DarkerThanSurface`].
    pub fn internal(&self, reflectance: f64) -> Result<f64, KubelkaMunkError> {
        measured("reflectance", reflectance)?;
        if reflectance <= self.floor() {
            return Err(KubelkaMunkError::DarkerThanSurface { value: reflectance, surface: self.floor() });
        }
        let y = (reflectance - self.floor()) / ((1.0 - self.external) * (1.0 - self.internal));
        let internal = y / (1.0 + self.internal * y);
        measured("reflectance under the surface", internal)
    }
}

fn moments(index: f64) -> Result<DiffuseReflectance, KubelkaMunkError> {
    let of = if (1.0..=10.0).contains(&index) { DiffuseReflectance::new(index) } else { None };
    of.ok_or(KubelkaMunkError::RefractiveIndex { value: index })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back() {
        for index in [1.0, 1.33, 1.5, 1.7] {
            for surface in [Saunderson::directional(index, 0.99).unwrap(), Saunderson::diffuse(index).unwrap()] {
                for surface in [surface, surface.with_specular(0.0), surface.with_specular(0.3)] {
                    for internal in [1e-6, 0.05, 0.5, 0.9, 0.999] {
                        let back = surface.internal(surface.measured(internal)).unwrap();
                        assert!((back - internal).abs() < 1e-9, "{surface:?} {internal}: {back}");
                        let step = 1e-3 * internal * (1.0 - internal);
                        let slope =
                            (surface.measured(internal + step) - surface.measured(internal - step)) / (2.0 * step);
                        assert!((slope / surface.slope(internal) - 1.0).abs() < 1e-4);
                    }
                }
            }
        }
    }

    #[test]
    fn a_film_that_loses_nothing_sends_everything_back() {
        let surface = Saunderson::diffuse(1.5).unwrap();
        assert!((surface.measured(1.0) - 1.0).abs() < 1e-15);
        assert_eq!(surface.measured(0.0), surface.external);
        assert_eq!(Saunderson::NONE.measured(0.3), 0.3);
    }

    #[test]
    fn what_cannot_be_is_refused() {
        assert!(Saunderson::diffuse(0.9).is_err() && Saunderson::directional(1.5, -0.1).is_err());
        assert!(Saunderson::directional(f64::NAN, 1.0).is_err() && Saunderson::directional(1.5, 0.0).is_err());
        let surface = Saunderson::directional(1.5, 1.0).unwrap();
        for reflectance in [0.0, 0.02, 0.04, 1.0, 33.0, f64::NAN] {
            assert!(surface.internal(reflectance).is_err(), "{reflectance}");
        }
        assert!(surface.with_specular(2.0).checked().is_err());
    }
}
