//! From what a slab reflects and transmits to what it is made of (`prahl1993`, whose inverse adding-doubling this does with
//! other means).
//!
//! A sample of known index and thickness, alone or between two slides, is lit along its normal. The unscattered
//! transmittance is a matter of the optical thickness alone; total reflectance and total transmittance then give
//! absorption and scattering, and the asymmetry if the optical thickness is known. They are found by least squares in
//! absorption and reduced scattering, between bounds, from the nearest of a grid of slabs.

mod error;
mod forward;
mod search;

pub use error::{InverseError, Misfit};
use forward::{Forward, Slab};
use search::{Minimum, minimise};

/// A number and its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// Its standard error, in the same unit; infinite where the measurement says nothing.
    pub error: f64,
}

/// Shares of light that falls along the normal, each with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Measured {
    /// All that comes back, the surface's own reflection included.
    pub reflectance: Option<Estimate>,
    /// All that passes, unscattered light included.
    pub transmittance: Option<Estimate>,
    /// What passes without having been scattered.
    pub unscattered: Option<Estimate>,
}

/// What is known of a sample beforehand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Refractive index, 0.1 to 10.
    pub refractive_index: f64,
    /// Of the slides above and below; 1 where there are none.
    pub slide_index: f64,
    /// The asymmetry g that is taken for granted unless it can be found, between -1 and 1 (Henyey-Greenstein).
    pub asymmetry: f64,
    /// The optical thickness that is taken for granted unless it can be found; without one a sample of which the
    /// reflectance alone is known counts as infinitely thick.
    pub optical_thickness: Option<f64>,
    /// The fraction of the unscattered reflection that is measured with the reflectance.
    pub specular_in_reflectance: f64,
    /// The fraction of the unscattered transmission that is measured with the transmittance.
    pub unscattered_in_transmittance: f64,
}

impl Default for Sample {
    fn default() -> Self {
        Self {
            refractive_index: 1.0,
            slide_index: 1.0,
            asymmetry: 0.0,
            optical_thickness: None,
            specular_in_reflectance: 1.0,
            unscattered_in_transmittance: 1.0,
        }
    }
}

/// What a sample is made of. Coefficients are times its thickness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// Single-scattering albedo.
    pub albedo: f64,
    /// Optical thickness; infinite where the sample counts as infinitely thick, and then `scattering` and `absorption` are
    /// in units in which the reduced scattering is 1.
    pub optical_thickness: f64,
    /// Absorption coefficient times thickness.
    pub absorption: Estimate,
    /// Scattering coefficient times thickness.
    pub scattering: Estimate,
    /// `scattering (1 - g)`.
    pub reduced_scattering: Estimate,
    /// Mean cosine; without error where it was taken for granted.
    pub asymmetry: Estimate,
    /// Root of the sum of the squared differences between the shares measured and those of what was found.
    pub residual: f64,
    /// Why what was found is only the nearest, if so.
    pub misfit: Option<Misfit>,
}

/// Inverts measurements of samples of one kind.
///
/// ```
/// use mieux_optics::transfer::inverse::{Estimate, Inversion, Measured, Sample};
///
/// let exact = |value| Some(Estimate { value, error: 0.0 });
/// let measured = Measured { reflectance: exact(0.4), transmittance: exact(0.1), unscattered: exact(0.002) };
/// let found = Inversion::new(Sample::default(), 32)?.invert(&measured)?;
/// assert!((found.asymmetry.value - 0.3116).abs() < 1e-3 && found.misfit.is_none());
/// # Ok::<(), mieux_optics::transfer::inverse::InverseError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Inversion {
    forward: Forward,
    /// Slabs of the assumed asymmetry, with their reflectances and transmittances.
    grid: Vec<(Slab, [f64; 2])>,
}

/// Smaller products of absorption and thickness count as 0 as good as; above them the search goes by logarithms.
const SMALL_ABSORPTION: f64 = 1e-3;
const SMALL_SCATTERING: f64 = 1e-2;
/// The most absorption and reduced scattering that a search looks at.
const MOST: f64 = 1e4;
/// Asymmetries between which is searched.
const ASYMMETRIES: [f64; 2] = [-0.98, 0.999];
/// The reduced scattering of what counts as infinitely thick: were the sample white, 1e-5 would still pass.
const INFINITE: f64 = 1e5;
/// Residuals up to this are those of an exact solution.
const SOLVED: f64 = 1e-8;

