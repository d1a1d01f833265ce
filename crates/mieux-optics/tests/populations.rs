//! Populations of every kind in a medium, against what is known of them by other ways.

use std::f64::consts::PI;

use mieux_optics::Complex64;
use mieux_optics::medium::{Coat, CoatExtent, HardSpheres, Inclusion, Medium, MediumError, Packing, SizedBy};
use mieux_optics::mie::{Layer, LayeredSphere, PlaneWave, scatter_sphere};
use mieux_optics::particle::{
    AspectRatio, Equivalence, Form, Gamma, LogNormal, MixedSizes, PowerLaw, RosinRammler, Shape, SizeDistribution,
    TabulatedSizes, Weighting, sphere_volume,
};
use mieux_optics::substance::Substance;
use proptest::prelude::{Just, Strategy, prop_oneof};

const GREEN: f64 = 550e-9;

fn constant(re: f64, im: f64) -> Substance {
    Substance::Constant(Complex64::new(re, im))
}

fn one_size(radius: f64) -> SizeDistribution {
    SizeDistribution::monodisperse(radius).unwrap()
}

fn log_normal(median: f64, deviation: f64) -> SizeDistribution {
    SizeDistribution::LogNormal(LogNormal::from_median(Weighting::Number, median, deviation).unwrap())
}

fn medium(inclusions: Vec<Inclusion>) -> Medium {
    Medium::new(constant(1.33, 1e-8), inclusions).unwrap()
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{found:e} against {expected:e}");
}

#[test]
fn a_coated_particle_is_a_layered_sphere() {
    let wave = PlaneWave::new(GREEN, Complex64::new(1.33, 1e-8)).unwrap();
    let (core, coat) = (Complex64::new(1.59, 0.0), Complex64::new(1.45, 1e-3));
    let layers = [Layer { radius: 0.3e-6, index: core }, Layer { radius: 0.4e-6, index: coat }];
    let exact = LayeredSphere::new(wave, &layers).unwrap().scattering().unwrap();
    let number = 0.01 / sphere_volume(0.4e-6);
    let extents =
        [CoatExtent::Thickness(0.1e-6), CoatExtent::RadiusRatio(0.75), CoatExtent::VolumeShare(1.0 - 0.75f64.powi(3))];
    for extent in extents {
        for (sized_by, radius) in [(SizedBy::Outside, 0.4e-6), (SizedBy::Core, 0.3e-6)] {
            let coats = vec![Coat::new(Substance::Constant(coat), extent).unwrap()];
            let beads = Inclusion::new("beads", Substance::Constant(core), one_size(radius), 0.01);
            let beads = beads.with_coats(coats, sized_by);
            close(beads.mean_volume().unwrap(), sphere_volume(0.4e-6), 1e-9);
            let medium = medium(vec![beads]);
            let at = medium.optics_at(GREEN, 1e-4).unwrap();
            close(at.sigma_s, number * exact.scattering, 1e-9);
            close(at.asymmetry, exact.asymmetry, 1e-9);
            let moments = medium.legendre_moments_at(GREEN, 4, 1e-4).unwrap();
            close(moments[1], exact.asymmetry, 1e-9);
            close(medium.phase_at(GREEN, 1e-4).unwrap().asymmetry(), exact.asymmetry, 1e-3);
        }
    }
}

/// A coat of the same stuff is no coat, and one thicker than a particle is all of it.
#[test]
fn coats_vanish_and_take_over() {
    let glass = constant(1.5, 1e-4);
    let plain = medium(vec![Inclusion::new("beads", glass.clone(), log_normal(0.3e-6, 1.5), 0.01)]);
    let expected = plain.optics_at(GREEN, 1e-6).unwrap();
    let coated = |core: Substance, thickness: f64| {
        let coat = Coat::new(constant(1.5, 1e-4), CoatExtent::Thickness(thickness)).unwrap();
        let beads = Inclusion::new("beads", core, log_normal(0.3e-6, 1.5), 0.01);
        medium(vec![beads.with_coats(vec![coat], SizedBy::Outside)]).optics_at(GREEN, 1e-6).unwrap()
    };
    for found in [coated(glass, 0.05e-6), coated(constant(2.5, 0.5), 1e-3)] {
        close(found.sigma_s, expected.sigma_s, 1e-5);
        close(found.sigma_a, expected.sigma_a, 1e-5);
        close(found.asymmetry, expected.asymmetry, 1e-5);
    }
}

