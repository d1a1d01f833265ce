//! The figure of phase functions over each other.

use super::{Figure, Panel, PolarPanel, Scale, Series};

/// Phase functions (1/sr) over the scattering angle (degrees, 0 forward), as polar and as plain curves: a name for the
/// legend and the values of each, all at the same angles.
pub fn comparison_figure(title: &str, angles: &[f64], curves: &[(String, Vec<f64>)]) -> Figure {
    let points = |values: &[f64]| angles.iter().copied().zip(values.to_vec()).collect::<Vec<_>>();
    let first = curves.first().map(|(_, values)| points(values)).unwrap_or_default();
    let mut polar = PolarPanel::new("log₁₀ of the phase function (1/sr)", first);
    let mut plain = Panel::new("Phase function", "Scattering angle (degrees)", "Phase function (1/sr)")
        .with_scales(Scale::ScatteringAngle, Scale::Log);
    for (i, (name, values)) in curves.iter().enumerate() {
        if i > 0 {
            polar = polar.with_curve(points(values));
        }
        plain = plain.with_series(Series::new(name, points(values)));
    }
    Figure::new(title, 2).with_polar_panel(polar).with_panel(plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_function_is_named_and_nothing_is_an_error() {
        let angles: Vec<f64> = (0..=180).map(f64::from).collect();
        let curve = |name: &str, k: f64| (name.to_owned(), angles.iter().map(|a| 10f64.powf(1.0 - a / k)).collect());
        let curves = [curve("fog", 40.0), curve("two lobes", 60.0)];
        let text = comparison_figure("Fog", &angles, &curves).to_svg().unwrap();
        for part in ["Fog", "fog", "two lobes", "Phase function (1/sr)", "150°"] {
            assert!(text.contains(part), "{part}");
        }
        assert!(comparison_figure("Fog", &angles, &[]).to_svg().is_err());
    }
}
