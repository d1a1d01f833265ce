//! Files about slabs: which layers lie on each other ([`layers`]), and phase functions as tables ([`phase`]).

pub mod layers;
pub mod phase;

use std::io::Read;
use std::path::{Path, PathBuf};

use crate::text_error::TextError;

/// Largest file read, bytes: a phase function has thousands of rows, not millions.
const MAX_TEXT: u64 = 16 << 20;

/// Why there are no layers or no phase function.
#[derive(Debug, thiserror::Error)]
pub enum SlabFileError {
    /// A file that cannot be read.
    #[error("the {what} file `{}` cannot be read: {source}", path.display())]
    Read {
        /// `layers` or `phase function`.
        what: &'static str,
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file that says something impossible, with the place.
    #[error(transparent)]
    Text(#[from] Box<TextError>),
}

fn read_text(what: &'static str, path: &Path) -> Result<String, SlabFileError> {
    let error = |source| SlabFileError::Read { what, path: path.into(), source };
    let mut text = String::new();
    let file = std::fs::File::open(path).map_err(error)?;
    file.take(MAX_TEXT + 1).read_to_string(&mut text).map_err(error)?;
    if text.len() as u64 > MAX_TEXT {
        return Err(error(std::io::Error::other("it is larger than 16 MiB")));
    }
    Ok(text)
}
