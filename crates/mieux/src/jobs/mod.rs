//! A job is a value that can be written down; running it reports progress and leaves results.
//!
//! The command line, a TOML or JSON file, and whatever comes later build the same values and run them the same way.

mod compare;
mod diff;
mod error;
mod event;
mod export;
mod invert;
mod keeper;
mod merge;
mod mie;
mod optics;
mod paint;
mod phase;
mod pictures;
mod render;
mod sheet;
mod sizes;
mod slab;
mod staging;
mod substance;
mod wanted;
mod wavelengths;

use serde::{Deserialize, Serialize};

pub use compare::{Compare, CompareReport, CompareSheet, Difference, Side};
pub use diff::{Diff, DiffReport};
pub use error::JobError;
pub use event::{Context, Event, Stage};
pub use export::{Export, ExportReport, ExportSheet};
pub use invert::{Invert, InvertReport, InvertSheet, Inverted, Slabs};
pub use merge::{Merge, MergeError};
pub use mie::{Coat, Definition, Directional, Mie, MieBatch, MieBatchReport, MieReport, MieSheet, Particle};
pub use optics::{Optics, OpticsReport};
pub use paint::{
    HoldOut, PaintFit, PaintFitReport, PaintMatch, PaintMatchReport, PaintMix, PaintMixReport, PaintTarget, SampleFit,
    Shown,
};
pub use phase::{Comparand, Compared, FitKind, Named, Phase, PhaseModel, PhaseReport, PhaseSheet};
pub use render::{Approximation, Render, RenderReport, Stop};
pub use sheet::{Made, OpticsSheet, made_of};
pub use sizes::{Population, Sizes, SizesReport};
pub use slab::{
    Answer, Backing, Case, LayerColour, Patch, PhaseName, Sample, Slab, SlabCompare, SlabCompareReport,
    SlabCompareSheet, SlabError, SlabLight, SlabReport, SlabSheet, Solver, Trial,
};
pub use substance::{SubstanceIndex, SubstanceReport, SubstanceSheet, format_range, substances_json};

/// Everything `mieux` can be asked to do.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "job", rename_all = "kebab-case")]
pub enum Job {
    /// Optical properties of a material over wavelength.
    Optics(Optics),
    /// Two materials, or a material and measurements, side by side.
    Compare(Compare),
    /// A picture.
    Render(Render),
    /// A picture from its parts.
    Merge(Merge),
    /// Two pictures and their noise.
    Diff(Diff),
    /// What a size distribution amounts to.
    Sizes(Sizes),
    /// Light and one particle.
    Mie(Mie),
    /// Light and a table of spheres.
    MieBatch(MieBatch),
    /// How scattered light spreads over angle.
    Phase(Phase),
    /// Light onto layers.
    Slab(Slab),
    /// Light onto layers, by every solver.
    SlabCompare(SlabCompare),
    /// K and S of paints from measurements.
    PaintFit(PaintFit),
    /// What a mixture of paints looks like.
    PaintMix(PaintMix),
    /// A recipe for a wanted colour.
    PaintMatch(PaintMatch),
    /// What measured slabs are made of.
    Invert(Invert),
    /// The refractive index of a substance.
    Substance(SubstanceIndex),
    /// A material for another renderer.
    Export(Export),
}

/// What a job leaves besides its files.
#[derive(Debug, Clone, PartialEq)]
pub enum Report {
    /// Of [`Job::Optics`].
    Optics(Box<OpticsReport>),
    /// Of [`Job::Compare`].
    Compare(Box<CompareReport>),
    /// Of [`Job::Render`] and [`Job::Merge`].
    Render(Box<RenderReport>),
    /// Of [`Job::Diff`].
    Diff(Box<DiffReport>),
    /// Of [`Job::Sizes`].
    Sizes(Box<SizesReport>),
    /// Of [`Job::Mie`].
    Mie(Box<MieReport>),
    /// Of [`Job::MieBatch`].
    MieBatch(Box<MieBatchReport>),
    /// Of [`Job::Phase`].
    Phase(Box<PhaseReport>),
    /// Of [`Job::Slab`].
    Slab(Box<SlabReport>),
    /// Of [`Job::SlabCompare`].
    SlabCompare(Box<SlabCompareReport>),
    /// Of [`Job::PaintFit`].
    PaintFit(Box<PaintFitReport>),
    /// Of [`Job::PaintMix`].
    PaintMix(Box<PaintMixReport>),
    /// Of [`Job::PaintMatch`].
    PaintMatch(Box<PaintMatchReport>),
    /// Of [`Job::Invert`].
    Invert(Box<InvertReport>),
    /// Of [`Job::Substance`].
    Substance(Box<SubstanceReport>),
    /// Of [`Job::Export`].
    Export(Box<ExportReport>),
}

impl Job {
    /// Runs the job to its end, or to the next stopping point once the context asks for it.
    ///
    /// # Errors
    /// [`JobError`]; nothing is written then that was not whole already.
    pub fn run(&self, context: &Context<'_>) -> Result<Report, JobError> {
        match self {
            Self::Optics(job) => job.run(context).map(|report| Report::Optics(Box::new(report))),
            Self::Compare(job) => job.run(context).map(|report| Report::Compare(Box::new(report))),
            Self::Render(job) => job.run(context).map(|report| Report::Render(Box::new(report))),
            Self::Merge(job) => job.run(context).map(|report| Report::Render(Box::new(report))),
            Self::Diff(job) => job.run(context).map(|report| Report::Diff(Box::new(report))),
            Self::Sizes(job) => job.run(context).map(|report| Report::Sizes(Box::new(report))),
            Self::Mie(job) => job.run(context).map(|report| Report::Mie(Box::new(report))),
            Self::MieBatch(job) => job.run(context).map(|report| Report::MieBatch(Box::new(report))),
            Self::Phase(job) => job.run(context).map(|report| Report::Phase(Box::new(report))),
            Self::Slab(job) => job.run(context).map(|report| Report::Slab(Box::new(report))),
            Self::SlabCompare(job) => job.run(context).map(|report| Report::SlabCompare(Box::new(report))),
            Self::PaintFit(job) => job.run(context).map(|report| Report::PaintFit(Box::new(report))),
            Self::PaintMix(job) => job.run(context).map(|report| Report::PaintMix(Box::new(report))),
            Self::PaintMatch(job) => job.run(context).map(|report| Report::PaintMatch(Box::new(report))),
            Self::Invert(job) => job.run(context).map(|report| Report::Invert(Box::new(report))),
            Self::Substance(job) => job.run(context).map(|report| Report::Substance(Box::new(report))),
            Self::Export(job) => job.run(context).map(|report| Report::Export(Box::new(report))),
        }
    }
}
