//! A homogeneous sphere in a host that may absorb: cross sections, asymmetry, forward amplitude.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::riccati::{Zeta, psi_ratios, series_order};
use super::{MieError, ScatteringDefinition};

/// What one sphere does to a plane wave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SphereScattering {
    /// Size parameter in the host, `2 pi r n_host / wavelength`; complex when the host absorbs.
    pub size_parameter: Complex64,
    /// Extinction cross section in m^2, relative to the host (eq 22 of `frisvad2007`); negative where the particle
    /// takes the place of a host that would have absorbed more.
    pub extinction: f64,
    /// Scattering cross section in m^2, never negative, by `definition`.
    pub scattering: f64,
    /// Absorption cross section in m^2: extinction minus scattering; never negative in a lossless host.
    pub absorption: f64,
    /// Mean cosine of scattering, in (-1, 1) (eq 26 of `frisvad2007`).
    pub asymmetry: f64,
    /// `S(0) / k^2` in m^2, with the complex wave number `k` of the host: what shifts the refractive index of a medium.
    pub forward: Complex64,
    /// How the scattering cross section is defined.
    pub definition: ScatteringDefinition,
}

/// Scattering by a sphere of radius `radius_m` (m) and refractive index `particle` in a host of index `host`, at the
/// vacuum wavelength `wavelength_m` (m).
///
/// Relative accuracy is about 1e-13 up to size parameters of 1e3 and degrades to about 1e-10 at 1e6, where the last bit
/// of the size parameter itself matters as much.
///
/// Source: `frisvad2007` section 2.1, with the signs of `zeta_n` made consistent; recurrences in the ratios of
/// successive orders ([`super::riccati`]).
///
/// # Errors
/// [`MieError`] when a length or index is out of range, when the modulus of either size parameter is outside
/// 1e-8..1e7, or when the host absorbs more than `exp(-700)` across the particle.
pub fn scatter_sphere(
    radius_m: f64,
    wavelength_m: f64,
    host: Complex64,
    particle: Complex64,
) -> Result<SphereScattering, MieError> {
    check_length("radius", radius_m)?;
    check_length("wavelength", wavelength_m)?;
    check_index("host", host)?;
    check_index("particle", particle)?;
    let k0r = 2.0 * PI * radius_m / wavelength_m;
    let (x, y) = (host * k0r, particle * k0r);
    for modulus in [x.norm(), y.norm()] {
        if !(1e-8..=1e7).contains(&modulus) {
            return Err(MieError::SizeParameter { modulus });
        }
    }
    if 2.0 * x.im > 700.0 {
        return Err(MieError::HostAbsorption { exponent: 2.0 * x.im });
    }
    Ok(cross_sections(wavelength_m, host, x, &sum_series(k0r, host, particle)))
}

fn check_length(name: &'static str, value_m: f64) -> Result<(), MieError> {
    if value_m > 0.0 && value_m.is_finite() { Ok(()) } else { Err(MieError::Length { name, value_m }) }
}

fn check_index(name: &'static str, n: Complex64) -> Result<(), MieError> {
    if n.re > 0.0 && n.im >= 0.0 && n.is_finite() { Ok(()) } else { Err(MieError::Index { name, re: n.re, im: n.im }) }
}

/// Sums over the orders, built from `a_n exp(2 i x)` and `b_n exp(2 i x)`, which never overflow.
#[derive(Default)]
struct Series {
    /// Sum of `(2n + 1)(a_n + b_n)`.
    forward: Complex64,
    /// Sum of `(2n + 1)(|a_n|^2 + |b_n|^2)`.
    scattering: f64,
    /// Sum of `(2n + 1)(Re a_n - |a_n|^2 + ...)`, free of cancellation; of meaning in a lossless host only.
    absorption: f64,
    /// Numerator of the asymmetry, eq 26.
    asymmetry: f64,
}

