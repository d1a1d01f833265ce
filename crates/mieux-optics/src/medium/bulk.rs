//! From particles to coefficients: the sums and integrals of `frisvad2007` section 2.2.

use std::f64::consts::PI;

use num_complex::Complex64;
use rayon::prelude::*;

use super::scatterer::Scatterer;
use super::{Inclusion, Medium, MediumError, absorption_coefficient};
use crate::particle::{Part, Spread};
use crate::spectrum::{Sampled, SpectrumError, WavelengthGrid};

/// Relative tolerance of the integral over radius unless another is asked for.
pub const DEFAULT_TOLERANCE: f64 = 1e-4;

/// Share of reduced scattering below which the integral over radius takes absorption for 0.
const ABSORPTION_FLOOR: f64 = 1e-3;

/// Optical properties of a bulk medium at one wavelength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpticsAt {
    /// Scattering coefficient, 1/m.
    pub sigma_s: f64,
    /// Absorption coefficient, 1/m.
    pub sigma_a: f64,
    /// Mean cosine of scattering.
    pub asymmetry: f64,
    /// Real part of the effective refractive index.
    pub n_real: f64,
    /// Relative errors that the integral over sizes is believed to have left.
    pub relative_error: RelativeError,
}

/// Relative errors that the integral over sizes is believed to have left; usually overestimates.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RelativeError {
    /// Of scattering.
    pub scattering: f64,
    /// Of reduced scattering, `(1 - g) sigma_s`.
    pub reduced: f64,
    /// Of absorption, or of 1e-3 of reduced scattering where that is more.
    pub absorption: f64,
}

impl RelativeError {
    /// The largest of them.
    pub fn largest(&self) -> f64 {
        self.scattering.max(self.reduced).max(self.absorption)
    }

    /// Each the larger of two.
    fn or_worse(self, other: Self) -> Self {
        Self {
            scattering: self.scattering.max(other.scattering),
            reduced: self.reduced.max(other.reduced),
            absorption: self.absorption.max(other.absorption),
        }
    }
}

/// Spectral optical properties of a bulk medium; all vectors are as long as the grid.
#[derive(Debug, Clone, PartialEq)]
pub struct BulkOptics {
    grid: WavelengthGrid,
    sigma_s: Vec<f64>,
    sigma_a: Vec<f64>,
    asymmetry: Vec<f64>,
    n_real: Vec<f64>,
    relative_error: RelativeError,
}

impl BulkOptics {
    /// Puts together what [`Medium::optics_at`] found at each wavelength of a grid.
    ///
    /// # Errors
    /// [`SpectrumError::Length`] unless there is one entry per wavelength.
    pub fn new(grid: WavelengthGrid, at: &[OpticsAt]) -> Result<Self, SpectrumError> {
        if grid.len() != at.len() {
            return Err(SpectrumError::Length { wavelengths: grid.len(), values: at.len() });
        }
        Ok(Self {
            grid,
            sigma_s: at.iter().map(|o| o.sigma_s).collect(),
            sigma_a: at.iter().map(|o| o.sigma_a).collect(),
            asymmetry: at.iter().map(|o| o.asymmetry).collect(),
            n_real: at.iter().map(|o| o.n_real).collect(),
            relative_error: at.iter().map(|o| o.relative_error).fold(RelativeError::default(), RelativeError::or_worse),
        })
    }

    /// The wavelengths, m.
    pub fn grid(&self) -> &WavelengthGrid {
        &self.grid
    }

    /// Scattering coefficient, 1/m, never negative.
    pub fn sigma_s(&self) -> &[f64] {
        &self.sigma_s
    }

    /// Absorption coefficient, 1/m, host and particles together, never negative.
    pub fn sigma_a(&self) -> &[f64] {
        &self.sigma_a
    }

    /// Mean cosine of scattering; 0 where nothing scatters.
    pub fn asymmetry(&self) -> &[f64] {
        &self.asymmetry
    }

    /// Real part of the effective refractive index, as [`EffectiveIndex`](super::EffectiveIndex) says.
    pub fn n_real(&self) -> &[f64] {
        &self.n_real
    }

    /// Imaginary part of the effective refractive index, from the bulk absorption by eq 6.
    pub fn n_imag(&self) -> Vec<f64> {
        let pairs = self.grid.iter().zip(&self.sigma_a);
        pairs.map(|(wavelength, sigma_a)| sigma_a * wavelength / (4.0 * std::f64::consts::PI)).collect()
    }

    /// Extinction coefficient, 1/m.
    pub fn sigma_t(&self) -> Vec<f64> {
        self.sigma_s.iter().zip(&self.sigma_a).map(|(s, a)| s + a).collect()
    }

