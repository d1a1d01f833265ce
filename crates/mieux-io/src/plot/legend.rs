//! Finds the place for a legend that is farthest from the data.

use kuva::plot::LegendPosition;

use super::axis::Axis;

/// The part of a panel's width and height that a legend with these labels takes, about.
fn extent<'a>(labels: impl Iterator<Item = &'a str>) -> (f64, f64) {
    let (mut rows, mut longest) = (0, 0);
    for label in labels {
        rows += 1;
        longest = label.chars().count().max(longest);
    }
    // A panel is some 370 by 230 units; a letter is 6 wide and a row 18 high.
    ((45.0 + 6.2 * longest as f64) / 370.0, (14.0 + 18.0 * f64::from(rows)) / 230.0)
}

/// The position of the legend, given the lines of a panel in the units of its axes; outside where it would cover some.
pub(super) fn place<'a>(
    labels: impl Iterator<Item = &'a str>,
    lines: &[Vec<(f64, f64)>],
    x_axis: &Axis,
    y_axis: &Axis,
) -> LegendPosition {
    let (width, height) = extent(labels);
    // From the left edge and from the top.
    let at = |&(x, y): &(f64, f64)| (x_axis.fraction(x), 1.0 - y_axis.fraction(y));
    let mut dots = Vec::new();
    for line in lines {
        dots.extend(line.first().map(at));
        for pair in line.windows(2) {
            let (from, to) = (at(&pair[0]), at(&pair[1]));
            let steps = (40.0 * (to.0 - from.0).abs().max((to.1 - from.1).abs())).ceil().clamp(1.0, 40.0) as usize;
            dots.extend((1..=steps).map(|i| {
                let t = i as f64 / steps as f64;
                (from.0 + t * (to.0 - from.0), from.1 + t * (to.1 - from.1))
            }));
        }
    }
    const PLACES: usize = 16;
    let mut best = (f64::NEG_INFINITY, (0.0, 0.0));
    for i in 0..=PLACES {
        for j in 0..=PLACES {
            // From the right and from the top, so that this is where the legend goes when all places are equal.
            let left = 0.02 + (0.96 - width).max(0.0) * (1.0 - i as f64 / PLACES as f64);
            let top = 0.03 + (0.94 - height).max(0.0) * j as f64 / PLACES as f64;
            let gap = |&(x, y): &(f64, f64)| {
                let dx = (left - x).max(x - left - width).max(0.0);
                let dy = (top - y).max(y - top - height).max(0.0);
                dx.hypot(dy)
            };
            // More room than this is of no use.
            let clear = dots.iter().map(gap).fold(0.25, f64::min);
            if clear > best.0 + 1e-9 {
                best = (clear, (left, top));
            }
        }
    }
    let (clear, (left, top)) = best;
    if clear <= 0.0 {
        return LegendPosition::OutsideRightTop;
    }
    LegendPosition::DataCoords(x_axis.value(left), y_axis.value(1.0 - top))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::Scale;

    #[test]
    fn a_legend_keeps_out_of_the_way() {
        let x = Axis::horizontal([0.0, 1.0].into_iter(), Scale::Linear, false);
        let y = Axis::vertical([1.0, 1e4].into_iter(), Scale::Log, true);
        let top = (0..=20).map(|i| (f64::from(i) / 20.0, 8e3)).collect();
        let place = place(["one", "two"].into_iter(), &[top], &x, &y);
        assert!(matches!(place, LegendPosition::DataCoords(at_x, at_y) if at_x > 0.5 && at_y < 3e3));
    }

    #[test]
    fn where_there_is_no_room_a_legend_goes_outside() {
        let x = Axis::horizontal([0.0, 1.0].into_iter(), Scale::Linear, false);
        let y = Axis::vertical([0.0, 1.0].into_iter(), Scale::LinearOver(0.0, 1.0), false);
        let lines: Vec<_> = (0..20).map(|i| f64::from(i) / 20.0).map(|u| vec![(0.0, u), (1.0, u)]).collect();
        let place = place(["one", "two", "three"].into_iter(), &lines, &x, &y);
        assert!(matches!(place, LegendPosition::OutsideRightTop));
    }
}
