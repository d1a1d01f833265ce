//! NRRD with its data in the same file: three axes of numbers, raw, gzip or as text.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use super::{GridError, MAX_CELLS, Scalar, cells, check, numbers};
use crate::scene::Transform;
use crate::scene::description::{Grid, GridFilter};

/// A header is not longer than this, bytes.
const MAX_HEADER: u64 = 1 << 16;

fn scalar(name: &str) -> Option<Scalar> {
    Some(match name {
        "signed char" | "int8" | "int8_t" => Scalar::I8,
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Scalar::U8,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => Scalar::I16,
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Scalar::U16,
        "int" | "signed int" | "int32" | "int32_t" => Scalar::I32,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => Scalar::U32,
        "longlong" | "long long" | "long long int" | "signed long long" | "int64" | "int64_t" => Scalar::I64,
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => Scalar::U64,
        "float" => Scalar::F32,
        "double" => Scalar::F64,
        _ => return None,
    })
}

pub(super) fn read(path: &Path) -> Result<Grid, GridError> {
    let io = |source| GridError::Read { path: path.into(), source };
    let error = |problem: String| GridError::Format { path: path.into(), problem };
    let mut file = BufReader::with_capacity(1 << 18, File::open(path).map_err(io)?);
    let fields = fields(path, &mut file)?;
    let field = |name: &str| fields.get(name).map(String::as_str);
    let needed = |name: &str| field(name).ok_or_else(|| error(format!("its header has no `{name}`")));
    for unsupported in ["data file", "datafile"] {
        if field(unsupported).is_some() {
            return Err(error("its data is in another file; join both".into()));
        }
    }
    for skipped in ["line skip", "lineskip", "byte skip", "byteskip"] {
        if field(skipped).is_some_and(|v| v != "0") {
            return Err(error(format!("`{skipped}` is not supported")));
        }
    }
    if needed("dimension")? != "3" {
        return Err(error(format!("it has {} axes, and should have 3", needed("dimension")?)));
    }
    let name = needed("type")?;
    let kind = scalar(name).ok_or_else(|| error(format!("its values are `{name}`, which is not supported")))?;
    let sizes: Option<Vec<u64>> = needed("sizes")?.split_whitespace().map(|s| s.parse().ok()).collect();
    let declared = sizes.and_then(|s| <[u64; 3]>::try_from(s.as_slice()).ok());
    let declared = declared.ok_or_else(|| error(format!("its `sizes` are `{}`", fields["sizes"])))?;
    let count = cells(path, declared)?;
    let dims = declared.map(|d| d as usize);
    let big = match field("endian") {
        Some("little") => false,
        Some("big") => true,
        None if kind.bytes() == 1 || !matches!(field("encoding"), Some("raw" | "gzip" | "gz")) => false,
        other => {
            return Err(error(format!("its `endian` should be little or big, and is {}", other.unwrap_or("none"))));
        }
    };
    let values = match needed("encoding")? {
        "raw" => numbers(path, &mut file, count, kind, big)?,
        "gzip" | "gz" => numbers(path, &mut flate2::bufread::GzDecoder::new(file), count, kind, big)?,
        "ascii" | "text" | "txt" => text(path, file, count)?,
        other => return Err(error(format!("the encoding `{other}` is not supported; raw, gzip and ascii are"))),
    };
    check(path, dims, &values)?;
    let to_world = place(&fields, dims).map_err(error)?;
    Ok(Grid { dims, values, to_world, filter: GridFilter::Trilinear })
}

/// `key: value` in every line up to an empty one.
fn fields(path: &Path, file: &mut impl BufRead) -> Result<HashMap<String, String>, GridError> {
    let error = |problem: &str| GridError::Format { path: path.into(), problem: problem.into() };
    let mut head = file.take(MAX_HEADER);
    let mut fields = HashMap::new();
    let mut first = true;
    loop {
        let mut line = Vec::new();
        let read = head.read_until(b'\n', &mut line).map_err(|source| GridError::Read { path: path.into(), source })?;
        if read == 0 {
            return Err(error("its header does not end with an empty line within 64 KiB"));
        }
        let line = String::from_utf8_lossy(&line);
        let line = line.trim();
        if first {
            if !line.starts_with("NRRD000") {
                return Err(error("it does not start with `NRRD000`"));
            }
            first = false;
        } else if line.is_empty() {
            return Ok(fields);
        } else if !line.starts_with('#')
            && !line.contains(":=")
            && let Some((key, value)) = line.split_once(':')
        {
            fields.insert(key.trim().to_lowercase(), value.trim().to_owned());
        }
    }
}

