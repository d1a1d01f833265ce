//! One of the models, ready to be asked.

use super::{
    BetterDipole, Boundary, DiffusionMedium, Dipole, DirectionalDipole, PhotonBeam, RadialSampler, SingleScattering,
};
use crate::transfer::TransferError;

/// The models of how far light travels below a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum DiffusionModel {
    /// [`Dipole`] with the exact boundary.
    Dipole,
    /// [`Dipole`] with the boundary as `jensen2001` published it.
    DipoleGroenhuis,
    /// [`BetterDipole`] and [`SingleScattering`] beside it.
    BetterDipole,
    /// [`DirectionalDipole`].
    DirectionalDipole,
    /// [`PhotonBeam`], single scattering included.
    PhotonBeam,
}

impl DiffusionModel {
    /// All of them, the oldest first.
    pub const ALL: [Self; 5] =
        [Self::DipoleGroenhuis, Self::Dipole, Self::BetterDipole, Self::DirectionalDipole, Self::PhotonBeam];

    /// As it is written in tables and on command lines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Dipole => "dipole",
            Self::DipoleGroenhuis => "dipole-groenhuis",
            Self::BetterDipole => "better-dipole",
            Self::DirectionalDipole => "directional-dipole",
            Self::PhotonBeam => "photon-beam",
        }
    }
}

/// How much light leaves a half-space at which distance from a pencil beam, by one of the models.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Profile {
    model: DiffusionModel,
    medium: DiffusionMedium,
    shape: Shape,
    total: f64,
    scale: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    Dipole(Dipole),
    Better(BetterDipole, SingleScattering),
    Directional(DirectionalDipole),
    Beam(PhotonBeam),
}

impl Profile {
    /// # Errors
    /// None for a [`DiffusionMedium`]; the type is that of its parts.
    pub fn new(model: DiffusionModel, medium: &DiffusionMedium) -> Result<Self, TransferError> {
        let shape = match model {
            DiffusionModel::Dipole => Shape::Dipole(Dipole::new(medium, Boundary::Exact)),
            DiffusionModel::DipoleGroenhuis => Shape::Dipole(Dipole::new(medium, Boundary::Groenhuis)),
            DiffusionModel::BetterDipole => Shape::Better(BetterDipole::new(medium), SingleScattering::new(medium)?),
            DiffusionModel::DirectionalDipole => Shape::Directional(DirectionalDipole::new(medium)),
            DiffusionModel::PhotonBeam => Shape::Beam(PhotonBeam::new(medium)?),
        };
        let total = match &shape {
            Shape::Dipole(dipole) => dipole.total(),
            Shape::Better(dipole, single) => dipole.total() + single.total(),
            Shape::Directional(dipole) => dipole.total(),
            Shape::Beam(beam) => beam.total(),
        };
        Ok(Self { model, medium: *medium, shape, total, scale: 1.0 })
    }

    /// The same times a number, so that its total is that of the transfer equation ([`DiffusionMedium::exact_total`]).
    ///
    /// # Errors
    /// [`TransferError::Dark`] if the model says that nothing comes back where something does; those of the solver.
    pub fn normalised(self) -> Result<Self, TransferError> {
        let exact = self.medium.exact_total()?;
        if exact == 0.0 {
            return Ok(Self { scale: 0.0, ..self });
        }
        if self.total > 0.0 && self.total.is_finite() {
            Ok(Self { scale: exact / self.total, ..self })
        } else {
            Err(TransferError::Dark)
        }
    }

    /// Which model it is.
    pub fn model(&self) -> DiffusionModel {
        self.model
    }

    /// What it is the profile of.
    pub fn medium(&self) -> &DiffusionMedium {
        &self.medium
    }

    /// What the model is multiplied by: 1 unless [`Profile::normalised`].
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Power that leaves per area at the distance `r` (m, from 0 up) from where light of power 1 has entered along the
    /// normal, 1/m^2. Where single scattering is part of the model it is infinite at 0.
    pub fn reflectance(&self, r: f64) -> f64 {
        let value = match &self.shape {
            Shape::Dipole(dipole) => dipole.reflectance(r),
            Shape::Better(dipole, single) => dipole.reflectance(r) + single.reflectance(r),
            Shape::Directional(dipole) => dipole.reflectance(r),
            Shape::Beam(beam) => beam.reflectance(r),
        };
        if self.scale == 0.0 { 0.0 } else { self.scale * value }
    }

    /// The integral of [`Profile::reflectance`] over the surface.
    pub fn total(&self) -> f64 {
        self.scale * self.total
    }

    /// Samples of the distance with nearly the density of the profile: the weight `reflectance / density` of a sample is the
    /// total within a few parts in a thousand. (The classical dipole can be sampled exactly: [`Dipole::sample`].)
    ///
    /// # Errors
    /// [`TransferError::Dark`] if nothing comes back.
    pub fn sampler(&self) -> Result<RadialSampler, TransferError> {
        RadialSampler::new(|r| self.reflectance(r), 1.0 / self.medium.reduced_extinction())
    }

    /// How fast it fades far away, 1/m.
    pub fn transport_coefficient(&self) -> f64 {
        match &self.shape {
            Shape::Dipole(dipole) => dipole.sigma_tr(),
            Shape::Better(dipole, _) => dipole.sigma_tr(),
            Shape::Directional(dipole) => dipole.sigma_tr(),
            Shape::Beam(beam) => beam.sigma_tr(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::diffusion::testing;

    #[test]
    fn rescaled_profiles_have_the_exact_total() {
        for medium in testing::media() {
            for model in DiffusionModel::ALL {
                let profile = Profile::new(model, &medium).unwrap();
                if medium.sigma_s() == 0.0 {
                    assert_eq!(profile.total(), 0.0);
                    let dark = profile.normalised().unwrap();
                    assert_eq!((dark.total(), dark.reflectance(0.0)), (0.0, 0.0));
                    assert_eq!(dark.sampler(), Err(TransferError::Dark));
                    continue;
                }
                let normalised = profile.normalised().unwrap();
                let exact = medium.exact_total().unwrap();
                assert!((normalised.total() - exact).abs() < 1e-12);
                let r = 1.0 / medium.reduced_extinction();
                assert!((normalised.reflectance(r) / profile.reflectance(r) - normalised.scale()).abs() < 1e-12);
            }
        }
    }

    /// The mean weight of samples is the total, and no sample weighs much more than another.
    #[test]
    fn samples_weigh_the_same() {
        for medium in testing::media().into_iter().filter(|m| m.sigma_s() > 0.0) {
            for model in DiffusionModel::ALL {
                let profile = Profile::new(model, &medium).unwrap();
                let sampler = profile.sampler().unwrap();
                for k in 0..200 {
                    let xi = (f64::from(k) + 0.5) / 200.0;
                    let r = sampler.sample(xi);
                    let weight = profile.reflectance(r) / (sampler.density(r) * profile.total());
                    assert!((weight - 1.0).abs() < 0.02, "{model:?} {medium:?} {xi}: {weight}");
                }
            }
        }
    }
}
