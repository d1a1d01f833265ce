//! A particle with or without layers, all checked.

use mieux_optics::Complex64;
use mieux_optics::mie::{Coefficients, PlaneWave, Sphere, SphereError, SphereScattering, scatter_spheres};
use rayon::prelude::*;

use super::JobError;

/// A sphere, or a sphere with layers around it, in a plane wave.
#[derive(Debug, Clone, PartialEq)]
pub struct Particle {
    wave: PlaneWave,
    /// Outer radius (m) and refractive index, from the inside outward; never empty.
    layers: Vec<(f64, Complex64)>,
}

impl Particle {
    /// From the core and the layers around it: outer radius (m) and refractive index of each.
    ///
    /// # Errors
    /// [`JobError::Mie`] when it cannot be computed.
    pub fn new(wave: PlaneWave, layers: impl IntoIterator<Item = (f64, Complex64)>) -> Result<Self, JobError> {
        let particle = Self { wave, layers: layers.into_iter().collect() };
        particle.sphere(1.0)?;
        Ok(particle)
    }

    /// The wave it is in.
    pub fn wave(&self) -> &PlaneWave {
        &self.wave
    }

    /// Outer radius, m.
    pub fn radius(&self) -> f64 {
        self.layers.last().map_or(0.0, |layer| layer.0)
    }

    fn sphere(&self, scale: f64) -> Result<Sphere, JobError> {
        let (radius, index) = self.layers[0];
        Ok(Sphere::new(self.wave, scale * radius, index)?)
    }

    /// Its coefficients.
    ///
    /// # Errors
    /// [`JobError::Mie`] when it cannot be computed.
    pub fn coefficients(&self) -> Result<Coefficients, JobError> {
        Ok(self.sphere(1.0)?.coefficients())
    }

    /// The scattering of particles so many times as large, in their order; those that cannot be computed are left out.
    /// With each goes its outer radius, m.
    pub fn scaled(&self, scales: &[f64]) -> Vec<(f64, SphereScattering)> {
        let spheres: Vec<(f64, Sphere)> =
            scales.iter().filter_map(|&s| Some((s * self.radius(), self.sphere(s).ok()?))).collect();
        let slices: Vec<Vec<(f64, SphereScattering)>> = spheres
            .par_chunks(16)
            .map(|slice| {
                let mut out = Vec::with_capacity(slice.len());
                if scatter(&slice.iter().map(|s| s.1).collect::<Vec<_>>(), &mut out).is_ok() {
                    return slice.iter().map(|s| s.0).zip(out).collect();
                }
                slice.iter().filter_map(|(radius, sphere)| Some((*radius, sphere.scattering().ok()?))).collect()
            })
            .collect();
        slices.concat()
    }
}

/// [`scatter_spheres`], in which spheres that differ much in size and go abreast can overflow: what is not finite is
/// computed once more by itself.
pub(super) fn scatter(spheres: &[Sphere], out: &mut Vec<SphereScattering>) -> Result<(), SphereError> {
    let first = out.len();
    scatter_spheres(spheres, out)?;
    for (index, (sphere, s)) in spheres.iter().zip(&mut out[first..]).enumerate() {
        if !(s.extinction.is_finite() && s.scattering.is_finite()) {
            *s = sphere.scattering().map_err(|source| SphereError { index, source })?;
        }
    }
    Ok(())
}
