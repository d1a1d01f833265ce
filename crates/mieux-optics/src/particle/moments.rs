//! What a size distribution amounts to: means, medians and modes in every weighting.

use super::{Part, ParticleError, SizeDistribution, Spread, Weighting, sphere_volume};
use crate::integrate::integrate;

/// Relative accuracy of moments.
const TOLERANCE: f64 = 1e-10;

/// Steps in which a mode is looked for.
const MODE_STEPS: u32 = 4000;

/// A size distribution as one weighting shows it. Radii in m, `None` where there is no such number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeightedSummary {
    /// The weighting.
    pub weighting: Weighting,
    /// Arithmetic mean radius.
    pub mean: Option<f64>,
    /// Standard deviation of the radius.
    pub deviation: Option<f64>,
    /// Radii below which lie 10, 50 and 90 %.
    pub quantiles: Option<[f64; 3]>,
    /// Radius of the largest density per radius.
    pub mode: Option<f64>,
}

/// A size distribution in numbers: [`SizeDistribution::summary`].
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// In the order of [`Weighting::ALL`].
    pub weighted: Vec<WeightedSummary>,
    /// Effective radius `D[3,2]`, m (`hansen1974`).
    pub effective_radius: Option<f64>,
    /// Effective variance.
    pub effective_variance: Option<f64>,
    /// Mean volume of a particle, m^3, were they all spheres.
    pub mean_volume: Option<f64>,
    /// Surface per volume of particles, 1/m.
    pub specific_surface: Option<f64>,
    /// Radius that the cumulants of dynamic light scattering give, m: the harmonic mean weighted by intensity, `D[6,5]`,
    /// while particles are much smaller than the wavelength (`koppel1972`).
    pub z_average: Option<f64>,
}

impl SizeDistribution {
    /// Integral of `r^power` over all particles, per integral of `r^3`; m to the power less 3.
    ///
    /// # Errors
    /// [`ParticleError::Diverges`] when so many particles are vanishingly small that there is no such integral.
    pub fn moment(&self, power: f64) -> Result<f64, ParticleError> {
        let mut sum = 0.0;
        for Part { share, sizes } in self.parts() {
            sum += share * moment(sizes, power)?;
        }
        Ok(sum)
    }

    /// Mean radius `D[p,q]` in m: the root of the ratio of moments `(M_p / M_q)^(1/(p-q))`, for `p = q` its limit, the geometric mean in
    /// that weighting. `D[1,0]` is the mean by number, `D[3,2]` the effective radius, `D[4,3]` the mean by volume.
    ///
    /// # Errors
    /// [`ParticleError::Diverges`].
    pub fn mean_radius(&self, p: f64, q: f64) -> Result<f64, ParticleError> {
        // The limit, to eight digits.
        let (p, q) = if p == q { (p + 1e-4, q - 1e-4) } else { (p, q) };
        Ok((self.moment(p)? / self.moment(q)?).powf(1.0 / (p - q)))
    }

    /// Effective radius, m: the mean weighted by cross section, `D[3,2]`, three times volume over surface.
    ///
    /// # Errors
    /// [`ParticleError::Diverges`].
    pub fn effective_radius(&self) -> Result<f64, ParticleError> {
        self.mean_radius(3.0, 2.0)
    }

    /// Variance of the radius weighted by cross section, over the square of the effective radius (eq 2.54 of `hansen1974`).
    ///
    /// # Errors
    /// [`ParticleError::Diverges`].
    pub fn effective_variance(&self) -> Result<f64, ParticleError> {
        Ok((self.moment(4.0)? * self.moment(2.0)? - 1.0).max(0.0))
    }

    /// Mean volume of a particle, m^3, all of them spheres: times the number of particles per volume, the volume fraction.
    ///
    /// # Errors
    /// [`ParticleError::Diverges`] when so many particles are vanishingly small that there is no such mean.
    pub fn mean_volume(&self) -> Result<f64, ParticleError> {
        Ok(sphere_volume(1.0) / self.moment(0.0)?)
    }

    /// Surface of the particles per their volume, 1/m, all of them spheres.
    ///
    /// # Errors
    /// [`ParticleError::Diverges`].
    pub fn specific_surface(&self) -> Result<f64, ParticleError> {
        Ok(3.0 * self.moment(2.0)?)
    }

