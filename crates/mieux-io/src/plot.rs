//! Figures: panels of lines with titles, units and legends, as SVG or PNG.
//!
//! A [`Panel`] holds [`Series`] of points on a linear or logarithmic axis, a [`Figure`] holds panels in columns.
//! A [`PolarPanel`] shows a value over the angle from the direction of light. Patches of colour ([`swatch_figure`]) and a bar
//! of shares stand below the panels, or alone. [`optics_figure`] is the figure of a
//! material's optical properties; [`efficiency_figure`], [`phase_figure`] and [`polarisation_figure`] show one particle.

mod axis;
mod inversion;
mod legend;
mod mie;
mod optics;
mod phase;
mod polar;
mod shares;
mod swatch;

use kuva::plot::line::LineStyle;
use kuva::plot::{LegendPosition, LinePlot, ScatterPlot};
use kuva::render::figure::Figure as Drawing;
use kuva::render::layout::{Layout, TickFormat};
use kuva::render::plots::Plot;
use kuva::render::render::{Scene, TextAnchor};

use axis::Axis;
pub use inversion::{Measured, inversion_figure};
pub use mie::{SizePlot, efficiency_figure, phase_figure, polarisation_figure};
pub use optics::{OpticsPlot, optics_figure, optics_svg};
pub use phase::comparison_figure;
pub use polar::PolarPanel;
use shares::Share;
use swatch::Swatch;
pub use swatch::{srgb_bytes, srgb_hex, swatch_figure};

/// Colours that most people tell apart (Okabe and Ito), and dashes for those who do not.
const COLOURS: [&str; 7] = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#333333"];

/// Up to so many points, each gets a marker.
const MARKED_POINTS: usize = 40;

/// What panels have by themselves.
const FONT: &str = "DejaVu Sans, Verdana, Liberation Sans, Arial, sans-serif";

/// Width of a panel with its labels, in units of the drawing.
const CELL_WIDTH: f64 = 460.0;

/// What can be wrong with a figure.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlotError {
    /// A quantity without a value for every position on the x axis.
    #[error("{quantity} has {found} values for {expected} wavelengths")]
    Length {
        /// Which quantity.
        quantity: &'static str,
        /// How many values it has.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// No finite point to show.
    #[error("there is nothing to plot: no finite value in `{title}`")]
    Empty {
        /// The title of the figure or panel.
        title: String,
    },
    /// A picture that cannot be made.
    #[error("the picture cannot be made at {scale} pixels per unit: {problem}; the scale is more than 0 and at most 8")]
    Raster {
        /// Pixels per unit of the drawing.
        scale: f32,
        /// Why.
        problem: String,
    },
}

/// How an axis runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scale {
    /// Evenly, over what the data need.
    Linear,
    /// Evenly, over these two values at least.
    LinearOver(f64, f64),
    /// Evenly from 0 to 180 degrees, a tick every 30.
    ScatteringAngle,
    /// By factors. Points that are not more than 0 are left out; with none left, the axis is linear.
    Log,
}

/// One line, or a single marker where there is one point.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    label: String,
    points: Vec<(f64, f64)>,
    errors: Option<Vec<f64>>,
}

impl Series {
    /// Points (x, y) in the units of the panel's axes; those that are not finite are left out.
    pub fn new(label: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self { label: label.into(), points: points.into_iter().collect(), errors: None }
    }

    /// Adds error bars: the standard error of y for every point, in the unit of y. A missing one is none.
    pub fn with_errors(mut self, errors: impl IntoIterator<Item = f64>) -> Self {
        self.errors = Some(errors.into_iter().collect());
        self
    }