    /// Reduced scattering coefficient `(1 - g) sigma_s`, 1/m.
    pub fn reduced_scattering(&self) -> Vec<f64> {
        self.sigma_s.iter().zip(&self.asymmetry).map(|(s, g)| s * (1.0 - g)).collect()
    }

    /// Largest relative errors over all wavelengths that the integral over sizes is believed to have left.
    pub fn relative_error(&self) -> RelativeError {
        self.relative_error
    }

    /// One of the vectors as a spectrum on this grid.
    pub fn spectrum(&self, values: &[f64]) -> Result<Sampled, MediumError> {
        Ok(Sampled::new(self.grid.clone(), values.to_vec())?)
    }
}

/// Sums over one inclusion at one wavelength, per metre of medium.
struct Contribution {
    scattering: f64,
    absorption: f64,
    reduced: f64,
    /// `sum N Im(S(0)/k^2)`, to be multiplied by the wavelength; 1/m.
    index_shift: f64,
    /// Believed errors of scattering, absorption and reduced scattering, 1/m.
    error: [f64; 3],
    panels: InclusionPanels,
}

/// Panels in `u` that were enough for each part of the sizes of an inclusion; none for a part of one size.
pub(super) type InclusionPanels = Vec<Vec<[f64; 2]>>;

/// Coefficients at one wavelength, and what else the integral over sizes found.
pub(super) struct Integrated {
    pub optics: OpticsAt,
    /// `1 - g` with all its digits.
    pub lack: f64,
    /// Of each inclusion.
    pub panels: Vec<InclusionPanels>,
}

impl Medium {
    /// Bulk optical properties on a grid of vacuum wavelengths: [`Self::optics_at`] for each, on all threads of the current
    /// pool of rayon.
    ///
    /// # Errors
    /// As for [`Self::optics_at`].
    pub fn bulk_optics(&self, grid: &WavelengthGrid, tolerance: f64) -> Result<BulkOptics, MediumError> {
        let wavelengths = grid.as_slice().par_iter();
        let at: Result<Vec<_>, _> = wavelengths.map(|wavelength| self.optics_at(*wavelength, tolerance)).collect();
        Ok(BulkOptics::new(grid.clone(), &at?)?)
    }

    /// Bulk optical properties at a vacuum wavelength (m), the integral over radius converged to `tolerance` (relative,
    /// 1e-12 to 1; [`DEFAULT_TOLERANCE`] is plenty for pictures) in scattering, reduced scattering and absorption
    /// alike, absorption to that or to 1e-3 of it times reduced scattering. The resonances of spheres of thousands of wavelengths are
    /// not followed that far: there, what is reached in some tenths of a second for each inclusion is given, and
    /// [`OpticsAt::relative_error`] says how good it is.
    ///
    /// Particles scatter independently of each other, unless a [`Packing`](super::Packing) is asked for. Source: eq 27-33 of
    /// `frisvad2007`.
    ///
    /// # Errors
    /// [`MediumError`] when the wavelength is outside the data, a particle outside Lorenz-Mie's reach, or the integral
    /// does not converge.
    pub fn optics_at(&self, wavelength: f64, tolerance: f64) -> Result<OpticsAt, MediumError> {
        Ok(self.integrated_at(wavelength, tolerance)?.optics)
    }

    /// [`Self::optics_at`] with the panels of the integral.
    pub(super) fn integrated_at(&self, wavelength: f64, tolerance: f64) -> Result<Integrated, MediumError> {
        if !(1e-12..=1.0).contains(&tolerance) {
            return Err(MediumError::Tolerance { tolerance });
        }
        let host = self.host().index(wavelength)?;
        let host_absorption = absorption_coefficient(host, wavelength);
        let (mut scattering, mut reduced, mut absorption) = (0.0, 0.0, host_absorption);
        // Of the wave in the medium, by particles each alone.
        let mut dilute = Complex64::ZERO;
        let mut error = [0.0; 3];
        let mut panels = Vec::with_capacity(self.inclusions().len());
        for inclusion in self.inclusions() {
            let part = contribution(inclusion, wavelength, host, host_absorption, tolerance)?;
            scattering += part.scattering;
            reduced += part.reduced;
            absorption += part.absorption;
            let extinction = part.scattering + part.absorption;
            dilute += wavelength * Complex64::new(-part.index_shift, extinction / (4.0 * PI));
            (0..3).for_each(|k| error[k] += part.error[k]);
            panels.push(part.panels);
        }
        let relative = |k: usize, value: f64| if value > 0.0 { error[k] / value } else { 0.0 };
        let lack = if scattering > 0.0 { reduced / scattering } else { 1.0 };
        let optics = OpticsAt {
            sigma_s: scattering,
            sigma_a: absorption,
            asymmetry: 1.0 - lack,
            n_real: self.effective_index().index(host, dilute).re,
            relative_error: RelativeError {
                scattering: relative(0, scattering),
                reduced: relative(2, reduced),
                absorption: relative(1, absorption.max(ABSORPTION_FLOOR * reduced)),
            },
        };
        Ok(Integrated { optics, lack, panels })
    }
}

