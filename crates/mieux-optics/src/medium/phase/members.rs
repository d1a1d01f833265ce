//! The spheres that stand for a medium.

use super::super::bulk::InclusionPanels;
use super::super::packing::HardSpheres;
use super::super::scatterer::{Ball, Scatterer, fluid};
use super::super::{Inclusion, Medium, MediumError};
use crate::Complex64;
use crate::integrate::rule;
use crate::particle::{Part, Smooth, Spread};

/// Widest panel of the rule over sizes, in size parameters: the light at one angle has interference fringes over size,
/// two of them to such a panel towards backward, of which the integral over angle knows nothing.
const WIDEST_PANEL: f64 = 4.0;

/// Narrowest panel of the rule over sizes, in size parameters, at a tolerance of 1e-3 and more, and in proportion below: what
/// narrower ones would tell of resonances, the coefficients know.
const NARROWEST_PANEL: f64 = 0.5;

/// Size parameter from which on fringes over size may be left to average out.
const AVERAGED: f64 = 500.0;

/// Panels from there on, at least: 15 sizes in each.
const AVERAGING_PANELS: f64 = 48.0;

/// Largest width of panels there over their size parameter.
const WIDEST_SHARE: f64 = 1.0 / 30.0;

/// Width of panels over that, where only rays can follow and only cross sections are asked for.
const RAYS_WIDER: f64 = 3.0;

/// Size parameter from which on spheres are followed by rays where there are some too large for anything else.
const RAYS_FROM: f64 = 1000.0;

/// Phase that a ray through the middle of a sphere must gain or lose (rad) for rays to have any meaning.
const LEAST_PHASE: f64 = 30.0;

/// One of the spheres that stand for a medium.
#[derive(Debug, Clone)]
pub(super) struct Member {
    pub ball: Ball,
    /// Scattering coefficient due to spheres like it, 1/m.
    pub scattering: f64,
    /// Scattering coefficient as if each were alone, 1/m.
    pub alone: f64,
    /// Those that it gets in the way of.
    pub fluid: Option<HardSpheres>,
    /// Modulus of its size parameter.
    pub size: f64,
    /// Its inclusion among those of the medium.
    pub inclusion: usize,
    /// Whether rays are followed through it.
    pub rays: bool,
    /// Whether its neighbours in size are so far from it that fringes only average out.
    averaged: bool,
}

/// How the mean phase function is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Road {
    Exact,
    Packed,
    Broad,
    StandIn,
}

/// All of them, and the largest size parameter that counts.
pub(super) struct Members {
    pub members: Vec<Member>,
    pub road: Road,
    pub largest: f64,
}

impl Medium {
    /// Spheres that stand for all sizes of all inclusions; those that hardly scatter are left out.
    pub(super) fn members(
        &self,
        wavelength: f64,
        tolerance: f64,
        panels: &[InclusionPanels],
    ) -> Result<Members, MediumError> {
        let host = self.host().index(wavelength)?;
        let mut members = Vec::new();
        for (i, (inclusion, panels)) in self.inclusions().iter().zip(panels).enumerate() {
            sample(inclusion, i, wavelength, host, tolerance, panels, &mut members)?;
        }
        let total: f64 = members.iter().map(|member| member.scattering).sum();
        let negligible = 1e-3 * tolerance * total / members.len() as f64;
        members.retain(|member| member.scattering > negligible);
        let largest = largest_size(&members, tolerance).unwrap_or(0.0);
        let mut road = Road::Exact;
        if largest > Self::LARGEST_SIZE {
            road = Road::Broad;
            for member in members.iter_mut().filter(|member| member.size > RAYS_FROM) {
                let contrast = match &member.ball {
                    Ball::Homogeneous(sphere) if member.fluid.is_none() => (sphere.index() / host - 1.0).norm(),
                    _ => {
                        road = Road::StandIn;
                        break;
                    }
                };
                member.rays = member.size > Self::LARGEST_SIZE || 2.0 * member.size * contrast > LEAST_PHASE;
            }
        } else {
            members.retain(|member| member.size <= Self::LARGEST_SIZE);
            if members.iter().any(|member| member.fluid.is_some()) {
                road = Road::Packed;
            } else if members.iter().any(|member| member.averaged) {
                road = Road::Broad;
            }
        }
        Ok(Members { members, road, largest })
    }
}

