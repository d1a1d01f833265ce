//! Media as files say them, and as materials make them.

use std::sync::Arc;

use mieux_io::scene::description::{
    BlendWeight, Coefficients, Grid, GridFilter, Medium, MediumKind, Optics, Phase, Place,
};
use mieux_optics::phase::{AngleGrid, HenyeyGreenstein, Isotropic, PhaseFunction, Rayleigh, SpectralPhase, Tabulated};
use mieux_optics::spectrum::{Sampled, WavelengthGrid};
use mieux_render::medium::{self, Filter, Part, Placement};

use super::spectra::{Kind, sampled};
use super::{JobError, RANGE, fault, flat};

/// A medium of the index `n` (its own where that is not given by the surface around it).
pub(super) fn stage(
    medium: &Medium,
    materials: &[medium::Medium],
    n: Option<Sampled>,
) -> Result<medium::Medium, JobError> {
    let place = &medium.place;
    let known = |material: usize| {
        materials.get(material).ok_or_else(|| fault(place, format!("there is no material {material}")))
    };
    match &medium.kind {
        MediumKind::Material { material, density } => {
            let mut made = known(*material)?.clone();
            made.parts.iter_mut().try_for_each(|part| scale(part, *density))?;
            Ok(medium::Medium { n: n.unwrap_or(made.n), parts: made.parts })
        }
        MediumKind::Homogeneous(optics) => Ok(medium::Medium {
            n: n.map_or_else(|| sampled(&optics.index, Kind::Matter), Ok)?,
            parts: parts(optics, None, place)?,
        }),
        MediumKind::Grid { optics, density, albedo, emission } => {
            if emission.is_some() {
                return Err(fault(place, "emission from a grid of its own is not supported; scale `emission` instead"));
            }
            let n = n.map_or_else(|| sampled(&optics.index, Kind::Matter), Ok)?;
            let parts = match albedo {
                None => parts(optics, Some(density), place)?,
                Some(albedo) => by_albedo(optics, density, albedo, place)?,
            };
            Ok(medium::Medium { n, parts })
        }
        MediumKind::Mixture(components) => {
            let mut parts = Vec::new();
            let mut index = n;
            for component in components {
                let made = known(component.material)?.clone();
                let grid = stage_grid(&component.density, component.density.values.clone(), place)?;
                for mut part in made.parts {
                    part.density = Some(grid.clone());
                    parts.push(part);
                }
                index.get_or_insert(made.n);
            }
            Ok(medium::Medium { n: index.map_or_else(|| flat(1.0), Ok)?, parts })
        }
    }
}

fn scale(part: &mut Part, factor: f64) -> Result<(), JobError> {
    for spectrum in [&mut part.sigma_s, &mut part.sigma_a] {
        let values = spectrum.values().iter().map(|v| v * factor).collect();
        *spectrum = Sampled::new(spectrum.grid().clone(), values)?;
    }
    Ok(())
}

/// Every wavelength at which either changes its slope.
fn both(a: &Sampled, b: &Sampled, f: impl Fn(f64, f64) -> f64) -> Result<Sampled, JobError> {
    let inside = |w: &f64| *w > RANGE.0 && *w < RANGE.1;
    let mut wavelengths: Vec<f64> = a.grid().iter().chain(b.grid().iter()).filter(inside).collect();
    wavelengths.extend([RANGE.0, RANGE.1]);
    wavelengths.sort_by(f64::total_cmp);
    wavelengths.dedup_by(|a, b| (*a - *b).abs() < 1e-15);
    let at = |s: &Sampled, w: f64| s.at(w).unwrap_or(0.0);
    let values = wavelengths.iter().map(|&w| f(at(a, w), at(b, w))).collect();
    Ok(Sampled::new(WavelengthGrid::new(wavelengths)?, values)?)
}

