//! Single particles against an arbitrary-precision evaluation of the series (`benches/oracle/mie_oracle.py`).

#![allow(clippy::print_stdout)] // figures for whoever runs it with --nocapture

use std::collections::BTreeMap;

use mieux_optics::Complex64;
use mieux_optics::mie::{
    Coefficients, Directions, Layer, LayeredSphere, MieError, PlaneWave, ScatteringDefinition, Sphere, SphereScattering,
};

const TABLE: &str = include_str!("data/mie_oracle.csv");

/// Above this share of the error that rounding the inputs forces anyway, a result counts as wrong.
const FORCED: f64 = 50.0;

/// Error allowed in any case.
const FLOOR: f64 = 1e-12;

/// One row, by the names of its columns.
struct Case<'a> {
    columns: &'a BTreeMap<&'a str, usize>,
    cells: Vec<&'a str>,
}

impl Case<'_> {
    fn text(&self, name: &str) -> &str {
        self.cells[self.columns[name]]
    }

    fn number(&self, name: &str) -> Option<f64> {
        self.text(name).parse().ok()
    }

    fn wave(&self) -> PlaneWave {
        let number = |name| self.number(name).expect("a number");
        let host = Complex64::new(number("host_re"), number("host_im"));
        PlaneWave::new(number("wavelength_m"), host).expect("a wave")
    }

    /// By the definition of Mishchenko and Yang, unless that overflows.
    fn far_field(&self) -> Option<SphereScattering> {
        self.number("my_c_sca_m2").filter(|c| c.is_finite())?;
        let wave = self.wave().with_definition(ScatteringDefinition::MishchenkoYang2018);
        self.coefficients(wave)?.scattering().ok()
    }

    fn coefficients(&self, wave: PlaneWave) -> Option<Coefficients> {
        let layers: Vec<[f64; 3]> = self
            .text("layers")
            .split(';')
            .map(|layer| {
                let mut parts = layer.split(':').map(|part| part.parse::<f64>().expect("a number"));
                std::array::from_fn(|_| parts.next().expect("radius:re:im"))
            })
            .collect();
        let sphere = match layers[..] {
            [[radius, re, im]] => Sphere::new(wave, radius, Complex64::new(re, im)).map(|s| s.coefficients()),
            _ => {
                let layer = |&[radius, re, im]: &[f64; 3]| Layer { radius, index: Complex64::new(re, im) };
                let layers: Vec<Layer> = layers.iter().map(layer).collect();
                LayeredSphere::new(wave, &layers).map(|s| s.coefficients())
            }
        };
        match sphere {
            Err(MieError::HostAbsorption { .. }) => None,
            sphere => Some(sphere.unwrap_or_else(|error| panic!("{}: {error}", self.text("id")))),
        }
    }
}

/// The worst relation of error to what is allowed, and where.
#[derive(Default)]
struct Worst {
    ratio: f64,
    error: f64,
    place: String,
}

impl Worst {
    /// `condition` is the sum of the moduli of what is added up over the modulus of the sum.
    fn meet(&mut self, case: &Case, name: &str, error: f64, condition: f64) {
        let forced = case.number(&format!("{name}_forced")).expect("a number");
        let ratio = error / FLOOR.max(FORCED * forced.max(0.5 * f64::EPSILON * condition));
        // NaN is the worst of all.
        if ratio > self.ratio || ratio.is_nan() {
            *self = Self { ratio, error, place: format!("{} {name} (forced {forced:e})", case.text("id")) };
        }
    }
}

#[test]
fn the_series_is_summed_as_well_as_arithmetic_allows() {
    let mut lines = TABLE.lines().filter(|line| !line.starts_with('#'));
    let columns: BTreeMap<&str, usize> =
        lines.next().expect("names").split(',').enumerate().map(|(i, n)| (n, i)).collect();
    let cosine = |degrees: f64| degrees.to_radians().cos();
    let angles = [("0", 1.0), ("30", cosine(30.0)), ("90", 0.0), ("175", -cosine(5.0)), ("180", -1.0)];
    let directions = Directions::new(angles.map(|(_, mu)| mu));
    let mut worst: BTreeMap<String, Worst> = BTreeMap::new();
    let mut count = 0;
    for line in lines {
        let case = Case { columns: &columns, cells: line.split(',').collect() };
        let Some(coefficients) = case.coefficients(case.wave()) else { continue };
        count += 1;
        let worst = worst.entry(case.text("group").to_owned()).or_default();
        let moduli: f64 =
            coefficients.terms().enumerate().map(|(i, [a, b])| (i as f64 + 1.5) * (a.norm() + b.norm())).sum();
        let amplitudes = coefficients.amplitudes(&directions);
        // Of the sum that extinction is taken from; lossless hosts have better ways to it.
        let condition = match &amplitudes {
            Ok(amplitudes) if coefficients.size_parameter().im > 0.0 => moduli / amplitudes[0][0].norm(),
            _ => 1.0,
        };
        let mut values = vec![];
        match coefficients.scattering() {
            Ok(s) => values.extend([
                ("c_ext_m2", s.extinction),
                ("c_sca_m2", s.scattering),
                ("c_abs_m2", s.absorption),
                ("g", s.asymmetry),
            ]),
            Err(error) => println!("{}: {error}", case.text("id")),
        }
        if let Some(far) = case.far_field() {
            values.extend([("my_c_ext_m2", far.extinction), ("my_c_sca_m2", far.scattering)]);
        }
        values.retain(|(name, _)| case.number(name).is_some());
        for (name, value) in values {
            let expected = case.number(name).expect("kept");
            let error = if expected == 0.0 { value.abs() } else { (value / expected - 1.0).abs() };
            worst.meet(&case, name, error, condition);
        }
        for ((angle, _), amplitudes) in angles.iter().zip(amplitudes.into_iter().flatten()) {
            for (i, amplitude) in amplitudes.into_iter().enumerate() {
                let name = format!("s{}_{angle}", i + 1);
                let part = |part: &str| case.number(&format!("{name}_{part}"));
                if let (Some(re), Some(im)) = (part("re"), part("im")) {
                    let expected = Complex64::new(re, im);
                    let size = expected.norm();
                    worst.meet(&case, &name, (amplitude - expected).norm() / size, moduli / size);
                }
            }
        }
    }
    for (group, worst) in &worst {
        println!("{group:18} {:8.2e} of the bound, error {:.2e}: {}", worst.ratio, worst.error, worst.place);
    }
    println!("{count} cases");
    for (group, worst) in worst {
        assert!(worst.ratio <= 1.0, "{group}: {}, error {:e}", worst.place, worst.error);
    }
}
