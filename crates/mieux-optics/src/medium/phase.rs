//! Phase functions of media: the mean of those of single spheres, each by how much it scatters.
//!
//! Source: eq 31 and 32 of `frisvad2007`.

mod moments;

use rayon::prelude::*;

use super::packing::HardSpheres;
use super::scatterer::{Ball, Scatterer, fluid, mie_error};
use super::{Inclusion, Medium, MediumError};
use crate::Complex64;
use crate::integrate::rule;
use crate::mie::Directions;
use crate::particle::{Part, Spread};
use crate::phase::{AngleGrid, HenyeyGreenstein, Isotropic, PhaseError, PhaseFunction, SpectralPhase, Tabulated};
use crate::spectrum::WavelengthGrid;

/// Bins to a period of the largest sphere's oscillation over angle, to begin with.
const BINS_PER_PERIOD: f64 = 8.0;

/// Widest panel of the rule over sizes, in size parameters: the light at one angle has interference fringes over size,
/// two of them to such a panel towards backward, of which the integral over angle knows nothing.
const WIDEST_PANEL: f64 = 4.0;

/// Grids that are tried before giving up.
const ATTEMPTS: usize = 4;

/// Spheres that are added up by themselves; fixed, so that results do not depend on the number of threads.
const BATCH: usize = 16;

/// One of the spheres that stand for a medium.
#[derive(Clone)]
struct Member {
    ball: Ball,
    /// Scattering coefficient due to spheres like it, 1/m, and the same reduced by `1 - g`.
    scattering: f64,
    reduced: f64,
    /// Scattering coefficient as if each were alone, 1/m.
    alone: f64,
    /// Those that it gets in the way of.
    fluid: Option<HardSpheres>,
    /// Modulus of its size parameter.
    size: f64,
    /// Its inclusion among those of the medium.
    inclusion: usize,
}

/// Size parameter that no sphere may have for its cross sections to be asked for all the same.
const BEYOND: f64 = 1e4;

/// The spheres that stand for a medium, or what stands in for their phase function.
enum Members {
    All(Vec<Member>),
    TooLarge(HenyeyGreenstein),
}

impl Medium {
    /// Size parameter of the largest spheres whose phase functions are computed.
    pub const LARGEST_SIZE: f64 = 1000.0;

    /// Phase function at a vacuum wavelength (m): the mean of the exact phase functions of all spheres, weighted by how
    /// much each scatters, as a table over angle; isotropic where nothing scatters.
    ///
    /// Where more than a share `tolerance` of the light is scattered by spheres beyond [`Self::LARGEST_SIZE`], whose rings are
    /// finer than there is time for, Henyey and Greenstein's function of the same asymmetry stands in.
    ///
    /// The integral over radius is converged to `tolerance` (relative, 1e-12 to 1) in scattering and reduced scattering
    /// as [`Self::optics_at`] does it, and `1 - g` of the table is within half of that of what the coefficients
    /// say. The time for clear droplets in air of many sizes, which resonate, is inverse to the tolerance: a second at
    /// 1e-3 for a fog.
    ///
    /// # Errors
    /// As for [`Self::optics_at`], or [`MediumError::Phase`] when no grid of angles reaches the tolerance.
    pub fn phase_at(&self, wavelength: f64, tolerance: f64) -> Result<PhaseFunction, MediumError> {
        let members = match self.members(wavelength, tolerance)? {
            Members::All(members) => members,
            Members::TooLarge(stand_in) => return Ok(stand_in.into()),
        };
        let Some(largest) = largest_size(&members, tolerance) else { return Ok(Isotropic.into()) };
        let [scattering, reduced] =
            members.iter().fold([0.0; 2], |[s, r], member| [s + member.scattering, r + member.reduced]);
        // The other half is left to the integral over radius.
        let wanted = 0.5 * tolerance;
        let mut bins_per_period = AngleGrid::effective_bins_per_period(largest, BINS_PER_PERIOD);
        let mut reached = f64::INFINITY;
        for _ in 0..ATTEMPTS {
            let grid = AngleGrid::graded(largest, bins_per_period)?;
            let values = self.values(&members, &grid)?;
            let table = Tabulated::new(grid.as_slice().to_vec(), values)?;
            reached = (table.one_minus_asymmetry() * scattering / reduced - 1.0).abs();
            if reached <= wanted {
                return Ok(table.into());
            }
            // The error falls with the square of the width of a bin.
            bins_per_period *= (1.2 * (reached / wanted).sqrt()).clamp(1.5, 8.0);
        }
        Err(PhaseError::Tolerance { reached, wanted }.into())
    }

