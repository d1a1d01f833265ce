//! PNG with 8 bits a channel, for screens.

use std::io::{self, Write};
use std::path::Path;

use mieux_optics::spectrum::colour::srgb_encode;

use super::{ImageError, Tone, check_length};
use crate::output::write_atomic;
use crate::quantity::Size;

/// Writes linear sRGB as a PNG of 8 bits a channel that says it is sRGB.
///
/// | | |
/// |---|---|
/// | `rgb` | red, green, blue of every pixel, rows from the top; 1 is white |
/// | `exposure` | what every value is multiplied by first; more than 0, 1 leaves the picture as it is |
///
/// What is then below 0 (outside the gamut of a screen) is shown as 0, above 1 as 1, and NaN as 0.
///
/// # Errors
/// [`ImageError::Size`], [`ImageError::Length`], [`ImageError::Exposure`] or [`ImageError::Output`].
pub fn write_png_srgb8<T: Copy + Into<f64>>(
    path: &Path,
    width: u32,
    height: u32,
    rgb: &[T],
    exposure: f64,
) -> Result<(), ImageError> {
    write_png_toned(path, width, height, rgb, exposure, Tone::Srgb)
}

/// [`write_png_srgb8`] by way of a tone curve.
///
/// # Errors
/// As [`write_png_srgb8`].
pub fn write_png_toned<T: Copy + Into<f64>>(
    path: &Path,
    width: u32,
    height: u32,
    rgb: &[T],
    exposure: f64,
    tone: Tone,
) -> Result<(), ImageError> {
    let size = Size::new(width, height)?;
    check_length("the picture", rgb.len(), size, 3)?;
    if !(exposure > 0.0 && exposure.is_finite()) {
        return Err(ImageError::Exposure { exposure });
    }
    write_atomic(path, |out| encode(out, size, rgb, exposure, tone).map_err(io::Error::from))?;
    Ok(())
}

fn encode<T: Copy + Into<f64>>(
    out: impl Write,
    size: Size,
    rgb: &[T],
    exposure: f64,
    tone: Tone,
) -> Result<(), png::EncodingError> {
    let mut encoder = png::Encoder::new(out, size.width(), size.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    encoder.add_text_chunk("Software".to_owned(), super::openexr::SOFTWARE.to_owned())?;
    let mut writer = encoder.write_header()?;
    let mut stream = writer.stream_writer()?;
    let mut row = Vec::with_capacity(3 * size.width() as usize);
    for values in rgb.chunks(3 * size.width() as usize) {
        row.clear();
        for pixel in values.chunks_exact(3) {
            row.extend(tone.apply([pixel[0].into(), pixel[1].into(), pixel[2].into()], exposure).map(byte));
        }
        stream.write_all(&row)?;
    }
    stream.finish()?;
    writer.finish()
}

/// The sRGB code of a linear value.
fn byte(linear: f64) -> u8 {
    // `as` takes NaN to 0 and stays within a byte.
    (srgb_encode(linear) * 255.0).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;
    use std::io::BufReader;

    #[test]
    fn a_png_reads_back_as_srgb() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let rgb = [0.0, 0.18, 1.0, -0.5, 2.0, f64::NAN];
        write_png_srgb8(&path, 2, 1, &rgb, 1.0).unwrap();
        let mut reader = png::Decoder::new(BufReader::new(File::open(&path).unwrap())).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!((info.width, info.height, info.color_type), (2, 1, png::ColorType::Rgb));
        assert_eq!(bytes, [0, 118, 255, 0, 255, 0]);
        assert_eq!(reader.info().srgb, Some(png::SrgbRenderingIntent::RelativeColorimetric));
        // Twice the light, from numbers of the other precision.
        write_png_srgb8(&path, 1, 1, &[0.09_f32; 3], 2.0).unwrap();
        let mut reader = png::Decoder::new(BufReader::new(File::open(&path).unwrap())).read_info().unwrap();
        reader.next_frame(&mut bytes).unwrap();
        assert_eq!(bytes[..3], [118; 3]);
    }

    #[test]
    fn what_is_no_picture_is_refused_and_nothing_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        assert!(matches!(write_png_srgb8(&path, 0, 1, &[0.0; 0], 1.0), Err(ImageError::Size(_))));
        assert!(matches!(write_png_srgb8(&path, 2, 2, &[0.0; 11], 1.0), Err(ImageError::Length { expected: 12, .. })));
        for exposure in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(write_png_srgb8(&path, 1, 1, &[0.0; 3], exposure), Err(ImageError::Exposure { .. })));
        }
        assert!(!path.exists());
    }
}
