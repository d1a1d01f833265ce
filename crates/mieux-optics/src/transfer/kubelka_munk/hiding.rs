//! How much paint hides what is below it.

use super::{Film, KubelkaMunkError, share};

/// A chart half black, half white, on which hiding is judged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chart {
    /// Reflectance of the black half.
    pub black: f64,
    /// Reflectance of the white half, more than that of the black one.
    pub white: f64,
}

impl Default for Chart {
    /// Perfectly black, and the white of usual charts, 0.8.
    fn default() -> Self {
        Self { black: 0.0, white: 0.8 }
    }
}

impl Chart {
    /// The contrast ratio at which hiding counts as complete.
    pub const COMPLETE: f64 = 0.98;

    /// Reflectance over black divided by that over white, in [0, 1]: 1 when nothing of the chart is seen. For a film that
    /// lets no light back at all it is that of a film ever so little thinner.
    ///
    /// # Errors
    /// [`KubelkaMunkError::Share`] unless `0 <= black < white <= 1`.
    pub fn contrast_ratio(&self, film: &Film) -> Result<f64, KubelkaMunkError> {
        self.check()?;
        let (dark, light) = (film.reflectance_over(self.black)?, film.reflectance_over(self.white)?);
        Ok(if light > 0.0 { dark / light } else { self.black / self.white })
    }

    /// The thickness (m) at which a film of these coefficients hides to this contrast ratio, in (0, 1).
    ///
    /// # Errors
    /// [`KubelkaMunkError::NeverHides`], or [`KubelkaMunkError::Share`].
    pub fn thickness(&self, film: &Film, wanted: f64) -> Result<f64, KubelkaMunkError> {
        self.check()?;
        // Lengths in which something happens, so that the search knows where to begin.
        let scale = film.s() + film.k();
        if scale == 0.0 {
            return Err(KubelkaMunkError::NeverHides { wanted, reached: self.black / self.white });
        }
        thickness_for(wanted, 1.0 / scale, |thickness| self.contrast_ratio(&film.with_thickness(thickness)?))
    }

    fn check(&self) -> Result<(), KubelkaMunkError> {
        let white = share("reflectance of the white half", self.white)?;
        let value = share("reflectance of the black half", self.black)?;
        if value < white {
            return Ok(());
        }
        Err(KubelkaMunkError::Share { quantity: "reflectance of the black half (less than that of the white)", value })
    }
}

/// The thickness (m) at which a contrast ratio that grows with it reaches `wanted`, in (0, 1); to 1e-12 of itself. `start` (m)
/// is where the search begins. The ratio may be one of luminances.
///
/// # Errors
/// [`KubelkaMunkError::NeverHides`] when 1e12 times the start is not enough, [`KubelkaMunkError::Share`] for a ratio
/// that is none; those of `contrast_ratio`.
pub fn thickness_for(
    wanted: f64,
    start: f64,
    contrast_ratio: impl Fn(f64) -> Result<f64, KubelkaMunkError>,
) -> Result<f64, KubelkaMunkError> {
    if !(wanted > 0.0 && wanted < 1.0) {
        return Err(KubelkaMunkError::Share { quantity: "contrast ratio (0 and 1 excluded)", value: wanted });
    }
    if contrast_ratio(0.0)? >= wanted {
        return Ok(0.0);
    }
    let (mut low, mut high) = (0.0, start);
    let mut reached = contrast_ratio(high)?;
    while reached < wanted {
        if high > 1e12 * start {
            return Err(KubelkaMunkError::NeverHides { wanted, reached });
        }
        (low, high) = (high, 2.0 * high);
        reached = contrast_ratio(high)?;
    }
    while high - low > 1e-12 * high {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if contrast_ratio(middle)? < wanted { low = middle } else { high = middle }
    }
    Ok(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_thickness_that_is_found_hides_as_wanted() {
        let chart = Chart::default();
        for (k, s) in [(0.0, 1e5), (100.0, 1e5), (1e4, 1e4), (1e5, 1.0)] {
            let film = Film::new(k, s, 0.0).unwrap();
            let thickness = chart.thickness(&film, Chart::COMPLETE).unwrap();
            let reached = chart.contrast_ratio(&film.with_thickness(thickness).unwrap()).unwrap();
            assert!((reached - 0.98).abs() < 1e-10, "{k} {s}: {reached} at {thickness}");
        }
        // Without absorption it has a closed form: R0 = x/(1+x), over w: (x + w(1-x))/(1 + x(1-w)), and with w = 1 the ratio
        // is R0 itself, so x = 49.
        let white = Chart { black: 0.0, white: 1.0 };
        let film = Film::new(0.0, 1e5, 0.0).unwrap();
        assert!((white.thickness(&film, 0.98).unwrap() / 49e-5 - 1.0).abs() < 1e-10);
    }

    #[test]
    fn what_never_hides_says_so() {
        let chart = Chart::default();
        let dye = Film::new(1e4, 0.0, 0.0).unwrap();
        assert!(matches!(chart.thickness(&dye, 0.98), Err(KubelkaMunkError::NeverHides { .. })));
        let nothing = Film::new(0.0, 0.0, 0.0).unwrap();
        assert!(matches!(chart.thickness(&nothing, 0.98), Err(KubelkaMunkError::NeverHides { .. })));
        let film = Film::new(1.0, 1.0, 0.0).unwrap();
        assert!(chart.thickness(&film, 1.0).is_err() && chart.thickness(&film, f64::NAN).is_err());
        assert!(Chart { black: 0.8, white: 0.1 }.contrast_ratio(&film).is_err());
    }
}
