//! The multipole: a dipole between two surfaces, mirrored in both again and again.

use std::f64::consts::PI;

use super::source::{decay, potential};
use super::{Boundary, DiffusionMedium};
use crate::transfer::TransferError;
use crate::transfer::fresnel::DiffuseReflectance;

/// Diffuse reflectance and transmittance of a slab after `donner2005`. As the classical dipole, which it becomes when
/// thick, it holds all scattering from the first on.
///
/// The sums over images are complete: below half a (extrapolated) thickness from the axis 64 images and an
/// Euler-Maclaurin remainder, beyond it the series of the slab's modes. Good from about four transport mean free paths
/// of thickness and two of distance on; what passes unscattered is not told apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Multipole {
    albedo: f64,
    sigma_tr: f64,
    thickness: f64,
    /// Depth of the source.
    depth: f64,
    /// Heights over the surfaces at which fluence vanishes: above and below, m.
    beyond: [f64; 2],
}

/// Images on each side, then the remainder.
const IMAGES: u32 = 64;

impl Multipole {
    /// A slab of a medium, `thickness` (m) thick, of relative index `eta_below` against what lies below it.
    ///
    /// # Errors
    /// [`TransferError::Thickness`] unless the slab is thicker than one transport mean free path, where the source stands;
    /// [`TransferError::RefractiveIndex`].
    pub fn new(
        medium: &DiffusionMedium,
        thickness: f64,
        eta_below: f64,
        boundary: Boundary,
    ) -> Result<Self, TransferError> {
        let depth = 1.0 / medium.reduced_extinction();
        if !(thickness > depth && thickness.is_finite()) {
            return Err(TransferError::Thickness { value: thickness, least: depth });
        }
        let below = (0.1..=10.0).contains(&eta_below).then(|| DiffuseReflectance::new(eta_below)).flatten();
        let below = below.ok_or(TransferError::RefractiveIndex { value: eta_below })?;
        let below = match boundary {
            Boundary::Exact => below.extrapolation(),
            Boundary::Groenhuis => below.extrapolation_groenhuis(),
        };
        let diffusion = medium.diffusion_coefficient();
        Ok(Self {
            albedo: medium.reduced_albedo(),
            sigma_tr: medium.transport_coefficient(diffusion),
            thickness,
            depth,
            beyond: [2.0 * medium.boundary(boundary) * diffusion, 2.0 * below * diffusion],
        })
    }

    /// Power that leaves upward per area at the distance `r` (m, from 0 up) from where light of power 1 has entered along
    /// the normal, 1/m^2.
    pub fn reflectance(&self, r: f64) -> f64 {
        let [above, _] = self.beyond;
        if r < 0.5 * self.between() {
            return self.images(r, self.depth, self.depth + 2.0 * above);
        }
        self.modes(r, above, self.depth + above)
    }

    /// The same through the lower surface.
    pub fn transmittance(&self, r: f64) -> f64 {
        let [above, below] = self.beyond;
        if r < 0.5 * self.between() {
            // The second pair is the negative images seen from below.
            let image = self.thickness + self.depth + 2.0 * above;
            return self.images(r, self.thickness - self.depth, -image);
        }
        self.modes(r, below, self.between() - self.depth - above)
    }

    /// The integral of [`Multipole::reflectance`] over the surface.
    pub fn total_reflectance(&self) -> f64 {
        let [above, below] = self.beyond;
        self.albedo * self.shared(above, self.thickness + below - self.depth)
    }

    /// The integral of [`Multipole::transmittance`] over the surface.
    pub fn total_transmittance(&self) -> f64 {
        let [above, below] = self.beyond;
        self.albedo * self.shared(below, self.depth + above)
    }

    /// Distance between the planes where fluence vanishes.
    fn between(&self) -> f64 {
        self.thickness + self.beyond[0] + self.beyond[1]
    }

    /// `cosh(sigma beyond) sinh(sigma far) / sinh(sigma L)`: one-dimensional diffusion.
    fn shared(&self, beyond: f64, far: f64) -> f64 {
        let (sigma, length) = (self.sigma_tr, self.between());
        let least = 1e-8;
        if sigma * length < least {
            return far / length;
        }
        let rises = -(-2.0 * sigma * far).exp_m1() / -(-2.0 * sigma * length).exp_m1();
        // exp(sigma (beyond + far - length)) never overflows: both lie within the length.
        0.5 * rises * ((sigma * (beyond + far - length)).exp() + (sigma * (far - length - beyond)).exp())
    }

    /// Two series of images, of offsets `first` and `second`.
    fn images(&self, r: f64, first: f64, second: f64) -> f64 {
        let sum = self.odd(r, first) + self.odd(r, second);
        self.albedo / (4.0 * PI) * sum
    }

    /// The sum of the flux of sources at the offset `a` and every even multiple of the length from it.
    fn odd(&self, r: f64, a: f64) -> f64 {
        let (sigma, period) = (self.sigma_tr, 2.0 * self.between());
        let flux = |z: f64| super::source::flux(z, r.hypot(z), sigma);
        let mut sum = flux(a);
        for image in 1..=IMAGES {
            let z = period * f64::from(image);
            let pair = flux(z + a) - flux(z - a);
            sum += pair;
            if pair.abs() < 1e-18 * sum.abs() {
                return sum;
            }
        }
        // What is left is a sum of a slow function: its integral, and 1/24 of its slope.
        let z = period * (f64::from(IMAGES) + 0.5);
        let integral = |z: f64| potential(r.hypot(z), sigma);
        let slope = |z: f64| {
            let d = r.hypot(z);
            let x = sigma * d;
            let decayed = decay(x);
            (decayed - (z / d).powi(2) * (3.0 * decayed + x * x * (-x).exp())) / d.powi(3)
        };
        let rest = (integral(z + a) - integral(z - a)) / period + period / 24.0 * (slope(z + a) - slope(z - a));
        sum + rest
    }

