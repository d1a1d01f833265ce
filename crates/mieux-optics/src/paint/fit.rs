//! K and S from opaque samples of known recipes.
//!
//! The most probable logarithms of K and S, given the readings, their errors, and two weak beliefs that only speak where the
//! readings are silent: S of a paint is some third of that of the reference, within a factor of five, and both K and S change
//! gradually over wavelength. Levenberg's and Marquardt's steps (`marquardt1963`) go through all wavelengths at once, since
//! only neighbours are coupled; the inverse of the same equations says how well each number is known.

use super::chain::{Chain, Solved};
use super::{Measurements, Paint, PaintError, PaintSet};
use crate::spectrum::Lab;
use crate::transfer::kubelka_munk::Saunderson;

/// What is known of the surface before the fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Surface {
    /// All of it.
    Given(Saunderson),
    /// All but how much of the specular component the instrument counts: `specular` is fitted.
    FitSpecular(Saunderson),
}

/// How to fit.
#[derive(Debug, Clone, PartialEq)]
pub struct FitOptions {
    /// The paint whose S is the unit; the one that is mixed with most others when left out.
    pub reference: Option<String>,
    /// The surface of every sample.
    pub surface: Surface,
    /// Standard error of a reading: an absolute part, and one relative to the reading.
    pub noise: [f64; 2],
    /// Mean and standard deviation of the belief about the logarithm of S relative to the reference.
    pub scattering: [f64; 2],
    /// By how much the logarithms of K and of S change over one nanometre, at random (standard deviation, 1/sqrt(nm)).
    pub roughness: [f64; 2],
}

impl FitOptions {
    /// For readings of usual precision under this surface.
    pub fn new(surface: Surface) -> Self {
        Self { reference: None, surface, noise: [0.0005, 0.01], scattering: [-1.0, 1.6], roughness: [0.5, 0.15] }
    }
}

/// What a fit leaves of one sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Leftover {
    /// Name of the sample.
    pub name: String,
    /// Its colour as measured.
    pub measured: Lab,
    /// As the fit has it.
    pub predicted: Lab,
    /// CIEDE2000 between them.
    pub ciede2000: f64,
    /// Root mean square of the difference of reflectance.
    pub rms: f64,
}

/// What [`fit`] finds.
#[derive(Debug, Clone, PartialEq)]
pub struct PaintFit {
    /// The paints.
    pub paints: PaintSet,
    /// What is left of each sample, in their order.
    pub leftovers: Vec<Leftover>,
    /// Standard error of `specular` of the surface, given the noise; infinite when the readings do not tell it, 0 when it
    /// was given.
    pub specular_error: f64,
    /// Paints of which nothing but K/S is known: their S is what is believed of any paint.
    pub ratio_only: Vec<String>,
}

/// Fits K and S of every paint in the samples, all of which are opaque.
///
/// # Errors
/// [`PaintError::NothingToFit`], [`PaintError::Unknown`] for the reference, [`PaintError::Surface`] when the surface alone
/// reflects more than a sample, [`PaintError::Singular`].
pub fn fit(measurements: &Measurements, options: &FitOptions) -> Result<PaintFit, PaintError> {
    let mut problem = Problem::new(measurements, options)?;
    let (surface, specular_error) = match options.surface {
        Surface::Given(surface) => (surface.checked()?, 0.0),
        Surface::FitSpecular(surface) => problem.find_specular(surface.checked()?)?,
    };
    problem.minimise(&surface, 60)?;
    let solved = problem.equations(&surface, 0.0).solve().ok_or(problem.singular())?;
    let paints = problem.paints(&solved);
    let ratio_only = problem.ratio_only();
    let set = PaintSet::new(measurements.grid().clone(), surface, problem.names[problem.reference].clone(), paints)?;
    let leftovers = leftovers(&set, measurements)?;
    Ok(PaintFit { paints: set, leftovers, specular_error, ratio_only })
}

