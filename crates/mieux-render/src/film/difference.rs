//! Two estimates of one picture: do they differ by more than their noise?

use mieux_optics::spectrum::colour::luminance;

use crate::render::TILE;

/// A picture in linear sRGB and the variance of each value: three numbers a pixel, row by row.
#[derive(Debug, Clone, Copy)]
pub struct Estimated<'a> {
    /// Red, green, blue.
    pub rgb: &'a [f32],
    /// Variances of the means; infinite or NaN where they are not known.
    pub variance: &'a [f32],
}

/// Why pictures cannot be compared.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DifferenceError {
    /// Not three values for every pixel.
    #[error("{found} values are not three for each of {width} x {height} pixels")]
    Length {
        /// Values given.
        found: usize,
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
    /// No pixel with a finite value and a known variance in both.
    #[error("no pixel has a known variance in both pictures; it takes eight samples per pixel at least")]
    Unknown,
}

/// A square of 16 x 16 pixels, or what the edge leaves of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    /// Left, top, width, height in pixels.
    pub place: [u32; 4],
    /// Mean difference of each channel over its standard error; 0 without a pixel that can be judged.
    pub z: [f64; 3],
    /// Pixels that can be judged.
    pub pixels: usize,
}

/// How two pictures differ.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// Mean over pixels and channels of the squared difference over the square of the second picture's value, plus that of
    /// 1 % of its mean luminance.
    pub relative_mse: f64,
    /// What noise alone makes of it: the same mean with the variances instead of the squared difference.
    pub expected_mse: f64,
    /// Difference of every value over its standard error; NaN where it cannot be judged.
    pub z: Vec<f32>,
    /// The blocks, row by row.
    pub blocks: Vec<Block>,
    /// Mean difference of the whole picture over its standard error, channel by channel.
    pub whole: [f64; 3],
    /// Mean difference of the whole picture over the second picture's mean, channel by channel.
    pub bias: [f64; 3],
    /// Mean square of the blocks' z: 1 for noise alone.
    pub spread: f64,
    /// How far that is from 1 in standard deviations, channel by channel (Wilson and Hilferty's normal approximation).
    pub spread_z: [f64; 3],
    /// Pixels that cannot be judged.
    pub unknown: usize,
}

/// What follows from a [`Difference`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// No more than noise; in one of a thousand pairs that differ by noise alone, this is not said.
    Agree,
    /// More than noise.
    Differ,
    /// Less than the noise of two: they share their samples, or their variances are too large.
    TooAlike,
}

/// Chance of a false alarm over all that is looked at.
const LEVEL: f64 = 1e-3;

/// Compares two pictures of `[width, height]` pixels, the second being what errors are relative to. Pixels must be
/// independent of each other, and the pictures of one another.
///
/// Single precision is counted as an error of one unit in the last place.
///
/// # Errors
/// [`DifferenceError`].
pub fn difference(
    [width, height]: [u32; 2],
    a: Estimated<'_>,
    b: Estimated<'_>,
) -> Result<Difference, DifferenceError> {
    let pixels = width as usize * height as usize;
    for values in [a.rgb, a.variance, b.rgb, b.variance] {
        if values.len() != 3 * pixels {
            return Err(DifferenceError::Length { found: values.len(), width, height });
        }
    }
    let seen: Vec<Option<Seen>> = (0..pixels).map(|i| seen(&a, &b, i)).collect();
    let known = seen.iter().flatten().count();
    if known == 0 {
        return Err(DifferenceError::Unknown);
    }
    let floor = 0.01 * seen.iter().flatten().map(|s| luminance(s.second)).sum::<f64>() / known as f64;
    let (mut relative, mut expected) = (0.0, 0.0);
    let mut z = vec![f32::NAN; 3 * pixels];
    for (i, one) in seen.iter().enumerate() {
        let Some(one) = one else { continue };
        for c in 0..3 {
            let scale = one.second[c] * one.second[c] + floor * floor;
            if scale > 0.0 {
                relative += one.difference[c] * one.difference[c] / scale;
                expected += one.variance[c] / scale;
            }
            z[3 * i + c] = ratio(one.difference[c], one.variance[c]) as f32;
        }
    }
    let blocks = blocks(width, height, &seen);
    let judged: Vec<&Block> = blocks.iter().filter(|b| b.pixels > 0).collect();
    let count = judged.len() as f64;
    let square = |c: usize| judged.iter().map(|b| b.z[c] * b.z[c]).sum::<f64>();
    let (whole, _) = mean_z(seen.iter().flatten());
    let sum = |pick: fn(&Seen) -> [f64; 3], c: usize| seen.iter().flatten().map(|s| pick(s)[c]).sum::<f64>();
    Ok(Difference {
        relative_mse: relative / (3 * known) as f64,
        expected_mse: expected / (3 * known) as f64,
        z,
        whole,
        bias: std::array::from_fn(|c| {
            let second = sum(|s| s.second, c);
            if second == 0.0 { 0.0 } else { sum(|s| s.difference, c) / second }
        }),
        spread: (0..3).map(square).sum::<f64>() / (3.0 * count),
        spread_z: std::array::from_fn(|c| wilson_hilferty(square(c), count)),
        blocks,
        unknown: pixels - known,
    })
}

