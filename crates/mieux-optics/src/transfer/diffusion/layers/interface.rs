//! What lies between two turbid layers, or outside of them: planes, and clear panes between planes.

use std::convert::Infallible;

use super::beam::line;
use super::turbid::Admittance;
use crate::integrate::integrate;

/// Shares of light that is uniform, and linear in the cosine: integrals over the cosine on one side.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moments {
    /// Of the reflected share times the cosine, and its square.
    pub reflected: [f64; 2],
    /// Of the share that passes, likewise.
    pub passed: [f64; 2],
}

/// Planes and panes, from above and from below.
#[derive(Debug, Clone, Copy)]
pub(super) struct Interface {
    pub above: Moments,
    pub below: Moments,
    /// Whether there is nothing in it.
    nothing: bool,
}

/// Cosines in a medium of index `from` up to which light is totally reflected from others, between 0 and 1.
pub(super) fn knots(from: f64, others: impl Iterator<Item = f64>) -> Vec<f64> {
    let critical = others.filter(|n| *n < from).map(|n| ((1.0 - n / from) * (1.0 + n / from)).sqrt());
    let mut knots: Vec<f64> = critical.chain([0.0, 1.0]).collect();
    knots.sort_by(f64::total_cmp);
    knots.dedup_by(|a, b| (*a - *b).abs() < 1e-12);
    knots
}

impl Moments {
    const FREE: Self = Self { reflected: [0.0; 2], passed: [0.5, 1.0 / 3.0] };

    fn new(indices: &[f64], panes: &[f64], mirror: f64) -> Self {
        let knots = knots(indices[0], indices.iter().copied());
        let found = integrate(&knots, 1e-11, [1e-2; 4], |cosine| {
            let line = line(indices, panes, cosine, mirror);
            let (back, through) = (line.reflected * cosine, line.on_ground * (1.0 - mirror) * cosine);
            Ok::<_, Infallible>([back, back * cosine, through, through * cosine])
        });
        let [r1, r2, t1, t2] = match found {
            Ok(found) => found.map_or([f64::NAN; 4], |integral| integral.value),
            Err(never) => match never {},
        };
        Self { reflected: [r1, r2], passed: [t1, t2] }
    }

    /// What fluence and flux towards the interface mean for the current away from it: `1/4 - r1/2` and `1/2 + 3 r2/2`.
    fn balance(&self) -> [f64; 2] {
        [0.25 - 0.5 * self.reflected[0], 0.5 + 1.5 * self.reflected[1]]
    }

    /// The current that passes, of fluence and flux towards the interface.
    fn through(&self, fluence: f64, flux: f64) -> f64 {
        0.5 * self.passed[0] * fluence + 1.5 * self.passed[1] * flux
    }
}

impl Interface {
    /// Media from above to below, and the optical thicknesses of those between the first and the last.
    pub fn new(indices: &[f64], panes: &[f64], mirror: f64) -> Self {
        let nothing = mirror == 0.0 && indices.windows(2).all(|n| n[0] == n[1]) && panes.iter().all(|t| *t == 0.0);
        if nothing {
            return Self { above: Moments::FREE, below: Moments::FREE, nothing };
        }
        let reversed = |values: &[f64]| values.iter().rev().copied().collect::<Vec<f64>>();
        let above = Moments::new(indices, panes, mirror);
        Self { above, below: Moments::new(&reversed(indices), &reversed(panes), 0.0), nothing }
    }

    /// The flux above, where below is a ground that sends back `ground` times what passes (its own echoes included) and the
    /// beam brings it `beam`.
    pub fn onto_ground(&self, ground: f64, beam: f64) -> Admittance {
        let [fluence, flux] = self.above.balance();
        let echo = 2.0 * self.below.passed[0] * ground;
        let divisor = flux + 1.5 * echo * self.above.passed[1];
        Admittance {
            slope: (fluence - 0.5 * echo * self.above.passed[0]).max(0.0) / divisor,
            offset: -echo * beam / divisor,
        }
    }

    /// The flux above as a function of the fluence there, from the same below.
    pub fn above(&self, below: Admittance) -> Admittance {
        if self.nothing {
            return below;
        }
        let ([fluence, flux], m) = (self.above.balance(), self.coupling(below));
        let divisor = flux + 1.5 * m * self.above.passed[1];
        let offset = m * self.below.balance()[1] + 1.5 * self.below.passed[1];
        Admittance {
            slope: (fluence - 0.5 * m * self.above.passed[0]) / divisor,
            offset: below.offset * offset / divisor,
        }
    }

    /// The fluence below, from fluence and flux above.
    pub fn below(&self, below: Admittance, fluence: f64, flux: f64) -> f64 {
        if self.nothing {
            return fluence;
        }
        let [of_fluence, of_flux] = self.below.balance();
        (self.above.through(fluence, flux) - below.offset * of_flux) / (of_fluence + below.slope * of_flux)
    }

    /// The fluence below where no diffuse light comes from above.
    pub fn below_nothing(&self, below: Admittance) -> f64 {
        let [of_fluence, of_flux] = self.below.balance();
        -below.offset * of_flux / (of_fluence + below.slope * of_flux)
    }

    /// The current that passes upward, of what is below.
    pub fn leaving_up(&self, fluence: f64, flux: f64) -> f64 {
        self.below.through(fluence, -flux)
    }

    /// The current that passes downward, of what is above.
    pub fn leaving_down(&self, fluence: f64, flux: f64) -> f64 {
        self.above.through(fluence, flux)
    }

    fn coupling(&self, below: Admittance) -> f64 {
        let [of_fluence, of_flux] = self.below.balance();
        self.below.through(1.0, -below.slope) / (of_fluence + below.slope * of_flux)
    }
}
