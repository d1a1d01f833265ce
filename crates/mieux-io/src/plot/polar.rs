//! A panel in which the angle is an angle: a value over the scattering angle, by powers of ten from the centre.

use kuva::plot::polar::PolarPlot;
use kuva::render::layout::{Layout, TickFormat};
use kuva::render::plots::Plot;

use super::{COLOURS, PlotError, dash, literal};

/// The centre lies no further below the largest value than this many powers of ten.
const MOST_DECADES: f64 = 12.0;

/// Values over the scattering angle, drawn on both sides of the direction of light, which runs to the right. The radius
/// is the logarithm of the value. Several curves have the colours and dashes that a plain panel would give them.
#[derive(Debug, Clone, PartialEq)]
pub struct PolarPanel {
    title: String,
    curves: Vec<Vec<(f64, f64)>>,
}

impl PolarPanel {
    /// Points (angle from forward in degrees, 0 to 180; value), ascending in angle. What is not finite is left out; what
    /// is too small to show, or not more than 0, lies in the centre. The title names quantity and unit.
    pub fn new(title: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self { title: title.into(), curves: vec![points.into_iter().collect()] }
    }

    /// Adds points as [`PolarPanel::new`] takes them, as another curve.
    pub fn with_curve(mut self, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        self.curves.push(points.into_iter().collect());
        self
    }

    /// The plot of the panel and the layout around it.
    pub(super) fn drawn(&self) -> Result<(Vec<Plot>, Layout), PlotError> {
        let logs: Vec<Vec<(f64, f64)>> = self.curves.iter().map(|points| logarithms(points)).collect();
        let shown = || logs.iter().flatten().map(|p| p.1).filter(|log| log.is_finite());
        let (low, high) = shown().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        if low > high {
            return Err(PlotError::Empty { title: self.title.clone() });
        }
        let (centre, edge, rings) = decades(low, high);
        let mut plot = PolarPlot::new()
            .with_r_min(centre)
            .with_r_max(edge)
            .with_r_grid_lines(rings)
            .with_theta_start(90.0)
            .with_clockwise(false);
        for (i, logs) in logs.iter().enumerate().filter(|(_, logs)| !logs.is_empty()) {
            let mirrored = logs.iter().rev().map(|&(angle, log)| (360.0 - angle, log));
            let (angles, radii): (Vec<f64>, Vec<f64>) =
                logs.iter().copied().chain(mirrored).map(|(angle, log)| (angle, log.max(centre))).unzip();
            plot = plot.with_series_line(radii, angles).with_color(COLOURS[i % COLOURS.len()]);
            if let Some(series) = plot.series.last_mut() {
                series.stroke_width = 1.8;
                series.line_dash = dash(i).dasharray();
            }
        }
        let plots = vec![Plot::Polar(plot)];
        let mut layout = Layout::auto_from_plots(&plots)
            .with_title(literal(&self.title))
            .with_title_size(14)
            .with_tick_size(11)
            .with_polar_r_label_angle(255.0)
            .with_x_tick_format(TickFormat::Custom(std::sync::Arc::new(|angle| {
                format!("{:.0}°", if angle > 180.0 { 360.0 - angle } else { angle })
            })));
        layout.theme.grid_color = "#d8d8d8".to_owned();
        layout.theme.axis_color = "#444444".to_owned();
        Ok((plots, layout))
    }
}

/// Angles and logarithms of what is finite.
fn logarithms(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let finite = points.iter().filter(|(angle, value)| angle.is_finite() && value.is_finite());
    finite.map(|&(angle, value)| (angle, value.max(0.0).log10())).collect()
}

/// Exponents at the centre and at the edge, and how many rings there are between them, each at a whole exponent.
fn decades(low: f64, high: f64) -> (f64, f64, usize) {
    let edge = (high - 1e-9).ceil();
    let mut span = edge - low.max(edge - MOST_DECADES).floor();
    span = span.max(2.0);
    let step = if span > 6.0 { 2.0 } else { 1.0 };
    let rings = (span / step).ceil();
    (edge - rings * step, edge, rings as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::Figure;

    #[test]
    fn rings_lie_at_whole_powers_of_ten() {
        assert_eq!(decades(-1.2, -0.9), (-2.0, 0.0, 2));
        assert_eq!(decades(-3.5, 1.5), (-4.0, 2.0, 6));
        assert_eq!(decades(-4.5, 2.0), (-6.0, 2.0, 4));
        assert_eq!(decades(-300.0, 4.2), (-7.0, 5.0, 6));
        assert_eq!(decades(0.0, 0.0), (-2.0, 0.0, 2));
    }

    #[test]
    fn several_curves_share_their_rings() {
        let angles = || (0..=36).map(|i| 5.0 * f64::from(i));
        let panel = PolarPanel::new("p (1/sr)", angles().map(|a| (a, 1.0)))
            .with_curve([])
            .with_curve(angles().map(|a| (a, 1e-3 + a)));
        let text = Figure::new("", 1).with_polar_panel(panel).to_svg().unwrap().to_lowercase();
        let shown = |i: usize| text.contains(&COLOURS[i].to_lowercase());
        assert!(shown(0) && !shown(1) && shown(2));
    }

    #[test]
    fn awkward_values_draw_and_none_at_all_is_an_error() {
        let svg = |values: &[f64]| {
            let points = values.iter().enumerate().map(|(i, v)| (180.0 * i as f64 / 4.0, *v));
            Figure::new("", 1).with_polar_panel(PolarPanel::new("p (1/sr)", points)).to_svg()
        };
        for values in [&[1.0, 0.1, 0.0, 1e-300, 1e9], &[1.0, f64::NAN, -1.0, 2.0, 3.0], &[1.0; 5]] {
            let text = svg(values).unwrap();
            assert!(text.contains("p (1/sr)") && text.contains("150°") && !text.contains("210°"));
            assert!(!text.contains("NaN") && !text.contains("inf"));
        }
        assert!(matches!(svg(&[0.0, f64::NAN]), Err(PlotError::Empty { .. })));
    }
}
