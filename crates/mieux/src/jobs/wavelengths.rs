//! At which wavelengths something is computed when nobody says.

use mieux_io::quantity::parse_wavelengths;
use mieux_optics::medium::Medium;
use mieux_optics::spectrum::WavelengthGrid;

use super::JobError;

/// As typed, or the usual ones ([`usual`]).
pub(super) fn chosen<'a>(
    text: Option<&String>,
    media: impl IntoIterator<Item = &'a Medium>,
) -> Result<WavelengthGrid, JobError> {
    match text {
        Some(text) => Ok(parse_wavelengths(text)?),
        None => Ok(usual(media)),
    }
}

/// The seventeen of frisvad2007 as far as all media are known there; all seventeen where fewer than two would remain, so
/// that what is missing is named.
pub(super) fn usual<'a>(media: impl IntoIterator<Item = &'a Medium>) -> WavelengthGrid {
    known(media.into_iter().filter_map(Medium::wavelength_range)).unwrap_or_else(WavelengthGrid::frisvad2007)
}

/// Those of the seventeen that lie within all ranges (m); `None` where fewer than two do.
pub(super) fn known(ranges: impl IntoIterator<Item = (f64, f64)>) -> Option<WavelengthGrid> {
    let all = WavelengthGrid::frisvad2007();
    // The ends give way as they do in a table.
    let (from, to) = ranges.into_iter().fold((0.0, f64::INFINITY), |(a, b), (from, to)| (from.max(a), to.min(b)));
    let inside = all.iter().filter(|w| *w >= from * (1.0 - 1e-12) && *w <= to * (1.0 + 1e-12)).collect::<Vec<_>>();
    if inside.len() > 1 { WavelengthGrid::new(inside).ok() } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_known_in_part_is_asked_in_part() {
        assert_eq!(known([]).unwrap(), WavelengthGrid::frisvad2007());
        assert_eq!(known([(430e-9, 1.0), (0.0, 500.0 * 1e-9)]).unwrap().as_slice().len(), 3);
        assert_eq!(known([(375e-9, 775e-9)]).unwrap().len(), 17);
        assert!(known([(800e-9, 900e-9)]).is_none() && known([(500e-9, 400e-9)]).is_none());
    }
}
