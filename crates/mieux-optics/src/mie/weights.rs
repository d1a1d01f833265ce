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

/// Those of the orders that most spheres need.
static FIRST: [Weight; Weights::WINDOW] = {
    let mut first = [Weight::new(1); Weights::WINDOW];
    let mut i = 0;
    while i < first.len() {
        first[i] = Weight::new(i + 1);
        i += 1;
    }
    first
};

/// Beyond the first, a window of orders that grows on demand up to [`Weights::WINDOW`] and then moves, so that memory stays
/// small at any order.
pub(super) struct Weights {
    first: usize,
    table: Vec<Weight>,
}

impl Weights {
    /// Most orders that can be asked for at once.
    pub const WINDOW: usize = 512;

    pub fn new() -> Self {
        Self { first: 1, table: Vec::new() }
    }

    /// The weights of `count` orders from `first` on.
    pub fn run(&mut self, first: usize, count: usize) -> &[Weight] {
        if let Some(weights) = FIRST.get(first - 1..first - 1 + count) {
            return weights;
        }
        if first < self.first || first + count > self.first + Self::WINDOW {
            self.first = first;
            self.table.clear();
        }
        let known = self.first + self.table.len();
        self.table.extend((known..first + count).map(Weight::new));
        &self.table[first - self.first..][..count]
    }
}

impl Weight {
    const fn new(order: usize) -> Self {
        let n = order as f64;
        let (next, factor) = (n + 1.0, 2.0 * n + 1.0);
        let inverse = 1.0 / (n * next);
        Self { order: n, next, factor, neighbours: (n - 1.0) * next * next * inverse, pair: factor * inverse }
    }
}
