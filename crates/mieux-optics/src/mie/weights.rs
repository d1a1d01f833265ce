//! Factors that depend on the order alone.

/// Those of one order `n`.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Weight {
    /// `n`
    pub order: f64,
    /// `n + 1`
    pub next: f64,
    /// `2 n + 1`
    pub factor: f64,
    /// `(n - 1)(n + 1) / n`, of the product with the order before in the asymmetry.
    pub neighbours: f64,
    /// `(2 n + 1) / (n (n + 1))`
    pub pair: f64,
}

/// A window of [`Weights::WINDOW`] orders that moves on demand, so that memory stays small at any order.
pub(super) struct Weights {
    first: usize,
    table: Vec<Weight>,
}

impl Weights {
    /// Most orders that can be asked for at once.
    pub const WINDOW: usize = 512;

    /// Orders from 1 on, which are those of nearly every sphere.
    pub fn new() -> Self {
        let mut weights = Self { first: 0, table: vec![Weight::default(); Self::WINDOW] };
        weights.fill(1);
        weights
    }

    fn fill(&mut self, first: usize) {
        self.first = first;
        for (i, weight) in self.table.iter_mut().enumerate() {
            let n = (first + i) as f64;
            let (next, factor) = (n + 1.0, 2.0 * n + 1.0);
            let inverse = 1.0 / (n * next);
            *weight = Weight {
                order: n,
                next,
                factor,
                neighbours: (n - 1.0) * next * next * inverse,
                pair: factor * inverse,
            };
        }
    }

    /// The weights of `count` orders from `first` on.
    pub fn run(&mut self, first: usize, count: usize) -> &[Weight] {
        if first < self.first || first + count > self.first + Self::WINDOW {
            self.fill(first);
        }
        &self.table[first - self.first..][..count]
    }
}
