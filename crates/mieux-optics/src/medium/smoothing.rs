//! Averages over the fine structure that cross sections of large spheres have over their size.
//!
//! Resonances of a dense sphere, and fringes of a light one, follow each other regularly over the size parameter `x`, thousands
//! of them over the sizes of bubbles in ice. An integral `I` of `G(x)` is that of `G` averaged with a kernel, `sum w G(x + d)`, as
//! long as `G` is 0 where it ends; and that is smooth. So `G` is parted by a share that rises smoothly from 0 to 1 and falls
//! again: the part with the share is averaged, the rest, at both ends, is integrated as it is.

use super::Inclusion;
use crate::particle::Smooth;

/// Widths of the kernel over which the share rises and falls.
const RISE: f64 = 8.0;

/// A kernel, and where it is used.
#[derive(Debug, Clone, Copy)]
pub(super) struct Smoothing {
    /// Size parameters between which the share is above 0.
    pub range: [f64; 2],
    /// Width of the kernel, in size parameters.
    pub width: f64,
    /// Points of the kernel.
    pub steps: u32,
}

impl Smoothing {
    /// Size parameters between which the share is 1.
    pub fn inner(&self) -> [f64; 2] {
        [self.range[0] + RISE * self.width, self.range[1] - RISE * self.width]
    }

    /// The share that is averaged at a size parameter.
    pub fn share(&self, x: f64) -> f64 {
        let step = |distance: f64| {
            let t = (distance / (RISE * self.width)).clamp(0.0, 1.0);
            t * t * t * (10.0 - t * (15.0 - 6.0 * t))
        };
        step(x - self.range[0]) * step(self.range[1] - x)
    }

    /// Shifts and weights: the window of Hann, of which nothing is left at the frequencies of 2 or more waves to its width.
    pub fn kernel(&self) -> impl Iterator<Item = (f64, f64)> + use<> {
        let Self { width, steps, .. } = *self;
        (0..steps).map(move |i| {
            let t = (f64::from(i) + 0.5) / f64::from(steps) - 0.5;
            (width * t, 2.0 * (std::f64::consts::PI * t).cos().powi(2) / f64::from(steps))
        })
    }
}

/// From the variable of a size distribution to size parameters, and back.
pub(super) struct Map<'a> {
    pub inclusion: &'a Inclusion,
    pub sizes: &'a dyn Smooth,
    /// Modulus of the wave number in the host, 1/m.
    pub wave: f64,
}

impl Map<'_> {
    pub fn x(&self, u: f64) -> f64 {
        let size = self.sizes.measure(u).0;
        let inclusion = self.inclusion;
        let radius = if inclusion.coats.is_empty() {
            inclusion.shape.equivalent_radius(size)
        } else {
            inclusion.outer_radius(size)
        };
        self.wave * radius
    }

    /// `dx/du`, to some nine digits.
    pub fn slope(&self, u: f64) -> f64 {
        const STEP: f64 = 1e-4;
        (self.x(u + STEP) - self.x(u - STEP)) / (2.0 * STEP)
    }

    /// Where a size parameter is, by Newton's method from nearby.
    pub fn near(&self, x: f64, mut u: f64) -> f64 {
        for _ in 0..8 {
            let change = (x - self.x(u)) / self.slope(u);
            u += change;
            if change.abs() < 1e-12 {
                break;
            }
        }
        u
    }

    /// Where a size parameter is within a range, by halving it.
    pub fn u(&self, x: f64, [mut low, mut high]: [f64; 2]) -> f64 {
        if x <= self.x(low) {
            return low;
        }
        if x >= self.x(high) {
            return high;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.x(middle) < x { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::gauss_legendre;

    /// The share and the rest are all, waves are gone, and the mean stays.
    #[test]
    fn the_kernel_takes_waves_away_and_keeps_the_rest() {
        let smoothing = Smoothing { range: [100.0, 500.0], width: 4.0, steps: 24 };
        let sum: f64 = smoothing.kernel().map(|(_, w)| w).sum();
        assert!((sum - 1.0).abs() < 1e-12);
        for frequency in [0.5, 1.0, 1.3, 2.2] {
            let wave: f64 = smoothing.kernel().map(|(d, w)| w * (std::f64::consts::TAU * frequency * d).cos()).sum();
            assert!(wave.abs() < 0.02, "{frequency}: {wave}");
        }
        assert_eq!((smoothing.share(100.0), smoothing.share(300.0), smoothing.share(500.0)), (0.0, 1.0, 0.0));
        // The integral of the share, averaged, is that of the share.
        let rule = gauss_legendre(200);
        let integral = |f: &dyn Fn(f64) -> f64| rule.iter().map(|(t, w)| 210.0 * w * f(300.0 + 210.0 * t)).sum::<f64>();
        let plain = integral(&|x| smoothing.share(x) * x);
        let moved = |x: f64| smoothing.kernel().map(|(d, w)| w * smoothing.share(x + d) * (x + d)).sum();
        assert!((integral(&moved) / plain - 1.0).abs() < 1e-6);
    }
}
