//! K and S of a film from what is measured on it.
//!
//! Reflectances here are those inside the film; take the surface away first ([`Saunderson::internal`](super::Saunderson)).
//!
//! A film turns the reflectance `G` of its backing into `R` such that `w(R) = w(G) exp(-2 decay d)` with
//! `w(R) = (R - u) / (1 - u R)` and `u` its infinite reflectance, so once `u` is known, one pair `(G, R)` gives the rest.

use super::{Film, KubelkaMunkError, measured, natural, share};

const UNLIT: &str = "the reflectance does not go from that of the backing towards that of an opaque film";

/// From the reflectance over two backings of known reflectance (in [0, 1], such as black and white), each in (0, 1), at one
/// thickness (m): pairs of backing and reflectance.
///
/// # Errors
/// [`KubelkaMunkError`]: what is no reflectance, backings that are alike, readings that no film has, or an opaque film, whose
/// readings are alike and give `K/S` only.
pub fn from_two_backings(pairs: [(f64, f64); 2], thickness: f64) -> Result<Film, KubelkaMunkError> {
    let [(g1, r1), (g2, r2)] = pairs;
    for (backing, reflectance) in pairs {
        share("reflectance of the backing", backing)?;
        measured("reflectance", reflectance)?;
    }
    if g1 == g2 {
        return Err(KubelkaMunkError::NoFilm { why: "both backings are alike" });
    }
    if (r1 - r2) * (g1 - g2) <= 0.0 {
        return Err(KubelkaMunkError::NoFilm {
            why: "it is not lighter over the lighter backing; an opaque film gives K/S only",
        });
    }
    // Where nothing scatters, reflectances are those of the backings times the same factor, and a is endless.
    let across = r1 * g2 - r2 * g1;
    let a = if across.abs() > 1e-13 * r1.max(r2) {
        0.5 * ((1.0 + r1 * g1) * (g2 - r2) - (1.0 + r2 * g2) * (g1 - r1)) / across
    } else {
        f64::INFINITY
    };
    // Rounding of readings without absorption may end a little below 1.
    if a.is_nan() || a <= 1.0 - 1e-9 {
        return Err(KubelkaMunkError::NoFilm { why: "more light would come back than went in" });
    }
    let a = a.max(1.0);
    let infinite = 1.0 / (a + ((a - 1.0) * (a + 1.0)).sqrt());
    // The pair in which more happens has more digits.
    let (backing, reflectance) = if (r1 - g1).abs() > (r2 - g2).abs() { pairs[0] } else { pairs[1] };
    film(infinite, backing, reflectance, thickness)
}

/// From the reflectance of an opaque film and that of a thin one (both in (0, 1)) of some thickness (m) over a backing of known
/// reflectance, in [0, 1].
///
/// # Errors
/// [`KubelkaMunkError`]: what is no reflectance, or readings that no film has.
pub fn from_infinite_and_one(
    infinite: f64,
    backing: f64,
    reflectance: f64,
    thickness: f64,
) -> Result<Film, KubelkaMunkError> {
    measured("infinite reflectance", infinite)?;
    share("reflectance of the backing", backing)?;
    measured("reflectance", reflectance)?;
    film(infinite, backing, reflectance, thickness)
}

/// From the reflectance (in (0, 1)) at two thicknesses (m) over the same backing of known reflectance, in [0, 1]: pairs of
/// thickness and reflectance. The film has the first thickness.
///
/// # Errors
/// [`KubelkaMunkError`]: what is no reflectance, thicknesses that are alike, or readings that no film has.
pub fn from_two_thicknesses(backing: f64, pairs: [(f64, f64); 2]) -> Result<Film, KubelkaMunkError> {
    let backing = share("reflectance of the backing", backing)?;
    for (thickness, reflectance) in pairs {
        natural("thickness", thickness)?;
        measured("reflectance", reflectance)?;
    }
    let [(d1, r1), (d2, r2)] = if pairs[0].0 <= pairs[1].0 { pairs } else { [pairs[1], pairs[0]] };
    if !(d1 > 0.0 && d2 > d1) {
        return Err(KubelkaMunkError::NoFilm { why: "two different thicknesses above 0 are needed" });
    }
    let lighter = r1 > backing;
    if r1 == backing || r1 == r2 || lighter != (r2 > r1) {
        return Err(KubelkaMunkError::NoFilm { why: UNLIT });
    }
    // The thicker film, if its infinite reflectance were u: grows with u, from the reading of the thinner one.
    let predicted = |u: f64| match film(u, backing, r1, d1).and_then(|film| film.with_thickness(d2)) {
        Ok(film) => film.reflectance_over(backing),
        Err(error) => Err(error),
    };
    let (mut low, mut high) = if lighter { (r2, 1.0) } else { (0.0, r2) };
    let beyond = KubelkaMunkError::NoFilm { why: "the second reading is too far from the first for its thickness" };
    let (end, misses): (f64, fn(f64, f64) -> bool) = if lighter { (1.0, |p, r| p < r) } else { (0.0, |p, r| p > r) };
    let at_end = predicted(end)?;
    if misses(at_end, r2 + if lighter { -1e-12 } else { 1e-12 }) {
        return Err(beyond);
    }
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if predicted(middle)? < r2 { low = middle } else { high = middle }
    }
    film(0.5 * (low + high), backing, r1, d1)?.with_thickness(pairs[0].0)
}

