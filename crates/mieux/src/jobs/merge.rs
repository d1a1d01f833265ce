//! The job behind `mieux merge`: parts of a picture become the whole.

use std::path::{Path, PathBuf};

use mieux_io::checkpoint::read_any_checkpoint;
use mieux_io::quantity::Size;
use mieux_render::film::Film;
use mieux_render::render::{Shard, owned_tiles};
use serde::{Deserialize, Serialize};

use super::render::SHARD;
use super::{Context, JobError, Render, RenderReport, Stop};

/// Parts that were rendered with `--shard`, put together: the same bits as one run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Merge {
    /// The folders in which the parts were rendered, or their `shard.film`, in any order.
    pub parts: Vec<PathBuf>,
    /// Folder for the results.
    pub output: PathBuf,
}

/// Parts that do not make a picture.
#[derive(Debug, thiserror::Error)]
pub enum MergeError {
    /// No parts.
    #[error("there is nothing to merge")]
    Nothing,
    /// A whole film, or one of another version.
    #[error("`{}` is not a part of a picture by this version of mieux", path.display())]
    NoPart {
        /// The file.
        path: PathBuf,
    },
    /// Parts of different pictures.
    #[error("`{}` and `{}` are parts of different pictures", first.display(), path.display())]
    Different {
        /// One file.
        first: PathBuf,
        /// The other.
        path: PathBuf,
    },
    /// The same part twice.
    #[error("part {index}/{count} is there twice: `{}` and `{}`", first.display(), path.display())]
    Twice {
        /// Which part, from 1.
        index: u32,
        /// Of how many.
        count: u32,
        /// One file.
        first: PathBuf,
        /// The other.
        path: PathBuf,
    },
    /// Parts that are not there.
    #[error("of {count} parts these are missing: {missing}")]
    Missing {
        /// How many there should be.
        count: u32,
        /// Which are not there.
        missing: String,
    },
    /// A part with too few samples.
    #[error("`{}` is not finished", path.display())]
    Unfinished {
        /// The file.
        path: PathBuf,
    },
}

struct Part {
    path: PathBuf,
    shard: (u32, u32),
    samples: u64,
    job: Render,
    fingerprint: String,
    film: Film,
}

impl Merge {
    pub(super) fn run(&self, context: &Context<'_>) -> Result<RenderReport, JobError> {
        let parts = self.parts.iter().map(|path| read(path)).collect::<Result<Vec<_>, _>>()?;
        let first = parts.first().ok_or(MergeError::Nothing)?;
        check(&parts)?;
        let [width, height] = first.film.resolution();
        let (left, top) = first.job.crop.map_or((0, 0), |c| (c[0], c[1]));
        let mut film = Film::with_bins([width, height], first.film.bins());
        for part in &parts {
            let shard = Shard { index: part.shard.0 - 1, count: part.shard.1 };
            for [x, y, w, h] in owned_tiles([left, top, width, height], Some(shard)) {
                for (x, y) in (y..y + h).flat_map(|y| (x..x + w).map(move |x| (x, y))) {
                    if part.film.pixel(x, y).is_none_or(|p| p.samples != part.samples) {
                        return Err(MergeError::Unfinished { path: part.path.clone() }.into());
                    }
                    film.take(&part.film, x, y);
                }
            }
        }
        let size = first.job.size.map_or_else(|| Size::new(width, height), Ok)?;
        let (job, identity) = first.job.whole(size, &first.fingerprint);
        let job = Render { output: Some(self.output.clone()), ..job };
        job.develop(Some((&identity, film)), context)
    }
}

fn read(path: &Path) -> Result<Part, JobError> {
    let path = if path.is_dir() { path.join(SHARD) } else { path.to_owned() };
    let (identity, film) = read_any_checkpoint(&path)?;
    let no_part = || MergeError::NoPart { path: path.clone() };
    let version = concat!("mieux ", env!("CARGO_PKG_VERSION"), " ");
    let rest = identity.strip_prefix(version).ok_or_else(no_part)?;
    let (fingerprint, job) = rest.split_once(' ').ok_or_else(no_part)?;
    let job: Render = serde_json::from_str(job).map_err(|_| no_part())?;
    let (Some(shard), Stop::Samples(samples)) = (job.shard, job.stop) else { return Err(no_part().into()) };
    let size = job.size.ok_or_else(no_part)?;
    let window = job.crop.map_or([size.width(), size.height()], |c| [c[2], c[3]]);
    if shard.0 == 0 || shard.0 > shard.1 || shard.1 > 65_536 || window != film.resolution() {
        return Err(no_part().into());
    }
    Ok(Part { fingerprint: fingerprint.into(), path, shard, samples, job, film })
}

fn check(parts: &[Part]) -> Result<(), MergeError> {
    let Some(first) = parts.first() else { return Err(MergeError::Nothing) };
    let count = first.shard.1;
    let mut found: Vec<Option<&Part>> = vec![None; count as usize];
    for part in parts {
        let same = Render { shard: None, ..part.job.clone() } == Render { shard: None, ..first.job.clone() };
        if !same || part.fingerprint != first.fingerprint || part.shard.1 != count {
            return Err(MergeError::Different { first: first.path.clone(), path: part.path.clone() });
        }
        let index = part.shard.0;
        if let Some(other) = found[index as usize - 1].replace(part) {
            return Err(MergeError::Twice { index, count, first: other.path.clone(), path: part.path.clone() });
        }
    }
    let missing: Vec<String> = (1..=count).zip(&found).filter(|(_, f)| f.is_none()).map(|m| m.0.to_string()).collect();
    if missing.is_empty() { Ok(()) } else { Err(MergeError::Missing { count, missing: missing.join(", ") }) }
}