/// Numbers between spaces.
fn text(path: &Path, file: impl BufRead, count: usize) -> Result<Vec<f32>, GridError> {
    let error = |problem: String| GridError::Format { path: path.into(), problem };
    let mut values = Vec::new();
    // No number needs more than this many characters, and a line may have all of them.
    let mut rest = file.take(64 * MAX_CELLS as u64);
    let mut word = Vec::new();
    loop {
        let buffer = rest.fill_buf().map_err(|source| GridError::Read { path: path.into(), source })?;
        let ended = buffer.is_empty();
        let used = buffer.len();
        for &byte in buffer.iter().chain(ended.then_some(&b' ')) {
            if !(byte.is_ascii_whitespace() || byte == b',') {
                word.push(byte);
                if word.len() > 64 {
                    return Err(error(format!("value {} (from 0) is longer than 64 characters", values.len())));
                }
            } else if !word.is_empty() && values.len() < count {
                let said = String::from_utf8_lossy(&word);
                let wrong = |_| error(format!("value {} (from 0) is `{said}`, not a number", values.len()));
                values.push(said.parse::<f32>().map_err(wrong)?);
                word.clear();
            }
        }
        rest.consume(used);
        if values.len() == count {
            return Ok(values);
        }
        if ended {
            return Err(error(format!("it has {} values of its {count}", values.len())));
        }
    }
}

/// From the unit cube to where the header puts the cells; samples stand in the middles of cells.
fn place(fields: &HashMap<String, String>, dims: [usize; 3]) -> Result<Transform, String> {
    let unit = match fields.get("space units").or(fields.get("units")) {
        None => 1.0,
        Some(said) => match said.split_whitespace().next().unwrap_or("").trim_matches('"') {
            "m" | "" => 1.0,
            "cm" => 1e-2,
            "mm" => 1e-3,
            "um" | "µm" => 1e-6,
            "km" => 1e3,
            other => return Err(format!("lengths in `{other}` are not supported; km, m, cm, mm, um are")),
        },
    };
    let numbers = |text: &str| -> Option<Vec<f64>> {
        let parts = text.split(|c: char| c.is_whitespace() || matches!(c, '(' | ')' | ',')).filter(|p| !p.is_empty());
        parts.map(|p| p.parse().ok()).collect()
    };
    let read = |name: &str, n: usize| -> Result<Option<Vec<f64>>, String> {
        let Some(text) = fields.get(name) else { return Ok(None) };
        let found = numbers(text).filter(|v| v.len() == n && v.iter().all(|x| x.is_finite()));
        found.map(Some).ok_or_else(|| format!("its `{name}` are not {n} numbers: `{text}`"))
    };
    let axes: Vec<f64> = match (read("space directions", 9)?, read("spacings", 3)?) {
        (Some(axes), _) => axes,
        (None, Some(s)) => vec![s[0], 0.0, 0.0, 0.0, s[1], 0.0, 0.0, 0.0, s[2]],
        (None, None) => return Ok(Transform::IDENTITY),
    };
    let origin = read("space origin", 3)?;
    let mut m = Transform::IDENTITY;
    for (i, row) in m.0.iter_mut().take(3).enumerate() {
        for axis in 0..3 {
            row[axis] = unit * axes[3 * axis + i] * dims[axis] as f64;
        }
        // The origin is the middle of the first cell; without one, the box starts at the origin.
        row[3] =
            origin.as_ref().map_or(0.0, |o| unit * (o[i] - 0.5 * (0..3).map(|axis| axes[3 * axis + i]).sum::<f64>()));
    }
    if m.is_affine_and_invertible() { Ok(m) } else { Err("its axes do not span a box".into()) }
}
