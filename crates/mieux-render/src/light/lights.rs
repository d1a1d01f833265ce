//! All lights of a scene, and which of them to look at from where.

use std::f64::consts::PI;

use glam::DVec3;

use super::image::MOST_CHANNELS;
use super::lamp::Place;
use super::{Environment, Lamp, LightError, Pattern};
use crate::geometry::Mesh;
use crate::integrator::{LANES, Lanes};
use crate::medium::{Dense, MediumError};

/// Surroundings whose brightest direction is this much brighter than their mean are looked at directly from within media;
/// others are found as well by scattering.
const PEAKED: f64 = 8.0;

/// The lights of a scene laid out for rendering.
pub(crate) struct Lights {
    pattern: Pattern,
    spectrum: Dense,
    channels: Vec<Dense>,
    /// Radiance of the surroundings, mean over directions and wavelengths.
    mean: f64,
    peaked: bool,
    /// Lamps, then surfaces that shine.
    sources: Vec<Source>,
    lamps: usize,
}

struct Source {
    centre: DVec3,
    radius: f64,
    /// Fluence at 1 m, or anywhere if it is far away; mean over wavelengths.
    strength: f64,
    spectrum: Dense,
    shape: Shape,
}

enum Shape {
    Lamp(Place),
    Mesh(MeshLight),
}

/// A surface that shines.
struct MeshLight {
    triangles: Vec<[DVec3; 3]>,
    /// Cumulative shares of the area.
    chances: Vec<f64>,
    area: f64,
}

/// A surface that shines, as the scene tells it.
pub(crate) struct Emitter<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) radiance: Dense,
}

/// Where lights are looked at from.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Viewpoint {
    /// One place; the surroundings count if asked for.
    Point { place: DVec3, surroundings: bool },
    /// Anywhere along a piece of a ray through a homogeneous medium.
    Segment(Segment),
}

/// A piece of a ray through a homogeneous medium.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Segment {
    pub(crate) origin: DVec3,
    pub(crate) direction: DVec3,
    pub(crate) length: f64,
    pub(crate) sigma_t: Lanes,
}

/// Light that may reach a place.
pub(crate) struct Sample {
    pub(crate) direction: DVec3,
    /// Distance to the light, m; infinite for surroundings.
    pub(crate) distance: f64,
    /// Radiance; for lights without extent, irradiance across the direction.
    pub(crate) radiance: Lanes,
    /// Density per solid angle; 1 for lights without extent.
    pub(crate) density: f64,
    /// Whether only looking at it finds it.
    pub(crate) point: bool,
}

/// Spectra of the surroundings at the wavelengths of a path.
pub(crate) struct SkyLanes {
    spectrum: Lanes,
    channels: [Lanes; MOST_CHANNELS],
}

impl Lights {
    pub(crate) fn new(
        environment: &Environment,
        lamps: &[Lamp],
        emitters: Vec<Emitter<'_>>,
        range: (f64, f64),
    ) -> Result<Self, Problem> {
        let rule = "must not be negative";
        let valid = |v: f64| v >= 0.0 && v.is_finite();
        let dense = |spectrum| Dense::new("radiance", spectrum, range, rule, valid);
        let spectrum = dense(&environment.spectrum)?;
        let channels = match &environment.pattern {
            // Primaries of colours may dip below nothing; what they add up to is cut there.
            Pattern::Image(image) => image
                .channels()
                .iter()
                .map(|channel| Dense::new("radiance", channel, range, "must be finite", f64::is_finite))
                .collect::<Result<_, _>>()?,
            _ => Vec::new(),
        };
        let mut sources = Vec::with_capacity(lamps.len() + emitters.len());
        for lamp in lamps {
            sources.push(Source::lamp(lamp.place()?, dense(lamp.spectrum())?));
        }
        sources.extend(emitters.into_iter().map(Source::emitter));
        let (peak, mean) = environment.pattern.peak_and_mean();
        let mean_spectrum = spectrum.mean();
        Ok(Self {
            pattern: environment.pattern.clone(),
            mean: mean * mean_spectrum,
            peaked: mean_spectrum > 0.0 && peak > PEAKED * mean,
            spectrum,
            channels,
            sources,
            lamps: lamps.len(),
        })
    }

    /// Whether there is anything that is better looked at from within a medium than found by chance.
    pub(crate) fn worth_looking(&self) -> bool {
        self.peaked || !self.sources.is_empty()
    }

