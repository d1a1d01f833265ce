//! The recipe that comes nearest to a wanted colour or spectrum.

use rayon::prelude::*;

use super::{PaintError, PaintSet, Recipe};
use crate::levenberg_marquardt::minimise;
use crate::spectrum::Lab;
use crate::spectrum::colour::Daylight;

/// What a mixture is to look like.
#[derive(Debug, Clone, PartialEq)]
pub enum Target {
    /// This colour under D65: CIEDE2000 is minimised.
    Colour(Lab),
    /// This reflectance, at the wavelengths of the paints: its root mean square difference is minimised.
    Spectrum(Vec<f64>),
}

/// A recipe and how near it comes.
#[derive(Debug, Clone, PartialEq)]
pub struct Match {
    /// The recipe.
    pub recipe: Recipe,
    /// Its reflectance at the wavelengths of the paints.
    pub reflectance: Vec<f64>,
    /// Its colour.
    pub lab: Lab,
    /// CIEDE2000 from the target.
    pub ciede2000: f64,
    /// Root mean square difference from the target, where it is a spectrum.
    pub rms: Option<f64>,
}

/// Combinations that are kept of every size, to be extended by one more paint.
const KEPT: usize = 24;
/// By so much CIEDE2000, or one part in fifty of the spectral difference, a recipe of more paints must be nearer.
const WORTHWHILE: f64 = 0.02;
/// Less than this share of a paint is none.
const TRACE: f64 = 2e-5;

/// Looks for the opaque mixture of at most so many paints (1 to 6) that comes nearest; among recipes that are as near, the one of
/// fewest paints. Pairs are tried all, larger combinations by adding to the best smaller ones. Same input, same answer.
///
/// # Errors
/// [`PaintError::AtMost`], or [`PaintError::Length`] for a spectrum of other wavelengths.
pub fn find_recipe(set: &PaintSet, target: &Target, at_most: usize) -> Result<Match, PaintError> {
    if !(1..=6).contains(&at_most) {
        return Err(PaintError::AtMost { value: at_most });
    }
    let expected = set.grid().len();
    if let Target::Spectrum(values) = target
        && values.len() != expected
    {
        return Err(PaintError::Length { sample: "target".into(), found: values.len(), expected });
    }
    let search = Search { set, target, daylight: set.daylight() };
    let count = set.paints().len();
    let mut tried: Vec<Tried> = (0..count).map(|paint| search.solve(&[paint])).collect();
    let mut best = nearest(&tried).cloned().ok_or(PaintError::Nothing)?;
    for size in 2..=at_most.min(count) {
        let mut combinations: Vec<Vec<usize>> = Vec::new();
        let kept = if size == 2 { tried.len() } else { KEPT };
        for Tried { paints, .. } in tried.iter().take(kept) {
            for paint in (0..count).filter(|paint| !paints.contains(paint)) {
                let mut wider = paints.clone();
                wider.push(paint);
                wider.sort_unstable();
                combinations.push(wider);
            }
        }
        combinations.sort_unstable();
        combinations.dedup();
        tried = combinations.par_iter().map(|paints| search.solve(paints)).collect();
        tried.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        if let Some(first) = tried.first()
            && first.distance < search.worthwhile(best.distance)
        {
            best = first.clone();
        }
    }
    search.finish(&best)
}

/// A combination of paints at its best.
#[derive(Clone)]
struct Tried {
    paints: Vec<usize>,
    shares: Vec<f64>,
    distance: f64,
}

fn nearest(tried: &[Tried]) -> Option<&Tried> {
    tried.iter().min_by(|a, b| a.distance.total_cmp(&b.distance))
}

struct Search<'a> {
    set: &'a PaintSet,
    target: &'a Target,
    daylight: Daylight,
}

