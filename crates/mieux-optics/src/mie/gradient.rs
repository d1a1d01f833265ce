//! Exact derivatives of cross sections and asymmetry.

use std::f64::consts::PI;

use num_complex::Complex64;
use pulp::{Simd, WithSimd};

use super::kernel::{Sink, Slopes, Term};
use super::sphere::{Series, Sphere, single};
use super::sums::{SphereSums, Sums};
use super::wave::SphereScattering;
use super::weights::Weight;
use super::{MieError, ScatteringDefinition};
use crate::lanes::{Cx, Re};

/// Derivatives by one quantity; cross sections in m^2 per its unit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Slope {
    /// Of the extinction cross section.
    pub extinction: f64,
    /// Of the scattering cross section.
    pub scattering: f64,
    /// Of the absorption cross section.
    pub absorption: f64,
    /// Of the asymmetry.
    pub asymmetry: f64,
}

/// A sphere's scattering and its derivatives by all that the sphere is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SphereGradient {
    /// The scattering itself.
    pub scattering: SphereScattering,
    /// By the radius, 1/m.
    pub radius: Slope,
    /// By the vacuum wavelength, 1/m, the indices held.
    pub wavelength: Slope,
    /// By the real part of the index of the host.
    pub host_re: Slope,
    /// By the imaginary part of the index of the host.
    pub host_im: Slope,
    /// By the real part of the index of the particle.
    pub particle_re: Slope,
    /// By the imaginary part of the index of the particle.
    pub particle_im: Slope,
}

impl Sphere {
    /// Cross sections and asymmetry with their exact derivatives, from those of every coefficient in closed form.
    ///
    /// A derivative of the absorption is the difference of those of extinction and scattering: as accurate as the larger
    /// of these.
    ///
    /// # Errors
    /// [`MieError::Cancellation`] as for [`Sphere::scattering`].
    pub fn gradient(&self) -> Result<SphereGradient, MieError> {
        let (sums, slopes, scaled) = pulp::Arch::new().dispatch(SumSlopes(self));
        let scattering = self.wave.cross_sections(self.k0r, &sums, scaled)?;
        let chain = Chain { sphere: self, sums, slopes, scaled, scattering };
        let (k0r, x, y) = (self.k0r, self.wave.host() * self.k0r, self.index * self.k0r);
        let (radius, wavelength) = (k0r * self.wave.wavelength() / (2.0 * PI), self.wave.wavelength());
        let zero = Complex64::ZERO;
        let along = |dx: Complex64, dy: Complex64, host: Complex64, wavelength: f64| {
            chain.slope(&Along { x: dx, y: dy, host, wavelength })
        };
        let (one, i) = (Complex64::ONE, Complex64::I);
        Ok(SphereGradient {
            scattering,
            radius: along(x / radius, y / radius, zero, 0.0),
            wavelength: along(-x / wavelength, -y / wavelength, zero, 1.0),
            host_re: along(one * k0r, zero, one, 0.0),
            host_im: along(i * k0r, zero, i, 0.0),
            particle_re: along(zero, one * k0r, zero, 0.0),
            particle_im: along(zero, i * k0r, zero, 0.0),
        })
    }
}

/// How everything moves with the quantity that is varied.
struct Along {
    x: Complex64,
    y: Complex64,
    host: Complex64,
    wavelength: f64,
}

/// Sums of derivatives by `x` and by `y`: of the amplitude, and of scattering and asymmetry as if conjugates were constant.
struct SlopeSums {
    forward: [Complex64; 2],
    scattering: [Complex64; 2],
    asymmetry: [Complex64; 2],
}

struct Chain<'a> {
    sphere: &'a Sphere,
    sums: SphereSums,
    slopes: SlopeSums,
    scaled: bool,
    scattering: SphereScattering,
}

