//! The random walk through a turbid medium: nearly all the time of a picture of milk is spent here.

use glam::DVec3;
use mieux_optics::phase::HenyeyGreenstein;
use rand_core::Rng;
use rand_pcg::Pcg64Mcg;

use super::throughput::{Throughput, WALK_ROULETTE};
use super::turbid::Turbid;
use super::{LANES, Lanes, Statistics};
use crate::geometry::{Accelerator, Hit, Ray};
use crate::sampler::{Exponential, Turn, uniform};

/// How a walk ended.
pub(crate) enum WalkEnd {
    /// At a surface.
    Hit(Hit),
    /// At a collision beyond the length asked for.
    Length,
    /// In Russian roulette.
    Absorbed,
    /// Outside everything, or after too many collisions.
    Lost,
}

/// Longest walk between two surfaces, in collisions.
const MOST_COLLISIONS: u64 = 10_000_000;

/// Mean free paths of known clearance beyond which it does not pay to look.
const ENOUGH: f64 = 300.0;

/// Running account of a walk: enough to give, at its end, the density of what happened for every wavelength.
#[derive(Clone, Copy)]
struct Account {
    length: f64,
    collisions: u32,
    /// Products of `(1 + g^2 - 2 g mu) / (1 - g^2)`.
    angles: Lanes,
}

impl Account {
    const EMPTY: Self = Self { length: 0.0, collisions: 0, angles: [1.0; LANES] };

    /// A flight of `step` (m) and a turn by the cosine `mu`.
    #[inline(always)]
    fn collide(&mut self, step: f64, mu: f64, phase: &Hero) {
        self.length += step;
        self.collisions += 1;
        for (product, (fixed, slope)) in self.angles.iter_mut().zip(phase.denominators) {
            *product *= fixed - slope * mu;
        }
    }

    /// Writes the account into the throughput and starts a new one.
    fn close(&mut self, medium: &Turbid, throughput: &mut Throughput) {
        let count = f64::from(self.collisions);
        let log_hero = self.angles[0].ln();
        let log_density = std::array::from_fn(|k| {
            if k == 0 {
                return 0.0;
            }
            count * medium.log_collision[k]
                - (medium.sigma_t[k] - medium.sigma_t[0]) * self.length
                - 1.5 * (self.angles[k].ln() - log_hero)
        });
        throughput.walk(&log_density, &medium.log_albedo.map(|a| a * count));
        *self = Self::EMPTY;
    }
}

/// What a walk moves: where the light is, and what it carries.
pub(crate) struct Flight<'a> {
    /// Left at the last collision, or before the surface met.
    pub(crate) ray: &'a mut Ray,
    /// The triangle the ray has just left; cleared after the first collision.
    pub(crate) exclude: &'a mut u32,
    pub(crate) throughput: &'a mut Throughput,
}

/// Walks until a surface, the length `limit` (m), or the end. The hero's extinction gives the free flights and its
/// asymmetry the angles; absorption only weighs. Returns the end and the length walked (m).
pub(crate) fn walk(
    accelerator: &Accelerator,
    medium: &Turbid,
    flight: Flight<'_>,
    limit: f64,
    outer: &mut Pcg64Mcg,
    statistics: &mut Statistics,
) -> (WalkEnd, f64) {
    let Flight { ray, exclude, throughput } = flight;
    // A copy of its own stays in registers.
    let mut generator = outer.clone();
    let (exponential, turn, phase) = (Exponential::get(), Turn::get(), Hero::new(medium));
    let mean_free_path = 1.0 / medium.sigma_t[0];
    let Ray { origin: mut place, direction: mut forward } = *ray;
    let mut space = Space::new(accelerator, ENOUGH * mean_free_path, *exclude);
    let mut account = Account::EMPTY;
    let (mut walked, mut closed) = (0.0, 0u64);
    let end = loop {
        let step = exponential.sample(&mut generator) * mean_free_path;
        let next = place + forward * step;
        if (next - space.centre).length_squared() >= space.clear
            && let Some((end, length)) = space.look(place, forward, step)
        {
            account.length += length;
            break end;
        }
        place = next;
        let bits = generator.next_u64();
        let mu = phase.sample(bits);
        account.collide(step, mu, &phase);
        forward = scattered(forward, mu, turn.angle(bits as u32));
        if account.collisions >= medium.interval || walked + account.length > limit {
            closed += u64::from(account.collisions);
            walked += account.length;
            account.close(medium, throughput);
            // Takes out the rounding of many turns.
            forward = forward.normalize();
            if !throughput.survives(WALK_ROULETTE, || uniform(&mut generator)) {
                break WalkEnd::Absorbed;
            }
            if closed > MOST_COLLISIONS {
                break WalkEnd::Lost;
            }
            if walked > limit {
                break WalkEnd::Length;
            }
        }
    };
    *outer = generator;
    (ray.origin, ray.direction, *exclude) = (place, forward, space.exclude);
    statistics.collisions += closed + u64::from(account.collisions);
    walked += account.length;
    account.close(medium, throughput);
    (end, walked)
}