    /// [`Self::phase_at`] for every wavelength of a grid.
    ///
    /// # Errors
    /// As for [`Self::phase_at`].
    pub fn spectral_phase(&self, grid: &WavelengthGrid, tolerance: f64) -> Result<SpectralPhase, MediumError> {
        let functions: Result<Vec<_>, _> = grid.iter().map(|wavelength| self.phase_at(wavelength, tolerance)).collect();
        Ok(SpectralPhase::new(grid.clone(), functions?)?)
    }

    /// Spheres that stand for all sizes of all inclusions; those that hardly scatter are left out.
    fn members(&self, wavelength: f64, tolerance: f64) -> Result<Members, MediumError> {
        if !(1e-12..=1.0).contains(&tolerance) {
            return Err(MediumError::Tolerance { tolerance });
        }
        let host = self.host().index(wavelength)?;
        if self.largest_possible(wavelength, host)? > BEYOND {
            let asymmetry = self.optics_at(wavelength, tolerance)?.asymmetry;
            return Ok(Members::TooLarge(HenyeyGreenstein::new(asymmetry)?));
        }
        let mut members = Vec::new();
        for (i, inclusion) in self.inclusions().iter().enumerate() {
            sample(inclusion, i, wavelength, host, tolerance, &mut members)?;
        }
        let total: f64 = members.iter().map(|member| member.scattering).sum();
        if largest_size(&members, tolerance).is_some_and(|size| size > Self::LARGEST_SIZE) {
            let reduced: f64 = members.iter().map(|member| member.reduced).sum();
            return Ok(Members::TooLarge(HenyeyGreenstein::new(1.0 - reduced / total)?));
        }
        let negligible = 1e-3 * tolerance * total / members.len() as f64;
        members.retain(|member| member.scattering > negligible);
        Ok(Members::All(members))
    }

    /// The size parameter of the largest sphere that any distribution holds, whether or not it matters.
    fn largest_possible(&self, wavelength: f64, host: Complex64) -> Result<f64, MediumError> {
        let mut largest = 0.0f64;
        for inclusion in self.inclusions() {
            let scatterer = Scatterer::new(inclusion, wavelength, host)?;
            let end = inclusion.sizes.log_range(2.0).map_or(0.0, |(_, end)| end.exp());
            largest = largest.max(scatterer.size_parameter(end));
        }
        Ok(largest)
    }

    /// The sum of scattering coefficients times phase functions, at the angles of a grid.
    fn values(&self, members: &[Member], grid: &AngleGrid) -> Result<Vec<f64>, MediumError> {
        let angles = grid.as_slice();
        let last = angles.len() - 1;
        // Graded grids are mirrored about 90 degrees; exact mirror images share their work.
        let cosine = |i: usize| if 2 * i > last { -angles[last - i].cos() } else { angles[i].cos() };
        let directions = Directions::new((0..=last).map(|i| if 2 * i == last { 0.0 } else { cosine(i) }));
        self.sum(members, &directions, angles.len())
    }