impl Search<'_> {
    fn worthwhile(&self, distance: f64) -> f64 {
        match self.target {
            Target::Colour(_) => distance - WORTHWHILE,
            Target::Spectrum(_) => distance * (1.0 - WORTHWHILE),
        }
    }

    fn reflectance(&self, paints: &[usize], shares: &[f64]) -> Vec<f64> {
        let surface = self.set.surface();
        let all = self.set.paints();
        (0..self.set.grid().len())
            .map(|i| {
                let (k, s) = paints.iter().zip(shares).fold((0.0, 0.0), |(k, s), (paint, share)| {
                    (k + share * all[*paint].k[i], s + share * all[*paint].s[i])
                });
                let root = (k * (k + 2.0 * s)).sqrt();
                surface.measured(if s > 0.0 { s / (k + s + root) } else { 0.0 })
            })
            .collect()
    }

    /// Residuals whose sum of squares is the square of the distance.
    fn residuals(&self, reflectance: &[f64], out: &mut [f64]) {
        match self.target {
            Target::Colour(wanted) => {
                out.copy_from_slice(&wanted.ciede2000_components(&self.daylight.lab(reflectance)));
            }
            Target::Spectrum(wanted) => {
                let scale = (wanted.len() as f64).sqrt().recip();
                out.iter_mut().zip(reflectance.iter().zip(wanted)).for_each(|(o, (a, b))| *o = scale * (a - b));
            }
        }
    }

    fn count(&self) -> usize {
        match self.target {
            Target::Colour(_) => 3,
            Target::Spectrum(wanted) => wanted.len(),
        }
    }

    fn solve(&self, paints: &[usize]) -> Tried {
        match paints.len() {
            1 => self.solve_sized::<1>(paints),
            2 => self.solve_sized::<2>(paints),
            3 => self.solve_sized::<3>(paints),
            4 => self.solve_sized::<4>(paints),
            5 => self.solve_sized::<5>(paints),
            _ => self.solve_sized::<6>(paints),
        }
    }

    /// Shares are squares over their sum, so that none is negative.
    fn solve_sized<const N: usize>(&self, paints: &[usize]) -> Tried {
        let shares = |x: &[f64; N]| {
            let sum: f64 = x.iter().map(|x| x * x).sum();
            x.map(|x| x * x / sum)
        };
        let mut best = Tried { paints: paints.to_vec(), shares: vec![1.0; N], distance: f64::INFINITY };
        // In equal parts, and mostly one of them: of strong colours a trace can be what is wanted.
        let leaders = if N == 1 { 0 } else { N };
        for leader in 0..=leaders {
            let start: [f64; N] = std::array::from_fn(|i| if leader == N || leader == i { 1.0 } else { 0.2 });
            let found =
                minimise(start, self.count(), |x, out| self.residuals(&self.reflectance(paints, &shares(x)), out));
            let distance = found.cost.sqrt();
            if distance < best.distance {
                best = Tried { shares: shares(&found.at).to_vec(), distance, ..best };
            }
        }
        best
    }

    fn finish(&self, best: &Tried) -> Result<Match, PaintError> {
        let names = self.set.paints();
        let mut parts: Vec<(String, f64)> = best
            .paints
            .iter()
            .zip(&best.shares)
            .filter(|(_, share)| **share > TRACE)
            .map(|(paint, share)| (names[*paint].name.clone(), *share))
            .collect();
        parts.sort_by(|a, b| b.1.total_cmp(&a.1));
        let recipe = Recipe::new(parts)?;
        let reflectance = self.set.reflectance(&recipe)?;
        let lab = self.daylight.lab(&reflectance);
        let (ciede2000, rms) = match self.target {
            Target::Colour(wanted) => (wanted.ciede2000(&lab), None),
            Target::Spectrum(wanted) => {
                let squares: f64 = reflectance.iter().zip(wanted).map(|(a, b)| (a - b) * (a - b)).sum();
                let rms = (squares / wanted.len() as f64).sqrt();
                (self.daylight.lab(wanted).ciede2000(&lab), Some(rms))
            }
        };
        Ok(Match { recipe, reflectance, lab, ciede2000, rms })
    }
}