/// What is known about the surfaces around a walk: a sphere that holds none, around where the nearest one was last
/// looked for, spares most steps the test.
struct Space<'a> {
    accelerator: &'a Accelerator,
    enough: f64,
    exclude: u32,
    centre: DVec3,
    /// Square of the sphere's radius; below 0 if nothing is known.
    clear: f64,
}

impl<'a> Space<'a> {
    fn new(accelerator: &'a Accelerator, enough: f64, exclude: u32) -> Self {
        Self { accelerator, enough, exclude, centre: DVec3::ZERO, clear: -1.0 }
    }

    /// Whether a step from `place` that may leave the sphere ends the walk, and after which length.
    fn look(&mut self, place: DVec3, forward: DVec3, step: f64) -> Option<(WalkEnd, f64)> {
        let free = self.accelerator.clearance(place, step, self.enough);
        (self.centre, self.clear) = (place, free * free);
        if step >= free {
            let ray = Ray { origin: place, direction: forward };
            if let Some(hit) = self.accelerator.intersect(&ray, step, self.exclude) {
                return Some((WalkEnd::Hit(hit), hit.t));
            }
        }
        self.exclude = Accelerator::NONE;
        let (low, high) = self.accelerator.bounds();
        let inside = place.cmpge(low).all() && place.cmple(high).all();
        (!inside).then_some((WalkEnd::Lost, 0.0))
    }
}

/// The hero's phase function, and what every wavelength's contributes to the account.
struct Hero {
    /// `None` is isotropic.
    phase: Option<HenyeyGreenstein>,
    /// Whether the closed form loses no digits: `mu = middle - slope (width / (1 + g s))^2`, s uniform in [-1, 1).
    closed: bool,
    g: f64,
    middle: f64,
    slope: f64,
    /// `(1 + g^2) / (1 - g^2)` and `2 g / (1 - g^2)` of each wavelength.
    denominators: [(f64, f64); LANES],
}

impl Hero {
    fn new(medium: &Turbid) -> Self {
        let g = medium.g[0];
        Self {
            phase: HenyeyGreenstein::new(g).ok().filter(|_| g != 0.0),
            closed: g.abs() > 0.01,
            g,
            middle: 0.5 * (1.0 + g * g) / g,
            slope: 0.5 * (1.0 - g * g).powi(2) / g,
            denominators: medium.g.map(|g| ((1.0 + g * g) / (1.0 - g * g), 2.0 * g / (1.0 - g * g))),
        }
    }

    /// A cosine from the upper half of 64 random bits.
    #[inline]
    fn sample(&self, bits: u64) -> f64 {
        let xi = (bits >> 32) as i64 as f64 * (1.0 / (1u64 << 32) as f64);
        if self.closed {
            let inverse = 1.0 / (1.0 + self.g * (2.0 * xi - 1.0));
            return self.middle - self.slope * inverse * inverse;
        }
        self.phase.map_or(2.0 * xi - 1.0, |phase| phase.sample(xi))
    }
}