/// Scattering and absorption, 1/m.
fn coefficients(optics: &Optics) -> Result<(Sampled, Sampled), JobError> {
    let factor = optics.scale;
    match &optics.coefficients {
        Coefficients::ExtinctionAlbedo { extinction, albedo } => {
            let (t, albedo) = (sampled(extinction, Kind::Matter)?, sampled(albedo, Kind::Matter)?);
            let scattered = both(&t, &albedo, |t, a| t * a * factor)?;
            Ok((scattered, both(&t, &albedo, |t, a| t * (1.0 - a).max(0.0) * factor)?))
        }
        Coefficients::ScatteringAbsorption { scattering, absorption } => {
            let of = |s: &_| {
                let s = sampled(s, Kind::Matter)?;
                both(&s, &s, |v, _| v * factor)
            };
            Ok((of(scattering)?, of(absorption)?))
        }
    }
}

/// The parts of a medium given by its numbers, one for each of the phase functions that are blended.
fn parts(optics: &Optics, density: Option<&Grid>, place: &Place) -> Result<Vec<Part>, JobError> {
    let (sigma_s, sigma_a) = coefficients(optics)?;
    let emission = match &optics.emission {
        None => None,
        Some(emission) => {
            let emission = sampled(emission, Kind::Light)?;
            if (0..=400).any(|k| {
                let w = RANGE.0 + f64::from(k) * 1e-9;
                emission.at(w).is_some_and(|e| e > 0.0) && !sigma_a.at(w).is_some_and(|a| a > 0.0)
            }) {
                return Err(fault(place, "it shines where it does not absorb, which nothing does"));
            }
            Some(both(&emission, &sigma_a, |e, a| if a > 0.0 { e / a } else { 0.0 })?)
        }
    };
    let mut blended = Vec::new();
    flatten(&optics.phase, Share { factor: 1.0, grid: density.map(|d| (d, d.values.clone())) }, &mut blended, place)?;
    let mut made = Vec::with_capacity(blended.len());
    for (phase, share) in blended {
        let share_of = |s: &Sampled| both(s, s, |v, _| v * share.factor);
        made.push(Part {
            sigma_s: share_of(&sigma_s)?,
            sigma_a: share_of(&sigma_a)?,
            phase: stage_phase(phase, place)?,
            emission: emission.clone(),
            density: share.grid.map(|(grid, values)| stage_grid(grid, values, place)).transpose()?,
        });
    }
    Ok(made)
}

/// How much of a medium scatters by one of several phase functions.
struct Share<'a> {
    factor: f64,
    grid: Option<(&'a Grid, Vec<f32>)>,
}

fn flatten<'a>(
    phase: &'a Phase,
    share: Share<'a>,
    found: &mut Vec<(&'a Phase, Share<'a>)>,
    place: &Place,
) -> Result<(), JobError> {
    let Phase::Blend { weight, a, b } = phase else {
        found.push((phase, share));
        return Ok(());
    };
    match weight {
        BlendWeight::Constant(weight) => {
            let of = |factor: f64| Share { factor: share.factor * factor, grid: share.grid.clone() };
            flatten(a, of(1.0 - weight), found, place)?;
            flatten(b, of(*weight), found, place)
        }
        BlendWeight::Grid(weights) => {
            let of = |turn: fn(f32) -> f32| -> Result<Share<'a>, JobError> {
                let weighted = weights.values.iter().map(|w| turn(*w));
                let (grid, values) = match &share.grid {
                    None => (weights, weighted.collect()),
                    Some((grid, values)) if same_place(grid, weights) => {
                        (*grid, values.iter().zip(weighted).map(|(v, w)| v * w).collect())
                    }
                    Some(_) => return Err(fault(place, "the grid of weights must lie as that of the density does")),
                };
                Ok(Share { factor: share.factor, grid: Some((grid, values)) })
            };
            flatten(a, of(|w| 1.0 - w)?, found, place)?;
            flatten(b, of(|w| w)?, found, place)
        }
    }
}

fn same_place(a: &Grid, b: &Grid) -> bool {
    a.dims == b.dims && a.to_world == b.to_world
}

