//! Homogeneous spheres in a host that may absorb.

use std::cmp::Ordering;

use num_complex::Complex64;
use pulp::{Simd, WithSimd};

use super::coefficients::{Coefficients, Keep};
use super::downward::{self, downward};
use super::elementary::NARROW;
use super::host::{Absorbing, Lossless, Opaque};
use super::kernel::{Group, Sink};
use super::recurrence::{abreast, series_order, start_order, top_order};
use super::sums::Sums;
use super::upward::{self, upward};
use super::wave::{PlaneWave, SphereScattering, check_index, check_length, check_size_parameters};
use super::weights::Weights;
use super::{MieError, SphereError};
use crate::lanes::{Cx, MAX_LANES, Re};

/// One homogeneous sphere in a plane wave; everything in it has been checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sphere {
    pub(super) wave: PlaneWave,
    /// Vacuum wave number times radius.
    pub(super) k0r: f64,
    pub(super) index: Complex64,
}

impl Sphere {
    /// A sphere of radius `radius` (m) and refractive index `index` in a plane wave.
    ///
    /// # Errors
    /// [`MieError`] when the radius or the index is outside the range it names, the modulus of the
    /// size parameter outside 1e-8..1e7 in the host or outside 1e-10..1e9 inside the particle, or when the host absorbs more than
    /// `exp(-680)` across the particle, `exp(-340)` by the definition of Mishchenko and Yang.
    pub fn new(wave: PlaneWave, radius: f64, index: Complex64) -> Result<Self, MieError> {
        check_length("radius", radius)?;
        check_index("particle", index)?;
        let sphere = Self { wave, k0r: wave.k0r(radius), index };
        let (x, y) = sphere.size_parameters();
        check_size_parameters(x, y)?;
        wave.check_absorption(sphere.k0r)?;
        Ok(sphere)
    }

    /// Its refractive index.
    pub fn index(&self) -> Complex64 {
        self.index
    }

    /// In the host and in the particle.
    fn size_parameters(&self) -> (Complex64, Complex64) {
        (self.wave.host() * self.k0r, self.index * self.k0r)
    }

    /// The Lorenz-Mie coefficients.
    pub fn coefficients(&self) -> Coefficients {
        pulp::Arch::new().dispatch(SphereCoefficients(self))
    }

    /// Cross sections, asymmetry and forward amplitude. Several spheres are better given to [`scatter_spheres`].
    ///
    /// # Errors
    /// [`MieError::Cancellation`] where the host absorbs so much that extinction is lost to rounding.
    pub fn scattering(&self) -> Result<SphereScattering, MieError> {
        let mut out = Vec::with_capacity(1);
        scatter_spheres(&[*self], &mut out).map_err(|error| error.source)?;
        Ok(out[0])
    }
}

/// Scattering by one sphere of radius `radius_m` (m) and index `particle` in a host of index `host`, at the vacuum
/// wavelength `wavelength_m` (m): [`PlaneWave::new`], [`Sphere::new`] and [`Sphere::scattering`] in one.
///
/// # Errors
/// As for these.
pub fn scatter_sphere(
    radius_m: f64,
    wavelength_m: f64,
    host: Complex64,
    particle: Complex64,
) -> Result<SphereScattering, MieError> {
    Sphere::new(PlaneWave::new(wavelength_m, host)?, radius_m, particle)?.scattering()
}

/// Spheres sorted at a time: what they need stays in the cache.
pub(super) const CHUNK: usize = 512;

/// How a sphere's series is summed; spheres of one class go abreast. Small ones first, as input often comes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Class {
    LosslessDown,
    LosslessUp,
    AbsorbingDown,
    AbsorbingUp,
    Opaque,
}

impl Class {
    /// Whether every coefficient lacks a factor of `exp(-2 i x)`.
    pub fn scaled(self) -> bool {
        self == Self::Opaque
    }

