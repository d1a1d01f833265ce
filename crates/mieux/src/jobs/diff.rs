//! The job behind `mieux diff`: do two pictures show the same thing?

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use mieux_io::image::{ExrImage, read_exr, write_exr_channels, write_png_srgb8};
use mieux_io::output::OutputDir;
use mieux_render::film::{Difference, Estimated, difference};
use serde::{Deserialize, Serialize};

use super::{Context, Event, JobError, Stage};

/// Two pictures with their variances, pixel by pixel and in blocks of 16 x 16.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Diff {
    /// An OpenEXR file with the layers `R`, `G`, `B` and `variance.R`, `variance.G`, `variance.B`.
    pub first: PathBuf,
    /// Another, which relative errors are relative to.
    pub second: PathBuf,
    /// Folder for maps and tables; nothing is written when left out.
    #[serde(default)]
    pub output: Option<PathBuf>,
}

/// What [`Diff`] finds.
#[derive(Debug, Clone, PartialEq)]
pub struct DiffReport {
    /// Width and height of both, pixels.
    pub size: [u32; 2],
    /// How they differ.
    pub difference: Difference,
    /// The files written.
    pub files: Vec<PathBuf>,
}

/// |z| at which the colours of the map end.
const FULL_COLOUR: f64 = 5.0;

impl Diff {
    /// Two pictures, and no files.
    pub fn new(first: impl Into<PathBuf>, second: impl Into<PathBuf>) -> Self {
        Self { first: first.into(), second: second.into(), output: None }
    }

    pub(super) fn run(&self, context: &Context<'_>) -> Result<DiffReport, JobError> {
        let (first, second) = (Picture::read(&self.first)?, Picture::read(&self.second)?);
        if first.size != second.size {
            return Err(JobError::PictureSizes {
                first: self.first.clone(),
                first_size: first.size,
                second: self.second.clone(),
                second_size: second.size,
            });
        }
        let difference = difference(first.size, first.estimated(), second.estimated())?;
        let mut files = Vec::new();
        if let Some(folder) = &self.output {
            context.say(Event::Begin(Stage::Write));
            files = self.write(folder, first.size, &difference)?;
            context.say(Event::End(Stage::Write));
        }
        Ok(DiffReport { size: first.size, difference, files })
    }

    fn write(&self, folder: &Path, [width, height]: [u32; 2], found: &Difference) -> Result<Vec<PathBuf>, JobError> {
        let dir = OutputDir::create(folder)?;
        let (png, exr) = (dir.file("difference.png")?, dir.file("difference.exr")?);
        write_png_srgb8(&png, width, height, &colours(&found.z), 1.0)?;
        let channel = |c: usize| found.z.iter().skip(c).step_by(3).copied().collect::<Vec<f32>>();
        let channels = BTreeMap::from([("R", 0), ("G", 1), ("B", 2)].map(|(name, c)| (name.to_owned(), channel(c))));
        let comment = format!(
            "difference of {} and {} in standard errors of the difference; NaN where it is not known",
            self.first.display(),
            self.second.display()
        );
        write_exr_channels(&exr, width, height, channels, &comment)?;
        let csv = dir.write("blocks.csv", |out| out.write_all(table(found).as_bytes()))?;
        dir.commit();
        Ok(vec![png, exr, csv])
    }
}

/// A picture read from a file.
struct Picture {
    size: [u32; 2],
    rgb: Vec<f32>,
    variance: Vec<f32>,
}

impl Picture {
    fn read(path: &Path) -> Result<Self, JobError> {
        let image = read_exr(path)?;
        let layer = |prefix: &str| three(&image, path, prefix);
        let size = [image.size.width(), image.size.height()];
        Ok(Self { size, rgb: layer("")?, variance: layer("variance.")? })
    }

    fn estimated(&self) -> Estimated<'_> {
        Estimated { rgb: &self.rgb, variance: &self.variance }
    }
}

fn three(image: &ExrImage, path: &Path, prefix: &str) -> Result<Vec<f32>, JobError> {
    image.rgb(prefix).ok_or_else(|| JobError::NoLayer {
        path: path.into(),
        wanted: ["R", "G", "B"].map(|c| format!("{prefix}{c}")).join(", "),
        found: image.channels.keys().take(12).cloned().collect::<Vec<_>>().join(", "),
    })
}

/// Linear sRGB of a map: white where there is no difference, red where the first picture is brighter, blue where the second
/// is, full at five standard errors, grey where nothing is known. What is shown is the mean of the channels.
fn colours(z: &[f32]) -> Vec<f64> {
    z.chunks_exact(3)
        .flat_map(|z| {
            let mean = z.iter().map(|&z| f64::from(z)).sum::<f64>() / 3.0;
            if mean.is_nan() {
                return [0.2; 3];
            }
            let fade = 1.0 - (mean.abs() / FULL_COLOUR).min(1.0);
            if mean > 0.0 { [0.6 + 0.4 * fade, fade, fade] } else { [fade, fade, 0.6 + 0.4 * fade] }
        })
        .collect()
}

fn table(found: &Difference) -> String {
    let mut text = String::from("left,top,width,height,pixels,z_r,z_g,z_b\n");
    for block in &found.blocks {
        let [x, y, w, h] = block.place;
        let [r, g, b] = block.z;
        // Writing into a string cannot fail.
        let _ = writeln!(text, "{x},{y},{w},{h},{},{r},{g},{b}", block.pixels);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_is_red_where_the_first_is_brighter() {
        let colours = colours(&[0.0, 0.0, 0.0, 9.0, 9.0, 9.0, -9.0, -9.0, -9.0, f32::NAN, 0.0, 0.0]);
        assert_eq!(colours, [1.0, 1.0, 1.0, 0.6, 0.0, 0.0, 0.0, 0.0, 0.6, 0.2, 0.2, 0.2]);
    }
}
