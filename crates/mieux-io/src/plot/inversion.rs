//! The figure of what measured slabs are made of.

use super::{Figure, Panel, Scale, Series};

/// Numbers with their standard errors; what is not finite is left out.
#[derive(Debug, Clone, Copy)]
pub struct Measured<'a> {
    /// The numbers.
    pub values: &'a [f64],
    /// Standard errors, in the same unit.
    pub errors: &'a [f64],
}

/// Coefficients of absorption and of reduced scattering (1/mm), and where it was found the asymmetry, over what `x` says
/// with its `label`: "Wavelength (nm)".
pub fn inversion_figure(
    title: &str,
    (label, x): (&str, &[f64]),
    absorption: Measured<'_>,
    reduced_scattering: Measured<'_>,
    asymmetry: Option<Measured<'_>>,
) -> Figure {
    let series = |of: Measured<'_>| {
        Series::new("", x.iter().copied().zip(of.values.iter().copied())).with_errors(of.errors.iter().copied())
    };
    let panel = |name: &str, unit: &str, of: Measured<'_>| {
        Panel::new(name, label, unit).with_scales(Scale::Linear, Scale::Linear).with_series(series(of))
    };
    let mut figure = Figure::new(title, if asymmetry.is_some() { 3 } else { 2 })
        .with_panel(panel("Absorption", "μₐ (1/mm)", absorption))
        .with_panel(panel("Reduced scattering", "μₛ′ (1/mm)", reduced_scattering));
    if let Some(asymmetry) = asymmetry {
        figure = figure.with_panel(panel("Asymmetry", "g", asymmetry));
    }
    figure
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_left_out_and_nothing_is_an_error() {
        let x = [500.0, 510.0, 520.0];
        let of = |values| Measured { values, errors: &[0.01, f64::INFINITY, 0.0] };
        let figure = |values| inversion_figure("Liver", ("Wavelength (nm)", &x), of(values), of(&[1.0; 3]), None);
        let text = figure(&[0.1, f64::NAN, 0.3]).to_svg().unwrap();
        for part in ["Liver", "Wavelength (nm)", "μₐ (1/mm)", "μₛ′ (1/mm)"] {
            assert!(text.contains(part), "{part}");
        }
        assert!(!text.contains("NaN") && !text.contains("inf"));
        assert!(figure(&[f64::NAN; 3]).to_svg().is_err());
    }
}
