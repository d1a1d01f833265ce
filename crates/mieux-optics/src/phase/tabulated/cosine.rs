//! Tables at equally spaced cosines, which is how renderers take them.

use std::f64::consts::PI;

use super::super::{PhaseError, PhaseFunction, quadrature};
use super::{AngleGrid, Tabulated};

impl Tabulated {
    /// A table of `points` equally spaced cosines from 1 to -1 (2 or more), linear in between.
    ///
    /// Its values are means of the function, each under the triangle that the linear interpolant gives to it. So the
    /// integral is kept whatever the function does between two cosines, and the mean cosine up to a third of a step
    /// times what the outermost triangles hold; values picked at the cosines would lose a narrow peak.
    ///
    /// # Errors
    /// [`PhaseError::TableLength`] for fewer than two points.
    pub fn regular_in_cosine(phase: &PhaseFunction, points: usize) -> Result<Self, PhaseError> {
        let steps = points.saturating_sub(1);
        let step = 2.0 / steps as f64;
        let angle = |k: usize| match k {
            0 => 0.0,
            k if k == steps => PI,
            k => 2.0 * (0.5 * step * k as f64).sqrt().asin(),
        };
        let grid = AngleGrid::new((0..points).map(angle).collect())?;
        let knots: Vec<f64> = (0..points).map(|k| if k == steps { 2.0 } else { step * k as f64 }).collect();
        let mut values = vec![0.0; points];
        quadrature::visit(&quadrature::merge_edges(&phase.edges(), &knots), 0, |_, away, weight| {
            let bin = ((away / step) as usize).min(steps - 1);
            let t = (away / step - bin as f64).clamp(0.0, 1.0);
            let part = weight * phase.value_away(away);
            values[bin] += part * (1.0 - t);
            values[bin + 1] += part * t;
        });
        for (k, value) in values.iter_mut().enumerate() {
            let share = if k == 0 || k == steps { 0.5 } else { 1.0 };
            *value /= 2.0 * PI * step * share;
        }
        Self::new(grid.as_slice().to_vec(), values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::phase::testing::sphere::Sphere;
    use crate::phase::{HenyeyGreenstein, Isotropic, compare};

    /// The droplet whose values at equal steps of the cosine lose 74 % of `1 - g`: means lose 0.5 %.
    #[test]
    fn means_keep_what_points_lose() {
        let x = PI * 20.0 / 0.55;
        let sphere = Sphere::new(x, 1.33);
        let exact = 1.0 - sphere.asymmetry();
        let droplet = Tabulated::to_tolerance(x, 1e-4, |theta| sphere.intensity(theta)).unwrap().into();
        let mut before = f64::INFINITY;
        for points in [1001usize, 4001, 16_001] {
            let table = Tabulated::regular_in_cosine(&droplet, points).unwrap();
            let error = (table.one_minus_asymmetry() / exact - 1.0).abs();
            let bound = 2.0 / (points - 1) as f64 / 3.0 / exact + 1e-4;
            assert!(error < bound && error < 0.01, "{points}: {error}");
            let apart = compare(&droplet, &table.into()).total_variation;
            assert!(apart < before);
            before = apart;
        }
    }

    #[test]
    fn smooth_functions_are_kept() {
        let table = Tabulated::regular_in_cosine(&Isotropic.into(), 3).unwrap();
        assert!(table.bins().iter().flatten().all(|v| (v * 4.0 * PI - 1.0).abs() < 1e-12));
        let hg: PhaseFunction = HenyeyGreenstein::new(0.5).unwrap().into();
        let apart = compare(&hg, &Tabulated::regular_in_cosine(&hg, 1001).unwrap().into());
        assert!(apart.total_variation < 5e-5 && apart.delta_asymmetry.abs() < 1e-5, "{apart:?}");
        assert!(Tabulated::regular_in_cosine(&hg, 1).is_err() && Tabulated::regular_in_cosine(&hg, 0).is_err());
    }
}
