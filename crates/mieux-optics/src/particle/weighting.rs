//! What a size distribution counts: the part of a measured size that the literature so often leaves unsaid.

use std::fmt;

/// What a size distribution counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weighting {
    /// Particles per size (aerosols, OPAC).
    Number,
    /// Surface area per size.
    Surface,
    /// Volume per size, `r^3 N(r)` (laser diffraction; eq 49 of `frisvad2007`).
    Volume,
    /// Light scattered per size where particles are much smaller than the wavelength, `r^6 N(r)` (dynamic light
    /// scattering, before any correction).
    Intensity,
}

impl Weighting {
    /// All of them, by ascending power of the radius.
    pub const ALL: [Self; 4] = [Self::Number, Self::Surface, Self::Volume, Self::Intensity];

    /// Power of the radius that multiplies `N(r)`.
    pub fn power(self) -> f64 {
        match self {
            Self::Number => 0.0,
            Self::Surface => 2.0,
            Self::Volume => 3.0,
            Self::Intensity => 6.0,
        }
    }

    /// What people call it: `number`, `surface`, `volume`, `intensity`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Number => "number",
            Self::Surface => "surface",
            Self::Volume => "volume",
            Self::Intensity => "intensity",
        }
    }

    /// The weighting of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|w| w.name() == name)
    }
}

impl fmt::Display for Weighting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
