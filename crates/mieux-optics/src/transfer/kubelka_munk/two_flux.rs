//! A whole stack by two diffuse fluxes, to be compared with solvers that follow directions.

use super::Film;
use crate::integrate::gauss_legendre;
use crate::transfer::fresnel::{DiffuseReflectance, dielectric_reflectance};
use crate::transfer::{Ground, Incidence, Layer, Shares, Stack, TransferError};

/// Directions over which the unscattered part of diffuse light is averaged.
const DIRECTIONS: usize = 64;

/// Where the light goes that falls onto a stack, by two fluxes: every layer as a [`Film`] of `K = 2 sigma_a` and
/// `S = 3/4 sigma_s (1 - g)`, planes by their diffuse Fresnel reflectances, joined by adding. Emission is left out.
///
/// A beam counts as diffuse from the first plane on, so stacks that are optically thin are far off, and may even be said to
/// reflect less than the specular part. `reflectance_specular` and `transmittance_unscattered` do not share this: they are
/// Beer's law and Fresnel's along each direction.
///
/// # Errors
/// [`TransferError`] for matter or light that cannot be.
pub fn shares(stack: &Stack, incidence: Incidence) -> Result<Shares, TransferError> {
    stack.check()?;
    let below = below_first_plane(stack)?;
    let first = stack.layers.first().map_or(stack.below, |layer| layer.refractive_index);
    let plane = Plane::new(stack.above, first)?;
    let (reflectance, transmittance, absorptance, unscattered) = match incidence {
        Incidence::Beam(cosine) => {
            if !(cosine > 0.0 && cosine <= 1.0) {
                return Err(TransferError::Cosine { value: cosine });
            }
            let mirrored = dielectric_reflectance(cosine, first / stack.above);
            let entering = (1.0 - mirrored) * below.enhancement(plane.from_below);
            let up = mirrored + entering * below.reflected * (1.0 - plane.from_below);
            (up, entering * below.passed, entering * below.kept, unscattered(stack, cosine))
        }
        Incidence::Diffuse => {
            let entering = (1.0 - plane.from_above) * below.enhancement(plane.from_below);
            let up = plane.from_above + entering * below.reflected * (1.0 - plane.from_below);
            (up, entering * below.passed, entering * below.kept, diffuse_unscattered(stack))
        }
    };
    Ok(Shares {
        reflectance,
        transmittance,
        absorptance,
        reflectance_specular: unscattered[0],
        transmittance_unscattered: unscattered[1],
    })
}

/// What everything below some level does to a diffuse flux of 1: the three add up to 1, each with its own digits.
#[derive(Clone, Copy)]
struct Below {
    reflected: f64,
    passed: f64,
    kept: f64,
}

impl Below {
    /// The flux down when one of 1 is let in and the share `mirrored` of what comes up is sent back.
    fn enhancement(&self, mirrored: f64) -> f64 {
        let lost = (1.0 - mirrored) + mirrored * (self.passed + self.kept);
        if lost > 0.0 { 1.0 / lost } else { 0.0 }
    }

    /// The same with a plane above.
    fn under_plane(self, plane: &Plane) -> Self {
        let entering = (1.0 - plane.from_above) * self.enhancement(plane.from_below);
        Self {
            reflected: plane.from_above + entering * self.reflected * (1.0 - plane.from_below),
            passed: entering * self.passed,
            kept: entering * self.kept,
        }
    }

    /// The same with a film above.
    fn under_film(self, film: &Film) -> Self {
        let [reflected, passed, kept] = film.shares();
        let lost = (passed + kept) + reflected * (self.passed + self.kept);
        let entering = if lost > 0.0 { passed / lost } else { 0.0 };
        Self {
            reflected: reflected + entering * self.reflected * passed,
            passed: entering * self.passed,
            kept: kept + entering * (self.kept + self.reflected * kept),
        }
    }
}

/// Shares of diffuse light that a plane sends back.
struct Plane {
    from_above: f64,
    from_below: f64,
}

impl Plane {
    fn new(above: f64, below: f64) -> Result<Self, TransferError> {
        let of = DiffuseReflectance::new(below / above).ok_or(TransferError::RefractiveIndex { value: below })?;
        Ok(Self { from_above: of.external, from_below: of.internal() })
    }
}

fn below_first_plane(stack: &Stack) -> Result<Below, TransferError> {
    let reflected = stack.ground.reflectance();
    let mut below = Below { reflected, passed: 1.0 - reflected, kept: 0.0 };
    let mut index = stack.below;
    for (number, layer) in stack.layers.iter().enumerate().rev() {
        below = below.under_plane(&Plane::new(layer.refractive_index, index)?);
        below = below.under_film(&film(number, layer)?);
        index = layer.refractive_index;
    }
    Ok(below)
}

fn film(number: usize, layer: &Layer) -> Result<Film, TransferError> {
    let tau = layer.optical_thickness;
    let found = Film::of_medium((1.0 - layer.albedo) * tau, layer.albedo * tau, layer.moments.asymmetry(), 1.0);
    found.map_err(|_| TransferError::OpticalThickness { layer: number, value: tau })
}

