//! Exponential variates by the ziggurat (`marsaglia2000`): nearly always one table look-up and one product.

use std::sync::LazyLock;

use rand_core::Rng;

use super::uniform;

const LAYERS: usize = 256;
/// Right edge of the lowest full layer, and the common area of the layers, for 256 layers.
const EDGE: f64 = 7.697_117_470_131_05;
const AREA: f64 = 3.949_659_822_581_572e-3;

/// Samples the density `exp(-x)`, x > 0.
pub struct Exponential {
    /// Right edges of the layers from the widest to 0, and the density there.
    edge: [f64; LAYERS + 1],
    density: [f64; LAYERS + 1],
}

impl Exponential {
    /// The tables, made once.
    pub fn get() -> &'static Self {
        static TABLES: LazyLock<Exponential> = LazyLock::new(Exponential::tables);
        &TABLES
    }

    fn tables() -> Self {
        let mut edge = [0.0; LAYERS + 1];
        // The lowest layer includes the tail; this is the width it would have as a rectangle.
        edge[0] = AREA * EDGE.exp();
        edge[1] = EDGE;
        for i in 2..LAYERS {
            edge[i] = -((-edge[i - 1]).exp() + AREA / edge[i - 1]).ln();
        }
        Self { edge, density: edge.map(|x| (-x).exp()) }
    }

    /// One variate; its mean is 1.
    #[inline]
    pub fn sample<R: Rng + Clone>(&self, generator: &mut R) -> f64 {
        let bits = generator.next_u64();
        let layer = (bits & 0xff) as usize;
        let x = (bits >> 11) as i64 as f64 * (1.0 / (1u64 << 53) as f64) * self.edge[layer];
        if x < self.edge[layer + 1] {
            return x;
        }
        // Passed by value, so that the generator can stay in registers where no call is made.
        let value;
        (value, *generator) = self.outside(layer, x, generator.clone());
        value
    }

    /// The two cases in a hundred that fall between layer and curve, or into the tail.
    #[cold]
    fn outside<R: Rng + Clone>(&self, layer: usize, x: f64, mut generator: R) -> (f64, R) {
        let value = if layer == 0 {
            EDGE - (1.0 - uniform(&mut generator)).ln()
        } else {
            let (low, high) = (self.density[layer], self.density[layer + 1]);
            if low + (high - low) * uniform(&mut generator) < (-x).exp() { x } else { self.sample(&mut generator) }
        };
        (value, generator)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_pcg::Pcg64Mcg;

    #[test]
    fn the_layers_close_at_the_top() {
        let tables = Exponential::get();
        let top = tables.edge[LAYERS - 1];
        assert!((top * (1.0 - (-top).exp()) - AREA).abs() < 1e-9);
        assert!(tables.edge.windows(2).all(|w| w[0] > w[1]));
    }

    /// Chi-squared over 100 equally likely bins, three seeds; moments; the tail.
    #[test]
    fn samples_pass_a_chi_squared_test() {
        for seed in 1..=3u128 {
            let mut generator = Pcg64Mcg::new(seed << 64 | 0xcafe_f00d);
            let (n, bins) = (1_000_000usize, 100usize);
            let mut counts = vec![0u32; bins];
            let (mut mean, mut square, mut beyond) = (0.0, 0.0, 0u32);
            for _ in 0..n {
                let x = Exponential::get().sample(&mut generator);
                assert!(x >= 0.0);
                mean += x / n as f64;
                square += x * x / n as f64;
                beyond += u32::from(x > EDGE);
                counts[((1.0 - (-x).exp()) * bins as f64).min(bins as f64 - 1.0) as usize] += 1;
            }
            let expected = n as f64 / bins as f64;
            let chi2: f64 = counts.iter().map(|&c| (f64::from(c) - expected).powi(2) / expected).sum();
            // 99 degrees of freedom: 99.99 % lie below 161.
            assert!(chi2 < 161.0, "seed {seed}: {chi2}");
            assert!((mean - 1.0).abs() < 5e-3 && (square - 2.0).abs() < 0.025, "{mean} {square}");
            let tail = (-EDGE).exp() * n as f64;
            assert!((f64::from(beyond) - tail).abs() < 5.0 * tail.sqrt(), "{beyond} {tail}");
        }
    }
}
