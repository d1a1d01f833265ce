//! Light: from all around, infinitely far away (frisvad2012, 4.2.3), from lamps without extent, and from surfaces that shine.

mod dome;
mod image;
mod lamp;
mod lights;
mod soft_box;
mod studio;

pub use dome::Dome;
pub use image::{MOST_CHANNELS, SkyImage};
pub use lamp::Lamp;
pub(crate) use lights::{Emitter, Lights, Problem, Segment, SkyLanes, Viewpoint};
pub use soft_box::SoftBox;
pub use studio::Studio;

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;
use mieux_optics::spectrum::{Sampled, WavelengthGrid, d65};

/// What can be wrong with a light.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum LightError {
    /// A brightness must be finite and not negative, and something must shine.
    #[error("{what} = {value}; a brightness is finite and not negative, and not all may be 0")]
    Brightness {
        /// Which one.
        what: &'static str,
        /// The offending value.
        value: f64,
    },
    /// Half extents of a soft box must be positive and finite, its edge between 0 and 1.
    #[error("{what} of a soft box = {value} {rule}")]
    Extent {
        /// Which one.
        what: &'static str,
        /// The offending value.
        value: f64,
        /// What is asked of it.
        rule: &'static str,
    },
    /// A soft box or a lamp needs a direction.
    #[error("{direction:?} is no direction for a light")]
    Direction {
        /// The offending direction.
        direction: [f64; 3],
    },
    /// A lamp stands somewhere.
    #[error("a lamp cannot stand at {position:?} m")]
    Position {
        /// The offending position, m.
        position: [f64; 3],
    },
    /// Angles of a spot light.
    #[error(
        "a spot light with half angles of {cutoff} degrees for its cone and {beam_width} for its beam; the cone lies above 0 and up to 180 degrees, the beam within it"
    )]
    Cone {
        /// Of the cone, degrees.
        cutoff: f64,
        /// Of the beam, degrees.
        beam_width: f64,
    },
    /// A picture of the surroundings.
    #[error("a picture cannot be the surroundings: {reason}")]
    Image {
        /// What is wrong.
        reason: String,
    },
}

/// How bright the surroundings are over direction, relative to the spectrum of the [`Environment`].
#[derive(Debug, Clone, PartialEq)]
pub enum Pattern {
    /// The same, 1, from everywhere: the white sky of a furnace test.
    Uniform,
    /// A photographer's studio.
    Studio(Studio),
    /// A picture, with spectra of its own that multiply the environment's.
    Image(Arc<SkyImage>),
}

/// Light from everywhere, seen in air (index 1): one spectrum times a pattern over direction.
///
/// Radiance is relative: [`Environment::daylight`] of brightness 1 makes a white surface that it lights from
/// everywhere come out as RGB (1, 1, 1).
#[derive(Debug, Clone, PartialEq)]
pub struct Environment {
    /// Radiance where the pattern is 1, over wavelength (m); not negative.
    pub spectrum: Sampled,
    /// How it varies over direction.
    pub pattern: Pattern,
}

impl Environment {
    /// A pattern of daylight: CIE D65, scaled to 1 at 560 nm.
    pub fn daylight(pattern: Pattern) -> Self {
        Self { spectrum: relative_d65(), pattern }
    }

    /// The white sky of a furnace test.
    pub fn white_sky() -> Self {
        Self::daylight(Pattern::Uniform)
    }
}

impl Pattern {
    /// Brightness from a direction (a unit vector towards the light); of a picture, the mean of its channels.
    pub fn value(&self, direction: DVec3) -> f64 {
        match self {
            Self::Uniform => 1.0,
            Self::Studio(studio) => studio.value(direction),
            Self::Image(image) => {
                let mut values = [0.0; MOST_CHANNELS];
                let count = image.values(direction, &mut values);
                values[..count].iter().sum::<f64>() / count as f64
            }
        }
    }

    /// The brightest value and the mean, from directions all over the sphere.
    fn peak_and_mean(&self) -> (f64, f64) {
        if let Self::Uniform = self {
            return (1.0, 1.0);
        }
        let (rows, columns) = (128u32, 256u32);
        let (mut peak, mut sum) = (0f64, 0.0);
        for i in 0..rows {
            for j in 0..columns {
                let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(rows);
                let value = self.value(about_z(z, (f64::from(j) + 0.5) / f64::from(columns)));
                peak = peak.max(value);
                sum += value;
            }
        }
        // What is too small to be met by the directions above is met by those drawn.
        let shares = [0.03, 0.17, 0.29, 0.41, 0.53, 0.67, 0.79, 0.97];
        for xi in shares.iter().flat_map(|a| shares.map(|b| [*a, b])) {
            peak = peak.max(self.value(self.sample(xi).0));
        }
        (peak, sum / f64::from(rows * columns))
    }