    /// Density per radius in a weighting, 1/m, which integrates to 1; 0 where all particles have one size.
    ///
    /// # Errors
    /// [`ParticleError::Diverges`].
    pub fn density(&self, weighting: Weighting, radius_m: f64) -> Result<f64, ParticleError> {
        Ok(self.densities(weighting, &[radius_m])?[0])
    }

    /// [`Self::density`] at many radii (m).
    ///
    /// # Errors
    /// [`ParticleError::Diverges`].
    pub fn densities(&self, weighting: Weighting, radii_m: &[f64]) -> Result<Vec<f64>, ParticleError> {
        let power = weighting.power();
        let mut sum = vec![0.0; radii_m.len()];
        for Part { share, sizes } in self.parts() {
            let Spread::Smooth(sizes) = sizes else { continue };
            let [volume, ends] = whole(sizes, 3.0)?;
            let (from, to) = (ends, last(sizes));
            for (sum, radius) in sum.iter_mut().zip(radii_m) {
                let (u, slope) = sizes.place(*radius);
                if u >= from && u <= to {
                    *sum += share * sizes.measure(u).1 * slope / volume * radius.powf(power - 4.0);
                }
            }
        }
        let total = self.moment(power)?;
        Ok(sum.into_iter().map(|density| density / total).collect())
    }

    /// Share of what the weighting counts that lies below a radius (m), 0 to 1.
    ///
    /// # Errors
    /// [`ParticleError::Diverges`].
    pub fn share_below(&self, weighting: Weighting, radius_m: f64) -> Result<f64, ParticleError> {
        let power = weighting.power();
        Ok((self.below(power, radius_m)? / self.moment(power)?).min(1.0))
    }

