//! The figures of one particle.

use mieux_io::plot::{SizePlot, efficiency_figure, phase_figure, polarisation_figure};
use mieux_optics::mie::Directions;

use super::{Context, Event, JobError, MieSheet, Particle, Stage};

/// Sizes in the curve of efficiencies.
const SIZES: u32 = 481;

/// How many sizes are computed between two looks at whether to stop.
const AT_ONCE: usize = 64;

/// The figures, by the names of their files.
///
/// # Errors
/// [`JobError::Cancelled`] or [`JobError::Plot`].
pub(super) fn figures(
    sheet: &MieSheet,
    particle: &Particle,
    context: &Context<'_>,
) -> Result<Vec<(&'static str, String)>, JobError> {
    let title = sheet.title().replacen('s', "S", 1);
    let efficiencies = efficiencies(sheet, particle, &title, context)?;
    let (angles, directions) = directions(sheet.scattering.size_parameter.norm());
    let mueller = particle.coefficients()?.mueller(&directions)?;
    let phase: Vec<f64> = mueller.iter().map(|m| m.p11).collect();
    let parts: Vec<[f64; 2]> = mueller.iter().map(|m| [m.p11 - m.p12, m.p11 + m.p12]).collect();
    Ok(vec![
        ("efficiencies.svg", efficiencies),
        ("phase-function.svg", phase_figure(&title, &angles, &phase).to_svg()?),
        ("polarisation.svg", polarisation_figure(&title, &angles, &parts).to_svg()?),
    ])
}

/// Angles dense enough for the lobes of a particle of that size, as far as a picture can show them; forward and backward
/// denser still.
fn directions(size: f64) -> (Vec<f64>, Directions) {
    let count = (8.0 * size).clamp(721.0, 3601.0) as usize;
    let angle = |i: usize| 180.0 * i as f64 / (count - 1) as f64;
    let angles: Vec<f64> = (0..count).map(angle).collect();
    (angles, Directions::uniform(count))
}

/// Particles from a hundredth to ten times as large, from smaller to larger.
fn efficiencies(sheet: &MieSheet, particle: &Particle, title: &str, context: &Context<'_>) -> Result<String, JobError> {
    context.say(Event::Begin(Stage::Spheres));
    let scales: Vec<f64> = (0..SIZES).map(|i| 10f64.powf(3.0 * f64::from(i) / f64::from(SIZES - 1) - 2.0)).collect();
    let mut sizes = Vec::with_capacity(scales.len());
    for (i, scales) in scales.chunks(AT_ONCE).enumerate() {
        if context.is_cancelled() {
            return Err(JobError::Cancelled);
        }
        sizes.extend(particle.scaled(scales));
        context.count(Stage::Spheres, (i * AT_ONCE + scales.len()) as u64, u64::from(SIZES));
    }
    context.say(Event::End(Stage::Spheres));
    let efficiency = |c: f64, radius: f64| c / (std::f64::consts::PI * radius * radius);
    let [x, ext, sca, abs, g]: [Vec<f64>; 5] = [
        sizes.iter().map(|(_, s)| s.size_parameter.re).collect(),
        sizes.iter().map(|(r, s)| efficiency(s.extinction, *r)).collect(),
        sizes.iter().map(|(r, s)| efficiency(s.scattering, *r)).collect(),
        sizes.iter().map(|(r, s)| efficiency(s.absorption, *r)).collect(),
        sizes.iter().map(|(_, s)| s.asymmetry).collect(),
    ];
    let here = &sheet.scattering;
    let plot = SizePlot {
        size_parameter: &x,
        q_ext: &ext,
        q_sca: &sca,
        q_abs: &abs,
        asymmetry: &g,
        here: [here.size_parameter.re, sheet.efficiency(here.extinction), here.asymmetry],
    };
    Ok(efficiency_figure(title, &plot).to_svg()?)
}
