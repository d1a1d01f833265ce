//! A random angle around the full turn, as its cosine and sine.

use std::f64::consts::PI;
use std::sync::LazyLock;

/// Cosines and sines of 256 angles; what lies between is added by a short series.
pub struct Turn {
    /// At the middle of each 256th of the turn.
    table: [(f64, f64); 256],
}

impl Turn {
    /// The table, made once.
    pub fn get() -> &'static Self {
        static TABLE: LazyLock<Turn> = LazyLock::new(|| Turn {
            table: std::array::from_fn(|i| {
                let (sine, cosine) = ((i as f64 + 0.5) * (PI / 128.0)).sin_cos();
                (cosine, sine)
            }),
        });
        &TABLE
    }

    /// Cosine and sine of the angle `2 pi bits / 2^32`, to 1e-9: uniform for uniform bits.
    #[inline]
    pub fn angle(&self, bits: u32) -> (f64, f64) {
        let (cosine, sine) = self.table[(bits >> 24) as usize];
        let within = f64::from((bits & 0x00ff_ffff) as i32 - 0x0080_0000) * (2.0 * PI / 4_294_967_296.0);
        // |within| <= pi/256: the first terms left out are 1e-9 and 3e-12.
        let square = within * within;
        let c = 1.0 - 0.5 * square;
        let s = within * (1.0 - square * (1.0 / 6.0));
        (cosine * c - sine * s, sine * c + cosine * s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_library_all_around() {
        for i in 0..100_000u32 {
            let bits = i.wrapping_mul(42_949);
            let angle = 2.0 * PI * f64::from(bits) / 4_294_967_296.0;
            let (cosine, sine) = Turn::get().angle(bits);
            assert!((cosine - angle.cos()).abs() < 1e-9 && (sine - angle.sin()).abs() < 1e-9, "{bits}");
        }
    }
}
