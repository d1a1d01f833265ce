//! Spheres much larger than the wavelength: light that passes by, diffracted, and light that meets them, followed by rays.
//!
//! Half of what a large sphere takes from a wave it diffracts, as the disc of its shadow does; the other half is reflected, refracted
//! and absorbed (`vandehulst1957`, chapter 12). Interference between rays, which averages out over sizes, is left out.

use std::f64::consts::PI;

/// Pairs of neighbouring rays between the axis and the rim, and as many again where reflection is total.
const RAYS: usize = 4000;

/// Passages through a sphere after which a ray is given up.
const PASSAGES: u32 = 30;

/// Share of its light below which a ray is given up.
const FAINT: f64 = 1e-7;

/// Shares of what a sphere of a relative index is met by that leave it between consecutive angles (rad, from 0 to pi), and
/// their sum, which is 1 without absorption.
///
/// `attenuation` is the absorption along a diameter, as exponent of the intensity.
pub(super) fn followed(index: f64, attenuation: f64, angles: &[f64]) -> (Vec<f64>, f64) {
    let mut shares = vec![0.0; angles.len() - 1];
    let critical = if index < 1.0 { index.asin() } else { 0.5 * PI };
    let mut at = 0.0;
    for k in 1..=RAYS {
        // Even steps of the smaller of the two angles with the normal, as neither can then jump.
        let even = 0.5 * PI * k as f64 / RAYS as f64;
        let next = if index < 1.0 { (index * even.sin()).min(1.0).asin() } else { even };
        tube(index, attenuation, [at, next], angles, &mut shares);
        at = next;
    }
    if index < 1.0 {
        for k in 0..RAYS {
            let incidence = |k: usize| critical + (0.5 * PI - critical) * k as f64 / RAYS as f64;
            let [from, to] = [incidence(k), incidence(k + 1)];
            spread(PI - 2.0 * from, PI - 2.0 * to, met(from, to), angles, &mut shares);
        }
    }
    let total = shares.iter().sum();
    (shares, total)
}

/// Share of the light on a sphere that meets it between two angles with the normal.
fn met(from: f64, to: f64) -> f64 {
    (to - from).sin() * (to + from).sin()
}

/// What leaves of the light that enters between two angles with the normal, both short of total reflection.
fn tube(index: f64, attenuation: f64, incidence: [f64; 2], angles: &[f64], shares: &mut [f64]) {
    let light = met(incidence[0], incidence[1]);
    let inside = incidence.map(|i| (i.sin() / index).min(1.0).asin());
    let [i, r] = [0.5 * (incidence[0] + incidence[1]), 0.5 * (inside[0] + inside[1])];
    let (ci, cr) = (i.cos(), r.cos());
    let reflected = [((ci - index * cr) / (ci + index * cr)).powi(2), ((index * ci - cr) / (index * ci + cr)).powi(2)];
    let passed = (-attenuation * cr).exp();
    let deviation = |p: u32, k: usize| 2.0 * (incidence[k] - inside[k]) + f64::from(p - 1) * (PI - 2.0 * inside[k]);
    spread(
        PI - 2.0 * incidence[0],
        PI - 2.0 * incidence[1],
        0.5 * light * (reflected[0] + reflected[1]),
        angles,
        shares,
    );
    let mut carried = reflected.map(|share| 0.5 * light * (1.0 - share).powi(2) * passed);
    for p in 1..=PASSAGES {
        let leaving = carried[0] + carried[1];
        if leaving < FAINT * light {
            break;
        }
        spread(deviation(p, 0), deviation(p, 1), leaving, angles, shares);
        (0..2).for_each(|k| carried[k] *= reflected[k] * passed);
    }
}

/// Spreads light evenly over the deviations between two, folded into scattering angles.
fn spread(from: f64, to: f64, light: f64, angles: &[f64], shares: &mut [f64]) {
    let (low, high) = (from.min(to), from.max(to));
    let (first, last) = ((low / PI).floor() as i64, (high / PI).floor() as i64);
    for turn in first..=last {
        let base = turn as f64 * PI;
        let (a, b) = ((low - base).clamp(0.0, PI), (high - base).clamp(0.0, PI));
        let part = if high > low { light * (b - a) / (high - low) } else { light };
        let (a, b) = if turn.rem_euclid(2) == 0 { (a, b) } else { (PI - b, PI - a) };
        let mut bin = angles.partition_point(|angle| *angle <= a).clamp(1, shares.len()) - 1;
        loop {
            let within = (b.min(angles[bin + 1]) - a.max(angles[bin])).max(0.0);
            shares[bin] += if b > a { part * within / (b - a) } else { part };
            if bin + 1 == shares.len() || angles[bin + 1] >= b {
                break;
            }
            bin += 1;
        }
    }
}

/// Shares of what a disc of a size parameter diffracts between consecutive angles (rad, from 0 to pi), added to `shares` times
/// `light`: the rings of Airy, that within `z = 2 x sin(theta/2)` being `1 - J0(z)^2 - J1(z)^2`.
pub(super) fn diffracted(size: f64, light: f64, angles: &[f64], shares: &mut [f64]) {
    let without = |angle: f64| {
        let z = 2.0 * size * (0.5 * angle).sin();
        libm::j0(z).powi(2) + libm::j1(z).powi(2)
    };
    let end = without(PI);
    let mut before = 1.0;
    for (share, angle) in shares.iter_mut().zip(&angles[1..]) {
        let after = without(*angle);
        *share += light * (before - after) / (1.0 - end);
        before = after;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn angles() -> Vec<f64> {
        (0..=1800).map(|k| PI * f64::from(k) / 1800.0).collect()
    }

    fn asymmetry(shares: &[f64], angles: &[f64]) -> f64 {
        let mean = |k: usize| 0.5 * (angles[k].cos() + angles[k + 1].cos());
        shares.iter().enumerate().map(|(k, share)| share * mean(k)).sum::<f64>() / shares.iter().sum::<f64>()
    }

    /// No light is lost, and what a sphere of large index reflects goes everywhere alike.
    #[test]
    fn light_is_kept() {
        for index in [0.5, 0.763, 0.98, 1.023, 1.33, 2.0] {
            let (shares, total) = followed(index, 0.0, &angles());
            assert!((total - 1.0).abs() < 1e-4, "{index}: {total}");
            assert!(shares.iter().all(|share| *share >= 0.0));
        }
        let angles = angles();
        let (shares, total) = followed(1.33, 1e3, &angles);
        // Unpolarised light on a flat face of water, from all sides: a mean reflectance of 6.6 %, and none gets through.
        assert!((total - 0.066).abs() < 1e-3, "{total}");
        assert!(asymmetry(&shares, &angles) > 0.3);
        let mut shares = vec![0.0; angles.len() - 1];
        diffracted(300.0, 2.0, &angles, &mut shares);
        assert!((shares.iter().sum::<f64>() - 2.0).abs() < 1e-12);
        assert!(asymmetry(&shares, &angles) > 0.99);
    }

    /// The rays of a water drop go round its rainbows, at 137.5 and 129.9 degrees, and none to between.
    #[test]
    fn rainbows_are_where_they_are() {
        let angles = angles();
        let (shares, _) = followed(1.33, 0.0, &angles);
        let density = |degrees: f64| {
            let bin = (degrees * 10.0) as usize;
            (bin - 3..bin + 3).map(|k| shares[k]).sum::<f64>()
        };
        assert!(density(137.8) > 5.0 * density(134.0) && density(134.0) < 0.2 * density(137.8));
        assert!(density(129.4) > density(134.0));
    }
}
