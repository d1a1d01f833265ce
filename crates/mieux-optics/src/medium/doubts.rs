//! Where it is doubtful that particles scatter independently of each other.

use std::fmt;

use super::packing::clearance;
use super::{Medium, Packing};
use crate::spectrum::nanometres;

/// Volume fraction up to which scattering is independent at any size (`tien1987`).
const DILUTE: f64 = 0.006;

/// Clearance between particles in wavelengths, above which scattering is independent (`tien1987`).
const CLEAR: f64 = 0.5;

/// Volume fraction up to which the structure factor is held to be good.
const DENSE: f64 = 0.45;

/// A reason to doubt the bulk properties of a medium.
#[derive(Debug, Clone, PartialEq)]
pub enum Doubt {
    /// Particles so near to each other that the light they scatter interferes: above 0.6 % of the volume, with less than half a
    /// wavelength between their faces.
    Dependent {
        /// Name of the inclusion.
        inclusion: String,
        /// Its volume fraction.
        volume_fraction: f64,
        /// Mean distance between faces of neighbours of the effective size, m.
        clearance_m: f64,
        /// The longest wavelength asked about, in vacuum, m.
        wavelength_m: f64,
    },
    /// Spheres so dense that their structure factor is in doubt.
    Dense {
        /// Name of the inclusion.
        inclusion: String,
        /// Its volume fraction.
        volume_fraction: f64,
    },
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Dependent { inclusion, volume_fraction, clearance_m, wavelength_m } => write!(
                f,
                "{inclusion} may not scatter independently: {:.1} % of the volume, with {:.0} nm between particles, at a \
                 wavelength of {} nm; a correction for packing (Percus-Yevick) may help",
                100.0 * volume_fraction,
                1e9 * clearance_m,
                nanometres(*wavelength_m)
            ),
            Self::Dense { inclusion, volume_fraction } => write!(
                f,
                "{inclusion} take up {:.1} % of the volume; the structure factor of hard spheres has been confirmed up to 45 %",
                100.0 * volume_fraction
            ),
        }
    }
}

impl Medium {
    /// What makes the bulk properties doubtful up to a vacuum wavelength (m), inclusion by inclusion: the criterion of `tien1987` with
    /// the effective radius, and the wavelength in the host.
    pub fn doubts(&self, longest_wavelength_m: f64) -> Vec<Doubt> {
        let index = self.host().index(longest_wavelength_m).map_or(1.0, |n| n.re);
        let doubt = |inclusion: &super::Inclusion| {
            let volume_fraction = inclusion.volume_fraction;
            let name = inclusion.name.clone();
            if inclusion.packing == Packing::PercusYevick {
                return (volume_fraction > DENSE).then_some(Doubt::Dense { inclusion: name, volume_fraction });
            }
            let sizes = &inclusion.sizes;
            let size = sizes.effective_radius().or_else(|_| sizes.mean_radius(4.0, 3.0)).ok()?;
            let radius = inclusion.shape.equivalent_radius(inclusion.outer_radius(size));
            let clearance_m = clearance(2.0 * radius, volume_fraction);
            let near = volume_fraction > DILUTE && clearance_m * index < CLEAR * longest_wavelength_m;
            let wavelength_m = longest_wavelength_m;
            near.then_some(Doubt::Dependent { inclusion: name, volume_fraction, clearance_m, wavelength_m })
        };
        self.inclusions().iter().filter_map(doubt).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Complex64;
    use crate::medium::Inclusion;
    use crate::particle::SizeDistribution;
    use crate::substance::Substance;

    fn beads(radius: f64, fraction: f64, packing: Packing) -> Vec<Doubt> {
        let glass = Substance::Constant(Complex64::new(1.59, 0.0));
        let water = Substance::Constant(Complex64::new(1.33, 0.0));
        let sizes = SizeDistribution::monodisperse(radius).unwrap();
        let beads = Inclusion::new("beads", glass, sizes, fraction).with_packing(packing);
        Medium::new(water, vec![beads]).unwrap().doubts(600e-9)
    }

    /// Clearances by hand: 0.4 um beads at 10 % are 0.38 um apart, 0.85 wavelengths; at 20 % 0.22 um, 0.48.
    #[test]
    fn near_particles_are_doubted_and_far_ones_are_not() {
        let count = |radius, fraction| beads(radius, fraction, Packing::Independent).len();
        assert_eq!(count(0.2e-6, 0.1), 0);
        assert_eq!(count(0.2e-6, 0.2), 1);
        assert_eq!(count(5e-9, 0.0059), 0);
        assert_eq!(count(5e-9, 0.0061), 1);
        assert_eq!(count(1e-3, 0.2), 0);
        let doubt = &beads(0.2e-6, 0.2, Packing::Independent)[0];
        assert!(
            doubt.to_string().starts_with("beads may not scatter independently: 20.0 % of the volume, with 219 nm")
        );
    }

    #[test]
    fn what_is_corrected_is_doubted_later() {
        assert!(beads(0.2e-6, 0.4, Packing::PercusYevick).is_empty());
        assert!(matches!(beads(0.2e-6, 0.48, Packing::PercusYevick)[..], [Doubt::Dense { .. }]));
    }
}