impl PaintFit {
    /// What is left of samples that were not fitted, of the same paints and wavelengths.
    ///
    /// # Errors
    /// [`PaintError::Unknown`] for a paint that was not fitted, [`PaintError::Length`].
    pub fn predict(&self, others: &Measurements) -> Result<Vec<Leftover>, PaintError> {
        leftovers(&self.paints, others)
    }
}

fn leftovers(set: &PaintSet, measurements: &Measurements) -> Result<Vec<Leftover>, PaintError> {
    let daylight = set.daylight();
    let of = |sample: &super::Sample| {
        let predicted = set.reflectance(&sample.recipe)?;
        let (found, expected) = (sample.reflectance.len(), predicted.len());
        if found != expected {
            return Err(PaintError::Length { sample: sample.name.clone(), found, expected });
        }
        let squares: f64 = predicted.iter().zip(&sample.reflectance).map(|(a, b)| (a - b) * (a - b)).sum();
        let (measured, lab) = (daylight.lab(&sample.reflectance), daylight.lab(&predicted));
        Ok(Leftover {
            name: sample.name.clone(),
            measured,
            predicted: lab,
            ciede2000: measured.ciede2000(&lab),
            rms: (squares / expected as f64).sqrt(),
        })
    };
    measurements.samples().iter().map(of).collect()
}

/// The unknowns of a wavelength are the logarithms of K of every paint, then of S of every paint but the reference.
struct Problem<'a> {
    measurements: &'a Measurements,
    options: &'a FitOptions,
    names: Vec<String>,
    reference: usize,
    /// Places and shares of the paints of each sample.
    recipes: Vec<Vec<(usize, f64)>>,
    at: Vec<Vec<f64>>,
}

/// A model value and its derivatives by the unknowns of a sample's paints, in pairs (place, derivative).
struct Predicted {
    value: f64,
    slopes: Vec<(usize, f64)>,
}

impl<'a> Problem<'a> {
    fn new(measurements: &'a Measurements, options: &'a FitOptions) -> Result<Self, PaintError> {
        let names: Vec<String> = measurements.paints().into_iter().map(str::to_owned).collect();
        if names.is_empty() {
            return Err(PaintError::NothingToFit { why: "there are no samples" });
        }
        let place = |name: &str| names.iter().position(|other| other == name);
        let mut recipes = Vec::new();
        let mut partners = vec![Vec::new(); names.len()];
        for sample in measurements.samples() {
            let recipe: Vec<(usize, f64)> =
                sample.recipe.parts().iter().filter_map(|(name, share)| Some((place(name)?, *share))).collect();
            for (paint, _) in &recipe {
                for (other, _) in &recipe {
                    if other != paint && !partners[*paint].contains(other) {
                        partners[*paint].push(*other);
                    }
                }
            }
            recipes.push(recipe);
        }
        let reference = match &options.reference {
            Some(name) => place(name).ok_or_else(|| PaintError::Unknown { paint: name.clone() })?,
            None => (0..names.len()).max_by_key(|i| (partners[*i].len(), names.len() - i)).unwrap_or(0),
        };
        Ok(Self { measurements, options, names, reference, recipes, at: Vec::new() })
    }

    fn unknowns(&self) -> usize {
        2 * self.names.len() - 1
    }

    fn singular(&self) -> PaintError {
        PaintError::Singular { unknowns: self.unknowns() }
    }

    /// The place of S of a paint among the unknowns.
    fn s_place(&self, paint: usize) -> Option<usize> {
        let n = self.names.len();
        match paint.cmp(&self.reference) {
            std::cmp::Ordering::Less => Some(n + paint),
            std::cmp::Ordering::Equal => None,
            std::cmp::Ordering::Greater => Some(n + paint - 1),
        }
    }

