//! A film in the middle of its exposure, kept so that a render can go on where it stopped, to the same bits.
//!
//! Layout: one line of ASCII (`mieux-film 2 WIDTH HEIGHT BINS FLOOR JOB`: bins of wavelength, the floor of relative errors
//! as 16 hexadecimal digits of its bits or `-`, and what the film belongs to as one line of text), then per pixel, row by
//! row: ten `f64` sums and the `u64` number of samples, little endian; then per pixel the `f64` sums of its bins; then the
//! CRC-32 of all that goes before.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};

use crc32fast::Hasher;
use mieux_render::film::{Film, Pixel};

use crate::output::{OutputError, write_atomic};
use crate::quantity::Size;

/// Bytes per pixel without spectra.
const PIXEL: u64 = 88;
/// Most bins of wavelength.
pub const MAX_BINS: u32 = 40;
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
/// [`OutputError::Write`], and then the file is as it was.
pub fn write_checkpoint(path: &Path, job: &str, film: &Film) -> Result<(), OutputError> {
    let [width, height] = film.resolution();
    let job = job.replace('\n', " ");
    let floor = film.floor().map_or("-".into(), |floor| format!("{:016x}", floor.to_bits()));
    write_atomic(path, |out| {
        let mut out = Summed { inner: out, sum: Hasher::new() };
        writeln!(out, "mieux-film 2 {width} {height} {} {floor} {job}", film.bins())?;
        for pixel in film.pixels() {
            let sums = pixel.sum.iter().chain(&pixel.sum_squares).chain([&pixel.sum_squares_luminance]);
            let sums = sums.chain(&pixel.open_group);
            for value in sums {
                out.write_all(&value.to_le_bytes())?;
            }
            out.write_all(&pixel.samples.to_le_bytes())?;
        }
        for value in film.spectra() {
            out.write_all(&value.to_le_bytes())?;
        }
        let sum = out.sum.finalize();
        out.inner.write_all(&sum.to_le_bytes())
    })
}

/// Sums up what goes through.
struct Summed<T> {
    inner: T,
    sum: Hasher,
}

impl<W: Write> Write for Summed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.sum.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl<R: Read> Summed<R> {
    fn word(&mut self) -> io::Result<[u8; 8]> {
        let mut bytes = [0; 8];
        self.inner.read_exact(&mut bytes)?;
        self.sum.update(&bytes);
        Ok(bytes)
    }
}

/// Reads the film of a job.
///
/// # Errors
/// [`CheckpointError`]: not readable, damaged, or of another job.
pub fn read_checkpoint(path: &Path, job: &str) -> Result<Film, CheckpointError> {
    let (found, film) = read_any_checkpoint(path)?;
    if found != job.replace('\n', " ") {
        return Err(CheckpointError::OtherJob { path: path.into(), found, wanted: job.into() });
    }
    Ok(film)
}

/// Reads a film and what it belongs to.
///
/// # Errors
/// [`CheckpointError`]: not readable, or damaged.
pub fn read_any_checkpoint(path: &Path) -> Result<(String, Film), CheckpointError> {
    let read = |source| CheckpointError::Read { path: path.into(), source };
    let damaged = |problem: String| CheckpointError::Damaged { path: path.into(), problem };
    let file = std::fs::File::open(path).map_err(read)?;
    let length = file.metadata().map_err(read)?.len();
    let mut reader = BufReader::new(file);
    let mut line = String::new();
    reader.by_ref().take(MAX_LINE).read_line(&mut line).map_err(|e| damaged(e.to_string()))?;
    let header = line.strip_suffix('\n').and_then(|l| l.strip_prefix("mieux-film 2 "));
    let header = header.ok_or_else(|| damaged("its first line is not that of a film of this version".into()))?;
    let mut words = header.splitn(5, ' ');
    let mut number = || words.next().and_then(|w| w.parse::<u32>().ok());
    let (width, height, bins) = (number(), number(), number());
    let size = width.zip(height).and_then(|(w, h)| Size::new(w, h).ok());
    let size = size.ok_or_else(|| damaged("its size is not that of a picture".into()))?;
    let bins = bins.filter(|&b| b <= MAX_BINS).ok_or_else(|| damaged("its number of bins is impossible".into()))?;
    let floor = match words.next() {
        Some("-") => None,
        Some(bits) => match u64::from_str_radix(bits, 16) {
            Ok(bits) => Some(f64::from_bits(bits)),
            Err(e) => return Err(damaged(e.to_string())),
        },
        None => return Err(damaged("its first line is cut short".into())),
    };
    let job = words.next().unwrap_or_default().to_owned();
    let expected = line.len() as u64 + size.pixels() as u64 * (PIXEL + 8 * u64::from(bins)) + 4;
    if length != expected {
        return Err(damaged(format!("it holds {length} bytes instead of {expected}")));
    }
    let mut reader = Summed { inner: reader, sum: Hasher::new() };
    reader.sum.update(line.as_bytes());
    let film = body(&mut reader, size, bins, floor).map_err(|e| damaged(e.to_string()))?;
    Ok((job, film))
}

