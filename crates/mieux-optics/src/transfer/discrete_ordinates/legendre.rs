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
        let orders_abreast: LaneArray = orders.map(|m| m as f64);
        let twice = Re::load(simd, &orders_abreast) + Re::load(simd, &orders_abreast);
        let one = Re::splat(simd, 1.0);
        let (mut rise, mut fall) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut before = Re::splat(simd, 0.0);
        for j in 0..count {
            let next = Re::splat(simd, (j + 1) as f64);
            let inverse = one / (next * (next + twice)).sqrt();
            rise.push((twice + next + next - one) * inverse);
            fall.push(before * inverse);
            before = (next * (next + twice)).sqrt();
        }
        Self { rise, fall, orders }
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
