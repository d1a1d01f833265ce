//! Legendre moments of the phase functions of media, without a table over angle between.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::{Medium, MediumError, Member, Members};
use crate::integrate::gauss_legendre;
use crate::medium::scatterer::node_count;
use crate::mie::Directions;

impl Medium {
    /// Legendre moments, from degree 0 to `max_degree`, of the phase function at a vacuum wavelength (m): 1, the mean
    /// cosine, and so on; 1 and zeros where nothing scatters.
    ///
    /// Henyey and Greenstein's where [`Self::phase_at`] lets them stand in.
    ///
    /// The phase function of every sphere is a polynomial in the scattering cosine, and a Gauss rule with enough nodes for
    /// the largest gives the moments of all of them without error but rounding: what is left is that of the integral over
    /// radius, converged to `tolerance` as [`Self::optics_at`] does it. (A structure factor, where packing is corrected for, is no
    /// polynomial, and gets nodes enough for 1e-6.)
    ///
    /// # Errors
    /// As for [`Self::optics_at`].
    pub fn legendre_moments_at(
        &self,
        wavelength: f64,
        max_degree: usize,
        tolerance: f64,
    ) -> Result<Vec<f64>, MediumError> {
        let members = match self.members(wavelength, tolerance)? {
            Members::All(members) => members,
            Members::TooLarge(stand_in) => {
                return Ok((0..=max_degree).map(|degree| stand_in.asymmetry().powi(degree as i32)).collect());
            }
        };
        let mut moments = vec![0.0; max_degree + 1];
        if members.is_empty() {
            moments[0] = 1.0;
            return Ok(moments);
        }
        let nodes = |member: &Member| {
            let terms = member.ball.coefficients().terms().len();
            if member.fluid.is_some() { node_count(terms) } else { terms + 1 }
        };
        let count = members.par_iter().map(nodes).max().unwrap_or(1);
        let nodes = gauss_legendre(count + max_degree / 2);
        let directions = Directions::new(nodes.iter().map(|(mu, _)| *mu));
        let values = self.sum(&members, &directions, nodes.len())?;
        for ((mu, weight), value) in nodes.iter().zip(&values) {
            let share = TAU * weight * value;
            let (mut before, mut here) = (0.0, 1.0);
            for (degree, moment) in moments.iter_mut().enumerate() {
                *moment += share * here;
                let l = degree as f64;
                (before, here) = (here, ((2.0 * l + 1.0) * mu * here - l * before) / (l + 1.0));
            }
        }
        let whole = moments[0];
        Ok(moments.into_iter().map(|moment| moment / whole).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{AIR, GREEN, droplet, milk};
    use crate::Complex64;
    use crate::medium::Medium;
    use crate::mie::{PlaneWave, Sphere};
    use crate::phase::PhaseFunction;
    use crate::substance::{Conditions, Substance};

    /// One size is one sphere, whose own expansion is another way.
    #[test]
    fn one_size_has_the_moments_of_its_sphere() {
        let medium = droplet(10e-6);
        let found = medium.legendre_moments_at(GREEN, 400, 1e-4).unwrap();
        let wave = PlaneWave::new(GREEN, Complex64::ONE).unwrap();
        let water = Substance::named("water", Conditions::default()).unwrap().index(GREEN).unwrap();
        let sphere = Sphere::new(wave, 5e-6, water).unwrap().coefficients().legendre_moments().unwrap();
        assert!(sphere.len() < 401);
        for (degree, moment) in found.iter().enumerate() {
            let exact = sphere.get(degree).copied().unwrap_or(0.0);
            assert!((moment - exact).abs() < 1e-11, "{degree}: {moment} {exact}");
        }
    }

    /// The table over angle, and the coefficients, go by other ways.
    #[test]
    fn milk_has_the_moments_of_its_table() {
        let medium = milk(3.5, 3.4);
        let found = medium.legendre_moments_at(GREEN, 64, 1e-5).unwrap();
        let lack = 1.0 - medium.optics_at(GREEN, 1e-5).unwrap().asymmetry;
        assert!(((1.0 - found[1]) / lack - 1.0).abs() < 1e-4, "{} {lack}", 1.0 - found[1]);
        let PhaseFunction::Tabulated(table) = medium.phase_at(GREEN, 1e-4).unwrap() else { panic!() };
        for (degree, (moment, of_table)) in found.iter().zip(table.legendre_moments(64)).enumerate() {
            assert!((moment - of_table).abs() < 2e-4, "{degree}: {moment} {of_table}");
        }
    }

    #[test]
    fn where_nothing_scatters_it_would_do_so_evenly() {
        let clear = Medium::new(AIR, vec![]).unwrap();
        assert_eq!(clear.legendre_moments_at(GREEN, 2, 1e-4).unwrap(), [1.0, 0.0, 0.0]);
        assert!(clear.legendre_moments_at(GREEN, 2, 0.0).is_err());
    }
}
