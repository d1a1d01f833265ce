//! Colours by how different they look: CIE L*a*b* and CIEDE2000.

/// Below this relative stimulus L*a*b* is linear.
const DELTA: f64 = 6.0 / 29.0;

/// A colour in CIE L*a*b* (`cie2018`), relative to some white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lab {
    /// Lightness L*: 0 black, 100 the white.
    pub l: f64,
    /// Green (below 0) to red.
    pub a: f64,
    /// Blue (below 0) to yellow.
    pub b: f64,
}

impl Lab {
    /// From XYZ, relative to that of a white, each above 0.
    pub fn from_xyz(xyz: [f64; 3], white: [f64; 3]) -> Self {
        let curve = |t: f64| if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 };
        let [x, y, z] = std::array::from_fn(|i| curve(xyz[i] / white[i]));
        Self { l: 116.0 * y - 16.0, a: 500.0 * (x - y), b: 200.0 * (y - z) }
    }

    /// The inverse of [`Lab::from_xyz`].
    pub fn to_xyz(self, white: [f64; 3]) -> [f64; 3] {
        let y = (self.l + 16.0) / 116.0;
        let curve = |f: f64| if f > DELTA { f * f * f } else { 3.0 * DELTA * DELTA * (f - 4.0 / 29.0) };
        let relative = [curve(y + self.a / 500.0), curve(y), curve(y - self.b / 200.0)];
        std::array::from_fn(|i| relative[i] * white[i])
    }

    /// Chroma: the distance from grey.
    pub fn chroma(&self) -> f64 {
        self.a.hypot(self.b)
    }

    /// CIEDE2000 from another colour (`sharma2005`, all parametric factors 1): about 1 is seen side by side, 2 to 3 by most.
    pub fn ciede2000(&self, other: &Self) -> f64 {
        let [l, c, h] = self.ciede2000_components(other);
        (l * l + c * c + h * h).sqrt()
    }

    /// Three numbers whose squares add up to that of [`Lab::ciede2000`]: of lightness, of chroma with its share of the rotated
    /// hue, and of what remains of hue. For least squares.
    pub fn ciede2000_components(&self, other: &Self) -> [f64; 3] {
        const BIG: f64 = 6_103_515_625.0; // 25^7
        let seventh = |c: f64| (c.powi(7) / (c.powi(7) + BIG)).sqrt();
        let stretch = 1.5 - 0.5 * seventh(0.5 * (self.chroma() + other.chroma()));
        let (a1, a2) = (self.a * stretch, other.a * stretch);
        let (c1, c2) = (a1.hypot(self.b), a2.hypot(other.b));
        let hue = |a: f64, b: f64| if a == 0.0 && b == 0.0 { 0.0 } else { b.atan2(a).to_degrees().rem_euclid(360.0) };
        let (h1, h2) = (hue(a1, self.b), hue(a2, other.b));
        let grey = c1 * c2 == 0.0;
        let turn = match h2 - h1 {
            _ if grey => 0.0,
            turn if turn > 180.0 => turn - 360.0,
            turn if turn < -180.0 => turn + 360.0,
            turn => turn,
        };
        let mean_hue = match h1 + h2 {
            sum if grey => sum,
            sum if (h1 - h2).abs() <= 180.0 => 0.5 * sum,
            sum if sum < 360.0 => 0.5 * (sum + 360.0),
            sum => 0.5 * (sum - 360.0),
        };
        let (mean_l, mean_c) = (0.5 * (self.l + other.l), 0.5 * (c1 + c2));
        let cosine = |factor: f64, shift: f64| (factor * mean_hue + shift).to_radians().cos();
        let t = 1.0 - 0.17 * cosine(1.0, -30.0) + 0.24 * cosine(2.0, 0.0) + 0.32 * cosine(3.0, 6.0)
            - 0.20 * cosine(4.0, -63.0);
        let from_50 = (mean_l - 50.0).powi(2);
        let s_l = 1.0 + 0.015 * from_50 / (20.0 + from_50).sqrt();
        let (s_c, s_h) = (1.0 + 0.045 * mean_c, 1.0 + 0.015 * mean_c * t);
        let blue = 30.0 * (-((mean_hue - 275.0) / 25.0).powi(2)).exp();
        let rotation = -(2.0 * blue).to_radians().sin() * 2.0 * seventh(mean_c);
        let chroma = (c2 - c1) / s_c;
        let hue = 2.0 * (c1 * c2).sqrt() * (0.5 * turn).to_radians().sin() / s_h;
        // x^2 + R x y + y^2 as two squares; |R| is at most 2.
        let left = (1.0 - 0.25 * rotation * rotation).max(0.0).sqrt();
        [(other.l - self.l) / s_l, chroma + 0.5 * rotation * hue, left * hue]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pairs of `sharma2005`, table 1, which are chosen to trip every branch.
    const PAIRS: [([f64; 3], [f64; 3], f64); 34] = [
        ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
        ([50.0, 3.1571, -77.2803], [50.0, 0.0, -82.7485], 2.8615),
        ([50.0, 2.8361, -74.0200], [50.0, 0.0, -82.7485], 3.4412),
        ([50.0, -1.3802, -84.2814], [50.0, 0.0, -82.7485], 1.0000),
        ([50.0, -1.1848, -84.8006], [50.0, 0.0, -82.7485], 1.0000),
        ([50.0, -0.9009, -85.5211], [50.0, 0.0, -82.7485], 1.0000),
        ([50.0, 0.0, 0.0], [50.0, -1.0, 2.0], 2.3669),
        ([50.0, -1.0, 2.0], [50.0, 0.0, 0.0], 2.3669),
        ([50.0, 2.4900, -0.0010], [50.0, -2.4900, 0.0009], 7.1792),
        ([50.0, 2.4900, -0.0010], [50.0, -2.4900, 0.0010], 7.1792),
        ([50.0, 2.4900, -0.0010], [50.0, -2.4900, 0.0011], 7.2195),
        ([50.0, 2.4900, -0.0010], [50.0, -2.4900, 0.0012], 7.2195),
        ([50.0, -0.0010, 2.4900], [50.0, 0.0009, -2.4900], 4.8045),
        ([50.0, -0.0010, 2.4900], [50.0, 0.0010, -2.4900], 4.8045),
        ([50.0, -0.0010, 2.4900], [50.0, 0.0011, -2.4900], 4.7461),
        ([50.0, 2.5, 0.0], [50.0, 0.0, -2.5], 4.3065),
        ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
        ([50.0, 2.5, 0.0], [61.0, -5.0, 29.0], 22.8977),
        ([50.0, 2.5, 0.0], [56.0, -27.0, -3.0], 31.9030),
        ([50.0, 2.5, 0.0], [58.0, 24.0, 15.0], 19.4535),
        ([50.0, 2.5, 0.0], [50.0, 3.1736, 0.5854], 1.0000),
        ([50.0, 2.5, 0.0], [50.0, 3.2972, 0.0], 1.0000),
        ([50.0, 2.5, 0.0], [50.0, 1.8634, 0.5757], 1.0000),
        ([50.0, 2.5, 0.0], [50.0, 3.2592, 0.3350], 1.0000),
        ([60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644),
        ([63.0109, -31.0961, -5.8663], [62.8187, -29.7946, -4.0864], 1.2630),
        ([61.2901, 3.7196, -5.3901], [61.4292, 2.2480, -4.9620], 1.8731),
        ([35.0831, -44.1164, 3.7933], [35.0232, -40.0716, 1.5901], 1.8645),
        ([22.7233, 20.0904, -46.6940], [23.0331, 14.9730, -42.5619], 2.0373),
        ([36.4612, 47.8580, 18.3852], [36.2715, 50.5065, 21.2231], 1.4146),
        ([90.8027, -2.0831, 1.4410], [91.1528, -1.6435, 0.0447], 1.4441),
        ([90.9257, -0.5406, -0.9208], [88.6381, -0.8985, -0.7239], 1.5381),
        ([6.7747, -0.2908, -2.4247], [5.8714, -0.0985, -2.2286], 0.6377),
        ([2.0776, 0.0795, -1.1350], [0.9033, -0.0636, -0.5514], 0.9082),
    ];

    fn lab([l, a, b]: [f64; 3]) -> Lab {
        Lab { l, a, b }
    }

    #[test]
    fn the_published_pairs_differ_as_published() {
        for (one, other, expected) in PAIRS {
            for (x, y) in [(one, other), (other, one)] {
                let found = lab(x).ciede2000(&lab(y));
                assert!((found - expected).abs() < 1e-4, "{one:?} {other:?}: {found} for {expected}");
            }
        }
    }

    #[test]
    fn there_and_back_and_white_is_white() {
        let white = [0.95047, 1.0, 1.08883];
        let paper = Lab::from_xyz(white, white);
        assert!((paper.l - 100.0).abs() < 1e-12 && paper.chroma() < 1e-12);
        for colour in [[0.0, 0.0, 0.0], [5.0, 1.0, -2.0], [50.0, 40.0, -60.0], [90.0, -3.0, 80.0]] {
            let back = Lab::from_xyz(lab(colour).to_xyz(white), white);
            assert!(back.ciede2000(&lab(colour)) < 1e-10, "{colour:?} {back:?}");
        }
        // A grey that reflects 18.42 % is the middle.
        assert!((Lab::from_xyz(white.map(|w| 0.184_187 * w), white).l - 50.0).abs() < 1e-3);
    }
}
