//! Models as functions of unbounded numbers, so that a search without bounds stays within theirs.

use crate::phase::{DoubleHenyeyGreenstein, Draine, HenyeyGreenstein, HenyeyGreensteinDraine, PhaseError};

/// Lobes sharper than this are not sought; a mean cosine beyond it may still be kept.
const SHARPEST: f64 = 1.0 - 1e-7;

/// From any number to (0, 1).
fn share(u: f64) -> f64 {
    1.0 / (1.0 + (-u).exp())
}

/// From any number to (-1, 1).
fn asymmetry(u: f64) -> f64 {
    u.tanh() * SHARPEST
}

/// From any number to an alpha between 1e-3 and 1e3, smoothly.
fn alpha(u: f64) -> f64 {
    (1e3f64.ln() * (u / 4.0).tanh()).exp()
}

pub(super) fn henyey_greenstein(u: &[f64; 1]) -> Result<HenyeyGreenstein, PhaseError> {
    HenyeyGreenstein::new(asymmetry(u[0]))
}

/// Share of the first lobe and both asymmetries.
pub(super) fn double(u: &[f64; 3]) -> Result<DoubleHenyeyGreenstein, PhaseError> {
    DoubleHenyeyGreenstein::new(share(u[0]), asymmetry(u[1]), asymmetry(u[2]))
}

/// One lobe above the mean cosine `g` and one below it; their shares follow.
pub(super) fn double_kept(g: f64, u: &[f64; 2]) -> Result<DoubleHenyeyGreenstein, PhaseError> {
    let (up, down) = ((SHARPEST - g).max(0.0) * share(u[0]), (SHARPEST + g).max(0.0) * share(u[1]));
    let weight = if up + down > 0.0 { down / (up + down) } else { 1.0 };
    DoubleHenyeyGreenstein::new(weight, g + up, g - down)
}

/// Share of Draine's lobe, the parameters of the lobes, alpha.
pub(super) fn draine(u: &[f64; 4]) -> Result<HenyeyGreensteinDraine, PhaseError> {
    HenyeyGreensteinDraine::new(share(u[0]), asymmetry(u[1]), asymmetry(u[2]), alpha(u[3]))
}

/// The Henyey-Greenstein lobe on one side of the mean cosine `g`, Draine's on the other; their shares follow.
pub(super) fn draine_kept(g: f64, hg_above: bool, u: &[f64; 3]) -> Result<HenyeyGreensteinDraine, PhaseError> {
    let alpha = alpha(u[2]);
    // Where the Draine lobe can go, between the mean cosine and the sharpest lobe.
    let end = Draine::new(if hg_above { -SHARPEST } else { SHARPEST }, alpha)?.asymmetry();
    let hg_end = if hg_above { SHARPEST } else { -SHARPEST };
    let to_hg = share(u[0]) * (hg_end - g);
    let to_draine = share(u[1]) * (end - g);
    let g_d = draine_parameter(g + to_draine, alpha)?;
    let draine_weight = if to_hg - to_draine == 0.0 { 0.0 } else { to_hg / (to_hg - to_draine) };
    HenyeyGreensteinDraine::new(draine_weight, g + to_hg, g_d, alpha)
}

/// The `g` of the Draine lobe of the given alpha and mean cosine, by halving: the mean cosine rises with it.
fn draine_parameter(mean: f64, alpha: f64) -> Result<f64, PhaseError> {
    let (mut low, mut high) = (-1.0, 1.0);
    for _ in 0..54 {
        let middle: f64 = 0.5 * (low + high);
        if Draine::new(middle, alpha)?.asymmetry() < mean {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(0.5 * (low + high))
}

/// All pairs of two sets of starts.
pub(super) fn product<const M: usize, const N: usize>(a: [f64; M], b: [f64; N]) -> Vec<[f64; 2]> {
    a.iter().flat_map(|&x| b.map(|y| [x, y])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_numbers_give_a_valid_model_that_keeps_the_mean_cosine() {
        for g in [-0.999, -0.3, 0.0, 0.87, 0.9999] {
            for &[a, b] in &product([-40.0, -1.0, 0.0, 2.0, 800.0], [-800.0, -3.0, 0.0, 1.0, 40.0]) {
                assert!((double_kept(g, &[a, b]).unwrap().asymmetry() - g).abs() < 1e-14);
                for c in [-50.0, 0.0, 50.0] {
                    for above in [true, false] {
                        let kept = draine_kept(g, above, &[a, b, c]).unwrap().asymmetry();
                        assert!((kept - g).abs() < 1e-13, "{g} {above} {a} {b} {c}: {kept}");
                    }
                    assert!(draine(&[a, b, c, a]).is_ok() && double(&[a, b, c]).is_ok());
                }
            }
        }
    }

    #[test]
    fn draines_mean_cosine_rises_with_its_parameter() {
        for alpha in [0.0, 1e-3, 1.0, 10.0, 1e3] {
            let mut before = -1.0;
            for i in -9999..10_000 {
                let now = Draine::new(f64::from(i) / 1e4, alpha).unwrap().asymmetry();
                assert!(now > before);
                before = now;
            }
        }
    }
}
