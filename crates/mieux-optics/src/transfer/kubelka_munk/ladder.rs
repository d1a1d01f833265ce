//! One pigment in white, at several concentrations.

use super::{Film, KubelkaMunkError, Saunderson, measured, share};
use crate::levenberg_marquardt::minimise;

/// One opaque mixture of a ladder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rung {
    /// Share of the pigment by volume, the rest being white; in [0, 1].
    pub concentration: f64,
    /// Measured reflectance, in (0, 1).
    pub reflectance: f64,
}

/// Opaque mixtures of a pigment and a white at one wavelength, from which K and S of the pigment follow in units of S of the
/// white, and with them how much the surface reflects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ladder<'a> {
    /// At least as many as there are unknowns, of different concentrations.
    pub rungs: &'a [Rung],
    /// The surface; its `external` (k1) is where the fit begins, or stays.
    pub surface: Saunderson,
    /// Whether `external` is fitted.
    pub fit_external: bool,
}

/// What a [`Ladder`] says, with S of the white as the unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LadderFit {
    /// K of the white.
    pub white_k: f64,
    /// K of the pigment.
    pub k: f64,
    /// S of the pigment.
    pub s: f64,
    /// External reflectance k1 of the surface.
    pub external: f64,
    /// Root mean square of what is left, in reflectance.
    pub residual: f64,
    /// Condition number of the fit: by how much an error of the readings in the worst direction is more amplified than in the
    /// best, all unknowns relative to their sizes. Above about 1000, readings of usual precision do not tell the unknowns apart.
    pub condition: f64,
    /// By how much the logarithms of `white_k`, `k`, `s` and `external` change, at worst, when a reading is off by 0.001.
    pub sensitivity: [f64; 4],
}

impl Ladder<'_> {
    /// Fits the ladder by least squares in reflectance.
    ///
    /// # Errors
    /// [`KubelkaMunkError`]: what is no reflectance or concentration, or fewer concentrations than unknowns.
    pub fn fit(&self) -> Result<LadderFit, KubelkaMunkError> {
        let unknowns = if self.fit_external { 4 } else { 3 };
        self.surface.checked()?;
        let mut concentrations: Vec<f64> = Vec::new();
        for rung in self.rungs {
            measured("reflectance", rung.reflectance)?;
            concentrations.push(share("concentration", rung.concentration)?);
        }
        concentrations.sort_by(f64::total_cmp);
        concentrations.dedup();
        if concentrations.len() < unknowns {
            return Err(KubelkaMunkError::TooFew { found: concentrations.len(), unknowns });
        }
        let count = self.rungs.len();
        let mut best = None::<([f64; 4], f64)>;
        for strength in [-3.0, 0.0, 3.0] {
            let start = [-5.0, strength, 0.0, self.logit(self.surface.external)];
            let found = minimise(start, count, |p, out| self.residuals(p, out));
            if best.is_none_or(|(_, cost)| found.cost < cost) {
                best = Some((found.at, found.cost));
            }
        }
        let Some((at, cost)) = best else { return Err(KubelkaMunkError::TooFew { found: 0, unknowns }) };
        let [white_k, k, s, external] = self.natural(&at);
        let (condition, sensitivity) = self.conditioning(&[white_k, k, s, external], unknowns);
        Ok(LadderFit { white_k, k, s, external, residual: (cost / count as f64).sqrt(), condition, sensitivity })
    }

    /// The largest k1 that leaves all readings possible.
    fn most(&self) -> f64 {
        let least = self.rungs.iter().map(|rung| rung.reflectance).fold(1.0, f64::min);
        if self.surface.specular > 0.0 { (least / self.surface.specular).min(0.5) } else { 0.5 }
    }

    fn logit(&self, external: f64) -> f64 {
        let share = (external / self.most()).clamp(1e-3, 0.999);
        (share / (1.0 - share)).ln()
    }

    fn natural(&self, p: &[f64; 4]) -> [f64; 4] {
        let external = if self.fit_external { self.most() / (1.0 + (-p[3]).exp()) } else { self.surface.external };
        [p[0].exp(), p[1].exp(), p[2].exp(), external]
    }

    fn residuals(&self, p: &[f64; 4], out: &mut [f64]) {
        let values = self.natural(p);
        for (out, rung) in out.iter_mut().zip(self.rungs) {
            *out = self.predicted(&values, rung.concentration) - rung.reflectance;
        }
    }

    fn predicted(&self, [white_k, k, s, external]: &[f64; 4], c: f64) -> f64 {
        let (k, s) = ((1.0 - c) * white_k + c * k, (1.0 - c) + c * s);
        let internal = Film::new(k, s, 0.0).map_or(f64::NAN, |film| film.reflectance_infinite());
        Saunderson { external: *external, ..self.surface }.measured(internal)
    }

    /// Of the derivatives by logarithms of the unknowns.
    fn conditioning(&self, values: &[f64; 4], unknowns: usize) -> (f64, [f64; 4]) {
        let mut normal = [[0.0; 4]; 4];
        for rung in self.rungs {
            let slopes: [f64; 4] = std::array::from_fn(|i| {
                if i >= unknowns {
                    return 0.0;
                }
                let step = 1e-5;
                let beside = |by: f64| {
                    let mut values = *values;
                    values[i] *= by;
                    self.predicted(&values, rung.concentration)
                };
                (beside(1.0 + step) - beside(1.0 - step)) / (2.0 * step)
            });
            for i in 0..4 {
                (0..4).for_each(|j| normal[i][j] += slopes[i] * slopes[j]);
            }
        }
        let (eigenvalues, vectors) = symmetric_eigen(normal);
        let used: Vec<f64> = eigenvalues.iter().map(|v| v.max(0.0)).filter(|v| *v > 0.0).collect();
        let mut sorted = eigenvalues;
        sorted.sort_by(f64::total_cmp);
        let least = sorted[4 - unknowns].max(0.0);
        let condition = if least > 0.0 && !used.is_empty() { (sorted[3] / least).sqrt() } else { f64::INFINITY };
        let sensitivity = std::array::from_fn(|i| {
            let variance: f64 = (0..4)
                .filter(|j| vectors[i][*j].abs() > 1e-12)
                .map(|j| vectors[i][j] * vectors[i][j] / eigenvalues[j].max(0.0))
                .sum();
            if i < unknowns { 1e-3 * variance.sqrt() } else { 0.0 }
        });
        (condition, sensitivity)
    }
}