    /// The downward series for the same spheres.
    pub fn downward(self) -> Self {
        match self {
            Self::LosslessUp => Self::LosslessDown,
            Self::AbsorbingUp => Self::AbsorbingDown,
            other => other,
        }
    }
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
    #[inline(always)]
    fn new(index: usize, sphere: &Sphere) -> Self {
        let (x, y) = sphere.size_parameters();
        let square = x.norm_sqr();
        // Contrast above 2 %: weaker ones lose digits upward.
        let dense = y.norm_sqr() >= square && (y - x).norm_sqr() > 4e-4 * square;
        let up = x.re > 1.0 && dense && lasts(square, y);
        let class = match (x.im, up) {
            (0.0, true) => Class::LosslessUp,
            (0.0, false) => Class::LosslessDown,
            (im, true) if im < NARROW => Class::AbsorbingUp,
            (im, false) if im < NARROW => Class::AbsorbingDown,
            _ => Class::Opaque,
        };
        Self { class, index: index as u32, size: square.sqrt() }
    }

    #[inline(always)]
    fn order(&self, other: &Self) -> Ordering {
        self.class.cmp(&other.class).then(self.size.total_cmp(&other.size))
    }
}

/// Whether upward recurrences keep enough digits of the wave inside a particle of size parameter `y`, denser than its host,
/// up to the order of the size parameter in the host, of squared modulus `square`.
///
/// The wave is `exp(Im(f(n) - f(0)))` there of what it was at order 0, with `f(n) = sqrt(y^2 - n^2) - n acos(n / y)`, and the
/// other solution, of which rounding leaves some at order 0, grows as it fades. To first order in `Im y / Re y`,
/// `Im f(n) = Im y sqrt(1 - n^2 / |y|^2)`.
#[inline(always)]
fn lasts(square: f64, y: Complex64) -> bool {
    y.im < NARROW || (y.im < 0.1 * y.re && 2.0 * y.im * (1.0 - (1.0 - square / y.norm_sqr()).sqrt()) < MOST_LOST)
}

/// Logarithm of what rounding may grow by. Only the order of the size parameter sees all of it, and few before: in the
/// sums no trace of it is left.
const MOST_LOST: f64 = 5.5;

/// Members that go abreast in registers of `width` lanes; the last fills what they leave.
#[inline(always)]
fn group(spheres: &[Sphere], members: &[Member], width: usize) -> Group {
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
    for lane in 0..width {
        let sphere = &spheres[members[lane.min(members.len() - 1)].index as usize];
        group.k0r[lane] = sphere.k0r;
        group.host_re[lane] = sphere.wave.host().re;
        group.host_im[lane] = sphere.wave.host().im;
        group.particle_re[lane] = sphere.index.re;
        group.particle_im[lane] = sphere.index.im;
    }
    if !matches!(members[0].class, Class::LosslessUp | Class::AbsorbingUp) {
        let all = || members.iter().map(|m| spheres[m.index as usize].size_parameters());
        let largest = all().fold([0.0f64; 2], |most, (x, y)| [most[0].max(x.norm_sqr()), most[1].max(y.norm_sqr())]);
        let tops = largest.map(|square| top_order(square.sqrt(), group.order));
        for (x, y) in all() {
            for (i, z) in [x, y].into_iter().enumerate() {
                group.start[i] = group.start[i].max(start_order(z, group.order, tops[i]));
                group.smallest = group.smallest.min(z.norm_sqr());
            }
        }
        group.smallest = group.smallest.sqrt();
    }
    group
}

/// Scattering by many spheres, appended to `out` in their order. One thread, several spheres abreast in vector
/// registers: neighbours in size go together, so any order of input will do.
///
/// Source: `frisvad2007` section 2.1 with the signs of `zeta_n` made consistent.
///
/// # Errors
/// [`SphereError`], with `out` as it was, when a host absorbs so much over a sphere that extinction is lost to rounding.
pub fn scatter_spheres(spheres: &[Sphere], out: &mut Vec<SphereScattering>) -> Result<(), SphereError> {
    let before = out.len();
    let result = pulp::Arch::new().dispatch(ScatterSpheres { spheres, out });
    if result.is_err() {
        out.truncate(before);
    }
    result
}

struct ScatterSpheres<'a> {
    spheres: &'a [Sphere],
    out: &'a mut Vec<SphereScattering>,
}

