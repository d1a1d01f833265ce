//! Everything that can keep a job from its end.

use std::path::PathBuf;

use mieux_io::checkpoint::CheckpointError;
use mieux_io::export::ExportError;
use mieux_io::image::ImageError;
use mieux_io::index_file::IndexFileError;
use mieux_io::measured::MeasuredError;
use mieux_io::netcdf::NetCdfError;
use mieux_io::output::OutputError;
use mieux_io::paint::PaintFileError;
use mieux_io::plot::PlotError;
use mieux_io::quantity::{Length, QuantityError};
use mieux_io::recipe::RecipeError;
use mieux_io::rows::RowsError;
use mieux_io::rxt::RxtError;
use mieux_io::slab_file::SlabFileError;
use mieux_io::table::TableError;
use mieux_optics::medium::MediumError;
use mieux_optics::mie::MieError;
use mieux_optics::paint::PaintError;
use mieux_optics::particle::ParticleError;
use mieux_optics::phase::PhaseError;
use mieux_optics::spectrum::SpectrumError;
use mieux_optics::substance::SubstanceError;
use mieux_optics::transfer::TransferError;
use mieux_optics::transfer::inverse::InverseError;
use mieux_render::detector::slab::SlabWalkError;
use mieux_render::film::DifferenceError;
use mieux_render::render::RenderError;

use super::{MergeError, SlabError};

