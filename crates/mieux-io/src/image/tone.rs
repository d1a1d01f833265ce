//! From scene light to what a screen can show.

use mieux_optics::spectrum::colour::luminance;

/// A tone curve on linear sRGB, 1 being white; what comes out is linear sRGB still.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Tone {
    /// None: what is brighter than white is white.
    #[default]
    Srgb,
    /// A curve with a toe and a shoulder, channel by channel, after film (`narkowicz2015`).
    Filmic,
    /// `L / (1 + L)` on luminance (`reinhard2002`, eq 3): nothing is ever burnt out, colours keep their ratios.
    Reinhard,
}

impl Tone {
    /// All there are, with the names they are called by.
    pub const ALL: [(&'static str, Self); 3] =
        [("srgb", Self::Srgb), ("filmic", Self::Filmic), ("reinhard", Self::Reinhard)];

    /// The curve at linear sRGB `rgb`, multiplied by `exposure` first. Without curve and exposure, `rgb` itself.
    pub fn apply(self, rgb: [f64; 3], exposure: f64) -> [f64; 3] {
        let rgb = rgb.map(|v| v * exposure);
        match self {
            Self::Srgb => rgb,
            Self::Filmic => rgb.map(|v| {
                let v = v.clamp(0.0, 1e6);
                (v * (2.51 * v + 0.03) / (v * (2.43 * v + 0.59) + 0.14)).min(1.0)
            }),
            Self::Reinhard => {
                let light = luminance(rgb).max(0.0);
                rgb.map(|v| v / (1.0 + light))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_rise_from_black_to_white() {
        for (name, tone) in Tone::ALL {
            assert_eq!(tone.apply([0.0; 3], 2.0), [0.0; 3], "{name}");
            let grey: Vec<f64> = (0..200).map(|i| tone.apply([0.05 * f64::from(i); 3], 1.0)[0]).collect();
            assert!(grey.windows(2).all(|w| w[1] >= w[0]), "{name}");
            assert!(tone == Tone::Srgb || grey.iter().all(|v| (0.0..=1.0).contains(v)), "{name}");
        }
        assert_eq!(Tone::Srgb.apply([0.1, 0.2, 0.3], 1.0), [0.1, 0.2, 0.3]);
        // By hand: 0.18 (0.4518 + 0.03) / (0.18 (0.4374 + 0.59) + 0.14).
        assert!((Tone::Filmic.apply([0.18; 3], 1.0)[0] - 0.086724 / 0.324932).abs() < 1e-12);
        assert!((Tone::Reinhard.apply([0.5; 3], 2.0)[1] - 0.5).abs() < 1e-12);
    }
}
