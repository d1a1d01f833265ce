//! Diffusion in one layer: a resistance between two leaks, and what a beam feeds it.

use super::super::super::Layer;
use super::beam::InLayer;

/// Downward flux as a function of the fluence at the same place: `slope fluence + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Admittance {
    pub slope: f64,
    pub offset: f64,
}

impl Admittance {
    pub fn flux(self, fluence: f64) -> f64 {
        self.slope * fluence + self.offset
    }
}

/// A turbid layer whose forward peak counts as not scattered.
#[derive(Debug, Clone)]
pub(super) struct Turbid {
    /// Which of the stack's layers it is.
    pub place: usize,
    /// Optical, with what is left of extinction.
    pub thickness: f64,
    albedo: f64,
    /// `g / (1 - albedo g)`.
    forward: f64,
    /// Rate at which diffuse light fades, per optical thickness.
    rate: f64,
    /// `D k tanh(k T / 2)` at each plane, and `sinh(k T) / (D k)` between them.
    leak: f64,
    resistance: f64,
    /// Flux at the top and at the bottom that the beam makes where the fluence there is 0.
    fed: [f64; 2],
}

impl Turbid {
    pub fn new(place: usize, layer: &Layer) -> Self {
        let (albedo, g) = (layer.albedo, layer.moments.asymmetry());
        // The second moment is the share of a peak (`joseph1976`); what scatters backward has none.
        let peak = layer.moments.get(2).clamp(0.0, g.max(0.0)).min(1.0 - 1e-12);
        let left = 1.0 - albedo * peak;
        let g = (g - peak) / (1.0 - peak);
        let (lost, albedo) = ((1.0 - albedo) / left, albedo * (1.0 - peak) / left);
        let thickness = layer.optical_thickness * left;
        let straight = 1.0 - albedo * g;
        let diffusion = 1.0 / (3.0 * straight);
        let rate = (lost / diffusion).sqrt();
        let x = rate * thickness;
        let resistance = if x < 1e-8 { thickness / diffusion } else { x.sinh() / (diffusion * rate) };
        let leak = diffusion * rate * (0.5 * x).tanh();
        Self { place, thickness, albedo, forward: g / straight, rate, leak, resistance, fed: [0.0; 2] }
    }

    /// A share of a beam's light more.
    pub fn light(&mut self, beam: &InLayer, share: f64) {
        let slant = 1.0 / beam.cosine;
        let [near, far] = fed_from(slant, self.rate, self.thickness);
        let source = slant * self.albedo * (1.0 + self.forward);
        // What is scattered forward leans: it is flux at once, without a slope of the fluence.
        let leaning = self.albedo * self.forward;
        let fade = (-slant * self.thickness).exp();
        let (down, up) = (share * beam.down, share * beam.up);
        self.fed[0] += leaning * (down - up * fade) - source * (down * near + up * far);
        self.fed[1] += leaning * (down * fade - up) + source * (down * far + up * near);
    }

    /// The answer at the top from that at the bottom.
    pub fn above(&self, bottom: Admittance) -> Admittance {
        let offset = bottom.offset - self.fed[1];
        let sinks = bottom.slope + self.leak;
        let divisor = 1.0 + self.resistance * sinks;
        let through = if divisor.is_finite() { 1.0 / divisor } else { 0.0 };
        Admittance { slope: self.leak + sinks * through, offset: offset * through + self.fed[0] }
    }

    /// The fluence at the bottom from that at the top.
    pub fn below(&self, bottom: Admittance, fluence: f64) -> f64 {
        let offset = bottom.offset - self.fed[1];
        let sinks = bottom.slope + self.leak;
        let divisor = 1.0 + self.resistance * sinks;
        if divisor < 1e100 { (fluence - self.resistance * offset) / divisor } else { -offset / sinks }
    }
}

/// Of a source `exp(-a t)` per depth, the parts that leave through the near and the far plane where fluence is 0 on both:
/// the integrals of `exp(-a t) sinh(k (T - t)) / sinh(k T)` and of `exp(-a t) sinh(k t) / sinh(k T)`.
fn fed_from(a: f64, k: f64, thickness: f64) -> [f64; 2] {
    let (x, y) = (a * thickness, k * thickness);
    if y < 1e-5 {
        let ramp = ramp(x);
        return [thickness * ramp, thickness * (mean(0.0, x) - ramp)];
    }
    let scale = thickness / -(-2.0 * y).exp_m1();
    let near = mean(0.0, x + y) - mean(2.0 * y, x - y);
    let far = mean(y, x - y) - mean(y, x + y);
    [scale * near, scale * far]
}

/// `exp(-shift) (1 - exp(-x)) / x`, for `x` above `-shift`.
fn mean(shift: f64, x: f64) -> f64 {
    let size = x.abs();
    let mean = if size < 1e-300 { 1.0 } else { -(-size).exp_m1() / size };
    (-(if x < 0.0 { shift + x } else { shift })).exp() * mean
}

/// The integral over `s` in [0, 1] of `exp(-x s) (1 - s)`.
fn ramp(x: f64) -> f64 {
    if x < 0.3 {
        // Sum of (-x)^n / (n + 2)!
        let (mut term, mut sum) = (0.5, 0.5);
        for n in 1..14 {
            term *= -x / f64::from(n + 2);
            sum += term;
        }
        return sum;
    }
    (1.0 - mean(0.0, x)) / x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::integrate;

    /// Both integrals, at a resonance (a = k), at k = 0 and near it, thin and thick.
    #[test]
    fn what_leaves_through_each_plane() {
        for (a, k, thickness) in [
            (1.0, 1.0, 2.0),
            (1.0, 1.0 + 1e-9, 2.0),
            (1.3, 0.4, 7.0),
            (1.0, 1.7, 30.0),
            (5.0, 0.0, 3.0),
            (1.1, 1e-6, 3.0),
            (1.1, 1e-4, 0.01),
            (1.0, 0.5, 1e-9),
            (1.0, 2.0, 1e4),
        ] {
            let weight = |up: f64, down: f64| {
                // sinh(k up) / sinh(k T) with up + down = T.
                if k * thickness < 1e-8 {
                    return up / thickness;
                }
                (-k * down).exp() * (-2.0 * k * up).exp_m1() / (-2.0 * k * thickness).exp_m1()
            };
            let end = thickness.min(60.0);
            let found = integrate(&[0.0, 0.1 * end, 0.5 * end, end], 1e-12, [1e-300; 2], |t| {
                let fade = (-a * t).exp();
                let [near, far] = [weight(thickness - t, t), weight(t, thickness - t)];
                Ok::<_, std::convert::Infallible>([fade * near, fade * far])
            });
            let wanted = found.unwrap().unwrap().value;
            let ours = fed_from(a, k, thickness);
            for (ours, wanted) in ours.iter().zip(wanted) {
                assert!((ours - wanted).abs() <= 1e-9 * wanted.abs(), "{a} {k} {thickness}: {ours} {wanted}");
            }
        }
    }
}
