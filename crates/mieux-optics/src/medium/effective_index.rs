//! The refractive index of a medium with particles in it.

use num_complex::Complex64;

/// How the forward scattering of particles adds up to the refractive index of the medium.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum EffectiveIndex {
    /// Each particle in the local field of the others (Lorentz and Lorenz): small spheres make the index of Maxwell Garnett
    /// (`maxwellgarnett1904`) at any volume fraction, and few particles of any size that of [`Self::Dilute`].
    #[default]
    LorentzLorenz,
    /// Each particle alone, eq 33 of `frisvad2007` with the sign that makes a denser particle raise the index: linear in volume
    /// fraction, and short of Maxwell Garnett's index by `3/8 n_host (f K)^2` to second order, `K` the polarisability of a
    /// sphere, `(eps - 1) / (eps + 2)`.
    Dilute,
}

impl EffectiveIndex {
    /// From the index of the host, and what the particles add to it each alone: `i wavelength sum N S(0)/k^2`.
    pub(super) fn index(self, host: Complex64, dilute: Complex64) -> Complex64 {
        match self {
            Self::Dilute => host + dilute,
            Self::LorentzLorenz => {
                // Polarisability per volume: alone, the index grows by 3/2 of it.
                let a = dilute / host * (2.0 / 3.0);
                // Its difference from the host's keeps the digits of few particles.
                let growth = 3.0 * a / (1.0 - a);
                host + host * growth / ((1.0 + growth).sqrt() + 1.0)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_particles_make_one_index() {
        let host = Complex64::new(1.33, 1e-6);
        let dilute = Complex64::new(1e-7, 3e-8);
        let [a, b] =
            [EffectiveIndex::LorentzLorenz, EffectiveIndex::Dilute].map(|form| form.index(host, dilute) - host);
        assert!((a - b).norm() < 1e-13 && (b - dilute).norm() < 1e-15);
    }
}