    /// Whether any light has a place or a shape of its own.
    pub(crate) fn has_places(&self) -> bool {
        !self.sources.is_empty()
    }

    /// Whether the surroundings are to be looked at from within media.
    pub(crate) fn peaked(&self) -> bool {
        self.peaked
    }

    /// Where the lights that have a place are.
    pub(crate) fn places(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.sources.iter().flat_map(|source| match &source.shape {
            Shape::Lamp(Place::Far { .. }) => None,
            Shape::Lamp(_) => Some(source.centre),
            Shape::Mesh(mesh) => mesh.triangles.first().map(|t| t[0]),
        })
    }

    pub(crate) fn sky(&self, wavelengths: &Lanes) -> SkyLanes {
        let mut channels = [[0.0; LANES]; MOST_CHANNELS];
        for (lanes, channel) in channels.iter_mut().zip(&self.channels) {
            *lanes = channel.lanes(wavelengths);
        }
        SkyLanes { spectrum: self.spectrum.lanes(wavelengths), channels }
    }

    /// Radiance of the surroundings from a direction.
    pub(crate) fn surroundings(&self, direction: DVec3, sky: &SkyLanes) -> Lanes {
        match &self.pattern {
            Pattern::Image(image) => {
                let mut values = [0.0; MOST_CHANNELS];
                let count = image.values(direction, &mut values);
                let sum = |k: usize| values[..count].iter().zip(&sky.channels).map(|(v, c)| v * c[k]).sum::<f64>();
                std::array::from_fn(|k| sky.spectrum[k] * sum(k).max(0.0))
            }
            pattern => {
                let value = pattern.value(direction);
                sky.spectrum.map(|s| s * value)
            }
        }
    }

    /// Radiance of the shining surface `emitter` (by its place among those that shine).
    pub(crate) fn emitted(&self, emitter: usize, wavelengths: &Lanes) -> Lanes {
        self.sources[self.lamps + emitter].spectrum.lanes(wavelengths)
    }

    /// How much a light counts; the surroundings come after the last source.
    fn weight(&self, light: usize, from: &Viewpoint) -> f64 {
        match (self.sources.get(light), from) {
            (Some(source), Viewpoint::Point { place, .. }) => source.fluence(*place),
            (Some(source), Viewpoint::Segment(segment)) => source.along(segment),
            (None, Viewpoint::Point { surroundings, .. }) => {
                if *surroundings {
                    4.0 * PI * self.mean
                } else {
                    0.0
                }
            }
            (None, Viewpoint::Segment(segment)) => {
                if self.peaked {
                    4.0 * PI * self.mean * segment.reach()
                } else {
                    0.0
                }
            }
        }
    }

    fn total(&self, from: &Viewpoint) -> f64 {
        (0..=self.sources.len()).map(|light| self.weight(light, from)).sum()
    }

    /// A light by its weight, from a uniform number, and its chance; `None` if nothing shines.
    pub(crate) fn choose(&self, from: &Viewpoint, xi: f64) -> Option<(usize, f64)> {
        let total = self.total(from);
        if total <= 0.0 || total.is_nan() {
            return None;
        }
        let mut left = xi * total;
        let mut last = None;
        for light in 0..=self.sources.len() {
            let weight = self.weight(light, from);
            if weight > 0.0 {
                last = Some((light, weight / total));
                if left < weight {
                    break;
                }
                left -= weight;
            }
        }
        last
    }

    /// Light that may reach `place` from a chosen light.
    pub(crate) fn sample(
        &self,
        light: usize,
        place: DVec3,
        xi: [f64; 2],
        wavelengths: &Lanes,
        sky: &SkyLanes,
    ) -> Option<Sample> {
        let Some(source) = self.sources.get(light) else {
            let (direction, density) = self.pattern.sample(xi);
            let radiance = self.surroundings(direction, sky);
            return (density > 0.0).then_some(Sample {
                direction,
                distance: f64::INFINITY,
                radiance,
                density,
                point: false,
            });
        };
        source.sample(place, xi, wavelengths)
    }

    /// Where along a segment light from one of the lights is looked for, as densities for each wavelength.
    pub(crate) fn place_along(&self, light: usize, segment: &Segment, xi: [f64; 2]) -> f64 {
        let near = self.sources.get(light).filter(|source| source.is_near());
        near.map_or_else(|| segment.exponential(xi[1]), |source| segment.sample(source, xi))
    }

