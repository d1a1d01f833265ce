//! A film of known coefficients.

use super::{KubelkaMunkError, natural, share};

/// A film without surface: what two diffuse fluxes make of it (`kubelka1948`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Film {
    k: f64,
    s: f64,
    thickness: f64,
}

impl Film {
    /// Absorption and scattering coefficients of diffuse flux (1/m) and thickness (m), each finite and from 0 up.
    ///
    /// # Errors
    /// [`KubelkaMunkError::Negative`].
    pub fn new(k: f64, s: f64, thickness: f64) -> Result<Self, KubelkaMunkError> {
        Ok(Self {
            k: natural("absorption coefficient K", k)?,
            s: natural("scattering coefficient S", s)?,
            thickness: natural("thickness", thickness)?,
        })
    }

    /// From the coefficients of single rays (1/m) and the mean cosine of scattering, for diffuse light: `K = 2 sigma_a`,
    /// `S = 3/4 sigma_s (1 - g)` (`mudgett1971`), which have the decay `sqrt(3 sigma_a sigma_s')` of diffusion, and its
    /// reflectance, as absorption goes to 0. The diffuse reflectance of thick matter of index 1 with isotropic scattering
    /// then is 5 % too small at albedo 0.5, and 0.2 % at 0.99.
    ///
    /// # Errors
    /// [`KubelkaMunkError::Negative`], also for `g` outside [-1, 1] (as the factor `1 - g`).
    pub fn of_medium(sigma_a: f64, sigma_s: f64, g: f64, thickness: f64) -> Result<Self, KubelkaMunkError> {
        let backward = if g >= -1.0 { natural("factor 1 - g", 1.0 - g)? } else { natural("factor 1 - g", f64::NAN)? };
        let (sigma_a, sigma_s) = (natural("sigma_a", sigma_a)?, natural("sigma_s", sigma_s)?);
        Self::new(2.0 * sigma_a, 0.75 * sigma_s * backward, thickness)
    }

    /// The pair that follows when fluxes are defined by light that goes straight up and down: `K = sigma_a` and
    /// `S = sigma_s / 2` for isotropic scattering, here with the share `(1 - g) / 2` that turns round.
    ///
    /// # Errors
    /// As [`Film::of_medium`].
    pub fn along_the_normal(sigma_a: f64, sigma_s: f64, g: f64, thickness: f64) -> Result<Self, KubelkaMunkError> {
        let film = Self::of_medium(sigma_a, sigma_s, g, thickness)?;
        Self::new(0.5 * film.k, film.s * (2.0 / 3.0), thickness)
    }

    /// Absorption coefficient of diffuse flux, 1/m.
    pub fn k(&self) -> f64 {
        self.k
    }

    /// Scattering coefficient of diffuse flux, 1/m.
    pub fn s(&self) -> f64 {
        self.s
    }

    /// Thickness, m.
    pub fn thickness(&self) -> f64 {
        self.thickness
    }

    /// The same of another thickness (m).
    ///
    /// # Errors
    /// [`KubelkaMunkError::Negative`].
    pub fn with_thickness(self, thickness: f64) -> Result<Self, KubelkaMunkError> {
        Self::new(self.k, self.s, thickness)
    }

    /// How fast light fades deep inside, 1/m: `sqrt(K (K + 2 S))`.
    pub fn decay(&self) -> f64 {
        self.k.sqrt() * (self.k + 2.0 * self.s).sqrt()
    }

    /// Reflectance, transmittance and absorptance, each with its own digits: none is the others' difference.
    ///
    /// All hyperbolic functions are divided by the growing exponential, and by the decay where that is 0, so nothing
    /// overflows and nothing has a limit to be taken.
    pub(super) fn shares(&self) -> [f64; 3] {
        let depth = self.decay() * self.thickness;
        // sinh and cosh over exp(depth), the former also over the decay.
        let sinh = if depth > 1.0 {
            -(-2.0 * depth).exp_m1() / (2.0 * self.decay())
        } else if depth > 0.0 {
            self.thickness * -(-2.0 * depth).exp_m1() / (2.0 * depth)
        } else {
            self.thickness
        };
        let cosh = 0.5 * (1.0 + (-2.0 * depth).exp());
        let below = (self.k + self.s) * sinh + cosh;
        // What is missing of 1, from cosh - 1 = (1 - exp(-depth))^2 / 2 of the divided functions.
        let faded = (-depth).exp_m1();
        [self.s * sinh / below, (-depth).exp() / below, (self.k * sinh + 0.5 * faded * faded) / below]
    }

