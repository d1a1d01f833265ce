//! Homogeneous spheres in a host that may absorb: cross sections, asymmetry, forward amplitude.

use std::cmp::Ordering;
use std::f64::consts::PI;

use num_complex::Complex64;
use pulp::{Simd, WithSimd};

use super::elementary::NARROW;
use super::host::{Absorbing, Lossless, Opaque};
use super::kernel::{Group, downward, upward};
use super::lanes::MAX_LANES;
use super::sums::{SphereSums, Sums};
use super::weights::Weights;
use super::{MieError, ScatteringDefinition};

/// One homogeneous sphere in a plane wave; everything in it has been checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    wavelength: f64,
    /// Vacuum wave number times radius.
    k0r: f64,
    host: Complex64,
    particle: Complex64,
}

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

impl SphereScattering {
    /// By nothing at all.
    fn none(definition: ScatteringDefinition) -> Self {
        Self {
            size_parameter: Complex64::ZERO,
            extinction: 0.0,
            scattering: 0.0,
            absorption: 0.0,
            asymmetry: 0.0,
            forward: Complex64::ZERO,
            definition,
        }
    }
}

impl Sphere {
    /// A sphere of radius `radius` (m) and refractive index `particle` in a host of index `host`, lit at the vacuum
    /// wavelength `wavelength` (m).
    ///
    /// # Errors
    /// [`MieError`] when a length is not positive and finite, an index outside the range it names, the modulus of
    /// either size parameter outside 1e-8..1e7, or when the host absorbs more than `exp(-700)` across the particle.
    pub fn new(radius: f64, wavelength: f64, host: Complex64, particle: Complex64) -> Result<Self, MieError> {
        check_length("radius", radius)?;
        check_length("wavelength", wavelength)?;
        check_index("host", host)?;
        check_index("particle", particle)?;
        let sphere = Self { wavelength, k0r: 2.0 * PI * radius / wavelength, host, particle };
        let (x, y) = sphere.size_parameters();
        for modulus in [x.norm(), y.norm()] {
            if !(1e-8..=1e7).contains(&modulus) {
                return Err(MieError::SizeParameter { modulus });
            }
        }
        if 2.0 * x.im > 700.0 {
            return Err(MieError::HostAbsorption { exponent: 2.0 * x.im });
        }
        Ok(sphere)
    }

    /// In the host and in the particle.
    fn size_parameters(&self) -> (Complex64, Complex64) {
        (self.host * self.k0r, self.particle * self.k0r)
    }
}

fn check_length(name: &'static str, value_m: f64) -> Result<(), MieError> {
    if value_m > 0.0 && value_m.is_finite() { Ok(()) } else { Err(MieError::Length { name, value_m }) }
}

fn check_index(name: &'static str, n: Complex64) -> Result<(), MieError> {
    let possible = n.re > 0.0 && n.im >= 0.0 && (1e-6..=1e6).contains(&n.norm());
    if possible { Ok(()) } else { Err(MieError::Index { name, re: n.re, im: n.im }) }
}

/// Scattering by one sphere: [`Sphere::new`] and [`scatter_spheres`] in one.
///
/// # Errors
/// As for [`Sphere::new`].
pub fn scatter_sphere(
    radius_m: f64,
    wavelength_m: f64,
    host: Complex64,
    particle: Complex64,
) -> Result<SphereScattering, MieError> {
    let sphere = Sphere::new(radius_m, wavelength_m, host, particle)?;
    let mut out = Vec::with_capacity(1);
    scatter_spheres(&[sphere], ScatteringDefinition::default(), &mut out);
    Ok(out[0])
}

/// Order beyond which the terms of a series in size parameter `modulus` no longer count.
///
/// Beyond the edge `n = |x|` coefficients fall like `exp(-1.886 p^(3/2))` with `p = (n - |x|) / |x|^(1/3)`, which is eq
/// 19 of `frisvad2007` with 7.25 (1e-16) where 4.3 gave 1e-8.
fn series_order(modulus: f64) -> usize {
    (modulus + 7.25 * modulus.cbrt() + 3.0) as usize
}

/// Order from which a downward recurrence in `z` forgets its start before it reaches `order`.
fn start_order(z: Complex64, order: usize) -> usize {
    let top = series_order(z.norm()).max(order) + 16;
    let nu = order as f64 + 0.5;
    if z.im > 0.0 && nu < z.norm() {
        // Per order the dominated solution shrinks by exp(-2 |Im theta|) against the other, where cos theta = nu / z.
        let theta = (nu / z).acos();
        let steps = 20.0 / theta.im.abs();
        if steps < top as f64 {
            return top.min(order + 16 + steps as usize);
        }
    }
    top
}