    /// Density of [`Self::place_along`] for each wavelength, 1/m.
    pub(crate) fn density_along(&self, light: usize, segment: &Segment, t: f64) -> Lanes {
        let near = self.sources.get(light).filter(|source| source.is_near());
        near.map_or_else(|| segment.exponential_density(t), |source| segment.density(source, t))
    }

    /// Density with which the surroundings would have been found in a direction by looking: per solid angle, for each
    /// wavelength; along a segment, times the density of the place at `t`.
    pub(crate) fn density_of_surroundings(&self, from: &Viewpoint, t: f64, direction: DVec3) -> Lanes {
        self.density(self.sources.len(), from, t, |_| self.pattern.density(direction))
    }

    /// The same for a point of a shining surface, met at `distance` under `cosine` from `place`.
    pub(crate) fn density_of_emitter(
        &self,
        emitter: usize,
        from: &Viewpoint,
        t: f64,
        distance: f64,
        cosine: f64,
    ) -> Lanes {
        self.density(self.lamps + emitter, from, t, |source| match source.map(|s| &s.shape) {
            Some(Shape::Mesh(mesh)) => distance * distance / (mesh.area * cosine.abs().max(1e-300)),
            _ => 0.0,
        })
    }

    fn density(&self, light: usize, from: &Viewpoint, t: f64, of: impl Fn(Option<&Source>) -> f64) -> Lanes {
        let total = self.total(from);
        if total <= 0.0 || total.is_nan() {
            return [0.0; LANES];
        }
        let density = self.weight(light, from) / total * of(self.sources.get(light));
        match from {
            Viewpoint::Point { .. } => [density; LANES],
            Viewpoint::Segment(segment) => self.density_along(light, segment, t).map(|d| d * density),
        }
    }
}

/// What is wrong with a light.
#[derive(Debug)]
pub(crate) enum Problem {
    Light(LightError),
    Spectrum(MediumError),
}

impl From<LightError> for Problem {
    fn from(error: LightError) -> Self {
        Self::Light(error)
    }
}

impl From<MediumError> for Problem {
    fn from(error: MediumError) -> Self {
        Self::Spectrum(error)
    }
}

impl Source {
    fn lamp(place: Place, spectrum: Dense) -> Self {
        let centre = if let Place::Near { position, .. } = place { position } else { DVec3::ZERO };
        Self { centre, radius: 0.0, strength: spectrum.mean(), spectrum, shape: Shape::Lamp(place) }
    }

    fn emitter(emitter: Emitter<'_>) -> Self {
        let triangles: Vec<[DVec3; 3]> = (0..emitter.mesh.triangles().len()).map(|t| emitter.mesh.corners(t)).collect();
        let mut area = 0.0;
        let mut chances: Vec<f64> = triangles
            .iter()
            .map(|[a, b, c]| {
                area += 0.5 * (*b - *a).cross(*c - *a).length();
                area
            })
            .collect();
        chances.iter_mut().for_each(|chance| *chance /= area);
        let (low, high) = emitter.mesh.bounds();
        Self {
            centre: 0.5 * (low + high),
            radius: 0.5 * (high - low).length(),
            strength: emitter.radiance.mean() * area * 0.25,
            spectrum: emitter.radiance,
            shape: Shape::Mesh(MeshLight { triangles, chances, area }),
        }
    }

    fn is_near(&self) -> bool {
        !matches!(self.shape, Shape::Lamp(Place::Far { .. }))
    }

    /// About the fluence at a place, without shadows.
    fn fluence(&self, place: DVec3) -> f64 {
        if !self.is_near() {
            return self.strength;
        }
        let squared = (place - self.centre).length_squared() + 0.25 * self.radius * self.radius;
        self.strength / squared.max(f64::MIN_POSITIVE)
    }

    /// About the fluence integrated along a segment, as far as the medium lets it count.
    fn along(&self, segment: &Segment) -> f64 {
        if !self.is_near() {
            return self.strength * segment.reach();
        }
        let (aside, from, to) = segment.angles(self);
        self.strength * (to - from) / aside
    }