    /// Share of diffuse light sent back, over nothing.
    pub fn reflectance(&self) -> f64 {
        self.shares()[0]
    }

    /// Share of diffuse light that passes, over nothing.
    pub fn transmittance(&self) -> f64 {
        self.shares()[1]
    }

    /// Share of diffuse light that stays, over nothing.
    pub fn absorptance(&self) -> f64 {
        self.shares()[2]
    }

    /// Share sent back over a backing in optical contact that reflects this share into all directions.
    ///
    /// # Errors
    /// [`KubelkaMunkError::Share`].
    pub fn reflectance_over(&self, backing: f64) -> Result<f64, KubelkaMunkError> {
        let backing = share("reflectance of the backing", backing)?;
        let [reflected, passed, kept] = self.shares();
        let lost = (1.0 - backing) + backing * (passed + kept);
        // Nothing is lost only where nothing passes either.
        Ok(if passed > 0.0 { reflected + passed * passed * backing / lost } else { reflected })
    }

    /// Share sent back however thick the film is; 0 where nothing scatters.
    pub fn reflectance_infinite(&self) -> f64 {
        if self.s > 0.0 { self.s / (self.k + self.s + self.decay()) } else { 0.0 }
    }

    /// `K/S` of opaque matter that sends back this share, strictly between 0 and 1: `(1 - R)^2 / (2 R)`.
    ///
    /// # Errors
    /// [`KubelkaMunkError::Reflectance`].
    pub fn ratio(reflectance_infinite: f64) -> Result<f64, KubelkaMunkError> {
        let r = super::measured("reflectance", reflectance_infinite)?;
        Ok((1.0 - r) * (1.0 - r) / (2.0 * r))
    }
}