/// What is known of a pixel in both pictures.
struct Seen {
    difference: [f64; 3],
    variance: [f64; 3],
    second: [f64; 3],
}

fn seen(a: &Estimated<'_>, b: &Estimated<'_>, pixel: usize) -> Option<Seen> {
    let three = |values: &[f32]| -> [f64; 3] { std::array::from_fn(|c| f64::from(values[3 * pixel + c])) };
    let (first, second, va, vb) = (three(a.rgb), three(b.rgb), three(a.variance), three(b.variance));
    let rounding = |c: usize| (f64::from(f32::EPSILON) * first[c].abs().max(second[c].abs())).powi(2);
    let variance: [f64; 3] = std::array::from_fn(|c| va[c] + vb[c] + rounding(c));
    let all = variance.iter().chain(&first).chain(&second).all(|v| v.is_finite());
    let possible = all && va.iter().chain(&vb).all(|&v| v >= 0.0);
    possible.then(|| Seen { difference: std::array::from_fn(|c| first[c] - second[c]), variance, second })
}

/// A difference over its standard error; 0 where there is neither.
fn ratio(difference: f64, variance: f64) -> f64 {
    if difference == 0.0 { 0.0 } else { difference / variance.sqrt() }
}

/// z of the mean difference of independent pixels, and how many there are.
fn mean_z<'a>(pixels: impl Iterator<Item = &'a Seen>) -> ([f64; 3], usize) {
    let (mut difference, mut variance, mut count) = ([0.0; 3], [0.0; 3], 0);
    for pixel in pixels {
        count += 1;
        (0..3).for_each(|c| {
            difference[c] += pixel.difference[c];
            variance[c] += pixel.variance[c];
        });
    }
    (std::array::from_fn(|c| ratio(difference[c], variance[c])), count)
}

fn blocks(width: u32, height: u32, seen: &[Option<Seen>]) -> Vec<Block> {
    let corners =
        (0..height).step_by(TILE as usize).flat_map(|y| (0..width).step_by(TILE as usize).map(move |x| (x, y)));
    corners
        .map(|(x, y)| {
            let place = [x, y, TILE.min(width - x), TILE.min(height - y)];
            let rows = (y..y + place[3]).map(|row| row as usize * width as usize + x as usize);
            let inside = rows.flat_map(|start| seen[start..start + place[2] as usize].iter().flatten());
            let (z, pixels) = mean_z(inside);
            Block { place, z, pixels }
        })
        .collect()
}

/// A chi-squared of so many degrees of freedom as a standard normal variate (`wilson1931`).
fn wilson_hilferty(chi_squared: f64, degrees: f64) -> f64 {
    let spread = 2.0 / (9.0 * degrees);
    ((chi_squared / degrees).cbrt() - (1.0 - spread)) / spread.sqrt()
}

impl Difference {
    /// Largest absolute z of any block, and where.
    pub fn worst(&self) -> (f64, [u32; 4]) {
        let largest = |b: &Block| b.z.iter().fold(0.0, |m: f64, z| m.max(z.abs()));
        let worst = self.blocks.iter().map(|b| (largest(b), b.place));
        worst.fold((0.0, [0; 4]), |best, one| if one.0 > best.0 { one } else { best })
    }

    /// Share of the blocks' values beyond three standard errors; 0.27 % for noise alone.
    pub fn beyond_three(&self) -> f64 {
        let values = self.blocks.iter().filter(|b| b.pixels > 0).flat_map(|b| b.z);
        let (beyond, all) = values.fold((0, 0), |(n, all), z| (n + u32::from(z.abs() > 3.0), all + 1));
        f64::from(beyond) / f64::from(all.max(1u32))
    }

    /// How large the worst block's z may be by chance: each of the three looks (at the whole, at the worst block, at the
    /// spread) has a third of a chance of a thousandth, shared evenly by all values looked at (Bonferroni).
    pub fn allowed(&self) -> f64 {
        quantile(LEVEL / 3.0 / (3 * self.blocks.iter().filter(|b| b.pixels > 0).count()) as f64)
    }

    /// Whether noise explains the difference.
    pub fn verdict(&self) -> Verdict {
        let few = quantile(LEVEL / 3.0 / 3.0);
        let largest = |values: &[f64; 3]| values.iter().fold(f64::NEG_INFINITY, |m: f64, v| m.max(*v));
        let whole = largest(&self.whole.map(f64::abs));
        if whole > few || self.worst().0 > self.allowed() || largest(&self.spread_z) > few {
            Verdict::Differ
        } else if largest(&self.spread_z) < -few && self.spread < 0.2 {
            Verdict::TooAlike
        } else {
            Verdict::Agree
        }
    }
}

/// z beyond which, on both sides together, a standard normal variate lies with this chance.
fn quantile(chance: f64) -> f64 {
    let (mut low, mut high) = (0.0, 40.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if two_sided(middle) > chance { low = middle } else { high = middle }
    }
    high
}

