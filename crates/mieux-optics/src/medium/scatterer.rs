//! Cross sections of the particles of one inclusion, over sizes.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use num_complex::Complex64;

use super::packing::HardSpheres;
use super::smoothing::{Map, Smoothing};
use super::{Inclusion, MediumError, Packing, SizedBy};
use crate::integrate::{Converged, Integral, gauss_legendre, integrate_panels};
use crate::mie::{
    Coefficients, Directions, Layer, LayeredSphere, MieError, PlaneWave, Sphere, SphereScattering,
    scatter_layered_spheres, scatter_spheres,
};
use crate::particle::{Smooth, sphere_volume};

/// Modulus of a size parameter below which particles of many sizes are taken for a little larger: they scatter nothing, and
/// what they absorb goes by volume.
const TINY: f64 = 1e-6;

/// Part of it below which what lies inside a coat is left out.
const HOLLOW: f64 = 0.1;

/// Resonances of a sphere follow each other at about this distance in its size parameter: what a rule makes of one panel that
/// wide or wider says nothing about its neighbour.
const ROUGH: f64 = 1.0;

/// A sphere that stands for particles, or for a part of one.
#[derive(Clone)]
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
    inclusion: &'a Inclusion,
    wave: PlaneWave,
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

    /// Integrates scattering, absorption, reduced scattering, and `Im S(0)/k^2`, over all sizes; fifth the volume of the particles,
    /// sixth that of spheres of their sizes. Also returns the panels that were enough.
    pub fn integrate(
        &mut self,
        sizes: &dyn Smooth,
        tolerance: f64,
        floor: impl Fn(&[f64; 6]) -> [f64; 6],
    ) -> Result<Converged<6>, MediumError> {
        // Every distribution was checked for its volume.
        let knots = sizes.knots(3.0, 6.0).unwrap_or_default();
        let map = self.map(sizes);
        let rough = |from: f64, to: f64| (map.x(to) - map.x(from)).abs() > ROUGH;
        integrate_panels(&knots, tolerance, floor, rough, |nodes, values| self.values(sizes, nodes, |_| 1.0, values))?
            .ok_or_else(|| self.not_converged(tolerance))
    }

    /// [`Self::integrate`] with resonances and fringes of large spheres smoothed out: the integrand is averaged over a few of
    /// their periods in size, which leaves its integral as it is.
    pub fn integrate_smoothed(
        &mut self,
        sizes: &dyn Smooth,
        tolerance: f64,
        floor: impl Fn(&[f64; 6]) -> [f64; 6],
    ) -> Result<Integral<6>, MediumError> {
        let knots = sizes.knots(3.0, 6.0).unwrap_or_default();
        let map = self.map(sizes);
        let Some(smoothing) = self.smoothing([map.x(knots[0]), map.x(knots[knots.len() - 1])]) else {
            return Ok(self.integrate(sizes, tolerance, floor)?.0);
        };
        let whole = [knots[0], knots[knots.len() - 1]];
        let half = 0.5 * smoothing.width;
        let [from, to] = [smoothing.range[0] - half, smoothing.range[1] + half].map(|x| map.u(x, whole));
        let panels = (2.0 * (to - from)).ceil().max(1.0);
        let even: Vec<f64> = (0..=panels as usize).map(|i| from + (to - from) * i as f64 / panels).collect();
        let rough = |from: f64, to: f64| (map.x(to) - map.x(from)).abs() > smoothing.width;
        let not_converged = self.not_converged(tolerance);
        let mut total = integrate_panels(&even, tolerance, &floor, rough, |nodes, values| {
            self.smoothed(sizes, &map, &smoothing, nodes, values)
        })?
        .ok_or(not_converged)?
        .0;
        // What is left at either end.
        let rough = |from: f64, to: f64| (map.x(to) - map.x(from)).abs() > ROUGH;
        let [low, high] = smoothing.inner().map(|x| map.u(x, whole));
        let ends = [
            knots.iter().copied().filter(|u| *u < low).chain([low]).collect::<Vec<_>>(),
            std::iter::once(high).chain(knots.iter().copied().filter(|u| *u > high)).collect(),
        ];
        for end in ends {
            let known = total.value;
            let floor = |so_far: &[f64; 6]| {
                let all: [f64; 6] = std::array::from_fn(|k| known[k] + so_far[k]);
                let floor = floor(&all);
                std::array::from_fn(|k| floor[k] + known[k].abs())
            };
            let rest = |u: f64| 1.0 - smoothing.share(map.x(u));
            let found = integrate_panels(&end, tolerance, floor, rough, |nodes, values| {
                self.values(sizes, nodes, rest, values)
            })?;
            let found = found.ok_or_else(|| self.not_converged(tolerance))?.0;
            (0..6).for_each(|k| {
                total.value[k] += found.value[k];
                total.error[k] += found.error[k];
            });
        }
        Ok(total)
    }

    /// What is integrated, at nodes, times a weight.
    fn values(
        &mut self,
        sizes: &dyn Smooth,
        nodes: &[f64],
        weight: impl Fn(f64) -> f64,
        values: &mut Vec<[f64; 6]>,
    ) -> Result<(), MediumError> {
        let measures: Vec<(f64, f64)> = nodes.iter().map(|u| sizes.measure(*u)).collect();
        let radii: Vec<f64> = measures.iter().map(|(size, _)| *size).collect();
        let found = self.per_volume(&radii, true)?;
        values.extend(found.iter().zip(measures).zip(nodes).map(|((v, (size, sphere)), u)| {
            let sphere = sphere * weight(*u);
            let m = sphere * self.inclusion.bulk(size);
            [v.scattering * m, v.absorption * m, v.reduced * m, v.shift * m, m, sphere]
        }));
        Ok(())
    }

    /// The smoothed part of what is integrated, at nodes.
    fn smoothed(
        &mut self,
        sizes: &dyn Smooth,
        map: &Map<'_>,
        smoothing: &Smoothing,
        nodes: &[f64],
        values: &mut Vec<[f64; 6]>,
    ) -> Result<(), MediumError> {
        let (mut around, mut weights, mut counts) = (Vec::new(), Vec::new(), Vec::with_capacity(nodes.len()));
        for &u in nodes {
            let (x, slope) = (map.x(u), map.slope(u));
            let before = around.len();
            for (shift, weight) in smoothing.kernel() {
                let share = smoothing.share(x + shift);
                if share > 0.0 {
                    let v = map.near(x + shift, u + shift / slope);
                    around.push(v);
                    // Per size parameter, or what is moved would be stretched.
                    weights.push(weight * share * slope / map.slope(v));
                }
            }
            counts.push(around.len() - before);
        }
        let mut found = Vec::with_capacity(around.len());
        self.values(sizes, &around, |_| 1.0, &mut found)?;
        let mut weighted = found.iter().zip(&weights);
        for count in counts {
            let mut sum = [0.0; 6];
            for (found, weight) in weighted.by_ref().take(count) {
                (0..6).for_each(|k| sum[k] += weight * found[k]);
            }
            values.push(sum);
        }
        Ok(())
    }

    fn map<'m>(&self, sizes: &'m dyn Smooth) -> Map<'m>
    where
        'a: 'm,
    {
        let wave = TAU / self.wave.wavelength() * self.wave.host().norm();
        Map { inclusion: self.inclusion, sizes, wave }
    }

    /// How to smooth over a range of size parameters; `None` where that does not pay.
    fn smoothing(&self, [first, last]: [f64; 2]) -> Option<Smoothing> {
        if !self.inclusion.coats.is_empty() || self.fluid.is_some() || first >= last {
            return None;
        }
        let m = (self.core / self.wave.host()).re;
        let (width, steps) = if m > 1.0 {
            // Resonances follow each other at this distance (section 11.3 of `bohren1983`, from `chylek1976`).
            let root = (m * m - 1.0).sqrt();
            (4.0 * root.atan() / root, 24)
        } else if m < 1.0 {
            // Light through the middle against light past the edge.
            (3.0 * PI / (1.0 - m), 16)
        } else {
            return None;
        };
        // What is moved by half a width stays within the sizes there are.
        let range = [(first + 0.5 * width).max(40.0 * width), last - 0.5 * width];
        let smoothing = Smoothing { range, width, steps };
        let [low, high] = smoothing.inner();
        (low < high).then_some(smoothing)
    }

    fn not_converged(&self, tolerance: f64) -> MediumError {
        MediumError::NotConverged {
            inclusion: self.inclusion.name.clone(),
            tolerance,
            wavelength_m: self.wave.wavelength(),
        }
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