/// The unit vector at the angle of cosine `mu` from `forward`, at an azimuth given by cosine and sine about axes made
/// from `forward` without a branch (`duff2017`), multiplied out.
#[inline]
pub(crate) fn scattered(forward: DVec3, mu: f64, (cos_phi, sin_phi): (f64, f64)) -> DVec3 {
    let sine = (1.0 - mu * mu).max(0.0).sqrt();
    let sign = 1f64.copysign(forward.z);
    let (c, s) = (sine * cos_phi, sine * sin_phi);
    let down = sign * c * forward.x + s * forward.y;
    // A reciprocal that waits for z alone: the division is not in the chain from one direction to the next.
    let k = down * (1.0 / (sign + forward.z));
    DVec3::new(forward.x * mu + (c - k * forward.x), forward.y * mu + (sign * s - k * forward.y), forward.z * mu - down)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scattered_directions_are_unit_vectors_at_the_angle() {
        for i in 0..2000u32 {
            let u = f64::from(i) / 2000.0;
            let z = 2.0 * u - 1.0;
            let (cosine, sine) = Turn::get().angle(i.wrapping_mul(0x9e37_79b9));
            let r = (1.0 - z * z).sqrt();
            let forward = DVec3::new(r * cosine, r * sine, z).normalize();
            let mu = (f64::from(i) * 0.7).sin();
            let turned = scattered(forward, mu, Turn::get().angle(i.wrapping_mul(0x85eb_ca6b)));
            assert!((turned.length() - 1.0).abs() < 1e-8, "{turned}");
            assert!((turned.dot(forward) - mu).abs() < 1e-8);
        }
    }

    #[test]
    fn both_forms_of_the_cosine_agree() {
        for g in [-0.9, -0.011, 0.011, 0.3, 0.954, 0.999] {
            let hero = Hero::new(&Turbid::new([1.0; LANES], &[0.0; LANES], [g; LANES]));
            for i in 0..1000u64 {
                let bits = i * 0x0041_8937_0000_0000;
                let xi = (bits >> 32) as f64 / 4_294_967_296.0;
                let mu = hero.phase.unwrap().sample(xi);
                assert!((hero.sample(bits) - mu).abs() < 1e-9, "{g} {xi}");
            }
        }
    }

    /// Reflected, transmitted and absorbed light of a slab add up to 1, absorption being gathered from the lengths
    /// of the flights: nothing but right flights, weights and roulette makes the three agree.
    #[test]
    fn energy_is_conserved() {
        use crate::geometry::cuboid;
        let accelerator = Accelerator::new([&cuboid([-9.0, -9.0, 0.0], [9.0, 9.0, 1e-3]).unwrap()]);
        let medium = Turbid::new([2_700.0; LANES], &[300.0; LANES], [0.7; LANES]);
        let (mut generator, mut statistics) = (Pcg64Mcg::new(77), Statistics::default());
        let n = 200_000;
        let (mut reflected, mut transmitted, mut absorbed, mut squares) = (0.0, 0.0, 0.0, 0.0);
        for _ in 0..n {
            let mut ray = Ray { origin: DVec3::new(1e-4, 2e-4, 1e-3), direction: -DVec3::Z };
            let (mut exclude, mut throughput, mut kept) = (Accelerator::NONE, Throughput::new(true), 0.0);
            // The entry lies on the f32 surface or just above it: step inside.
            ray.origin.z -= 1e-10;
            loop {
                let before = throughput.share();
                let flight = Flight { ray: &mut ray, exclude: &mut exclude, throughput: &mut throughput };
                let (end, length) = walk(&accelerator, &medium, flight, 0.0, &mut generator, &mut statistics);
                kept += before * 300.0 * length;
                match end {
                    WalkEnd::Hit(_) if ray.direction.z > 0.0 => reflected += throughput.share(),
                    WalkEnd::Hit(_) => transmitted += throughput.share(),
                    WalkEnd::Length => continue,
                    WalkEnd::Absorbed => {}
                    WalkEnd::Lost => panic!("lost"),
                }
                break;
            }
            absorbed += kept;
            squares += kept * kept;
        }
        let count = f64::from(n);
        let (r, t, a) = (reflected / count, transmitted / count, absorbed / count);
        // The errors of R and T are below those of independent draws of 0 or 1.
        let error = ((squares / count - a * a + r * (1.0 - r) + t * (1.0 - t)) / count).sqrt();
        assert!(a > 0.1 && r > 0.03 && t > 0.3, "{r} {t} {a}");
        assert!((r + t + a - 1.0).abs() < 3.0 * error && error < 3e-3, "{r} + {t} + {a} = {}", r + t + a);
    }
}
