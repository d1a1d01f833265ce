//! Pictures of radiance from all directions: OpenEXR, and Radiance's own `.hdr`.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::{ImageError, read_exr};

/// Larger files are not read, bytes.
const MAX_BYTES: u64 = 2 << 30;
/// Largest picture in pixels: 16384 by 8192.
const MAX_PIXELS: u64 = 1 << 27;

/// Reads linear red, green and blue, rows from the top, by what the name ends in; with width and height.
///
/// # Errors
/// [`ImageError`]; also where a value is negative or not finite.
pub fn read_radiance(path: &Path) -> Result<([u32; 2], Vec<[f32; 3]>), ImageError> {
    let error = |problem: String| ImageError::Radiance { path: path.into(), problem };
    let (size, rgb) = match path.extension().map(|e| e.to_string_lossy().to_lowercase()).as_deref() {
        Some("exr") => {
            let image = read_exr(path)?;
            let values = image.rgb("").ok_or_else(|| error("it has no channels R, G and B".into()))?;
            let size = [image.size.width(), image.size.height()];
            (size, values.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect())
        }
        Some("hdr" | "pic" | "rgbe") => {
            let io = |source| ImageError::Read { path: path.into(), source };
            let mut bytes = Vec::new();
            File::open(path).map_err(io)?.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(io)?;
            if bytes.len() as u64 > MAX_BYTES {
                return Err(error("it is larger than 2 GiB".into()));
            }
            decode(&bytes).map_err(error)?
        }
        _ => return Err(error("its name ends in neither .exr nor .hdr".into())),
    };
    if let Some(at) = rgb.iter().position(|p: &[f32; 3]| p.iter().any(|c| !(c.is_finite() && *c >= 0.0))) {
        let (x, y) = (at % size[0] as usize, at / size[0] as usize);
        return Err(error(format!("in column {x}, row {y} (from 0) is {:?}, which is no radiance", rgb[at])));
    }
    Ok((size, rgb))
}

/// Greg Ward's format: a head in lines, then rows of pixels with a common exponent, packed channel by channel.
fn decode(bytes: &[u8]) -> Result<([u32; 2], Vec<[f32; 3]>), String> {
    let mut rest = bytes;
    let mut line = || -> Result<String, String> {
        let end = rest.iter().take(4096).position(|&b| b == b'\n').ok_or("its head does not end")?;
        let line = String::from_utf8_lossy(&rest[..end]).trim().to_owned();
        rest = &rest[end + 1..];
        Ok(line)
    };
    if !line()?.starts_with("#?") {
        return Err("it does not start with `#?RADIANCE`".into());
    }
    loop {
        let said = line()?;
        if said.is_empty() {
            break;
        }
        if let Some(format) = said.strip_prefix("FORMAT=")
            && format.trim() != "32-bit_rle_rgbe"
        {
            return Err(format!("its format is `{format}`, and only 32-bit_rle_rgbe is supported"));
        }
    }
    let said = line()?;
    let parts: Vec<&str> = said.split_whitespace().collect();
    let (height, width) = match parts.as_slice() {
        ["-Y", height, "+X", width] => (height.parse::<u32>(), width.parse::<u32>()),
        _ => return Err(format!("its rows run as `{said}`, and only `-Y height +X width` is supported")),
    };
    let (Ok(height), Ok(width)) = (height, width) else {
        return Err(format!("its size is `{said}`"));
    };
    let pixels = u64::from(width) * u64::from(height);
    // Four runs of at most 127 pixels take two bytes each.
    if pixels == 0 || pixels > MAX_PIXELS || pixels > 64 * rest.len() as u64 {
        return Err(format!("its size {width}x{height} does not go with the {} bytes of its pixels", rest.len()));
    }
    let mut out = Vec::new();
    let mut row = vec![[0_u8; 4]; width as usize];
    for y in 0..height {
        rest = scanline(rest, &mut row).ok_or_else(|| format!("it breaks off or is damaged in row {y} (from 0)"))?;
        out.extend(row.iter().map(|&[r, g, b, e]| {
            let scale = if e == 0 { 0.0 } else { (f32::from(e) - 136.0).exp2() };
            [r, g, b].map(|m| f32::from(m) * scale)
        }));
    }
    Ok(([width, height], out))
}

