//! What a path carries at each of its wavelengths, and how likely each of them would have made it.

use super::{LANES, Lanes};

/// Per wavelength: the measurement `f`, the density `p` of the path had that wavelength been the hero, and the density `l`
/// of the path up to where light was last looked for directly, all up to one common factor.
///
/// Single-sample multiple importance sampling with the balance heuristic (`wilkie2014`, `miller2019`): wavelength `i`
/// contributes `f_i / mean(p + l q)` to light that would have been looked for with the density `q`. A companion that could
/// not have made the path has `p = 0`; where no light was looked for, `l = 0`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Throughput {
    f: Lanes,
    p: Lanes,
    l: Lanes,
}

/// What a ray towards a light carries: measurement, density of finding it by chance, and by looking.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shadow {
    pub(crate) f: Lanes,
    pub(crate) p: Lanes,
    pub(crate) l: Lanes,
}

impl Shadow {
    /// The radiance it adds at the start of the path.
    pub(crate) fn estimate(&self) -> Lanes {
        let sum: f64 = (0..LANES).map(|k| self.p[k] + self.l[k]).sum();
        let scale = if sum > 0.0 { LANES as f64 / sum } else { 0.0 };
        self.f.map(|f| f * scale)
    }

    /// Through homogeneous matter that the path would have to get through by chance.
    pub(crate) fn pass(&mut self, transmittance: &Lanes) {
        for ((f, p), t) in self.f.iter_mut().zip(&mut self.p).zip(transmittance) {
            *f *= t;
            *p *= t;
        }
    }

    /// Through clear matter.
    pub(crate) fn absorb(&mut self, transmittance: &Lanes) {
        (0..LANES).for_each(|k| self.f[k] *= transmittance[k]);
    }

    /// An event of density `seen` for the path and `tracked` for the ray, whose light share is `seen`.
    pub(crate) fn track(&mut self, seen: &Lanes, tracked: &Lanes) {
        let scale = 1.0 / tracked[0];
        for k in 0..LANES {
            self.f[k] *= seen[k] * scale;
            self.p[k] *= seen[k] * scale;
            self.l[k] *= tracked[k] * scale;
        }
    }
}

/// Below this share a path is continued by chance only, at surfaces.
pub(crate) const ROULETTE: f64 = 0.1;
/// The same within a walk. The longest walks cost most and carry least: at a half, milk takes a third fewer collisions
/// than at a tenth, for hardly more noise.
pub(crate) const WALK_ROULETTE: f64 = 0.5;

impl Throughput {
    pub(crate) fn new(companions: bool) -> Self {
        let lanes = std::array::from_fn(|k| if k == 0 || companions { 1.0 } else { 0.0 });
        Self { f: lanes, p: lanes, l: [0.0; LANES] }
    }

    /// The share of light that the path carries, averaged over its wavelengths: 1 until something is absorbed. The
    /// same whichever of them is the hero.
    pub(crate) fn share(&self) -> f64 {
        let (f, p): (f64, f64) = (self.f.iter().sum(), self.p.iter().sum());
        if p > 0.0 { f / p } else { 0.0 }
    }

    /// Radiance that light of `radiance` adds at the start of the path.
    pub(crate) fn estimate(&self, radiance: &Lanes) -> Lanes {
        let p: f64 = self.p.iter().sum();
        let scale = if p > 0.0 { LANES as f64 / p } else { 0.0 };
        std::array::from_fn(|k| self.f[k] * radiance[k] * scale)
    }

    /// The same for light that was also looked for, with the density `looked`.
    pub(crate) fn estimate_beside(&self, radiance: &Lanes, looked: &Lanes) -> Lanes {
        let sum: f64 = (0..LANES).map(|k| self.p[k] + self.l[k] * looked[k]).sum();
        let scale = if sum > 0.0 { LANES as f64 / sum } else { 0.0 };
        std::array::from_fn(|k| self.f[k] * radiance[k] * scale)
    }

    /// From here light is looked for directly.
    pub(crate) fn mark(&mut self) {
        self.l = self.p;
    }

    /// What comes now could not have been found by looking for light directly.
    pub(crate) fn forget(&mut self) {
        self.l = [0.0; LANES];
    }

    /// A ray towards a light, from here: the share of its `radiance` that goes on along the path, the density of that
    /// direction by chance and by looking.
    pub(crate) fn towards(&self, share: &Lanes, chance: &Lanes, looked: &Lanes) -> Shadow {
        Shadow {
            f: std::array::from_fn(|k| self.f[k] * share[k]),
            p: std::array::from_fn(|k| self.p[k] * chance[k]),
            l: std::array::from_fn(|k| self.p[k] * looked[k]),
        }
    }

