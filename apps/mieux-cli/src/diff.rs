//! `mieux diff`.

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use mieux::jobs::{Diff, DiffReport};
use mieux::render::film::{Difference, Verdict};

use crate::args::Format;

#[derive(Args)]
pub struct DiffArgs {
    /// An OpenEXR file with `R`, `G`, `B` and `variance.R`, `variance.G`, `variance.B`, as `mieux render` writes it
    pub first: PathBuf,
    /// Another of the same size, with independent samples (another `--seed`); errors are relative to it
    pub second: PathBuf,
    /// How to print the result
    #[arg(long, value_enum, default_value = "table")]
    pub format: Format,
    /// Also write difference.png, difference.exr (in standard errors) and blocks.csv to this folder
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

impl DiffArgs {
    pub fn job(self) -> Diff {
        Diff { output: self.output, ..Diff::new(self.first, self.second) }
    }
}

/// Prints what was found; the code is 0 for pictures that agree, 3 for those that differ, 4 for those that are more alike
/// than noise allows.
pub fn show(report: &DiffReport, format: Format) -> io::Result<ExitCode> {
    let text = match format {
        Format::Table => table(report),
        Format::Csv => csv(&report.difference),
        Format::Json => json(report),
    };
    io::stdout().lock().write_all(text.as_bytes())?;
    Ok(ExitCode::from(match report.difference.verdict() {
        Verdict::Agree => 0,
        Verdict::Differ => 3,
        Verdict::TooAlike => 4,
    }))
}

fn word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Agree => "agree",
        Verdict::Differ => "differ",
        Verdict::TooAlike => "too-alike",
    }
}

fn table(report: &DiffReport) -> String {
    let found = &report.difference;
    let (worst, [x, y, ..]) = found.worst();
    let blocks = found.blocks.iter().filter(|b| b.pixels > 0).count();
    let three = |values: [f64; 3]| values.map(|v| format!("{v:+.2}")).join("  ");
    let mut text = format!(
        "relative mean square error   {:.3e}, of which noise explains {:.3e}\n\
         whole picture                bias R, G, B {} %, z {}\n\
         blocks of 16x16              {blocks}; largest |z| {worst:.2} at {x},{y} (chance allows {:.2}); {:.2} % of z beyond 3 (0.27 % by chance)\n\
         mean square of the blocks' z {:.3} (1 by chance)\n",
        found.relative_mse,
        found.expected_mse,
        three(found.bias.map(|b| 100.0 * b)),
        three(found.whole),
        found.allowed(),
        100.0 * found.beyond_three(),
        found.spread,
    );
    if found.unknown > 0 {
        text += &format!("left out                     {} pixels without a known variance\n", found.unknown);
    }
    text += match found.verdict() {
        Verdict::Agree => "the pictures agree within their noise\n",
        Verdict::Differ => "the pictures differ by more than their noise\n",
        Verdict::TooAlike => {
            "the pictures are more alike than their noise allows: they share samples (were both made with one seed?), or their variances are too large\n"
        }
    };
    if let Some(folder) = report.files.first().and_then(|file| file.parent()) {
        let names: Vec<_> = report.files.iter().filter_map(|f| f.file_name()).map(|n| n.to_string_lossy()).collect();
        text += &format!("in {}: {}\n", folder.display(), names.join(" "));
    }
    text
}

fn csv(found: &Difference) -> String {
    let mut text = String::from("left,top,width,height,pixels,z_r,z_g,z_b\n");
    for block in &found.blocks {
        let [x, y, w, h] = block.place;
        let [r, g, b] = block.z;
        text += &format!("{x},{y},{w},{h},{},{r},{g},{b}\n", block.pixels);
    }
    text
}

fn json(report: &DiffReport) -> String {
    let found = &report.difference;
    let (worst, place) = found.worst();
    let value = serde_json::json!({
        "size": report.size,
        "verdict": word(found.verdict()),
        "relative_mse": found.relative_mse,
        "expected_mse": found.expected_mse,
        "bias": found.bias,
        "z": found.whole,
        "worst_block": { "z": worst, "allowed": found.allowed(), "place": place },
        "beyond_three": found.beyond_three(),
        "spread": found.spread,
        "spread_z": found.spread_z,
        "unknown_pixels": found.unknown,
    });
    format!("{value:#}\n")
}