/// Fills a row and returns what follows it.
fn scanline<'a>(mut rest: &'a [u8], row: &mut [[u8; 4]]) -> Option<&'a [u8]> {
    let mut take = |n: usize| -> Option<&'a [u8]> {
        let (piece, after) = rest.split_at_checked(n)?;
        rest = after;
        Some(piece)
    };
    let width = row.len();
    let head: [u8; 4] = take(4)?.try_into().ok()?;
    let packed = (8..32_768).contains(&width) && head[0] == 2 && head[1] == 2 && head[2] < 128;
    if packed {
        if usize::from(head[2]) << 8 | usize::from(head[3]) != width {
            return None;
        }
        for channel in 0..4 {
            let mut x = 0;
            while x < width {
                let count = take(1)?[0];
                if count > 128 {
                    let value = take(1)?[0];
                    let run = row.get_mut(x..x + usize::from(count - 128))?;
                    run.iter_mut().for_each(|p| p[channel] = value);
                    x += run.len();
                } else if count > 0 {
                    let values = take(usize::from(count))?;
                    let run = row.get_mut(x..x + values.len())?;
                    run.iter_mut().zip(values).for_each(|(p, &v)| p[channel] = v);
                    x += run.len();
                } else {
                    return None;
                }
            }
        }
        return Some(rest);
    }
    // Rows that are not packed, or as of old with runs marked by (1, 1, 1, count).
    let (mut x, mut shift, mut pixel) = (0_usize, 0, head);
    loop {
        if pixel[..3] == [1, 1, 1] {
            let last = *row.get(x.checked_sub(1)?)?;
            let count = usize::from(pixel[3]).checked_shl(shift).filter(|_| shift < 24)?;
            row.get_mut(x..x + count)?.fill(last);
            x += count;
            shift += 8;
        } else {
            *row.get_mut(x)? = pixel;
            x += 1;
            shift = 0;
        }
        if x >= width {
            return Some(rest);
        }
        pixel = take_four(&mut rest)?;
    }
}

fn take_four(rest: &mut &[u8]) -> Option<[u8; 4]> {
    let (piece, after) = rest.split_first_chunk::<4>()?;
    *rest = after;
    Some(*piece)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// 9 columns and 2 rows: the first packed, the second not.
    fn picture() -> Vec<u8> {
        let mut bytes = b"#?RADIANCE\n# made here\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1\n\n-Y 2 +X 9\n".to_vec();
        bytes.extend([2, 2, 0, 9]);
        bytes.extend([128 + 9, 128, 9, 1, 2, 3, 4, 5, 6, 7, 8, 9, 128 + 4, 64, 128 + 5, 32, 128 + 9, 129]);
        for x in 0..9 {
            bytes.extend([x, 128, 255, 128]);
        }
        bytes
    }

    #[test]
    fn both_kinds_of_rows_are_read() {
        let (size, rgb) = decode(&picture()).unwrap();
        assert_eq!(size, [9, 2]);
        assert_eq!(rgb[0], [1.0, 1.0 / 128.0, 0.5]);
        assert_eq!(rgb[8], [1.0, 9.0 / 128.0, 0.25]);
        assert_eq!(rgb[9 + 3], [3.0 / 256.0, 0.5, 255.0 / 256.0]);
    }

    #[test]
    fn old_runs_repeat_the_last_pixel() {
        let mut bytes = b"#?RGBE\n\n-Y 1 +X 4\n".to_vec();
        bytes.extend([128, 0, 0, 128, 1, 1, 1, 3]);
        assert_eq!(decode(&bytes).unwrap().1, [[0.5, 0.0, 0.0]; 4]);
    }

    #[test]
    fn what_is_wrong_is_said() {
        let huge = String::from_utf8_lossy(b"#?RADIANCE\n\n-Y 60000 +X 60000\n").into_owned();
        assert!(decode(huge.as_bytes()).unwrap_err().contains("60000x60000"));
        let whole = picture();
        assert!(decode(&whole[..whole.len() - 1]).unwrap_err().contains("row 1"));
        assert!(decode(b"P6\n").unwrap_err().contains("#?RADIANCE"));
        assert!(read_radiance(Path::new("a.jpg")).unwrap_err().to_string().contains(".exr nor .hdr"));
    }

    proptest! {
        #[test]
        fn damaged_files_end_in_an_answer(at in 0.0..1.0_f64, byte: u8, kind in 0..3_u8, more in 0.0..1.0_f64) {
            let mut bytes = picture();
            crate::testing::damage(&mut bytes, at, byte, kind, more);
            if let Ok((size, rgb)) = decode(&bytes) {
                prop_assert_eq!(rgb.len(), (size[0] * size[1]) as usize);
            }
        }
    }
}