    /// An event of density `chance` for each wavelength, that lets through the share of light of the same size; light looked
    /// for from before it would have come there with the density `tracked`.
    pub(crate) fn pass(&mut self, chance: &Lanes, tracked: &Lanes) {
        let scale = 1.0 / chance[0];
        for k in 0..LANES {
            self.f[k] *= chance[k] * scale;
            self.p[k] *= chance[k] * scale;
            self.l[k] *= tracked[k] * scale;
        }
    }

    /// Absorption along the way: no chance is involved.
    pub(crate) fn absorb(&mut self, share: &Lanes) {
        (0..LANES).for_each(|k| self.f[k] *= share[k]);
    }

    /// An event was chosen by the hero with probability `chance[0]` and would have been by the others with theirs;
    /// the light takes the same shares.
    pub(crate) fn choose(&mut self, chance: &Lanes) {
        for k in 0..LANES {
            let ratio = chance[k] / chance[0];
            self.f[k] *= ratio;
            self.p[k] *= ratio;
            self.l[k] /= chance[0];
        }
    }

    /// A place was chosen with a density for each wavelength had it been the hero, and light takes these shares to it.
    pub(crate) fn jump(&mut self, share: &Lanes, density: &Lanes) {
        let scale = 1.0 / density[0];
        for k in 0..LANES {
            self.f[k] *= share[k] * scale;
            self.p[k] *= density[k] * scale;
            self.l[k] *= scale;
        }
    }

    /// Ends the companions for which `same` is false: they would have gone elsewhere.
    pub(crate) fn keep(&mut self, same: impl Fn(usize) -> bool) {
        for k in (1..LANES).filter(|&k| !same(k)) {
            (self.f[k], self.p[k], self.l[k]) = (0.0, 0.0, 0.0);
        }
    }

    /// A random walk: logarithms of its density for each wavelength relative to the hero's, and of the share of
    /// light left by absorption. Light looked for from before it is forgotten.
    pub(crate) fn walk(&mut self, log_density: &Lanes, log_left: &Lanes) {
        let highest = (0..LANES).filter(|&k| self.p[k] > 0.0).map(|k| log_density[k]).fold(f64::NEG_INFINITY, f64::max);
        let mut sum = 0.0;
        for k in 0..LANES {
            if self.p[k] > 0.0 {
                let density = (log_density[k] - highest).exp();
                self.p[k] *= density;
                self.f[k] *= density * log_left[k].exp();
                sum += self.p[k];
            }
        }
        self.forget();
        // The common factor is free; keep it near 1.
        if sum > 0.0 {
            let scale = 1.0 / sum;
            (0..LANES).for_each(|k| {
                self.f[k] *= scale;
                self.p[k] *= scale;
            });
        }
    }

    /// Russian roulette by what the path still carries, never by its length: white media scatter light thousands of
    /// times and lose nothing. Below the share `least` it is continued with probability share / least. Returns whether
    /// the path goes on; `xi` gives a uniform number if one is needed.
    pub(crate) fn survives(&mut self, least: f64, xi: impl FnOnce() -> f64) -> bool {
        let share = self.share();
        if share >= least {
            return true;
        }
        let chance = share / least;
        if xi() >= chance {
            return false;
        }
        self.f.iter_mut().for_each(|f| *f /= chance);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lossless_events_keep_the_share() {
        let mut t = Throughput::new(true);
        t.choose(&[0.3, 0.2, 0.5, 0.9]);
        t.walk(&[0.0, -3.0, 700.0, 2.0], &[0.0; 4]);
        assert!((t.share() - 1.0).abs() < 1e-12);
        let parts: f64 = t.estimate(&[1.0; 4]).iter().sum();
        assert!((parts - 4.0).abs() < 1e-12);
        t.keep(|_| false);
        assert!(t.share().is_finite());
    }

    #[test]
    fn a_lone_hero_counts_fourfold() {
        let mut t = Throughput::new(true);
        t.keep(|_| false);
        assert_eq!(t.estimate(&[2.0; 4]), [8.0, 0.0, 0.0, 0.0]);
        assert_eq!(Throughput::new(false).estimate(&[2.0; 4]), [8.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn roulette_is_fair_and_spares_the_bright() {
        let mut bright = Throughput::new(true);
        assert!(bright.survives(ROULETTE, || unreachable!()));
        let mut dim = Throughput::new(true);
        dim.absorb(&[0.05, 0.02, 0.0, 0.01]);
        let before = dim.share();
        let mut lucky = dim;
        assert!(!dim.survives(ROULETTE, || before / ROULETTE));
        assert!(lucky.survives(ROULETTE, || 0.999 * before / ROULETTE));
        assert!((lucky.share() - ROULETTE).abs() < 1e-12);
        let mut dark = Throughput::new(true);
        dark.absorb(&[0.0; 4]);
        assert!(!dark.survives(ROULETTE, || 0.0));
    }
}