/// How a sphere's series is summed; spheres of one class go abreast. Small ones first, as input often comes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Class {
    LosslessDown,
    LosslessUp,
    AbsorbingDown,
    AbsorbingUp,
    Opaque,
}

/// A sphere's place in the order in which spheres are put abreast.
#[derive(Debug, Clone, Copy)]
struct Member {
    class: Class,
    index: u32,
    /// Modulus of the size parameter.
    size: f64,
}

impl Member {
    fn new(index: usize, sphere: &Sphere) -> Self {
        let (x, y) = sphere.size_parameters();
        let square = x.norm_sqr();
        let up = x.re > 1.5 && y.im < NARROW && y.norm_sqr() >= square;
        let class = match (x.im, up) {
            (0.0, true) => Class::LosslessUp,
            (0.0, false) => Class::LosslessDown,
            (im, true) if im < NARROW => Class::AbsorbingUp,
            (im, false) if im < NARROW => Class::AbsorbingDown,
            _ => Class::Opaque,
        };
        Self { class, index: index as u32, size: square.sqrt() }
    }

    fn order(&self, other: &Self) -> Ordering {
        self.class.cmp(&other.class).then(self.size.total_cmp(&other.size))
    }
}

fn group(spheres: &[Sphere], members: &[Member]) -> Group {
    let mut group = Group {
        k0r: [0.0; MAX_LANES],
        host_re: [0.0; MAX_LANES],
        host_im: [0.0; MAX_LANES],
        particle_re: [0.0; MAX_LANES],
        particle_im: [0.0; MAX_LANES],
        order: series_order(members[members.len() - 1].size),
        start: [0; 2],
        smallest: f64::INFINITY,
    };
    for lane in 0..MAX_LANES {
        let sphere = &spheres[members[lane.min(members.len() - 1)].index as usize];
        group.k0r[lane] = sphere.k0r;
        group.host_re[lane] = sphere.host.re;
        group.host_im[lane] = sphere.host.im;
        group.particle_re[lane] = sphere.particle.re;
        group.particle_im[lane] = sphere.particle.im;
    }
    if !matches!(members[0].class, Class::LosslessUp | Class::AbsorbingUp) {
        for member in members {
            let (x, y) = spheres[member.index as usize].size_parameters();
            for (start, z) in group.start.iter_mut().zip([x, y]) {
                *start = start_order(z, group.order).max(*start);
                group.smallest = group.smallest.min(z.norm());
            }
        }
    }
    group
}

/// Scattering by many spheres, appended to `out` in their order. One thread, several spheres abreast in vector
/// registers: neighbours in size go together, so any order of input will do.
///
/// Source: `frisvad2007` section 2.1 with the signs of `zeta_n` made consistent.
pub fn scatter_spheres(spheres: &[Sphere], definition: ScatteringDefinition, out: &mut Vec<SphereScattering>) {
    pulp::Arch::new().dispatch(ScatterSpheres { spheres, definition, out });
}

struct ScatterSpheres<'a> {
    spheres: &'a [Sphere],
    definition: ScatteringDefinition,
    out: &'a mut Vec<SphereScattering>,
}

impl WithSimd for ScatterSpheres<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { spheres, definition, out } = self;
        let mut members: Vec<Member> = spheres.iter().enumerate().map(|(i, s)| Member::new(i, s)).collect();
        if !members.is_sorted_by(|a, b| a.order(b).is_le()) {
            members.sort_unstable_by(Member::order);
        }
        let first = out.len();
        out.resize(first + spheres.len(), SphereScattering::none(definition));
        let out = &mut out[first..];
        let mut weights = Weights::new();
        let (mut real, mut complex) = (Vec::new(), Vec::new());
        for class in members.chunk_by(|a, b| a.class == b.class) {
            let scaled = class[0].class == Class::Opaque;
            for members in class.chunks(S::F64_LANES) {
                let group = &group(spheres, members);
                let (mut plain, mut far) = (Sums::<S, false>::new(simd), Sums::<S, true>::new(simd));
                let weights = &mut weights;
                match members[0].class {
                    Class::LosslessUp => upward::<S, Lossless>(simd, group, weights, &mut plain),
                    Class::LosslessDown => downward::<S, Lossless>(simd, group, weights, &mut real, &mut plain),
                    Class::AbsorbingUp => upward::<S, Absorbing>(simd, group, weights, &mut plain),
                    Class::AbsorbingDown => downward::<S, Absorbing>(simd, group, weights, &mut complex, &mut plain),
                    Class::Opaque => downward::<S, Opaque>(simd, group, weights, &mut complex, &mut far),
                }
                let sums = if scaled { far.finish() } else { plain.finish() };
                for (lane, member) in members.iter().enumerate() {
                    let i = member.index as usize;
                    out[i] = cross_sections(&spheres[i], &sums.lane(lane), scaled, definition);
                }
            }
        }
    }
}