    /// K of each paint from its pure sample with the believed S, where there is one.
    fn start(&mut self, surface: &Saunderson) -> Result<(), PaintError> {
        let unknowns = self.unknowns();
        let believed = self.options.scattering[0];
        let mut at = vec![vec![believed; unknowns]; self.measurements.grid().len()];
        for (sample, recipe) in self.measurements.samples().iter().zip(&self.recipes) {
            let wavelengths = self.measurements.grid().iter();
            for (at, (wavelength, &reading)) in at.iter_mut().zip(wavelengths.zip(&sample.reflectance)) {
                let internal = surface.internal(reading).map_err(|source| {
                    let wavelength_nm = crate::spectrum::nanometres(wavelength);
                    PaintError::Surface { sample: sample.name.clone(), wavelength_nm, source }
                })?;
                let ratio = (1.0 - internal) * (1.0 - internal) / (2.0 * internal);
                if let [(paint, _)] = recipe[..] {
                    at[paint] = ratio.ln() + if paint == self.reference { 0.0 } else { believed };
                }
            }
        }
        self.at = at;
        Ok(())
    }

    fn predicted(&self, at: &[f64], recipe: &[(usize, f64)], surface: &Saunderson) -> Predicted {
        let (mut k_sum, mut s_sum) = (0.0, 0.0);
        let mut slopes = Vec::with_capacity(2 * recipe.len());
        for &(paint, share) in recipe {
            let k = share * at[paint].exp();
            let s = share * self.s_place(paint).map_or(1.0, |place| at[place].exp());
            k_sum += k;
            s_sum += s;
            slopes.push((paint, k));
            slopes.extend(self.s_place(paint).map(|place| (place, -s)));
        }
        let q = k_sum / s_sum;
        let root = (q * (q + 2.0)).sqrt();
        let internal = 1.0 / (1.0 + q + root);
        // By the logarithm of q: -R q / sqrt(q (q + 2)).
        let by_log_ratio = -surface.slope(internal) * internal * q / root;
        for (place, slope) in &mut slopes {
            *slope *= by_log_ratio / if *place < self.names.len() { k_sum } else { s_sum };
        }
        Predicted { value: surface.measured(internal), slopes }
    }

    fn noise(&self, reading: f64) -> f64 {
        self.options.noise[0] + self.options.noise[1] * reading
    }

    /// Precisions of the changes between neighbours, for K and for S.
    fn stiffness(&self, link: usize) -> [f64; 2] {
        let grid = self.measurements.grid().as_slice();
        let nanometres = (grid[link + 1] - grid[link]) * 1e9;
        self.options.roughness.map(|roughness| 1.0 / (roughness * roughness * nanometres))
    }

    /// Half the sum of squares: minus the logarithm of the probability.
    fn cost(&self, at: &[Vec<f64>], surface: &Saunderson) -> f64 {
        let n = self.names.len();
        let mut sum = 0.0;
        for (sample, recipe) in self.measurements.samples().iter().zip(&self.recipes) {
            for (at, &reading) in at.iter().zip(&sample.reflectance) {
                let off = (self.predicted(at, recipe, surface).value - reading) / self.noise(reading);
                sum += off * off;
            }
        }
        let [believed, spread] = self.options.scattering;
        for (link, here) in at.iter().enumerate() {
            // A belief is one for the whole spectrum, not one more for each wavelength that was measured.
            let weight = 1.0 / (spread * spread * at.len() as f64);
            sum += here[n..].iter().map(|v| weight * (v - believed) * (v - believed)).sum::<f64>();
            if let Some(next) = at.get(link + 1) {
                let stiff = self.stiffness(link);
                let changes = here.iter().zip(next).enumerate();
                sum += changes.map(|(i, (a, b))| stiff[usize::from(i >= n)] * (b - a) * (b - a)).sum::<f64>();
            }
        }
        0.5 * sum
    }

