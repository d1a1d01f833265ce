//! Discrete ordinates: the transfer equation followed along any number of streams (`chandrasekhar1960`), with any phase
//! function, any number of layers, and refracting planes between them.
//!
//! `plan.rs` makes a stack ready, `modes.rs` solves each layer, `sweep.rs` joins them from the ground up and comes back
//! down, `shares.rs`, `fluxes.rs` and `radiance.rs` read off what is asked. Several problems are solved abreast, one per lane: stacks of
//! one shape (the wavelengths of a spectrum), or the orders of an expansion in azimuth.

pub(super) mod beam;
mod crossing;
mod depth;
mod drivers;
mod first_order;
mod fluxes;
mod forward_peak;
mod gathered;
mod legendre;
pub(super) mod matrix;
mod modes;
pub(super) mod plan;
mod radiance;
mod ray;
pub(super) mod shares;
mod sweep;
mod views;

use super::{Incidence, Shares, Stack, TransferError};

pub use fluxes::{Fluxes, Light};
pub use views::{Place, Radiances, Views};

/// The solver and its settings.
///
/// ```
/// use mieux_optics::transfer::{DiscreteOrdinates, Incidence, Layer, Moments, Stack};
///
/// // Van de Hulst's slab: g = 0.75, optical thickness 2, albedo 0.9, light along the normal.
/// let slab = Stack::slab(Layer::new(2.0, 0.9, Moments::henyey_greenstein(0.75)?));
/// let shares = DiscreteOrdinates::default().shares(&slab, Incidence::NORMAL)?;
/// assert!((shares.reflectance - 0.09739464).abs() < 1e-7);
/// assert!((shares.transmittance - 0.66095770).abs() < 1e-7);
/// # Ok::<(), mieux_optics::transfer::TransferError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DiscreteOrdinates {
    /// Directions in both hemispheres of the densest medium: even, from 2 to 256. Where media differ in index, every range
    /// of directions that travels in some of them and not in others has at least one stream.
    pub streams: usize,
    /// Whether what the streams cannot resolve of the forward peak counts as not scattered (delta-M, `wiscombe1977`).
    pub cut_peak: bool,
    /// Whether radiance has its first scattering with all moments of the phase function (`nakajima1988`), rather than with
    /// those that the streams can tell apart.
    pub correct_radiance: bool,
}

impl Default for DiscreteOrdinates {
    fn default() -> Self {
        Self { streams: 32, cut_peak: true, correct_radiance: true }
    }
}

impl DiscreteOrdinates {
    /// With another number of streams.
    ///
    /// # Errors
    /// [`TransferError::Streams`] unless it is even and from 2 to 256.
    pub fn with_streams(streams: usize) -> Result<Self, TransferError> {
        let solver = Self { streams, ..Self::default() };
        solver.check()?;
        Ok(solver)
    }

    fn check(&self) -> Result<(), TransferError> {
        let streams = self.streams;
        if streams.is_multiple_of(2) && (2..=256).contains(&streams) {
            Ok(())
        } else {
            Err(TransferError::Streams { streams })
        }
    }

    /// Where the light goes that falls onto a stack; emission is left out.
    ///
    /// # Errors
    /// [`TransferError`] for matter or light that cannot be.
    pub fn shares(&self, stack: &Stack, incidence: Incidence) -> Result<Shares, TransferError> {
        let all = self.shares_of(std::slice::from_ref(stack), &[incidence])?;
        all.into_iter().flatten().next().ok_or(TransferError::Streams { streams: self.streams })
    }

    /// The same for many stacks and, in the inner list, many ways of falling in, which cost little more than one. Stacks of
    /// one shape (the same planes at which the index changes), such as those of the wavelengths of one material, are solved
    /// abreast.
    ///
    /// # Errors
    /// As [`DiscreteOrdinates::shares`].
    pub fn shares_of(&self, stacks: &[Stack], incidences: &[Incidence]) -> Result<Vec<Vec<Shares>>, TransferError> {
        self.check()?;
        stacks.iter().try_for_each(Stack::check)?;
        for incidence in incidences {
            if let Incidence::Beam(cosine) = *incidence {
                check_cosine(cosine)?;
            }
        }
        shares::solve(self, stacks, incidences)
    }

    /// The fluxes through horizontal planes in the stack, at optical depths from its top; emission counts. At a depth
    /// between two layers of different index it is the lower one that is meant; 0 is just below the first plane.
    ///
    /// # Errors
    /// [`TransferError`] for matter, light or depths that cannot be.
    pub fn fluxes(&self, stack: &Stack, light: &Light, depths: &[f64]) -> Result<Vec<Fluxes>, TransferError> {
        self.check()?;
        stack.check()?;
        light.check()?;
        fluxes::solve(self, stack, light, depths)
    }

    /// The radiance at heights, and in directions, in the stack and outside; emission counts.
    ///
    /// # Errors
    /// [`TransferError`] for matter, light, depths or directions that cannot be.
    pub fn radiance(&self, stack: &Stack, light: &Light, views: &Views) -> Result<Radiances, TransferError> {
        self.check()?;
        stack.check()?;
        light.check()?;
        views.check()?;
        radiance::solve(self, stack, light, views)
    }
}

pub(super) fn check_cosine(value: f64) -> Result<(), TransferError> {
    if value > 0.0 && value <= 1.0 { Ok(()) } else { Err(TransferError::Cosine { value }) }
}

#[cfg(test)]
mod tests;
