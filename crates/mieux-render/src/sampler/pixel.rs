//! The numbers one path of one pixel draws.

use rand_core::Rng;
use rand_pcg::Pcg64Mcg;

/// Numbers for one sample of one pixel: the first sixteen from an Owen-scrambled Sobol sequence of the pixel's own
/// (`burley2020`), which spreads the samples of a pixel evenly over the first decisions of a path; all later ones
/// from a permuted congruential generator (`oneill2014`) seeded by a hash of seed, pixel and sample.
pub struct PixelSampler {
    index: u32,
    seed: u32,
    next: u32,
    four: [f32; 4],
    generator: Pcg64Mcg,
}

/// Numbers taken from the Sobol sequence.
const EVEN: u32 = 16;
/// Length of the Sobol sequence; longer runs go on with another scramble.
const SEQUENCE: u64 = 1 << 16;

impl PixelSampler {
    /// The numbers of sample `index` of pixel (`x`, `y`).
    pub fn new(seed: u64, x: u32, y: u32, index: u64) -> Self {
        let pixel = mix(mix(seed ^ 0x6d69_6575_785f_7264) ^ (u64::from(x) << 32 | u64::from(y)));
        let path = mix(pixel ^ mix(index.wrapping_add(0x9e37_79b9_7f4a_7c15)));
        let state = u128::from(path) << 64 | u128::from(mix(path ^ 0xd1b5_4a32_d192_ed03));
        Self {
            index: (index % SEQUENCE) as u32,
            seed: (mix(pixel ^ (index / SEQUENCE)) >> 32) as u32,
            next: 0,
            four: [0.0; 4],
            generator: Pcg64Mcg::new(state),
        }
    }

    /// Uniform in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        if self.next >= EVEN {
            return uniform(&mut self.generator);
        }
        if self.next.is_multiple_of(4) {
            self.four = sobol_burley::sample_4d(self.index, self.next / 4, self.seed);
        }
        let value = self.four[(self.next % 4) as usize];
        self.next += 1;
        f64::from(value)
    }

    /// Two numbers, uniform in [0, 1).
    pub fn pair(&mut self) -> [f64; 2] {
        [self.uniform(), self.uniform()]
    }

    /// The generator behind the later numbers, for long walks.
    pub fn generator(&mut self) -> &mut Pcg64Mcg {
        &mut self.generator
    }
}

/// Uniform in [0, 1), all 53 bits.
#[inline]
pub(crate) fn uniform(generator: &mut impl Rng) -> f64 {
    (generator.next_u64() >> 11) as i64 as f64 * (1.0 / (1u64 << 53) as f64)
}

/// A bijection of 64 bits that scatters them (the finaliser of `steele2014`).
pub(crate) fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_place_gives_the_same_numbers_and_others_differ() {
        let draw = |seed, x, y, i| {
            let mut s = PixelSampler::new(seed, x, y, i);
            (0..24).map(|_| s.uniform()).collect::<Vec<_>>()
        };
        let one = draw(1, 2, 3, 4);
        assert_eq!(one, draw(1, 2, 3, 4));
        for other in
            [draw(2, 2, 3, 4), draw(1, 3, 2, 4), draw(1, 2, 4, 4), draw(1, 2, 3, 5), draw(1, 2, 3, 4 + (1 << 16))]
        {
            assert!(one.iter().zip(&other).all(|(a, b)| a != b));
        }
    }

    #[test]
    fn the_first_numbers_are_even_and_all_are_uniform() {
        let n = 1024;
        let mut sums = [0.0; 20];
        let mut strata = [0u32; 1024];
        for i in 0..n {
            let mut s = PixelSampler::new(7, 11, 13, i);
            for (k, sum) in sums.iter_mut().enumerate() {
                let u = s.uniform();
                assert!((0.0..1.0).contains(&u));
                *sum += u;
                if k == 2 {
                    strata[(u * 1024.0) as usize] += 1;
                }
            }
        }
        assert!(strata.iter().all(|&c| c == 1));
        for (k, sum) in sums.iter().enumerate() {
            let tolerance = if k < 16 { 1e-3 } else { 0.04 };
            assert!((sum / n as f64 - 0.5).abs() < tolerance, "{k}: {}", sum / n as f64);
        }
    }
}