    /// Radius (m) below which lies a share (0 to 1) of what the weighting counts.
    ///
    /// # Errors
    /// [`ParticleError::Diverges`].
    pub fn quantile(&self, weighting: Weighting, share: f64) -> Result<f64, ParticleError> {
        let power = weighting.power();
        let total = self.moment(power)?;
        let (mut low, mut high) = self.log_range(power)?;
        if low == high {
            return Ok(low.exp());
        }
        // 50 halvings leave nothing to choose.
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if self.below(power, middle.exp())? < share * total { low = middle } else { high = middle }
        }
        Ok((0.5 * (low + high)).exp())
    }

    /// Radius (m) of the largest density per radius; `None` when some particles all have one size, or the densest is the smallest
    /// of a distribution without a lower limit.
    ///
    /// # Errors
    /// [`ParticleError::Diverges`].
    pub fn mode(&self, weighting: Weighting) -> Result<Option<f64>, ParticleError> {
        let (from, to) = self.log_range(weighting.power())?;
        if self.parts().iter().any(|part| matches!(part.sizes, Spread::One(_))) {
            return Ok((from == to).then(|| from.exp()));
        }
        let at = |i: f64| (from + (to - from) * i / f64::from(MODE_STEPS)).exp();
        let radii: Vec<f64> = (0..=MODE_STEPS).map(|i| at(f64::from(i))).collect();
        let densities = self.densities(weighting, &radii)?;
        let best = (0..radii.len()).max_by(|a, b| densities[*a].total_cmp(&densities[*b])).unwrap_or(0);
        if best == 0 && self.is_open_below() {
            return Ok(None);
        }
        if best == 0 || best + 1 == radii.len() {
            return Ok(Some(radii[best]));
        }
        // The top of the parabola through three points.
        let [a, b, c] = [densities[best - 1], densities[best], densities[best + 1]];
        let bend = a - 2.0 * b + c;
        let shift = if bend < 0.0 { 0.5 * (a - c) / bend } else { 0.0 };
        Ok(Some(at(best as f64 + shift.clamp(-1.0, 1.0))))
    }

    /// All of it.
    pub fn summary(&self) -> Summary {
        let weighted = |weighting: Weighting| {
            let p = weighting.power();
            let mean = self.mean_radius(p + 1.0, p).ok();
            let square = self.mean_radius(p + 2.0, p).ok();
            let quantile = |share| self.quantile(weighting, share).ok();
            WeightedSummary {
                weighting,
                mean,
                deviation: mean.zip(square).map(|(mean, square)| (square * square - mean * mean).max(0.0).sqrt()),
                quantiles: quantile(0.1).zip(quantile(0.5)).zip(quantile(0.9)).map(|((a, b), c)| [a, b, c]),
                mode: self.mode(weighting).ok().flatten(),
            }
        };
        Summary {
            weighted: Weighting::ALL.map(weighted).to_vec(),
            effective_radius: self.effective_radius().ok(),
            effective_variance: self.effective_variance().ok(),
            mean_volume: self.mean_volume().ok(),
            specific_surface: self.specific_surface().ok(),
            z_average: self.mean_radius(6.0, 5.0).ok(),
        }
    }

    /// The part of [`Self::moment`] that is below a radius (m).
    fn below(&self, power: f64, radius_m: f64) -> Result<f64, ParticleError> {
        let mut sum = 0.0;
        for Part { share, sizes } in self.parts() {
            match sizes {
                Spread::One(radius) if radius <= radius_m => sum += share * moment(sizes, power)?,
                Spread::One(_) => {}
                Spread::Smooth(smooth) => {
                    let mut knots = smooth.knots(power, power).ok_or(ParticleError::Diverges { power })?;
                    let end = smooth.place(radius_m).0.min(knots[knots.len() - 1]);
                    knots.retain(|u| *u < end);
                    if knots.is_empty() {
                        continue;
                    }
                    knots.push(end);
                    let volume = whole(smooth, 3.0)?[0];
                    sum += share * integral(smooth, &knots, power) / volume;
                }
            }
        }
        Ok(sum)
    }

    /// The logarithms of radii between which all of the integral of a power is.
    pub(crate) fn log_range(&self, power: f64) -> Result<(f64, f64), ParticleError> {
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for part in self.parts() {
            let (from, to) = match part.sizes {
                Spread::One(radius) => (radius, radius),
                Spread::Smooth(sizes) => {
                    let knots = sizes.knots(power, power).ok_or(ParticleError::Diverges { power })?;
                    (sizes.measure(knots[0]).0, sizes.measure(knots[knots.len() - 1]).0)
                }
            };
            range = (range.0.min(from.ln()), range.1.max(to.ln()));
        }
        Ok(range)
    }

    fn is_open_below(&self) -> bool {
        match self {
            Self::PowerLaw(law) => law.limits().0 == 0.0,
            Self::Mixture(mix) => mix.parts().iter().any(|(_, sizes)| sizes.is_open_below()),
            _ => false,
        }
    }
}

/// Per integral of the volume.
fn moment(sizes: Spread<'_>, power: f64) -> Result<f64, ParticleError> {
    match sizes {
        Spread::One(radius) => Ok(radius.powf(power - 3.0)),
        Spread::Smooth(sizes) => Ok(whole(sizes, power)?[0] / whole(sizes, 3.0)?[0]),
    }
}

/// The integral of the volume times `r^(power - 3)`, and where it begins.
fn whole(sizes: &dyn super::Smooth, power: f64) -> Result<[f64; 2], ParticleError> {
    let knots = sizes.knots(power, power).ok_or(ParticleError::Diverges { power })?;
    Ok([integral(sizes, &knots, power), knots[0]])
}

/// Where the volume ends.
fn last(sizes: &dyn super::Smooth) -> f64 {
    sizes.knots(3.0, 6.0).and_then(|knots| knots.last().copied()).unwrap_or(f64::NEG_INFINITY)
}

