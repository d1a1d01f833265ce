//! Reflection or refraction at a smooth interface, for all wavelengths of a path at once.

use glam::DVec3;

use super::turbid::MediumLanes;
use super::{LANES, Lanes};
use crate::surface::{dielectric_reflectance, reflect, refract};

/// An interface as one path meets it.
pub(crate) struct Interface {
    /// Share reflected at each wavelength.
    pub(crate) reflectance: Lanes,
    /// Index beyond over index before by which rays bend, at each wavelength.
    eta: Lanes,
    direction: DVec3,
    /// Facet and smooth normals, facing the ray.
    facet: DVec3,
    smooth: DVec3,
    refracted: Option<DVec3>,
}

impl Interface {
    /// `facet` and `smooth` are unit normals on one side or the other; `before` and `beyond` the media.
    pub(crate) fn new(
        direction: DVec3,
        (facet, smooth): (DVec3, DVec3),
        before: &MediumLanes,
        beyond: &MediumLanes,
    ) -> Self {
        let side = if direction.dot(facet) > 0.0 { -1.0 } else { 1.0 };
        let (facet, smooth) = (facet * side, smooth * side);
        // Seen from behind the smooth normal there is only the facet.
        let smooth = if direction.dot(smooth) < 0.0 { smooth } else { facet };
        let eta: Lanes = std::array::from_fn(|k| beyond.n_geometry[k] / before.n_geometry[k]);
        let own: Lanes = std::array::from_fn(|k| beyond.n[k] / before.n[k]);
        let cosine = -direction.dot(smooth);
        let refracted = refract(direction, smooth, eta[0]);
        let reflectance = if own == eta {
            own.map(|eta| dielectric_reflectance(cosine, eta))
        } else {
            shared(cosine, eta[0], &own, refracted.map(|d| -d.dot(smooth)))
        };
        Self { reflectance, eta, direction, facet, smooth, refracted }
    }

    /// The mirrored direction; always back into the medium the ray came from.
    pub(crate) fn reflected(&self) -> DVec3 {
        let mirrored = reflect(self.direction, self.smooth);
        if mirrored.dot(self.facet) > 0.0 { mirrored } else { reflect(self.direction, self.facet) }
    }

    /// The refracted direction of the hero; always into the medium beyond, or `None` where that cannot be.
    pub(crate) fn refracted(&self) -> Option<DVec3> {
        let into = |d: &DVec3| d.dot(self.facet) < 0.0;
        self.refracted.filter(into).or_else(|| refract(self.direction, self.facet, self.eta[0]).filter(into))
    }

    /// Whether a companion is refracted just like the hero.
    pub(crate) fn bends_alike(&self, lane: usize) -> bool {
        self.eta[lane] == self.eta[0]
    }
}

/// Reflectance by each wavelength's own index along rays that all bend by one.
///
/// Always taken from the side where the common index is lower: there every ray has a partner on the other side, so
/// both directions of a ray see the same share, and no wavelength is totally reflected where the others are not.
fn shared(cosine: f64, eta: f64, own: &Lanes, refracted: Option<f64>) -> Lanes {
    match refracted {
        None => [1.0; LANES],
        Some(_) if eta >= 1.0 => own.map(|own| dielectric_reflectance(cosine, own)),
        Some(beyond) => own.map(|own| dielectric_reflectance(beyond.clamp(0.0, 1.0), 1.0 / own)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn medium(n: Lanes, n_geometry: Lanes) -> MediumLanes {
        MediumLanes { n, n_geometry, ..MediumLanes::vacuum() }
    }

    #[test]
    fn both_directions_of_a_ray_see_the_same_share() {
        let glass = medium([1.52, 1.53, 1.51, 1.54], [1.52; 4]);
        let air = MediumLanes::vacuum();
        for i in 0..90 {
            let angle = f64::from(i) * 0.01745;
            let direction = DVec3::new(angle.sin(), 0.0, -angle.cos());
            let there = Interface::new(direction, (DVec3::Z, DVec3::Z), &air, &glass);
            let inside = there.refracted().unwrap();
            let back = Interface::new(-inside, (DVec3::Z, DVec3::Z), &glass, &air);
            for k in 0..4 {
                assert!((there.reflectance[k] - back.reflectance[k]).abs() < 1e-9);
                assert!((0.0..=1.0).contains(&there.reflectance[k]));
            }
        }
        let grazing = DVec3::new(0.9, 0.0, -(1.0f64 - 0.81).sqrt());
        assert_eq!(Interface::new(grazing, (DVec3::Z, DVec3::Z), &glass, &air).reflectance, [1.0; 4]);
    }

    #[test]
    fn equal_indices_do_nothing() {
        let water = medium([1.33; 4], [1.33; 4]);
        let direction = DVec3::new(0.6, 0.0, 0.8);
        let interface = Interface::new(direction, (DVec3::Z, DVec3::Z), &water, &water);
        assert_eq!(interface.reflectance, [0.0; 4]);
        assert_eq!(interface.refracted(), Some(direction));
    }

    #[test]
    fn directions_stay_on_their_side_of_the_facet() {
        let glass = medium([1.5; 4], [1.5; 4]);
        let air = MediumLanes::vacuum();
        let smooth = DVec3::new(0.5, 0.0, 1.0).normalize();
        for i in -80..=80 {
            let angle = f64::from(i) * 0.0194;
            let direction = DVec3::new(angle.sin(), 0.0, -angle.cos());
            for (before, beyond) in [(&air, &glass), (&glass, &air)] {
                let interface = Interface::new(direction, (DVec3::Z, smooth), before, beyond);
                assert!(interface.reflected().z > 0.0);
                assert!(interface.refracted().is_none_or(|d| d.z < 0.0));
            }
        }
    }
}
