//! Values in a box, and the files they come in: NRRD (`.nrrd`), Mitsuba's volumes (`.vol`), and raw numbers with a header of
//! our own (`.toml`, see [`read_grid`]).
//!
//! Whatever a file declares, memory grows with the bytes that are there, and never beyond [`MAX_CELLS`] values.

mod header;
mod nrrd;
mod vol;

use std::io::Read;
use std::path::{Path, PathBuf};

pub use vol::read_vol;

use crate::scene::description::Grid;
use crate::text_error::TextError;

/// More cells than this are not read: 1 GiB of values.
pub const MAX_CELLS: usize = 1 << 28;

/// Why there is no grid.
#[derive(Debug, thiserror::Error)]
pub enum GridError {
    /// The file cannot be opened or read.
    #[error("the grid `{}` cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The name ends in nothing that is known.
    #[error("`{}` is no grid that can be read: its name ends in none of .nrrd, .vol, .toml", path.display())]
    Kind {
        /// The file.
        path: PathBuf,
    },
    /// The file does not keep to its format.
    #[error("the grid `{}` is damaged or not supported: {problem}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// A cell with no number in it.
    #[error("the grid `{}` has a value that is not finite, {value}, in cell {cell:?}", path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// Along x, y, z, from 0.
        cell: [usize; 3],
        /// What is there.
        value: f32,
    },
    /// A mistake in a header of our own, with the place.
    #[error(transparent)]
    Text(#[from] Box<TextError>),
}

/// Reads a grid by what its name ends in.
///
/// A header of our own is TOML:
///
/// ```toml
/// data = "cloud.raw"            # beside this file; x runs fastest, then y, then z
/// dims = [128, 128, 64]         # cells along x, y, z
/// type = "f32"                  # u8, i8, u16, i16, u32, i32, f32 (unless given), f64
/// endian = "little"             # unless given; or "big"
/// compression = "none"          # unless given; or "gzip"
/// size = ["2 km", "2 km", "1 km"]   # of the box; 1 m each unless given
/// origin = ["0 m", "0 m", "0 m"]    # its lowest corner; the origin unless given
/// ```
///
/// Without a place in the file, the grid fills the unit cube. Whole numbers are taken as they are.
///
/// # Errors
/// [`GridError`].
pub fn read_grid(path: &Path) -> Result<Grid, GridError> {
    match path.extension().map(|e| e.to_string_lossy().to_lowercase()).as_deref() {
        Some("nrrd") => nrrd::read(path),
        Some("vol") => read_vol(path),
        Some("toml") => header::read(path),
        _ => Err(GridError::Kind { path: path.into() }),
    }
}

/// How a number lies in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// Of as many bytes as [`Self::bytes`], the lowest first.
    fn value(self, b: &[u8]) -> f32 {
        let mut low = [0; 8];
        low[..b.len()].copy_from_slice(b);
        let whole = u64::from_le_bytes(low);
        match self {
            Self::I8 => f32::from(whole as i8),
            Self::U8 => f32::from(whole as u8),
            Self::I16 => f32::from(whole as i16),
            Self::U16 => f32::from(whole as u16),
            Self::I32 => whole as i32 as f32,
            Self::U32 => whole as u32 as f32,
            Self::I64 => whole as i64 as f32,
            Self::U64 => whole as f32,
            Self::F32 => f32::from_bits(whole as u32),
            Self::F64 => f64::from_bits(whole) as f32,
        }
    }
}

/// How many cells that is, if it is neither none nor too many.
fn cells(path: &Path, dims: [u64; 3]) -> Result<usize, GridError> {
    let count = dims.iter().try_fold(1_u64, |n, &d| n.checked_mul(d));
    match count {
        Some(n) if (1..=MAX_CELLS as u64).contains(&n) => Ok(n as usize),
        _ => {
            let [x, y, z] = dims;
            let problem = format!("it declares {x} x {y} x {z} cells, and 1 to {MAX_CELLS} are allowed");
            Err(GridError::Format { path: path.into(), problem })
        }
    }
}

/// Reads `count` numbers; memory grows as they come.
fn numbers(path: &Path, from: &mut dyn Read, count: usize, kind: Scalar, big: bool) -> Result<Vec<f32>, GridError> {
    const AT_ONCE: usize = 1 << 16;
    let width = kind.bytes();
    let mut values = Vec::new();
    let mut buffer = vec![0_u8; AT_ONCE.min(count) * width];
    while values.len() < count {
        let want = (count - values.len()).min(AT_ONCE) * width;
        let piece = &mut buffer[..want];
        from.read_exact(piece).map_err(|e| match e.kind() {
            std::io::ErrorKind::UnexpectedEof => {
                let problem = format!("it ends after fewer than its {count} values ({} read so far)", values.len());
                GridError::Format { path: path.into(), problem }
            }
            _ => GridError::Read { path: path.into(), source: e },
        })?;
        if big {
            piece.chunks_exact_mut(width).for_each(<[u8]>::reverse);
        }
        values.extend(piece.chunks_exact(width).map(|b| kind.value(b)));
    }
    Ok(values)
}

/// That every value is a number.
fn check(path: &Path, dims: [usize; 3], values: &[f32]) -> Result<(), GridError> {
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(at) => {
            let cell = [at % dims[0], at / dims[0] % dims[1], at / dims[0] / dims[1]];
            Err(GridError::Value { path: path.into(), cell, value: values[at] })
        }
    }
}

#[cfg(test)]
mod tests;
