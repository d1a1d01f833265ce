//! OpenEXR with 32-bit floats: what was computed, with how sure it is.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek};
use std::path::Path;

use exr::meta::attribute::AttributeValue;
use exr::meta::header::Header;
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, Layer, LayerAttributes, LineOrder,
    ReadChannels, ReadLayers, Text, WritableImage,
};

use super::{ImageError, check_length, damaged, unsupported};
use crate::output::{WriteSeek, write_atomic};
use crate::quantity::Size;

/// What the files say they were made with.
pub(super) const SOFTWARE: &str = concat!("mieux ", env!("CARGO_PKG_VERSION"));

/// No image has more channels than this, over all its layers.
pub const MAX_CHANNELS: usize = 64;

/// No more values than this are read from one file (4 GB of them).
const MAX_VALUES: usize = 1_000_000_000;

/// A rendered picture in linear sRGB: what was estimated, and the variance of that estimate.
#[derive(Debug, Clone, Copy)]
pub struct Film<'a, T> {
    /// Red, green, blue of every pixel, rows from the top; 1 is white.
    pub rgb: &'a [T],
    /// The variance of the mean, in the square of the same unit: three values for every pixel.
    pub variance: Option<&'a [T]>,
    /// How many samples the mean is over: one value for every pixel.
    pub samples: Option<&'a [T]>,
}

/// Writes a film: the channels `R`, `G`, `B` as the main layer, `variance.R`, `variance.G`, `variance.B` as a second one,
/// and `samples`.
///
/// `comment` says what the picture shows and how it was made, for instance the command and the material.
///
/// # Errors
/// [`ImageError::Size`], [`ImageError::Length`] or [`ImageError::Output`].
pub fn write_exr<T: Copy + Into<f64>>(
    path: &Path,
    width: u32,
    height: u32,
    film: &Film<'_, T>,
    comment: &str,
) -> Result<(), ImageError> {
    let size = Size::new(width, height)?;
    let mut channels = BTreeMap::new();
    let mut add = |what: &str, names: &[&str], values: &[T]| {
        check_length(what, values.len(), size, names.len())?;
        for (i, name) in names.iter().enumerate() {
            let one = values.iter().skip(i).step_by(names.len()).map(|&v| v.into() as f32);
            channels.insert((*name).to_owned(), one.collect());
        }
        Ok::<_, ImageError>(())
    };
    add("the picture", &["R", "G", "B"], film.rgb)?;
    if let Some(variance) = film.variance {
        add("the variance", &["variance.R", "variance.G", "variance.B"], variance)?;
    }
    if let Some(samples) = film.samples {
        add("the number of samples", &["samples"], samples)?;
    }
    write_exr_channels(path, width, height, channels, comment)
}

/// Writes channels by their names; a name `layer.channel` puts a channel in a layer, `R`, `G`, `B` are what viewers show.
///
/// One part with 32-bit floats and ZIP compression, which loses nothing and which every reader knows.
///
/// # Errors
/// [`ImageError::Size`]; [`ImageError::Channels`] with no channel, more than [`MAX_CHANNELS`], or a name that is not 1 to
/// 255 printable ASCII characters; [`ImageError::Length`]; [`ImageError::Output`].
pub fn write_exr_channels(
    path: &Path,
    width: u32,
    height: u32,
    channels: BTreeMap<String, Vec<f32>>,
    comment: &str,
) -> Result<(), ImageError> {
    write_exr_spectral(path, width, height, channels, comment, None)
}

/// The name of the channel that holds radiance around a wavelength (m), as in `S0.512,500000nm`: the unpolarised part of
/// the layout of `fichet2021`, which its viewers know.
pub fn spectral_channel(wavelength: f64) -> String {
    let number = format!("{:.6}", wavelength * 1e9).replace('.', ",");
    format!("S0.{number}nm")
}

