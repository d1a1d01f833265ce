//! A medium as rendering reads it, and what of it matters to one path.

use mieux_optics::spectrum::Sampled;

use super::phase::{DensePhase, PhaseLanes};
use super::{DESIGN_WAVELENGTH, Dense, Grid, MOST_PARTS, Medium, MediumError, Part as MediumPart};
use crate::integrator::{LANES, Lanes};

/// A medium with all spectra laid out.
pub(crate) struct DenseMedium {
    pub(crate) n: Dense,
    pub(crate) n_design: f64,
    /// Sums over the parts that are everywhere.
    pub(crate) sigma_s: Dense,
    pub(crate) sigma_a: Dense,
    /// Mean cosine of scattering; of the first part where several have other functions.
    pub(crate) g: Dense,
    /// Henyey-Greenstein alone, the same everywhere, dark: what the fast walk can do.
    pub(crate) walkable: bool,
    /// Nothing scatters and nothing shines anywhere in it.
    pub(crate) clear: bool,
    pub(crate) has_grids: bool,
    /// Whether it has the index of the air around, 1 at all wavelengths.
    pub(crate) unbending: bool,
    parts: Vec<DensePart>,
}

struct DensePart {
    sigma_s: Dense,
    sigma_a: Dense,
    emission: Option<Dense>,
    phase: DensePhase,
    grid: Option<std::sync::Arc<Grid>>,
}

/// One part at the wavelengths of a path.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part<'a> {
    pub(crate) sigma_s: Lanes,
    pub(crate) sigma_t: Lanes,
    /// Absorption times source function; 0 for what does not shine.
    pub(crate) emitted: Lanes,
    pub(crate) phase: PhaseLanes<'a>,
    pub(crate) grid: Option<&'a Grid>,
}

/// What scatters in a medium at the wavelengths of a path.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Matter<'a> {
    parts: [Part<'a>; MOST_PARTS],
    count: usize,
    /// The place of the grids, if there are any.
    pub(crate) grid: Option<&'a Grid>,
    pub(crate) shines: bool,
}

const COEFFICIENT: &str = "must lie between 0 and 1e12 per metre";

impl DensePart {
    fn new(part: &MediumPart, range: (f64, f64)) -> Result<Self, MediumError> {
        let coefficient = |v: f64| (0.0..=1e12).contains(&v);
        let dense = |what, spectrum: &Sampled| Dense::new(what, spectrum, range, COEFFICIENT, coefficient);
        let emission = |spectrum: &Sampled| {
            Dense::new("emission", spectrum, range, "must not be negative", |v| v >= 0.0 && v.is_finite())
        };
        Ok(Self {
            sigma_s: dense("sigma_s", &part.sigma_s)?,
            sigma_a: dense("sigma_a", &part.sigma_a)?,
            emission: part.emission.as_ref().map(emission).transpose()?,
            phase: DensePhase::new(&part.phase, range)?,
            grid: part.density.clone(),
        })
    }
}

impl DensePart {
    fn lanes(&self, wavelengths: &Lanes) -> Part<'_> {
        let (sigma_s, sigma_a) = (self.sigma_s.lanes(wavelengths), self.sigma_a.lanes(wavelengths));
        let source = self.emission.as_ref().map_or([0.0; LANES], |emission| emission.lanes(wavelengths));
        Part {
            sigma_s,
            sigma_t: std::array::from_fn(|k| sigma_s[k] + sigma_a[k]),
            emitted: std::array::from_fn(|k| sigma_a[k] * source[k]),
            phase: self.phase.lanes(wavelengths),
            grid: self.grid.as_deref(),
        }
    }
}

impl DenseMedium {
    pub(crate) fn new(medium: &Medium, range: (f64, f64)) -> Result<Self, MediumError> {
        if !(1..=MOST_PARTS).contains(&medium.parts.len()) {
            return Err(MediumError::Parts { count: medium.parts.len() });
        }
        let index = |v: f64| (0.1..=10.0).contains(&v);
        let n = Dense::new("n", &medium.n, range, "must lie between 0.1 and 10", index)?.rounded();
        let parts: Vec<DensePart> =
            medium.parts.iter().map(|part| DensePart::new(part, range)).collect::<Result<_, _>>()?;
        let mut grids = parts.iter().filter_map(|part| part.grid.as_deref());
        if let Some(first) = grids.next()
            && !grids.all(|grid| grid.lies_as(first))
        {
            return Err(MediumError::Grids);
        }
        let everywhere = |of: fn(&DensePart) -> &Dense| {
            let values = parts.iter().filter(|p| p.grid.is_none()).map(of);
            values.fold(None, |sum: Option<Dense>, d| Some(sum.map_or_else(|| d.clone(), |s| s.plus(d))))
        };
        let zero = || n.map(|_| 0.0);
        let single = parts.len() == 1 && parts[0].grid.is_none() && parts[0].emission.is_none();
        let first = &parts[0];
        let g = n.by_wavelength(|w| first.phase.asymmetry(w));
        let dark = |part: &DensePart| part.emission.is_none() && part.sigma_s.all(|v| v == 0.0);
        Ok(Self {
            n_design: n.at(DESIGN_WAVELENGTH),
            sigma_s: everywhere(|p| &p.sigma_s).unwrap_or_else(zero),
            sigma_a: everywhere(|p| &p.sigma_a).unwrap_or_else(zero),
            g,
            walkable: single && matches!(first.phase, DensePhase::HenyeyGreenstein(_)),
            clear: parts.iter().all(|part| part.grid.is_none() && dark(part)),
            has_grids: parts.iter().any(|part| part.grid.is_some()),
            unbending: n.all(|v| v == 1.0),
            n,
            parts,
        })
    }

