//! Reconstruction filters, sampled: where in and around a pixel its rays go.
//!
//! A ray's place is drawn from the filter's own density, and its light counts with the filter's sign there, so every
//! sample belongs to one pixel and pixels stay independent (`ernst2006`): parts of a picture are the same bits as the
//! whole.

use std::sync::OnceLock;

/// How the light around a pixel's centre is weighed. All are products of one function across and down.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Filter {
    /// The pixel's own square, evenly.
    #[default]
    Box,
    /// Falls linearly to 0 at one pixel from the centre.
    Tent,
    /// A bell of half a pixel's standard deviation, lowered to reach 0 at 1.5 pixels.
    Gaussian,
    /// The cubic of `mitchell1988` with B = C = 1/3, which is below 0 between 1.14 and 2 pixels: sharper, and noisier.
    Mitchell,
    /// The four-term window of `harris1978`, 2 pixels to each side.
    BlackmanHarris,
}

/// Steps in which a filter is tabulated, over its whole width.
const STEPS: usize = 1024;

/// A filter along one axis as steps of even weight.
struct Table {
    radius: f64,
    /// Cumulative share of the absolute weight at the lower edge of each step; one more at the end.
    cumulative: Vec<f64>,
    /// Sign of each step times the absolute weight over the weight.
    weight: Vec<f64>,
}

impl Filter {
    /// All there are, with the names they are called by.
    pub const ALL: [(&'static str, Self); 5] = [
        ("box", Self::Box),
        ("tent", Self::Tent),
        ("gaussian", Self::Gaussian),
        ("mitchell", Self::Mitchell),
        ("blackman-harris", Self::BlackmanHarris),
    ];

    /// How far it reaches from the centre of a pixel, in pixels.
    pub fn radius(self) -> f64 {
        match self {
            Self::Box => 0.5,
            Self::Tent => 1.0,
            Self::Gaussian => 1.5,
            Self::Mitchell | Self::BlackmanHarris => 2.0,
        }
    }

    /// Its value along one axis, not normalised, at a distance from the centre in pixels.
    pub fn value(self, x: f64) -> f64 {
        let x = x.abs();
        if x > self.radius() {
            return 0.0;
        }
        let bell = |x: f64| (-2.0 * x * x).exp();
        match self {
            Self::Box => 1.0,
            Self::Tent => 1.0 - x,
            Self::Gaussian => bell(x) - bell(1.5),
            Self::Mitchell if x < 1.0 => (7.0 * x - 12.0) * x * x + 16.0 / 3.0,
            Self::Mitchell => ((-7.0 / 3.0 * x + 12.0) * x - 20.0) * x + 32.0 / 3.0,
            Self::BlackmanHarris => {
                let turn = std::f64::consts::PI * (x / 2.0 + 1.0);
                0.35875 - 0.48829 * turn.cos() + 0.14128 * (2.0 * turn).cos() - 0.01168 * (3.0 * turn).cos()
            }
        }
    }

    /// Where to look, in pixels from the upper left corner of the pixel, and what the light there counts, for two uniform
    /// numbers in [0, 1).
    pub fn sample(self, u: [f64; 2]) -> ([f64; 2], f64) {
        if self == Self::Box {
            return (u, 1.0);
        }
        let table = self.table();
        let [(x, a), (y, b)] = u.map(|u| table.sample(u));
        ([0.5 + x, 0.5 + y], a * b)
    }

    fn table(self) -> &'static Table {
        static TABLES: [OnceLock<Table>; 5] = [const { OnceLock::new() }; 5];
        TABLES[self as usize].get_or_init(|| Table::new(self))
    }
}

impl Table {
    fn new(filter: Filter) -> Self {
        let radius = filter.radius();
        let middle = |i: usize| ((i as f64 + 0.5) / STEPS as f64 * 2.0 - 1.0) * radius;
        let values: Vec<f64> = (0..STEPS).map(|i| filter.value(middle(i))).collect();
        let (sum, absolute) = values.iter().fold((0.0, 0.0), |(s, a), v| (s + v, a + v.abs()));
        let mut cumulative = vec![0.0];
        for value in &values {
            cumulative.push(cumulative[cumulative.len() - 1] + value.abs() / absolute);
        }
        let weight = values.iter().map(|v| v.signum() * absolute / sum).collect();
        Self { radius, cumulative, weight }
    }

    fn sample(&self, u: f64) -> (f64, f64) {
        let step = self.cumulative.partition_point(|&c| c <= u).saturating_sub(1).min(STEPS - 1);
        let (low, high) = (self.cumulative[step], self.cumulative[step + 1]);
        let within = if high > low { ((u - low) / (high - low)).clamp(0.0, 1.0) } else { 0.5 };
        (((step as f64 + within) / STEPS as f64 * 2.0 - 1.0) * self.radius, self.weight[step])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_leaves_numbers_alone() {
        assert_eq!(Filter::Box.sample([0.3, 0.7]), ([0.3, 0.7], 1.0));
    }

    /// Against integrals of the filters themselves, by a rule that knows nothing of the table.
    #[test]
    fn samples_follow_the_filter() {
        for (name, filter) in Filter::ALL {
            let n = 100_000;
            let (radius, step) = (filter.radius(), 2.0 * filter.radius() / f64::from(n));
            let integral = |f: &dyn Fn(f64) -> f64| {
                (0..n).map(|i| f((f64::from(i) + 0.5) * step - radius)).map(|v| v * step).sum::<f64>()
            };
            let total = integral(&|x| filter.value(x));
            let tests: [fn(f64) -> f64; 4] = [|_| 1.0, |x| x * x, |x| (3.0 * x).cos(), |x| x];
            for (i, test) in tests.into_iter().enumerate() {
                let expected = integral(&|x| filter.value(x) * test(x)) / total;
                let mean = (0..n)
                    .map(|k| {
                        let ([x, _], weight) = filter.sample([(f64::from(k) + 0.5) / f64::from(n), 0.5]);
                        let across = filter.sample([0.5, 0.5]).1.abs().sqrt();
                        test(x - 0.5) * weight / across
                    })
                    .sum::<f64>()
                    / f64::from(n);
                assert!((mean - expected).abs() < 1e-4, "{name}, {i}: {mean} {expected}");
            }
        }
    }

    #[test]
    fn only_mitchell_goes_below_zero() {
        for (_, filter) in Filter::ALL {
            let lowest = (0..400).map(|i| filter.value(f64::from(i) * 0.005)).fold(f64::INFINITY, f64::min);
            assert_eq!(lowest < -1e-9, filter == Filter::Mitchell);
        }
        assert!(Filter::Mitchell.sample([0.01, 0.5]).1 < 0.0);
    }
}
