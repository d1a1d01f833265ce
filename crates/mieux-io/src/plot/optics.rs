//! The figure of what a material does to light, over wavelength.

use super::{Figure, Panel, PlotError, Scale, Series};

/// Optical properties at the wavelengths of a figure, one value for each.
#[derive(Debug, Clone, Copy)]
pub struct OpticsPlot<'a> {
    /// Scattering coefficient, 1/m.
    pub sigma_s: &'a [f64],
    /// Reduced scattering coefficient, 1/m.
    pub reduced_scattering: &'a [f64],
    /// Absorption coefficient, 1/m.
    pub sigma_a: &'a [f64],
    /// Asymmetry g, the mean cosine, -1 to 1.
    pub asymmetry: &'a [f64],
    /// Real part of the refractive index, where there is one to show.
    pub refractive_index: Option<&'a [f64]>,
}

/// Scattering, absorption, asymmetry and refractive index over the vacuum wavelength in nm.
///
/// Values that are not finite are left out, as are zeros on the logarithmic axes (scattering and absorption); a panel
/// in which nothing remains is left out.
///
/// # Errors
/// [`PlotError::Length`] when a quantity does not have one value per wavelength, [`PlotError::Empty`] when no panel
/// remains.
pub fn optics_figure(title: &str, wavelengths_nm: &[f64], optics: &OpticsPlot<'_>) -> Result<Figure, PlotError> {
    let series = |quantity: &'static str, label: &str, values: &[f64]| {
        if values.len() != wavelengths_nm.len() {
            return Err(PlotError::Length { quantity, found: values.len(), expected: wavelengths_nm.len() });
        }
        Ok(Series::new(label, wavelengths_nm.iter().copied().zip(values.iter().copied())))
    };
    let panel = |title: &str, y_label: &str, y: Scale| {
        Panel::new(title, "Wavelength in vacuum (nm)", y_label).with_scales(Scale::Linear, y)
    };
    // An asymmetry below zero by no more than rounding asks for no second half of the axis.
    let backward = optics.asymmetry.iter().any(|g| *g < -1e-3);
    let mut panels = vec![
        panel("Scattering", "Coefficient (1/m)", Scale::Log)
            .with_series(series("the scattering coefficient", "scattering σₛ", optics.sigma_s)?)
            .with_series(series(
                "the reduced scattering coefficient",
                "reduced scattering σₛ′",
                optics.reduced_scattering,
            )?),
        panel("Absorption", "Coefficient σₐ (1/m)", Scale::Log).with_series(series(
            "the absorption coefficient",
            "absorption σₐ",
            optics.sigma_a,
        )?),
        panel("Asymmetry", "Mean cosine g", Scale::LinearOver(if backward { -1.0 } else { 0.0 }, 1.0))
            .with_series(series("the asymmetry", "asymmetry g", optics.asymmetry)?),
    ];
    if let Some(refractive_index) = optics.refractive_index {
        let real = series("the refractive index", "refractive index n", refractive_index)?;
        panels.push(panel("Refractive index", "Real part n", Scale::Linear).with_series(real));
    }
    let mut figure = Figure::new(title, 2);
    for panel in panels {
        let shows = |(x, y): &(f64, f64)| x.is_finite() && y.is_finite();
        if panel.series.iter().flat_map(|s| &s.points).any(shows) {
            figure = figure.with_panel(panel);
        }
    }
    if figure.panels.is_empty() {
        return Err(PlotError::Empty { title: title.to_owned() });
    }
    Ok(figure)
}

/// [`optics_figure`] as the text of an SVG file.
///
/// # Errors
/// As [`optics_figure`].
pub fn optics_svg(title: &str, wavelengths_nm: &[f64], optics: &OpticsPlot<'_>) -> Result<String, PlotError> {
    optics_figure(title, wavelengths_nm, optics)?.to_svg()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn milk(wavelengths: &[f64]) -> [Vec<f64>; 5] {
        let of = |f: fn(f64) -> f64| wavelengths.iter().map(|&w| f(w)).collect::<Vec<_>>();
        [
            of(|w| 6.1e4 * (550.0 / w).powf(0.8)),
            of(|w| 2.3e3 * (550.0 / w).powf(1.3)),
            of(|w| 0.05 + 120.0 * (-(w - 375.0) / 40.0).exp()),
            of(|w| 0.96 - 1e-4 * (w - 400.0)),
            of(|w| 1.334 + 3100.0 / (w * w)),
        ]
    }

    fn plot(milk: &[Vec<f64>; 5]) -> OpticsPlot<'_> {
        let [sigma_s, reduced_scattering, sigma_a, asymmetry, n] = milk;
        OpticsPlot { sigma_s, reduced_scattering, sigma_a, asymmetry, refractive_index: Some(n) }
    }

    #[test]
    fn a_spectrum_and_a_single_wavelength_draw() {
        for wavelengths in [(0..17).map(|i| 375.0 + 25.0 * f64::from(i)).collect::<Vec<_>>(), vec![550.0]] {
            let values = milk(&wavelengths);
            let text = optics_svg("Milk, 2 % fat", &wavelengths, &plot(&values)).unwrap();
            for part in ["Milk, 2 % fat", "Scattering", "Absorption", "Asymmetry", "Refractive index", "reduced"] {
                assert!(text.contains(part), "{part}");
            }
            assert!(!text.contains("NaN"));
        }
    }

    #[test]
    fn a_clear_host_has_no_need_of_logarithms() {
        let wavelengths = [400.0, 500.0];
        let zeros = [0.0; 2];
        let clear = OpticsPlot {
            sigma_s: &zeros,
            reduced_scattering: &zeros,
            sigma_a: &zeros,
            asymmetry: &[f64::NAN; 2],
            refractive_index: None,
        };
        let text = optics_svg("Nothing", &wavelengths, &clear).unwrap();
        assert!(text.contains("Absorption") && !text.contains("Asymmetry"));
    }

    #[test]
    fn lengths_must_agree() {
        let values = milk(&[550.0]);
        let error = optics_svg("", &[500.0, 600.0], &plot(&values)).unwrap_err();
        assert_eq!(error, PlotError::Length { quantity: "the scattering coefficient", found: 1, expected: 2 });
        let none: [Vec<f64>; 5] = Default::default();
        assert!(matches!(optics_svg("", &[], &plot(&none)), Err(PlotError::Empty { .. })));
    }
}