/// A grid of albedos is two parts: what scatters, and what absorbs. Cells hold the products; between their middles the product
/// is interpolated, not its factors.
fn by_albedo(optics: &Optics, density: &Grid, albedo: &Grid, place: &Place) -> Result<Vec<Part>, JobError> {
    if !same_place(density, albedo) {
        return Err(fault(place, "the grid of albedos must lie as that of the density does"));
    }
    let (sigma_s, sigma_a) = coefficients(optics)?;
    let extinction = both(&sigma_s, &sigma_a, |s, a| s + a)?;
    let of = |turn: fn(f32) -> f32| {
        let values = density.values.iter().zip(&albedo.values).map(|(d, a)| d * turn(*a)).collect();
        stage_grid(density, values, place)
    };
    let (zero, phase) = (flat(0.0)?, stage_phase(&optics.phase, place)?);
    let scatters = Part {
        sigma_s: extinction.clone(),
        sigma_a: zero.clone(),
        phase: phase.clone(),
        emission: None,
        density: Some(of(|a| a)?),
    };
    let absorbs =
        Part { sigma_s: zero, sigma_a: extinction, phase, emission: None, density: Some(of(|a| (1.0 - a).max(0.0))?) };
    Ok(vec![scatters, absorbs])
}

fn stage_grid(grid: &Grid, values: Vec<f32>, place: &Place) -> Result<Arc<medium::Grid>, JobError> {
    let placement = Placement {
        corner: grid.to_world.point([0.0; 3]),
        edges: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|edge| grid.to_world.vector(edge)),
    };
    let filter = match grid.filter {
        GridFilter::Nearest => Filter::Nearest,
        GridFilter::Trilinear => Filter::Trilinear,
    };
    let made = medium::Grid::new(grid.dims, &values, filter, &placement);
    Ok(Arc::new(made.map_err(|e| fault(place, e.to_string()))?))
}

fn stage_phase(phase: &Phase, place: &Place) -> Result<medium::Phase, JobError> {
    let function = |f: PhaseFunction| medium::Phase::Function(Arc::new(f));
    Ok(match phase {
        Phase::Isotropic => function(PhaseFunction::Isotropic(Isotropic)),
        Phase::Rayleigh => function(PhaseFunction::Rayleigh(Rayleigh)),
        Phase::HenyeyGreenstein { g } => {
            HenyeyGreenstein::new(*g).map_err(|e| fault(place, e.to_string()))?;
            medium::Phase::HenyeyGreenstein(flat(*g)?)
        }
        Phase::Tabulated { cosines, values } => function(table(cosines, values, place)?),
        Phase::TabulatedSpectral { wavelengths, cosines, values } => {
            let mut grid = wavelengths.clone();
            let mut functions: Vec<PhaseFunction> =
                values.iter().map(|values| table(cosines, values, place)).collect::<Result<_, _>>()?;
            // The nearest holds beyond the ends.
            if let (Some(first), Some(one)) = (grid.first().copied(), functions.first().cloned())
                && first > RANGE.0
            {
                grid.insert(0, RANGE.0);
                functions.insert(0, one);
            }
            if let (Some(last), Some(one)) = (grid.last().copied(), functions.last().cloned())
                && last < RANGE.1
            {
                grid.push(RANGE.1);
                functions.push(one);
            }
            let spectral = SpectralPhase::new(WavelengthGrid::new(grid)?, functions);
            medium::Phase::Spectral(Arc::new(spectral.map_err(|e| fault(place, e.to_string()))?))
        }
        Phase::Blend { .. } => return Err(fault(place, "a blend of blends by grids of albedos is not supported")),
    })
}

/// Linear in the cosine between values from backward to forward.
fn table(cosines: &[f64], values: &[f64], place: &Place) -> Result<PhaseFunction, JobError> {
    let wrong = |e: mieux_optics::phase::PhaseError| fault(place, e.to_string());
    let angles: Vec<f64> = cosines.iter().rev().map(|c| c.clamp(-1.0, 1.0).acos()).collect();
    AngleGrid::new(angles.clone()).map_err(wrong)?;
    Ok(Tabulated::new(angles, values.iter().rev().copied().collect()).map_err(wrong)?.into())
}