/// K and S (any unit, that of the parts) of a mixture: what each part does, by its share of the volume. The shares are taken
/// relative to their sum.
///
/// # Errors
/// [`KubelkaMunkError::Negative`], [`KubelkaMunkError::TooFew`] when no amount is above 0.
pub fn mix(parts: impl IntoIterator<Item = (f64, f64, f64)>) -> Result<(f64, f64), KubelkaMunkError> {
    let (mut total, mut k_sum, mut s_sum) = (0.0, 0.0, 0.0);
    for (amount, k, s) in parts {
        let amount = natural("amount", amount)?;
        total += amount;
        k_sum += amount * natural("absorption coefficient K", k)?;
        s_sum += amount * natural("scattering coefficient S", s)?;
    }
    if total > 0.0 {
        Ok((k_sum / total, s_sum / total))
    } else {
        Err(KubelkaMunkError::TooFew { found: 0, unknowns: 1 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn awkward_films_keep_their_energy() {
        for k in [0.0, 1e-12, 1e-3, 1.0, 1e5, 1e200] {
            for s in [0.0, 1e-12, 1.0, 1e5, 1e200] {
                for thickness in [0.0, 1e-200, 1e-8, 1.0, 1e8, 1e100] {
                    let film = Film::new(k, s, thickness).unwrap();
                    let shares = film.shares();
                    assert!(shares.iter().all(|v| (0.0..=1.0 + 1e-12).contains(v)), "{film:?}: {shares:?}");
                    assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{film:?}: {shares:?}");
                    for backing in [0.0, 0.5, 1.0] {
                        let r = film.reflectance_over(backing).unwrap();
                        assert!((0.0..=1.0 + 1e-12).contains(&r), "{film:?} over {backing}: {r}");
                    }
                }
            }
        }
    }

    #[test]
    fn limits_have_their_closed_forms() {
        // Without absorption S d / (1 + S d); over white nothing is lost.
        let clear = Film::new(0.0, 2e4, 1e-3).unwrap();
        assert!((clear.reflectance() - 20.0 / 21.0).abs() < 1e-14 && clear.absorptance() == 0.0);
        assert!((clear.reflectance_over(1.0).unwrap() - 1.0).abs() < 1e-14);
        assert_eq!(clear.reflectance_infinite(), 1.0);
        // Without scattering, Beer and Lambert, twice where there is a backing.
        let dark = Film::new(300.0, 0.0, 1e-3).unwrap();
        assert!((dark.transmittance() - (-0.3f64).exp()).abs() < 1e-15);
        assert!((dark.reflectance_over(0.8).unwrap() - 0.8 * (-0.6f64).exp()).abs() < 1e-15);
        assert_eq!(dark.reflectance_infinite(), 0.0);
        // Nothing at all.
        assert_eq!(Film::new(1.0, 1.0, 0.0).unwrap().reflectance_over(0.3).unwrap(), 0.3);
        // A little of both, to first order.
        let thin = Film::new(3.0, 5.0, 1e-10).unwrap();
        assert!((thin.reflectance() / 5e-10 - 1.0).abs() < 1e-8 && (thin.absorptance() / 3e-10 - 1.0).abs() < 1e-8);
    }

    #[test]
    fn thick_films_reach_the_infinite_one() {
        for (k, s) in [(0.1, 1.0), (1e-4, 1.0), (5.0, 0.1)] {
            let film = Film::new(k, s, 1e4).unwrap();
            assert!((film.reflectance() / film.reflectance_infinite() - 1.0).abs() < 1e-13);
            assert!((Film::ratio(film.reflectance_infinite()).unwrap() / (k / s) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_textbook_form_is_the_same_where_it_works() {
        let (k, s, x, g) = (0.3f64, 1.7f64, 0.9f64, 0.6f64);
        let a = (k + s) / s;
        let b = (a * a - 1.0).sqrt();
        let coth = 1.0 / (b * s * x).tanh();
        let textbook = (1.0 - g * (a - b * coth)) / (a - g + b * coth);
        let film = Film::new(k, s, x).unwrap();
        assert!((film.reflectance_over(g).unwrap() - textbook).abs() < 1e-14);
        let passed = b / (a * (b * s * x).sinh() + b * (b * s * x).cosh());
        assert!((film.transmittance() - passed).abs() < 1e-14);
    }

    /// Thick matter of little absorption, by diffusion: `1 - 4 sqrt(sigma_a / (3 sigma_s'))`.
    #[test]
    fn little_absorption_is_that_of_diffusion() {
        let film = Film::of_medium(1e-6, 10.0, 0.6, 1.0).unwrap();
        assert!((film.decay() / (3.0f64 * 1e-6 * 4.0).sqrt() - 1.0).abs() < 1e-6);
        let missing = 1.0 - film.reflectance_infinite();
        assert!((missing / (4.0 * (1e-6f64 / 12.0).sqrt()) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn mixtures_are_means_by_volume() {
        assert_eq!(mix([(1.0, 2.0, 4.0), (3.0, 6.0, 8.0)]).unwrap(), (5.0, 7.0));
        assert!(mix([(0.0, 1.0, 1.0)]).is_err() && mix([(-1.0, 1.0, 1.0)]).is_err());
    }

    #[test]
    fn what_is_no_film_is_refused() {
        for value in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(Film::new(value, 1.0, 1.0).is_err() && Film::new(1.0, 1.0, value).is_err());
        }
        for g in [1.1, -1.1, f64::NAN] {
            assert!(Film::of_medium(1.0, 1.0, g, 1.0).is_err(), "{g}");
        }
        let film = Film::new(1.0, 1.0, 1.0).unwrap();
        assert!(film.reflectance_over(1.1).is_err() && Film::ratio(0.0).is_err() && Film::ratio(1.0).is_err());
    }
}