/// Why a job did not get to its end.
#[derive(Debug, thiserror::Error)]
pub enum JobError {
    /// The material or scene.
    #[error(transparent)]
    Recipe(#[from] RecipeError),
    /// Its optical properties.
    #[error("{material}: {source}")]
    Medium {
        /// Name of the material.
        material: String,
        /// What is wrong.
        source: MediumError,
    },
    /// Something in a scene file.
    #[error("{file}:{line}:{column}: {reason}")]
    Scene {
        /// The file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong.
        reason: String,
    },
    /// Something that is known by name alone.
    #[error("{what} cannot be rendered yet")]
    NotYet {
        /// What it is.
        what: String,
    },
    /// A substance that is not known.
    #[error("there is no substance called `{name}`")]
    NoSuchSubstance {
        /// What was asked for.
        name: String,
        /// What to do instead.
        help: String,
    },
    /// A substance without the index asked for.
    #[error(transparent)]
    Substance(Box<SubstanceError>),
    /// A file of refractive indices.
    #[error(transparent)]
    IndexFile(#[from] IndexFileError),
    /// A setting that means nothing here.
    #[error("{name} means nothing here; it belongs to {to}")]
    Belongs {
        /// The setting.
        name: &'static str,
        /// Where it means something.
        to: &'static str,
    },
    /// A particle that cannot be computed.
    #[error(transparent)]
    Mie(#[from] MieError),
    /// A layer that does not lie around what is inside it.
    #[error(
        "layer {number} reaches to {radius}, what lies inside it to {below}; give layers from the inside outward, each by its outer radius"
    )]
    Layers {
        /// Number of the layer, from 1.
        number: usize,
        /// Its outer radius.
        radius: Length,
        /// The outer radius of the one below.
        below: Length,
    },
    /// A weighting that there is not.
    #[error("there is no weighting `{name}`: number, surface, volume and intensity are known")]
    Weighting {
        /// What was asked for.
        name: String,
    },
    /// Sizes that cannot be counted in the way asked for.
    #[error(transparent)]
    Particle(#[from] ParticleError),
    /// A phase function that is none.
    #[error(transparent)]
    Phase(#[from] PhaseError),
    /// Fournier and Forand's function has one parameter besides the index.
    #[error("fournier-forand takes either the slope of the size distribution or the share scattered backward")]
    SlopeOrBackscatter,
    /// A file of paints or of measurements.
    #[error(transparent)]
    PaintFile(#[from] PaintFileError),
    /// Paints that cannot be.
    #[error(transparent)]
    Paint(#[from] PaintError),
    /// A paint that is not in the file.
    #[error("no paint called `{paint}`")]
    NoSuchPaint {
        /// Its name.
        paint: String,
        /// Names that are there.
        help: String,
    },
    /// A material that a format cannot hold.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// A table too long for memory.
    #[error(transparent)]
    Rows(#[from] RowsError),
    /// Layers that cannot be, or cannot be solved.
    #[error(transparent)]
    Transfer(#[from] TransferError),
    /// Photons that cannot be sent.
    #[error(transparent)]
    SlabWalk(#[from] SlabWalkError),
    /// A file of layers or with a phase function.
    #[error(transparent)]
    SlabFile(#[from] SlabFileError),
    /// Settings of a slab that do not go together.
    #[error(transparent)]
    Slab(#[from] SlabError),
    /// A file of measured slabs.
    #[error(transparent)]
    Rxt(#[from] RxtError),
    /// A measured slab that cannot be.
    #[error(transparent)]
    Inverse(#[from] InverseError),
    /// Measurements that integrating spheres have changed.
    #[error("`{}` was measured with {spheres} integrating sphere(s), for which nothing is corrected here", path.display())]
    Spheres {
        /// The file.
        path: PathBuf,
        /// How many at a time.
        spheres: u32,
    },
    /// A table of measurements.
    #[error(transparent)]
    Measured(#[from] MeasuredError),
    /// A comparison with nothing.
    #[error("there is nothing to compare with: name another material, or measurements with `--measured FILE`")]
    NothingToCompare,
    /// A setting that none of the materials of a scene has.
    #[error("no material of the scene {scene} has an input `{input}`")]
    NoSuchInput {
        /// Name of the scene.
        scene: String,
        /// The input.
        input: String,
    },
    /// A typed quantity in the job.
    #[error(transparent)]
    Quantity(#[from] QuantityError),
    /// A number that makes no sense.
    #[error("{name} = {value}: {allowed}")]
    Value {
        /// What it is.
        name: &'static str,
        /// What was given.
        value: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The scene `glass` needs a material.
    #[error(
        "the scene {scene} shows a material of your choice: render the material itself, as in `mieux render whole-milk`"
    )]
    NoMaterial {
        /// Name of the scene.
        scene: String,
    },
    /// A spectrum that is none.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
    /// The renderer.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The render to go on with.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// Parts of a picture that do not go together.
    #[error(transparent)]
    Merge(#[from] MergeError),
    /// Parts of a picture must end where one run would.
    #[error(
        "a part of a picture ends at a number of samples per pixel: give `--spp`, for by time or noise parts would not be those of one run"
    )]
    ShardStop,
    /// The parts were made of other materials than are found now.
    #[error("the materials of the parts have changed since, or cannot be found where they were")]
    OtherScene,
    /// A folder or file to be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A picture.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// Pictures of different sizes.
    #[error(
        "`{}` has {}x{} pixels, `{}` has {}x{}; only pictures of one size can be compared",
        first.display(), first_size[0], first_size[1], second.display(), second_size[0], second_size[1]
    )]
    PictureSizes {
        /// The first.
        first: PathBuf,
        /// Its width and height.
        first_size: [u32; 2],
        /// The second.
        second: PathBuf,
        /// Its width and height.
        second_size: [u32; 2],
    },
    /// A picture without the layers that are needed.
    #[error("`{}` has no channels {wanted}; it has {found}", path.display())]
    NoLayer {
        /// The file.
        path: PathBuf,
        /// The channels that are needed.
        wanted: String,
        /// Some that are there.
        found: String,
    },
    /// Pictures that cannot be compared.
    #[error(transparent)]
    Difference(#[from] DifferenceError),
    /// A plot.
    #[error(transparent)]
    Plot(#[from] PlotError),
    /// A table.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A table as Parquet.
    #[cfg(feature = "parquet")]
    #[error("the table cannot be written as Parquet: {0}")]
    Parquet(#[from] mieux_io::table::ParquetError),
    /// A data set as NetCDF.
    #[error(transparent)]
    NetCdf(#[from] NetCdfError),
    /// The threads could not be started.
    #[error("{threads} threads could not be started: {reason}")]
    Threads {
        /// How many.
        threads: usize,
        /// Why.
        reason: String,
    },
    /// Stopped before there was anything to keep.
    #[error("stopped before there was anything to keep")]
    Cancelled,
}

impl JobError {
    /// What to do about it, where there is something to say.
    pub fn help(&self) -> Option<String> {
        match self {
            Self::Recipe(RecipeError::Unknown { help, .. } | RecipeError::NoSuchInput { help, .. }) => {
                Some(help.clone())
            }
            Self::Rows(RowsError::Missing { help, .. }) => Some(help.clone()),
            Self::Recipe(RecipeError::Text(error))
            | Self::SlabFile(SlabFileError::Text(error))
            | Self::Measured(MeasuredError::Text(error))
            | Self::Rxt(RxtError::Text(error))
            | Self::PaintFile(PaintFileError::Text(error)) => error.help.clone(),
            Self::NoSuchPaint { help, .. } | Self::NoSuchSubstance { help, .. } => Some(help.clone()),
            Self::IndexFile(error) => error.help(),
            Self::Substance(error) if matches!(**error, SubstanceError::NoAbsorption { .. }) => {
                Some("give `--transparent` to take k for 0".into())
            }
            Self::Paint(PaintError::Relative { .. }) => {
                Some("fit again with `--reference-hides`, the thickness at which the reference by itself hides".into())
            }
            Self::Spheres { .. } => {
                Some("give `--corrected` if the reflectances and transmittances in it are those of the sample".into())
            }
            Self::NoLayer { wanted, .. } if wanted.starts_with("variance") => {
                Some("pictures are compared by their noise: render them with `mieux render`, which writes it".into())
            }
            Self::Checkpoint(CheckpointError::Read { .. }) => Some("leave out `--resume` to begin anew".into()),
            Self::Checkpoint(_) => Some("leave out `--resume` to begin anew, or give another folder with `-o`".into()),
            _ => None,
        }
    }
}