    /// The points that can be shown, each with its error bar (0 where there is none).
    fn shown(&self, log_x: bool, log_y: bool) -> Vec<(f64, f64, f64)> {
        let error =
            |i: usize| self.errors.as_ref().and_then(|e| e.get(i)).copied().filter(|e| *e > 0.0 && e.is_finite());
        let shows = |v: f64, log: bool| v.is_finite() && (!log || v > 0.0);
        let points = self.points.iter().enumerate();
        points
            .filter(|(_, (x, y))| shows(*x, log_x) && shows(*y, log_y))
            .map(|(i, &(x, y))| (x, y, error(i).unwrap_or(0.0)))
            .collect()
    }
}

/// One pair of axes with lines over it.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    title: String,
    x_label: String,
    y_label: String,
    x_scale: Scale,
    y_scale: Scale,
    series: Vec<Series>,
}

impl Panel {
    /// A panel without lines. The labels name the quantity and its unit: "Wavelength (nm)".
    pub fn new(title: impl Into<String>, x_label: impl Into<String>, y_label: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            x_label: x_label.into(),
            y_label: y_label.into(),
            x_scale: Scale::Linear,
            y_scale: Scale::Linear,
            series: Vec::new(),
        }
    }

    /// How the two axes run; both are linear unless this says otherwise.
    pub fn with_scales(mut self, x: Scale, y: Scale) -> Self {
        (self.x_scale, self.y_scale) = (x, y);
        self
    }

    /// Adds a line.
    pub fn with_series(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// The plots of the panel and the layout around them.
    fn drawn(&self, titled: bool) -> Result<(Vec<Plot>, Layout), PlotError> {
        let any_positive = |pick: fn(&(f64, f64)) -> f64| {
            self.series.iter().flat_map(|s| &s.points).any(|p| pick(p) > 0.0 && pick(p).is_finite())
        };
        let log_x = self.x_scale == Scale::Log && any_positive(|p| p.0);
        let log_y = self.y_scale == Scale::Log && any_positive(|p| p.1);
        let shown: Vec<_> = self.series.iter().map(|series| series.shown(log_x, log_y)).collect();
        let all = || shown.iter().flatten();
        if all().next().is_none() {
            return Err(PlotError::Empty { title: self.title.clone() });
        }
        let x_axis = Axis::horizontal(all().map(|p| p.0), self.x_scale, log_x);
        let reach = |&(_, y, e): &(f64, f64, f64)| [y, y + e, if log_y && y <= e { y } else { y - e }];
        let y_axis = Axis::vertical(all().flat_map(reach), self.y_scale, log_y);
        let mut plots = Vec::new();
        for (i, (series, points)) in self.series.iter().zip(&shown).enumerate() {
            draw_series(&mut plots, series, points, i, self.series.len() > 1, &y_axis);
        }
        let mut layout = Layout::auto_from_plots(&plots)
            .with_x_label(literal(&self.x_label))
            .with_y_label(literal(&self.y_label))
            .with_x_axis_min(x_axis.low)
            .with_x_axis_max(x_axis.high)
            .with_y_axis_min(y_axis.low)
            .with_y_axis_max(y_axis.high)
            .with_x_tick_format(ticks(&x_axis))
            .with_y_tick_format(ticks(&y_axis))
            .with_legend_position(self.legend(&shown, &x_axis, &y_axis))
            .with_title_size(14)
            .with_label_size(12)
            .with_tick_size(11);
        if titled {
            layout = layout.with_title(literal(&self.title));
        }
        layout = if log_x { layout.with_log_x() } else { layout.with_x_tick_step(x_axis.step) };
        layout = if log_y { layout.with_log_y() } else { layout.with_y_tick_step(y_axis.step) };
        layout.theme.grid_color = "#e6e6e6".to_owned();
        layout.theme.axis_color = "#444444".to_owned();
        layout.theme.legend_border = "#cccccc".to_owned();
        Ok((plots, layout))
    }

    fn legend(&self, shown: &[Vec<(f64, f64, f64)>], x_axis: &Axis, y_axis: &Axis) -> LegendPosition {
        let ends = |&(x, y, e): &(f64, f64, f64)| {
            let bar = (e > 0.0).then_some([(x, (y - e).max(y_axis.low)), (x, (y + e).min(y_axis.high)), (x, y)]);
            std::iter::once((x, y)).chain(bar.into_iter().flatten())
        };
        let lines: Vec<Vec<_>> = shown.iter().map(|points| points.iter().flat_map(ends).collect()).collect();
        legend::place(self.series.iter().map(|series| series.label.as_str()), &lines, x_axis, y_axis)
    }
}