    /// Density of [`Self::sample`] in a direction, per solid angle.
    pub fn density(&self, direction: DVec3) -> f64 {
        match self {
            Self::Uniform => 0.25 / PI,
            Self::Studio(studio) => studio.density(direction),
            Self::Image(image) => image.density(direction),
        }
    }

    /// A direction towards the light from two uniform numbers in [0, 1), favouring bright ones, and its density.
    pub fn sample(&self, xi: [f64; 2]) -> (DVec3, f64) {
        let direction = match self {
            Self::Uniform => about_z(1.0 - 2.0 * xi[0], xi[1]),
            Self::Studio(studio) => studio.sample(xi),
            Self::Image(image) => image.sample(xi),
        };
        (direction, self.density(direction))
    }
}

/// CIE D65 scaled to 1 at 560 nm.
pub fn relative_d65() -> Sampled {
    let table = d65();
    let values = table.values().iter().map(|v| v / 100.0).collect();
    // A table with a finite value per wavelength stays one; the fallback can only be reached by an empty table.
    Sampled::new(table.grid().clone(), values).unwrap_or_else(|_| table.clone())
}

/// A spectrum that is the same at all wavelengths from 100 nm to 10 um.
pub fn constant(value: f64) -> Option<Sampled> {
    let grid = WavelengthGrid::new(vec![100e-9, 10e-6]).ok()?;
    Sampled::new(grid, vec![value; 2]).ok()
}

fn about_z(z: f64, turn: f64) -> DVec3 {
    let (sin, cos) = (2.0 * PI * turn).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    DVec3::new(r * cos, r * sin, z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_pcg::Pcg64Mcg;

    fn studio() -> Pattern {
        let dome = Dome { nadir: 0.3, horizon: 0.6, zenith: 0.9 };
        let boxes = vec![
            SoftBox::new([1.0, -1.0, 1.0], [0.5, 0.4], 0.4, 6.0).unwrap(),
            SoftBox::new([-1.0, 0.2, 0.6], [0.3, 0.8], 0.0, 2.0).unwrap(),
        ];
        Pattern::Studio(Studio::new(dome, boxes).unwrap())
    }

    /// Midpoints over the sphere: uniform in height and angle.
    fn sphere(n: u32) -> impl Iterator<Item = (DVec3, usize)> {
        (0..n).flat_map(move |i| {
            (0..2 * n).map(move |j| {
                let z = 2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0;
                (about_z(z, (f64::from(j) + 0.5) / f64::from(2 * n)), bin(z, (f64::from(j) + 0.5) / f64::from(2 * n)))
            })
        })
    }

    fn bin(z: f64, turn: f64) -> usize {
        let row = ((z + 1.0) * 8.0).clamp(0.0, 15.0) as usize;
        row * 32 + (turn.rem_euclid(1.0) * 32.0).min(31.0) as usize
    }

    /// The density integrates to 1, and samples fall into 512 bins as it says (chi-squared, three seeds).
    #[test]
    fn densities_are_normalised_and_samples_follow_them() {
        for pattern in [Pattern::Uniform, studio()] {
            let n = 1024;
            let cell = 4.0 * PI / f64::from(2 * n * n);
            let mut expected = vec![0.0; 512];
            sphere(n).for_each(|(d, b)| expected[b] += pattern.density(d) * cell);
            let total: f64 = expected.iter().sum();
            assert!((total - 1.0).abs() < 1e-3, "{total}");
            for seed in 1..=3u128 {
                let mut generator = Pcg64Mcg::new(seed << 64 | 0x1234_5671);
                let draws = 200_000;
                let mut counts = vec![0.0; 512];
                for _ in 0..draws {
                    let xi = [crate::sampler::uniform(&mut generator), crate::sampler::uniform(&mut generator)];
                    let (d, density) = pattern.sample(xi);
                    assert!((d.length() - 1.0).abs() < 1e-12 && density > 0.0);
                    counts[bin(d.z, d.y.atan2(d.x) / (2.0 * PI))] += 1.0;
                }
                let chi2: f64 = expected
                    .iter()
                    .zip(&counts)
                    .map(|(e, c)| (e / total * f64::from(draws), c))
                    .map(|(e, c)| (c - e).powi(2) / e)
                    .sum();
                // 511 degrees of freedom: 99.99 % lie below 637; a little more for the quadrature of the bins.
                assert!(chi2 < 660.0, "{chi2}");
            }
        }
    }

    #[test]
    fn daylight_is_one_at_560_nm() {
        assert!((relative_d65().at(560e-9).unwrap() - 1.0).abs() < 1e-12);
    }
}