/// Cross sections from sums; `scaled` says that every coefficient lacks a factor of `exp(-2 i x)`.
fn cross_sections(
    sphere: &Sphere,
    sums: &SphereSums,
    scaled: bool,
    definition: ScatteringDefinition,
) -> SphereScattering {
    let host = sphere.host;
    let (x, _) = sphere.size_parameters();
    let area = sphere.wavelength * sphere.wavelength / (2.0 * PI * host.norm_sqr());
    let asymmetry = if sums.scattering > 0.0 { 2.0 * sums.asymmetry / sums.scattering } else { 0.0 };
    let (extinction, scattering, absorption, forward);
    if scaled {
        let turn = host.conj() / host;
        forward = sums.forward * (-2.0 * Complex64::I * x).exp() * turn * (area / (4.0 * PI));
        extinction = 4.0 * PI * forward.re;
        scattering = area * sums.scattering * (1.0 + surface_excess(2.0 * x.im));
        absorption = extinction - scattering;
    } else {
        let (excess, turned) = if x.im == 0.0 { (0.0, Complex64::ZERO) } else { host_effects(host, x, sums.forward) };
        // The real part of the amplitude less the scattering, with their leading terms, which cancel, left out.
        scattering = area * sums.scattering * (1.0 + excess);
        absorption = area * (sums.loss + turned.re - excess * sums.scattering);
        extinction = scattering + absorption;
        forward = Complex64::new(extinction, area * (sums.forward.im + turned.im)) / (4.0 * PI);
    }
    SphereScattering { size_parameter: x, extinction, scattering, absorption, asymmetry, forward, definition }
}

/// By how much a weakly absorbing host raises the scattering at the surface of the particle (relative), and what it adds
/// to the sum of amplitudes when that is divided by the square of its index in place of the squared modulus.
fn host_effects(host: Complex64, x: Complex64, amplitude: Complex64) -> (f64, Complex64) {
    let alpha = 2.0 * x.im;
    let surface = surface_excess(alpha);
    let excess = surface + (1.0 + surface) * (-2.0 * alpha).exp_m1();
    // conj(n)/n - 1
    let turn = Complex64::new(-2.0 * host.im * host.im, -2.0 * host.re * host.im) / host.norm_sqr();
    (excess, amplitude * turn)
}

/// `exp(alpha) / gamma(alpha) - 1` with `gamma = 2 (1 + (alpha - 1) exp(alpha)) / alpha^2` (eq 24), that is
/// `alpha^2 / (2 (exp(-alpha) - 1 + alpha)) - 1`; 0 at `alpha = 0`.
fn surface_excess(alpha: f64) -> f64 {
    if alpha < 0.5 {
        // 2 (exp(-alpha) - 1 + alpha) / alpha^2 is 1 plus this series; twelve terms leave less than 1e-17.
        let mut term = 1.0;
        let mut rest = 0.0;
        for k in 3..15 {
            term *= -alpha / f64::from(k);
            rest += term;
        }
        -rest / (1.0 + rest)
    } else {
        alpha * alpha / (2.0 * ((-alpha).exp() - 1.0 + alpha)) - 1.0
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
    fn the_surface_excess_joins_its_series() {
        let gamma = |a: f64| 2.0 * (1.0 + (a - 1.0) * a.exp()) / (a * a);
        for a in [0.3f64, 0.4999, 0.5001, 2.0, 20.0] {
            close(1.0 + surface_excess(a), a.exp() / gamma(a), 1e-12);
        }
        assert_eq!(surface_excess(0.0), 0.0);
        assert!(surface_excess(1e6).is_finite());
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
