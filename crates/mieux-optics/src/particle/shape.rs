//! Particles that are no spheres, and the spheres that scatter like them.

use std::f64::consts::PI;

use super::{ParticleError, positive, sphere_volume};

/// Millimetre, in which lengths of the literature's aspect ratios are, m.
const MILLIMETRE: f64 = 1e-3;

/// What a particle looks like. All have an axis, along which lengths are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Form {
    /// A sphere, whose size is its radius.
    #[default]
    Sphere,
    /// An ellipsoid of revolution: prolate where it is longer than wide, else oblate.
    Ellipsoid,
    /// A circular cylinder with flat ends.
    Cylinder,
    /// A prism over a regular hexagon, as ice crystals: column or plate. Its width is from corner to corner.
    HexagonalPrism,
}

/// Ratio of length (along the axis) to width.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AspectRatio {
    /// The same for all lengths.
    Constant(f64),
    /// `factor (length / 1 mm)^exponent`: 10.3 and 0.67 for brine in sea ice (eq 47 of `frisvad2007`, from `light2003`).
    Power {
        /// At a length of 1 mm.
        factor: f64,
        /// How it grows with length.
        exponent: f64,
    },
}

/// Which spheres stand for a particle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Equivalence {
    /// Of the same ratio of volume to area, and as many as have the same volume (and area): the best for scattering and
    /// absorption of randomly oriented particles (`grenfell1999`, `neshyba2003`); eq 34-35 of `frisvad2007`.
    #[default]
    VolumeToArea,
    /// One of the same volume: too small a cross section. For comparison.
    Volume,
    /// One of the same area: too large a volume. For comparison.
    Area,
}

/// A shape, with its proportions, and the spheres that stand for it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Shape {
    form: Form,
    aspect: AspectRatio,
    equivalence: Equivalence,
}

impl Default for AspectRatio {
    fn default() -> Self {
        Self::Constant(1.0)
    }
}

/// The spheres that stand for one particle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spheres {
    /// m
    pub radius: f64,
    /// How many; a real number.
    pub count: f64,
}

impl Shape {
    /// Spheres, whose sizes are radii.
    pub const SPHERE: Self =
        Self { form: Form::Sphere, aspect: AspectRatio::Constant(1.0), equivalence: Equivalence::VolumeToArea };

    /// A form with its proportions, which spheres have no use for.
    ///
    /// # Errors
    /// [`ParticleError::NotPositive`], or [`ParticleError::Exponent`].
    pub fn new(form: Form, aspect: AspectRatio) -> Result<Self, ParticleError> {
        match aspect {
            AspectRatio::Constant(ratio) => {
                positive("aspect ratio", ratio)?;
            }
            AspectRatio::Power { factor, exponent } => {
                positive("aspect ratio at 1 mm", factor)?;
                if !(-10.0..=10.0).contains(&exponent) {
                    return Err(ParticleError::Exponent { value: exponent });
                }
            }
        }
        Ok(Self { form, aspect, equivalence: Equivalence::default() })
    }

    /// The same, with other spheres to stand for it.
    pub fn with_equivalence(self, equivalence: Equivalence) -> Self {
        Self { equivalence, ..self }
    }

    /// The form.
    pub fn form(&self) -> Form {
        self.form
    }

    /// Which spheres stand for it.
    pub fn equivalence(&self) -> Equivalence {
        self.equivalence
    }

    /// Ratio of length to width at a length (m).
    pub fn aspect_ratio(&self, length_m: f64) -> f64 {
        match self.aspect {
            _ if self.form == Form::Sphere => 1.0,
            AspectRatio::Constant(ratio) => ratio,
            AspectRatio::Power { factor, exponent } => factor * (length_m / MILLIMETRE).powf(exponent),
        }
    }

    /// Volume in m^3 of a particle of a size in m: the radius of a sphere, the length of all else.
    pub fn volume(&self, size_m: f64) -> f64 {
        self.volume_and_area(size_m).0
    }

    /// Surface area in m^2 of a particle of a size in m.
    pub fn area(&self, size_m: f64) -> f64 {
        self.volume_and_area(size_m).1
    }

    /// Radius in m of the spheres that stand for a particle of a size in m.
    pub fn equivalent_radius(&self, size_m: f64) -> f64 {
        self.spheres(size_m).radius
    }

    pub(crate) fn spheres(&self, size_m: f64) -> Spheres {
        if self.form == Form::Sphere {
            return Spheres { radius: size_m, count: 1.0 };
        }
        let (volume, area) = self.volume_and_area(size_m);
        match self.equivalence {
            Equivalence::VolumeToArea => {
                let radius = 3.0 * volume / area;
                Spheres { radius, count: volume / sphere_volume(radius) }
            }
            Equivalence::Volume => Spheres { radius: (volume / sphere_volume(1.0)).cbrt(), count: 1.0 },
            Equivalence::Area => Spheres { radius: (area / (4.0 * PI)).sqrt(), count: 1.0 },
        }
    }

    /// Volume and area per particle (appendix B of `frisvad2007` for the prolate and the cylinder).
    fn volume_and_area(&self, size: f64) -> (f64, f64) {
        let width = size / self.aspect_ratio(size);
        match self.form {
            Form::Sphere => (sphere_volume(size), 4.0 * PI * size * size),
            Form::Ellipsoid => (PI / 6.0 * size * width * width, ellipsoid_area(size, width)),
            Form::Cylinder => (0.25 * PI * size * width * width, PI * width * (0.5 * width + size)),
            Form::HexagonalPrism => {
                let base = 0.375 * 3f64.sqrt() * width * width;
                (base * size, 2.0 * base + 3.0 * width * size)
            }
        }
    }
}

