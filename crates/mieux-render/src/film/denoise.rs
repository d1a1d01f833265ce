//! Takes noise out of a picture by averaging pixels that look alike, as far as their noise lets one tell: means over
//! patches (`buades2005`), weighed by the variance of every pixel (`rousselle2012`) and by what stands there
//! (`rousselle2013`).

use rayon::prelude::*;

/// What is known of a picture: values per pixel, row by row.
#[derive(Debug, Clone, Copy)]
pub struct Noisy<'a> {
    /// Linear red, green, blue.
    pub rgb: &'a [[f64; 3]],
    /// Variance of each; infinite where it is not known, and then the pixel is left as it is.
    pub variance: &'a [[f64; 3]],
    /// Colour of what is seen first, 0 to 1.
    pub albedo: &'a [[f64; 3]],
    /// Its normal.
    pub normal: &'a [[f64; 3]],
}

/// How far away like pixels are looked for, pixels to each side.
const REACH: i64 = 8;
/// Size of the patches that are compared, pixels to each side of the middle.
const PATCH: i64 = 2;
/// Differences that count as small, in standard deviations of the noise.
const STRENGTH: f64 = 0.6;
/// Differences of albedo and normal that count as small.
const ALBEDO: f64 = 0.05;
const NORMAL: f64 = 0.2;

/// The picture without most of its noise, biased where details are finer than the noise: for the eye, not for measuring.
/// `None` unless all parts have `width * height` pixels.
pub fn denoise([width, height]: [u32; 2], noisy: &Noisy<'_>) -> Option<Vec<[f64; 3]>> {
    let pixels = width as usize * height as usize;
    let parts = [noisy.rgb, noisy.variance, noisy.albedo, noisy.normal];
    if parts.iter().any(|part| part.len() != pixels) || pixels == 0 {
        return None;
    }
    let grid = Grid { width: i64::from(width), height: i64::from(height) };
    let variance = grid.smooth(noisy.variance);
    let mut sums = vec![[0.0; 4]; pixels];
    for dy in -REACH..=REACH {
        for dx in -REACH..=REACH {
            let distance = grid.map(|x, y| match grid.at(x + dx, y + dy) {
                Some(q) => colour_distance(noisy, &variance, grid.index(x, y), q),
                None => f64::INFINITY,
            });
            let across: Vec<f64> = grid.map(|x, y| (-PATCH..=PATCH).map(|d| distance[grid.nearest(x + d, y)]).sum());
            sums.par_chunks_mut(width as usize).enumerate().for_each(|(y, row)| {
                let y = y as i64;
                for (x, sum) in (0i64..).zip(row) {
                    let Some(q) = grid.at(x + dx, y + dy) else { continue };
                    let patch: f64 = (-PATCH..=PATCH).map(|d| across[grid.nearest(x, y + d)]).sum();
                    let patch = patch / ((2 * PATCH + 1) * (2 * PATCH + 1)) as f64;
                    let weight = (-patch.max(feature_distance(noisy, grid.index(x, y), q)).max(0.0)).exp();
                    if weight > 1e-4 {
                        (0..3).for_each(|c| sum[c] += weight * noisy.rgb[q][c]);
                        sum[3] += weight;
                    }
                }
            });
        }
    }
    let known = |i: usize| variance[i].iter().all(|v| v.is_finite());
    let filtered = |(i, sum): (usize, &[f64; 4])| {
        if sum[3] > 0.0 && known(i) { [sum[0] / sum[3], sum[1] / sum[3], sum[2] / sum[3]] } else { noisy.rgb[i] }
    };
    Some(sums.iter().enumerate().map(filtered).collect())
}

/// Squared difference of two pixels less what noise alone makes of it, over the noise: about 0 for pixels of one colour.
fn colour_distance(noisy: &Noisy<'_>, variance: &[[f64; 3]], p: usize, q: usize) -> f64 {
    let one = |c: usize| {
        let (a, b, va, vb) = (noisy.rgb[p][c], noisy.rgb[q][c], variance[p][c], variance[q][c]);
        let noise = STRENGTH * STRENGTH * (va + vb);
        let excess = (a - b) * (a - b) - (va + va.min(vb));
        if excess == 0.0 { 0.0 } else { excess / (noise + 1e-12 * (a * a + b * b)).max(f64::MIN_POSITIVE) }
    };
    let mean = (0..3).map(one).sum::<f64>() / 3.0;
    // A bound keeps one pixel from deciding for its whole patch, and what is not known from spreading.
    if mean.is_finite() { mean.min(1e3) } else { 1e3 }
}

fn feature_distance(noisy: &Noisy<'_>, p: usize, q: usize) -> f64 {
    let square = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>();
    let albedo = square(&noisy.albedo[p], &noisy.albedo[q]) / (ALBEDO * ALBEDO);
    albedo.max(square(&noisy.normal[p], &noisy.normal[q]) / (NORMAL * NORMAL))
}

