//! A film in the middle of its exposure, kept so that a render can go on where it stopped, to the same bits.
//!
//! Layout: one line of ASCII (`mieux-film 1 WIDTH HEIGHT JOB`, the job being what the film belongs to, as one line of
//! text), then per pixel, row by row: ten `f64` sums and the `u64` number of samples, little endian.

use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use mieux_render::film::{Film, FilmError, Pixel};

use crate::output::{OutputError, write_atomic};
use crate::quantity::Size;

/// Bytes per pixel.
const PIXEL: u64 = 88;
/// Longest first line.
const MAX_LINE: u64 = 1 << 16;

/// Why a checkpoint cannot be taken up.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The file cannot be read.
    #[error("there is nothing to go on with: `{}` cannot be read: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The file is no checkpoint, or not all of it is there.
    #[error("`{}` is not a whole checkpoint: {problem}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// The checkpoint belongs to another render.
    #[error("`{}` belongs to another render: it was made by {found}, this is {wanted}", path.display())]
    OtherJob {
        /// The file.
        path: PathBuf,
        /// The job in the file.
        found: String,
        /// The job that asks.
        wanted: String,
    },
}

/// Writes a film and the one-line description of the job it belongs to.
///
/// # Errors
/// [`OutputError::Write`].
pub fn write_checkpoint(path: &Path, job: &str, film: &Film) -> Result<(), OutputError> {
    let [width, height] = film.resolution();
    let job = job.replace('\n', " ");
    write_atomic(path, |out| {
        writeln!(out, "mieux-film 1 {width} {height} {job}")?;
        for pixel in film.pixels() {
            let sums = pixel.sum.iter().chain(&pixel.sum_squares).chain([&pixel.sum_squares_luminance]);
            let sums = sums.chain(&pixel.open_group);
            for value in sums {
                out.write_all(&value.to_le_bytes())?;
            }
            out.write_all(&pixel.samples.to_le_bytes())?;
        }
        Ok(())
    })
}

/// Reads the film of a job.
///
/// # Errors
/// [`CheckpointError`]: not readable, damaged, or of another job.
pub fn read_checkpoint(path: &Path, job: &str) -> Result<Film, CheckpointError> {
    let read = |source| CheckpointError::Read { path: path.into(), source };
    let damaged = |problem: String| CheckpointError::Damaged { path: path.into(), problem };
    let file = std::fs::File::open(path).map_err(read)?;
    let length = file.metadata().map_err(read)?.len();
    let mut reader = BufReader::new(file);
    let mut line = String::new();
    reader.by_ref().take(MAX_LINE).read_line(&mut line).map_err(|e| damaged(e.to_string()))?;
    let header = line.strip_suffix('\n').and_then(|l| l.strip_prefix("mieux-film 1 "));
    let header = header.ok_or_else(|| damaged("its first line is not that of a film".into()))?;
    let mut words = header.splitn(3, ' ');
    let mut number = || words.next().and_then(|w| w.parse::<u32>().ok());
    let (width, height) = (number(), number());
    let size = width.zip(height).and_then(|(w, h)| Size::new(w, h).ok());
    let size = size.ok_or_else(|| damaged("its size is not that of a picture".into()))?;
    let found = words.next().unwrap_or_default();
    if found != job.replace('\n', " ") {
        return Err(CheckpointError::OtherJob { path: path.into(), found: found.into(), wanted: job.into() });
    }
    let expected = line.len() as u64 + size.pixels() as u64 * PIXEL;
    if length != expected {
        return Err(damaged(format!("it holds {length} bytes instead of {expected}")));
    }
    let mut pixels = Vec::with_capacity(size.pixels());
    for _ in 0..size.pixels() {
        let mut bytes = [0u8; PIXEL as usize];
        reader.read_exact(&mut bytes).map_err(|e| damaged(e.to_string()))?;
        pixels.push(pixel(&bytes));
    }
    Film::from_parts([size.width(), size.height()], pixels).map_err(|e: FilmError| damaged(e.to_string()))
}

fn pixel(bytes: &[u8; PIXEL as usize]) -> Pixel {
    let word = |i: usize| std::array::from_fn::<u8, 8, _>(|k| bytes[8 * i + k]);
    let float = |i: usize| f64::from_le_bytes(word(i));
    Pixel {
        sum: std::array::from_fn(float),
        sum_squares: std::array::from_fn(|c| float(3 + c)),
        sum_squares_luminance: float(6),
        open_group: std::array::from_fn(|c| float(7 + c)),
        samples: u64::from_le_bytes(word(10)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn film() -> Film {
        let mut pixels = vec![Pixel::default(); 6];
        for (i, pixel) in pixels.iter_mut().enumerate() {
            (0..2 * i).for_each(|k| pixel.add([0.1 * k as f64, 0.7, 1.0 / 3.0]));
        }
        Film::from_parts([3, 2], pixels).unwrap()
    }

    #[test]
    fn a_film_comes_back_to_the_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("film");
        write_checkpoint(&path, "job a", &film()).unwrap();
        assert_eq!(read_checkpoint(&path, "job a").unwrap(), film());
        assert!(matches!(read_checkpoint(&path, "job b"), Err(CheckpointError::OtherJob { .. })));
        assert!(matches!(read_checkpoint(&folder.path().join("no"), "job a"), Err(CheckpointError::Read { .. })));
    }

    #[test]
    fn a_damaged_file_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("film");
        write_checkpoint(&path, "job", &film()).unwrap();
        let whole = std::fs::read(&path).unwrap();
        for length in 0..whole.len() {
            std::fs::write(&path, &whole[..length]).unwrap();
            assert!(read_checkpoint(&path, "job").is_err(), "{length} bytes");
        }
        let mut nan = whole.clone();
        let start = whole.iter().position(|&b| b == b'\n').unwrap() + 1;
        nan[start..start + 8].copy_from_slice(&f64::NAN.to_le_bytes());
        std::fs::write(&path, nan).unwrap();
        assert!(matches!(read_checkpoint(&path, "job"), Err(CheckpointError::Damaged { .. })));
        std::fs::write(&path, b"mieux-film 1 99999 99999 job\n").unwrap();
        assert!(matches!(read_checkpoint(&path, "job"), Err(CheckpointError::Damaged { .. })));
    }
}