    pub(crate) fn matter(&self, wavelengths: &Lanes) -> Matter<'_> {
        let mut parts = [self.parts[0].lanes(wavelengths); MOST_PARTS];
        for (lanes, part) in parts.iter_mut().zip(&self.parts).skip(1) {
            *lanes = part.lanes(wavelengths);
        }
        Matter {
            parts,
            count: self.parts.len(),
            grid: self.parts.iter().find_map(|part| part.grid.as_deref()),
            shines: self.parts.iter().any(|part| part.emission.is_some()),
        }
    }
}

impl<'a> Matter<'a> {
    pub(crate) fn parts(&self) -> &[Part<'a>] {
        &self.parts[..self.count]
    }

    /// Coefficients summed over the parts, each times its density: scattering, extinction, emission.
    pub(crate) fn sums(&self, densities: &[f64; MOST_PARTS]) -> Sums {
        let mut sums = Sums { sigma_s: [0.0; LANES], sigma_t: [0.0; LANES], emitted: [0.0; LANES] };
        for (part, density) in self.parts().iter().zip(densities) {
            for k in 0..LANES {
                sums.sigma_s[k] += part.sigma_s[k] * density;
                sums.sigma_t[k] += part.sigma_t[k] * density;
                sums.emitted[k] += part.emitted[k] * density;
            }
        }
        sums
    }

    /// Densities of the parts where no grid reaches: 1 for those that are everywhere.
    pub(crate) fn everywhere(&self) -> [f64; MOST_PARTS] {
        std::array::from_fn(|i| if self.parts[i].grid.is_none() { 1.0 } else { 0.0 })
    }

    /// Densities of the parts at a place in the units of the grid.
    pub(crate) fn densities(&self, place: glam::DVec3) -> [f64; MOST_PARTS] {
        std::array::from_fn(|i| match self.parts[i].grid {
            Some(grid) if i < self.count => grid.at(place),
            _ => 1.0,
        })
    }

    /// The most that the densities can be in a block of the grids.
    pub(crate) fn majorants(&self, block: usize) -> [f64; MOST_PARTS] {
        std::array::from_fn(|i| match self.parts[i].grid {
            Some(grid) if i < self.count => grid.most(block),
            _ => 1.0,
        })
    }

    /// Scattering coefficient times phase function, summed over the parts, at a scattering cosine: 1/(m sr).
    pub(crate) fn scattering(&self, densities: &[f64; MOST_PARTS], mu: f64) -> Lanes {
        let mut sum = [0.0; LANES];
        for (part, density) in self.parts().iter().zip(densities).filter(|(_, d)| **d > 0.0) {
            let values = part.phase.values(mu);
            (0..LANES).for_each(|k| sum[k] += part.sigma_s[k] * density * values[k]);
        }
        sum
    }

    /// A scattering cosine of the hero's: a part by its share, then by its phase function.
    pub(crate) fn sample(&self, densities: &[f64; MOST_PARTS], xi: f64) -> f64 {
        let shares = |(part, density): (&Part<'a>, &f64)| part.sigma_s[0] * density;
        let total: f64 = self.parts().iter().zip(densities).map(shares).sum();
        let mut left = xi * total;
        let last = self.count - 1;
        for (i, (part, density)) in self.parts().iter().zip(densities).enumerate() {
            let share = shares((part, density));
            if left < share || i == last {
                let xi = if share > 0.0 { (left / share).clamp(0.0, 1.0 - f64::EPSILON) } else { 0.5 };
                return part.phase.sample(xi);
            }
            left -= share;
        }
        1.0
    }
}

/// Coefficients of a medium at a place, 1/m, at the wavelengths of a path.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sums {
    pub(crate) sigma_s: Lanes,
    pub(crate) sigma_t: Lanes,
    pub(crate) emitted: Lanes,
}