/// Chance of an absolute value beyond z: the series of the error function below 3, its continued fraction above.
fn two_sided(z: f64) -> f64 {
    let bell = (-0.5 * z * z).exp() * (2.0 / std::f64::consts::PI).sqrt();
    if z < 3.0 {
        let (mut term, mut sum) = (z, z);
        for n in 1..60 {
            term *= z * z / f64::from(2 * n + 1);
            sum += term;
        }
        return 1.0 - bell * sum;
    }
    let fraction = (1..60).rev().fold(z, |below, n| z + f64::from(n) / below);
    bell / fraction
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::{Rng, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    const SIZE: [u32; 2] = [150, 101];

    /// A picture of a gradient from 0.1 to 2, each value the mean of 64 exponential samples with the variance they say
    /// they have.
    fn noisy(seed: u64, factor: f64) -> (Vec<f32>, Vec<f32>) {
        let mut generator = Pcg64Mcg::seed_from_u64(seed);
        let (mut rgb, mut variance) = (Vec::new(), Vec::new());
        for i in 0..3 * SIZE[0] * SIZE[1] {
            let truth = 0.1 + 1.9 * f64::from(i % (3 * SIZE[0])) / f64::from(3 * SIZE[0]);
            let samples: Vec<f64> = (0..64)
                .map(|_| {
                    let uniform = (generator.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
                    -truth * factor * (1.0 - uniform).ln()
                })
                .collect();
            let mean = samples.iter().sum::<f64>() / 64.0;
            rgb.push(mean as f32);
            variance.push((samples.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / 63.0 / 64.0) as f32);
        }
        (rgb, variance)
    }

    fn compare(a: &(Vec<f32>, Vec<f32>), b: &(Vec<f32>, Vec<f32>)) -> Difference {
        fn of(p: &(Vec<f32>, Vec<f32>)) -> Estimated<'_> {
            Estimated { rgb: &p.0, variance: &p.1 }
        }
        difference(SIZE, of(a), of(b)).unwrap()
    }

    #[test]
    fn noise_agrees_and_one_per_cent_is_found() {
        for seed in 0..8 {
            let (a, b) = (noisy(2 * seed, 1.0), noisy(2 * seed + 1, 1.0));
            let same = compare(&a, &b);
            assert_eq!(
                same.verdict(),
                Verdict::Agree,
                "{seed}: {:?} {:?} {:?}",
                same.whole,
                same.worst(),
                same.spread_z
            );
            assert!((same.spread - 1.0).abs() < 0.4 && same.beyond_three() < 0.02, "{}", same.spread);
            assert!((same.relative_mse / same.expected_mse - 1.0).abs() < 0.2);
            let biased = compare(&noisy(2 * seed, 1.01), &b);
            assert_eq!(biased.verdict(), Verdict::Differ, "{seed}: {:?}", biased.whole);
            assert!(biased.bias.iter().all(|b| (b - 0.01).abs() < 0.007), "{:?}", biased.bias);
        }
    }

    #[test]
    fn one_wrong_block_is_found_and_named() {
        let (mut a, b) = (noisy(1, 1.0), noisy(2, 1.0));
        for y in 32..48 {
            for x in 64..80 {
                (0..3).for_each(|c| a.0[3 * (y * SIZE[0] as usize + x) + c] *= 1.15);
            }
        }
        let found = compare(&a, &b);
        assert_eq!((found.verdict(), found.worst().1), (Verdict::Differ, [64, 32, 16, 16]));
    }

    #[test]
    fn a_picture_and_itself_are_too_alike() {
        let a = noisy(1, 1.0);
        let same = compare(&a, &a);
        assert_eq!((same.verdict(), same.relative_mse, same.worst().0), (Verdict::TooAlike, 0.0, 0.0));
    }

    #[test]
    fn pictures_without_variance_or_size_are_refused() {
        let a = noisy(1, 1.0);
        let unknown = vec![f32::INFINITY; a.0.len()];
        let bad = Estimated { rgb: &a.0, variance: &unknown };
        assert_eq!(difference(SIZE, bad, bad), Err(DifferenceError::Unknown));
        assert!(matches!(difference([3, 3], bad, bad), Err(DifferenceError::Length { .. })));
        // Some pixels alone can be judged.
        let mut some = a.1.clone();
        some[..300].fill(f32::INFINITY);
        let half = Estimated { rgb: &a.0, variance: &some };
        let found = difference(SIZE, half, half).unwrap();
        assert_eq!(found.unknown, 100);
        assert!(found.z[0].is_nan() && !found.z[300].is_nan());
    }

    /// Against the table of the normal distribution in `abramowitz1964`, 26.
    #[test]
    fn quantiles_are_those_of_the_normal_distribution() {
        for (chance, z) in [(0.31731, 1.0), (0.0455003, 2.0), (0.0026998, 3.0), (6.33425e-5, 4.0), (5.73303e-7, 5.0)] {
            assert!((quantile(chance) - z).abs() < 1e-5, "{chance}: {}", quantile(chance));
        }
    }
}
