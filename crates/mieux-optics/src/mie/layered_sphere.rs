//! Spheres of concentric layers in a host that may absorb.

use num_complex::Complex64;
use pulp::{Simd, WithSimd};

use super::coefficients::{Coefficients, Keep};
use super::elementary::NARROW;
use super::host::{Absorbing, Lossless, Opaque};
use super::kernel::Sink;
use super::layered::{LayerGroup, LayeredGroup, layered};
use super::recurrence::{abreast, series_order, start_order, top_order};
use super::sums::{GroupSums, Sums};
use super::wave::{PlaneWave, SphereScattering, check_index, check_length, check_size_parameters};
use super::weights::Weights;
use super::{MieError, SphereError};
use crate::lanes::{LaneArray, MAX_LANES};

/// One layer of a sphere; the innermost is its core.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layer {
    /// Outer radius, m.
    pub radius: f64,
    /// Refractive index.
    pub index: Complex64,
}

/// A sphere of concentric layers in a plane wave; everything in it has been checked.
#[derive(Debug, Clone, PartialEq)]
pub struct LayeredSphere {
    wave: PlaneWave,
    /// Vacuum wave number times outer radius, and index, from the core outward.
    layers: Vec<(f64, Complex64)>,
}

impl LayeredSphere {
    /// A sphere of layers from the core outward, at most 1 000, in a plane wave. The radius of the last is that of the
    /// sphere.
    ///
    /// # Errors
    /// [`MieError::Layers`] when there are none or too many or their radii do not ascend, and those of
    /// [`Sphere::new`](super::Sphere::new) for every layer.
    pub fn new(wave: PlaneWave, layers: &[Layer]) -> Result<Self, MieError> {
        if layers.is_empty() || layers.len() > 1000 {
            return Err(MieError::Layers { count: layers.len() });
        }
        let mut inside = 0.0;
        for (i, layer) in layers.iter().enumerate() {
            check_length("radius", layer.radius)?;
            check_index("particle", layer.index)?;
            if layer.radius <= inside {
                return Err(MieError::LayerOrder { layer: i + 1, radius_m: layer.radius, inside_m: inside });
            }
            inside = layer.radius;
            let k0r = wave.k0r(layer.radius);
            // Only the outermost meets the host.
            let host = if i + 1 == layers.len() { wave.host() } else { layers[i + 1].index };
            check_size_parameters(host * k0r, layer.index * k0r)?;
        }
        let layers: Vec<(f64, Complex64)> = layers.iter().map(|l| (wave.k0r(l.radius), l.index)).collect();
        let sphere = Self { wave, layers };
        wave.check_absorption(sphere.k0r())?;
        Ok(sphere)
    }

    /// Vacuum wave number times the radius of the sphere.
    fn k0r(&self) -> f64 {
        self.layers[self.layers.len() - 1].0
    }

    /// The Lorenz-Mie coefficients.
    pub fn coefficients(&self) -> Coefficients {
        pulp::Arch::new().dispatch(LayeredCoefficients(self))
    }

    /// Cross sections, asymmetry and forward amplitude. Several spheres are better given to
    /// [`scatter_layered_spheres`].
    ///
    /// # Errors
    /// [`MieError::Cancellation`] where the host absorbs so much that extinction is lost to rounding.
    pub fn scattering(&self) -> Result<SphereScattering, MieError> {
        let mut out = Vec::with_capacity(1);
        scatter_layered_spheres(std::slice::from_ref(self), &mut out).map_err(|error| error.source)?;
        Ok(out[0])
    }
}

/// Scattering by many layered spheres, appended to `out` in their order. One thread, several spheres of as many layers
/// abreast in vector registers.
///
/// Source: the recursion of `yang2003` with the ratios multiplied out, in the host of `frisvad2007` section 2.1.
///
/// # Errors
/// [`SphereError`], with `out` as it was, when a host absorbs so much over a sphere that extinction is lost to rounding.
pub fn scatter_layered_spheres(spheres: &[LayeredSphere], out: &mut Vec<SphereScattering>) -> Result<(), SphereError> {
    let before = out.len();
    let result = pulp::Arch::new().dispatch(ScatterLayered { spheres, out });
    if result.is_err() {
        out.truncate(before);
    }
    result
}

