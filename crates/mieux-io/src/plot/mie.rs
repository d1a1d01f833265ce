//! The figures of what one particle does to light.

use super::{Figure, Panel, PolarPanel, Scale, Series};

/// Particles that differ in size alone, one value of each quantity per particle.
#[derive(Debug, Clone, Copy)]
pub struct SizePlot<'a> {
    /// Real part of the size parameter, ascending.
    pub size_parameter: &'a [f64],
    /// Efficiency of extinction.
    pub q_ext: &'a [f64],
    /// Efficiency of scattering.
    pub q_sca: &'a [f64],
    /// Efficiency of absorption.
    pub q_abs: &'a [f64],
    /// Mean cosine of scattering.
    pub asymmetry: &'a [f64],
    /// The particle that the others are compared with: size parameter, efficiency of extinction, asymmetry.
    pub here: [f64; 3],
}

/// Efficiencies and asymmetry over the size parameter. Sizes beyond the shortest quantity, and values that are not finite,
/// are left out.
pub fn efficiency_figure(title: &str, sizes: &SizePlot<'_>) -> Figure {
    let [x, q_ext, g] = sizes.here;
    let highest = sizes.q_ext.iter().copied().filter(|q| q.is_finite()).fold(0.0, f64::max);
    // Less than nothing by less than a line's width asks for no room below zero.
    let at_least_zero = |q: f64| if q < 0.0 && q > -0.01 * highest { 0.0 } else { q };
    let series = |label: &str, values: &[f64]| {
        Series::new(label, sizes.size_parameter.iter().copied().zip(values.iter().map(|q| at_least_zero(*q))))
    };
    let lowest = sizes.asymmetry.iter().copied().filter(|g| g.is_finite()).fold(0.0, f64::min);
    let lower = if lowest < -0.02 { -1.0 } else { 0.0 };
    let axis = "Size parameter x = 2πrn/λ";
    let efficiencies = Panel::new("Efficiencies", axis, "Q = C/πr²")
        .with_scales(Scale::Log, Scale::LinearOver(0.0, 0.1))
        .with_series(series("extinction", sizes.q_ext))
        .with_series(series("scattering", sizes.q_sca))
        .with_series(series("absorption", sizes.q_abs))
        .with_series(Series::new("this particle", [(x, q_ext)]));
    let asymmetry = Panel::new("Asymmetry", axis, "Mean cosine g")
        .with_scales(Scale::Log, Scale::LinearOver(lower, 1.0))
        .with_series(series("", sizes.asymmetry))
        .with_series(Series::new("this particle", [(x, g)]));
    Figure::new(title, 2).with_panel(efficiencies).with_panel(asymmetry)
}

/// The phase function (1/sr) over the scattering angle (degrees, 0 forward), as a polar and as a plain curve.
pub fn phase_figure(title: &str, angles: &[f64], phase: &[f64]) -> Figure {
    let points = || angles.iter().copied().zip(phase.iter().copied());
    let polar = PolarPanel::new("log₁₀ of the phase function (1/sr)", points());
    let plain = Panel::new("Phase function", "Scattering angle (degrees)", "Phase function (1/sr)")
        .with_scales(Scale::ScatteringAngle, Scale::Log)
        .with_series(Series::new("", points()));
    Figure::new(title, 2).with_polar_panel(polar).with_panel(plain)
}

/// Phase functions (1/sr) of light polarised across and along the plane of scattering, and the degree of linear
/// polarisation (-1 to 1) that unpolarised light takes on, over the scattering angle (degrees, 0 forward).
pub fn polarisation_figure(title: &str, angles: &[f64], across_and_along: &[[f64; 2]]) -> Figure {
    let series = |label: &str, value: fn(&[f64; 2]) -> f64| {
        Series::new(label, angles.iter().copied().zip(across_and_along.iter().map(value)))
    };
    let axis = "Scattering angle (degrees)";
    let parts = Panel::new("Polarised across and along the plane of scattering", axis, "Phase function (1/sr)")
        .with_scales(Scale::ScatteringAngle, Scale::Log)
        .with_series(series("across", |p| p[0]))
        .with_series(series("along", |p| p[1]));
    let degree = Panel::new("Unpolarised light", axis, "Degree of linear polarisation")
        .with_scales(Scale::ScatteringAngle, Scale::LinearOver(-1.0, 1.0))
        .with_series(series("", |[across, along]| (across - along) / (across + along)));
    Figure::new(title, 2).with_panel(degree).with_panel(parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_figures_name_what_they_show() {
        let x: Vec<f64> = (0..300).map(|i| 10f64.powf(f64::from(i) / 100.0 - 2.0)).collect();
        let q: Vec<f64> = x.iter().map(|x| 2.0 * x / (1.0 + x)).collect();
        let sizes =
            SizePlot { size_parameter: &x, q_ext: &q, q_sca: &q, q_abs: &q, asymmetry: &q, here: [1.0, 1.0, 0.2] };
        let text = efficiency_figure("a sphere", &sizes).to_svg().unwrap();
        for part in ["a sphere", "Efficiencies", "Asymmetry", "Size parameter", "this particle", "absorption"] {
            assert!(text.contains(part), "{part}");
        }
        let angles: Vec<f64> = (0..=180).map(f64::from).collect();
        let phase: Vec<f64> = angles.iter().map(|a| 10f64.powf(2.0 - a / 40.0)).collect();
        let text = phase_figure("a sphere", &angles, &phase).to_svg().unwrap();
        assert!(text.contains("Phase function (1/sr)") && text.contains("Scattering angle (degrees)"));
        let nothing = vec![[0.0; 2]; angles.len()];
        assert!(polarisation_figure("", &angles, &nothing).to_svg().is_err());
        let rayleigh: Vec<_> = angles.iter().map(|a| [1.0, a.to_radians().cos().powi(2)]).collect();
        let text = polarisation_figure("", &angles, &rayleigh).to_svg().unwrap();
        assert!(text.contains("Degree of linear polarisation") && text.contains("along") && !text.contains("NaN"));
    }

    #[test]
    fn a_long_title_fits() {
        let angles = [0.0, 180.0];
        let size = |letters: usize| {
            let text = phase_figure(&"m".repeat(letters), &angles, &[1.0, 1.0]).to_svg().unwrap();
            let title = text.find("mmm").unwrap();
            let from = text[..title].rfind("font-size=\"").unwrap() + 11;
            text[from..].split('"').next().unwrap().parse::<f64>().unwrap()
        };
        assert_eq!(size(20), 18.0);
        assert!(size(110) < 14.0 && size(500) >= 9.0, "{} {}", size(110), size(500));
    }
}
