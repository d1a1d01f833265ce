//! Associated Legendre functions, normalised: `sqrt((l - m)! / (l + m)!) P_l^m`, so that none is large.

use pulp::Simd;

use crate::lanes::{LaneArray, MAX_LANES, Re};

/// Which order `m` each lane works on.
pub(super) type Orders = [usize; MAX_LANES];

/// The factors of the recurrence `L_{j+1} = rise_j mu L_j - fall_j L_{j-1}`, with `l = m + j`.
pub(super) struct Recurrence<S: Simd> {
    rise: Vec<Re<S>>,
    fall: Vec<Re<S>>,
    orders: Orders,
}

impl<S: Simd> Recurrence<S> {
    /// For `count` degrees from `l = m` on.
    #[inline(always)]
    pub fn new(simd: S, orders: Orders, count: usize) -> Self {
        let factor = |value: &dyn Fn(f64, f64) -> f64, j: usize| {
            let lanes: LaneArray = std::array::from_fn(|lane| value(j as f64, orders[lane] as f64));
            Re::load(simd, &lanes)
        };
        let rise = |j: f64, m: f64| (2.0 * (m + j) + 1.0) / ((j + 1.0) * (j + 1.0 + 2.0 * m)).sqrt();
        let fall = |j: f64, m: f64| ((j * (j + 2.0 * m)) / ((j + 1.0) * (j + 1.0 + 2.0 * m))).sqrt();
        Self {
            rise: (0..count).map(|j| factor(&rise, j)).collect(),
            fall: (0..count).map(|j| factor(&fall, j)).collect(),
            orders,
        }
    }

    /// Appends the functions of `count` degrees at one cosine per lane to `out`.
    #[inline(always)]
    pub fn append(&self, simd: S, cosine: Re<S>, out: &mut Vec<Re<S>>) {
        let cosines = cosine.lanes();
        let start: LaneArray = std::array::from_fn(|lane| sectoral(self.orders[lane], cosines[lane]));
        let (mut before, mut here) = (Re::splat(simd, 0.0), Re::load(simd, &start));
        for (rise, fall) in self.rise.iter().zip(&self.fall) {
            out.push(here);
            (before, here) = (here, fall.neg_mul_add(before, *rise * cosine * here));
        }
    }
}

/// The function of degree `m` and order `m`.
fn sectoral(m: usize, cosine: f64) -> f64 {
    if m == 0 {
        return 1.0;
    }
    let norm: f64 = (1..=m).map(|i| (2 * i - 1) as f64 / (2 * i) as f64).product();
    (norm * ((1.0 - cosine) * (1.0 + cosine)).powi(m as i32)).sqrt()
}