/// Volume and area are kept, so large particles that all light is scattered or absorbed by have the cross sections that their
/// area says: a quarter of it on average over directions, twice for diffraction.
#[test]
fn shapes_scatter_as_their_area_says() {
    let length = 400e-6;
    for form in [Form::Ellipsoid, Form::Cylinder, Form::HexagonalPrism] {
        for ratio in [0.2, 1.0, 5.0] {
            let shape = Shape::new(form, AspectRatio::Constant(ratio)).unwrap();
            let soot = Inclusion::new("soot", constant(1.75, 0.44), one_size(length), 0.01).with_shape(shape);
            close(soot.mean_volume().unwrap(), shape.volume(length), 1e-12);
            let at = Medium::new(constant(1.0, 0.0), vec![soot]).unwrap().optics_at(GREEN, 1e-4).unwrap();
            let number = 0.01 / shape.volume(length);
            close(at.sigma_s + at.sigma_a, number * 2.0 * shape.area(length) / 4.0, 0.03);
        }
    }
    let cylinder = Shape::new(Form::Cylinder, AspectRatio::Constant(4.0)).unwrap();
    let sigma_t = |equivalence| {
        let rods = Inclusion::new("rods", constant(1.5, 0.01), log_normal(40e-6, 1.3), 0.01);
        let at = medium(vec![rods.with_shape(cylinder.with_equivalence(equivalence))]).optics_at(GREEN, 1e-3).unwrap();
        at.sigma_s + at.sigma_a
    };
    let [both, volume, area] = [Equivalence::VolumeToArea, Equivalence::Volume, Equivalence::Area].map(sigma_t);
    // One sphere of the same volume shows less area; one of the same area shows the same.
    assert!(volume < 0.9 * both);
    close(area, both, 0.03);
}

/// Number, not volume, is what a distribution over lengths keeps where proportions change with length.
#[test]
fn lengths_are_counted_as_the_distribution_says() {
    let aspect = AspectRatio::Power { factor: 10.3, exponent: 0.67 };
    let shape = Shape::new(Form::Cylinder, aspect).unwrap();
    let (from, to, exponent) = (0.5e-3, 14.6e-3, 1.96);
    let sizes = SizeDistribution::PowerLaw(PowerLaw::new(exponent, from, to).unwrap());
    let tubes = Inclusion::new("tubes", constant(1.34, 0.0), sizes, 0.01).with_shape(shape);
    // V = pi/4 l^3 / gamma^2 = pi/4 / 10.3^2 l^(3 - 1.34) mm^1.34
    let p = 1.66 - exponent + 1.0;
    let volume = PI / 4.0 / 10.3f64.powi(2) * 1e-3f64.powf(1.34) * (to.powf(p) - from.powf(p)) / p;
    let number = (to.powf(1.0 - exponent) - from.powf(1.0 - exponent)) / (1.0 - exponent);
    close(tubes.mean_volume().unwrap(), volume / number, 1e-7);
}

/// A sum is its parts, each by its own volume.
#[test]
fn a_sum_of_sizes_is_its_parts() {
    let parts = [log_normal(0.1e-6, 1.4), one_size(1e-6)];
    let mix = MixedSizes::new(Weighting::Volume, vec![(0.3, parts[0].clone()), (0.7, parts[1].clone())]).unwrap();
    let glass = || constant(1.5, 1e-5);
    let mixed = medium(vec![Inclusion::new("beads", glass(), SizeDistribution::Mixture(mix), 0.01)]);
    let [a, b] = parts;
    let apart = medium(vec![Inclusion::new("small", glass(), a, 0.003), Inclusion::new("large", glass(), b, 0.007)]);
    let (found, expected) = (mixed.optics_at(GREEN, 1e-6).unwrap(), apart.optics_at(GREEN, 1e-6).unwrap());
    close(found.sigma_s, expected.sigma_s, 1e-6);
    close(found.asymmetry, expected.asymmetry, 1e-6);
    close(found.n_real, expected.n_real, 1e-9);
    let [p, q] = [&mixed, &apart].map(|m| m.phase_at(GREEN, 1e-3).unwrap());
    for mu in [-1.0, 0.0, 0.7, 1.0] {
        close(p.value(mu), q.value(mu), 5e-3);
    }
}