impl Chain<'_> {
    fn slope(&self, d: &Along) -> Slope {
        let Self { sphere, sums, slopes, .. } = self;
        let (wave, host) = (&sphere.wave, sphere.wave.host());
        let total = |z: &[Complex64; 2]| z[0] * d.x + z[1] * d.y;
        let x = host * sphere.k0r;
        let factor = if self.scaled { (-2.0 * Complex64::I * x).exp() } else { Complex64::ONE };
        let area = wave.area();
        // Relative changes of the area.
        let grown = 2.0 * d.wavelength / wave.wavelength() - 2.0 * (host.conj() * d.host).re / host.norm_sqr();

        let (amplitude, d_amplitude) = (sums.forward * factor, total(&slopes.forward) * factor);
        let d_extinction = match wave.definition() {
            ScatteringDefinition::Frisvad2007 => {
                let turn = host.conj() / host;
                (d_amplitude * turn + amplitude * (d.host.conj() - turn * d.host) / host).re
            }
            ScatteringDefinition::MishchenkoYang2018 => {
                let tilt = host.im / host.re;
                let d_tilt = (d.host.im - tilt * d.host.re) / host.re;
                d_amplitude.re + tilt * d_amplitude.im + d_tilt * amplitude.im
            }
        };
        let (surface, d_surface) = wave.surface(2.0 * x.im, self.scaled);
        let d_sum = 2.0 * total(&slopes.scattering).re;
        let d_scattering = d_sum * surface + sums.scattering * d_surface * 2.0 * d.x.im;
        let asymmetry = self.scattering.asymmetry;
        let extinction = self.scattering.extinction * grown + area * d_extinction;
        let scattering = self.scattering.scattering * grown + area * d_scattering;
        Slope {
            extinction,
            scattering,
            absorption: extinction - scattering,
            asymmetry: if sums.scattering > 0.0 {
                (2.0 * total(&slopes.asymmetry).re - asymmetry * d_sum) / sums.scattering
            } else {
                0.0
            },
        }
    }
}

/// Sums coefficients and their derivatives.
struct SumsAndSlopes<S: Simd, const SCALED: bool> {
    sums: Sums<S, SCALED>,
    now: Slopes<S>,
    before: Option<(Slopes<S>, Cx<S>, Cx<S>)>,
    forward: [Cx<S>; 2],
    scattering: [Cx<S>; 2],
    asymmetry: [Cx<S>; 2],
}

impl<S: Simd, const SCALED: bool> SumsAndSlopes<S, SCALED> {
    #[inline(always)]
    fn new(simd: S) -> Self {
        let zero = Cx { re: Re::splat(simd, 0.0), im: Re::splat(simd, 0.0) };
        let now = Slopes { a: [zero; 2], b: [zero; 2] };
        let sums = Sums::new(simd);
        Self { sums, now, before: None, forward: [zero; 2], scattering: [zero; 2], asymmetry: [zero; 2] }
    }

    fn finish(self) -> (SphereSums, SlopeSums) {
        let first = |z: [Cx<S>; 2]| z.map(|z| Complex64::new(z.re.lanes()[0], z.im.lanes()[0]));
        let slopes = SlopeSums {
            forward: first(self.forward),
            scattering: first(self.scattering),
            asymmetry: first(self.asymmetry),
        };
        (self.sums.finish().lane(0), slopes)
    }
}

/// `conj(value) * slope`
#[inline(always)]
fn along<S: Simd>(value: Cx<S>, slope: Cx<S>) -> Cx<S> {
    Cx { re: slope.dot(value), im: slope.cross(value) }
}

impl<S: Simd, const SCALED: bool> Sink<S> for SumsAndSlopes<S, SCALED> {
    const SLOPES: bool = true;

    #[inline(always)]
    fn take_slopes(&mut self, slopes: Slopes<S>) {
        self.now = slopes;
    }

    #[inline(always)]
    fn take(&mut self, weight: &Weight, term: Term<S>) {
        let Term { a, b, loss, .. } = term;
        let real = |value| loss.same(value);
        let (factor, neighbours, pair) = (real(weight.factor), real(weight.neighbours), real(weight.pair));
        let Slopes { a: da, b: db } = self.now;
        for k in 0..2 {
            self.forward[k] = self.forward[k] + scaled(da[k] + db[k], factor);
            self.scattering[k] = self.scattering[k] + scaled(along(a, da[k]) + along(b, db[k]), factor);
            let mut asymmetry = scaled(along(b, da[k]) + along(a, db[k]), pair);
            if let Some((Slopes { a: da0, b: db0 }, a0, b0)) = self.before {
                let beside = along(a, da0[k]) + along(a0, da[k]) + along(b, db0[k]) + along(b0, db[k]);
                asymmetry = asymmetry + scaled(beside, neighbours);
            }
            self.asymmetry[k] = self.asymmetry[k] + asymmetry;
        }
        self.before = Some((self.now, a, b));
        self.sums.take(weight, term);
    }

    #[inline(always)]
    fn pause(&mut self) {
        self.sums.pause();
    }
}

#[inline(always)]
fn scaled<S: Simd>(z: Cx<S>, factor: Re<S>) -> Cx<S> {
    Cx { re: z.re * factor, im: z.im * factor }
}

struct SumSlopes<'a>(&'a Sphere);