#[cfg(test)]
mod tests {
    use super::super::Paint;
    use super::*;
    use crate::spectrum::WavelengthGrid;
    use crate::transfer::kubelka_munk::Saunderson;

    fn set() -> PaintSet {
        let grid = WavelengthGrid::regular(400e-9, 700e-9, 10e-9).unwrap();
        let paint = |name: &str, k: &dyn Fn(f64) -> f64, s: f64| Paint {
            name: name.into(),
            k: grid.iter().map(|w| k(w * 1e9)).collect(),
            s: vec![s; grid.len()],
            k_error: vec![],
            s_error: vec![],
        };
        let step = |w: f64, at: f64| 1.0 / (1.0 + ((w - at) / 12.0).exp());
        let paints = vec![
            paint("white", &|_| 0.002, 1.0),
            paint("black", &|_| 4.0, 0.3),
            paint("yellow", &|w| 0.01 + 2.0 * step(w, 490.0), 0.4),
            paint("red", &|w| 0.01 + 2.0 * step(w, 590.0), 0.3),
            paint("blue", &|w| 0.05 + 3.0 * step(-w, -540.0), 0.1),
        ];
        let surface = Saunderson::directional(1.5, 1.0).unwrap().with_specular(0.2);
        PaintSet::new(grid.clone(), surface, "white".into(), paints).unwrap()
    }

    #[test]
    fn what_was_mixed_is_found_again() {
        let set = set();
        let parts = [("white", 0.62), ("yellow", 0.3), ("blue", 0.08)];
        let recipe = Recipe::new(parts.map(|(name, share)| (name.into(), share))).unwrap();
        let reflectance = set.reflectance(&recipe).unwrap();
        let wanted = set.lab(&reflectance);
        let found = find_recipe(&set, &Target::Colour(wanted), 3).unwrap();
        assert!(found.ciede2000 < 0.02, "{found:?}");
        let found = find_recipe(&set, &Target::Spectrum(reflectance), 4).unwrap();
        assert!(found.rms.unwrap() < 1e-5, "{found:?}");
        for (name, share) in found.recipe.parts() {
            let expected = parts.iter().find(|part| part.0 == name).map_or(0.0, |part| part.1);
            assert!((share - expected).abs() < 1e-3, "{found:?}");
        }
    }

    #[test]
    fn shares_are_shares_and_fewer_paints_are_no_nearer() {
        let set = set();
        let wanted = Target::Colour(Lab { l: 60.0, a: -30.0, b: 10.0 });
        let mut last = f64::INFINITY;
        for at_most in 1..=5 {
            let found = find_recipe(&set, &wanted, at_most).unwrap();
            let sum: f64 = found.recipe.parts().iter().map(|part| part.1).sum();
            assert!((sum - 1.0).abs() < 1e-12 && found.recipe.parts().len() <= at_most);
            assert!(found.ciede2000 <= last + 0.02, "{at_most}: {found:?}");
            last = found.ciede2000;
        }
    }

    /// A colour no paint reaches: the nearest is still an answer, and the distance says so.
    #[test]
    fn out_of_reach_is_told_by_the_distance() {
        let found = find_recipe(&set(), &Target::Colour(Lab { l: 60.0, a: 90.0, b: -90.0 }), 4).unwrap();
        assert!(found.ciede2000 > 5.0, "{found:?}");
        assert!(matches!(find_recipe(&set(), &Target::Spectrum(vec![0.5]), 3), Err(PaintError::Length { .. })));
        for at_most in [0, 7] {
            let target = Target::Colour(Lab { l: 50.0, a: 0.0, b: 0.0 });
            assert_eq!(find_recipe(&set(), &target, at_most), Err(PaintError::AtMost { value: at_most }));
        }
    }
}