/// Shares that are reflected, and that pass into the ground, without having been scattered; of light of this cosine above.
fn unscattered(stack: &Stack, cosine: f64) -> [f64; 2] {
    let (mut mirrored, mut passed) = match stack.ground {
        Ground::Mirror(share) => (share, 1.0 - share),
        Ground::Lambertian(share) => (0.0, 1.0 - share),
        Ground::Black => (0.0, 1.0),
    };
    let along = |index: f64| {
        let sine2 = (1.0 - cosine * cosine) * (stack.above / index).powi(2);
        (sine2 < 1.0).then(|| if index == stack.above { cosine } else { (1.0 - sine2).sqrt() })
    };
    let mut below = stack.below;
    for index in stack.layers.iter().rev().map(|layer| (layer.refractive_index, layer.optical_thickness)) {
        let (index, tau) = index;
        if let Some(here) = along(index) {
            under_plane(&mut mirrored, &mut passed, dielectric_reflectance(here, below / index));
            let once = (-tau / here).exp();
            mirrored *= once * once;
            passed *= once;
        }
        below = index;
    }
    under_plane(&mut mirrored, &mut passed, dielectric_reflectance(cosine, below / stack.above));
    [mirrored, passed]
}

fn under_plane(mirrored: &mut f64, passed: &mut f64, plane: f64) {
    let lost = 1.0 - plane * *mirrored;
    let entering = if lost > 0.0 { (1.0 - plane) / lost } else { 0.0 };
    *passed *= entering;
    *mirrored = plane + entering * *mirrored * (1.0 - plane);
}

fn diffuse_unscattered(stack: &Stack) -> [f64; 2] {
    let mut sum = [0.0; 2];
    for (node, weight) in gauss_legendre(DIRECTIONS) {
        let cosine = 0.5 * (1.0 + node);
        let found = unscattered(stack, cosine);
        (0..2).for_each(|i| sum[i] += weight * cosine * found[i]);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transfer::{DiscreteOrdinates, Moments};

    fn thick(albedo: f64, g: f64, index: f64) -> Stack {
        Stack::slab(Layer::new(1e6, albedo, Moments::henyey_greenstein(g).unwrap()).with_index(index))
    }

    fn error(stack: &Stack, incidence: Incidence) -> f64 {
        let exact = DiscreteOrdinates::with_streams(32).unwrap().shares(stack, incidence).unwrap();
        shares(stack, incidence).unwrap().reflectance / exact.reflectance - 1.0
    }

    /// What it costs to follow two fluxes only.
    #[test]
    fn the_error_under_diffuse_light_is_what_the_documentation_says() {
        for (albedo, expected, digits) in [(0.5, -0.05, 0.005), (0.99, -0.002, 0.0005)] {
            let found = error(&thick(albedo, 0.0, 1.0), Incidence::Diffuse);
            assert!((found - expected).abs() < digits, "{albedo}: {found}");
        }
        // A refracting surface takes the light inside for Lambertian, which it is not: 0.299 for 0.260.
        let surface = thick(0.9, 0.0, 1.5);
        let found = shares(&surface, Incidence::NORMAL).unwrap().reflectance;
        assert!((found - 0.299).abs() < 0.005, "{found}");
        let found = error(&surface, Incidence::NORMAL);
        assert!((found - 0.15).abs() < 0.02, "{found}");
    }

    #[test]
    fn energy_is_kept_and_unscattered_light_is_exact() {
        let layer = |tau: f64, albedo: f64, index: f64| {
            Layer::new(tau, albedo, Moments::henyey_greenstein(0.7).unwrap()).with_index(index)
        };
        for tau in [0.0, 1e-8, 0.5, 30.0, 1e6] {
            for albedo in [0.0, 0.7, 1.0] {
                for ground in [Ground::Black, Ground::Lambertian(0.6), Ground::Lambertian(1.0), Ground::Mirror(0.5)] {
                    let layers = vec![layer(tau, albedo, 1.5), layer(0.3, albedo, 1.2), layer(0.1, albedo, 1.4)];
                    let stack = Stack { above: 1.0, layers, below: 1.4, ground };
                    for incidence in [Incidence::NORMAL, Incidence::Beam(0.3), Incidence::Diffuse] {
                        let found = shares(&stack, incidence).unwrap();
                        let sum = found.reflectance + found.transmittance + found.absorptance;
                        assert!((sum - 1.0).abs() < 1e-9, "{tau} {albedo} {ground:?} {incidence:?}: {found:?}");
                        let exact = DiscreteOrdinates::with_streams(16).unwrap().shares(&stack, incidence).unwrap();
                        let digits = if incidence == Incidence::Diffuse { 5e-3 } else { 1e-10 };
                        let off = (found.reflectance_specular - exact.reflectance_specular).abs()
                            + (found.transmittance_unscattered - exact.transmittance_unscattered).abs();
                        assert!(off < digits, "{tau} {albedo} {ground:?} {incidence:?}: {found:?} {exact:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let stack = thick(0.5, 0.0, 1.0);
        for cosine in [0.0, -1.0, 1.1, f64::NAN] {
            assert!(matches!(shares(&stack, Incidence::Beam(cosine)), Err(TransferError::Cosine { .. })));
        }
        let dark = stack.over(Ground::Lambertian(2.0));
        assert!(shares(&dark, Incidence::Diffuse).is_err());
    }
}