impl WithSimd for SumSlopes<'_> {
    type Output = (SphereSums, SlopeSums, bool);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let (class, group) = single(self.0);
        let class = class.downward();
        let group = group(class);
        let mut series = Series::new(simd);
        let (sums, slopes) = if class.scaled() {
            let mut sums = SumsAndSlopes::<S, true>::new(simd);
            series.run(class, &group, &mut sums);
            sums.finish()
        } else {
            let mut sums = SumsAndSlopes::<S, false>::new(simd);
            series.run(class, &group, &mut sums);
            sums.finish()
        };
        (sums, slopes, class.scaled())
    }
}

#[cfg(test)]
mod tests {
    use super::super::PlaneWave;
    use super::*;

    /// What a sphere is made of, in the order of the slopes.
    type Inputs = [f64; 6];

    fn sphere([radius, wavelength, host_re, host_im, re, im]: Inputs, definition: ScatteringDefinition) -> Sphere {
        let wave = PlaneWave::new(wavelength, Complex64::new(host_re, host_im)).unwrap().with_definition(definition);
        Sphere::new(wave, radius, Complex64::new(re, im)).unwrap()
    }

    fn values(s: &SphereScattering) -> [f64; 4] {
        [s.extinction, s.scattering, s.absorption, s.asymmetry]
    }

    /// Central differences of fourth order.
    fn difference(inputs: Inputs, k: usize, h: f64, definition: ScatteringDefinition) -> [f64; 4] {
        let at = |steps: f64| {
            let mut moved = inputs;
            moved[k] += steps * h;
            values(&sphere(moved, definition).scattering().unwrap())
        };
        let (p1, m1, p2, m2) = (at(1.0), at(-1.0), at(2.0), at(-2.0));
        std::array::from_fn(|i| (8.0 * (p1[i] - m1[i]) - (p2[i] - m2[i])) / (12.0 * h))
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        let cases: [Inputs; 7] = [
            [0.5e-6, 0.55e-6, 1.33, 1e-3, 1.5, 0.01],
            [3e-6, 0.55e-6, 1.33, 0.02, 1.1, 0.03],
            [0.02e-6, 0.55e-6, 1.33, 1e-3, 1.46, 1e-3],
            [1e-6, 0.55e-6, 1.0, 1e-3, 0.2, 3.0],
            [10e-6, 0.55e-6, 1.33, 0.05, 1.5, 0.01],
            [0.5e-6, 0.55e-6, 1.33, 1e-3, 1.3301, 1.1e-3],
            [5e-6, 0.55e-6, 1.33, 0.1, 1.5, 0.0101],
        ];
        for definition in [ScatteringDefinition::Frisvad2007, ScatteringDefinition::MishchenkoYang2018] {
            for inputs in cases {
                let g = sphere(inputs, definition).gradient().unwrap();
                let slopes = [g.radius, g.wavelength, g.host_re, g.host_im, g.particle_re, g.particle_im];
                for (k, slope) in slopes.iter().enumerate() {
                    let h = 1e-4 * if k < 2 { inputs[k] } else { inputs[k].abs().clamp(1e-3, 0.1) };
                    let expected = difference(inputs, k, h, definition);
                    let found = [slope.extinction, slope.scattering, slope.absorption, slope.asymmetry];
                    let size = values(&g.scattering).map(|v| v.abs() / inputs[k].abs().max(1e-2));
                    for i in 0..4 {
                        let scale = expected[i].abs() + 1e-3 * size[i];
                        let error = (found[i] - expected[i]).abs() / scale;
                        assert!(error < 2e-6, "{inputs:?} input {k} output {i}: {} {}", found[i], expected[i]);
                    }
                }
            }
        }
    }

    /// `C_s` of a small lossless sphere goes with the sixth power of the radius, `C_a` with its volume and with `n''`.
    #[test]
    fn small_spheres_follow_their_powers() {
        let inputs = [1e-9, 0.5e-6, 1.33, 0.0, 1.5, 1e-8];
        let g = sphere(inputs, ScatteringDefinition::Frisvad2007).gradient().unwrap();
        let relative = |slope: f64, value: f64, at: f64| slope * at / value;
        assert!((relative(g.radius.scattering, g.scattering.scattering, inputs[0]) - 6.0).abs() < 2e-3);
        assert!((relative(g.wavelength.scattering, g.scattering.scattering, inputs[1]) + 4.0).abs() < 2e-3);
        assert!((relative(g.particle_im.absorption, g.scattering.absorption, inputs[5]) - 1.0).abs() < 1e-3);
    }
}