fn sum_series(k0r: f64, host: Complex64, particle: Complex64) -> Series {
    let (x, y) = (host * k0r, particle * k0r);
    let order = series_order(x.norm());
    let (mut rho_x, mut rho_y) = (Vec::new(), Vec::new());
    psi_ratios(x, order, &mut rho_x);
    psi_ratios(y, order, &mut rho_y);

    let relative = particle / host;
    // A_n(y) host - A_n(x) particle, with the leading terms of A_n collected.
    let contrast = (host - particle) * (host + particle) / (host * particle) / k0r;
    let (host_over_y, particle_over_x, inverse_x) = (relative.inv() / k0r, relative / k0r, x.inv());

    let mut zeta = Zeta::new(x);
    let mut series = Series::default();
    let mut previous = (Complex64::ZERO, Complex64::ZERO);
    for n in 1..=order {
        let (scaled_zeta, q) = zeta.advance();
        let (rx, ry, nf) = (rho_x[n], rho_y[n], n as f64);
        let b_minus_a = q - inverse_x * (2.0 * nf + 1.0) + rx;
        let psi_over_zeta = Complex64::I / (scaled_zeta * scaled_zeta * b_minus_a);
        let numerator_a = contrast * (nf + 1.0) - host * ry + particle * rx;
        let denominator_a = host_over_y * (nf + 1.0) + particle_over_x * nf - host * ry - particle * q;
        let numerator_b = host * rx - particle * ry;
        let denominator_b = Complex64::from((2.0 * nf + 1.0) / k0r) - particle * ry - host * q;
        let a = psi_over_zeta * numerator_a / denominator_a;
        let b = psi_over_zeta * numerator_b / denominator_b;

        let weight = 2.0 * nf + 1.0;
        series.forward += (a + b) * weight;
        series.scattering += weight * (a.norm_sqr() + b.norm_sqr());
        // Re a - |a|^2 = -Im L / |L zeta - zeta'|^2, L the logarithmic derivative that the particle imposes.
        let loss_a = -((host_over_y * (nf + 1.0) - host * ry) * particle.conj()).im / denominator_a.norm_sqr();
        let loss_b = (particle * ry).im * host.re / denominator_b.norm_sqr();
        series.absorption += weight * (loss_a + loss_b) / scaled_zeta.norm_sqr();
        let (a1, b1) = previous;
        series.asymmetry += (nf - 1.0) * (nf + 1.0) / nf * (a1 * a.conj() + b1 * b.conj()).re
            + weight / (nf * (nf + 1.0)) * (a * b.conj()).re;
        previous = (a, b);
        if n as f64 > x.norm() && a.norm_sqr().max(b.norm_sqr()) < 1e-36 * series.scattering {
            break;
        }
    }
    series
}

fn cross_sections(wavelength_m: f64, host: Complex64, x: Complex64, series: &Series) -> SphereScattering {
    let area = wavelength_m * wavelength_m / (2.0 * PI);
    let phase = (-2.0 * Complex64::I * x).exp();
    let forward = series.forward * phase / (host * host) * (area / (4.0 * PI));
    // |a_n|^2 exp(-alpha) / gamma with |a_n|^2 = |scaled|^2 exp(2 alpha): one ratio that neither overflows nor cancels.
    let scattering = area / host.norm_sqr() * series.scattering * surface_factor(2.0 * x.im);
    let (extinction, absorption) = if host.im == 0.0 {
        let absorption = area / host.norm_sqr() * series.absorption;
        (scattering + absorption, absorption)
    } else {
        let extinction = 4.0 * PI * forward.re;
        (extinction, extinction - scattering)
    };
    SphereScattering {
        size_parameter: x,
        extinction,
        scattering,
        absorption,
        asymmetry: 2.0 * series.asymmetry / series.scattering,
        forward,
        definition: ScatteringDefinition::Frisvad2007,
    }
}