/// Dense beads scatter less and less forward; few do not notice each other; table, moments and coefficients agree.
#[test]
fn packed_spheres_interfere() {
    let beads = |fraction, packing| {
        let glass = constant(1.59, 0.0);
        Medium::new(
            constant(1.33, 0.0),
            vec![Inclusion::new("b", glass, one_size(0.23e-6), fraction).with_packing(packing)],
        )
        .unwrap()
    };
    let few = [Packing::PercusYevick, Packing::Independent].map(|p| beads(1e-5, p).optics_at(GREEN, 1e-4).unwrap());
    close(few[0].sigma_s, few[1].sigma_s, 2e-4);
    let (packed, alone) = (beads(0.3, Packing::PercusYevick), beads(0.3, Packing::Independent));
    let [dense, free] = [&packed, &alone].map(|m| m.optics_at(GREEN, 1e-4).unwrap());
    assert!(dense.sigma_s < 0.6 * free.sigma_s && dense.asymmetry < free.asymmetry);
    // By hand: Simpson's rule over the angle on the phase function of one sphere.
    let s = scatter_sphere(0.23e-6, GREEN, 1.33.into(), 1.59.into()).unwrap();
    let (p, fluid) = (alone.phase_at(GREEN, 1e-5).unwrap(), HardSpheres::new(0.3));
    let (steps, mut sums) = (20_000, [0.0; 2]);
    for i in 0..=steps {
        let theta = PI * f64::from(i) / f64::from(steps);
        let weight = if i == 0 || i == steps { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
        let q = 4.0 * PI * 1.33 / GREEN * (0.5 * theta).sin();
        let f = weight * theta.sin() * p.value(theta.cos()) * fluid.structure_factor(q * 0.46e-6);
        sums[0] += 2.0 * PI * PI / f64::from(steps) / 3.0 * f;
        sums[1] += 2.0 * PI * PI / f64::from(steps) / 3.0 * f * theta.cos();
    }
    close(dense.sigma_s, sums[0] * s.scattering * 0.3 / sphere_volume(0.23e-6), 1e-4);
    close(dense.asymmetry, sums[1] / sums[0], 1e-4);
    close(packed.phase_at(GREEN, 1e-4).unwrap().asymmetry(), dense.asymmetry, 1e-3);
    close(packed.legendre_moments_at(GREEN, 3, 1e-4).unwrap()[1], dense.asymmetry, 1e-6);
    close(
        packed.phase_at(GREEN, 1e-4).unwrap().value(-0.5),
        p.value(-0.5) * fluid.structure_factor(4.0 * PI * 1.33 / GREEN * 0.75f64.sqrt() * 0.46e-6) / sums[0],
        1e-3,
    );
}

/// In the limit of small spheres nothing is left of the light but fluctuations of their number: `S(0)`.
#[test]
fn small_packed_spheres_scatter_by_compressibility() {
    for fraction in [0.1f64, 0.4] {
        let sigma_s = |packing| {
            let grains = Inclusion::new("grains", constant(1.46, 0.0), one_size(1e-9), fraction).with_packing(packing);
            Medium::new(constant(1.33, 0.0), vec![grains]).unwrap().optics_at(GREEN, 1e-4).unwrap().sigma_s
        };
        let expected = (1.0 - fraction).powi(4) / (1.0 + 2.0 * fraction).powi(2);
        close(sigma_s(Packing::PercusYevick) / sigma_s(Packing::Independent), expected, 1e-3);
    }
}

#[test]
fn what_goes_not_together_is_refused() {
    let rods = Shape::new(Form::Cylinder, AspectRatio::Constant(3.0)).unwrap();
    let coat = Coat::new(Substance::Air, CoatExtent::RadiusRatio(0.5)).unwrap();
    let make = |f: &dyn Fn(Inclusion) -> Inclusion, fraction| {
        let inclusion = Inclusion::new("grains", constant(1.5, 0.0), one_size(1e-6), fraction);
        Medium::new(constant(1.33, 0.0), vec![f(inclusion)]).unwrap_err()
    };
    let coated = make(&|i| i.with_shape(rods).with_coats(vec![coat.clone()], SizedBy::Core), 0.1);
    assert!(matches!(coated, MediumError::NotSpheres { what: "coats", .. }));
    let packed = make(&|i| i.with_shape(rods).with_packing(Packing::PercusYevick), 0.1);
    assert!(matches!(packed, MediumError::NotSpheres { .. }));
    let dense = make(&|i| i.with_packing(Packing::PercusYevick), 0.55);
    assert!(matches!(dense, MediumError::Packing { .. }), "{dense}");
    let needles = Shape::new(Form::Cylinder, AspectRatio::Constant(50.0)).unwrap().with_equivalence(Equivalence::Area);
    assert!(matches!(make(&|i| i.with_shape(needles), 0.9), MediumError::OverfullSpheres { .. }));
}

fn sizes() -> impl Strategy<Value = SizeDistribution> {
    let radius = || (-8.3f64..-6.2).prop_map(|r| 10f64.powf(r));
    prop_oneof![
        radius().prop_map(one_size),
        (radius(), 1.05f64..1.6).prop_map(|(r, s)| log_normal(r, s)),
        (radius(), 0.01f64..0.45).prop_map(|(r, b)| SizeDistribution::Gamma(Gamma::new(r, b).unwrap())),
        (radius(), 0.0f64..6.0).prop_map(|(r, a)| SizeDistribution::PowerLaw(PowerLaw::new(a, r, 20.0 * r).unwrap())),
        (radius(), 1.5f64..4.0).prop_map(|(r, n)| SizeDistribution::RosinRammler(RosinRammler::new(r, n).unwrap())),
        (radius(), 0.1f64..1.0).prop_map(|(r, d)| {
            let table = TabulatedSizes::from_bins(Weighting::Number, &[0.5 * r, r, 2.0 * r], &[1.0, d]);
            SizeDistribution::Tabulated(table.unwrap())
        }),
    ]
}

fn inclusion() -> impl Strategy<Value = Inclusion> {
    let form = prop_oneof![
        Just(Form::Sphere),
        Just(Form::Sphere),
        Just(Form::Ellipsoid),
        Just(Form::Cylinder),
        Just(Form::HexagonalPrism)
    ];
    let index = || (0.9f64..2.2, -9.0f64..0.3).prop_map(|(n, k)| constant(n, 10f64.powf(k)));
    let equivalence = prop_oneof![Just(Equivalence::VolumeToArea), Just(Equivalence::Volume)];
    (sizes(), form, 0.1f64..8.0, equivalence, index(), index(), 0.01f64..0.99, 0.0f64..0.3, 0u8..4).prop_map(
        |(sizes, form, ratio, equivalence, core, coat, share, fraction, extra)| {
            let shape = Shape::new(form, AspectRatio::Constant(ratio)).unwrap().with_equivalence(equivalence);
            let inclusion = Inclusion::new("grains", core, sizes, fraction).with_shape(shape);
            let coat = Coat::new(coat, CoatExtent::VolumeShare(share)).unwrap();
            match extra {
                0 if form == Form::Sphere => inclusion.with_coats(vec![coat], SizedBy::Outside),
                1 if form == Form::Sphere => inclusion.with_packing(Packing::PercusYevick),
                _ => inclusion,
            }
        },
    )
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(48))]
    /// Whatever is mixed into a host that may absorb: no coefficient is negative.
    #[test]
    fn mixtures_never_have_negative_coefficients(
        host in (1.0f64..1.6, -10.0f64..-4.0), inclusions in proptest::collection::vec(inclusion(), 1..4),
        wavelength in 400e-9f64..800e-9,
    ) {
        let medium = Medium::new(constant(host.0, 10f64.powf(host.1)), inclusions).unwrap();
        let at = medium.optics_at(wavelength, 1e-2).unwrap();
        proptest::prop_assert!(at.sigma_s >= 0.0 && at.sigma_a >= 0.0, "{at:?}");
        proptest::prop_assert!(at.asymmetry.abs() <= 1.0 && at.n_real > 0.0, "{at:?}");
    }
}
