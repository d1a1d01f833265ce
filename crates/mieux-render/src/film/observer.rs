//! From wavelengths to linear sRGB, and which wavelengths to look at.

use mieux_optics::spectrum::cie1931;
use mieux_optics::spectrum::colour::xyz_to_linear_srgb;

use crate::integrator::{LANES, Lanes};
use crate::light::relative_d65;

/// What can be wrong with a range of wavelengths.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ObserverError {
    /// The range must lie within that of the standard observer, with some light on both sides of green.
    #[error("cannot render {:.1} to {:.1} nm; the range lies within 380 to 780 nm and holds 450 to 650 nm", low_m * 1e9, high_m * 1e9)]
    Range {
        /// Shortest wavelength, m.
        low_m: f64,
        /// Longest wavelength, m.
        high_m: f64,
    },
}

/// The CIE 1931 observer on a range of wavelengths: draws wavelengths about where it sees most, and turns radiance at
/// wavelengths into linear sRGB.
///
/// The colour is scaled, channel by channel and by a few parts in a thousand, so that D65 of brightness 1 is exactly
/// RGB (1, 1, 1) on whatever range is rendered.
#[derive(Debug, Clone)]
pub struct Observer {
    low: f64,
    width: f64,
    /// Chance of each bin divided by its width, 1/m, and the cumulative chance at its lower edge; one more at the end.
    density: Vec<f64>,
    cumulative: Vec<f64>,
    /// Linear sRGB per unit of radiance and metre of wavelength, at the edges of the bins.
    response: Vec<[f64; 3]>,
}

impl Observer {
    /// Shares of the three matching functions in the density of wavelengths: most for luminance, where noise is seen.
    const SHARES: [f64; 3] = [0.15, 0.70, 0.15];
    /// Share spread evenly, so that no wavelength of the range is left out.
    const EVEN: f64 = 0.03;

    /// An observer of the wavelengths from `low_m` to `high_m` (m).
    ///
    /// # Errors
    /// [`ObserverError::Range`] unless `380 nm <= low <= 450 nm` and `650 nm <= high <= 780 nm`.
    pub fn new((low_m, high_m): (f64, f64)) -> Result<Self, ObserverError> {
        let slack = 1e-15;
        let inside = low_m >= 380e-9 - slack && low_m <= 450e-9 && high_m >= 650e-9 && high_m <= 780e-9 + slack;
        if !inside {
            return Err(ObserverError::Range { low_m, high_m });
        }
        let bins = ((high_m - low_m) / 1e-9 - 1e-6).ceil();
        let width = (high_m - low_m) / bins;
        let middles = (0..bins as usize).map(|i| low_m + (i as f64 + 0.5) * width);
        let matching: Vec<[f64; 3]> = middles.map(|w| cie1931().at(w)).collect();
        let sums: [f64; 3] = std::array::from_fn(|c| matching.iter().map(|m| m[c]).sum());
        let weight = |m: &[f64; 3]| (0..3).map(|c| Self::SHARES[c] * m[c] / sums[c]).sum::<f64>();
        let mut cumulative = vec![0.0];
        let mut density = Vec::with_capacity(matching.len());
        for m in &matching {
            let chance = (1.0 - Self::EVEN) * weight(m) + Self::EVEN / bins;
            density.push(chance / width);
            cumulative.push(cumulative[cumulative.len() - 1] + chance);
        }
        let edge = |i: usize| xyz_to_linear_srgb(cie1931().at((low_m + i as f64 * width).min(high_m)));
        let response = (0..=density.len()).map(edge).collect();
        let mut observer = Self { low: low_m, width, density, cumulative, response };
        let white = observer.white();
        observer.response.iter_mut().for_each(|rgb| (0..3).for_each(|c| rgb[c] /= white[c]));
        Ok(observer)
    }

    /// The colour of D65 before scaling, by the midpoint rule in steps of a tenth of a nanometre.
    fn white(&self) -> [f64; 3] {
        let light = relative_d65();
        let steps = self.density.len() * 10;
        let step = self.width / 10.0;
        let mut rgb = [0.0; 3];
        for i in 0..steps {
            let wavelength = self.low + (i as f64 + 0.5) * step;
            let response = self.response(wavelength);
            let power = light.at(wavelength).unwrap_or(0.0) * step;
            (0..3).for_each(|c| rgb[c] += response[c] * power);
        }
        rgb
    }

    /// Linear sRGB per unit of radiance and metre of wavelength.
    fn response(&self, wavelength: f64) -> [f64; 3] {
        let place = ((wavelength - self.low) / self.width).clamp(0.0, self.density.len() as f64);
        let bin = (place as usize).min(self.density.len() - 1);
        let (t, below, above) = (place - bin as f64, self.response[bin], self.response[bin + 1]);
        std::array::from_fn(|c| below[c] + (above[c] - below[c]) * t)
    }

