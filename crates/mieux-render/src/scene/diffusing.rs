//! Bodies dense enough for diffusion, and what the surfaces between them and others do to it.

use std::sync::OnceLock;

use mieux_optics::spectrum::{Sampled, WavelengthGrid};
use mieux_optics::transfer::diffusion::{Boundary, DiffusionMedium, Dipole};

use super::Body;
use crate::integrator::{LANES, Lanes};
use crate::medium::{Dense, DenseMedium};

/// A body thinner than so many transport mean free paths, at any wavelength, is no place for diffusion.
const LEAST_PATHS: f64 = 10.0;
/// And so is one that scatters a lesser share (reduced) than this.
const LEAST_ALBEDO: f64 = 0.5;
/// Step of the tables of what surfaces do, m: it changes little from one to the next.
const STEP: f64 = 20e-9;

/// What is known of every surface between two bodies, found when it is first met.
pub(super) struct Diffusing {
    range: (f64, f64),
    /// Whether each body is dense enough.
    dense: Vec<bool>,
    /// For each body, each that may be beyond, and nothing.
    surfaces: Vec<OnceLock<Option<Surface>>>,
}

/// Over wavelength.
struct Surface {
    /// `A` of the boundary.
    a: Dense,
    /// What makes the dipole's total exact.
    scale: Dense,
    /// Share of diffuse light from outside that enters.
    entering: Dense,
}

/// Light under a surface, at the wavelengths of a path.
pub(crate) struct Dipoles {
    pub(crate) dipoles: [Dipole; LANES],
    /// What makes their totals exact.
    pub(crate) scales: Lanes,
    /// Share of diffuse light from outside that enters.
    pub(crate) entering: Lanes,
}

impl Diffusing {
    pub fn new(bodies: &[Body], media: &[DenseMedium], range: (f64, f64)) -> Self {
        let dense = bodies.iter().zip(media).map(|(body, medium)| is_dense(body, medium, range)).collect();
        let pairs = bodies.len() * (bodies.len() + 1);
        Self { range, dense, surfaces: (0..pairs).map(|_| OnceLock::new()).collect() }
    }

    pub fn dipoles(
        &self,
        media: &[DenseMedium],
        body: u16,
        beyond: Option<u16>,
        wavelengths: &Lanes,
    ) -> Option<Dipoles> {
        let inside = usize::from(body);
        if !self.dense.get(inside).copied()? {
            return None;
        }
        let outside = beyond.map_or(media.len(), usize::from);
        let cell = self.surfaces.get(inside * (media.len() + 1) + outside)?;
        let surface = cell.get_or_init(|| Surface::new(&media[inside], media.get(outside), self.range)).as_ref()?;
        let medium = &media[inside];
        let dipole = |k: usize| {
            let w = wavelengths[k];
            let reduced = (1.0 - medium.g.at(w)) * medium.sigma_s.at(w);
            Dipole::with_boundary(medium.sigma_a.at(w), reduced, surface.a.at(w))
        };
        Some(Dipoles {
            dipoles: std::array::from_fn(dipole),
            scales: surface.scale.lanes(wavelengths),
            entering: surface.entering.lanes(wavelengths),
        })
    }
}

fn wavelengths((low, high): (f64, f64)) -> Vec<f64> {
    let steps = ((high - low) / STEP).ceil().max(1.0);
    (0..=steps as usize).map(|k| low + (high - low) * (k as f64 / steps)).collect()
}

fn is_dense(body: &Body, medium: &DenseMedium, range: (f64, f64)) -> bool {
    if !medium.walkable {
        return false;
    }
    let corners = || (0..body.mesh.triangles().len()).flat_map(|t| body.mesh.corners(t));
    let low = corners().fold(glam::DVec3::INFINITY, |low, corner| low.min(corner));
    let high = corners().fold(glam::DVec3::NEG_INFINITY, |high, corner| high.max(corner));
    let extent = (high - low).min_element();
    wavelengths(range).into_iter().all(|w| {
        let reduced = (1.0 - medium.g.at(w)) * medium.sigma_s.at(w);
        let extinction = reduced + medium.sigma_a.at(w);
        extinction * extent >= LEAST_PATHS && reduced >= LEAST_ALBEDO * extinction
    })
}

impl Surface {
    /// `None` if the transfer equation cannot be asked.
    fn new(medium: &DenseMedium, beyond: Option<&DenseMedium>, range: (f64, f64)) -> Option<Self> {
        let places = wavelengths(range);
        let mut columns = [Vec::new(), Vec::new(), Vec::new()];
        for &w in &places {
            let eta = medium.n.at(w) / beyond.map_or(1.0, |beyond| beyond.n.at(w));
            let here = DiffusionMedium::new(medium.sigma_a.at(w), medium.sigma_s.at(w), medium.g.at(w), eta).ok()?;
            let total = Dipole::new(&here, Boundary::Exact).total();
            columns[0].push(here.boundary(Boundary::Exact));
            columns[1].push(here.exact_total().ok()? / total);
            columns[2].push(1.0 - here.surface().external);
        }
        let grid = WavelengthGrid::new(places).ok()?;
        let dense = |values: Vec<f64>| {
            let spectrum = Sampled::new(grid.clone(), values).ok()?;
            Dense::new("diffusion", &spectrum, range, "must be finite", f64::is_finite).ok()
        };
        let [a, scale, entering] = columns.map(dense);
        Some(Self { a: a?, scale: scale?, entering: entering? })
    }
}
