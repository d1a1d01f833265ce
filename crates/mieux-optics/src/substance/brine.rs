//! Brine in equilibrium with ice: the colder, the saltier.

use num_complex::Complex64;

use super::error::SubstanceError;
use super::water::{quan_fry_index, salt_absorption};

/// Temperatures (degrees Celsius) at which sea ice holds brine of known salinity and index.
pub const BRINE_TEMPERATURES: (f64, f64) = (-30.0, -2.0);

/// Salinity (g/kg) of brine in equilibrium with ice at a temperature in degrees Celsius, -30 to -2: polynomials
/// (`ulaby1986`) through the data of `assur1958`.
///
/// # Errors
/// [`SubstanceError::Condition`].
pub fn brine_salinity(temperature_c: f64) -> Result<f64, SubstanceError> {
    super::within(|| "brine".into(), "temperature", "degC", temperature_c, BRINE_TEMPERATURES)?;
    let t = temperature_c;
    Ok(if t >= -8.2 {
        1.725 - 18.756 * t - 0.3964 * t * t
    } else if t >= -22.9 {
        57.041 - 9.929 * t - 0.16204 * t * t - 0.002396 * t * t * t
    } else {
        242.94 + 1.5299 * t + 0.0429 * t * t
    })
}

/// Index of such brine at a wavelength in metres: Quan and Fry's formula at this temperature and salinity, beyond what
/// it was made for; absorption in proportion to salinity, as in the sea.
///
/// The formula is right within 0.001 down to -23 degrees, where sodium chloride begins to settle and leaves salts of
/// higher refraction behind; at -30 it is some 0.005 too low (`maykut1995` measured 1.341 at -2 and 1.397 at -32
/// degrees at 589 nm).
pub(super) fn index(wavelength_m: f64, temperature_c: f64) -> Option<Complex64> {
    let salinity = brine_salinity(temperature_c).ok()?;
    let imaginary = salt_absorption(wavelength_m, salinity)?;
    Some(Complex64::new(quan_fry_index(wavelength_m, temperature_c, salinity), imaginary))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn salinity_is_what_freezing_points_say() {
        // Sea water of 35 g/kg freezes at -1.92 degrees (`fofonoff1983`); at -10 degrees 142 g/kg (`assur1958`).
        assert!((brine_salinity(-2.0).unwrap() - 36.0).abs() < 2.0);
        assert!((brine_salinity(-10.0).unwrap() - 142.0).abs() < 2.0);
        // The pieces meet.
        for joint in [-8.2, -22.9] {
            let [above, below] = [1e-9, -1e-9].map(|d| brine_salinity(joint + d).unwrap());
            assert!((above - below).abs() < 2.5, "{joint}: {above} {below}");
        }
        for t in [-31.0, -1.0, f64::NAN] {
            assert!(matches!(brine_salinity(t), Err(SubstanceError::Condition { .. })), "{t}");
        }
    }

    #[test]
    fn refraction_grows_as_brine_cools() {
        let n = |t| index(589e-9, t).unwrap().re;
        // 1.341 at -2 and 1.397 at -32 degrees (`maykut1995`): met at the warm end, 0.006 low at the cold one.
        assert!((n(-2.0) - 1.341).abs() < 5e-4, "{}", n(-2.0));
        assert!(n(-30.0) < 1.397 && n(-30.0) > 1.385, "{}", n(-30.0));
        assert!((0..28).all(|i| n(-2.0 - f64::from(i)) < n(-3.0 - f64::from(i))));
    }

    #[test]
    fn the_formula_holds_at_the_salinity_of_brine() {
        // A solution of 20 % sodium chloride at 20 degrees: 1.3684 (`crc`); sea salt refracts a little more.
        let excess = quan_fry_index(589e-9, 20.0, 200.0) - 1.3684;
        assert!((0.0..2.5e-3).contains(&excess), "{excess}");
    }

    #[test]
    fn absorption_stays_positive() {
        for t in [-2.0, -15.0, -30.0] {
            assert!((0..=16).all(|i| index((375.0 + 25.0 * f64::from(i)) * 1e-9, t).unwrap().im > 0.0), "{t}");
        }
    }
}