/// [`write_exr_channels`] for channels among which are spectral ones ([`spectral_channel`]) in some unit of radiance per
/// wavelength, which the file names as the layout asks: attributes `spectralLayoutVersion` and `emissiveUnits`.
///
/// # Errors
/// As [`write_exr_channels`].
pub fn write_exr_spectral(
    path: &Path,
    width: u32,
    height: u32,
    channels: BTreeMap<String, Vec<f32>>,
    comment: &str,
    units: Option<&str>,
) -> Result<(), ImageError> {
    let size = Size::new(width, height)?;
    if channels.is_empty() || channels.len() > MAX_CHANNELS {
        let problem = format!("there are {}, and 1 to {MAX_CHANNELS} are allowed", channels.len());
        return Err(ImageError::Channels { problem });
    }
    let mut list = Vec::with_capacity(channels.len());
    for (name, values) in channels {
        check_length(&format!("the channel `{name}`"), values.len(), size, 1)?;
        let printable =
            !name.is_empty() && name.len() <= 255 && name.bytes().all(|b| b.is_ascii_graphic() || b == b' ');
        match Text::new_or_none(&name) {
            Some(text) if printable => list.push(AnyChannel::new(text, FlatSamples::F32(values))),
            _ => {
                let problem = format!("the name `{name}` is not 1 to 255 printable ASCII characters");
                return Err(ImageError::Channels { problem });
            }
        }
    }
    let mut attributes = LayerAttributes {
        software_name: Text::new_or_none(SOFTWARE),
        comments: Text::new_or_none(ascii(comment)).filter(|_| !comment.is_empty()),
        ..LayerAttributes::default()
    };
    // One attribute here and one for the image: in a map of several, their order in the file would be left to chance.
    if let Some(units) = units.and_then(|units| Text::new_or_none(ascii(units))) {
        attributes.other.insert(Text::from("emissiveUnits"), AttributeValue::Text(units));
    }
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let (width, height) = (size.width() as usize, size.height() as usize);
    let layer = Layer::new((width, height), attributes, encoding, AnyChannels::sort(list.into()));
    let mut image = Image::from_layer(layer);
    if units.is_some() {
        image.attributes.other.insert(Text::from("spectralLayoutVersion"), AttributeValue::Text(Text::from("1.0")));
    }
    write_atomic(path, |out: &mut dyn WriteSeek| {
        image.write().to_buffered(out).map_err(|e| match e {
            exr::error::Error::Io(e) => e,
            other => io::Error::new(io::ErrorKind::InvalidInput, other.to_string()),
        })
    })?;
    Ok(())
}

/// The text in the characters every reader of the format knows.
fn ascii(text: &str) -> String {
    let known = |c: char| c.is_ascii_graphic() || matches!(c, ' ' | '\n');
    text.chars()
        .map(|c| {
            if known(c) {
                c
            } else if matches!(c, 'µ' | '\u{3bc}') {
                'u'
            } else {
                '?'
            }
        })
        .collect()
}

/// What was read from an OpenEXR file.
#[derive(Debug, Clone, PartialEq)]
pub struct ExrImage {
    /// Width and height in pixels.
    pub size: Size,
    /// Every channel by its name, rows from the top. In a file of several parts, the name of the part comes first:
    /// `part.channel`.
    pub channels: BTreeMap<String, Vec<f32>>,
    /// The program that wrote the file.
    pub software: Option<String>,
    /// What it had to say about it.
    pub comment: Option<String>,
}

impl ExrImage {
    /// Three channels `prefix` + `R`, `G`, `B` as one value after the other, or `None` where one is missing. The prefix is
    /// empty for the picture itself, `variance.` for its variance.
    pub fn rgb(&self, prefix: &str) -> Option<Vec<f32>> {
        let [r, g, b] = ["R", "G", "B"].map(|c| self.channels.get(&format!("{prefix}{c}")));
        let (r, g, b) = (r?, g?, b?);
        Some(r.iter().zip(g).zip(b).flat_map(|((&r, &g), &b)| [r, g, b]).collect())
    }
}

/// Reads every channel of an OpenEXR file as 32-bit floats, the finest resolution where there are several.
///
/// What the file says about its size is weighed against its length on disk before memory is set aside for it.
///
/// # Errors
/// [`ImageError::Read`], [`ImageError::Damaged`] or [`ImageError::Unsupported`].
pub fn read_exr(path: &Path) -> Result<ExrImage, ImageError> {
    let read_error = |source| ImageError::Read { path: path.to_owned(), source };
    let file = File::open(path).map_err(read_error)?;
    let metadata = file.metadata().map_err(read_error)?;
    if !metadata.is_file() {
        return Err(unsupported(path, "only regular files are read"));
    }
    decode(BufReader::new(file), metadata.len(), path)
}

fn decode(file: impl Read + Seek, file_bytes: u64, path: &Path) -> Result<ExrImage, ImageError> {
    let error = |e: exr::error::Error| match e {
        exr::error::Error::Io(source) => ImageError::Read { path: path.to_owned(), source },
        exr::error::Error::NotSupported(problem) => unsupported(path, problem),
        other => damaged(path, other.to_string()),
    };
    let chunks = exr::block::read(file, false).map_err(error)?;
    let size = check_headers(chunks.headers(), file_bytes, path)?;
    let parts = chunks.headers().len();
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_chunks(chunks)
        .map_err(error)?;
    let mut channels = BTreeMap::new();
    let (mut software, mut comment) = (None, None);
    for layer in image.layer_data {
        software = software.or_else(|| layer.attributes.software_name.as_ref().map(Text::to_string));
        comment = comment.or_else(|| layer.attributes.comments.as_ref().map(Text::to_string));
        for channel in layer.channel_data.list {
            let name = match &layer.attributes.layer_name {
                Some(part) if parts > 1 => format!("{part}.{}", channel.name),
                _ => channel.name.to_string(),
            };
            let values = match channel.sample_data {
                FlatSamples::F32(values) => values,
                other => other.values_as_f32().collect(),
            };
            check_length(&format!("the channel `{name}`"), values.len(), size, 1)?;
            if let Some((name, _)) = channels.insert(name.clone(), values).map(|old| (name, old)) {
                return Err(damaged(path, format!("there are two channels `{name}`")));
            }
        }
    }
    Ok(ExrImage { size, channels, software, comment })
}

