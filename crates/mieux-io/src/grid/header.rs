//! Raw numbers with a header of our own beside them.

use std::fs::File;
use std::io::{BufReader, Read};
use std::ops::Range;
use std::path::{Component, Path};

use serde::Deserialize;
use toml::Spanned;

use super::{GridError, Scalar, cells, check, numbers};
use crate::quantity::Length;
use crate::scene::Transform;
use crate::scene::description::{Grid, GridFilter};
use crate::text_error::TextError;

/// A header is not longer than this, bytes.
const MAX_HEADER: u64 = 1 << 20;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    data: Spanned<String>,
    dims: Spanned<[u64; 3]>,
    #[serde(rename = "type")]
    kind: Option<Kind>,
    endian: Option<Endian>,
    compression: Option<Compression>,
    size: Option<[Spanned<String>; 3]>,
    origin: Option<[Spanned<String>; 3]>,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "lowercase")]
enum Kind {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    F32,
    F64,
}

#[derive(Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
enum Endian {
    Little,
    Big,
}

#[derive(Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
enum Compression {
    None,
    Gzip,
}

pub(super) fn read(path: &Path) -> Result<Grid, GridError> {
    let io = |source| GridError::Read { path: path.into(), source };
    let mut text = String::new();
    File::open(path).map_err(io)?.take(MAX_HEADER).read_to_string(&mut text).map_err(io)?;
    let name = path.to_string_lossy();
    let document: Document = toml::from_str(&text).map_err(|e| TextError::from_toml(&name, &text, &e))?;
    let error = |span: Range<usize>, message: String| TextError::new(&name, &text, span, message);
    let data = Path::new(document.data.get_ref());
    if !data.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir)) {
        return Err(error(document.data.span(), "the data should lie beside the header, or below it".into()).into());
    }
    let declared = *document.dims.get_ref();
    let count = cells(path, declared)?;
    let dims = declared.map(|d| d as usize);
    let kind = match document.kind.unwrap_or(Kind::F32) {
        Kind::U8 => Scalar::U8,
        Kind::I8 => Scalar::I8,
        Kind::U16 => Scalar::U16,
        Kind::I16 => Scalar::I16,
        Kind::U32 => Scalar::U32,
        Kind::I32 => Scalar::I32,
        Kind::F32 => Scalar::F32,
        Kind::F64 => Scalar::F64,
    };
    let metres = |from: Option<[Spanned<String>; 3]>, default: f64, any: bool| -> Result<[f64; 3], GridError> {
        let mut found = [default; 3];
        for (metres, said) in found.iter_mut().zip(from.into_iter().flatten()) {
            let length = length(said.get_ref(), any).map_err(|e| error(said.span(), e))?;
            *metres = length;
        }
        Ok(found)
    };
    let (size, origin) = (metres(document.size, 1.0, false)?, metres(document.origin, 0.0, true)?);
    let to_world = Transform::scale(size).then(&Transform::translate(origin));
    let file = path.parent().unwrap_or(Path::new("")).join(data);
    let opened = File::open(&file).map_err(|source| GridError::Read { path: file.clone(), source })?;
    let mut bytes = BufReader::with_capacity(1 << 18, opened);
    let big = document.endian == Some(Endian::Big);
    let values = if document.compression == Some(Compression::Gzip) {
        numbers(&file, &mut flate2::bufread::GzDecoder::new(bytes), count, kind, big)?
    } else {
        numbers(&file, &mut bytes, count, kind, big)?
    };
    check(&file, dims, &values)?;
    Ok(Grid { dims, values, to_world, filter: GridFilter::Trilinear })
}

/// A length with its unit, in metres; positive, unless `any` will do.
fn length(text: &str, any: bool) -> Result<f64, String> {
    let text = text.trim();
    if any {
        if let Some(positive) = text.strip_prefix('-') {
            return length(positive, true).map(|l| -l);
        }
        // Nothing is nothing in any unit.
        if text.trim_end_matches(char::is_alphabetic).trim().parse() == Ok(0.0) {
            return Ok(0.0);
        }
    }
    let length = if any { text.parse() } else { Length::parse_positive(text) };
    length.map(Length::metres).map_err(|e| e.to_string())
}