/// `exp(alpha) / gamma(alpha)` with `gamma = 2 (1 + (alpha - 1) exp(alpha)) / alpha^2` (eq 24), that is
/// `alpha^2 / (2 (exp(-alpha) - 1 + alpha))`; 1 at `alpha = 0`.
fn surface_factor(alpha: f64) -> f64 {
    if alpha < 0.5 {
        // 2 (exp(-alpha) - 1 + alpha) / alpha^2 as its series; twelve terms leave less than 1e-17.
        let mut term = 1.0;
        let mut sum = 1.0;
        for k in 3..15 {
            term *= -alpha / f64::from(k);
            sum += term;
        }
        1.0 / sum
    } else {
        alpha * alpha / (2.0 * ((-alpha).exp() - 1.0 + alpha))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UM: f64 = 1e-6;

    fn c(re: f64, im: f64) -> Complex64 {
        Complex64::new(re, im)
    }

    fn close(value: f64, expected: f64, tolerance: f64) {
        assert!((value / expected - 1.0).abs() < tolerance, "{value:e} against {expected:e}");
    }

    /// Reference values by 50-digit arithmetic: (r, wavelength) um, host, particle, C_t um^2, C_s um^2, g, tolerance.
    #[test]
    fn agrees_with_arbitrary_precision() {
        let lossless = [
            (0.5, 0.55, c(1.33, 0.0), c(1.5, 0.0), 1.29872491436, 1.29872491436, 0.943794368628, 1e-9),
            (0.5, 0.55, c(1.33, 1e-3), c(1.5, 0.01), 1.31844491089, 1.1723481838, 0.945566175316, 1e-9),
            (5.0, 0.55, c(1.33, 1e-2), c(1.0, 0.0), 155.521741717, 69.9796068894, 0.7875514618, 1e-9),
            (0.001, 0.5, c(1.33, 0.0), c(1.5, 0.0), 4.51622859043e-15, 4.51622859043e-15, 4.69518573905e-5, 1e-9),
        ];
        for (r, wavelength, host, particle, extinction, scattering, g, tolerance) in lossless {
            let s = scatter_sphere(r * UM, wavelength * UM, host, particle).unwrap();
            close(s.extinction / (UM * UM), extinction, tolerance);
            close(s.scattering / (UM * UM), scattering, tolerance);
            close(s.asymmetry, g, tolerance);
        }
    }

    /// At `x = 10 pi` the start values of eq 20 vanish; the recurrences here have no such point.
    #[test]
    fn is_smooth_where_the_published_start_values_vanish() {
        let at = |x: f64| {
            let s = scatter_sphere(x / (2.0 * PI) * UM, UM, c(1.0, 0.0), c(1.5, 0.01)).unwrap();
            s.extinction
        };
        let x = 10.0 * PI;
        let h = 1e-6;
        let curvature_bound = 1e-4 * at(x);
        assert!((at(x) - 0.5 * (at(x - h) + at(x + h))).abs() < curvature_bound * h);
    }

    /// Rayleigh: eq 10.22 of the volume-scattering chapter with its second factor put right.
    #[test]
    fn small_spheres_follow_the_rayleigh_series() {
        let (host, particle) = (c(1.33, 0.0), c(1.5, 0.0));
        let m2 = (particle / host).powi(2);
        for x in [1e-7, 1e-5, 1e-3, 1e-2] {
            let r = x / (2.0 * PI * host.re) * UM;
            let s = scatter_sphere(r, UM, host, particle).unwrap();
            let rayleigh = 8.0 / 3.0 * x.powi(4) * ((m2 - 1.0) / (m2 + 2.0)).norm_sqr();
            let next = 1.0 + 1.2 * ((m2 - 2.0) / (m2 + 2.0)).re * x * x;
            close(s.scattering / (PI * r * r), rayleigh * next, 4.0 * x.powi(3) + 1e-13);
        }
    }

    /// Without absorption anywhere, extinction from the forward amplitude is the scattering summed over angles.
    #[test]
    fn the_optical_theorem_holds() {
        for x in [0.3, 3.0, 31.4159, 300.0, 1e4] {
            let s = scatter_sphere(x / (2.0 * PI) * UM, UM, c(1.0, 0.0), c(1.33, 0.0)).unwrap();
            close(4.0 * PI * s.forward.re, s.scattering, 1e-10);
            let s = scatter_sphere(x / (2.0 * PI) * UM, UM, c(1.0, 0.0), c(1.33, 0.1)).unwrap();
            close(4.0 * PI * s.forward.re, s.scattering + s.absorption, 1e-10);
        }
    }

    /// A weakly absorbing sphere: absorption is the volume times the coefficient, many digits below extinction.
    #[test]
    fn weak_absorption_keeps_its_digits() {
        let r = 1e-9;
        for im in [1e-14, 1e-10, 1e-6] {
            let s = scatter_sphere(r, 0.5 * UM, c(1.33, 0.0), c(1.33, im)).unwrap();
            close(s.absorption, 4.0 / 3.0 * PI * r.powi(3) * 4.0 * PI * im / (0.5 * UM), 1e-3);
        }
    }

    #[test]
    fn the_surface_factor_joins_its_series() {
        let gamma = |a: f64| 2.0 * (1.0 + (a - 1.0) * a.exp()) / (a * a);
        for a in [0.3f64, 0.4999, 0.5001, 2.0, 20.0] {
            close(surface_factor(a), a.exp() / gamma(a), 1e-12);
        }
        assert_eq!(surface_factor(0.0), 1.0);
        assert!(surface_factor(1e6).is_finite());
    }

    #[test]
    fn what_is_no_sphere_is_refused() {
        let ok = c(1.33, 0.0);
        assert!(matches!(scatter_sphere(-1.0, UM, ok, ok), Err(MieError::Length { name: "radius", .. })));
        assert!(matches!(scatter_sphere(UM, f64::NAN, ok, ok), Err(MieError::Length { name: "wavelength", .. })));
        assert!(matches!(scatter_sphere(UM, UM, c(0.0, 0.0), ok), Err(MieError::Index { name: "host", .. })));
        assert!(matches!(scatter_sphere(UM, UM, ok, c(1.5, -0.1)), Err(MieError::Index { name: "particle", .. })));
        assert!(matches!(scatter_sphere(1e9, UM, ok, ok), Err(MieError::SizeParameter { .. })));
        assert!(matches!(scatter_sphere(1e-3, UM, c(1.33, 1.0), ok), Err(MieError::HostAbsorption { .. })));
    }

    proptest::proptest! {
        #[test]
        fn results_are_finite_and_bounded(
            log_x in -7.0f64..3.5, re in 0.05f64..4.0, log_im in -12.0f64..1.0, host_log_im in -12.0f64..-2.0,
        ) {
            let r = 10f64.powf(log_x) / (2.0 * PI * 1.33) * UM;
            for host in [c(1.33, 0.0), c(1.33, 10f64.powf(host_log_im))] {
                for particle in [c(re, 0.0), c(re, 10f64.powf(log_im))] {
                    if let Ok(s) = scatter_sphere(r, UM, host, particle) {
                        proptest::prop_assert!(s.scattering >= 0.0 && s.scattering.is_finite());
                        proptest::prop_assert!(s.extinction.is_finite() && s.forward.is_finite());
                        proptest::prop_assert!(s.asymmetry.abs() <= 1.0, "g {}", s.asymmetry);
                        if host.im == 0.0 {
                            proptest::prop_assert!(s.absorption >= 0.0, "C_a {}", s.absorption);
                        }
                    }
                }
            }
        }
    }
}
