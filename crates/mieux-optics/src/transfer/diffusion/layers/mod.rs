//! One-dimensional diffusion through a whole stack, in closed form layer by layer.
//!
//! In each turbid layer radiance is linear in the cosine (the first-order spherical harmonics), its forward peak counts
//! as not scattered (`joseph1976`), and the beam with all its reflections is the source. At refracting planes, and at the
//! clear panes between turbid layers, partial currents are joined by Fresnel's shares integrated over angle
//! (`deon2011`). A layer is a resistance between two leaks, so that the sweep from the ground up has nothing that grows.

mod beam;
mod interface;
mod turbid;

use super::super::{Ground, Incidence, Shares, Stack, TransferError};
use crate::integrate::gauss_legendre;
use beam::{Line, line};
use interface::Interface;
use turbid::Turbid;

/// Where the light goes that falls onto a stack, by diffusion; emission is left out. Shares mean what they mean in
/// [`crate::transfer::DiscreteOrdinates::shares`]; those that were never scattered are exact, and so is a stack in which nothing
/// scatters. Diffuse light is a sum of beams.
///
/// Shares add up to 1 by construction, and without absorption reflectance and transmittance do so alone. Against
/// discrete ordinates, one layer, in numbers out of 1 and by reduced thickness `(1 - g) tau` and reduced albedo: within
/// 0.005 from thickness 10 and albedo 0.999 on; within 0.023 at any albedo from thickness 5 on; within 0.033 everywhere if
/// scattering is isotropic. Thin, forward scattering layers under oblique light are worst (0.08 of transmittance at
/// thickness 0.5, g 0.8, index 1.5 and 60 degrees). Small shares may be off by much of themselves: a black body of albedo
/// 0.1 and index 1.5 is said to return 0.0017 more than the right 0.0056. docs/diffusion.md has the table.
///
/// # Errors
/// [`TransferError`] for matter or light that cannot be.
pub fn shares(stack: &Stack, incidence: Incidence) -> Result<Shares, TransferError> {
    stack.check()?;
    let beams = match incidence {
        Incidence::Beam(cosine) if cosine > 0.0 && cosine <= 1.0 => vec![(cosine, 1.0)],
        Incidence::Beam(value) => return Err(TransferError::Cosine { value }),
        Incidence::Diffuse => diffuse(stack),
    };
    Ok(Chain::new(stack).shares(&beams))
}

/// Cosines and shares of diffuse light; panels end where light begins to be totally reflected.
fn diffuse(stack: &Stack) -> Vec<(f64, f64)> {
    let indices = stack.layers.iter().map(|layer| layer.refractive_index).chain([stack.below]);
    let knots = interface::knots(stack.above, indices);
    let rule = gauss_legendre(16);
    let panels = knots.windows(2);
    let beams = panels.flat_map(|ends| {
        let (half, middle) = (0.5 * (ends[1] - ends[0]), 0.5 * (ends[0] + ends[1]));
        rule.iter().map(move |(x, w)| (middle + half * x, 2.0 * half * w * (middle + half * x)))
    });
    let beams: Vec<(f64, f64)> = beams.collect();
    let sum: f64 = beams.iter().map(|beam| beam.1).sum();
    beams.into_iter().map(|(cosine, share)| (cosine, share / sum)).collect()
}

/// The stack as turbid layers with interfaces around each, in which clear layers have gone.
struct Chain<'a> {
    stack: &'a Stack,
    turbid: Vec<Turbid>,
    /// One more than turbid layers.
    interfaces: Vec<Interface>,
    /// What the ground sends back as a mirror, and into all directions.
    mirror: f64,
    lambert: f64,
}

