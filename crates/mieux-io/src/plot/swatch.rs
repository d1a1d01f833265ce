//! Patches of colour with names, in rows: by themselves, or below the panels of a figure.

use kuva::render::render::{Primitive, Scene, TextAnchor};
use mieux_optics::spectrum::colour::srgb_encode;

use super::{Figure, literal};

/// Margin around the patches, gap between them, and size of their labels, in units of the drawing.
const MARGIN: f64 = 24.0;
const GAP: f64 = 12.0;
const LABEL_SIZE: f64 = 12.0;
const LINE_HEIGHT: f64 = 15.0;
/// Of a patch.
const HEIGHT: f64 = 64.0;
const LEAST_WIDTH: f64 = 72.0;
const MOST_WIDTH: f64 = 130.0;
/// A letter's share of the size, about.
const LETTER: f64 = 0.58;
/// Widest figure of patches alone.
const WIDEST: f64 = 920.0;

/// A figure of patches under a title: a label for each, and its colour in linear sRGB (clamped to what a screen can show).
/// Patches go from left to right and then down, in the order given. Labels are broken into lines at blanks; no-break spaces
/// hold what belongs together.
pub fn swatch_figure(title: &str, patches: &[(String, [f64; 3])]) -> Figure {
    patches.iter().fold(Figure::new(title, 1), |figure, (label, colour)| figure.with_swatch(label, *colour))
}

/// A linear sRGB colour as a screen takes it, `#rrggbb`: clamped, encoded, rounded; what is no number is black.
pub fn srgb_hex(linear: [f64; 3]) -> String {
    let [r, g, b] = srgb_bytes(linear);
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// A linear sRGB colour in three bytes, as [`srgb_hex`] writes them.
pub fn srgb_bytes(linear: [f64; 3]) -> [u8; 3] {
    // A float becomes the nearest byte there is; NaN becomes 0.
    linear.map(|channel| (255.0 * srgb_encode(channel)).round() as u8)
}

/// One patch.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Swatch {
    pub label: String,
    pub colour: [f64; 3],
}

/// How patches are laid out in a given width.
struct Grid {
    columns: usize,
    rows: usize,
    width: f64,
    lines: usize,
}

impl Grid {
    fn new(swatches: &[Swatch], available: f64) -> Self {
        // A label in two lines, none of its words cut.
        let letters = |text: &str| text.chars().count();
        let wanted = |label: &str| {
            let word = words(label).map(letters).max().unwrap_or(0);
            word.max(letters(label).div_ceil(2)) as f64
        };
        let longest = swatches.iter().map(|s| wanted(&s.label)).fold(0.0, f64::max);
        let width = (LETTER * LABEL_SIZE * longest).clamp(LEAST_WIDTH, MOST_WIDTH);
        let most = (((available - 2.0 * MARGIN + GAP) / (width + GAP)) as usize).max(1);
        let rows = swatches.len().div_ceil(most).max(1);
        // Rows of about one length.
        let columns = swatches.len().div_ceil(rows).max(1);
        let lines = swatches.iter().map(|s| wrapped(&s.label, width).len()).max().unwrap_or(0);
        Self { columns, rows, width, lines }
    }

    fn size(&self) -> [f64; 2] {
        let cells = |count: usize, size: f64| count as f64 * (size + GAP) - GAP;
        [cells(self.columns, self.width) + 2.0 * MARGIN, cells(self.rows, self.cell_height()) + MARGIN]
    }

    fn cell_height(&self) -> f64 {
        HEIGHT + 4.0 + LINE_HEIGHT * self.lines as f64
    }
}

/// The width that patches want by themselves.
pub(super) fn natural_width(swatches: &[Swatch]) -> f64 {
    Grid::new(swatches, WIDEST).size()[0]
}

