//! Cross sections of the particles of one inclusion, over sizes.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use num_complex::Complex64;

use super::packing::HardSpheres;
use super::{Inclusion, MediumError, Packing, SizedBy};
use crate::integrate::gauss_legendre;
use crate::mie::{
    Coefficients, Directions, Layer, LayeredSphere, MieError, PlaneWave, Sphere, SphereScattering,
    scatter_layered_spheres, scatter_spheres,
};
use crate::particle::sphere_volume;

/// Modulus of a size parameter below which particles of many sizes are taken for a little larger: they scatter nothing, and
/// what they absorb goes by volume.
const TINY: f64 = 1e-6;

/// Part of it below which what lies inside a coat is left out.
const HOLLOW: f64 = 0.1;

/// A sphere that stands for particles, or for a part of one.
#[derive(Debug, Clone)]
pub(super) enum Ball {
    Homogeneous(Sphere),
    Layered(LayeredSphere),
}

impl Ball {
    pub fn coefficients(&self) -> Coefficients {
        match self {
            Self::Homogeneous(sphere) => sphere.coefficients(),
            Self::Layered(sphere) => sphere.coefficients(),
        }
    }
}

/// What particles of one size do, each number per volume of particles.
#[derive(Debug, Clone, Copy)]
pub(super) struct PerVolume {
    /// Scattering, 1/m.
    pub scattering: f64,
    /// Absorption beyond that of the host they displace, 1/m.
    pub absorption: f64,
    /// Scattering reduced by `1 - g`, 1/m.
    pub reduced: f64,
    /// `Im(S(0) / k^2)` over volume, 1/m.
    pub shift: f64,
    /// Scattering as if each particle were alone, 1/m.
    pub alone: f64,
}

/// Cross sections of the particles of one inclusion at one wavelength.
pub(super) struct Scatterer<'a> {
    pub(super) inclusion: &'a Inclusion,
    pub(super) wave: PlaneWave,
    core: Complex64,
    coats: Vec<Complex64>,
    fluid: Option<HardSpheres>,
    rules: BTreeMap<usize, (Vec<(f64, f64)>, Directions)>,
    balls: Vec<Ball>,
}

impl<'a> Scatterer<'a> {
    pub fn new(inclusion: &'a Inclusion, wavelength: f64, host: Complex64) -> Result<Self, MediumError> {
        let core = inclusion.substance.index(wavelength)?;
        let coats = inclusion.coats.iter().map(|coat| coat.substance().index(wavelength));
        Ok(Self {
            inclusion,
            wave: PlaneWave::new(wavelength, host).map_err(|source| mie_error(inclusion, source))?,
            core,
            coats: coats.collect::<Result<_, _>>()?,
            fluid: fluid(inclusion),
            rules: BTreeMap::new(),
            balls: Vec::new(),
        })
    }

    /// Modulus of the size parameter of the spheres that stand for particles of a size (m).
    pub fn size_parameter(&self, size: f64) -> f64 {
        TAU / self.wave.wavelength() * self.wave.host().norm() * self.radius(size)
    }

    fn radius(&self, size: f64) -> f64 {
        if self.inclusion.coats.is_empty() {
            self.inclusion.shape.equivalent_radius(size)
        } else {
            self.inclusion.outer_radius(size)
        }
    }

    /// What particles of every size (m) do. `many` says that they are nodes of an integral, in which the tiniest may be
    /// drawn together.
    pub fn per_volume(&mut self, sizes: &[f64], many: bool) -> Result<Vec<PerVolume>, MediumError> {
        let mut scale = Vec::with_capacity(sizes.len());
        self.balls.clear();
        for &size in sizes {
            let factor = if many { (TINY / self.size_parameter(size)).max(1.0) } else { 1.0 };
            let ball = self.ball(size, factor).map_err(|source| mie_error(self.inclusion, source))?;
            self.balls.push(ball);
            let shape = &self.inclusion.shape;
            let volume = if self.inclusion.coats.is_empty() {
                shape.volume(size) / shape.spheres(size).count
            } else {
                sphere_volume(self.radius(size))
            };
            scale.push(1.0 / (volume * factor.powi(3)));
        }
        let found = self.scattering()?;
        let mut out = Vec::with_capacity(sizes.len());
        for (i, s) in found.into_iter().enumerate() {
            let mut mean = [1.0, 1.0 - s.asymmetry];
            if let Some(fluid) = self.fluid
                && s.scattering > 0.0
            {
                mean = self.packed(i, &s, fluid)?;
            }
            let v = [s.scattering * mean[0], s.absorption, s.scattering * mean[1], s.forward.im, s.scattering];
            let [scattering, absorption, reduced, shift, alone] = v.map(|v| v * scale[i]);
            out.push(PerVolume { scattering, absorption, reduced, shift, alone });
        }
        Ok(out)
    }

