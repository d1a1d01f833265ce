//! What every size distribution that has a density can tell.

use std::fmt;

/// A density of particle volume over an internal variable `u`, which is `ln r` unless said otherwise.
pub(crate) trait Smooth: fmt::Debug + Sync {
    /// Radius (m) at `u`, and the volume of particles per unit of `u` there, up to a constant factor.
    fn measure(&self, u: f64) -> (f64, f64);

    /// Where to integrate the volume times `r^(power - 3)`, for all powers from `least` to `most`: knots in `u`, ascending.
    /// `None` when there is no such integral.
    fn knots(&self, least: f64, most: f64) -> Option<Vec<f64>>;

    /// `u` of a radius (m), and `du / d ln r` there.
    fn place(&self, radius_m: f64) -> (f64, f64) {
        (radius_m.ln(), 1.0)
    }
}

/// Evenly spaced knots from `from` to `to`, no further apart than `step`.
pub(super) fn even_knots(from: f64, to: f64, step: f64) -> Vec<f64> {
    let panels = ((to - from) / step).ceil().clamp(1.0, 64.0);
    (0..=panels as usize).map(|i| from + (to - from) * i as f64 / panels).collect()
}

/// A range of `ln r` cut off at limits (m); where that leaves nothing, what is `depth` wide at the nearer limit.
pub(super) fn clipped([from, to]: [f64; 2], limits: [f64; 2], depth: f64) -> (f64, f64) {
    let [minimum, maximum] = limits.map(f64::ln);
    let (low, high) = (from.max(minimum), to.min(maximum));
    if low < high {
        (low, high)
    } else if to <= minimum {
        (minimum, maximum.min(minimum + depth))
    } else {
        (minimum.max(maximum - depth), maximum)
    }
}