/// Eigenvalues, and eigenvectors as columns, by Jacobi's rotations.
fn symmetric_eigen(mut a: [[f64; 4]; 4]) -> ([f64; 4], [[f64; 4]; 4]) {
    let mut v: [[f64; 4]; 4] = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    for _ in 0..30 {
        for p in 0..3 {
            for q in p + 1..4 {
                if a[p][q] == 0.0 {
                    continue;
                }
                let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
                let c = 1.0 / (t * t + 1.0).sqrt();
                let s = t * c;
                for row in &mut a {
                    (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
                }
                let (above, below) = a.split_at_mut(q);
                for (x, y) in above[p].iter_mut().zip(&mut below[0]) {
                    (*x, *y) = (c * *x - s * *y, s * *x + c * *y);
                }
                for row in &mut v {
                    (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
                }
            }
        }
    }
    (std::array::from_fn(|i| a[i][i]), v)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ladder(concentrations: &[f64], k: f64, s: f64, surface: Saunderson) -> Vec<Rung> {
        let reflectance = |c: f64| {
            let film = Film::new((1.0 - c) * 0.004 + c * k, (1.0 - c) + c * s, 0.0).unwrap();
            surface.measured(film.reflectance_infinite())
        };
        concentrations.iter().map(|&c| Rung { concentration: c, reflectance: reflectance(c) }).collect()
    }

    #[test]
    fn a_clean_ladder_gives_back_its_pigment_and_surface() {
        let truth = Saunderson::directional(1.5, 1.0).unwrap();
        let rungs = ladder(&[0.0, 0.02, 0.1, 0.3, 0.7, 1.0], 3.0, 0.4, truth);
        for (surface, fit_external) in [(truth, false), (Saunderson { external: 0.02, ..truth }, true)] {
            let found = Ladder { rungs: &rungs, surface, fit_external }.fit().unwrap();
            assert!((found.k / 3.0 - 1.0).abs() < 1e-3 && (found.s / 0.4 - 1.0).abs() < 1e-3, "{found:?}");
            assert!((found.white_k / 0.004 - 1.0).abs() < 1e-2 && (found.external - 0.04).abs() < 1e-4, "{found:?}");
            assert!(found.residual < 1e-6, "{found:?}");
        }
    }

    /// What the conditioning is for: high tints alone do not tell K, S and the surface apart, and it says so.
    #[test]
    fn a_short_ladder_is_reported_as_ill_conditioned() {
        let surface = Saunderson::directional(1.5, 1.0).unwrap();
        let fit = |concentrations: &[f64], fit_external| {
            let rungs = ladder(concentrations, 3.0, 0.4, surface);
            Ladder { rungs: &rungs, surface, fit_external }.fit().unwrap()
        };
        let wide = fit(&[0.0, 0.02, 0.1, 0.3, 0.7, 1.0], true);
        let short = fit(&[0.0, 0.005, 0.01, 0.02], true);
        assert!(short.condition > 20.0 * wide.condition, "{} {}", short.condition, wide.condition);
        assert!(short.sensitivity[3] > 1.0 && wide.sensitivity[3] < 0.3, "{short:?} {wide:?}");
        let given = fit(&[0.0, 0.02, 0.1, 0.3, 0.7, 1.0], false);
        assert!(given.condition <= wide.condition && given.sensitivity[3] == 0.0);
    }

    /// The sensitivities are those of the fit itself.
    #[test]
    fn a_wrong_reading_moves_the_answer_as_foretold() {
        let surface = Saunderson::directional(1.5, 1.0).unwrap();
        let mut rungs = ladder(&[0.0, 0.05, 0.3, 1.0], 3.0, 0.4, surface);
        let fit = |rungs: &[Rung]| Ladder { rungs, surface, fit_external: false }.fit().unwrap();
        let clean = fit(&rungs);
        for i in 0..rungs.len() {
            rungs[i].reflectance += 1e-3;
            let moved = fit(&rungs);
            rungs[i].reflectance -= 1e-3;
            for (by, most) in [(moved.k / clean.k, clean.sensitivity[1]), (moved.s / clean.s, clean.sensitivity[2])] {
                assert!(by.ln().abs() < 1.3 * most, "{i}: {} {most}", by.ln());
            }
        }
    }

    #[test]
    fn too_few_rungs_are_refused() {
        let surface = Saunderson::NONE;
        let rungs = ladder(&[0.0, 0.5, 1.0], 1.0, 1.0, surface);
        let found = Ladder { rungs: &rungs, surface, fit_external: true }.fit();
        assert_eq!(found, Err(KubelkaMunkError::TooFew { found: 3, unknowns: 4 }));
        let bad = [Rung { concentration: 0.5, reflectance: 42.0 }];
        assert!(matches!(
            Ladder { rungs: &bad, surface, fit_external: false }.fit(),
            Err(KubelkaMunkError::Reflectance { .. })
        ));
    }
}
