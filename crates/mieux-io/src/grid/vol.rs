//! Mitsuba's binary volumes, version 3, of one channel of 32-bit floats.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use super::{GridError, Scalar, cells, check, numbers};
use crate::scene::Transform;
use crate::scene::description::{Grid, GridFilter};

/// Reads a volume of Mitsuba; its `to_world` is the bounding box in the file.
///
/// # Errors
/// [`GridError`]; also where there is more than one channel.
pub fn read_vol(path: &Path) -> Result<Grid, GridError> {
    let io = |source| GridError::Read { path: path.into(), source };
    let error = |problem: String| GridError::Format { path: path.into(), problem };
    let mut file = BufReader::new(File::open(path).map_err(io)?);
    let mut head = [0_u8; 48];
    file.read_exact(&mut head).map_err(|_| error("it is shorter than a header of 48 bytes".into()))?;
    if head[..3] != *b"VOL" || head[3] != 3 {
        return Err(error("it does not start with `VOL` and the version 3".into()));
    }
    let word = |i: usize| [head[4 + 4 * i], head[5 + 4 * i], head[6 + 4 * i], head[7 + 4 * i]];
    let whole = |i: usize| i32::from_le_bytes(word(i));
    if whole(0) != 1 {
        return Err(error(format!("its values are of type {}, and only 1, 32-bit floats, is supported", whole(0))));
    }
    if whole(4) != 1 {
        return Err(error(format!("it has {} channels, and only one is supported", whole(4))));
    }
    let declared = [whole(1), whole(2), whole(3)].map(|d| u64::try_from(d).unwrap_or(0));
    let count = cells(path, declared)?;
    let corner = |i: usize| -> [f64; 3] { std::array::from_fn(|k| f64::from(f32::from_le_bytes(word(i + k)))) };
    let (low, high) = (corner(5), corner(8));
    let extent: [f64; 3] = std::array::from_fn(|i| high[i] - low[i]);
    let to_world = Transform::scale(extent).then(&Transform::translate(low));
    // The box is often not filled in, and need not be used.
    let to_world = if to_world.is_affine_and_invertible() { to_world } else { Transform::IDENTITY };
    let values = numbers(path, &mut file, count, Scalar::F32, false)?;
    let dims = declared.map(|d| d as usize);
    check(path, dims, &values)?;
    Ok(Grid { dims, values, to_world, filter: GridFilter::Trilinear })
}
