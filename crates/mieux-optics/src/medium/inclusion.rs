//! One kind of particle in a medium.

use super::{Coat, MediumError, Packing, SizedBy};
use crate::integrate::integrate;
use crate::particle::{Equivalence, Form, ParticleError, Shape, SizeDistribution, Smooth, Spread, sphere_volume};
use crate::substance::Substance;

/// One kind of particle: of what, how large, of what shape, how much.
#[derive(Debug, Clone, PartialEq)]
pub struct Inclusion {
    /// What people call it; used in messages and summaries.
    pub name: String,
    /// What it is made of; the core, where it has coats.
    pub substance: Substance,
    /// How large its particles are: radii of spheres, lengths of other shapes.
    pub sizes: SizeDistribution,
    /// Volume of particles, coats included, per volume of medium, 0 to 1.
    pub volume_fraction: f64,
    /// What its particles look like.
    pub shape: Shape,
    /// What lies around the core, from the inside outward; only spheres have coats.
    pub coats: Vec<Coat>,
    /// Which radius of a coated sphere the sizes are about.
    pub sized_by: SizedBy,
    /// Whether its particles get in each other's way.
    pub packing: Packing,
}

impl Inclusion {
    /// Homogeneous spheres that scatter independently.
    pub fn new(name: impl Into<String>, substance: Substance, sizes: SizeDistribution, volume_fraction: f64) -> Self {
        Self {
            name: name.into(),
            substance,
            sizes,
            volume_fraction,
            shape: Shape::SPHERE,
            coats: Vec::new(),
            sized_by: SizedBy::Outside,
            packing: Packing::Independent,
        }
    }

    /// The same particles in another shape; their sizes are lengths then.
    pub fn with_shape(self, shape: Shape) -> Self {
        Self { shape, ..self }
    }

    /// The same cores with coats, from the inside outward.
    pub fn with_coats(self, coats: Vec<Coat>, sized_by: SizedBy) -> Self {
        Self { coats, sized_by, ..self }
    }

    /// The same particles, packed otherwise.
    pub fn with_packing(self, packing: Packing) -> Self {
        Self { packing, ..self }
    }

    /// Mean volume of a particle, coats included, m^3: times their number per volume, the volume fraction.
    ///
    /// # Errors
    /// [`ParticleError::Diverges`] when so many particles are vanishingly small that there is no such mean.
    pub fn mean_volume(&self) -> Result<f64, ParticleError> {
        if self.shape.form() == Form::Sphere && (self.coats.is_empty() || self.sized_by == SizedBy::Outside) {
            return self.sizes.mean_volume();
        }
        // Volume of particles over their number; shares are of the volume that spheres of these sizes would have.
        let (mut volume, mut number) = (0.0, 0.0);
        for part in self.sizes.parts() {
            let share = match part.sizes {
                Spread::One(size) => [self.bulk(size), 1.0 / sphere_volume(size)],
                Spread::Smooth(sizes) => self.mean(sizes)?,
            };
            volume += part.share * share[0];
            number += part.share * share[1];
        }
        Ok(volume / number)
    }

    /// Volume and number of particles per volume that spheres of these sizes would have.
    fn mean(&self, sizes: &dyn Smooth) -> Result<[f64; 2], ParticleError> {
        let knots = sizes.knots(0.0, 4.0).ok_or(ParticleError::Diverges { power: 0.0 })?;
        let unit = sphere_volume(sizes.measure(0.5 * (knots[0] + knots[knots.len() - 1])).0);
        let integral = integrate(&knots, 1e-9, [0.0; 3], |u| {
            let (size, volume) = sizes.measure(u);
            Ok::<_, ParticleError>([volume * self.bulk(size), volume * unit / sphere_volume(size), volume])
        })?;
        let [bulk, number, volume] = integral.ok_or(ParticleError::Diverges { power: 0.0 })?.value;
        Ok([bulk / volume, number / unit / volume])
    }

    /// Volume of a particle of a size, over that of a sphere whose radius that were.
    pub(super) fn bulk(&self, size: f64) -> f64 {
        if self.shape.form() != Form::Sphere {
            self.shape.volume(size) / sphere_volume(size)
        } else if self.coats.is_empty() {
            1.0
        } else {
            (self.outer_radius(size) / size).powi(3)
        }
    }

    /// Outer radius of a coated sphere of a size.
    pub(super) fn outer_radius(&self, size: f64) -> f64 {
        match self.sized_by {
            SizedBy::Outside => size,
            SizedBy::Core => self.coats.iter().fold(size, |radius, coat| coat.extent().outer(radius)),
        }
    }

    /// Checks what does not depend on the other inclusions.
    pub(super) fn check(&self) -> Result<(), MediumError> {
        let name = || self.name.clone();
        let value = self.volume_fraction;
        if !(0.0..=1.0).contains(&value) {
            return Err(MediumError::VolumeFraction { inclusion: name(), value });
        }
        if self.shape.form() != Form::Sphere && !self.coats.is_empty() {
            return Err(MediumError::NotSpheres { inclusion: name(), what: "coats" });
        }
        if self.packing == Packing::PercusYevick {
            if self.shape.form() != Form::Sphere {
                return Err(MediumError::NotSpheres { inclusion: name(), what: "a correction for packing" });
            }
            if value > Packing::MOST {
                return Err(MediumError::Packing { inclusion: name(), value });
            }
        }
        Ok(())
    }

    /// The volume fraction that the equivalent spheres take up, which for those of equal area is more than the particles do.
    pub(super) fn fraction_of_spheres(&self) -> f64 {
        if self.shape.equivalence() != Equivalence::Area || self.shape.form() == Form::Sphere {
            return self.volume_fraction;
        }
        let excess = |size: f64| sphere_volume(self.shape.equivalent_radius(size)) / self.shape.volume(size);
        // The largest over the sizes bounds the mean.
        let ends = self.sizes.log_range(3.0).unwrap_or((0.0, 0.0));
        self.volume_fraction * excess(ends.0.exp()).max(excess(ends.1.exp()))
    }
}
