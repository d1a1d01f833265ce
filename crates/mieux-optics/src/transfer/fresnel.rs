//! Smooth surfaces between clear or turbid media: the share of light they send back, for one direction and for diffuse
//! light.

use std::convert::Infallible;

use crate::integrate::integrate;

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
    reflectance_of_pair(cos_i, (1.0 - sin2_t).sqrt(), eta)
}

/// As [`dielectric_reflectance`], from the cosines on both sides: near total reflection these have digits that one
/// cannot be computed from the other with.
#[inline]
pub(crate) fn reflectance_of_pair(cos_i: f64, cos_t: f64, eta: f64) -> f64 {
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    (0.5 * (parallel * parallel + perpendicular * perpendicular)).min(1.0)
}

/// What a smooth surface does to diffuse light that comes from the denser side's inside, in the moments that diffusion
/// theory and Saunderson's correction ask for (`egan1973`, `deon2011`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiffuseReflectance {
    /// `C1`: the integral over the inner cosine `mu` in [0, 1] of `F(mu) mu`.
    pub c1: f64,
    /// `C2`: of `F(mu) mu^2`.
    pub c2: f64,
    /// Share of isotropic light from outside that is reflected, `r_ext`.
    pub external: f64,
}

impl DiffuseReflectance {
    /// Of a medium of relative index `eta` (inside over outside), from above 0; to about 1e-13. `None` for an index
    /// that is not positive and finite.
    pub fn new(eta: f64) -> Option<Self> {
        if !(eta > 0.0 && eta.is_finite()) {
            return None;
        }
        if eta < 1.0 {
            // Seen from the denser outside, the roles of the sides are exchanged.
            let [c1, _, c2] = cone_integrals(1.0 / eta)?;
            let critical = (1.0 - eta * eta).sqrt();
            let denser_c1 = 0.5 * critical * critical + c1 * eta * eta;
            return Some(Self { c1, c2, external: 2.0 * denser_c1 });
        }
        let [outer_c1, inner_c2, _] = cone_integrals(eta)?;
        let squared = eta * eta;
        let critical2 = (eta - 1.0) * (eta + 1.0) / squared;
        Some(Self {
            c1: 0.5 * critical2 + outer_c1 / squared,
            c2: critical2 * critical2.sqrt() / 3.0 + inner_c2 / squared,
            external: 2.0 * outer_c1,
        })
    }

    /// Share of isotropic light from inside that is reflected, `r_int = 2 C1`.
    pub fn internal(&self) -> f64 {
        2.0 * self.c1
    }

    /// What the exact boundary of diffusion theory needs: `A = (1 + 3 C2) / (1 - 2 C1)` (`deon2011`).
    pub fn extrapolation(&self) -> f64 {
        (1.0 + 3.0 * self.c2) / (1.0 - 2.0 * self.c1)
    }

    /// The older `A = (1 + r_int) / (1 - r_int)` (`groenhuis1983`).
    pub fn extrapolation_groenhuis(&self) -> f64 {
        (1.0 + self.internal()) / (1.0 - self.internal())
    }
}

/// Over the cosine `u` on the thinner side of a surface of index ratio `eta >= 1`, where every integrand is smooth:
/// `F u`, `F u mu` and `F u^2`, with `mu` the cosine on the denser side.
fn cone_integrals(eta: f64) -> Option<[f64; 3]> {
    let found = integrate(&[0.0, 1.0], 1e-13, [1e-4; 3], |u| {
        let mu = ((eta - 1.0) * (eta + 1.0) + u * u).sqrt() / eta;
        let weighted = reflectance_of_pair(u, mu, eta) * u;
        Ok::<_, Infallible>([weighted, weighted * mu, weighted * u])
    });
    match found {
        Ok(found) => found.map(|integral| integral.value),
        Err(never) => match never {},
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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

    /// The closed form of Duntley (`egan1973`) for light from outside.
    #[test]
    fn diffuse_light_from_outside_follows_the_closed_form() {
        for n in [1.0001f64, 1.01, 1.33, 1.5, 2.0, 4.0] {
            let (n2, n4) = (n * n, n.powi(4));
            let closed = 0.5
                + (n - 1.0) * (3.0 * n + 1.0) / (6.0 * (n + 1.0).powi(2))
                + n2 * (n2 - 1.0).powi(2) / (n2 + 1.0).powi(3) * ((n - 1.0) / (n + 1.0)).ln()
                - 2.0 * n.powi(3) * (n2 + 2.0 * n - 1.0) / ((n2 + 1.0) * (n4 - 1.0))
                + 8.0 * n4 * (n4 + 1.0) / ((n2 + 1.0) * (n4 - 1.0).powi(2)) * n.ln();
            let ours = DiffuseReflectance::new(n).unwrap().external;
            // The closed form itself cancels for indices near 1.
            let allowed = if n < 1.005 { 1e-6 } else { 1e-10 };
            assert!((ours - closed).abs() < allowed, "n = {n}: {ours} for {closed}");
        }
    }

    #[test]
    fn what_is_inside_for_one_is_outside_for_the_other() {
        let (denser, thinner) = (DiffuseReflectance::new(1.4).unwrap(), DiffuseReflectance::new(1.0 / 1.4).unwrap());
        assert!((denser.internal() - thinner.external).abs() < 1e-12);
        assert!((denser.external - thinner.internal()).abs() < 1e-12);
        assert_eq!(DiffuseReflectance::new(1.0).unwrap(), DiffuseReflectance { c1: 0.0, c2: 0.0, external: 0.0 });
        assert!(DiffuseReflectance::new(f64::NAN).is_none() && DiffuseReflectance::new(0.0).is_none());
    }
}