fn integral(sizes: &dyn super::Smooth, knots: &[f64], power: f64) -> f64 {
    // Relative to a radius of the range, so that no power leaves the range of numbers.
    let unit = sizes.measure(0.5 * (knots[0] + knots[knots.len() - 1])).0;
    let f = |u| {
        let (radius, volume) = sizes.measure(u);
        Ok::<_, std::convert::Infallible>([volume * (radius / unit).powf(power - 3.0)])
    };
    match integrate(knots, TOLERANCE, [0.0], f) {
        Ok(Some(integral)) => integral.value[0] * unit.powf(power - 3.0),
        _ => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particle::{LogNormal, MixedSizes};

    fn log_normal(median: f64, deviation: f64) -> SizeDistribution {
        SizeDistribution::LogNormal(LogNormal::from_median(Weighting::Number, median, deviation).unwrap())
    }

    /// All of a log-normal is known in closed form (`hatch1929`).
    #[test]
    fn a_log_normal_amounts_to_what_is_known() {
        for deviation in [1.05, 1.4, 2.0, 3.0] {
            let (median, s) = (0.3e-6, f64::ln(deviation));
            let sizes = log_normal(median, deviation);
            let summary = sizes.summary();
            let near = |a: Option<f64>, b: f64, tolerance: f64| {
                assert!((a.unwrap() / b - 1.0).abs() < tolerance, "{deviation}: {a:?} {b:e}");
            };
            for w in &summary.weighted {
                let centre = median * (w.weighting.power() * s * s).exp();
                near(w.mean, centre * (0.5 * s * s).exp(), 1e-8);
                near(w.quantiles.map(|q| q[1]), centre, 1e-6);
                near(w.quantiles.map(|q| q[2]), centre * (1.281_551_565_5 * s).exp(), 1e-6);
                near(w.deviation, centre * (0.5 * s * s).exp() * (s * s).exp_m1().sqrt(), 1e-5);
                near(w.mode, centre * (-s * s).exp(), 1e-4);
            }
            near(summary.effective_radius, median * (2.5 * s * s).exp(), 1e-8);
            near(summary.effective_variance, (s * s).exp_m1(), 1e-6);
            near(summary.mean_volume, sphere_volume(median) * (4.5 * s * s).exp(), 1e-8);
            near(summary.specific_surface, 3.0 / (median * (2.5 * s * s).exp()), 1e-8);
            near(summary.z_average, median * (5.5 * s * s).exp(), 1e-8);
            near(sizes.mean_radius(3.0, 3.0).ok(), median * (3.0 * s * s).exp(), 1e-6);
        }
    }

    #[test]
    fn densities_integrate_to_one_and_limits_cut_them() {
        let cut = LogNormal::from_median(Weighting::Number, 1e-6, 2.0).unwrap().truncated(0.5e-6, 3e-6).unwrap();
        let sizes = SizeDistribution::LogNormal(cut);
        for weighting in Weighting::ALL {
            let steps = 20_000;
            let h = 2.5e-6 / f64::from(steps);
            let radii: Vec<f64> = (0..steps).map(|i| 0.5e-6 + h * (f64::from(i) + 0.5)).collect();
            let sum: f64 = sizes.densities(weighting, &radii).unwrap().iter().sum::<f64>() * h;
            assert!((sum - 1.0).abs() < 1e-6, "{weighting}: {sum}");
            assert_eq!(sizes.density(weighting, 0.4e-6).unwrap(), 0.0);
            assert_eq!(sizes.density(weighting, 3.1e-6).unwrap(), 0.0);
        }
    }

    #[test]
    fn one_size_and_two_have_medians() {
        let one = SizeDistribution::monodisperse(2e-6).unwrap();
        let summary = one.summary();
        for w in &summary.weighted {
            for radius in [w.mean, w.mode, w.quantiles.map(|q| q[0])] {
                assert!((radius.unwrap() / 2e-6 - 1.0).abs() < 1e-12);
            }
        }
        assert!(summary.effective_variance.unwrap() < 1e-12);
        let mix = MixedSizes::new(Weighting::Number, vec![(0.7, log_normal(1e-6, 1.2)), (0.3, one)]).unwrap();
        let mix = SizeDistribution::Mixture(mix);
        // 0.7 of them are the log-normal, whose quantile at 0.5 / 0.7 lies well below the other size.
        let expected = 1e-6 * (0.565_948_821_9 * 1.2f64.ln()).exp();
        let median = mix.quantile(Weighting::Number, 0.5).unwrap();
        assert!((median / expected - 1.0).abs() < 1e-5, "{median:e} {expected:e}");
        assert!((mix.quantile(Weighting::Number, 0.9).unwrap() / 2e-6 - 1.0).abs() < 1e-9);
        assert_eq!(mix.mode(Weighting::Number).unwrap(), None);
    }
}