/// Area of an ellipsoid of revolution of a length along its axis and a width.
fn ellipsoid_area(length: f64, width: f64) -> f64 {
    // asin(e)/e and artanh(e)/e, e the eccentricity, are one function of its square, taken negative where oblate.
    let (polar, equator) = (0.5 * length, 0.5 * width);
    let square = 1.0 - (equator / polar).powi(2);
    if square.abs() < 1e-3 {
        // Prolate: 2 pi (equator^2 + equator polar asin(e)/e); the series holds for oblate ones alike.
        let series = 1.0 + square / 6.0 + 3.0 / 40.0 * square.powi(2) + 15.0 / 336.0 * square.powi(3);
        return 2.0 * PI * equator * (equator + polar * series);
    }
    if square > 0.0 {
        let e = square.sqrt();
        2.0 * PI * equator * (equator + polar * e.asin() / e)
    } else {
        let e = (1.0 - (polar / equator).powi(2)).sqrt();
        2.0 * PI * (equator * equator + polar * polar * e.atanh() / e)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(form: Form, ratio: f64) -> Shape {
        Shape::new(form, AspectRatio::Constant(ratio)).unwrap()
    }

    /// The printed equivalent radii of appendix B.
    #[test]
    fn equivalent_radii_are_those_of_the_paper() {
        let length = 2.0;
        for ratio in [1.2f64, 3.0, 10.3] {
            let e = (1.0 - ratio.powi(-2)).sqrt();
            let expected = length * e / (e + ratio * e.asin());
            let found = shape(Form::Ellipsoid, ratio).equivalent_radius(length);
            assert!((found / expected - 1.0).abs() < 1e-12, "{ratio}: {found} {expected}");
            let expected = 3.0 * length / (2.0 + 4.0 * ratio);
            let found = shape(Form::Cylinder, ratio).equivalent_radius(length);
            assert!((found / expected - 1.0).abs() < 1e-12, "{ratio}: {found} {expected}");
        }
    }

    /// By the integral over the surface of revolution.
    #[test]
    fn ellipsoids_have_the_area_of_their_integral() {
        for ratio in [0.05, 0.3, 0.97, 0.9996, 1.0, 1.0004, 1.03, 4.0, 20.0] {
            let (a, b) = (1.0, 1.0 / ratio);
            let steps = 200_000;
            let h = PI / f64::from(steps);
            let ring = |t: f64| 2.0 * PI * b * t.sin() * ((a * t.sin()).powi(2) + (b * t.cos()).powi(2)).sqrt();
            let expected: f64 = (0..steps).map(|i| ring(h * (f64::from(i) + 0.5))).sum::<f64>() * h;
            let found = shape(Form::Ellipsoid, ratio).area(2.0);
            assert!((found / expected - 1.0).abs() < 1e-8, "{ratio}: {found} {expected}");
        }
    }

    #[test]
    fn limits_are_known() {
        let ball = shape(Form::Ellipsoid, 1.0);
        assert!((ball.equivalent_radius(2.0) - 1.0).abs() < 1e-12);
        assert!((ball.volume(2.0) - sphere_volume(1.0)).abs() < 1e-12);
        // A hexagon's width is two of its sides: six triangles of side 1 over a length of 4.
        let column = shape(Form::HexagonalPrism, 2.0);
        assert!((column.volume(4.0) - 6.0 * 3f64.sqrt()).abs() < 1e-12);
        assert!((column.area(4.0) - (3.0 * 3f64.sqrt() + 24.0)).abs() < 1e-12);
        // A thin plate: 3/2 of its thickness.
        for form in [Form::Cylinder, Form::HexagonalPrism] {
            assert!((shape(form, 1e-6).equivalent_radius(1.0) - 1.5).abs() < 1e-5);
        }
    }

    #[test]
    fn equivalent_spheres_keep_what_they_promise() {
        let brine = AspectRatio::Power { factor: 10.3, exponent: 0.67 };
        let tube = Shape::new(Form::Cylinder, brine).unwrap();
        assert!((tube.aspect_ratio(1e-3) - 10.3).abs() < 1e-12);
        assert!((tube.aspect_ratio(8e-3) / 10.3 - 8f64.powf(0.67)).abs() < 1e-12);
        let total = |equivalence| {
            let Spheres { radius, count } = tube.with_equivalence(equivalence).spheres(5e-3);
            (count * sphere_volume(radius) / tube.volume(5e-3), count * 4.0 * PI * radius * radius / tube.area(5e-3))
        };
        let (volume, area) = total(Equivalence::VolumeToArea);
        assert!((volume - 1.0).abs() < 1e-12 && (area - 1.0).abs() < 1e-12);
        assert!((total(Equivalence::Volume).0 - 1.0).abs() < 1e-12 && total(Equivalence::Volume).1 < 1.0);
        assert!((total(Equivalence::Area).1 - 1.0).abs() < 1e-12 && total(Equivalence::Area).0 > 1.0);
    }

    #[test]
    fn impossible_proportions_are_refused() {
        for ratio in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Shape::new(Form::Cylinder, AspectRatio::Constant(ratio)).is_err());
        }
        let steep = AspectRatio::Power { factor: 1.0, exponent: f64::NAN };
        assert!(matches!(Shape::new(Form::Cylinder, steep), Err(ParticleError::Exponent { .. })));
    }
}