impl Inversion {
    /// For samples of a kind, followed along a number of streams (even, 2 to 256; 32 give four digits or more).
    ///
    /// # Errors
    /// [`InverseError`] for a sample that cannot be.
    pub fn new(sample: Sample, streams: usize) -> Result<Self, InverseError> {
        if let Some(value) = sample.optical_thickness.filter(|b| !(*b > 0.0 && b.is_finite())) {
            return Err(InverseError::OpticalThickness { value });
        }
        let fractions =
            [("reflectance", sample.specular_in_reflectance), ("transmittance", sample.unscattered_in_transmittance)];
        if let Some((quantity, value)) = fractions.into_iter().find(|(_, f)| !(0.0..=1.0).contains(f)) {
            return Err(InverseError::Fraction { quantity, value });
        }
        let forward = Forward::new(sample, streams)?;
        let steps = |from: f64, to: f64, count: u32| {
            (0..count).map(move |i| from * (to / from).powf(f64::from(i) / f64::from(count - 1)))
        };
        let asymmetry = sample.asymmetry;
        let slabs: Vec<Slab> = std::iter::once(0.0)
            .chain(steps(3e-3, 30.0, 7))
            .flat_map(|absorption| {
                steps(0.03, 100.0, 9).map(move |reduced| Slab {
                    absorption,
                    scattering: reduced / (1.0 - asymmetry),
                    asymmetry,
                })
            })
            .collect();
        let values = forward.shares(&slabs)?;
        let grid = slabs.into_iter().zip(values.iter().map(|v| [v[0], v[1]])).collect();
        Ok(Self { forward, grid })
    }

    /// What the sample is made of that has these shares: from the reflectance alone its absorption over scattering, from
    /// reflectance and transmittance both coefficients, with the unscattered transmittance also the asymmetry.
    ///
    /// # Errors
    /// [`InverseError`] for shares that cannot be, or for too few. Shares that no slab has are no error: [`Found::misfit`]
    /// says why.
    pub fn invert(&self, measured: &Measured) -> Result<Found, InverseError> {
        check(measured)?;
        let thickness = measured.unscattered.filter(|u| u.value > 0.0).map(|u| self.forward.thickness(u.value));
        // A transmittance of 0 is that of everything that is thick enough.
        let transmittance = measured.transmittance.filter(|t| t.value > 0.0);
        let found = match (measured.reflectance, transmittance, thickness) {
            (Some(r), Some(t), Some(b)) => self.all(r.value, t.value, b),
            (Some(r), Some(t), None) => self.coefficients(r.value, t.value),
            (Some(r), None, b) => self.albedo(0, r.value, b.or(self.forward.sample.optical_thickness)),
            (None, Some(t), Some(b)) => self.albedo(1, t.value, Some(b)),
            (None, Some(_), None) => Err(InverseError::TooLittle { given: "the transmittance alone" }),
            (None, None, Some(_)) => Err(InverseError::TooLittle { given: "the unscattered transmittance alone" }),
            (None, None, None) => Err(InverseError::TooLittle { given: "nothing but darkness" }),
        };
        let (slab, kind, residual) = found?;
        self.report(measured, slab, kind, residual)
    }

    /// Absorption and scattering, with the asymmetry taken for granted.
    fn coefficients(&self, r: f64, t: f64) -> Result<Solution, InverseError> {
        let g = self.forward.sample.asymmetry;
        let slab = |p: [f64; 2]| Slab {
            absorption: (p[0].exp() - SMALL_ABSORPTION).max(0.0),
            scattering: (p[1].exp() - SMALL_SCATTERING).max(0.0) / (1.0 - g),
            asymmetry: g,
        };
        let start = |near: &Slab| {
            [(near.absorption + SMALL_ABSORPTION).ln(), (near.reduced_scattering() + SMALL_SCATTERING).ln()]
        };
        let bounds = [[SMALL_ABSORPTION.ln(), MOST.ln()], [SMALL_SCATTERING.ln(), MOST.ln()]];
        let minimum = self.best([r, t], bounds, start, slab)?;
        Ok((slab(minimum.at), Kind::Coefficients, minimum.residual))
    }