    fn scattering(&self) -> Result<Vec<SphereScattering>, MediumError> {
        let mut found = Vec::with_capacity(self.balls.len());
        let result = if self.coats.is_empty() {
            let spheres: Vec<Sphere> = self
                .balls
                .iter()
                .filter_map(|ball| match ball {
                    Ball::Homogeneous(sphere) => Some(*sphere),
                    Ball::Layered(_) => None,
                })
                .collect();
            scatter_spheres(&spheres, &mut found)
        } else {
            let spheres: Vec<LayeredSphere> = self
                .balls
                .iter()
                .filter_map(|ball| match ball {
                    Ball::Layered(sphere) => Some(sphere.clone()),
                    Ball::Homogeneous(_) => None,
                })
                .collect();
            scatter_layered_spheres(&spheres, &mut found)
        };
        result.map_err(|error| mie_error(self.inclusion, error.source))?;
        Ok(found)
    }

    /// The sphere that stands for particles of a size, all its radii multiplied by `factor`.
    fn ball(&self, size: f64, factor: f64) -> Result<Ball, MieError> {
        if self.coats.is_empty() {
            return Ok(Ball::Homogeneous(Sphere::new(self.wave, factor * self.radius(size), self.core)?));
        }
        let extents: Vec<_> = self.inclusion.coats.iter().map(super::Coat::extent).collect();
        // Faces from the core outward.
        let mut faces = vec![size];
        match self.inclusion.sized_by {
            SizedBy::Core => extents.iter().for_each(|extent| faces.push(extent.outer(faces[faces.len() - 1]))),
            SizedBy::Outside => {
                extents.iter().rev().for_each(|extent| faces.push(extent.inner(faces[faces.len() - 1])));
                faces.reverse();
            }
        }
        let least = HOLLOW * TINY * self.wave.wavelength() / (TAU * self.wave.host().norm() * factor);
        let mut layers: Vec<Layer> = Vec::with_capacity(faces.len());
        let indices = std::iter::once(&self.core).chain(&self.coats);
        for (radius, index) in faces.into_iter().zip(indices) {
            let inside = layers.last().map_or(least, |layer| layer.radius);
            if radius * factor > inside {
                layers.push(Layer { radius: radius * factor, index: *index });
            }
        }
        Ok(Ball::Layered(LayeredSphere::new(self.wave, &layers)?))
    }

    /// Means over the phase function of one of the spheres of the structure factor, and of that times `1 - cos`.
    fn packed(&mut self, i: usize, s: &SphereScattering, fluid: HardSpheres) -> Result<[f64; 2], MediumError> {
        let coefficients = self.balls[i].coefficients();
        let count = node_count(coefficients.terms().len()).next_multiple_of(32);
        let (nodes, directions) = self.rules.entry(count).or_insert_with(|| {
            let nodes = gauss_legendre(count);
            let directions = Directions::new(nodes.iter().map(|(mu, _)| *mu));
            (nodes, directions)
        });
        let phase = coefficients.phase_function(directions).map_err(|source| mie_error(self.inclusion, source))?;
        let x = s.size_parameter.re;
        let (mut whole, mut mean) = (0.0, [0.0; 2]);
        for ((mu, weight), p) in nodes.iter().zip(phase) {
            let packed = weight * p * fluid.at(x, *mu);
            whole += weight * p;
            mean[0] += packed;
            mean[1] += packed * (1.0 - mu);
        }
        Ok(mean.map(|v| v / whole))
    }

    /// The spheres that [`Self::per_volume`] was last asked about, in their order.
    pub fn balls(&self) -> &[Ball] {
        &self.balls
    }
}

/// The fluid that the particles of an inclusion are, if that is asked for.
pub(super) fn fluid(inclusion: &Inclusion) -> Option<HardSpheres> {
    (inclusion.packing == Packing::PercusYevick).then(|| HardSpheres::new(inclusion.volume_fraction))
}

/// Nodes over the cosine that phase functions of so many terms want when a structure factor is in play: it has as fine a structure
/// as they have, and some finer.
pub(super) fn node_count(terms: usize) -> usize {
    3 * terms + 40
}

pub(super) fn mie_error(inclusion: &Inclusion, source: MieError) -> MediumError {
    MediumError::Mie { inclusion: inclusion.name.clone(), source }
}