fn contribution(
    inclusion: &Inclusion,
    wavelength: f64,
    host: Complex64,
    host_absorption: f64,
    tolerance: f64,
) -> Result<Contribution, MediumError> {
    let mut scatterer = Scatterer::new(inclusion, wavelength, host)?;
    let fraction = inclusion.volume_fraction;
    // Absorption need be no better than the host's share of it, or than 1e-3 of reduced scattering, beside which nobody
    // sees it (the resonances of nearly lossless droplets would cost a thousand times the rest); the index no better than
    // 1e-2 of the tolerance.
    let floor = |so_far: &[f64; 6]| {
        let absorption = host_absorption / fraction * so_far[4] + ABSORPTION_FLOOR * so_far[2];
        [0.0, absorption, 0.0, 1e-2 / (wavelength * fraction) * so_far[4], 0.0, 0.0]
    };
    let mut sum = [0.0; 5];
    let mut error = [0.0; 3];
    let mut all_panels = Vec::new();
    for Part { share, sizes } in inclusion.sizes.parts() {
        match sizes {
            Spread::One(size) => {
                let v = scatterer.per_volume(&[size], false)?[0];
                let amount = share * inclusion.bulk(size);
                let v = [v.scattering, v.absorption, v.reduced, v.shift, 1.0];
                (0..5).for_each(|k| sum[k] += amount * v[k]);
                all_panels.push(Vec::new());
            }
            Spread::Smooth(sizes) => {
                let (integral, panels) = scatterer.integrate(sizes, tolerance, floor)?;
                let scale = share / integral.value[5];
                (0..5).for_each(|k| sum[k] += scale * integral.value[k]);
                let volume = integral.error[4] / integral.value[4];
                (0..3).for_each(|k| error[k] += scale * (integral.error[k] + integral.value[k].abs() * volume));
                all_panels.push(panels.iter().map(|panel| [panel.from, panel.to]).collect());
            }
        }
    }
    let scale = fraction / sum[4];
    let [scattering, absorption, reduced, index_shift, _] = sum.map(|v| v * scale);
    Ok(Contribution {
        scattering,
        absorption,
        reduced,
        index_shift,
        error: error.map(|e| e * scale),
        panels: all_panels,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::medium::EffectiveIndex;
    use crate::particle::{LogNormal, SizeDistribution, Weighting};
    use crate::substance::{Conditions, Substance};

    fn constant(re: f64, im: f64) -> Substance {
        Substance::Constant(Complex64::new(re, im))
    }

    fn spheres(radius_m: f64, substance: Substance, volume_fraction: f64) -> Inclusion {
        let sizes = SizeDistribution::monodisperse(radius_m).unwrap();
        Inclusion::new("spheres", substance, sizes, volume_fraction)
    }

    fn at_550(host: Substance, inclusion: Inclusion) -> BulkOptics {
        let grid = WavelengthGrid::new(vec![550e-9]).unwrap();
        Medium::new(host, vec![inclusion]).unwrap().bulk_optics(&grid, 1e-6).unwrap()
    }

    /// Small lossless spheres have the index of Maxwell Garnett (`maxwellgarnett1904`): to second order in volume fraction, in
    /// fact to all. The dilute form is short of it by `3/8 n_host (f K)^2`, the second order of its expansion.
    #[test]
    fn small_spheres_shift_the_index_as_maxwell_garnett_says() {
        let (host, particle) = (1.33f64, 1.5f64);
        let (eh, ep) = (host * host, particle * particle);
        let contrast = (ep - eh) / (ep + 2.0 * eh);
        let difference = |fraction: f64, form| {
            let inclusion = spheres(1e-12, constant(particle, 0.0), fraction);
            let medium = Medium::new(constant(host, 0.0), vec![inclusion]).unwrap().with_effective_index(form);
            let a = fraction * contrast;
            let maxwell_garnett = (eh * (1.0 + 2.0 * a) / (1.0 - a)).sqrt();
            medium.optics_at(550e-9, 1e-6).unwrap().n_real - maxwell_garnett
        };
        for fraction in [1e-3, 1e-2, 0.1, 0.4] {
            let short = difference(fraction, EffectiveIndex::LorentzLorenz).abs();
            assert!(short < 1e-11, "{fraction}: {short:e}");
            let second = -0.375 * host * (fraction * contrast).powi(2);
            let short = difference(fraction, EffectiveIndex::Dilute) / second;
            assert!((short - 1.0).abs() < 0.7 * fraction, "{fraction}: {short}");
        }
        let b = at_550(constant(host, 0.0), spheres(1e-11, constant(particle, 0.0), 1e-2));
        assert!(b.n_real()[0] > host);
    }

    /// Small bubbles take host absorption away. Large ones do too, but the projection of their scattering to the surface
    /// (`exp(-alpha)/gamma`, eq 23) books `5/3 alpha` of it, with `alpha` the host's absorption times the radius, as
    /// absorbed: the price of that definition, stated here as a number.
    #[test]
    fn bubbles_reduce_absorption() {
        let host = constant(1.33, 1e-6);
        let pure = absorption_coefficient(Complex64::new(1.33, 1e-6), 550e-9);
        let b = at_550(host.clone(), spheres(5e-9, constant(1.0, 0.0), 0.1));
        assert!(b.sigma_a()[0] > 0.8 * pure && b.sigma_a()[0] < pure, "{} of {pure}", b.sigma_a()[0]);
        let radius = 10e-6;
        let b = at_550(host, spheres(radius, constant(1.0, 0.0), 0.1));
        let booked = 5.0 / 3.0 * pure * radius * b.sigma_s()[0];
        assert!(((b.sigma_a()[0] - booked) / (0.9 * pure) - 1.0).abs() < 0.02);
    }

    #[test]
    fn an_inclusion_that_matches_the_host_is_not_seen() {
        let b = at_550(constant(1.33, 1e-7), spheres(1e-6, constant(1.33, 1e-7), 0.2));
        assert!(b.sigma_s()[0] < 1e-12);
        assert!((b.n_real()[0] - 1.33).abs() < 1e-12);
    }

    #[test]
    fn a_tighter_tolerance_agrees_within_the_looser_one() {
        let grid = WavelengthGrid::new(vec![450e-9, 550e-9, 650e-9]).unwrap();
        let sizes = LogNormal::from_mean(Weighting::Volume, 0.8e-6, 0.5e-6).unwrap();
        let sizes = SizeDistribution::LogNormal(sizes.truncated(5e-9, 10e-6).unwrap());
        let drops = Inclusion::new("drops", constant(1.46, 5e-6), sizes, 0.03);
        let medium = Medium::new(constant(1.335, 1e-9), vec![drops]).unwrap();
        let loose = medium.bulk_optics(&grid, 1e-3).unwrap();
        let tight = medium.bulk_optics(&grid, 1e-9).unwrap();
        assert!(tight.relative_error().largest() <= 3e-9 && loose.relative_error().largest() <= 3e-3);
        for i in 0..grid.len() {
            for (a, b) in [(&loose.sigma_s, &tight.sigma_s), (&loose.sigma_a, &tight.sigma_a)] {
                assert!((a[i] / b[i] - 1.0).abs() < 1e-3);
            }
            assert!((loose.reduced_scattering()[i] / tight.reduced_scattering()[i] - 1.0).abs() < 1e-3);
        }
    }

    #[test]
    fn impossible_media_are_refused() {
        let water = Substance::named("water", Conditions::default()).unwrap();
        let make = |fraction| Medium::new(water.clone(), vec![spheres(1e-6, constant(1.5, 0.0), fraction)]);
        assert!(matches!(make(-0.1), Err(MediumError::VolumeFraction { .. })));
        assert!(matches!(make(f64::NAN), Err(MediumError::VolumeFraction { .. })));
        assert!(make(0.0).unwrap().inclusions().is_empty());
        let half = spheres(1e-6, constant(1.5, 0.0), 0.6);
        assert!(matches!(Medium::new(water.clone(), vec![half.clone(), half]), Err(MediumError::Overfull { .. })));
        let infrared = WavelengthGrid::new(vec![2e-6]).unwrap();
        assert!(matches!(make(0.1).unwrap().bulk_optics(&infrared, 1e-4), Err(MediumError::Substance(_))));
    }

    proptest::proptest! {
        #![proptest_config(proptest::prelude::ProptestConfig::with_cases(64))]
        #[test]
        fn bulk_coefficients_are_never_negative(
            radius in -8.5f64..-5.0, n in 1.0f64..2.0, k in -9.0f64..-1.0, host_k in -10.0f64..-4.0, fraction in 0.0f64..0.5,
        ) {
            let host = constant(1.33, 10f64.powf(host_k));
            let b = at_550(host, spheres(10f64.powf(radius), constant(n, 10f64.powf(k)), fraction));
            proptest::prop_assert!(b.sigma_s()[0] >= 0.0 && b.sigma_a()[0] >= 0.0);
            proptest::prop_assert!(b.n_real()[0] > 0.0 && b.asymmetry()[0].abs() <= 1.0);
        }
    }
}