/// The film of infinite reflectance `u` in [0, 1] that turns a backing into this reflectance.
fn film(u: f64, backing: f64, reflectance: f64, thickness: f64) -> Result<Film, KubelkaMunkError> {
    if natural("thickness", thickness)? == 0.0 {
        return Err(KubelkaMunkError::NoFilm { why: "a film of thickness 0 says nothing" });
    }
    // 1 - w(R)/w(G), over 1 - u^2, which is what is left of it where u is 1.
    let change = (backing - reflectance) / ((1.0 - u * reflectance) * (backing - u));
    let missing = (1.0 - u) * (1.0 + u);
    let faded = 1.0 - change * missing;
    if !(change > 0.0 && faded > 0.0) {
        return Err(KubelkaMunkError::NoFilm { why: UNLIT });
    }
    // Twice the decay times thickness, over 1 - u^2.
    let depth = if missing > 0.0 { -(-change * missing).ln_1p() / missing } else { change };
    Film::new(0.5 * depth * (1.0 - u) * (1.0 - u) / thickness, depth * u / thickness, thickness)
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILMS: [(f64, f64, f64); 7] = [
        (100.0, 1e4, 1e-4),
        (1e4, 1e3, 1e-4),
        (1.0, 1e5, 2e-5),
        (0.0, 1e4, 1e-4),
        (3e3, 3e3, 3e-4),
        (1e-3, 2e4, 1e-4),
        (2e4, 20.0, 5e-5),
    ];

    fn close(found: &Film, k: f64, s: f64, digits: f64) {
        let size = k + s;
        assert!((found.k() - k).abs() < digits * size && (found.s() - s).abs() < digits * size, "{found:?}: {k} {s}");
    }

    #[test]
    fn black_and_white_give_back_the_film() {
        for (k, s, d) in FILMS {
            let film = Film::new(k, s, d).unwrap();
            for (black, white) in [(0.0, 0.8), (0.04, 0.9), (0.3, 0.98)] {
                let pair = |g: f64| (g, film.reflectance_over(g).unwrap());
                close(&from_two_backings([pair(black), pair(white)], d).unwrap(), k, s, 1e-8);
                close(&from_two_backings([pair(white), pair(black)], d).unwrap(), k, s, 1e-8);
            }
        }
    }

    #[test]
    fn a_dye_over_two_greys_scatters_nothing() {
        let film = Film::new(3e3, 0.0, 1e-4).unwrap();
        let pair = |g: f64| (g, film.reflectance_over(g).unwrap());
        close(&from_two_backings([pair(0.3), pair(0.8)], 1e-4).unwrap(), 3e3, 0.0, 1e-9);
    }

    #[test]
    fn two_thicknesses_give_back_the_film() {
        for (k, s, d) in FILMS {
            for backing in [0.0, 0.2, 0.85] {
                let film = Film::new(k, s, d).unwrap();
                let pair = |d: f64| (d, film.with_thickness(d).unwrap().reflectance_over(backing).unwrap());
                if pair(d).1 == 0.0 || (pair(d).1 - film.reflectance_infinite()).abs() < 1e-3 {
                    continue;
                }
                let found = from_two_thicknesses(backing, [pair(d), pair(2.0 * d)]).unwrap();
                close(&found, k, s, 1e-6);
                close(&from_two_thicknesses(backing, [pair(2.0 * d), pair(d)]).unwrap(), k, s, 1e-6);
            }
        }
    }

    #[test]
    fn an_opaque_film_and_a_thin_one_give_it_back() {
        for (k, s, d) in FILMS.into_iter().filter(|film| film.0 > 1e-2) {
            let film = Film::new(k, s, d).unwrap();
            let found = from_infinite_and_one(film.reflectance_infinite(), 0.5, film.reflectance_over(0.5).unwrap(), d)
                .unwrap();
            close(&found, k, s, 1e-8);
        }
    }

    #[test]
    fn readings_that_cannot_be_are_refused() {
        for value in [0.0, 1.0, -0.1, 55.0, f64::NAN] {
            let error = from_two_backings([(0.0, value), (0.8, 0.85)], 1e-4).unwrap_err();
            assert!(matches!(error, KubelkaMunkError::Reflectance { .. }), "{value}: {error}");
            assert!(from_two_thicknesses(0.0, [(1e-4, value), (2e-4, 0.5)]).is_err());
            assert!(from_infinite_and_one(value, 0.0, 0.5, 1e-4).is_err());
        }
        // Darker over white, opaque, brighter than its parts allow, the wrong way, no thickness.
        for (pairs, d) in [
            ([(0.0, 0.5), (0.8, 0.4)], 1e-4),
            ([(0.0, 0.5), (0.8, 0.5)], 1e-4),
            ([(0.0, 0.6), (0.8, 0.99)], 1e-4),
            ([(0.1, 0.5), (0.1, 0.6)], 1e-4),
            ([(0.0, 0.5), (0.8, 0.6)], 0.0),
        ] {
            assert!(from_two_backings(pairs, d).is_err(), "{pairs:?}");
        }
        for pairs in [[(1e-4, 0.3), (2e-4, 0.9)], [(1e-4, 0.3), (2e-4, 0.2)], [(1e-4, 0.3), (1e-4, 0.4)]] {
            assert!(from_two_thicknesses(0.0, pairs).is_err(), "{pairs:?}");
        }
        assert!(from_infinite_and_one(0.5, 0.0, 0.6, 1e-4).is_err());
    }
}
