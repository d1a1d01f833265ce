//! From any phase function to one of a few parameters, by least squares.
//!
//! The metric is the square of the difference of the natural logarithms of the values, averaged with a chosen
//! [`Weight`]. Logarithms, because phase functions span five decades. The mean cosine can be kept exactly
//! ([`Options::keep_asymmetry`]), by taking one parameter out of the fit: many scatterings see little else.
//!
//! Searches start from a fixed set of places and end at the best minimum found: same input, same answer.

mod models;

use std::f64::consts::PI;

use super::compare::FLOOR;
use super::{
    DoubleHenyeyGreenstein, HenyeyGreenstein, HenyeyGreensteinDraine, PhaseError, PhaseFunction, compare, quadrature,
};
use crate::levenberg_marquardt::minimise;

/// What counts how much in a fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Weight {
    /// Every solid angle alike: the shape at large angles, where a narrow peak hardly counts.
    #[default]
    SolidAngle,
    /// Every photon alike: the peak, where the light goes.
    Energy,
}

/// How to fit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Options {
    /// What counts how much.
    pub weight: Weight,
    /// Keep the mean cosine of what is fitted, to rounding, at the price of shape.
    pub keep_asymmetry: bool,
}

/// A fitted phase function, and how far it is from what it was fitted to.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit<P> {
    /// The function found, with its parameters.
    pub phase: P,
    /// Root of the mean squared difference of decimal logarithms, under the weight of the fit: what was minimised.
    pub rms_log10: f64,
    /// The largest difference of the decimal logarithms.
    pub max_log10: f64,
    /// Mean cosine of the fit less that of what was fitted.
    pub asymmetry_error: f64,
    /// Share of the light that goes elsewhere, 0 to 1.
    pub total_variation: f64,
}

/// One Henyey-Greenstein lobe. With the mean cosine kept nothing is left to search for: it is the parameter.
///
/// # Errors
/// [`PhaseError::Asymmetry`] if the mean cosine is to be kept and is within 1e-9 of -1 or 1.
pub fn henyey_greenstein(target: &PhaseFunction, options: &Options) -> Result<Fit<HenyeyGreenstein>, PhaseError> {
    let bands = Bands::new(target, options.weight);
    let phase = if options.keep_asymmetry {
        HenyeyGreenstein::new(kept(target)?)?
    } else {
        let starts = [-2.0, -1.0, 0.0, 0.5, 1.0, 2.0, 3.0].map(|u| [u]);
        bands.best(&starts, &models::henyey_greenstein)?
    };
    Ok(report(target, phase, options.weight))
}

/// Two Henyey-Greenstein lobes.
///
/// # Errors
/// [`PhaseError::Asymmetry`] if the mean cosine is to be kept and is within 1e-9 of -1 or 1.
pub fn double_henyey_greenstein(
    target: &PhaseFunction,
    options: &Options,
) -> Result<Fit<DoubleHenyeyGreenstein>, PhaseError> {
    let bands = Bands::new(target, options.weight);
    let phase = if options.keep_asymmetry {
        let g = kept(target)?;
        bands.best(&models::product([-3.0, -1.0, 1.0], [-3.0, -1.0, 1.0]), &|u: &[f64; 2]| models::double_kept(g, u))?
    } else {
        let lobes = models::product([0.5, 1.5, 3.0], [-1.5, -0.3, 0.7]);
        let starts: Vec<[f64; 3]> = lobes.iter().flat_map(|&[a, b]| [[2.0, a, b], [-1.0, a, b]]).collect();
        bands.best(&starts, &models::double)?
    };
    Ok(report(target, phase, options.weight))
}

/// A Henyey-Greenstein lobe and a Draine lobe, the form of `jendersie2023s`; alpha is sought between 1e-3 and 1e3.
///
/// # Errors
/// [`PhaseError::Asymmetry`] if the mean cosine is to be kept and is within 1e-9 of -1 or 1.
pub fn henyey_greenstein_draine(
    target: &PhaseFunction,
    options: &Options,
) -> Result<Fit<HenyeyGreensteinDraine>, PhaseError> {
    let bands = Bands::new(target, options.weight);
    let lobes = models::product([-1.0, 1.0], [-2.0, 0.0, 3.0]);
    let phase = if options.keep_asymmetry {
        let g = kept(target)?;
        let starts: Vec<[f64; 3]> = lobes.iter().flat_map(|&[a, b]| [[-2.0, a, b], [0.5, a, b]]).collect();
        let above = bands.search(&starts, &|u: &[f64; 3]| models::draine_kept(g, true, u))?;
        let below = bands.search(&starts, &|u: &[f64; 3]| models::draine_kept(g, false, u))?;
        if below.0 < above.0 { below.1 } else { above.1 }
    } else {
        let starts: Vec<[f64; 4]> = lobes
            .iter()
            .flat_map(|&[a, b]| [[0.0, 3.0, a, b], [0.0, 1.0, a, b], [2.0, -0.5, a, b], [-2.0, 2.0, a, b]])
            .collect();
        bands.best(&starts, &models::draine)?
    };
    Ok(report(target, phase, options.weight))
}