impl<'a> Chain<'a> {
    fn new(stack: &'a Stack) -> Self {
        let (mirror, lambert) = match stack.ground {
            Ground::Black => (0.0, 0.0),
            Ground::Mirror(share) => (share, 0.0),
            Ground::Lambertian(share) => (0.0, share),
        };
        let (mut turbid, mut interfaces) = (Vec::new(), Vec::new());
        let (mut indices, mut panes) = (vec![stack.above], Vec::new());
        for (place, layer) in stack.layers.iter().enumerate() {
            indices.push(layer.refractive_index);
            if layer.optical_thickness > 0.0 && layer.albedo > 0.0 {
                interfaces.push(Interface::new(&indices, &panes, 0.0));
                turbid.push(Turbid::new(place, layer));
                (indices, panes) = (vec![layer.refractive_index], Vec::new());
            } else {
                panes.push(layer.optical_thickness);
            }
        }
        indices.push(stack.below);
        interfaces.push(Interface::new(&indices, &panes, mirror));
        Self { stack, turbid, interfaces, mirror, lambert }
    }

    fn shares(mut self, beams: &[(f64, f64)]) -> Shares {
        let (mut reflected, mut on_ground) = (0.0, 0.0);
        let (mut specular, mut unscattered) = (0.0, 0.0);
        for &(cosine, share) in beams {
            let truly = self.line(cosine, None);
            specular += share * truly.reflected;
            unscattered += share * truly.on_ground;
            let scaled = self.line(cosine, Some(&self.turbid));
            reflected += share * scaled.reflected;
            on_ground += share * scaled.on_ground;
            for layer in &mut self.turbid {
                layer.light(&scaled.layers[layer.place], share);
            }
        }
        let passes = 1.0 - self.mirror;
        let (up, down) = self.diffuse(on_ground * passes);
        let (reflectance, transmittance) = (reflected + up, (1.0 - self.lambert) * down);
        Shares {
            reflectance,
            transmittance,
            absorptance: 1.0 - reflectance - transmittance,
            reflectance_specular: specular,
            transmittance_unscattered: unscattered * passes * (1.0 - self.lambert),
        }
    }

    /// A beam of flux 1, with true optical thicknesses or with those that are left when peaks count as not scattered.
    fn line(&self, cosine: f64, scaled: Option<&[Turbid]>) -> Line {
        let inner = self.stack.layers.iter().map(|layer| layer.refractive_index);
        let indices: Vec<f64> = std::iter::once(self.stack.above).chain(inner).chain([self.stack.below]).collect();
        let mut thickness: Vec<f64> = self.stack.layers.iter().map(|layer| layer.optical_thickness).collect();
        for layer in scaled.unwrap_or_default() {
            thickness[layer.place] = layer.thickness;
        }
        line(&indices, &thickness, cosine, self.mirror)
    }

    /// Diffuse flux that leaves at the top, and all flux that meets the ground (beyond its mirror), of which the beam
    /// brings some.
    fn diffuse(&self, beam: f64) -> (f64, f64) {
        let last = &self.interfaces[self.turbid.len()];
        // What the ground sends up comes back to it from the planes above.
        let ground = divided(self.lambert, 1.0 - 2.0 * last.below.reflected[0] * self.lambert);
        let received = |passed: f64| divided(beam + passed, 1.0 - 2.0 * last.below.reflected[0] * self.lambert);
        if self.turbid.is_empty() {
            let down = received(0.0);
            return (2.0 * last.below.passed[0] * self.lambert * down, down);
        }

        // From the ground up: the flux at the top of each layer as a function of its fluence.
        let mut answer = last.onto_ground(ground, beam);
        let mut within = vec![answer; self.turbid.len()];
        let mut tops = within.clone();
        for (place, layer) in self.turbid.iter().enumerate().rev() {
            within[place] = answer;
            tops[place] = layer.above(answer);
            if place > 0 {
                answer = self.interfaces[place].above(tops[place]);
            }
        }

        // And down again.
        let first = &self.interfaces[0];
        let mut fluence = first.below_nothing(tops[0]);
        let up = first.leaving_up(fluence, tops[0].flux(fluence));
        for (place, layer) in self.turbid.iter().enumerate() {
            fluence = layer.below(within[place], fluence);
            if place + 1 < self.turbid.len() {
                let flux = within[place].flux(fluence);
                fluence = self.interfaces[place + 1].below(tops[place + 1], fluence, flux);
            }
        }
        let passed = last.leaving_down(fluence, within[self.turbid.len() - 1].flux(fluence));
        (up, received(passed))
    }
}

fn divided(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}

#[cfg(test)]
mod tests;
