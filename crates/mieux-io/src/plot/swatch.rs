//! Patches of colour with their names.

use kuva::render::render::{Primitive, Scene, TextAnchor};
use mieux_optics::spectrum::colour::srgb_encode;

/// Patches in a row, before the next row begins.
const COLUMNS: usize = 6;
const PATCH: [f64; 2] = [140.0, 84.0];
const GAP: f64 = 12.0;
/// Room below a patch for two lines of its name.
const LABEL: f64 = 36.0;
/// Letters that fit below a patch.
const LETTERS: usize = 23;

/// Patches of linear sRGB (1 is white; what a screen cannot show is cut off) with a name each, in rows, as the text of an SVG
/// file. A name too long for one line goes on in a second.
pub fn swatch_figure(title: &str, patches: &[(String, [f64; 3])]) -> String {
    let columns = patches.len().clamp(1, COLUMNS);
    let rows = patches.len().div_ceil(columns).max(1);
    let top = if title.is_empty() { GAP } else { 44.0 };
    let width = GAP + columns as f64 * (PATCH[0] + GAP);
    let mut scene = Scene::new(width, top + rows as f64 * (PATCH[1] + LABEL + GAP));
    // As on the other figures.
    scene.font_family = Some("DejaVu Sans, Verdana, Liberation Sans, Arial, sans-serif".to_owned());
    let text = |x: f64, y: f64, content: String, size: u32| Primitive::Text {
        x,
        y,
        content,
        size,
        anchor: TextAnchor::Middle,
        rotate: None,
        bold: false,
        color: None,
    };
    if !title.is_empty() {
        let fits = (width / (0.58 * title.chars().count().max(1) as f64)).clamp(8.0, 17.0);
        scene.add(text(0.5 * width, 27.0, super::literal(title), fits as u32));
    }
    for (i, (label, rgb)) in patches.iter().enumerate() {
        let x = GAP + (i % columns) as f64 * (PATCH[0] + GAP);
        let y = top + (i / columns) as f64 * (PATCH[1] + LABEL + GAP);
        scene.add(Primitive::Rect {
            x,
            y,
            width: PATCH[0],
            height: PATCH[1],
            fill: hex(*rgb).as_str().into(),
            stroke: Some("#999999".into()),
            stroke_width: Some(0.6),
            opacity: None,
        });
        for (line, part) in lines(label).into_iter().enumerate() {
            let below = y + PATCH[1] + 15.0 + 14.0 * line as f64;
            scene.add(text(x + 0.5 * PATCH[0], below, super::literal(&part), 11));
        }
    }
    kuva::backend::svg::SvgBackend::new().render_scene(&scene)
}

/// A linear colour as screens take it, "#1a2b3c"; what they cannot show is cut off.
pub fn hex(linear: [f64; 3]) -> String {
    let [r, g, b] = linear.map(|v| (255.0 * srgb_encode(v)).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// At most two lines, broken at a space where there is one.
fn lines(label: &str) -> Vec<String> {
    let letters: Vec<char> = label.chars().collect();
    if letters.len() <= LETTERS {
        return vec![label.to_owned()];
    }
    let space = letters[..=LETTERS].iter().rposition(|c| *c == ' ').filter(|at| *at > 0);
    let (first, rest) = letters.split_at(space.unwrap_or(LETTERS));
    let rest: String = rest.iter().collect::<String>().trim_start().to_owned();
    let second = if rest.chars().count() > LETTERS {
        rest.chars().take(LETTERS - 1).chain(std::iter::once('…')).collect()
    } else {
        rest
    };
    vec![first.iter().collect(), second]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_patch_has_its_colour_and_name() {
        let patches: Vec<(String, [f64; 3])> = (0..8)
            .map(|i| (format!("patch <{i}> of a long name, too long for a line"), [f64::from(i) / 7.0, 0.2, 2.0]))
            .collect();
        let svg = swatch_figure("a & b", &patches);
        assert!(svg.contains("a &amp; b") && svg.contains("patch &lt;7&gt;") && svg.contains("#ff7cff"), "{svg}");
        assert!(!svg.contains("NaN"));
        assert!(swatch_figure("", &[]).contains("<svg"));
    }

    #[test]
    fn colours_are_cut_off_at_what_a_screen_shows() {
        assert_eq!(hex([0.0, 1.0, 0.215_860_5]), "#00ff80");
        assert_eq!(hex([-1.0, 7.0, f64::NAN]), "#00ff00");
    }
}
