//! One bar cut into shares, with a legend below it: where all of something goes.

use kuva::render::render::{Primitive, Scene, TextAnchor};

use super::COLOURS;
use super::swatch::text;
use crate::quantity::significant;

const MARGIN: f64 = 24.0;
const HEIGHT: f64 = 40.0;
const ROW: f64 = 20.0;
const LEGEND_COLUMN: f64 = 200.0;

/// A share and its name.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Share {
    pub label: String,
    pub share: f64,
}

/// The width that a bar wants by itself.
pub(super) const NATURAL_WIDTH: f64 = 2.0 * MARGIN + 2.0 * LEGEND_COLUMN + 60.0;

/// Adds a bar below what a scene holds. Shares are of their sum; what is not more than 0 has a legend and no bar.
pub(super) fn draw_below(scene: &mut Scene, shares: &[Share]) {
    if shares.is_empty() {
        return;
    }
    let positive = |share: &Share| if share.share > 0.0 { share.share } else { 0.0 };
    let total: f64 = shares.iter().map(positive).sum();
    let (width, top) = (scene.width - 2.0 * MARGIN, scene.height);
    let mut x = MARGIN;
    let rect = |x: f64, y: f64, width: f64, height: f64, colour: &str| Primitive::Rect {
        x,
        y,
        width,
        height,
        fill: colour.into(),
        stroke: None,
        stroke_width: None,
        opacity: None,
    };
    let columns = ((width / LEGEND_COLUMN) as usize).clamp(1, shares.len());
    for (i, share) in shares.iter().enumerate() {
        let colour = COLOURS[i % COLOURS.len()];
        let part = if total > 0.0 { width * positive(share) / total } else { 0.0 };
        if part > 0.0 {
            scene.add(rect(x, top, part, HEIGHT, colour));
            x += part;
        }
        let at = MARGIN + (i % columns) as f64 * LEGEND_COLUMN;
        let y = top + HEIGHT + 12.0 + (i / columns) as f64 * ROW;
        scene.add(rect(at, y, 11.0, 11.0, colour));
        let label = format!("{} {} %", share.label, significant(100.0 * share.share, 4));
        scene.add(text(at + 17.0, y + 10.0, &label, 12, TextAnchor::Start));
    }
    scene.height = top + HEIGHT + 18.0 + shares.len().div_ceil(columns) as f64 * ROW + 8.0;
}

#[cfg(test)]
mod tests {
    use crate::plot::Figure;

    #[test]
    fn shares_are_named_with_their_size() {
        let figure = Figure::new("Slab", 1).with_share("reflected", 0.25).with_share("absorbed", 0.75);
        let svg = figure.with_share("nothing", 0.0).to_svg().unwrap();
        for part in ["reflected 25 %", "absorbed 75 %", "nothing 0 %"] {
            assert!(svg.contains(part), "{part}");
        }
        assert!(!svg.contains("NaN"));
    }
}