/// The size of the image, once what the headers promise is known to be sane and to fit in a file of that length.
fn check_headers(headers: &[Header], file_bytes: u64, path: &Path) -> Result<Size, ImageError> {
    let first = headers.first().ok_or_else(|| damaged(path, "it holds no image"))?;
    let side = |pixels: usize| u32::try_from(pixels).unwrap_or(u32::MAX);
    let size = Size::new(side(first.layer_size.width()), side(first.layer_size.height()))
        .map_err(|e| unsupported(path, e.to_string()))?;
    let channel_count: usize = headers.iter().map(|header| header.channels.list.len()).sum();
    if channel_count > MAX_CHANNELS || channel_count * size.pixels() > MAX_VALUES {
        let pixels = size.pixels();
        let problem = format!(
            "{channel_count} channels of {pixels} pixels, where {MAX_CHANNELS} channels and {MAX_VALUES} values are the most"
        );
        return Err(unsupported(path, problem));
    }
    for header in headers {
        if header.layer_size != first.layer_size {
            return Err(unsupported(path, "its parts differ in size; only parts of one size are read"));
        }
        if header.channels.list.iter().any(|c| c.sampling.0 != 1 || c.sampling.1 != 1) {
            return Err(unsupported(path, "it has channels of lower resolution; only full resolution is read"));
        }
    }
    // Every chunk has an entry of 8 bytes in a table and a head of 8 bytes at least.
    let chunk_bytes: u64 = headers.iter().map(|header| 16 * header.chunk_count as u64).sum();
    // And no deflated byte becomes more than 1032.
    let densest = |header: &Header| match header.compression {
        Compression::Uncompressed => Some(1),
        Compression::RLE | Compression::ZIP1 | Compression::ZIP16 => Some(1032),
        _ => None,
    };
    let pixel_bytes: u64 = headers
        .iter()
        .filter_map(|header| Some(header.channels.bytes_per_pixel as u64 * size.pixels() as u64 / densest(header)?))
        .sum();
    if chunk_bytes + pixel_bytes > file_bytes {
        let problem =
            format!("{} bytes cannot hold the {channel_count} channels of {size} pixels it speaks of", file_bytes);
        return Err(damaged(path, problem));
    }
    Ok(size)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn film(pixels: usize) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let rgb = (0..3 * pixels).map(|i| (i as f64 * 0.37).sin() * 1e3).collect();
        let variance = (0..3 * pixels).map(|i| 1e-6 * i as f64).collect();
        (rgb, variance, vec![256.0; pixels])
    }

    fn written(width: u32, height: u32) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let (rgb, variance, samples) = film((width * height) as usize);
        let film = Film { rgb: &rgb, variance: Some(&variance), samples: Some(&samples) };
        write_exr(&path, width, height, &film, "mieux render milk, 5 µm €").unwrap();
        (folder, path)
    }

    #[test]
    fn a_film_reads_back_to_the_bit() {
        let (_folder, path) = written(33, 21);
        let image = read_exr(&path).unwrap();
        let (rgb, variance, _) = film(33 * 21);
        assert_eq!(image.size, Size::new(33, 21).unwrap());
        assert_eq!(image.rgb("").unwrap(), rgb.iter().map(|&v| v as f32).collect::<Vec<_>>());
        assert_eq!(image.rgb("variance.").unwrap(), variance.iter().map(|&v| v as f32).collect::<Vec<_>>());
        assert!(image.channels["samples"].iter().all(|&v| v == 256.0));
        assert_eq!(image.channels.len(), 7);
        assert_eq!(image.software.as_deref(), Some(SOFTWARE));
        assert_eq!(image.comment.as_deref(), Some("mieux render milk, 5 um ?"));
    }

    #[test]
    fn the_picture_alone_will_do_and_odd_floats_survive() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let rgb = [f32::MAX, f32::MIN_POSITIVE, -0.0, f32::INFINITY, f32::NAN, 1e-45];
        write_exr(&path, 1, 2, &Film { rgb: &rgb, variance: None, samples: None }, "").unwrap();
        let image = read_exr(&path).unwrap();
        let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&image.rgb("").unwrap()), bits(&rgb));
        assert_eq!((image.comment.as_deref(), image.rgb("variance.")), (None, None));
    }

    #[test]
    fn spectra_are_named_as_the_layout_asks() {
        assert_eq!(spectral_channel(512.5e-9), "S0.512,500000nm");
        let folder = tempfile::tempdir().unwrap();
        let files = ["a.exr", "b.exr"].map(|name| {
            let path = folder.path().join(name);
            let channels = BTreeMap::from([(spectral_channel(400e-9), vec![1.0, 2.0]), ("R".into(), vec![0.5; 2])]);
            write_exr_spectral(&path, 2, 1, channels, "", Some("W.m^-2.sr^-1.nm^-1")).unwrap();
            assert_eq!(read_exr(&path).unwrap().channels["S0.400,000000nm"], [1.0, 2.0]);
            std::fs::read(path).unwrap()
        });
        let holds = |text: &[u8]| files[0].windows(text.len()).any(|w| w == text);
        assert!(holds(b"spectralLayoutVersion\0") && holds(b"emissiveUnits\0") && holds(b"W.m^-2.sr^-1.nm^-1"));
        assert_eq!(files[0], files[1]);
    }

    #[test]
    fn the_same_film_is_the_same_file() {
        let ((_a, a), (_b, b)) = (written(100, 77), written(100, 77));
        assert_eq!(std::fs::read(a).unwrap(), std::fs::read(b).unwrap());
    }

    #[test]
    fn what_is_no_film_is_refused_and_nothing_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let rgb = [0.0; 12];
        let short = Film { rgb: &rgb[..11], variance: None, samples: None };
        assert!(matches!(write_exr(&path, 2, 2, &short, ""), Err(ImageError::Length { .. })));
        let short = Film { rgb: &rgb, variance: Some(&rgb[..3]), samples: None };
        assert!(matches!(write_exr(&path, 2, 2, &short, ""), Err(ImageError::Length { .. })));
        assert!(matches!(write_exr(&path, 0, 2, &short, ""), Err(ImageError::Size(_))));
        let named = |name: &str| BTreeMap::from([(name.to_owned(), vec![0.0; 4])]);
        for channels in [BTreeMap::new(), named(""), named("é"), named("a\0b"), named(&"x".repeat(256))] {
            assert!(matches!(write_exr_channels(&path, 2, 2, channels, ""), Err(ImageError::Channels { .. })));
        }
        assert!(write_exr_channels(&path, 2, 2, named(&"x".repeat(255)), "").is_ok());
        assert!(matches!(read_exr(folder.path()), Err(ImageError::Unsupported { .. })));
        assert!(matches!(read_exr(&folder.path().join("none.exr")), Err(ImageError::Read { .. })));
    }

    #[test]
    fn a_file_cut_short_anywhere_is_damaged() {
        let (_folder, path) = written(5, 40);
        let bytes = std::fs::read(&path).unwrap();
        for length in (0..bytes.len()).step_by(7).chain([bytes.len() - 1]) {
            let cut = decode(Cursor::new(&bytes[..length]), length as u64, &path);
            assert!(matches!(cut, Err(ImageError::Damaged { .. })), "{length} of {}: {cut:?}", bytes.len());
        }
    }

    #[test]
    fn a_changed_byte_never_panics() {
        let (_folder, path) = written(3, 17);
        let bytes = std::fs::read(&path).unwrap();
        for at in 0..bytes.len() {
            for value in [0, 0x80, 0xff] {
                let mut changed = bytes.clone();
                changed[at] = value;
                // Either an image or an error will do.
                let _ = decode(Cursor::new(&changed), changed.len() as u64, &path);
            }
        }
    }

    #[test]
    fn a_boast_is_not_believed() {
        let (_folder, path) = written(5, 40);
        let mut bytes = std::fs::read(&path).unwrap();
        let after = |name: &[u8]| bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len() + 4;
        let (window, chunks) = (after(b"dataWindow\0box2i\0"), after(b"chunkCount\0int\0"));
        for (last, damaged) in [(9_999_i32, true), (99_999, false)] {
            // The lower right corner, and blocks of 16 lines to go with it.
            for (at, value) in [(window + 8, last), (window + 12, last), (chunks, (last + 1) / 16)] {
                bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
            }
            let error = decode(Cursor::new(&bytes), bytes.len() as u64, &path).unwrap_err();
            assert_eq!(matches!(error, ImageError::Damaged { .. }), damaged, "{error:?}");
        }
    }
}
