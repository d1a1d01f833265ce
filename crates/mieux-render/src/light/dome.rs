//! A soft vertical gradient all around.

use std::f64::consts::PI;

use glam::DVec3;

use super::{LightError, about_z};

/// Brightness linear in the height `z` of the direction: from `nadir` (straight down) by `horizon` to `zenith`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dome {
    /// Brightness from straight below; at least 0.
    pub nadir: f64,
    /// Brightness from the horizon; at least 0.
    pub horizon: f64,
    /// Brightness from straight above; at least 0.
    pub zenith: f64,
}

impl Dome {
    pub(super) fn check(&self) -> Result<(), LightError> {
        for (what, value) in [("nadir", self.nadir), ("horizon", self.horizon), ("zenith", self.zenith)] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(LightError::Brightness { what, value });
            }
        }
        Ok(())
    }

    pub(super) fn value(&self, direction: DVec3) -> f64 {
        let z = direction.z.clamp(-1.0, 1.0);
        let end = if z < 0.0 { self.nadir } else { self.zenith };
        self.horizon + (end - self.horizon) * z.abs()
    }

    /// Brightness integrated over the sphere.
    pub(super) fn power(&self) -> f64 {
        PI * (self.nadir + 2.0 * self.horizon + self.zenith)
    }

    /// A direction with density `value / power`, from two uniform numbers: the exact inverse in each half.
    pub(super) fn sample(&self, [u, v]: [f64; 2]) -> DVec3 {
        let (below, above) = (self.nadir + self.horizon, self.horizon + self.zenith);
        let split = u * (below + above);
        let z = if split < below {
            -linear(self.horizon, self.nadir, split / below)
        } else {
            linear(self.horizon, self.zenith, (split - below) / above)
        };
        about_z(z, v)
    }
}

/// A number in [0, 1] whose density is linear from `a` at 0 to `b` at 1, not both 0.
pub(super) fn linear(a: f64, b: f64, u: f64) -> f64 {
    let root = (a * a * (1.0 - u) + b * b * u).sqrt();
    // (root - a)/(b - a), arranged so that nothing cancels.
    let sum = a + root;
    if sum > 0.0 { (u * (a + b) / sum).min(1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_linear_sample_inverts_its_distribution() {
        for (a, b) in [(1.0, 1.0), (0.0, 2.0), (2.0, 0.0), (0.3, 0.9), (5.0, 1e-9)] {
            for i in 0..=100 {
                let u = f64::from(i) / 100.0;
                let x = linear(a, b, u);
                let cumulative = (a * x + 0.5 * (b - a) * x * x) / (0.5 * (a + b));
                assert!((cumulative - u).abs() < 1e-12, "{a} {b} {u}");
            }
        }
    }
}