/// Pixels by column and row.
struct Grid {
    width: i64,
    height: i64,
}

impl Grid {
    fn index(&self, x: i64, y: i64) -> usize {
        (y * self.width + x) as usize
    }

    fn at(&self, x: i64, y: i64) -> Option<usize> {
        ((0..self.width).contains(&x) && (0..self.height).contains(&y)).then(|| self.index(x, y))
    }

    /// The pixel there, or the nearest one inside.
    fn nearest(&self, x: i64, y: i64) -> usize {
        self.index(x.clamp(0, self.width - 1), y.clamp(0, self.height - 1))
    }

    fn map<T: Send>(&self, value: impl Fn(i64, i64) -> T + Sync) -> Vec<T> {
        let row = |y: i64| (0..self.width).map(move |x| (x, y));
        (0..self.height).into_par_iter().flat_map_iter(row).map(|(x, y)| value(x, y)).collect()
    }

    /// Means over 5 x 5 pixels: variances are noisy themselves, and those of dark samples too small.
    fn smooth(&self, values: &[[f64; 3]]) -> Vec<[f64; 3]> {
        self.map(|x, y| {
            if values[self.index(x, y)].iter().any(|v| !v.is_finite()) {
                return [f64::INFINITY; 3];
            }
            let (mut sum, mut count) = ([0.0; 3], 0.0);
            for (dx, dy) in (-2..=2).flat_map(|dy| (-2..=2).map(move |dx| (dx, dy))) {
                let Some(value) = self.at(x + dx, y + dy).map(|i| values[i]) else { continue };
                if value.iter().all(|v| v.is_finite()) {
                    (0..3).for_each(|c| sum[c] += value[c]);
                    count += 1.0;
                }
            }
            sum.map(|s| s / count)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::{Rng, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    const SIZE: [u32; 2] = [64, 48];

    type Field = Vec<[f64; 3]>;

    /// Two fields of different colour, and noise of a tenth of the brighter.
    fn fields(noise: f64) -> (Field, Field, Field) {
        let mut generator = Pcg64Mcg::seed_from_u64(3);
        let mut uniform = || (generator.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        let truth: Vec<[f64; 3]> =
            (0..SIZE[0] * SIZE[1]).map(|i| if i % SIZE[0] < 30 { [1.0, 0.8, 0.6] } else { [0.2; 3] }).collect();
        let spread = noise * 12f64.sqrt();
        let noisy = truth.iter().map(|t| t.map(|t| t + spread * (uniform() - 0.5))).collect();
        let variance = vec![[noise * noise; 3]; truth.len()];
        (truth, noisy, variance)
    }

    fn error(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
        let square = |(a, b): (&[f64; 3], &[f64; 3])| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>();
        a.iter().zip(b).map(square).sum::<f64>() / a.len() as f64 / 3.0
    }

    #[test]
    fn noise_goes_and_edges_stay() {
        let (truth, rgb, variance) = fields(0.1);
        let none = vec![[0.0; 3]; rgb.len()];
        let noisy = Noisy { rgb: &rgb, variance: &variance, albedo: &none, normal: &none };
        let clean = denoise(SIZE, &noisy).unwrap();
        let (before, after) = (error(&rgb, &truth), error(&clean, &truth));
        assert!(after < 0.1 * before, "{before} {after}");
        let edge = |picture: &[[f64; 3]]| picture[29 + 20 * 64][0] - picture[30 + 20 * 64][0];
        assert!((edge(&clean) - 0.8).abs() < 0.08, "{}", edge(&clean));
    }

    #[test]
    fn what_has_no_noise_or_none_that_is_known_stays() {
        let (truth, _, variance) = fields(0.0);
        let none = vec![[0.0; 3]; truth.len()];
        let same = denoise(SIZE, &Noisy { rgb: &truth, variance: &variance, albedo: &none, normal: &none }).unwrap();
        assert!(error(&same, &truth) < 1e-24);
        let (_, rgb, _) = fields(0.1);
        let unknown = vec![[f64::INFINITY; 3]; rgb.len()];
        let noisy = Noisy { rgb: &rgb, variance: &unknown, albedo: &none, normal: &none };
        assert_eq!(denoise(SIZE, &noisy).unwrap(), rgb);
        assert!(denoise([3, 3], &noisy).is_none());
    }

    /// Two fields of one colour with different normals do not mix, however noisy they are.
    #[test]
    fn features_keep_apart_what_noise_hides() {
        let (truth, _, _) = fields(0.1);
        let variance = vec![[1.0; 3]; truth.len()];
        let none = vec![[0.0; 3]; truth.len()];
        let normal: Vec<[f64; 3]> =
            (0..truth.len()).map(|i| if i % 64 < 30 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] }).collect();
        let kept = denoise(SIZE, &Noisy { rgb: &truth, variance: &variance, albedo: &none, normal: &normal }).unwrap();
        assert!(error(&kept, &truth) < 1e-6, "{}", error(&kept, &truth));
    }
}