    /// The sum of scattering coefficients times phase functions, in the order of `directions`, of which there are `count`.
    fn sum(&self, members: &[Member], directions: &Directions, count: usize) -> Result<Vec<f64>, MediumError> {
        let sums: Result<Vec<Vec<f64>>, MediumError> = members
            .par_chunks(BATCH)
            .map(|batch| {
                let mut sum = vec![0.0; count];
                for member in batch {
                    let phase = member.ball.coefficients().phase_function(directions);
                    let phase = phase.map_err(|source| mie_error(&self.inclusions()[member.inclusion], source))?;
                    match member.fluid {
                        None => sum.iter_mut().zip(phase).for_each(|(sum, p)| *sum += member.alone * p),
                        Some(fluid) => {
                            for ((sum, p), mu) in sum.iter_mut().zip(phase).zip(directions.cosines()) {
                                *sum += member.alone * p * fluid.at(member.size, *mu);
                            }
                        }
                    }
                }
                Ok(sum)
            })
            .collect();
        let mut total = vec![0.0; count];
        for sum in sums? {
            total.iter_mut().zip(sum).for_each(|(total, s)| *total += s);
        }
        Ok(total)
    }
}

/// Appends the spheres at the nodes of a rule for the integral over the sizes of one inclusion.
fn sample(
    inclusion: &Inclusion,
    place: usize,
    wavelength: f64,
    host: Complex64,
    tolerance: f64,
    members: &mut Vec<Member>,
) -> Result<(), MediumError> {
    let mut scatterer = Scatterer::new(inclusion, wavelength, host)?;
    let (first, mut volume) = (members.len(), 0.0);
    for Part { share, sizes } in inclusion.sizes.parts() {
        let (nodes, many): (Vec<(f64, f64)>, bool) = match sizes {
            Spread::One(size) => (vec![(size, share)], false),
            Spread::Smooth(sizes) => {
                // Absorption and refraction have no part in this.
                let floor = |_: &[f64; 6]| [0.0, f64::INFINITY, 0.0, f64::INFINITY, 0.0, 0.0];
                let (_, panels) = scatterer.integrate(sizes, tolerance, false, floor)?;
                let size = |u: f64| scatterer.size_parameter(sizes.measure(u).0);
                let panels = panels.into_iter().flat_map(|[from, to]| {
                    let parts = ((size(to) - size(from)).abs() / WIDEST_PANEL).ceil().clamp(1.0, 1e4) as u32;
                    let at = move |i: u32| from + (to - from) * f64::from(i) / f64::from(parts);
                    (0..parts).map(move |i| [at(i), at(i + 1)])
                });
                let measure = |(u, weight): (f64, f64)| {
                    let (size, measure) = sizes.measure(u);
                    (size, weight * measure)
                };
                let mut nodes: Vec<(f64, f64)> = panels.flat_map(rule).map(measure).collect();
                let whole: f64 = nodes.iter().map(|(_, measure)| measure).sum();
                nodes.iter_mut().for_each(|(_, measure)| *measure *= share / whole);
                (nodes, true)
            }
        };
        let radii: Vec<f64> = nodes.iter().map(|(size, _)| *size).collect();
        let found = scatterer.per_volume(&radii, many)?;
        for ((ball, found), (size, measure)) in scatterer.balls().iter().zip(found).zip(nodes) {
            let amount = measure * inclusion.bulk(size);
            volume += amount;
            members.push(Member {
                ball: ball.clone(),
                scattering: found.scattering * amount,
                reduced: found.reduced * amount,
                alone: found.alone * amount,
                fluid: fluid(inclusion),
                size: scatterer.size_parameter(size),
                inclusion: place,
            });
        }
    }
    let scale = inclusion.volume_fraction / volume;
    for member in &mut members[first..] {
        member.scattering *= scale;
        member.reduced *= scale;
        member.alone *= scale;
    }
    Ok(())
}

/// The size parameter beyond which there is no more than the share `tolerance` of the scattering; `None` without any
/// scattering.
fn largest_size(members: &[Member], tolerance: f64) -> Option<f64> {
    let total: f64 = members.iter().map(|member| member.scattering).sum();
    let mut order: Vec<&Member> = members.iter().collect();
    order.sort_by(|a, b| b.size.total_cmp(&a.size));
    let mut above = 0.0;
    for member in order {
        above += member.scattering;
        if above > tolerance.min(0.5) * total {
            return Some(member.size);
        }
    }
    None
}

#[cfg(test)]
mod tests;