/// Appends the spheres at the nodes of a rule for the integral over the sizes of one inclusion.
fn sample(
    inclusion: &Inclusion,
    place: usize,
    wavelength: f64,
    host: Complex64,
    tolerance: f64,
    panels: &InclusionPanels,
    members: &mut Vec<Member>,
) -> Result<(), MediumError> {
    let mut scatterer = Scatterer::new(inclusion, wavelength, host)?;
    let (first, mut volume) = (members.len(), 0.0);
    for (Part { share, sizes }, panels) in inclusion.sizes.parts().into_iter().zip(panels) {
        // Size, weight, and whether fringes are averaged.
        let (nodes, many): (Vec<(f64, f64, bool)>, bool) = match sizes {
            Spread::One(size) => (vec![(size, share, false)], false),
            Spread::Smooth(sizes) => {
                let panels = panels_of_fringes(&scatterer, sizes, panels, tolerance);
                let measure = |averaged: bool| {
                    move |(u, weight): (f64, f64)| {
                        let (size, measure) = sizes.measure(u);
                        (size, weight * measure, averaged)
                    }
                };
                let mut nodes: Vec<_> =
                    panels.into_iter().flat_map(|(panel, averaged)| rule(panel).map(measure(averaged))).collect();
                let whole: f64 = nodes.iter().map(|(_, measure, _)| measure).sum();
                nodes.iter_mut().for_each(|(_, measure, _)| *measure *= share / whole);
                (nodes, true)
            }
        };
        let radii: Vec<f64> = nodes.iter().map(|(size, ..)| *size).collect();
        let found = scatterer.per_volume(&radii, many)?;
        for ((ball, found), (size, measure, averaged)) in scatterer.balls().iter().zip(found).zip(nodes) {
            let amount = measure * inclusion.bulk(size);
            volume += amount;
            members.push(Member {
                ball: ball.clone(),
                scattering: found.scattering * amount,
                alone: found.alone * amount,
                fluid: fluid(inclusion),
                size: scatterer.size_parameter(size),
                inclusion: place,
                rays: false,
                averaged,
            });
        }
    }
    let scale = inclusion.volume_fraction / volume;
    for member in &mut members[first..] {
        member.scattering *= scale;
        member.alone *= scale;
    }
    Ok(())
}

/// Panels in `u` that are narrow enough for fringes over size, or so many that these average out (then true).
fn panels_of_fringes(
    scatterer: &Scatterer<'_>,
    sizes: &dyn Smooth,
    panels: &[[f64; 2]],
    tolerance: f64,
) -> Vec<([f64; 2], bool)> {
    let size = |u: f64| scatterer.size_parameter(sizes.measure(u).0);
    let narrowest = NARROWEST_PANEL * (tolerance / 1e-3).min(1.0);
    let end = panels.last().map_or(0.0, |panel| size(panel[1]));
    let start = panels.first().map_or(0.0, |panel| size(panel[0])).max(AVERAGED);
    let share = ((end / start).ln() / AVERAGING_PANELS).clamp(0.0, WIDEST_SHARE);
    let mut pieces: Vec<[f64; 2]> = panels.iter().rev().copied().collect();
    let mut panels = Vec::with_capacity(pieces.len());
    while let Some([from, to]) = pieces.pop() {
        let middle = 0.5 * (from + to);
        if size(to) > AVERAGED && size(to) > 1.1 * size(from) && from < middle && middle < to {
            pieces.extend([[middle, to], [from, middle]]);
        } else {
            panels.push([from, to]);
        }
    }
    let mut found = Vec::new();
    let mut from = panels.first().map_or(0.0, |panel| panel[0]);
    for (i, &[_, to]) in panels.iter().enumerate() {
        let (least, most) = (size(from), size(to));
        let share = if least > Medium::LARGEST_SIZE { RAYS_WIDER * share } else { share };
        let averaged = least > AVERAGED && share * most > WIDEST_PANEL;
        let (narrowest, widest) = if averaged { (0.5 * share * most, share * most) } else { (narrowest, WIDEST_PANEL) };
        if most - least < narrowest && i + 1 < panels.len() {
            continue;
        }
        let parts = ((most - least).abs() / widest).ceil().clamp(1.0, 1e4) as u32;
        let at = |k: u32| if k == parts { to } else { from + (to - from) * f64::from(k) / f64::from(parts) };
        found.extend((0..parts).map(|k| ([at(k), at(k + 1)], averaged)));
        from = to;
    }
    found
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