fn ticks(axis: &Axis) -> TickFormat {
    let style = axis.style;
    TickFormat::Custom(std::sync::Arc::new(move |value| style.format(value)))
}

/// Adds a line with error bars, and markers where the points are few.
fn draw_series(
    plots: &mut Vec<Plot>,
    series: &Series,
    points: &[(f64, f64, f64)],
    index: usize,
    labelled: bool,
    y_axis: &Axis,
) {
    let colour = COLOURS[index % COLOURS.len()];
    let label = Some(literal(&series.label)).filter(|label| labelled && !label.is_empty());
    let data = || points.iter().map(|p| (p.0, p.1));
    // On a logarithmic axis a bar that reaches 0 ends at the edge.
    let arms = || {
        points
            .iter()
            .map(|&(_, y, error)| (error.min((y - y_axis.low).max(0.0)), error.min((y_axis.high - y).max(0.0))))
    };
    let has_errors = points.iter().any(|p| p.2 > 0.0);
    let single = points.len() == 1;
    if !single && !points.is_empty() {
        let mut line =
            LinePlot::new().with_data(data()).with_color(colour).with_stroke_width(1.8).with_line_style(dash(index));
        if has_errors {
            line = line.with_y_err_asymmetric(arms());
        }
        if let Some(label) = &label {
            line = line.with_legend(label.clone());
        }
        plots.push(line.into());
    }
    if points.len() <= MARKED_POINTS && !points.is_empty() {
        let size = if single { 5.0 } else { 2.6 };
        let mut markers = ScatterPlot::new().with_data(data()).with_color(colour).with_size(size);
        if single && has_errors {
            markers = markers.with_y_err_asymmetric(arms());
        }
        if let Some(label) = label.filter(|_| single) {
            markers = markers.with_legend(label);
        }
        plots.push(markers.into());
    }
}

/// How the line of a number is dashed.
fn dash(index: usize) -> LineStyle {
    [LineStyle::Solid, LineStyle::Dashed, LineStyle::DashDot, LineStyle::Dotted][index % 4].clone()
}

/// A text in which `$` is a dollar and not the start of a formula.
fn literal(text: &str) -> String {
    text.replace('$', "\\$").replace(['\n', '\r'], " ")
}

/// Panels under a title, from left to right and then down; below them a bar of shares and patches of colour, if any.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    title: String,
    columns: usize,
    panels: Vec<Pane>,
    shares: Vec<Share>,
    swatches: Vec<Swatch>,
}

/// Anything that takes a place in a figure.
#[derive(Debug, Clone, PartialEq)]
enum Pane {
    Lines(Panel),
    Polar(PolarPanel),
}

impl Pane {
    fn drawn(&self) -> Result<(Vec<Plot>, Layout), PlotError> {
        match self {
            Self::Lines(panel) => panel.drawn(!panel.title.is_empty()),
            Self::Polar(panel) => panel.drawn(),
        }
    }
}

impl Figure {
    /// A figure without panels, with so many columns (0 is taken as 1).
    pub fn new(title: impl Into<String>, columns: usize) -> Self {
        Self {
            title: title.into(),
            columns: columns.max(1),
            panels: Vec::new(),
            shares: Vec::new(),
            swatches: Vec::new(),
        }
    }

    /// Adds a panel.
    pub fn with_panel(mut self, panel: Panel) -> Self {
        self.panels.push(Pane::Lines(panel));
        self
    }

    /// Adds a polar panel.
    pub fn with_polar_panel(mut self, panel: PolarPanel) -> Self {
        self.panels.push(Pane::Polar(panel));
        self
    }