/// The numbers after the first line, weighed against their sum.
fn body(reader: &mut Summed<impl Read>, size: Size, bins: u32, floor: Option<f64>) -> io::Result<Film> {
    let invalid = |problem: String| io::Error::new(io::ErrorKind::InvalidData, problem);
    let mut pixels = Vec::with_capacity(size.pixels());
    for _ in 0..size.pixels() {
        let mut bytes = [0u8; PIXEL as usize];
        for word in bytes.chunks_exact_mut(8) {
            word.copy_from_slice(&reader.word()?);
        }
        pixels.push(pixel(&bytes));
    }
    let mut spectra = Vec::with_capacity(size.pixels() * bins as usize);
    for _ in 0..size.pixels() * bins as usize {
        spectra.push(f64::from_le_bytes(reader.word()?));
    }
    let mut sum = [0; 4];
    reader.inner.read_exact(&mut sum)?;
    let found = reader.sum.clone().finalize();
    if u32::from_le_bytes(sum) != found {
        return Err(invalid(format!("its checksum is {:08x}, not {found:08x}", u32::from_le_bytes(sum))));
    }
    Film::from_parts([size.width(), size.height()], pixels)
        .and_then(|film| film.with_spectra(bins as usize, spectra))
        .and_then(|film| film.with_floor(floor))
        .map_err(|e| invalid(e.to_string()))
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
        let film = Film::from_parts([3, 2], pixels).unwrap();
        let spectra = (0..12).map(|i| f64::from(i) / 7.0).collect();
        film.with_spectra(2, spectra).unwrap().with_floor(Some(0.1)).unwrap()
    }

    #[test]
    fn a_film_comes_back_to_the_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("film");
        write_checkpoint(&path, "job a", &film()).unwrap();
        assert_eq!(read_checkpoint(&path, "job a").unwrap(), film());
        assert_eq!(read_any_checkpoint(&path).unwrap(), ("job a".into(), film()));
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
        for at in 0..whole.len() {
            let mut changed = whole.clone();
            changed[at] ^= 1 << (at % 8);
            std::fs::write(&path, &changed).unwrap();
            assert!(read_checkpoint(&path, "job").is_err(), "byte {at}");
        }
        let mut nan = whole.clone();
        let start = whole.iter().position(|&b| b == b'\n').unwrap() + 1;
        nan[start..start + 8].copy_from_slice(&f64::NAN.to_le_bytes());
        let end = nan.len() - 4;
        let sum = crc32fast::hash(&nan[..end]).to_le_bytes();
        nan[end..].copy_from_slice(&sum);
        std::fs::write(&path, nan).unwrap();
        assert!(matches!(read_checkpoint(&path, "job"), Err(CheckpointError::Damaged { .. })));
        std::fs::write(&path, b"mieux-film 2 99999 99999 0 - job\n").unwrap();
        assert!(matches!(read_checkpoint(&path, "job"), Err(CheckpointError::Damaged { .. })));
    }
}
