//! What a slab between slides reflects and transmits.

use super::super::fresnel::dielectric_reflectance;
use super::super::{DiscreteOrdinates, Ground, Incidence, Layer, Moments, Stack};
use super::{InverseError, Sample};

/// Coefficients times thickness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Slab {
    pub absorption: f64,
    pub scattering: f64,
    pub asymmetry: f64,
}

impl Slab {
    pub fn reduced_scattering(&self) -> f64 {
        self.scattering * (1.0 - self.asymmetry)
    }
}

#[derive(Debug, Clone)]
pub(super) struct Forward {
    pub sample: Sample,
    solver: DiscreteOrdinates,
}

impl Forward {
    pub fn new(sample: Sample, streams: usize) -> Result<Self, InverseError> {
        let forward = Self { sample, solver: DiscreteOrdinates::with_streams(streams)? };
        Moments::henyey_greenstein(sample.asymmetry)?;
        forward.stack(&Slab { absorption: 1.0, scattering: 1.0, asymmetry: 0.0 })?.check()?;
        Ok(forward)
    }

    fn stack(&self, slab: &Slab) -> Result<Stack, InverseError> {
        let Slab { absorption, scattering, asymmetry } = *slab;
        let thickness = absorption + scattering;
        let albedo = if thickness > 0.0 { (scattering / thickness).min(1.0) } else { 0.0 };
        // One moment beyond what the streams can tell apart is the peak that they cannot.
        let moments: Vec<f64> = (0..=self.solver.streams as i32).map(|degree| asymmetry.powi(degree)).collect();
        let layer = Layer::new(thickness, albedo, Moments::new(moments)?).with_index(self.sample.refractive_index);
        let layers = if self.sample.slide_index == 1.0 {
            vec![layer]
        } else {
            let pane = Layer::pane(self.sample.slide_index, 0.0);
            vec![pane.clone(), layer, pane]
        };
        Ok(Stack { above: 1.0, layers, below: 1.0, ground: Ground::Black })
    }

    /// Reflectance, transmittance and unscattered transmittance as they are measured.
    pub fn shares(&self, slabs: &[Slab]) -> Result<Vec<[f64; 3]>, InverseError> {
        let stacks = slabs.iter().map(|slab| self.stack(slab)).collect::<Result<Vec<_>, _>>()?;
        let all = self.solver.shares_of(&stacks, &[Incidence::NORMAL])?;
        let sample = &self.sample;
        let measured = all.iter().flatten().map(|found| {
            let specular = (1.0 - sample.specular_in_reflectance) * found.reflectance_specular;
            let unscattered = (1.0 - sample.unscattered_in_transmittance) * found.transmittance_unscattered;
            [found.reflectance - specular, found.transmittance - unscattered, found.transmittance_unscattered]
        });
        Ok(measured.collect())
    }

    /// What one side of the sample reflects, with its slide, of light along the normal.
    pub fn surface_reflectance(&self) -> f64 {
        let Sample { refractive_index: n, slide_index: slide, .. } = self.sample;
        let (outer, inner) = (dielectric_reflectance(1.0, slide), dielectric_reflectance(1.0, n / slide));
        outer + (1.0 - outer).powi(2) * inner / (1.0 - outer * inner)
    }

    /// What a clear sample transmits.
    pub fn clear_transmittance(&self) -> f64 {
        let r = self.surface_reflectance();
        (1.0 - r) / (1.0 + r)
    }

    /// The optical thickness from the unscattered transmittance, at least 0: with `r` reflected by either side and
    /// `x = exp(-b)`, `T = (1 - r)^2 x / (1 - r^2 x^2)`.
    pub fn thickness(&self, unscattered: f64) -> f64 {
        let r = self.surface_reflectance();
        let (through, twice) = ((1.0 - r) * (1.0 - r), 2.0 * r * unscattered);
        let x = 2.0 * unscattered / (through + through.hypot(twice));
        (-x.ln()).max(0.0)
    }
}