/// How the waves of the host and of the layers are carried, and how many layers there are: spheres alike go abreast.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Class {
    layers: usize,
    host: HostClass,
    opaque_layers: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum HostClass {
    Lossless,
    Absorbing,
    Opaque,
}

impl Class {
    fn of(sphere: &LayeredSphere) -> Self {
        let im = sphere.wave.host().im * sphere.k0r();
        let host = match im {
            0.0 => HostClass::Lossless,
            im if im < NARROW => HostClass::Absorbing,
            _ => HostClass::Opaque,
        };
        // The core is left out: its waves are of one kind only.
        let opaque_layers = sphere.layers[1..].iter().any(|(k0r, index)| k0r * index.im >= NARROW);
        Self { layers: sphere.layers.len(), host, opaque_layers }
    }

    fn scaled(&self) -> bool {
        self.host == HostClass::Opaque
    }

    #[inline(always)]
    fn run<S: Simd>(self, simd: S, group: &LayeredGroup, weights: &mut Weights, sink: &mut impl Sink<S>) {
        match (self.host, self.opaque_layers) {
            (HostClass::Lossless, false) => layered::<S, Lossless, Absorbing>(simd, group, weights, sink),
            (HostClass::Lossless, true) => layered::<S, Lossless, Opaque>(simd, group, weights, sink),
            (HostClass::Absorbing, false) => layered::<S, Absorbing, Absorbing>(simd, group, weights, sink),
            (HostClass::Absorbing, true) => layered::<S, Absorbing, Opaque>(simd, group, weights, sink),
            (HostClass::Opaque, false) => layered::<S, Opaque, Absorbing>(simd, group, weights, sink),
            (HostClass::Opaque, true) => layered::<S, Opaque, Opaque>(simd, group, weights, sink),
        }
    }

    /// The sums of a group of this class.
    #[inline(always)]
    fn sums<S: Simd>(self, simd: S, group: &LayeredGroup, weights: &mut Weights) -> GroupSums {
        if self.scaled() {
            let mut sums = Sums::<S, true>::new(simd);
            self.run(simd, group, weights, &mut sums);
            sums.finish()
        } else {
            let mut sums = Sums::<S, false>::new(simd);
            self.run(simd, group, weights, &mut sums);
            sums.finish()
        }
    }
}

/// What one boundary is for a group: its size parameter on one side, lane by lane.
fn starts(spheres: &[&LayeredSphere], order: usize, z: impl Fn(&LayeredSphere) -> Complex64) -> (usize, f64) {
    let (mut start, mut smallest) = (0, f64::INFINITY);
    for z in spheres.iter().map(|s| z(s)) {
        let modulus = z.norm();
        let top = top_order(modulus, order);
        start = start_order(z, order, top).max(start);
        smallest = modulus.min(smallest);
    }
    (start, smallest)
}

