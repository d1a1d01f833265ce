//! Whole populations in one call: radii by wavelengths.

use num_complex::Complex64;
use rayon::prelude::*;

use super::sphere::{CHUNK, Sphere, scatter_spheres};
use super::wave::{PlaneWave, SphereScattering};
use super::{MieError, ScatteringDefinition};

/// Spheres of many radii of one substance in one host, at many wavelengths.
#[derive(Debug, Clone, Copy)]
pub struct Population<'a> {
    /// Radii, m.
    pub radii: &'a [f64],
    /// Vacuum wavelengths, m.
    pub wavelengths: &'a [f64],
    /// Refractive index of the host at every wavelength.
    pub host: &'a [Complex64],
    /// Refractive index of the particles at every wavelength.
    pub particle: &'a [Complex64],
    /// What scattering means.
    pub definition: ScatteringDefinition,
}

/// What every sphere of a population does: vectors of `wavelengths.len() * radii.len()` entries, all radii of the first
/// wavelength first.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PopulationScattering {
    /// Extinction cross sections, m^2.
    pub extinction: Vec<f64>,
    /// Scattering cross sections, m^2.
    pub scattering: Vec<f64>,
    /// Absorption cross sections, m^2.
    pub absorption: Vec<f64>,
    /// Mean cosines of scattering.
    pub asymmetry: Vec<f64>,
    /// `S(0) / k^2`, m^2.
    pub forward: Vec<Complex64>,
}

/// Why a population could not be computed.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PopulationError {
    /// As many indices as wavelengths are needed.
    #[error("{wavelengths} wavelengths, but {host} indices of the host and {particle} of the particles")]
    Lengths {
        /// Number of wavelengths.
        wavelengths: usize,
        /// Number of indices of the host.
        host: usize,
        /// Number of indices of the particles.
        particle: usize,
    },
    /// A sphere that could not be computed.
    #[error("radius {radius_m:e} m at the wavelength {wavelength_m:e} m: {source}")]
    Sphere {
        /// Its radius, m.
        radius_m: f64,
        /// The wavelength, m.
        wavelength_m: f64,
        /// What was wrong.
        source: MieError,
    },
}

/// Spheres that go to one thread at a time, whole wavelengths or even parts of one; not for the number of threads to decide,
/// so that results do not depend on it.
fn batch_length(radii: usize) -> usize {
    if radii > CHUNK { radii.div_ceil(radii.div_ceil(CHUNK)) } else { CHUNK - CHUNK % radii.max(1) }
}

impl Population<'_> {
    /// Scattering by every sphere, on all threads of the current pool of rayon; the same bits on any number of them.
    ///
    /// # Errors
    /// [`PopulationError`].
    pub fn scatter(&self) -> Result<PopulationScattering, PopulationError> {
        let count = self.radii.len() * self.wavelengths.len();
        let mut all = PopulationScattering {
            extinction: vec![0.0; count],
            scattering: vec![0.0; count],
            absorption: vec![0.0; count],
            asymmetry: vec![0.0; count],
            forward: vec![Complex64::ZERO; count],
        };
        self.scatter_into(&mut all)?;
        Ok(all)
    }

    /// [`Population::scatter`] into the memory of earlier results, as for fits: fresh memory costs a tenth of the time.
    ///
    /// # Errors
    /// [`PopulationError`], after which what is in `all` has no meaning.
    pub fn scatter_into(&self, all: &mut PopulationScattering) -> Result<(), PopulationError> {
        let Self { radii, wavelengths, host, particle, .. } = *self;
        if wavelengths.len() != host.len() || wavelengths.len() != particle.len() {
            let (wavelengths, host, particle) = (wavelengths.len(), host.len(), particle.len());
            return Err(PopulationError::Lengths { wavelengths, host, particle });
        }
        let count = radii.len() * wavelengths.len();
        for numbers in [&mut all.extinction, &mut all.scattering, &mut all.absorption, &mut all.asymmetry] {
            numbers.resize(count, 0.0);
        }
        all.forward.resize(count, Complex64::ZERO);
        let length = batch_length(radii.len());
        (
            all.extinction.par_chunks_mut(length),
            all.scattering.par_chunks_mut(length),
            all.absorption.par_chunks_mut(length),
            all.asymmetry.par_chunks_mut(length),
            all.forward.par_chunks_mut(length),
        )
            .into_par_iter()
            .enumerate()
            .try_for_each_init(
                Scratch::default,
                |scratch, (k, (extinction, scattering, absorption, asymmetry, forward))| {
                    self.batch(k * length, extinction.len(), scratch)?;
                    for (i, s) in scratch.out.iter().enumerate() {
                        (extinction[i], scattering[i], absorption[i]) = (s.extinction, s.scattering, s.absorption);
                        (asymmetry[i], forward[i]) = (s.asymmetry, s.forward);
                    }
                    Ok(())
                },
            )
    }

    /// The spheres from `first` on, into `scratch.out`.
    fn batch(&self, first: usize, count: usize, scratch: &mut Scratch) -> Result<(), PopulationError> {
        let place = |i: usize| (i / self.radii.len(), i % self.radii.len());
        let error = |i: usize, source: MieError| {
            let (w, r) = place(i);
            PopulationError::Sphere { radius_m: self.radii[r], wavelength_m: self.wavelengths[w], source }
        };
        let Scratch { spheres, out } = scratch;
        out.clear();
        let mut i = first;
        while i < first + count {
            let (w, r) = place(i);
            let wave = PlaneWave::new(self.wavelengths[w], self.host[w]).map_err(|e| error(i, e))?;
            let wave = wave.with_definition(self.definition);
            let last = self.radii.len().min(r + first + count - i);
            // One wavelength at a time: radii often come in order.
            spheres.clear();
            for (k, radius) in self.radii[r..last].iter().enumerate() {
                spheres.push(Sphere::new(wave, *radius, self.particle[w]).map_err(|e| error(i + k, e))?);
            }
            scatter_spheres(spheres, out).map_err(|e| error(i + e.index, e.source))?;
            i += spheres.len();
        }
        Ok(())
    }
}

