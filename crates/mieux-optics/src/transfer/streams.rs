//! Directions in which light is followed: quadrature nodes that map onto each other under refraction.
//!
//! What refraction leaves alone is `s = n sin(theta)`. The indices of all media cut the range of `s` into ranges: light
//! with `s` below the least index travels everywhere, light beyond is totally reflected from the media of lesser index.
//! Each range carries a Gauss rule in the cosine of the medium whose index bounds it, where radiance, Fresnel's shares
//! and the cosines of all denser media are smooth.

use std::borrow::Cow;
use std::sync::OnceLock;

use crate::integrate::gauss_legendre;

use super::Stack;

/// The streams of one hemisphere, those of the least index first.
#[derive(Debug, Clone)]
pub(crate) struct Streams {
    nodes: Vec<Node>,
}

/// One direction, in the medium that bounds its range.
#[derive(Debug, Clone, Copy)]
struct Node {
    index: f64,
    cosine: f64,
    weight: f64,
}

/// A stream as one medium sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stream {
    /// Against the normal, in this medium.
    pub cosine: f64,
    /// Quadrature weight in that cosine.
    pub weight: f64,
}

impl Streams {
    /// About `count / 2` streams in each hemisphere of the densest medium, shared between the ranges of the stack.
    pub fn new(count: usize, stack: &Stack) -> Self {
        let bounds = bounds(stack);
        // The width of each range in the cosine of its own medium is the share of nodes it gets.
        let before = std::iter::once(0.0).chain(bounds.iter().copied());
        let ranges: Vec<(f64, f64)> =
            bounds.iter().zip(before).map(|(&n, before)| (n, (1.0 - (before / n).powi(2)).sqrt())).collect();
        let total: f64 = ranges.iter().map(|(_, width)| width).sum();
        let wanted = (count / 2).max(ranges.len()) as f64;
        let mut nodes = Vec::with_capacity(count / 2 + ranges.len());
        let mut reached = 0.0;
        for (index, width) in ranges {
            reached += wanted * width / total;
            let share = ((reached.round() as usize).saturating_sub(nodes.len())).max(1);
            nodes.extend(rule(share).iter().map(|(x, w)| Node {
                index,
                cosine: 0.5 * width * (1.0 + x),
                weight: 0.5 * width * w,
            }));
        }
        Self { nodes }
    }

    /// The streams that travel in a medium of the given index, as it sees them.
    pub fn within(&self, index: f64) -> Vec<Stream> {
        let count = self.nodes.partition_point(|node| node.index <= index);
        self.nodes[..count].iter().map(|node| node.seen_from(index)).collect()
    }
}

impl Node {
    fn seen_from(&self, index: f64) -> Stream {
        if index == self.index {
            return Stream { cosine: self.cosine, weight: self.weight };
        }
        let cosine = refracted_cosine(self.cosine, self.index, index).unwrap_or(0.0);
        // n^2 mu d(mu) is the same on both sides.
        Stream { cosine, weight: self.weight * self.cosine * self.index * self.index / (cosine * index * index) }
    }
}

/// A Gauss rule on [-1, 1], computed once.
fn rule(count: usize) -> Cow<'static, [(f64, f64)]> {
    static RULES: [OnceLock<Vec<(f64, f64)>>; 129] = [const { OnceLock::new() }; 129];
    match RULES.get(count) {
        Some(known) => Cow::Borrowed(known.get_or_init(|| gauss_legendre(count))),
        None => Cow::Owned(gauss_legendre(count)),
    }
}

/// The cosine in a medium of index `to` of light that has `cosine` in one of index `from` (Snell); `None` where it is
/// totally reflected.
pub(crate) fn refracted_cosine(cosine: f64, from: f64, to: f64) -> Option<f64> {
    let squared = (to - from) * (to + from) + (from * cosine).powi(2);
    (squared > 0.0).then(|| squared.sqrt() / to)
}

/// The greatest index that counts: panes denser than everything that scatters hold only trapped light, which nothing
/// feeds.
pub(crate) fn greatest_index(stack: &Stack) -> f64 {
    let active = stack.layers.iter().filter(|layer| layer.is_active()).map(|layer| layer.refractive_index);
    active.chain([stack.above, stack.below]).fold(0.0, f64::max)
}

/// The different indices, ascending, up to the greatest that counts.
fn bounds(stack: &Stack) -> Vec<f64> {
    let outside = [stack.above, stack.below];
    let greatest = greatest_index(stack);
    let mut indices: Vec<f64> = stack.layers.iter().map(|layer| layer.refractive_index).chain(outside).collect();
    indices.retain(|n| *n <= greatest);
    indices.sort_by(f64::total_cmp);
    indices.dedup();
    indices
}

#[cfg(test)]
mod tests {
    use super::super::{Ground, Layer, Moments};
    use super::*;

    fn stack(indices: &[f64]) -> Stack {
        let layers = indices.iter().map(|n| Layer::new(1.0, 0.5, Moments::isotropic()).with_index(*n)).collect();
        Stack { above: 1.0, layers, below: 1.0, ground: Ground::Black }
    }

    #[test]
    fn one_index_gives_the_double_gauss_rule() {
        let streams = Streams::new(8, &stack(&[1.0])).within(1.0);
        assert_eq!(streams.len(), 4);
        for power in 0..8 {
            let sum: f64 = streams.iter().map(|s| s.weight * s.cosine.powi(power)).sum();
            assert!((sum - 1.0 / f64::from(power + 1)).abs() < 1e-15, "{power}: {sum}");
        }
    }

    #[test]
    fn every_medium_integrates_powers_of_its_cosine() {
        let streams = Streams::new(48, &stack(&[1.4, 1.2, 1.5]));
        for index in [1.0, 1.2, 1.4, 1.5] {
            let seen = streams.within(index);
            for power in 0..10 {
                let sum: f64 = seen.iter().map(|s| s.weight * s.cosine.powi(power)).sum();
                assert!((sum - 1.0 / f64::from(power + 1)).abs() < 1e-6, "{index} {power}: {sum}");
            }
        }
        let counts: Vec<usize> = [1.0, 1.2, 1.4, 1.5].iter().map(|n| streams.within(*n).len()).collect();
        assert!(counts.windows(2).all(|pair| pair[0] < pair[1]) && counts[3] == 24, "{counts:?}");
    }

    #[test]
    fn a_dense_pane_adds_no_range() {
        let mut stack = stack(&[1.4]);
        stack.layers.insert(0, Layer::pane(1.5, 0.0));
        assert_eq!(Streams::new(16, &stack).within(1.5).len(), Streams::new(16, &stack).within(1.4).len());
        assert_eq!(refracted_cosine(0.1, 1.5, 1.0), None);
    }
}