fn group(spheres: &[&LayeredSphere], class: Class) -> LayeredGroup {
    let lanes = |value: &dyn Fn(&LayeredSphere) -> f64| -> LaneArray {
        std::array::from_fn(|lane| value(spheres[lane.min(spheres.len() - 1)]))
    };
    let most = |value: &dyn Fn(&LayeredSphere) -> f64| spheres.iter().map(|s| value(s)).fold(0.0, f64::max);
    let order = series_order(most(&|s| (s.wave.host() * s.k0r()).norm()));
    let (start, mut smallest) = starts(spheres, order, |s| s.wave.host() * s.k0r());
    let mut layers = Vec::with_capacity(class.layers);
    for i in 0..class.layers {
        let (at_outer, smallest_outer) = starts(spheres, order, |s| s.layers[i].1 * s.layers[i].0);
        smallest = smallest.min(smallest_outer);
        let (mut at_inner, mut farthest, mut across) = (0, 0, [[1.0; MAX_LANES], [0.0; MAX_LANES]]);
        if i > 0 {
            let (at, smallest_inner) = starts(spheres, order, |s| s.layers[i].1 * s.layers[i - 1].0);
            at_inner = at;
            smallest = smallest.min(smallest_inner);
            let inner = |s: &LayeredSphere| s.layers[i - 1].0 * s.layers[i].1.norm().max(s.layers[i - 1].1.norm());
            farthest = series_order(most(&inner)) + 1;
            if class.opaque_layers {
                let turn = |s: &LayeredSphere| {
                    (2.0 * Complex64::I * s.layers[i].1 * (s.layers[i].0 - s.layers[i - 1].0)).exp()
                };
                across = [lanes(&|s| turn(s).re), lanes(&|s| turn(s).im)];
            }
        }
        layers.push(LayerGroup {
            k0r: lanes(&|s| s.layers[i].0),
            re: lanes(&|s| s.layers[i].1.re),
            im: lanes(&|s| s.layers[i].1.im),
            farthest,
            across,
            start: [at_inner, at_outer],
        });
    }
    let (host_re, host_im) = (lanes(&|s| s.wave.host().re), lanes(&|s| s.wave.host().im));
    LayeredGroup { host_re, host_im, layers, order, start, smallest }
}

struct ScatterLayered<'a> {
    spheres: &'a [LayeredSphere],
    out: &'a mut Vec<SphereScattering>,
}

impl WithSimd for ScatterLayered<'_> {
    type Output = Result<(), SphereError>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self { spheres, out } = self;
        let member = |(i, s): (usize, &LayeredSphere)| (Class::of(s), (s.wave.host() * s.k0r()).norm(), i);
        let mut members: Vec<(Class, f64, usize)> = spheres.iter().enumerate().map(member).collect();
        members.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut weights = Weights::new();
        let first = out.len();
        out.resize(first + spheres.len(), SphereScattering::NONE);
        let out = &mut out[first..];
        for class in members.chunk_by(|a, b| a.0 == b.0) {
            let mut rest = class;
            while !rest.is_empty() {
                let sizes: [f64; MAX_LANES] = std::array::from_fn(|i| rest[i.min(rest.len() - 1)].1);
                let count = abreast(S::F64_LANES.min(rest.len()), &sizes);
                let (members, others) = rest.split_at(count);
                rest = others;
                let class = members[0].0;
                let abreast: Vec<&LayeredSphere> = members.iter().map(|m| &spheres[m.2]).collect();
                let sums = class.sums(simd, &group(&abreast, class), &mut weights);
                for (lane, &(class, _, index)) in members.iter().enumerate() {
                    let sphere = &spheres[index];
                    out[index] = sphere
                        .wave
                        .cross_sections(sphere.k0r(), &sums.lane(lane), class.scaled())
                        .map_err(|source| SphereError { index, source })?;
                }
            }
        }
        Ok(())
    }
}

struct LayeredCoefficients<'a>(&'a LayeredSphere);

impl WithSimd for LayeredCoefficients<'_> {
    type Output = Coefficients;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Coefficients {
        let sphere = self.0;
        let class = Class::of(sphere);
        let group = group(&[sphere], class);
        let weights = &mut Weights::new();
        let (sums, terms) = if class.scaled() {
            let mut keep = Keep::<S, true>::new(simd, group.order);
            class.run(simd, &group, weights, &mut keep);
            (keep.sums.finish(), keep.terms)
        } else {
            let mut keep = Keep::<S, false>::new(simd, group.order);
            class.run(simd, &group, weights, &mut keep);
            (keep.sums.finish(), keep.terms)
        };
        let (wave, k0r, scaled) = (sphere.wave, sphere.k0r(), class.scaled());
        Coefficients { wave, k0r, scaled, terms, sums: sums.lane(0) }
    }
}
