//! Plane-parallel matter: layers on top of each other, what lies above and below.

use super::{Moments, TransferError};

/// A homogeneous layer between two smooth planes. Where its refractive index differs from its neighbour's, Fresnel's
/// laws hold at the plane between them.
#[derive(Debug, Clone, PartialEq)]
pub struct Layer {
    /// Extinction coefficient times thickness, from 0 up.
    pub optical_thickness: f64,
    /// Scattering over extinction coefficient, in [0, 1].
    pub albedo: f64,
    /// How the scattered light spreads over angle.
    pub moments: Moments,
    /// Real refractive index.
    pub refractive_index: f64,
    /// Radiance of a black body (of index 1) at the temperature of the top and of the bottom, linear in optical depth
    /// between; the layer emits `(1 - albedo)` of it per optical thickness. Any unit of radiance.
    pub emission: [f64; 2],
}

impl Layer {
    /// A layer that scatters and absorbs, of index 1, without emission.
    pub fn new(optical_thickness: f64, albedo: f64, moments: Moments) -> Self {
        Self { optical_thickness, albedo, moments, refractive_index: 1.0, emission: [0.0; 2] }
    }

    /// A clear pane, such as a microscope slide: it has an index and may absorb, but does not scatter.
    pub fn pane(refractive_index: f64, optical_thickness: f64) -> Self {
        Self { refractive_index, ..Self::new(optical_thickness, 0.0, Moments::isotropic()) }
    }

    /// The same with another refractive index.
    pub fn with_index(self, refractive_index: f64) -> Self {
        Self { refractive_index, ..self }
    }

    /// Whether light is scattered or made here.
    pub(crate) fn is_active(&self) -> bool {
        self.optical_thickness > 0.0 && (self.albedo > 0.0 || self.emission != [0.0; 2])
    }
}

/// What meets the light that leaves the stack downward, beyond the last plane.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Ground {
    /// Nothing comes back.
    #[default]
    Black,
    /// Reflects this share into all directions with equal radiance.
    Lambertian(f64),
    /// A mirror that reflects this share at every angle.
    Mirror(f64),
}

impl Ground {
    /// The share of light it reflects.
    pub fn reflectance(self) -> f64 {
        match self {
            Self::Black => 0.0,
            Self::Lambertian(share) | Self::Mirror(share) => share,
        }
    }
}

/// Layers between two half-spaces. Light falls in from above, from below, or is made inside.
#[derive(Debug, Clone, PartialEq)]
pub struct Stack {
    /// Refractive index of the half-space above, where the light comes from.
    pub above: f64,
    /// From the top down.
    pub layers: Vec<Layer>,
    /// Refractive index of what lies below the last plane.
    pub below: f64,
    /// What the light meets there. A ground in optical contact with the last layer has `below` equal to its index; one
    /// behind a gap of air has `below` equal to 1.
    pub ground: Ground,
}

impl Stack {
    /// One layer in air, or whatever has index 1.
    pub fn slab(layer: Layer) -> Self {
        Self { above: 1.0, layers: vec![layer], below: 1.0, ground: Ground::Black }
    }

    /// The same over another ground.
    pub fn over(self, ground: Ground) -> Self {
        Self { ground, ..self }
    }

    /// # Errors
    /// [`TransferError`], naming the layer and the value that no matter can have.
    pub fn check(&self) -> Result<(), TransferError> {
        let indices = self.layers.iter().map(|layer| layer.refractive_index).chain([self.above, self.below]);
        if let Some(value) = indices.into_iter().find(|n| !(0.1..=10.0).contains(n)) {
            return Err(TransferError::RefractiveIndex { value });
        }
        for (layer, Layer { optical_thickness, albedo, emission, .. }) in self.layers.iter().enumerate() {
            if !(*optical_thickness >= 0.0 && optical_thickness.is_finite()) {
                return Err(TransferError::OpticalThickness { layer, value: *optical_thickness });
            }
            if !(0.0..=1.0).contains(albedo) {
                return Err(TransferError::Albedo { layer, value: *albedo });
            }
            if let Some(&value) = emission.iter().find(|b| !(**b >= 0.0 && b.is_finite())) {
                return Err(TransferError::Source { value });
            }
        }
        let value = self.ground.reflectance();
        if !(0.0..=1.0).contains(&value) {
            return Err(TransferError::Ground { value });
        }
        Ok(())
    }
}

/// How light falls onto the top of a stack.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Incidence {
    /// From one direction; the cosine of its angle with the normal, in (0, 1], in the medium above.
    Beam(f64),
    /// Equal radiance from all directions.
    Diffuse,
}

impl Incidence {
    /// Along the normal.
    pub const NORMAL: Self = Self::Beam(1.0);
}

/// Where the light goes, as shares of what falls onto the top.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shares {
    /// All that goes back up, the surface's own reflection included.
    pub reflectance: f64,
    /// All that passes the last plane and does not come back: into the half-space below, or into the ground.
    pub transmittance: f64,
    /// All that stays in the layers.
    pub absorptance: f64,
    /// The part of the reflectance that was never scattered: by the surfaces, and by a mirror below.
    pub reflectance_specular: f64,
    /// The part of the transmittance that was never scattered, neither inside nor by the ground.
    pub transmittance_unscattered: f64,
}