    /// Adds a share (0 to 1) to the bar below the panels.
    pub fn with_share(mut self, label: impl Into<String>, share: f64) -> Self {
        self.shares.push(Share { label: label.into(), share });
        self
    }

    /// Adds a patch of a colour in linear sRGB below the panels.
    pub fn with_swatch(mut self, label: impl Into<String>, colour: [f64; 3]) -> Self {
        self.swatches.push(Swatch { label: label.into(), colour });
        self
    }

    /// The figure as the text of an SVG file.
    ///
    /// # Errors
    /// [`PlotError::Empty`] without anything to show, or when one has no finite point.
    pub fn to_svg(&self) -> Result<String, PlotError> {
        Ok(kuva::backend::svg::SvgBackend::new().render_scene(&self.scene()?))
    }

    /// The figure as the bytes of a PNG file, with `scale` pixels per unit of the drawing (1 to see, 2 to print).
    ///
    /// # Errors
    /// As [`Figure::to_svg`], or [`PlotError::Raster`] unless `0 < scale <= 8`.
    pub fn to_png(&self, scale: f32) -> Result<Vec<u8>, PlotError> {
        if !(scale > 0.0 && scale <= 8.0) {
            return Err(PlotError::Raster { scale, problem: "out of range".to_owned() });
        }
        let scene = self.scene()?;
        kuva::RasterBackend::new()
            .with_scale(scale)
            .render_scene(&scene)
            .map_err(|problem| PlotError::Raster { scale, problem })
    }

    fn scene(&self) -> Result<Scene, PlotError> {
        let mut scene = if self.panels.is_empty() { self.bare()? } else { self.panel_scene()? };
        shares::draw_below(&mut scene, &self.shares);
        swatch::draw_below(&mut scene, &self.swatches);
        Ok(scene)
    }

    /// The title alone, over the width that the rest needs.
    fn bare(&self) -> Result<Scene, PlotError> {
        if self.shares.is_empty() && self.swatches.is_empty() {
            return Err(PlotError::Empty { title: self.title.clone() });
        }
        let shares = if self.shares.is_empty() { 0.0 } else { shares::NATURAL_WIDTH };
        // A title at its smallest.
        let titled = 0.6 * 9.0 * self.title.chars().count() as f64;
        let width = swatch::natural_width(&self.swatches).max(shares).max(titled).max(240.0);
        let mut scene = Scene::new(width, 20.0);
        scene.font_family = Some(FONT.to_owned());
        if !self.title.is_empty() {
            // As in `title_size`.
            let size = (width / (0.6 * self.title.chars().count() as f64)).clamp(9.0, 18.0);
            scene.add(swatch::text(0.5 * width, 30.0, &self.title, size as u32, TextAnchor::Middle));
            scene.height = 48.0;
        }
        Ok(scene)
    }

    fn panel_scene(&self) -> Result<Scene, PlotError> {
        let columns = self.columns.min(self.panels.len());
        let rows = self.panels.len().div_ceil(columns);
        let (mut plots, mut layouts) = (Vec::new(), Vec::new());
        for panel in &self.panels {
            let (panel_plots, layout) = panel.drawn()?;
            plots.push(panel_plots);
            layouts.push(layout);
        }
        // A circle wants a square.
        let height = if self.panels.iter().any(|p| matches!(p, Pane::Polar(_))) { 440.0 } else { 320.0 };
        let structure = (0..self.panels.len()).map(|i| vec![i]).collect();
        let mut drawing = Drawing::new(rows, columns)
            .with_structure(structure)
            .with_plots(plots)
            .with_layouts(layouts)
            .with_cell_size(CELL_WIDTH, height)
            .with_title_size(title_size(&self.title, columns))
            .with_padding(14.0);
        if !self.title.is_empty() {
            drawing = drawing.with_title(literal(&self.title));
        }
        Ok(drawing.render())
    }
}