    /// The equations of a step from where the fit is; `damping` of 0 for those whose inverse is the covariance.
    fn equations(&self, surface: &Saunderson, damping: f64) -> Chain {
        let (n, unknowns, links) = (self.names.len(), self.unknowns(), self.at.len());
        let mut chain = Chain::new(unknowns, links);
        for (sample, recipe) in self.measurements.samples().iter().zip(&self.recipes) {
            for (link, &reading) in sample.reflectance.iter().enumerate() {
                let found = self.predicted(&self.at[link], recipe, surface);
                let precision = self.noise(reading).powi(-2);
                for &(i, slope) in &found.slopes {
                    chain.right[link][i] -= precision * slope * (found.value - reading);
                    for &(j, other) in &found.slopes {
                        chain.blocks[link][i * unknowns + j] += precision * slope * other;
                    }
                }
            }
        }
        let [believed, spread] = self.options.scattering;
        let weight = 1.0 / (spread * spread * links as f64);
        for link in 0..links {
            for i in n..unknowns {
                chain.blocks[link][i * unknowns + i] += weight;
                chain.right[link][i] -= weight * (self.at[link][i] - believed);
            }
            if link + 1 < links {
                let stiff = self.stiffness(link);
                for i in 0..unknowns {
                    let stiff = stiff[usize::from(i >= n)];
                    let pull = stiff * (self.at[link + 1][i] - self.at[link][i]);
                    chain.blocks[link][i * unknowns + i] += stiff;
                    chain.blocks[link + 1][i * unknowns + i] += stiff;
                    chain.couplings[link][i] = -stiff;
                    chain.right[link][i] += pull;
                    chain.right[link + 1][i] -= pull;
                }
            }
            // K of a paint that is always in others' shadow is known from nothing else.
            for i in 0..unknowns {
                chain.blocks[link][i * unknowns + i] *= 1.0 + damping;
                chain.blocks[link][i * unknowns + i] += 1e-9;
            }
        }
        chain
    }

    /// Goes to the minimum from where the fit is; the cost there.
    fn minimise(&mut self, surface: &Saunderson, steps: usize) -> Result<f64, PaintError> {
        if self.at.is_empty() {
            self.start(surface)?;
        }
        let mut cost = self.cost(&self.at, surface);
        let mut damping = 1e-3;
        for _ in 0..steps {
            let before = cost;
            while damping < 1e9 {
                let step = self.equations(surface, damping).solve().ok_or_else(|| self.singular())?;
                let moved: Vec<Vec<f64>> = self
                    .at
                    .iter()
                    .zip(&step.at)
                    .map(|(at, step)| at.iter().zip(step).map(|(a, s)| a + s.clamp(-2.0, 2.0)).collect())
                    .collect();
                let reached = self.cost(&moved, surface);
                if reached < cost {
                    (self.at, cost) = (moved, reached);
                    damping = (0.2 * damping).max(1e-9);
                    break;
                }
                damping *= 8.0;
            }
            let gained = before - cost;
            if gained.is_nan() || gained <= 1e-6 * before {
                break;
            }
        }
        Ok(cost)
    }

    /// The share of the specular component that makes the readings most probable, and its standard error, by a parabola
    /// through three costs around it.
    fn find_specular(&mut self, surface: Saunderson) -> Result<(Saunderson, f64), PaintError> {
        let least = self.measurements.samples().iter().flat_map(|s| &s.reflectance).fold(1.0, |a: f64, b| a.min(*b));
        if surface.external == 0.0 {
            // Without a surface there is nothing to count.
            return Ok((surface, 0.0));
        }
        let most = (0.97 * least / surface.external).min(1.0);
        let mut cost = |specular: f64| self.minimise(&surface.with_specular(specular), 12);
        // A coarse look, then golden sections.
        let count = 8;
        let mut best = (0.0, f64::INFINITY);
        for i in 0..=count {
            let specular = most * f64::from(i) / f64::from(count);
            let reached = cost(specular)?;
            if reached < best.1 {
                best = (specular, reached);
            }
        }
        let width = most / f64::from(count);
        let (mut low, mut high) = ((best.0 - width).max(0.0), (best.0 + width).min(most));
        let ratio = 0.5 * (5f64.sqrt() - 1.0);
        let [mut a, mut b] = [high - ratio * (high - low), low + ratio * (high - low)];
        let [mut cost_a, mut cost_b] = [cost(a)?, cost(b)?];
        while high - low > 1e-3 * most {
            if cost_a < cost_b {
                (high, b, cost_b) = (b, a, cost_a);
                a = high - ratio * (high - low);
                cost_a = cost(a)?;
            } else {
                (low, a, cost_a) = (a, b, cost_b);
                b = low + ratio * (high - low);
                cost_b = cost(b)?;
            }
        }
        let specular = 0.5 * (low + high);
        let step = (0.05 * most).min(specular).max(1e-3 * most);
        let curvature =
            (cost(specular + step)? - 2.0 * cost(specular)? + cost((specular - step).max(0.0))?) / (step * step);
        let error = if curvature > 0.0 { curvature.sqrt().recip() } else { f64::INFINITY };
        Ok((surface.with_specular(specular), error))
    }