/// What one thread works with.
#[derive(Default)]
struct Scratch {
    spheres: Vec<Sphere>,
    out: Vec<SphereScattering>,
}

#[cfg(test)]
mod tests {
    use super::super::scatter_sphere;
    use super::*;

    fn population<'a>(radii: &'a [f64], indices: &'a [Complex64; 4]) -> Population<'a> {
        let definition = ScatteringDefinition::default();
        Population { radii, wavelengths: &[450e-9, 650e-9], host: &indices[..2], particle: &indices[2..], definition }
    }

    #[test]
    fn a_population_is_its_spheres_one_by_one() {
        let indices = [(1.34, 0.0), (1.33, 1e-4), (1.5, 1e-3), (1.2, 0.0)].map(|(re, im)| Complex64::new(re, im));
        let radii: Vec<f64> = (0..3000).map(|i| 1e-9 * 1.004f64.powi((i * 7919) % 3000)).collect();
        let population = population(&radii, &indices);
        let all = population.scatter().unwrap();
        for (i, radius) in radii.iter().enumerate().step_by(97) {
            for w in 0..2 {
                let one = scatter_sphere(*radius, population.wavelengths[w], indices[w], indices[w + 2]).unwrap();
                let at = w * radii.len() + i;
                assert!((all.extinction[at] / one.extinction - 1.0).abs() < 1e-12);
                assert!((all.asymmetry[at] / one.asymmetry - 1.0).abs() < 1e-10);
            }
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        assert_eq!(all, pool.install(|| population.scatter().unwrap()));
        let mut again = Population {
            radii: &radii[..1200],
            wavelengths: &[500e-9],
            host: &indices[..1],
            particle: &indices[2..3],
            ..population
        }
        .scatter()
        .unwrap();
        population.scatter_into(&mut again).unwrap();
        assert_eq!(all, again);
    }

    #[test]
    fn batches_are_whole_wavelengths_or_even_parts_of_one() {
        assert_eq!([1, 7, CHUNK, CHUNK + 1, 1000, 0].map(batch_length), [512, 511, 512, 257, 500, 512]);
    }

    #[test]
    fn what_is_wrong_with_one_sphere_is_told() {
        let indices = [(1.34, 0.0), (1.33, 0.0), (1.5, 0.0), (1.5, -1.0)].map(|(re, im)| Complex64::new(re, im));
        let error = population(&[1e-6, 2e-6], &indices).scatter().unwrap_err();
        assert!(matches!(error, PopulationError::Sphere { wavelength_m: 650e-9, source: MieError::Index { .. }, .. }));
        let short = Population { host: &indices[..1], ..population(&[1e-6], &indices) };
        assert!(matches!(short.scatter(), Err(PopulationError::Lengths { host: 1, .. })));
    }
}