/// Adds patches below what a scene holds, in the middle of its width.
pub(super) fn draw_below(scene: &mut Scene, swatches: &[Swatch]) {
    if swatches.is_empty() {
        return;
    }
    let grid = Grid::new(swatches, scene.width);
    let [width, height] = grid.size();
    let (left, top) = (0.5 * (scene.width - width) + MARGIN, scene.height);
    for (i, swatch) in swatches.iter().enumerate() {
        let x = left + (i % grid.columns) as f64 * (grid.width + GAP);
        let y = top + (i / grid.columns) as f64 * (grid.cell_height() + GAP);
        scene.add(Primitive::Rect {
            x,
            y,
            width: grid.width,
            height: HEIGHT,
            fill: srgb_hex(swatch.colour).into(),
            stroke: Some("#888888".into()),
            stroke_width: Some(0.8),
            opacity: None,
        });
        for (line, content) in wrapped(&swatch.label, grid.width).into_iter().enumerate() {
            let y = y + HEIGHT + 2.0 + LINE_HEIGHT * (line as f64 + 0.85);
            scene.add(text(x + 0.5 * grid.width, y, &content, LABEL_SIZE as u32, TextAnchor::Middle));
        }
    }
    scene.height = top + height;
}

/// A line of text in a scene.
pub(super) fn text(x: f64, y: f64, content: &str, size: u32, anchor: TextAnchor) -> Primitive {
    Primitive::Text { x, y, content: literal(content), size, anchor, rotate: None, bold: false, color: None }
}

/// What blanks separate; a no-break space does not.
fn words(label: &str) -> impl Iterator<Item = &str> {
    label.split(' ').filter(|word| !word.is_empty())
}

/// A label in lines that fit a width, cut at blanks that may be cut at; a third line ends in an ellipsis.
fn wrapped(label: &str, width: f64) -> Vec<String> {
    const MOST_LINES: usize = 3;
    let fits = ((width + 0.5 * GAP) / (LETTER * LABEL_SIZE)) as usize;
    let mut lines: Vec<String> = Vec::new();
    for word in words(label) {
        let count = |text: &str| text.chars().count();
        match lines.last_mut() {
            Some(line) if count(line) + 1 + count(word) <= fits => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    if lines.len() > MOST_LINES {
        lines.truncate(MOST_LINES);
        lines.iter_mut().skip(MOST_LINES - 1).for_each(|line| line.push('…'));
    }
    for line in &mut lines {
        if line.chars().count() > fits {
            *line = line.chars().take(fits.saturating_sub(1)).chain(['…']).collect();
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_encoded_and_clamped() {
        assert_eq!(srgb_hex([0.0, 1.0, 2.0]), "#00ffff");
        // The middle of the curve: 0.2140 is 127.5 of 255 (IEC 61966-2-1).
        assert_eq!(srgb_hex([0.2140, 0.2159, f64::NAN]), "#7f8000");
        assert_eq!(srgb_bytes([-1.0, 0.0, 0.0]), [0; 3]);
    }

    #[test]
    fn patches_are_named_and_a_figure_of_none_is_an_error() {
        let patches: Vec<_> =
            (0..9).map(|i| (format!("patch {i} & its name"), [0.1 * f64::from(i), 0.5, 0.2])).collect();
        let figure = swatch_figure("Paints", &patches);
        let svg = figure.to_svg().unwrap();
        assert!(svg.contains("Paints") && svg.contains("patch 8 &amp;"), "{svg}");
        for (_, colour) in &patches {
            assert!(svg.contains(&srgb_hex(*colour)), "{colour:?}");
        }
        assert_eq!(&figure.to_png(1.0).unwrap()[1..4], b"PNG");
        assert!(swatch_figure("Paints", &[]).to_svg().is_err());
    }

    #[test]
    fn long_labels_are_cut_at_blanks() {
        assert_eq!(wrapped("short", 84.0), ["short"]);
        let pair =
            ["1 mm reflected", "ultramarine with white"].map(|label| Swatch { label: label.into(), colour: [0.5; 3] });
        assert_eq!(Grid::new(&pair, 400.0).lines, 2);
        assert_eq!(wrapped("ultramarine blue", 84.0), ["ultramarine", "blue"]);
        assert_eq!(wrapped("whole milk 10\u{a0}mm", 84.0), ["whole milk", "10\u{a0}mm"]);
        assert_eq!(wrapped("a b c d e f g h i j k l m n o p q r s t u v w x y z 1 2 3 4", 84.0).len(), 3);
        assert!(wrapped("unbreakableunbreakable", 84.0)[0].ends_with('…'));
    }
}
