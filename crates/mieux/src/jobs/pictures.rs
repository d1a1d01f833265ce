//! The files of a picture: a PNG to look at, and an EXR with all that is known of it.

use std::collections::BTreeMap;
use std::path::PathBuf;

use mieux_io::image::{Tone, spectral_channel, write_exr_spectral, write_png_toned};
use mieux_io::output::OutputDir;
use mieux_io::quantity::significant;
use mieux_render::film::Film;
use mieux_render::integrator::features;
use mieux_render::scene::Prepared;

use super::JobError;

/// What the layers of the EXR are, in its comment: there it is found by whoever opens the file.
const LAYERS: &str = "R, G, B: linear sRGB, 1 is white
variance: of the mean of R, G, B, in the square of their unit
samples: per pixel
albedo: linear sRGB under D65 of the first surface, 1 where a body reflects and refracts, 0 where there is none
normal: of the first surface, towards the camera, in the axes of the scene, z up
depth: m along the ray to the first surface, infinite where there is none";

/// How the PNG is made from light.
pub(super) struct Look {
    pub(super) tone: Tone,
    /// What light is multiplied by.
    pub(super) factor: f64,
}

/// Writes `picture.png`.
pub(super) fn write_png(dir: &OutputDir, film: &Film, look: &Look) -> Result<PathBuf, JobError> {
    let [width, height] = film.resolution();
    let rgb: Vec<f64> = film.pixels().iter().flat_map(|p| p.mean()).collect();
    let png = dir.file("picture.png")?;
    write_png_toned(&png, width, height, &rgb, look.factor, look.tone)?;
    Ok(png)
}

/// Writes both files; the film is the window `[left, top, width, height]` of the scene's picture.
pub(super) fn write_pictures(
    dir: &OutputDir,
    film: &Film,
    scene: &Prepared,
    window: [u32; 4],
    look: &Look,
    comment: &str,
) -> Result<Vec<PathBuf>, JobError> {
    let [width, height] = film.resolution();
    let png = write_png(dir, film, look)?;
    let mut channels = BTreeMap::new();
    let mut add = |name: String, values: Vec<f32>| channels.insert(name, values);
    for (c, name) in ["R", "G", "B"].iter().enumerate() {
        add((*name).into(), film.pixels().iter().map(|p| p.mean()[c] as f32).collect());
        add(format!("variance.{name}"), film.pixels().iter().map(|p| p.variance_of_mean()[c] as f32).collect());
    }
    add("samples".into(), film.pixels().iter().map(|p| p.samples as f32).collect());
    let seen = features(scene, window);
    for (c, (colour, axis)) in [("R", "X"), ("G", "Y"), ("B", "Z")].iter().enumerate() {
        add(format!("albedo.{colour}"), seen.iter().map(|f| f.albedo[c] as f32).collect());
        add(format!("normal.{axis}"), seen.iter().map(|f| f.normal[c] as f32).collect());
    }
    add("depth.Z".into(), seen.iter().map(|f| f.depth as f32).collect());
    let mut units = format!("{comment}\n{LAYERS}");
    let bins = film.bins();
    if bins > 0 {
        let (low, high) = scene.observer().range();
        let step = (high - low) / bins as f64;
        for bin in 0..bins {
            let mean = |i: usize| (film.spectra()[i * bins + bin] / film.pixels()[i].samples.max(1) as f64) as f32;
            let name = spectral_channel(low + (bin as f64 + 0.5) * step);
            add(name, (0..film.pixels().len()).map(mean).collect());
        }
        units += &format!(
            "\nS0: mean radiance in {bins} bins of {} nm around the wavelengths named, relative to the scene's lights",
            significant(1e9 * step, 6)
        );
    }
    let exr = dir.file("picture.exr")?;
    let spectral = (bins > 0).then_some("W.m^-2.sr^-1.nm^-1");
    write_exr_spectral(&exr, width, height, channels, &units, spectral)?;
    Ok(vec![png, exr])
}
