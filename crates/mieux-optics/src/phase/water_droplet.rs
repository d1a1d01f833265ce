//! Fog and cloud: Lorenz-Mie scattering of visible light by water droplets, approximated from the diameter alone.

use std::fmt;

use super::{HenyeyGreensteinDraine, PhaseError};

/// Approximate Lorenz-Mie scattering of a water droplet of the given diameter, as Henyey-Greenstein plus Draine.
///
/// Four ranges of diameter have each their own published fit. They do not meet at their joints of 0.1, 1.5 and 5 um
/// (the mean cosine falls from 0.144 to 0.130 at 0.1 um): the published form is kept. A joint at 0.1 um belongs to the
/// range below, at 1.5 and 5 um to the range above.
///
/// Beside Lorenz-Mie theory averaged over 400 to 700 nm the mean cosine is 0.01 to 0.02 high from 3 um up, and up to 0.16
/// high near 0.2 um (`docs/fog-phase-function.md`); a single sphere in light of one wavelength may be 0.15 off near 2 um.
///
/// | | |
/// |---|---|
/// | `diameter_m` | above 0 and at most 50e-6 m |
///
/// Source: eqs 7 to 22 of `jendersie2023s`, with the diameter in micrometres and natural logarithms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WaterDroplet {
    diameter_m: f64,
    lobes: HenyeyGreensteinDraine,
}

impl WaterDroplet {
    /// The largest diameter of the fit, m.
    pub const MAX_DIAMETER_M: f64 = 50e-6;

    /// # Errors
    /// [`PhaseError::Diameter`] unless `0 < diameter_m <= 50e-6`.
    pub fn new(diameter_m: f64) -> Result<Self, PhaseError> {
        let micrometres = micrometres(diameter_m);
        if !(diameter_m > 0.0 && micrometres <= 50.0) {
            return Err(PhaseError::Diameter { diameter_m });
        }
        let [w_d, g_hg, g_d, alpha] = parameters(micrometres);
        Ok(Self { diameter_m, lobes: HenyeyGreensteinDraine::new(w_d, g_hg, g_d, alpha)? })
    }

    /// Diameter in metres.
    pub fn diameter(&self) -> f64 {
        self.diameter_m
    }

    /// The two lobes that the diameter stands for.
    pub fn lobes(&self) -> HenyeyGreensteinDraine {
        self.lobes
    }

    /// Value in 1/sr at the scattering cosine `mu` in [-1, 1]. Also the density of [`Self::sample`] per solid angle.
    pub fn value(&self, mu: f64) -> f64 {
        self.lobes.value(mu)
    }

    /// Scattering cosine in [-1, 1] for a uniform `xi` in [0, 1]. Not monotone in `xi`.
    pub fn sample(&self, xi: f64) -> f64 {
        self.lobes.sample(xi)
    }

    /// Mean cosine.
    pub fn asymmetry(&self) -> f64 {
        self.lobes.asymmetry()
    }

    /// Moment of the Legendre polynomial of the given degree, in closed form.
    pub fn legendre_moment(&self, degree: u32) -> f64 {
        self.lobes.legendre_moment(degree)
    }
}

impl fmt::Display for WaterDroplet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "water droplet (d = {} um)", micrometres(self.diameter_m))
    }
}

/// Micrometres; what differs from a joint by rounding alone is the joint.
fn micrometres(diameter_m: f64) -> f64 {
    let d = diameter_m * 1e6;
    [0.1, 1.5, 5.0, 50.0].into_iter().find(|joint| (d / joint - 1.0).abs() < 1e-14).unwrap_or(d)
}