/// The mean cosine that a fit is to keep.
fn kept(target: &PhaseFunction) -> Result<f64, PhaseError> {
    let g = target.asymmetry();
    if g.abs() < 1.0 - 1e-9 { Ok(g) } else { Err(PhaseError::Asymmetry { g }) }
}

/// The target's logarithm in some hundreds of bands, each with its weight. Within a band the function of few
/// parameters hardly varies, so that fitting the band's mean is fitting all that lies in it.
struct Bands {
    /// Scattering cosine, root of the weight, mean logarithm.
    bands: Vec<(f64, f64, f64)>,
}

impl Bands {
    fn new(target: &PhaseFunction, weight: Weight) -> Self {
        let bands = band_edges();
        let edges = quadrature::merge_edges(&target.edges(), &bands);
        let mut sums = vec![[0.0; 3]; bands.len()];
        quadrature::visit(&edges, 0, |_, away, solid_angle| {
            let value = target.value_away(away).max(FLOOR);
            let part = weight.of(value) * solid_angle;
            // Next to backward `away` may round to 2, where no band starts.
            let sum = &mut sums[bands.partition_point(|&edge| edge <= away).min(bands.len() - 1)];
            sum[0] += part;
            sum[1] += part * away;
            sum[2] += part * value.ln();
        });
        let total: f64 = sums.iter().map(|sum| sum[0]).sum();
        let bands = sums
            .iter()
            .filter(|sum| sum[0] > 0.0)
            .map(|sum| (1.0 - sum[1] / sum[0], (sum[0] / total).sqrt(), sum[2] / sum[0]))
            .collect();
        Self { bands }
    }

    /// The best of the minima found from all starts, with its cost.
    fn search<const N: usize, P: Value>(
        &self,
        starts: &[[f64; N]],
        model: &impl Fn(&[f64; N]) -> Result<P, PhaseError>,
    ) -> Result<(f64, P), PhaseError> {
        let mut best = (f64::INFINITY, starts.first().copied().unwrap_or([0.0; N]));
        for &start in starts {
            let minimum = minimise(start, self.bands.len(), |u, residuals| match model(u) {
                Ok(phase) => {
                    for (r, &(mu, root, log)) in residuals.iter_mut().zip(&self.bands) {
                        *r = root * (phase.at(mu).max(FLOOR).ln() - log);
                    }
                }
                Err(_) => residuals.fill(f64::NAN),
            });
            if minimum.cost < best.0 {
                best = (minimum.cost, minimum.at);
            }
        }
        Ok((best.0, model(&best.1)?))
    }

    fn best<const N: usize, P: Value>(
        &self,
        starts: &[[f64; N]],
        model: &impl Fn(&[f64; N]) -> Result<P, PhaseError>,
    ) -> Result<P, PhaseError> {
        Ok(self.search(starts, model)?.1)
    }
}

/// Edges of the bands, in `1 - mu`: half a degree wide, and towards forward and backward a twenty-fifth of the angle
/// from there.
fn band_edges() -> Vec<f64> {
    let widest = 0.5f64.to_radians();
    let mut angles = vec![0.0, 1e-8];
    let mut angle: f64 = 1e-8;
    while angle < 0.5 * PI {
        angle += (angle / 25.0).min(widest);
        angles.push(angle.min(0.5 * PI));
    }
    let forward = angles.iter().map(|&theta| quadrature::away_of(theta));
    let backward = angles.iter().map(|&theta| 2.0 - quadrature::away_of(theta));
    quadrature::merge_edges(&forward.collect::<Vec<_>>(), &backward.collect::<Vec<_>>())
}

impl Weight {
    /// Weight per solid angle where the target has the value.
    fn of(self, value: f64) -> f64 {
        match self {
            Self::SolidAngle => 1.0,
            Self::Energy => value,
        }
    }
}

/// What a model must tell the search.
trait Value {
    fn at(&self, mu: f64) -> f64;
}

macro_rules! values {
    ($($model:ty),*) => {$(
        impl Value for $model {
            fn at(&self, mu: f64) -> f64 {
                self.value(mu)
            }
        }
    )*};
}

values!(HenyeyGreenstein, DoubleHenyeyGreenstein, HenyeyGreensteinDraine);

/// The errors, over every detail of the target and not only over the bands.
fn report<P: Clone + Into<PhaseFunction>>(target: &PhaseFunction, phase: P, weight: Weight) -> Fit<P> {
    let fitted: PhaseFunction = phase.clone().into();
    let apart = compare(target, &fitted);
    let edges = quadrature::merge_edges(&target.edges(), &fitted.edges());
    let (mut squares, mut total) = (0.0, 0.0);
    quadrature::visit(&edges, 0, |_, away, solid_angle| {
        let value = target.value_away(away).max(FLOOR);
        let part = weight.of(value) * solid_angle;
        total += part;
        squares += part * (fitted.value_away(away).max(FLOOR) / value).log10().powi(2);
    });
    Fit {
        phase,
        rms_log10: (squares / total).sqrt(),
        max_log10: apart.max_log10,
        asymmetry_error: apart.delta_asymmetry,
        total_variation: apart.total_variation,
    }
}

#[cfg(test)]
mod tests;