    /// Absorption, scattering and asymmetry, with a known optical thickness.
    fn all(&self, r: f64, t: f64, b: f64) -> Result<Solution, InverseError> {
        let slab = |p: [f64; 2]| {
            let absorption = (p[0].exp() - SMALL_ABSORPTION).clamp(0.0, b);
            Slab { absorption, scattering: b - absorption, asymmetry: 1.0 - p[1].exp() }
        };
        let start = |near: &Slab| {
            let absorption = near.absorption.min(0.99 * b);
            let one_less_g = (near.reduced_scattering() / (b - absorption)).clamp(1e-3, 1.9);
            [(absorption + SMALL_ABSORPTION).ln(), one_less_g.ln()]
        };
        let bounds = [
            [SMALL_ABSORPTION.ln(), (b + SMALL_ABSORPTION).ln()],
            [(1.0 - ASYMMETRIES[1]).ln(), (1.0 - ASYMMETRIES[0]).ln()],
        ];
        let minimum = self.best([r, t], bounds, start, slab)?;
        Ok((slab(minimum.at), Kind::All, minimum.residual))
    }

    /// The albedo from one share (0: reflectance, 1: transmittance), with known optical thickness, or none for a sample
    /// without end.
    fn albedo(&self, which: usize, share: f64, b: Option<f64>) -> Result<Solution, InverseError> {
        let g = self.forward.sample.asymmetry;
        let slab = |p: f64| match b {
            // Evenly in both small absorption and small scattering.
            Some(b) => {
                let scattering = b / (1.0 + p.exp());
                Slab { absorption: b - scattering, scattering, asymmetry: g }
            }
            None => Slab { absorption: INFINITE * p.exp(), scattering: INFINITE / (1.0 - g), asymmetry: g },
        };
        let bounds = [[-24.0, 16.0], [0.0, 0.0]];
        let mut best: Option<Minimum> = None;
        // From the nearest of a few.
        let starts: Vec<f64> = (0..16).map(|i| -22.0 + 2.4 * f64::from(i)).collect();
        let slabs: Vec<Slab> = starts.iter().map(|p| slab(*p)).collect();
        let mut near: Vec<(f64, f64)> = self
            .forward
            .shares(&slabs)?
            .iter()
            .zip(&starts)
            .map(|(found, start)| ((found[which] - share).abs(), *start))
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, start) in near.into_iter().take(2) {
            let minimum = minimise([start, 0.0], bounds, |points| {
                let slabs: Vec<Slab> = points.iter().map(|p| slab(p[0])).collect();
                let found = self.forward.shares(&slabs)?;
                Ok::<_, InverseError>(found.iter().map(|found| [found[which] - share, 0.0]).collect())
            })?;
            if best.is_none_or(|best| minimum.residual < best.residual) {
                best = Some(minimum);
            }
            if minimum.residual < SOLVED {
                break;
            }
        }
        let minimum = best.unwrap_or(Minimum { at: [0.0; 2], residual: f64::INFINITY });
        let kind = if b.is_some() { Kind::Albedo } else { Kind::Endless };
        Ok((slab(minimum.at[0]), kind, minimum.residual))
    }

    /// The best of searches that start from the nearest slabs of the grid.
    fn best(
        &self,
        [r, t]: [f64; 2],
        bounds: [[f64; 2]; 2],
        start: impl Fn(&Slab) -> [f64; 2],
        slab: impl Fn([f64; 2]) -> Slab,
    ) -> Result<Minimum, InverseError> {
        let far = |found: &[f64; 2]| (found[0] - r).powi(2) + (found[1] - t).powi(2);
        let mut near: Vec<&(Slab, [f64; 2])> = self.grid.iter().collect();
        near.sort_by(|a, b| far(&a.1).total_cmp(&far(&b.1)));
        let mut best = Minimum { at: [bounds[0][0], bounds[1][0]], residual: f64::INFINITY };
        for (from, _) in near.into_iter().take(4) {
            let minimum = minimise(start(from), bounds, |points| {
                let slabs: Vec<Slab> = points.iter().map(|p| slab(*p)).collect();
                let found = self.forward.shares(&slabs)?;
                Ok::<_, InverseError>(found.iter().map(|found| [found[0] - r, found[1] - t]).collect())
            })?;
            if minimum.residual < best.residual {
                best = minimum;
            }
            if best.residual < SOLVED {
                break;
            }
        }
        Ok(best)
    }

    fn report(&self, measured: &Measured, slab: Slab, kind: Kind, residual: f64) -> Result<Found, InverseError> {
        let covariance = self.covariance(measured, &slab, kind)?;
        let variance = |by: [f64; 3]| {
            let mut sum = 0.0;
            for i in 0..3 {
                for j in 0..3 {
                    // Infinite variances of what does not matter are no concern.
                    if by[i] != 0.0 && by[j] != 0.0 {
                        sum += by[i] * covariance[i][j] * by[j];
                    }
                }
            }
            if sum.is_finite() { sum.max(0.0).sqrt() } else { f64::INFINITY }
        };
        let unit = if kind == Kind::Endless { INFINITE } else { 1.0 };
        let of = |value: f64, by: [f64; 3]| Estimate { value: value / unit, error: variance(by) / unit };
        let Slab { absorption, scattering, asymmetry } = slab;
        let extinction = absorption + scattering;
        Ok(Found {
            albedo: if extinction > 0.0 { scattering / extinction } else { 0.0 },
            optical_thickness: if kind == Kind::Endless { f64::INFINITY } else { extinction },
            absorption: of(absorption, [1.0, 0.0, 0.0]),
            scattering: of(scattering, [0.0, 1.0, 0.0]),
            reduced_scattering: of(slab.reduced_scattering(), [0.0, 1.0 - asymmetry, -scattering]),
            asymmetry: Estimate { value: asymmetry, error: variance([0.0, 0.0, 1.0]) },
            residual,
            misfit: self.misfit(measured, residual),
        })
    }

    /// Of absorption, scattering and asymmetry, to first order in the errors of what was measured.
    fn covariance(&self, measured: &Measured, slab: &Slab, kind: Kind) -> Result<[[f64; 3]; 3], InverseError> {
        let free: &[usize] = match kind {
            Kind::All => &[0, 1, 2],
            Kind::Coefficients | Kind::Albedo => &[0, 1],
            Kind::Endless => &[0],
        };
        let errors = [measured.reflectance, measured.transmittance, measured.unscattered];
        let mut rows: Vec<(usize, f64)> = Vec::new();
        for (which, given) in errors.iter().enumerate() {
            let used = given.filter(|g| which == 0 || g.value > 0.0);
            if let (Some(given), true) = (used, rows.len() < free.len()) {
                rows.push((which, given.error));
            }
        }
        let mut covariance = [[0.0; 3]; 3];
        if rows.iter().all(|(_, error)| *error == 0.0) {
            return Ok(covariance);
        }
        let (steps, slabs) = beside(slab);
        let values = self.forward.shares(&slabs)?;
        let by = |which: usize, j: usize| (values[2 * j + 1][which] - values[2 * j][which]) / steps[j];
        // An assumed optical thickness, where nothing was measured of it, is taken for exact.
        let assumed = rows.len() < free.len();
        let n = free.len();
        let mut jacobian = [[0.0; 3]; 3];
        for (i, row) in jacobian.iter_mut().enumerate().take(n) {
            for (k, j) in free.iter().enumerate() {
                row[k] = match rows.get(i) {
                    Some((which, _)) => by(*which, *j),
                    None if assumed => 1.0,
                    None => 0.0,
                };
            }
        }
        for i in 0..rows.len() {
            let mut unit = [0.0; 3];
            unit[i] = rows[i].1;
            let change = solve(jacobian, unit, n);
            for (k, a) in free.iter().enumerate() {
                for (l, b) in free.iter().enumerate() {
                    covariance[*a][*b] += change[k] * change[l];
                }
            }
        }
        Ok(covariance)
    }

    fn misfit(&self, measured: &Measured, residual: f64) -> Option<Misfit> {
        let value = |estimate: Option<Estimate>| estimate.map(|e| e.value);
        let [r, t, u] = [measured.reflectance, measured.transmittance, measured.unscattered].map(value);
        let most = self.forward.clear_transmittance();
        if u.is_some_and(|u| u > most * (1.0 + 1e-12)) {
            return Some(Misfit::UnscatteredAboveSurfaces { most });
        }
        if residual <= SOLVED {
            return None;
        }
        let sum = r.unwrap_or(0.0) + t.unwrap_or(0.0);
        if sum > 1.0 {
            return Some(Misfit::MoreThanFallsIn { sum });
        }
        let least = self.forward.surface_reflectance() * self.forward.sample.specular_in_reflectance;
        if r.is_some_and(|r| r < least) {
            return Some(Misfit::ReflectanceBelowSurface { least });
        }
        if let (Some(t), Some(unscattered)) = (t, u)
            && t < unscattered * self.forward.sample.unscattered_in_transmittance
        {
            return Some(Misfit::TransmittanceBelowUnscattered { unscattered });
        }
        Some(Misfit::NoSuchSlab { residual })
    }
}