    fn paints(&self, solved: &Solved) -> Vec<Paint> {
        let of = |place: Option<usize>| {
            let values = self.at.iter().map(|at| place.map_or(1.0, |place| at[place].exp())).collect::<Vec<_>>();
            let errors = solved.variance.iter().map(|v| place.map_or(0.0, |place| v[place].sqrt())).collect::<Vec<_>>();
            (values, errors)
        };
        let paint = |(i, name): (usize, &String)| {
            let ((k, k_error), (s, s_error)) = (of(Some(i)), of(self.s_place(i)));
            Paint { name: name.clone(), k, s, k_error, s_error }
        };
        self.names.iter().enumerate().map(paint).collect()
    }

    /// Paints without a chain of mixtures to the reference.
    fn ratio_only(&self) -> Vec<String> {
        let mut linked = vec![false; self.names.len()];
        linked[self.reference] = true;
        // Each round reaches one mixture further.
        for _ in 0..self.names.len() {
            for recipe in &self.recipes {
                if recipe.iter().any(|(paint, _)| linked[*paint]) {
                    recipe.iter().for_each(|(paint, _)| linked[*paint] = true);
                }
            }
        }
        self.names.iter().zip(linked).filter(|(_, linked)| !linked).map(|(name, _)| name.clone()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Recipe, Sample};
    use super::*;
    use crate::spectrum::WavelengthGrid;
    use crate::transfer::kubelka_munk::Film;

    const SURFACE: Saunderson = Saunderson { external: 0.04, internal: 0.596, specular: 0.25 };

    type Truth = Vec<(String, [Vec<f64>; 2])>;

    /// White, and two pigments of smooth K and S, by themselves and with white.
    fn made(surface: &Saunderson) -> (Measurements, Truth) {
        let grid = WavelengthGrid::regular(400e-9, 700e-9, 5e-9).unwrap();
        let of = |f: &dyn Fn(f64) -> f64| grid.iter().map(|w| f((w * 1e9 - 550.0) / 150.0)).collect::<Vec<_>>();
        let truth: Truth = vec![
            ("white".into(), [of(&|x| 0.004 - 0.002 * x), of(&|_| 1.0)]),
            ("blue".into(), [of(&|x| 0.1 + 1.5 * (-(x - 0.4f64).powi(2) * 6.0).exp()), of(&|x| 0.15 + 0.05 * x)]),
            ("red".into(), [of(&|x| 0.02 + 1.2 / (1.0 + (8.0 * x).exp())), of(&|x| 0.3 + 0.1 * x)]),
        ];
        let reflectance = |parts: &[(usize, f64)]| {
            (0..grid.len())
                .map(|i| {
                    let sum = |which: usize| parts.iter().map(|(p, c)| c * truth[*p].1[which][i]).sum::<f64>();
                    surface.measured(Film::new(sum(0), sum(1), 0.0).unwrap().reflectance_infinite())
                })
                .collect::<Vec<f64>>()
        };
        let sample = |parts: &[(usize, f64)]| Sample {
            name: format!("{parts:?}"),
            recipe: Recipe::new(parts.iter().map(|(p, c)| (truth[*p].0.clone(), *c))).unwrap(),
            reflectance: reflectance(parts),
        };
        let samples = [
            &[(0, 1.0)][..],
            &[(1, 1.0)],
            &[(2, 1.0)],
            &[(0, 0.7), (1, 0.3)],
            &[(0, 0.95), (1, 0.05)],
            &[(0, 0.6), (2, 0.4)],
            &[(0, 0.9), (2, 0.1)],
        ];
        (Measurements::new(grid.clone(), samples.map(sample).to_vec()).unwrap(), truth)
    }

    #[test]
    fn noiseless_samples_give_back_their_paints_and_surface() {
        let (measurements, truth) = made(&SURFACE);
        let start = SURFACE.with_specular(1.0);
        let found = fit(&measurements, &FitOptions::new(Surface::FitSpecular(start))).unwrap();
        assert_eq!(found.paints.reference(), "white");
        assert!(found.ratio_only.is_empty());
        let off = (found.paints.surface().specular - 0.25).abs();
        // Readings of the assumed precision tell it to 0.3; exact ones do better.
        assert!(off < 0.1 && off < found.specular_error, "{off} {}", found.specular_error);
        for (paint, (name, [k, s])) in found.paints.paints().iter().zip(&truth) {
            assert_eq!(paint.name, *name);
            for i in 0..k.len() {
                let (k_off, s_off) = ((paint.k[i] / k[i]).ln().abs(), (paint.s[i] / s[i]).ln().abs());
                assert!(
                    k_off < 0.05 + paint.k_error[i] && s_off < 0.05 + paint.s_error[i],
                    "{name} {i}: {k_off} {s_off}"
                );
            }
        }
        assert!(found.leftovers.iter().all(|left| left.ciede2000 < 0.1), "{:?}", found.leftovers);
    }

    /// A paint that is never mixed: the answer says that its S is a belief.
    #[test]
    fn a_paint_by_itself_is_reported_as_a_ratio() {
        let (measurements, _) = made(&SURFACE);
        let kept = measurements.filtered(|i, _| i != 5 && i != 6);
        let found = fit(&kept, &FitOptions::new(Surface::Given(SURFACE))).unwrap();
        assert_eq!(found.ratio_only, ["red"]);
        let [white, blue, red] = found.paints.paints() else { panic!() };
        assert!(white.s_error.iter().all(|e| *e == 0.0));
        let mean = |errors: &[f64]| errors.iter().sum::<f64>() / errors.len() as f64;
        assert!(
            mean(&red.s_error) > 1.0 && mean(&blue.s_error) < 0.3,
            "{} {}",
            mean(&red.s_error),
            mean(&blue.s_error)
        );
        // Left out, the tints are foretold within what the belief allows and no better.
        let out = measurements.filtered(|i, _| i == 5 || i == 6);
        assert_eq!(found.predict(&out).unwrap().len(), 2);
    }

    #[test]
    fn what_cannot_be_fitted_says_why() {
        let (measurements, _) = made(&SURFACE);
        let none = measurements.filtered(|_, _| false);
        let options = FitOptions::new(Surface::Given(SURFACE));
        assert!(matches!(fit(&none, &options), Err(PaintError::NothingToFit { .. })));
        let options = FitOptions { reference: Some("grey".into()), ..options };
        assert_eq!(fit(&measurements, &options), Err(PaintError::Unknown { paint: "grey".into() }));
        // A surface that alone reflects more than the darkest sample.
        let bright = Saunderson { external: 0.3, specular: 1.0, ..SURFACE };
        assert!(matches!(
            fit(&measurements, &FitOptions::new(Surface::Given(bright))),
            Err(PaintError::Surface { .. })
        ));
    }
}