/// `[w_D, g_HG, g_D, alpha]` of the published fits, for a diameter in micrometres.
fn parameters(d: f64) -> [f64; 4] {
    let log = d.ln();
    if d <= 0.1 {
        let w_d = 0.252977 - 312.983 * d.powf(4.3);
        [w_d, 13.8 * d * d, 1.1456 * d * (9.29044 * d).sin(), 250.0]
    } else if d < 1.5 {
        let inner = (log - 0.238604) * (log + 1.00667) / (0.507522 - 0.15677 * log);
        let g_d = 0.379685 * (1.19692 * inner.cos() + 1.37932 * log + 0.0625835).cos() + 0.344213;
        let w_d = 0.146209 * (3.38707 * log + 2.11193).cos() + 0.316072 + 0.0778917 * log;
        [w_d, 0.862 - 0.143 * log * log, g_d, 250.0]
    } else if d < 5.0 {
        let log_log = log.ln();
        let g_d = 0.500411 - 0.081287 / (-2.0 * log + log.tan() + 1.27551);
        let w_d = 0.026914 * (log - (5.68947 * (log_log - 0.0292149)).cos()) + 0.376475;
        [w_d, 0.0604931 * log_log + 0.940256, g_d, 7.30354 * log + 6.31675]
    } else {
        let g_hg = (-0.0990567 / (d - 1.67154)).exp();
        let g_d = (-2.20679 / (d + 3.91029) - 0.428934).exp();
        let alpha = (3.62489 - 8.29288 / (d + 5.52825)).exp();
        [(-0.599085 / (d - 0.641583) - 0.665888).exp(), g_hg, g_d, alpha]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phase::testing;

    fn droplet(micrometres: f64) -> WaterDroplet {
        WaterDroplet::new(micrometres * 1e-6).unwrap()
    }

    #[test]
    fn is_a_phase_function_on_both_sides_of_every_joint() {
        for d in [1e-9, 0.05, 0.1, 0.1 + 1e-9, 0.4, 1.5 - 1e-9, 1.5, 3.0, 5.0 - 1e-9, 5.0, 20.0, 50.0] {
            let phase = droplet(d);
            testing::check(&phase.into());
            testing::check_inverse(&phase.into(), &[phase.lobes().draine_weight()]);
        }
    }

    /// The figures of the jumps were computed apart from this code.
    #[test]
    fn the_published_jumps_are_kept() {
        let near = |a: f64, b: f64, unit: f64| assert!((a - b).abs() <= 0.5 * unit, "{a} {b}");
        near(droplet(0.1).asymmetry(), 0.144, 1e-3);
        // Steep there: 0.1295 at the joint itself, 0.1301 one part in a thousand above.
        near(droplet(0.1 + 1e-9).asymmetry(), 0.129484, 1e-6);
        near(droplet(0.1001).asymmetry(), 0.130, 1e-3);
        let (below, above) = (droplet(1.5 - 1e-9).lobes(), droplet(1.5).lobes());
        near(below.draine_weight(), 0.210, 1e-3);
        near(above.draine_weight(), 0.372, 1e-3);
        assert_eq!(below.draine().parameters().1, 250.0);
        near(above.draine().parameters().1, 9.3, 0.1);
    }

    /// Written down from the paper and evaluated apart from this code: `w_D`, `g_HG`, `g_D`, `alpha`.
    #[test]
    fn has_the_published_parameters() {
        let published = [
            (0.05, [0.252180672, 0.0345, 0.0256611824, 250.0]),
            (0.08, [0.246967924, 0.08832, 0.0620157704, 250.0]),
            (0.2, [0.0473507757, 0.491588474, 0.175181577, 250.0]),
            (0.7, [0.378733688, 0.843807967, 0.67810315, 250.0]),
            (1.4, [0.196954945, 0.84581046, 0.305115307, 250.0]),
            (1.6, [0.395797318, 0.89458281, 0.404039237, 9.74944031]),
            (2.5, [0.379933736, 0.934967598, 0.391466862, 13.008916]),
            (4.5, [0.431824643, 0.964948054, 0.494268417, 17.3018394]),
            (4.9, [0.440307529, 0.968279604, 0.50185919, 17.9237929]),
            (5.0, [0.44782949, 0.970677964, 0.508341616, 17.0680985]),
            (12.0, [0.487418732, 0.990455188, 0.566863888, 23.3775202]),
            (40.0, [0.50605533, 0.99741892, 0.619284323, 31.2725899]),
        ];
        for (d, wanted) in published {
            let lobes = droplet(d).lobes();
            let (g_d, alpha) = lobes.draine().parameters();
            let found = [lobes.draine_weight(), lobes.henyey_greenstein().asymmetry(), g_d, alpha];
            for (found, wanted) in found.into_iter().zip(wanted) {
                assert!((found / wanted - 1.0).abs() < 1e-8, "{d}: {found} {wanted}");
            }
        }
    }

    #[test]
    fn every_diameter_of_the_range_gives_valid_lobes() {
        for i in 0..=20_000 {
            // Geometric from 1 pm to 50 um.
            let d = 50.0 * 2e-8f64.powf(1.0 - f64::from(i) / 20_000.0);
            let phase = droplet(d);
            assert!(phase.value(1.0).is_finite() && phase.value(-1.0) > 0.0, "{d}");
        }
    }

    /// The mean cosine that Lorenz-Mie theory gives a 20 um droplet is 0.86 to 0.87.
    #[test]
    fn a_cloud_droplet_has_the_mean_cosine_of_clouds() {
        let g = droplet(20.0).asymmetry();
        assert!((0.85..0.88).contains(&g), "{g}");
        // Vanishing droplets scatter as Rayleigh says.
        let small = droplet(1e-6);
        for mu in [-1.0, -0.5, 0.0, 0.5, 1.0] {
            assert!((small.value(mu) / crate::phase::Rayleigh.value(mu) - 1.0).abs() < 0.03, "{mu}");
        }
    }

    #[test]
    fn diameters_out_of_range_are_refused() {
        for d in [0.0, -1e-6, 50.001e-6, 1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(WaterDroplet::new(d), Err(PhaseError::Diameter { .. })), "{d}");
        }
        assert_eq!(droplet(1.5).to_string(), "water droplet (d = 1.5 um)");
    }
}