/// A slab, what of it was searched, and by how much it misses.
type Solution = (Slab, Kind, f64);

/// What was searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// Absorption and scattering.
    Coefficients,
    /// These and the asymmetry.
    All,
    /// The albedo at a known optical thickness.
    Albedo,
    /// The albedo of a sample without end.
    Endless,
}

fn check(measured: &Measured) -> Result<(), InverseError> {
    let named = [
        ("reflectance", measured.reflectance),
        ("transmittance", measured.transmittance),
        ("unscattered transmittance", measured.unscattered),
    ];
    for (quantity, estimate) in named {
        let Some(Estimate { value, error }) = estimate else { continue };
        if !(0.0..=1.0).contains(&value) {
            return Err(InverseError::Share { quantity, value });
        }
        if !(error >= 0.0 && error.is_finite()) {
            return Err(InverseError::StandardError { quantity, value: error });
        }
    }
    Ok(())
}

/// Pairs of slabs a little less and a little more in each number, and by how much they differ.
fn beside(slab: &Slab) -> ([f64; 3], Vec<Slab>) {
    let less = |value: f64, least: f64| (value - 1e-4 * value.abs().max(1e-3)).max(least);
    let more = |value: f64, most: f64| (value + 1e-4 * value.abs().max(1e-3)).min(most);
    let lower = [less(slab.absorption, 0.0), less(slab.scattering, 0.0), less(slab.asymmetry, -0.999)];
    let upper = [more(slab.absorption, f64::MAX), more(slab.scattering, f64::MAX), more(slab.asymmetry, 0.9995)];
    let with = |j: usize, value: f64| match j {
        0 => Slab { absorption: value, ..*slab },
        1 => Slab { scattering: value, ..*slab },
        _ => Slab { asymmetry: value, ..*slab },
    };
    let slabs = (0..3).flat_map(|j| [with(j, lower[j]), with(j, upper[j])]).collect();
    ([0, 1, 2].map(|j| upper[j] - lower[j]), slabs)
}

/// `A x = b` in the first `n` unknowns, by elimination with the largest pivots; infinite where nothing determines it.
fn solve(mut a: [[f64; 3]; 3], mut b: [f64; 3], n: usize) -> [f64; 3] {
    for k in 0..n {
        let pivot = (k..n).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs())).unwrap_or(k);
        a.swap(k, pivot);
        b.swap(k, pivot);
        if a[k][k] == 0.0 {
            return [f64::INFINITY; 3];
        }
        for i in k + 1..n {
            let factor = a[i][k] / a[k][k];
            let upper = a[k];
            a[i].iter_mut().zip(upper).skip(k).for_each(|(value, above)| *value -= factor * above);
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - known) / a[k][k];
    }
    b
}

#[cfg(test)]
mod tests;
