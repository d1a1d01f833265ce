//! Smooth surfaces between clear or turbid media: how much light is reflected, and where it goes.

use glam::DVec3;

/// Share of unpolarised light reflected at a smooth surface (Fresnel; `born1999` section 1.5).
///
/// | | |
/// |---|---|
/// | `cos_i` | cosine of incidence against the normal, in [0, 1] |
/// | `eta` | index beyond the surface over index before it, > 0; real parts |
///
/// In [0, 1]; exactly 0 for `eta = 1`, exactly 1 where no light is refracted.
#[inline]
pub fn dielectric_reflectance(cos_i: f64, eta: f64) -> f64 {
    if eta == 1.0 {
        return 0.0;
    }
    let sin2_t = (1.0 - cos_i * cos_i).max(0.0) / (eta * eta);
    if sin2_t >= 1.0 {
        return 1.0;
    }
    let cos_t = (1.0 - sin2_t).sqrt();
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    (0.5 * (parallel * parallel + perpendicular * perpendicular)).min(1.0)
}

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

    /// Reflectance of a diffuse field, by the midpoint rule in the squared cosine.
    fn diffuse(eta: f64) -> f64 {
        let n = 2_000_000;
        (0..n).map(|i| dielectric_reflectance(((f64::from(i) + 0.5) / f64::from(n)).sqrt(), eta)).sum::<f64>()
            / f64::from(n)
    }

    #[test]
    fn known_values() {
        assert!((dielectric_reflectance(1.0, 1.5) - 0.04).abs() < 1e-15);
        assert!((dielectric_reflectance(1.0, 1.0 / 1.5) - 0.04).abs() < 1e-15);
        assert_eq!(dielectric_reflectance(0.3, 1.0), 0.0);
        assert_eq!(dielectric_reflectance(0.0, 1.0), 0.0);
        assert_eq!(dielectric_reflectance(0.0, 1.5), 1.0);
        assert_eq!(dielectric_reflectance(0.5, 1.0 / 1.5), 1.0);
        // At Brewster's angle only half of the perpendicular part is left.
        let cos_b = 1.0 / (1.0 + 1.5f64 * 1.5).sqrt();
        let perpendicular = (1.0 - 1.5f64 * 1.5) / (1.0 + 1.5f64 * 1.5);
        assert!((dielectric_reflectance(cos_b, 1.5) - 0.5 * perpendicular * perpendicular).abs() < 1e-12);
    }

    /// PHYSICS section 7: the internal diffuse reflectance follows from the external one.
    #[test]
    fn diffuse_internal_reflectance() {
        assert!((diffuse(1.0 / 1.5) - 0.59635).abs() < 1e-5, "{}", diffuse(1.0 / 1.5));
        assert!((diffuse(1.0 / 1.33) - 0.47195).abs() < 1e-5);
        assert!((diffuse(1.0 / 1.5) - (1.0 - (1.0 - diffuse(1.5)) / 2.25)).abs() < 1e-6);
    }

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