impl WithSimd for ScatterSpheres<'_> {
    type Output = Result<(), SphereError>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self { spheres, out } = self;
        let mut series = Series::new(simd);
        let mut members: Vec<Member> = Vec::with_capacity(spheres.len().min(CHUNK));
        for (k, spheres) in spheres.chunks(CHUNK).enumerate() {
            members.clear();
            members.extend(spheres.iter().enumerate().map(|(i, s)| Member::new(i, s)));
            if !members.is_sorted_by(|a, b| a.order(b).is_le()) {
                members.sort_unstable_by(Member::order);
            }
            let first = out.len();
            out.resize(first + spheres.len(), SphereScattering::NONE);
            for class in members.chunk_by(|a, b| a.class == b.class) {
                series
                    .scatter(spheres, class, &mut out[first..])
                    .map_err(|error| SphereError { index: k * CHUNK + error.index, ..error })?;
            }
        }
        Ok(())
    }
}

/// What the series of one group after another share.
pub(super) struct Series<S: Simd> {
    simd: S,
    weights: Weights,
    up: upward::Scratch<S>,
    real: downward::Scratch<S, Re<S>>,
    complex: downward::Scratch<S, Cx<S>>,
}

impl<S: Simd> Series<S> {
    pub fn new(simd: S) -> Self {
        Self {
            simd,
            weights: Weights::new(),
            up: upward::Scratch::new(),
            real: downward::Scratch::new(),
            complex: downward::Scratch::new(),
        }
    }

    /// Scattering by those of the spheres that are members, all of one class.
    #[inline(always)]
    fn scatter(
        &mut self,
        spheres: &[Sphere],
        members: &[Member],
        out: &mut [SphereScattering],
    ) -> Result<(), SphereError> {
        let class = members[0].class;
        let mut rest = members;
        while !rest.is_empty() {
            let sizes: [f64; MAX_LANES] = std::array::from_fn(|i| rest[i.min(rest.len() - 1)].size);
            let (members, others) = rest.split_at(abreast(S::F64_LANES.min(rest.len()), &sizes));
            rest = others;
            let group = group(spheres, members, S::F64_LANES);
            let sums = if class.scaled() {
                let mut sums = Sums::<S, true>::new(self.simd);
                self.run(class, &group, &mut sums);
                sums.finish()
            } else {
                let mut sums = Sums::<S, false>::new(self.simd);
                self.run(class, &group, &mut sums);
                sums.finish()
            };
            for (lane, member) in members.iter().enumerate() {
                let index = member.index as usize;
                let Sphere { wave, k0r, .. } = &spheres[index];
                let sums = sums.lane(lane);
                // Each by itself, or the result would go through memory as what may have failed.
                if class.scaled() {
                    out[index] =
                        wave.scaled_cross_sections(*k0r, &sums).map_err(|source| SphereError { index, source })?;
                } else {
                    out[index] = wave.plain_cross_sections(*k0r, &sums);
                }
            }
        }
        Ok(())
    }

    #[inline(always)]
    pub fn run<O: Sink<S>>(&mut self, class: Class, group: &Group, sink: &mut O) {
        let Self { simd, weights, up, real, complex } = self;
        match class {
            Class::LosslessUp => upward::<S, Lossless>(*simd, group, weights, up, sink),
            Class::LosslessDown => downward::<S, Lossless, O>(*simd, group, weights, real, sink),
            Class::AbsorbingUp => upward::<S, Absorbing>(*simd, group, weights, up, sink),
            Class::AbsorbingDown => downward::<S, Absorbing, O>(*simd, group, weights, complex, sink),
            Class::Opaque => downward::<S, Opaque, O>(*simd, group, weights, complex, sink),
        }
    }
}

/// The class of one sphere by itself, and the group that it makes in a class.
pub(super) fn single(sphere: &Sphere) -> (Class, impl Fn(Class) -> Group) {
    let member = Member::new(0, sphere);
    let of = move |class| group(std::slice::from_ref(sphere), &[Member { class, ..member }], MAX_LANES);
    (member.class, of)
}

struct SphereCoefficients<'a>(&'a Sphere);