/// 18, or less where the title would not fit above so many columns.
fn title_size(title: &str, columns: usize) -> u32 {
    // A letter is some 0.6 of the size wide.
    let fits = columns as f64 * CELL_WIDTH / (0.6 * title.chars().count().max(1) as f64);
    fits.clamp(9.0, 18.0) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(points: &[(f64, f64)], scale: Scale) -> Panel {
        Panel::new("a panel", "x (nm)", "y (1/m)")
            .with_scales(Scale::Linear, scale)
            .with_series(Series::new("one", points.iter().copied()))
    }

    fn svg(panel: Panel) -> Result<String, PlotError> {
        Figure::new("a < b & $c$", 2).with_panel(panel).to_svg()
    }

    #[test]
    fn a_figure_names_its_axes_and_escapes_its_title() {
        let text = svg(panel(&[(1.0, 2.0), (2.0, 3.0)], Scale::Linear)).unwrap();
        for part in ["a &lt; b &amp; $c$", "a panel", "x (nm)", "y (1/m)"] {
            assert!(text.contains(part), "{part}");
        }
        assert!(!text.contains("NaN") && !text.contains("inf"));
    }

    #[test]
    fn awkward_data_still_draw() {
        let cases: [&[(f64, f64)]; 9] = [
            &[(550.0, 1e4)],
            &[(550.0, 0.0)],
            &[(1.0, 0.0), (2.0, 0.0)],
            &[(1.0, 5.0), (2.0, 5.0)],
            &[(1.0, -1.0), (2.0, 1e300)],
            &[(1.0, 1e-300), (2.0, 1e300)],
            &[(1.0, f64::NAN), (2.0, 1.0), (3.0, f64::INFINITY)],
            &[(1.0, 1.3), (1.0, 1.3 + 1e-15)],
            &[(-1e9, 4.9e-324), (1e9, 1e-320)],
        ];
        for points in cases {
            for scale in [Scale::Linear, Scale::LinearOver(0.0, 1.0), Scale::Log] {
                let text = svg(panel(points, scale)).unwrap();
                assert!(!text.contains("NaN") && !text.contains("inf"), "{points:?} {scale:?}");
                let swapped = Panel::new("", "", "")
                    .with_scales(scale, scale)
                    .with_series(Series::new("", points.iter().map(|p| (p.1, p.0))));
                let text = svg(swapped);
                assert!(text.is_ok_and(|t| !t.contains("NaN")), "{points:?} {scale:?}");
            }
        }
    }

    #[test]
    fn nothing_to_show_is_an_error() {
        let empty = svg(panel(&[(1.0, f64::NAN)], Scale::Log)).unwrap_err();
        assert_eq!(empty, PlotError::Empty { title: "a panel".into() });
        assert!(Figure::new("none", 0).to_svg().is_err());
        let figure = Figure::new("", 1).with_panel(panel(&[(1.0, 2.0)], Scale::Linear));
        for scale in [0.0, -1.0, 9.0, f32::NAN] {
            assert!(matches!(figure.to_png(scale), Err(PlotError::Raster { .. })));
        }
        assert!(figure.to_png(1.0).unwrap().starts_with(b"\x89PNG"));
    }

    #[test]
    fn error_bars_are_drawn_and_stay_on_a_logarithmic_axis() {
        let bars = |scale| {
            let series = Series::new("R", (1..9).map(|i| (f64::from(i), 1.0 / f64::from(i)))).with_errors([0.5; 8]);
            svg(Panel::new("R(r)", "r (mm)", "R (1/mm2)").with_scales(Scale::Linear, scale).with_series(series))
                .unwrap()
        };
        assert!(bars(Scale::Log).len() > svg(panel(&[(1.0, 1.0); 8], Scale::Log)).unwrap().len());
        assert!(!bars(Scale::Log).contains("NaN") && !bars(Scale::Linear).contains("NaN"));
    }
}