    fn sample(&self, place: DVec3, xi: [f64; 2], wavelengths: &Lanes) -> Option<Sample> {
        let radiance = self.spectrum.lanes(wavelengths);
        match &self.shape {
            Shape::Lamp(Place::Far { direction }) => {
                Some(Sample { direction: -*direction, distance: f64::INFINITY, radiance, density: 1.0, point: true })
            }
            Shape::Lamp(near @ Place::Near { position, .. }) => {
                let towards = *position - place;
                let squared = towards.length_squared();
                let direction = towards.try_normalize()?;
                let factor = near.profile(-direction) / squared;
                let radiance = radiance.map(|r| r * factor);
                Some(Sample { direction, distance: squared.sqrt(), radiance, density: 1.0, point: true })
            }
            Shape::Mesh(mesh) => mesh.sample(place, xi, radiance),
        }
    }
}

impl MeshLight {
    fn sample(&self, place: DVec3, [u, v]: [f64; 2], radiance: Lanes) -> Option<Sample> {
        let i = self.chances.partition_point(|&c| c <= u).min(self.chances.len() - 1);
        let before = if i > 0 { self.chances[i - 1] } else { 0.0 };
        let u = ((u - before) / (self.chances[i] - before)).clamp(0.0, 1.0 - f64::EPSILON);
        let [a, b, c] = self.triangles[i];
        let root = u.sqrt();
        let at = a * (1.0 - root) + b * (root * (1.0 - v)) + c * (root * v);
        let normal = (b - a).cross(c - a).try_normalize()?;
        let towards = at - place;
        let squared = towards.length_squared();
        let direction = towards.try_normalize()?;
        let cosine = -direction.dot(normal);
        if cosine <= 0.0 {
            return None;
        }
        let density = squared / (self.area * cosine);
        density.is_finite().then_some(Sample { direction, distance: squared.sqrt(), radiance, density, point: false })
    }
}

impl Segment {
    fn mean_sigma_t(&self) -> f64 {
        self.sigma_t.iter().sum::<f64>() / LANES as f64
    }

    /// Length that counts: all of it, or a mean free path.
    fn reach(&self) -> f64 {
        self.length.min(1.0 / self.mean_sigma_t().max(f64::MIN_POSITIVE))
    }

    /// Distance of a light from the line, and the angles under which it sees both ends from its nearest point.
    fn angles(&self, source: &Source) -> (f64, f64, f64) {
        let (aside, nearest) = self.nearest(source);
        (aside, (-nearest / aside).atan(), ((self.length - nearest) / aside).atan())
    }

    fn nearest(&self, source: &Source) -> (f64, f64) {
        let to = source.centre - self.origin;
        let nearest = to.dot(self.direction);
        let aside = (to - self.direction * nearest).length();
        (aside.max(0.5 * source.radius).max(1e-6 * self.length).max(f64::MIN_POSITIVE), nearest)
    }

    /// Share of the places chosen by angle rather than by transmittance: more the less the medium dims.
    fn by_angle(&self, aside: f64) -> f64 {
        (1.0 / (1.0 + self.mean_sigma_t() * aside)).clamp(0.1, 0.9)
    }

    fn sample(&self, source: &Source, [choice, xi]: [f64; 2]) -> f64 {
        let (aside, from, to) = self.angles(source);
        if choice < self.by_angle(aside) {
            let (_, nearest) = self.nearest(source);
            (nearest + aside * (from + (to - from) * xi).tan()).clamp(0.0, self.length)
        } else {
            self.exponential(xi)
        }
    }

    fn density(&self, source: &Source, t: f64) -> Lanes {
        let (aside, from, to) = self.angles(source);
        let (_, nearest) = self.nearest(source);
        let share = self.by_angle(aside);
        let angular = aside / ((to - from) * (aside * aside + (t - nearest).powi(2)));
        self.exponential_density(t).map(|d| share * angular + (1.0 - share) * d)
    }

    /// A place by the hero's transmittance.
    fn exponential(&self, xi: f64) -> f64 {
        let sigma = self.sigma_t[0];
        let depth = sigma * self.length;
        if depth < 1e-6 {
            return xi * self.length;
        }
        (-(xi * (-depth).exp_m1()).ln_1p() / sigma).min(self.length)
    }

    fn exponential_density(&self, t: f64) -> Lanes {
        self.sigma_t.map(|sigma| {
            let depth = sigma * self.length;
            if depth < 1e-6 { 1.0 / self.length } else { sigma * (-sigma * t).exp() / -(-depth).exp_m1() }
        })
    }
}