    /// The series of modes that vanish on both planes: their flux at a surface `beyond` behind one of them, of a source
    /// at a distance `source` from the same.
    fn modes(&self, r: f64, beyond: f64, source: f64) -> f64 {
        let length = self.between();
        let mut sum = 0.0;
        for mode in 1..=100u32 {
            let n = f64::from(mode);
            let wave = n * PI / length;
            let radial = modified_bessel_k0(self.sigma_tr.hypot(wave) * r);
            sum += n * (wave * beyond).cos() * (wave * source).sin() * radial;
            if radial * n * n < 1e-18 * sum.abs() || radial == 0.0 {
                break;
            }
        }
        self.albedo * sum / (length * length)
    }
}

/// `K_0(x)` for `x` from about 0.1 up, to 1e-14: the trapezoidal rule on `Int exp(-x cosh t) dt`, which converges faster
/// than any power of the step.
fn modified_bessel_k0(x: f64) -> f64 {
    const STEP: f64 = 0.1;
    let mut sum = 0.5;
    for k in 1..200 {
        let t = STEP * f64::from(k);
        // cosh t - 1
        let term = (-2.0 * x * (0.5 * t).sinh().powi(2)).exp();
        sum += term;
        if term < 1e-18 {
            break;
        }
    }
    STEP * sum * (-x).exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::diffusion::{Dipole, radial, testing};

    fn slab(medium: &DiffusionMedium, paths: f64, below: f64) -> Multipole {
        Multipole::new(medium, paths / medium.reduced_extinction(), below, Boundary::Exact).unwrap()
    }

    /// Values of `abramowitz1964`, table 9.8.
    #[test]
    fn bessel() {
        for (x, value) in [(0.2, 1.752_703_855_528_14), (1.0, 0.421_024_438_240_708), (5.0, 3.691_098_334_042_6e-3)] {
            assert!((modified_bessel_k0(x) / value - 1.0).abs() < 1e-12, "{x}: {}", modified_bessel_k0(x));
        }
    }

    #[test]
    fn images_and_modes_are_the_same() {
        for medium in testing::media().into_iter().filter(|m| m.reduced_albedo() > 0.0) {
            for paths in [1.001, 1.7, 6.0, 40.0] {
                let slab = slab(&medium, paths, 1.2);
                let [above, below] = slab.beyond;
                for part in [0.35, 0.5, 0.8] {
                    let r = part * slab.between();
                    let up = slab.images(r, slab.depth, slab.depth + 2.0 * above);
                    let image = slab.thickness + slab.depth + 2.0 * above;
                    let down = slab.images(r, slab.thickness - slab.depth, -image);
                    let scale = up.abs().max(down.abs());
                    let source = slab.depth + above;
                    let modes = slab.modes(r, above, source);
                    assert!((modes - up).abs() < 2e-11 * scale, "{medium:?} {paths} {part}: {up} {modes}");
                    let modes = slab.modes(r, below, slab.between() - source);
                    assert!((modes - down).abs() < 2e-11 * scale, "{medium:?} {paths} {part}: {down} {modes}");
                }
            }
        }
    }

    #[test]
    fn totals_are_integrals_and_add_up() {
        for medium in testing::media().into_iter().filter(|m| m.reduced_albedo() > 0.0) {
            for paths in [1.01, 3.0, 20.0] {
                let slab = slab(&medium, paths, 1.0);
                let length = 1.0 / medium.reduced_extinction();
                let sigma = slab.sigma_tr.hypot(PI / slab.between());
                for (total, integral) in [
                    (slab.total_reflectance(), radial::area_integral(|r| slab.reflectance(r), length, sigma)),
                    (slab.total_transmittance(), radial::area_integral(|r| slab.transmittance(r), length, sigma)),
                ] {
                    assert!((total - integral).abs() < 1e-9, "{medium:?} {paths}: {total} {integral}");
                }
                let sum = slab.total_reflectance() + slab.total_transmittance();
                if medium.sigma_a() == 0.0 {
                    assert!((sum - 1.0).abs() < 1e-14, "{sum}");
                } else {
                    assert!(sum < 1.0 && sum > 0.0, "{sum}");
                }
            }
        }
    }

    #[test]
    fn a_thick_slab_is_a_dipole() {
        for medium in testing::media() {
            for boundary in [Boundary::Exact, Boundary::Groenhuis] {
                let length = 1.0 / medium.reduced_extinction();
                let thick = Multipole::new(&medium, 1e7 * length, 1.5, boundary).unwrap();
                let dipole = Dipole::new(&medium, boundary);
                assert!((thick.total_reflectance() - dipole.total()).abs() < 1e-6);
                for r in [0.0, 0.3, 4.0, 100.0] {
                    let (a, b) = (thick.reflectance(r * length), dipole.reflectance(r * length));
                    assert!((a - b).abs() <= 1e-10 * b, "{medium:?} {r}: {a} {b}");
                }
            }
        }
    }

    #[test]
    fn what_is_too_thin_is_refused() {
        let medium = DiffusionMedium::new(0.0, 100.0, 0.0, 1.3).unwrap();
        let message = Multipole::new(&medium, 0.009, 1.3, Boundary::Exact).unwrap_err().to_string();
        assert!(message.contains("0.009") && message.contains("0.01"), "{message}");
        assert!(Multipole::new(&medium, f64::NAN, 1.3, Boundary::Exact).is_err());
        assert!(Multipole::new(&medium, 1.0, 0.0, Boundary::Exact).is_err());
    }
}
