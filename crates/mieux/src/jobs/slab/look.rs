//! What a material looks like in plain layers: its phase functions, and the colours of layers of it.

use std::sync::atomic::AtomicU64;

use mieux_io::quantity::format_length;
use mieux_io::recipe::Material;
use mieux_optics::phase::PhaseFunction;
use mieux_optics::spectrum::WavelengthGrid;
use mieux_optics::transfer::{DiscreteOrdinates, Ground, Incidence, Stack};
use serde_json::{Value, json};

use super::super::{Context, Event, JobError, Stage};
use super::colour::linear_srgb;
use super::matter::{Count, SpectralMatter, Wanted};
use super::solve::{Question, Solver, solve};
use super::stacks::ENDLESS;

/// Layers that are shown, m; the first stands for endless depth.
const THICKNESSES: [f64; 4] = [f64::INFINITY, 1e-3, 1e-2, 1e-1];
/// Least relative tolerance of the phase functions: enough for pictures and colours, where more would take minutes for fogs.
const TOLERANCE: f64 = 1e-2;
/// Wavelengths that must be covered for a colour to mean something, m.
const VISIBLE: (f64, f64) = (400e-9, 700e-9);

/// Phase functions by wavelength, and colours of layers where the wavelengths cover the visible.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::jobs) struct Look {
    pub functions: Vec<PhaseFunction>,
    pub colours: Vec<LayerColour>,
}

/// The colour of a layer under D65 along the normal, for the CIE 1931 observer, on a ground in optical contact with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LayerColour {
    /// Thickness, m; may be infinite.
    pub thickness_m: f64,
    /// Whether the ground is white (all light comes back diffusely) rather than black.
    pub white: bool,
    /// All that comes back, the mirror image on the surface too; linear sRGB.
    pub with_surface: [f64; 3],
    /// What comes back from inside; linear sRGB.
    pub without_surface: [f64; 3],
}

impl LayerColour {
    /// Which layer: "1 mm on white".
    pub fn label(&self) -> String {
        if self.thickness_m.is_infinite() {
            return "endlessly thick".into();
        }
        format!("{} on {}", format_length(self.thickness_m), if self.white { "white" } else { "black" })
    }

    /// As JSON; an infinite thickness is null.
    pub fn json(&self) -> Value {
        let hex = mieux_io::plot::srgb_hex;
        json!({
            "thickness_m": self.thickness_m.is_finite().then_some(self.thickness_m),
            "ground": if self.white { "white" } else { "black" },
            "with_surface_reflection": hex(self.with_surface),
            "without_surface_reflection": hex(self.without_surface),
        })
    }
}

impl Look {
    pub fn compute(
        material: &Material,
        grid: &WavelengthGrid,
        tolerance: f64,
        context: &Context<'_>,
    ) -> Result<Self, JobError> {
        let streams = DiscreteOrdinates::default().streams;
        let wanted =
            Wanted { degree: streams + super::Slab::MARGIN, functions: true, tolerance: tolerance.max(TOLERANCE) };
        context.say(Event::Begin(Stage::Phase));
        let count = Count { stage: Stage::Phase, done: AtomicU64::new(0), total: grid.len() as u64 };
        let matter = SpectralMatter::compute(material, grid, wanted, &count, context)?;
        context.say(Event::End(Stage::Phase));
        let covered = grid.range().0 <= VISIBLE.0 && grid.range().1 >= VISIBLE.1;
        let colours = if covered { colours(&matter, grid, streams, context)? } else { Vec::new() };
        let functions = matter.scattering.into_iter().filter_map(|scattering| scattering.function).collect();
        Ok(Self { functions, colours })
    }
}

fn colours(
    matter: &SpectralMatter,
    grid: &WavelengthGrid,
    streams: usize,
    context: &Context<'_>,
) -> Result<Vec<LayerColour>, JobError> {
    let layers = THICKNESSES.iter().flat_map(|&thickness| {
        let grounds = if thickness.is_infinite() { &[false][..] } else { &[false, true] };
        grounds.iter().map(move |&white| (thickness, white))
    });
    let layers: Vec<(f64, bool)> = layers.collect();
    let each = |&(thickness, white): &(f64, bool)| (0..grid.len()).map(move |at| stack(matter, at, thickness, white));
    let stacks: Vec<Stack> = layers.iter().flat_map(each).collect();
    let question =
        Question { stacks: &stacks, functions: &[], incidence: Incidence::NORMAL, streams, photons: 0, seed: 0 };
    let answers = solve(Solver::Auto, &question, context)?;
    let colour = |((thickness_m, white), answers): ((f64, bool), &[super::Answer])| {
        let all: Vec<f64> = answers.iter().map(|answer| answer.shares.reflectance).collect();
        let inside = answers.iter().map(|answer| answer.shares.reflectance - answer.shares.reflectance_specular);
        let inside: Vec<f64> = inside.collect();
        let of = |shares: &[f64]| linear_srgb(Some(grid), shares);
        LayerColour { thickness_m, white, with_surface: of(&all), without_surface: of(&inside) }
    };
    Ok(layers.into_iter().zip(answers.chunks_exact(grid.len())).map(colour).collect())
}

fn stack(matter: &SpectralMatter, at: usize, thickness: f64, white: bool) -> Stack {
    let optical = if thickness.is_finite() { thickness * matter.extinction(at) } else { ENDLESS };
    Stack {
        above: 1.0,
        layers: vec![matter.layer(at, optical)],
        below: matter.index[at],
        ground: if white { Ground::Lambertian(1.0) } else { Ground::Black },
    }
}
