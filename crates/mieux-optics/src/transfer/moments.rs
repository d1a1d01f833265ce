//! A phase function as solvers of the transfer equation see it: its Legendre moments.

use std::sync::Arc;

use super::TransferError;
use crate::phase::PhaseFunction;

/// Legendre moments of a phase function: the mean of `P_l(cos theta)` for `l = 0, 1, ...`, the first being 1 and the
/// second the asymmetry. Moments beyond the last are taken for 0. Cheap to clone.
#[derive(Debug, Clone, PartialEq)]
pub struct Moments(Arc<[f64]>);

impl Moments {
    /// From a list.
    ///
    /// # Errors
    /// [`TransferError::Moment`] unless the first is 1 (to 1e-6), every other lies in [-1, 1], and the second degree
    /// allows for the first (`chi_2 >= (3 chi_1^2 - 1) / 2`), as those of a function without negative values do.
    pub fn new(moments: impl Into<Arc<[f64]>>) -> Result<Self, TransferError> {
        let mut moments: Arc<[f64]> = moments.into();
        let refuse = |degree: usize, value: f64| Err(TransferError::Moment { degree, value });
        let first = moments.first().copied().unwrap_or(f64::NAN);
        if (first - 1.0).abs() > 1e-6 || first.is_nan() {
            return refuse(0, first);
        }
        if let Some((degree, &value)) = moments.iter().enumerate().find(|(_, chi)| chi.is_nan() || chi.abs() > first) {
            return refuse(degree, value);
        }
        if let [_, g, second, ..] = *moments
            && second < 0.5 * (3.0 * g * g - 1.0) - 1e-6
        {
            return refuse(2, second);
        }
        if first != 1.0 {
            moments = moments.iter().map(|chi| chi / first).collect();
        }
        Ok(Self(moments))
    }

    /// Of scattering into all directions alike.
    pub fn isotropic() -> Self {
        Self(Arc::new([1.0]))
    }

    /// The powers of `g`, up to the last that matters (at most `MAX_MOMENTS`).
    ///
    /// # Errors
    /// [`TransferError::Asymmetry`] unless `g` lies strictly between -1 and 1.
    pub fn henyey_greenstein(g: f64) -> Result<Self, TransferError> {
        if g.is_nan() || g.abs() >= 1.0 {
            return Err(TransferError::Asymmetry { g });
        }
        let moments = std::iter::successors(Some(1.0f64), |power| Some(power * g));
        Ok(Self(moments.take_while(|power| power.abs() > NEGLIGIBLE).take(MAX_MOMENTS).collect()))
    }

    /// The first `count` (at most `MAX_MOMENTS`) of a phase function.
    ///
    /// # Errors
    /// As [`Moments::new`]; a [`PhaseFunction`] gives none unless its table is coarse.
    pub fn of(phase: &PhaseFunction, count: usize) -> Result<Self, TransferError> {
        let last = count.clamp(1, MAX_MOMENTS) - 1;
        Self::new(phase.legendre_moments(last as u32))
    }

    /// The moment of a degree.
    pub fn get(&self, degree: usize) -> f64 {
        self.0.get(degree).copied().unwrap_or(0.0)
    }

    /// The mean scattering cosine.
    pub fn asymmetry(&self) -> f64 {
        self.get(1)
    }

    /// All that are known, from degree 0.
    pub fn as_slice(&self) -> &[f64] {
        &self.0
    }
}

/// Moments smaller than this change nothing in double precision.
const NEGLIGIBLE: f64 = 1e-18;

/// Enough for 256 streams and for the single scattering of a lobe one hundredth of a degree wide.
pub const MAX_MOMENTS: usize = 20_000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_that_are_not_of_a_phase_function() {
        assert_eq!(
            Moments::new(vec![]).unwrap_err().to_string(),
            Moments::new(vec![f64::NAN]).unwrap_err().to_string()
        );
        for (list, degree) in [
            (vec![0.9], 0),
            (vec![1.0, 1.2], 1),
            (vec![1.0, f64::NAN], 1),
            (vec![1.0, 0.9, 0.1], 2),
            (vec![1.0, 0.0, 0.0, -1.5], 3),
        ] {
            match Moments::new(list) {
                Err(TransferError::Moment { degree: found, .. }) => assert_eq!(found, degree),
                other => panic!("{other:?}"),
            }
        }
        assert!(Moments::henyey_greenstein(1.0).is_err() && Moments::henyey_greenstein(f64::NAN).is_err());
    }

    #[test]
    fn henyey_greenstein_by_both_roads() {
        let direct = Moments::henyey_greenstein(-0.4).unwrap();
        let phase = PhaseFunction::from(crate::phase::HenyeyGreenstein::new(-0.4).unwrap());
        let general = Moments::of(&phase, 20).unwrap();
        for degree in 0..20 {
            assert!((direct.get(degree) - general.get(degree)).abs() < 1e-15);
        }
        assert_eq!(Moments::isotropic().get(1), 0.0);
        assert_eq!(direct.asymmetry(), -0.4);
    }
}
