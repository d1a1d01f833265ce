//! Particles that get in each other's way: interference of the light of neighbours.
//!
//! Hard spheres keep a distance, and the light that they scatter interferes: a structure factor `S(q)` multiplies what each
//! scatters by itself. Dense fluids of hard spheres scatter much less forward, and less altogether.

/// Whether particles of an inclusion get in each other's way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Packing {
    /// Each scatters as if it were alone.
    #[default]
    Independent,
    /// Hard spheres as dense as their volume fraction says, by the static structure factor of `percus1958` in the closed form
    /// of `wertheim1963`; where they are of several sizes, each among its like (the local monodisperse approximation,
    /// `pedersen1994`). Good up to a volume fraction of about 0.45 (`fraden1990`), and refused above 0.5, where hard spheres
    /// freeze.
    /// Nothing but positions is corrected: neighbours do not act on each other's near field, and other inclusions are not
    /// in the way.
    PercusYevick,
}

impl Packing {
    /// Largest volume fraction for which a structure factor is offered.
    pub const MOST: f64 = 0.5;
}

/// Fluid of hard spheres in Percus and Yevick's approximation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HardSpheres {
    fraction: f64,
    /// Of the direct correlation `-(alpha + beta s + gamma s^3)` over the distance `s` in diameters, within one.
    alpha: f64,
    beta: f64,
    gamma: f64,
}

impl HardSpheres {
    /// At a volume fraction, drawn to 0..=0.5.
    pub fn new(volume_fraction: f64) -> Self {
        let fraction = if volume_fraction.is_nan() { 0.0 } else { volume_fraction.clamp(0.0, Packing::MOST) };
        let below = (1.0 - fraction).powi(4);
        let alpha = (1.0 + 2.0 * fraction).powi(2) / below;
        let beta = -6.0 * fraction * (1.0 + 0.5 * fraction).powi(2) / below;
        Self { fraction, alpha, beta, gamma: 0.5 * fraction * alpha }
    }

    /// Structure factor at a wave number of scattering `q` times the diameter of a sphere: 1 where spheres do not see each
    /// other, `(1 - f)^4 / (1 + 2 f)^2` forward.
    pub fn structure_factor(&self, q_diameter: f64) -> f64 {
        1.0 / (1.0 + 24.0 * self.fraction * self.correlation(q_diameter.abs()))
    }

    /// Integral of `(alpha + beta s + gamma s^3) s^2 sin(a s)/(a s)` over `s` from 0 to 1.
    fn correlation(&self, a: f64) -> f64 {
        let Self { alpha, beta, gamma, .. } = *self;
        if a < 1.0 {
            // The closed form loses digits to its sixth power.
            let (square, mut factor, mut sum) = (a * a, 1.0, 0.0);
            for k in 0..10 {
                let n = f64::from(2 * k);
                sum += factor * (alpha / (n + 3.0) + beta / (n + 4.0) + gamma / (n + 6.0));
                factor *= -square / ((n + 2.0) * (n + 3.0));
            }
            return sum;
        }
        let (sin, cos) = a.sin_cos();
        let square = a * a;
        let first = alpha * (sin - a * cos) / a;
        let second = beta * (2.0 * a * sin + (2.0 - square) * cos - 2.0) / square;
        let third = gamma
            * (-square * square * cos + 4.0 * ((3.0 * square - 6.0) * cos + (square - 6.0) * a * sin + 6.0))
            / (square * square);
        (first + second + third) / square
    }

    /// The factor for a scattering cosine of a sphere of size parameter `x` in its host.
    pub(super) fn at(&self, x: f64, cosine: f64) -> f64 {
        self.structure_factor(4.0 * x * (0.5 * (1.0 - cosine)).max(0.0).sqrt())
    }
}

/// Distance from face to face of neighbours in a random arrangement of spheres of a diameter (m) at a volume fraction, m:
/// `d (0.905 / f^(1/3) - 1)`, never negative (`hottel1971`).
pub fn clearance(diameter_m: f64, volume_fraction: f64) -> f64 {
    (diameter_m * (0.905 / volume_fraction.cbrt() - 1.0)).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::integrate;
    use std::convert::Infallible;
    use std::f64::consts::PI;

    /// Compressibility in the closed form, and no correlation where there is nobody.
    #[test]
    fn limits_are_known() {
        for fraction in [0.0f64, 0.01, 0.1, 0.3, 0.494] {
            let fluid = HardSpheres::new(fraction);
            let forward = (1.0 - fraction).powi(4) / (1.0 + 2.0 * fraction).powi(2);
            assert!((fluid.structure_factor(0.0) / forward - 1.0).abs() < 1e-12, "{fraction}");
            assert!((fluid.structure_factor(1e4) - 1.0).abs() < 1e-3);
            // The series joins the closed form.
            let (below, above) = (fluid.structure_factor(1.0 - 1e-9), fluid.structure_factor(1.0));
            assert!((below / above - 1.0).abs() < 1e-8, "{fraction}: {below} {above}");
        }
        // Lowest order in density: 1 - 24 f (sin a - a cos a)/a^3.
        let a = 2.5f64;
        let fluid = HardSpheres::new(1e-6);
        let expected = -24e-6 * (a.sin() - a * a.cos()) / a.powi(3);
        assert!(((fluid.structure_factor(a) - 1.0) / expected - 1.0).abs() < 1e-4);
    }

    /// What Percus and Yevick asked for: spheres do not overlap. `g(r)`, from the structure factor, is 0 within a diameter,
    /// and at contact `(1 + f/2)/(1 - f)^2`.
    #[test]
    fn spheres_do_not_overlap() {
        for fraction in [0.1, 0.3, 0.45] {
            let fluid = HardSpheres::new(fraction);
            // A window takes the ringing of the jump at contact away, and blurs it over 1/50 of a diameter.
            let blur = 0.02f64;
            let pair = |r: f64| {
                let f = |a: f64| {
                    let window = (-0.5 * (a * blur).powi(2)).exp();
                    Ok::<_, Infallible>([(fluid.structure_factor(a) - 1.0) * a * (a * r).sin() * window])
                };
                let knots: Vec<f64> = (0..=400).map(f64::from).collect();
                let integral = integrate(&knots, 1e-9, [1.0], f).unwrap().unwrap().value[0];
                // Spheres per cubic diameter: 6 f / pi.
                1.0 + integral / (2.0 * PI * PI * r) / (6.0 * fraction / PI)
            };
            for r in [0.2, 0.5, 0.9] {
                assert!(pair(r).abs() < 2e-3, "{fraction} {r}: {}", pair(r));
            }
            let contact = (1.0 + 0.5 * fraction) / (1.0 - fraction).powi(2);
            // Past the blur, extrapolated back to contact.
            let found = 2.0 * pair(1.06) - pair(1.12);
            assert!((found / contact - 1.0).abs() < 0.05, "{fraction}: {found} {contact}");
            assert!((pair(12.0) - 1.0).abs() < 0.02);
        }
    }

    #[test]
    fn neighbours_touch_where_they_are_dense() {
        assert_eq!(clearance(1e-6, 0.75), 0.0);
        assert!((clearance(1e-6, 0.006) / 3.98e-6 - 1.0).abs() < 0.01);
    }
}
