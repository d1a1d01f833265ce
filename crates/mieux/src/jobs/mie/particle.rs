//! A particle with or without layers, all checked.

use mieux_optics::Complex64;
use mieux_optics::mie::{
    Coefficients, Layer, LayeredSphere, MieError, PlaneWave, Sphere, SphereError, SphereScattering,
    scatter_layered_spheres, scatter_spheres,
};
use rayon::prelude::*;

use super::JobError;

/// How many particles one thread computes abreast.
const ABREAST: usize = 16;

/// A sphere, or a sphere with layers around it, in a plane wave.
#[derive(Debug, Clone, PartialEq)]
pub struct Particle {
    wave: PlaneWave,
    core: Layer,
    /// Around the core, from the inside outward.
    coats: Vec<Layer>,
}

impl Particle {
    /// From the core and what is around it, from the inside outward: outer radius (m) and refractive index of each.
    ///
    /// # Errors
    /// [`JobError::Mie`] when it cannot be computed.
    pub fn new(
        wave: PlaneWave,
        core: (f64, Complex64),
        coats: impl IntoIterator<Item = (f64, Complex64)>,
    ) -> Result<Self, JobError> {
        let layer = |(radius, index)| Layer { radius, index };
        let particle = Self { wave, core: layer(core), coats: coats.into_iter().map(layer).collect() };
        if particle.coats.is_empty() { particle.sphere(1.0).map(drop) } else { particle.layered(1.0).map(drop) }?;
        Ok(particle)
    }

    /// Outer radius, m.
    pub fn radius(&self) -> f64 {
        self.coats.last().unwrap_or(&self.core).radius
    }

    fn sphere(&self, scale: f64) -> Result<Sphere, MieError> {
        Sphere::new(self.wave, scale * self.core.radius, self.core.index)
    }

    fn layered(&self, scale: f64) -> Result<LayeredSphere, MieError> {
        let layers = std::iter::once(&self.core).chain(&self.coats);
        let scaled: Vec<Layer> = layers.map(|l| Layer { radius: scale * l.radius, index: l.index }).collect();
        LayeredSphere::new(self.wave, &scaled)
    }

    /// Its coefficients.
    ///
    /// # Errors
    /// [`JobError::Mie`] when it cannot be computed.
    pub fn coefficients(&self) -> Result<Coefficients, JobError> {
        Ok(if self.coats.is_empty() { self.sphere(1.0)?.coefficients() } else { self.layered(1.0)?.coefficients() })
    }

    /// The scattering of particles so many times as large, in their order; those that cannot be computed are left out.
    /// With each goes its outer radius, m.
    pub fn scaled(&self, scales: &[f64]) -> Vec<(f64, SphereScattering)> {
        let radius = self.radius();
        if self.coats.is_empty() {
            let spheres = scales.iter().filter_map(|&s| Some((s * radius, self.sphere(s).ok()?))).unzip();
            abreast(spheres, scatter_spheres, Sphere::scattering)
        } else {
            let spheres = scales.iter().filter_map(|&s| Some((s * radius, self.layered(s).ok()?))).unzip();
            abreast(spheres, scatter_layered_spheres, LayeredSphere::scattering)
        }
    }
}

/// Computes many particles on all threads, and one by one where one of them cannot be.
fn abreast<T: Sync>(
    (radii, particles): (Vec<f64>, Vec<T>),
    many: fn(&[T], &mut Vec<SphereScattering>) -> Result<(), SphereError>,
    one: fn(&T) -> Result<SphereScattering, MieError>,
) -> Vec<(f64, SphereScattering)> {
    let slices = radii.par_chunks(ABREAST).zip(particles.par_chunks(ABREAST)).map(|(radii, particles)| {
        let mut out = Vec::with_capacity(particles.len());
        if many(particles, &mut out).is_ok() {
            return radii.iter().copied().zip(out).collect();
        }
        radii.iter().zip(particles).filter_map(|(radius, particle)| Some((*radius, one(particle).ok()?))).collect()
    });
    slices.collect::<Vec<Vec<_>>>().concat()
}
