//! The integral over the sizes of one inclusion: adaptive, and drawn at random where resonances are too many to follow.

use std::cell::Cell;

use super::scatterer::Scatterer;
use super::{Inclusion, MediumError};
use crate::integrate::{Converged, Integral, Panel, integrate_panels};
use crate::particle::Smooth;

/// Orders of the series of all spheres together, of one inclusion at one wavelength, after which resonances are not followed any
/// further: some tenths of a second.
const MOST_ORDERS: f64 = 1e7;

/// The same where spheres are larger than [`RIPPLED`]: their resonances could not be followed with a thousand times as many.
const MOST_ORDERS_OF_LARGE: f64 = 2e6;

/// Size parameter beyond which there are more resonances than can be followed.
const RIPPLED: f64 = 1000.0;

/// Share of scattering beyond that from which on the errors of panels are not believed.
const MOST_RIPPLED: f64 = 0.5;

/// Orders that drawn sizes may take.
const MOST_DRAWN_ORDERS: f64 = 2e7;

/// Independent estimates whose spread tells the error of their mean.
const REPLICATES: usize = 16;

/// Standard errors that are believed: Student's factor for 95 % and one degree of freedom less than there are replicates.
const STANDARD_ERRORS: f64 = 2.131;

/// The seed of drawn sizes; fixed, so that results are.
const SEED: u64 = 0x006D_6965_7578;

impl Scatterer<'_> {
    /// Integrates scattering, absorption, reduced scattering, and `Im S(0)/k^2`, over all sizes; fifth the volume of the particles,
    /// sixth that of spheres of their sizes. Also returns the panels that were enough.
    ///
    /// The work is bounded: where following resonances takes too long, sizes are drawn, and the error is told from the spread of
    /// independent draws (95 % of the time it is no more).
    pub fn integrate(
        &mut self,
        sizes: &dyn Smooth,
        tolerance: f64,
        floor: impl Fn(&[f64; 6]) -> [f64; 6],
    ) -> Result<Converged<6>, MediumError> {
        // Every distribution was checked for its volume.
        let knots = sizes.knots(3.0, 6.0).unwrap_or_default();
        let last = knots.last().map_or(0.0, |u| self.size_parameter(sizes.measure(*u).0));
        let most = if last > RIPPLED { MOST_ORDERS_OF_LARGE } else { MOST_ORDERS };
        let orders = Cell::new(0.0);
        let spent = || orders.get() > most;
        let found = integrate_panels(&knots, tolerance, &floor, spent, |nodes, values| {
            orders.set(orders.get() + self.fill(sizes, nodes, values)?);
            Ok::<_, MediumError>(())
        })?;
        let (mut integral, panels) = found.ok_or_else(|| MediumError::NotConverged {
            inclusion: self.inclusion.name.clone(),
            tolerance,
            wavelength_m: self.wave.wavelength(),
        })?;
        let rippled = |panel: &&Panel<6>| self.size_parameter(sizes.measure(panel.from).0) > RIPPLED;
        let scattered = |panel: &Panel<6>| panel.integral.value[0];
        let above: f64 = panels.iter().filter(rippled).map(scattered).sum();
        // Panels that see next to nothing of the ripple may also take it for less than it is, and themselves for good enough.
        if spent() || above > MOST_RIPPLED * integral.value[0] {
            self.draw(sizes, &panels, tolerance, floor, &mut integral)?;
        }
        Ok((integral, panels))
    }

    /// Appends the integrands at nodes in `u`; returns the orders that took.
    fn fill(&mut self, sizes: &dyn Smooth, nodes: &[f64], values: &mut Vec<[f64; 6]>) -> Result<f64, MediumError> {
        let inclusion: &Inclusion = self.inclusion;
        let measures: Vec<(f64, f64)> = nodes.iter().map(|u| sizes.measure(*u)).collect();
        let radii: Vec<f64> = measures.iter().map(|(size, _)| *size).collect();
        let found = self.per_volume(&radii, true)?;
        values.extend(found.iter().zip(measures).map(|(v, (size, sphere))| {
            let m = sphere * inclusion.bulk(size);
            [v.scattering * m, v.absorption * m, v.reduced * m, v.shift * m, m, sphere]
        }));
        Ok(radii.iter().map(|size| self.size_parameter(*size)).sum())
    }

    /// Draws sizes from strata of equal reduced scattering, in pairs that mirror each other about the middle of their stratum, so that
    /// what is smooth cancels to second order, and puts the mean in place of what the panels found.
    fn draw(
        &mut self,
        sizes: &dyn Smooth,
        panels: &[Panel<6>],
        tolerance: f64,
        floor: impl Fn(&[f64; 6]) -> [f64; 6],
        integral: &mut Integral<6>,
    ) -> Result<(), MediumError> {
        let mut random = SplitMix(SEED);
        let mut sums = [[0.0; 6]; REPLICATES];
        let (mut orders, mut rounds, mut strata_wanted) = (0.0, 0.0, 4.0);
        let (mut drawn, mut nodes, mut values) = (*integral, Vec::new(), Vec::new());
        // Each round has twice the strata of the one before, and weighs by them.
        while orders < MOST_DRAWN_ORDERS {
            let strata = strata(panels, strata_wanted);
            for sum in &mut sums {
                nodes.clear();
                values.clear();
                for [from, to] in &strata {
                    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from) * random.next());
                    nodes.extend([middle - half, middle + half]);
                }
                orders += self.fill(sizes, &nodes, &mut values)?;
                for ([from, to], pair) in strata.iter().zip(values.chunks_exact(2)) {
                    let weight = strata_wanted * 0.5 * (to - from);
                    (0..6).for_each(|k| sum[k] += weight * (pair[0][k] + pair[1][k]));
                }
            }
            rounds += strata_wanted;
            strata_wanted *= 2.0;
            drawn = mean_and_error(&sums, rounds);
            let floor = floor(&drawn.value);
            if rounds > 100.0 && (0..4).all(|k| drawn.error[k] <= tolerance * (drawn.value[k].abs() + floor[k])) {
                break;
            }
        }
        // Volumes are smooth, and panels find them better.
        for k in 0..4 {
            (integral.value[k], integral.error[k]) = (drawn.value[k], drawn.error[k]);
        }
        Ok(())
    }
}

