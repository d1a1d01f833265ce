//! Smooth surfaces between clear or turbid media: how much light is reflected, and where it goes.

use glam::DVec3;
pub use mieux_optics::transfer::fresnel::dielectric_reflectance;

/// The mirrored direction at a surface whose unit normal faces the incoming ray (`direction . normal <= 0`).
#[inline]
pub fn reflect(direction: DVec3, normal: DVec3) -> DVec3 {
    (direction - normal * (2.0 * direction.dot(normal))).normalize()
}

/// The refracted direction (Snell), or `None` under total reflection. The unit normal faces the incoming ray; `eta`
/// is the index beyond over the index before. With `eta = 1` the direction is returned unchanged.
#[inline]
pub fn refract(direction: DVec3, normal: DVec3, eta: f64) -> Option<DVec3> {
    if eta == 1.0 {
        return Some(direction);
    }
    let cos_i = -direction.dot(normal);
    let sin2_t = (1.0 - cos_i * cos_i).max(0.0) / (eta * eta);
    if sin2_t >= 1.0 {
        return None;
    }
    Some((direction / eta + normal * (cos_i / eta - (1.0 - sin2_t).sqrt())).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_sides_agree_and_snell_holds() {
        let normal = DVec3::Z;
        for i in 0..50 {
            let angle = f64::from(i) * 0.031;
            let direction = DVec3::new(angle.sin(), 0.0, -angle.cos());
            let refracted = refract(direction, normal, 1.5).unwrap();
            assert!((refracted.x * 1.5 - direction.x).abs() < 1e-14 && refracted.z < 0.0);
            let there = dielectric_reflectance(-direction.z, 1.5);
            let back = dielectric_reflectance(-refracted.z, 1.0 / 1.5);
            assert!((there - back).abs() < 1e-12);
            let returned = refract(-refracted, -normal, 1.0 / 1.5).unwrap();
            assert!((returned + direction).length() < 1e-7);
            let mirrored = reflect(direction, normal);
            assert!((mirrored - DVec3::new(direction.x, 0.0, -direction.z)).length() < 1e-14);
            assert_eq!(refract(direction, normal, 1.0), Some(direction));
        }
        assert!(refract(DVec3::new(0.8, 0.0, -0.6), normal, 1.0 / 1.5).is_none());
    }
}