impl WithSimd for SphereCoefficients<'_> {
    type Output = Coefficients;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Coefficients {
        let sphere = self.0;
        let (class, group) = single(sphere);
        let group = group(class);
        let mut series = Series::new(simd);
        let scaled = class.scaled();
        let (sums, terms) = if scaled {
            let mut keep = Keep::<S, true>::new(simd, group.order);
            series.run(class, &group, &mut keep);
            (keep.sums.finish(), keep.terms)
        } else {
            let mut keep = Keep::<S, false>::new(simd, group.order);
            series.run(class, &group, &mut keep);
            (keep.sums.finish(), keep.terms)
        };
        Coefficients { wave: sphere.wave, k0r: sphere.k0r, scaled, terms, sums: sums.lane(0) }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

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
    fn what_is_no_sphere_is_refused() {
        let ok = c(1.33, 0.0);
        assert!(matches!(scatter_sphere(-1.0, UM, ok, ok), Err(MieError::Length { name: "radius", .. })));
        assert!(matches!(scatter_sphere(UM, f64::NAN, ok, ok), Err(MieError::Length { name: "wavelength", .. })));
        assert!(matches!(scatter_sphere(UM, UM, c(0.0, 0.0), ok), Err(MieError::Index { name: "host", .. })));
        assert!(matches!(scatter_sphere(UM, UM, ok, c(1.5, -0.1)), Err(MieError::Index { name: "particle", .. })));
        assert!(matches!(scatter_sphere(1e9, UM, ok, ok), Err(MieError::SizeParameter { .. })));
        assert!(matches!(scatter_sphere(1e-3, UM, c(1.33, 1.0), ok), Err(MieError::HostAbsorption { .. })));
    }

    /// Just inside the bound on absorption, against the downward series, which derivatives come from.
    #[test]
    fn absorbing_spheres_upward_are_the_same_downward() {
        for (x, re) in [(5.0, 1.03), (60.0f64, 1.1f64), (300.0, 1.33), (900.0, 1.5), (3000.0, 4.0)] {
            let wave = PlaneWave::new(UM, c(1.0, 0.0)).unwrap();
            let share: f64 = 2.0 * (1.0 - (1.0 - 1.0 / (re * re)).sqrt());
            let index = c(re, (0.95 * MOST_LOST / share / x).min(0.09 * re));
            let sphere = Sphere::new(wave, x * UM / (2.0 * PI), index).unwrap();
            assert_eq!(Member::new(0, &sphere).class, Class::LosslessUp, "{x}");
            let (up, down) = (sphere.scattering().unwrap(), sphere.gradient().unwrap().scattering);
            close(up.extinction, down.extinction, 1e-13);
            close(up.scattering, down.scattering, 1e-13);
            close(up.absorption, down.absorption, 1e-13);
            close(up.asymmetry, down.asymmetry, 1e-13);
        }
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

    /// Whatever goes abreast, every sphere gets what it gets alone, to rounding.
    #[test]
    fn spheres_do_not_disturb_each_other() {
        let wave = PlaneWave::new(UM, c(1.0, 0.0)).unwrap();
        let spheres: Vec<Sphere> = (0..200u64)
            .map(|i| {
                // Sizes 1e-8 to 1e3 in no order, some of which take each of the ways to sum.
                let x = 10f64.powf(((i * 89) % 200) as f64 / 200.0 * 11.0 - 8.0);
                let index = [c(1.5, 0.01), c(1.33, 0.0), c(0.7, 0.0), c(1.0001, 1e-9), c(0.1, 4.0)][i as usize % 5];
                Sphere::new(wave, x * UM / (2.0 * PI), index).unwrap()
            })
            .collect();
        let mut together = Vec::new();
        scatter_spheres(&spheres, &mut together).unwrap();
        for (sphere, s) in spheres.iter().zip(together) {
            let alone = sphere.scattering().unwrap();
            close(s.extinction, alone.extinction, 1e-12);
            close(s.scattering, alone.scattering, 1e-12);
            close(s.asymmetry, alone.asymmetry, 1e-11);
        }
    }
}