/// About as many strata as wanted, each within a panel, and as many in each panel as its share of reduced scattering says.
fn strata(panels: &[Panel<6>], wanted: f64) -> Vec<[f64; 2]> {
    let total: f64 = panels.iter().map(|panel| panel.integral.value[2].abs()).sum();
    let mut strata = Vec::new();
    // Panels are put together until they hold what one stratum does.
    let (mut from, mut held) = (panels.first().map_or(0.0, |panel| panel.from), 0.0);
    for (i, panel) in panels.iter().enumerate() {
        held += panel.integral.value[2].abs() / total * wanted;
        if held >= 1.0 || i + 1 == panels.len() {
            let parts = held.round().max(1.0) as usize;
            let at = |k: usize| from + (panel.to - from) * k as f64 / parts as f64;
            strata.extend((0..parts).map(|k| [at(k), at(k + 1)]));
            (from, held) = (panel.to, 0.0);
        }
    }
    strata
}

/// Mean of what the replicates found, each `weight` times over, and what its error is believed to be.
fn mean_and_error(sums: &[[f64; 6]; REPLICATES], weight: f64) -> Integral<6> {
    let count = REPLICATES as f64;
    let mean: [f64; 6] = std::array::from_fn(|k| sums.iter().map(|sum| sum[k] / weight).sum::<f64>() / count);
    let error = std::array::from_fn(|k| {
        let squares: f64 = sums.iter().map(|sum| (sum[k] / weight - mean[k]).powi(2)).sum();
        STANDARD_ERRORS * (squares / (count * (count - 1.0))).sqrt()
    });
    Integral { value: mean, error }
}

/// Uniform numbers in [0, 1): splitmix64 (`steele2014`).
struct SplitMix(u64);

impl SplitMix {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / 2f64.powi(53)
    }
}

#[cfg(test)]
mod tests {
    use num_complex::Complex64;

    use super::Scatterer;
    use crate::medium::{Inclusion, Medium};
    use crate::particle::{PowerLaw, SizeDistribution};
    use crate::substance::Substance;

    const GREEN: f64 = 550e-9;

    /// Bubbles of air in ice from a tenth of a millimetre, their sizes by a power law.
    fn bubbles(largest_m: f64) -> Medium {
        let sizes = SizeDistribution::PowerLaw(PowerLaw::new(1.24, 0.1e-3, largest_m).unwrap());
        let air = Substance::Constant(Complex64::new(1.0, 0.0));
        let ice = Substance::Constant(Complex64::new(1.31, 0.0));
        Medium::new(ice, vec![Inclusion::new("bubbles", air, sizes, 6e-3)]).unwrap()
    }

    /// Scattering and reduced scattering by sixty thousand sizes in even steps of the logarithm, and half their difference from every
    /// second one.
    fn by_brute_force(medium: &Medium, largest_m: f64) -> [[f64; 2]; 2] {
        let mut scatterer = Scatterer::new(&medium.inclusions()[0], GREEN, Complex64::new(1.31, 0.0)).unwrap();
        let (from, to) = ((0.1e-3f64).ln(), largest_m.ln());
        let steps = 60_000;
        let radius = |k: i32| (from + (to - from) * (f64::from(k) + 0.5) / f64::from(steps)).exp();
        let radii: Vec<f64> = (0..steps).map(radius).collect();
        let mut sums = [[0.0; 3]; 2];
        for (k, (v, r)) in scatterer.per_volume(&radii, false).unwrap().iter().zip(&radii).enumerate() {
            let volume = r.powf(4.0 - 1.24);
            let parts = [v.scattering * volume, v.reduced * volume, volume];
            (0..3).for_each(|i| sums[k % 2][i] += parts[i]);
        }
        let [odd, even] = sums.map(|s| [6e-3 * s[0] / s[2], 6e-3 * s[1] / s[2]]);
        [0, 1].map(|i| [0.5 * (odd[i] + even[i]), 0.5 * (odd[i] - even[i]).abs()])
    }

    /// What is told holds 95 times in 100; one and a half of it, nearly always.
    #[test]
    fn the_error_told_of_drawn_sizes_is_honest() {
        for largest in [0.2e-3, 0.4e-3] {
            let medium = bubbles(largest);
            let at = medium.optics_at(GREEN, 1e-4).unwrap();
            let found = [at.sigma_s, at.sigma_s * (1.0 - at.asymmetry)];
            let told = [at.relative_error.scattering, at.relative_error.reduced];
            for ((found, told), [value, spread]) in found.iter().zip(told).zip(by_brute_force(&medium, largest)) {
                let error = (found - value).abs();
                assert!(error <= 1.5 * told * value + spread, "{largest}: {error:e} of {value}, told {told:e}");
                assert!(told < 3e-4 && spread < 1e-4 * value, "{largest}: {told:e}");
            }
        }
    }
}
