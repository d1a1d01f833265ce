//! One type for every phase function, so that media and integrators need not know which one they hold.

use std::fmt;

use super::{
    CornetteShanks, DoubleHenyeyGreenstein, Draine, FournierForand, HenyeyGreenstein, HenyeyGreensteinDraine,
    HenyeyGreensteinMixture, Isotropic, Rayleigh, Tabulated, WaterDroplet, quadrature,
};

/// How scattered light spreads over angle: a density per solid angle that depends on the scattering cosine alone.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum PhaseFunction {
    /// Every direction alike.
    Isotropic(Isotropic),
    /// Particles much smaller than the wavelength.
    Rayleigh(Rayleigh),
    /// One lobe.
    HenyeyGreenstein(HenyeyGreenstein),
    /// Two lobes.
    DoubleHenyeyGreenstein(DoubleHenyeyGreenstein),
    /// Any number of lobes.
    HenyeyGreensteinMixture(HenyeyGreensteinMixture),
    /// One lobe that becomes Rayleigh's for small `g`.
    CornetteShanks(CornetteShanks),
    /// One lobe, from Henyey-Greenstein's to Rayleigh's.
    Draine(Draine),
    /// A Henyey-Greenstein lobe and a Draine lobe.
    HenyeyGreensteinDraine(HenyeyGreensteinDraine),
    /// Fog and cloud.
    WaterDroplet(WaterDroplet),
    /// Particles in sea water.
    FournierForand(FournierForand),
    /// Values at angles.
    Tabulated(Tabulated),
}

/// Calls the same method of whichever variant.
macro_rules! each {
    ($self:expr, $phase:ident => $call:expr) => {
        match $self {
            PhaseFunction::Isotropic($phase) => $call,
            PhaseFunction::Rayleigh($phase) => $call,
            PhaseFunction::HenyeyGreenstein($phase) => $call,
            PhaseFunction::DoubleHenyeyGreenstein($phase) => $call,
            PhaseFunction::HenyeyGreensteinMixture($phase) => $call,
            PhaseFunction::CornetteShanks($phase) => $call,
            PhaseFunction::Draine($phase) => $call,
            PhaseFunction::HenyeyGreensteinDraine($phase) => $call,
            PhaseFunction::WaterDroplet($phase) => $call,
            PhaseFunction::FournierForand($phase) => $call,
            PhaseFunction::Tabulated($phase) => $call,
        }
    };
}

macro_rules! from_variant {
    ($($variant:ident),*) => {$(
        impl From<$variant> for PhaseFunction {
            fn from(phase: $variant) -> Self {
                Self::$variant(phase)
            }
        }
    )*};
}

from_variant!(
    Isotropic,
    Rayleigh,
    HenyeyGreenstein,
    DoubleHenyeyGreenstein,
    HenyeyGreensteinMixture,
    CornetteShanks,
    Draine,
    HenyeyGreensteinDraine,
    WaterDroplet,
    FournierForand,
    Tabulated
);

impl PhaseFunction {
    /// Value in 1/sr at the scattering cosine `mu`, 1 being forward; integrates to 1 over the sphere. A `mu` beyond
    /// [-1, 1] is taken for the nearer end; NaN gives NaN (or, of [`Isotropic`], the constant).
    pub fn value(&self, mu: f64) -> f64 {
        let mu = mu.clamp(-1.0, 1.0);
        each!(self, phase => phase.value(mu))
    }

    /// Density of [`Self::sample`] per sr. All sampling is exact, so this is [`Self::value`].
    pub fn pdf(&self, mu: f64) -> f64 {
        self.value(mu)
    }

    /// Scattering cosine in [-1, 1] for a uniform `xi` in [0, 1]. One lobe rises from -1 to 1 with `xi`; a mixture
    /// spends `xi` on the lobe first and the rest on the cosine. A `xi` beyond [0, 1] is taken for the nearer end; NaN
    /// gives NaN.
    pub fn sample(&self, xi: f64) -> f64 {
        let xi = xi.clamp(0.0, 1.0);
        if xi.is_nan() {
            return xi;
        }
        each!(self, phase => phase.sample(xi))
    }

    /// Mean cosine.
    pub fn asymmetry(&self) -> f64 {
        each!(self, phase => phase.asymmetry())
    }

    /// Mean of the Legendre polynomial of the given degree: 1 for degree 0, [`Self::asymmetry`] for degree 1. In closed
    /// form, except of Fournier-Forand and tables, where the time grows with the degree.
    pub fn legendre_moment(&self, degree: u32) -> f64 {
        each!(self, phase => phase.legendre_moment(degree))
    }

    /// The moments of all degrees from 0 to `max_degree`.
    pub fn legendre_moments(&self, max_degree: u32) -> Vec<f64> {
        match self {
            Self::Tabulated(table) => table.legendre_moments(max_degree),
            _ => (0..=max_degree).map(|degree| self.legendre_moment(degree)).collect(),
        }
    }

    /// What the field calls it, without parameters; `Display` adds them.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Isotropic(_) => "isotropic",
            Self::Rayleigh(_) => "Rayleigh",
            Self::HenyeyGreenstein(_) => "Henyey-Greenstein",
            Self::DoubleHenyeyGreenstein(_) => "double Henyey-Greenstein",
            Self::HenyeyGreensteinMixture(_) => "Henyey-Greenstein mixture",
            Self::CornetteShanks(_) => "Cornette-Shanks",
            Self::Draine(_) => "Draine",
            Self::HenyeyGreensteinDraine(_) => "Henyey-Greenstein + Draine",
            Self::WaterDroplet(_) => "water droplet",
            Self::FournierForand(_) => "Fournier-Forand",
            Self::Tabulated(_) => "tabulated",
        }
    }

    /// Key of the source in `references.bib`; a table has none of its own.
    pub fn source(&self) -> Option<&'static str> {
        Some(match self {
            Self::Isotropic(_) => "vandehulst1980",
            Self::Rayleigh(_) => "bohren1983",
            Self::HenyeyGreenstein(_) => "henyey1941",
            Self::DoubleHenyeyGreenstein(_) | Self::HenyeyGreensteinMixture(_) => "kattawar1975",
            Self::CornetteShanks(_) => "cornette1992",
            Self::Draine(_) => "draine2003",
            Self::HenyeyGreensteinDraine(_) | Self::WaterDroplet(_) => "jendersie2023s",
            Self::FournierForand(_) => "fournier1994",
            Self::Tabulated(_) => return None,
        })
    }

    /// The value at `1 - mu`, which near forward has digits that `mu` has not.
    pub(super) fn value_away(&self, away: f64) -> f64 {
        match self {
            Self::FournierForand(phase) => phase.value_away(away),
            Self::Tabulated(table) => table.value_away(away),
            _ => self.value(1.0 - away),
        }
    }

    /// Edges in `1 - mu` between which the function is smooth.
    pub(super) fn edges(&self) -> Vec<f64> {
        match self {
            Self::Tabulated(table) => table.edges().to_vec(),
            _ => quadrature::graded_edges(),
        }
    }
}

impl fmt::Display for PhaseFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        each!(self, phase => phase.fmt(f))
    }
}

#[cfg(test)]
mod tests;