    /// The wavelengths observed, m.
    pub fn range(&self) -> (f64, f64) {
        (self.low, self.low + self.width * self.density.len() as f64)
    }

    /// The hero wavelength and its companions (m) for a uniform `u` in [0, 1): evenly spread quantiles, turned by `u`.
    pub fn wavelengths(&self, u: f64) -> Lanes {
        std::array::from_fn(|k| self.quantile((u + k as f64 / LANES as f64).fract()))
    }

    fn quantile(&self, u: f64) -> f64 {
        let last = self.density.len() - 1;
        let bin = self.cumulative.partition_point(|&c| c <= u).saturating_sub(1).min(last);
        let within = (u - self.cumulative[bin]) / (self.density[bin] * self.width);
        self.low + self.width * (bin as f64 + within.clamp(0.0, 1.0))
    }

    /// Density of each wavelength drawn, 1/m.
    pub fn density(&self, wavelength: f64) -> f64 {
        let bin = ((wavelength - self.low) / self.width).clamp(0.0, (self.density.len() - 1) as f64);
        self.density[bin as usize]
    }

    /// Adds the radiance at the wavelengths of one path to bins of equal width over the range: what is added estimates the
    /// mean radiance in each bin.
    pub fn bin(&self, wavelengths: &Lanes, radiance: &Lanes, bins: &mut [f64]) {
        let (low, high) = self.range();
        let count = bins.len() as f64;
        for k in 0..LANES {
            let at = ((wavelengths[k] - low) / (high - low) * count).clamp(0.0, count - 1.0) as usize;
            bins[at] += radiance[k] / (self.density(wavelengths[k]) * LANES as f64) * count / (high - low);
        }
    }

    /// Linear sRGB estimated from the radiance at the wavelengths of one path.
    pub fn colour(&self, wavelengths: &Lanes, radiance: &Lanes) -> [f64; 3] {
        let mut rgb = [0.0; 3];
        for k in 0..LANES {
            if radiance[k] != 0.0 {
                let weight = radiance[k] / (self.density(wavelengths[k]) * LANES as f64);
                let response = self.response(wavelengths[k]);
                (0..3).for_each(|c| rgb[c] += response[c] * weight);
            }
        }
        rgb
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn daylight_is_white() {
        for range in [(380e-9, 780e-9), (380e-9, 775e-9), (400e-9, 700e-9)] {
            let observer = Observer::new(range).unwrap();
            let light = relative_d65();
            let n = 100_000;
            let mut mean = [0.0; 3];
            for i in 0..n {
                let wavelengths = observer.wavelengths((f64::from(i) + 0.5) / f64::from(n));
                let rgb = observer.colour(&wavelengths, &wavelengths.map(|w| light.at(w).unwrap()));
                (0..3).for_each(|c| mean[c] += rgb[c] / f64::from(n));
            }
            for channel in mean {
                assert!((channel - 1.0).abs() < 1e-4, "{mean:?}");
            }
        }
    }

    #[test]
    fn wavelengths_follow_their_density() {
        let observer = Observer::new((380e-9, 775e-9)).unwrap();
        let (low, high) = observer.range();
        assert!((low - 380e-9).abs() < 1e-18 && (high - 775e-9).abs() < 1e-15);
        let mut expected = 0.0;
        let n = 4_000;
        let mut drawn: Vec<f64> =
            (0..n).flat_map(|i| observer.wavelengths((f64::from(i) + 0.5) / f64::from(n))).collect();
        drawn.sort_by(f64::total_cmp);
        let mut below = 0usize;
        for i in 0..3950 {
            let wavelength = low + (f64::from(i) + 0.5) * 1e-10;
            expected += observer.density(wavelength) * 1e-10;
            while below < drawn.len() && drawn[below] < wavelength + 0.5e-10 {
                below += 1;
            }
            assert!((below as f64 / drawn.len() as f64 - expected).abs() < 1e-3);
        }
        assert!((expected - 1.0).abs() < 1e-9);
    }

    #[test]
    fn bins_hold_the_mean_radiance() {
        let observer = Observer::new((380e-9, 780e-9)).unwrap();
        let (mut bins, n) = ([0.0; 16], 1_000_000);
        for i in 0..n {
            let wavelengths = observer.wavelengths((f64::from(i) + 0.5) / f64::from(n));
            observer.bin(&wavelengths, &wavelengths.map(|w| w * 1e9), &mut bins);
        }
        for (k, sum) in bins.iter().enumerate() {
            let middle = 380.0 + (k as f64 + 0.5) * 25.0;
            assert!((sum / f64::from(n) / middle - 1.0).abs() < 1e-3, "{k}: {} {middle}", sum / f64::from(n));
        }
    }

    #[test]
    fn impossible_ranges_are_refused() {
        for range in [(300e-9, 700e-9), (400e-9, 900e-9), (500e-9, 700e-9), (400e-9, 600e-9), (f64::NAN, 7e-7)] {
            assert!(Observer::new(range).is_err());
        }
    }
}
