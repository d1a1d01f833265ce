//! The way of one photon.

use glam::{DVec2, DVec3};
use mieux_optics::phase::PhaseFunction;
use mieux_optics::transfer::fresnel::dielectric_reflectance;
use mieux_optics::transfer::{Ground, Stack};
use rand_core::Rng;
use rand_pcg::Pcg64Mcg;

use super::counts::{Slot, Tally};
use crate::integrator::scattered;
use crate::sampler::{Exponential, Turn, uniform};

/// Below this share of its first weight a photon plays roulette, for `REVIVED` times as much.
const LEAST: f64 = 0.05;
const REVIVED: f64 = 5.0;
/// Collisions between two looks at the bound on their number; rounding in the direction is then taken out too.
const LOOK: u64 = 256;

/// The stack as photons meet it: media 0 (above), 1 .. (the layers), and what lies below.
pub(super) struct Slab<'a> {
    layers: Vec<Matter<'a>>,
    indices: Vec<f64>,
    ground: Ground,
    most_collisions: u64,
    /// Whether anyone asks where light leaves.
    placed: bool,
}

/// A layer.
struct Matter<'a> {
    thickness: f64,
    /// The thickness in m; 0 where nobody asks.
    height: f64,
    albedo: f64,
    /// Optical length from one scattering to the next; infinite where nothing scatters.
    free_path: f64,
    /// Absorbed per optical length.
    loss: f64,
    phase: Sampler<'a>,
}

/// How cosines of scattering are drawn.
enum Sampler<'a> {
    /// One lobe whose closed form loses no digits: `middle - slope / (1 + g s)^2`, s uniform in [-1, 1]
    /// (`henyey1941`).
    Lobe { g: f64, middle: f64, slope: f64 },
    /// Whatever else.
    Any(&'a PhaseFunction),
}

impl<'a> Sampler<'a> {
    fn new(phase: &'a PhaseFunction) -> Self {
        match phase {
            PhaseFunction::HenyeyGreenstein(lobe) if (0.01..0.999).contains(&lobe.asymmetry().abs()) => {
                let g = lobe.asymmetry();
                let squared = g * g;
                Self::Lobe { g, middle: 0.5 * (1.0 + squared) / g, slope: 0.5 * (1.0 - squared).powi(2) / g }
            }
            other => Self::Any(other),
        }
    }

    /// From a number in (0, 1).
    #[inline]
    fn cosine(&self, xi: f64) -> f64 {
        match *self {
            Self::Lobe { g, middle, slope } => {
                let inverse = 1.0 / (1.0 + g * (2.0 * xi - 1.0));
                middle - slope * inverse * inverse
            }
            Self::Any(phase) => phase.sample(xi),
        }
    }
}

/// Light on its way.
pub(super) struct Photon {
    pub medium: usize,
    /// Optical, from the top of the layer.
    pub depth: f64,
    /// Sideways from where it fell in, m; stays 0 where nobody asks.
    pub aside: DVec2,
    /// `z` down; `x` where a beam goes.
    pub direction: DVec3,
    /// Scattering optical length still to go before the next collision.
    pub flight: f64,
    pub weight: f64,
    pub scattered: bool,
}

/// A photon with what limits it.
struct Walk<'g> {
    photon: Photon,
    /// Weight below which roulette is played.
    floor: f64,
    collisions: u64,
    generator: &'g mut Pcg64Mcg,
}

/// The direction beyond a plane, of a relative index that lets it pass.
pub(super) fn refracted(direction: DVec3, eta: f64) -> DVec3 {
    if eta == 1.0 {
        return direction;
    }
    let (x, y) = (direction.x / eta, direction.y / eta);
    DVec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt().copysign(direction.z))
}

impl<'a> Slab<'a> {
    /// `heights` are the thicknesses of the layers in m, where it is to be known how far aside light comes out.
    pub fn new(stack: &Stack, phases: &'a [PhaseFunction], heights: Option<&[f64]>, most_collisions: u64) -> Self {
        let height = |place: usize| heights.and_then(|all| all.get(place)).copied().unwrap_or(0.0);
        let layers = stack.layers.iter().zip(phases).enumerate().map(|(place, (layer, phase))| Matter {
            thickness: layer.optical_thickness,
            height: height(place),
            albedo: layer.albedo,
            free_path: if layer.albedo > f64::MIN_POSITIVE { 1.0 / layer.albedo } else { f64::INFINITY },
            loss: 1.0 - layer.albedo,
            phase: Sampler::new(phase),
        });
        let inner = stack.layers.iter().map(|layer| layer.refractive_index);
        let indices = std::iter::once(stack.above).chain(inner).chain([stack.below]).collect();
        let placed = heights.is_some();
        Self { layers: layers.collect(), indices, ground: stack.ground, most_collisions, placed }
    }

    /// Index of a medium over that of another.
    pub fn relative_index(&self, from: usize, to: usize) -> f64 {
        self.indices[to] / self.indices[from]
    }

    /// Optical thickness of a medium, 0 outside.
    pub fn thickness(&self, medium: usize) -> f64 {
        medium.checked_sub(1).and_then(|layer| self.layers.get(layer)).map_or(0.0, |layer| layer.thickness)
    }

    /// From its start to its end, all of which is counted.
    pub fn follow(&self, photon: Photon, generator: &mut Pcg64Mcg, tally: &mut Tally<'_>) {
        let below = self.indices.len() - 1;
        let floor = LEAST * photon.weight;
        let mut walk = Walk { photon, floor, collisions: 0, generator };
        loop {
            let goes_on = match walk.photon.medium {
                0 => {
                    let Photon { direction, aside, weight, scattered, .. } = walk.photon;
                    tally.count(Slot::Up, weight);
                    if scattered {
                        tally.leave(direction, weight);
                        tally.place(aside.length(), true, weight);
                    } else {
                        tally.count(Slot::UpUnscattered, weight);
                    }
                    false
                }
                medium if medium == below => self.meet_ground(&mut walk, tally),
                medium if self.placed => self.travel::<true>(medium - 1, &mut walk, tally),
                medium => self.travel::<false>(medium - 1, &mut walk, tally),
            };
            // Surfaces count as collisions here, or light between two mirrors would stay for ever.
            walk.collisions += 1;
            if !goes_on {
                break;
            }
            if walk.collisions > self.most_collisions {
                tally.count(Slot::Lost, walk.photon.weight);
                break;
            }
            self.cross(&mut walk.photon, walk.generator);
        }
    }

    /// Through the plane ahead, or back from it.
    fn cross(&self, photon: &mut Photon, generator: &mut Pcg64Mcg) {
        let down = photon.direction.z > 0.0;
        let to = if down { photon.medium + 1 } else { photon.medium - 1 };
        let eta = self.relative_index(photon.medium, to);
        if eta != 1.0 {
            let reflected = dielectric_reflectance(photon.direction.z.abs(), eta);
            if reflected >= 1.0 || uniform(generator) < reflected {
                photon.direction.z = -photon.direction.z;
                return;
            }
            photon.direction = refracted(photon.direction, eta);
        }
        photon.medium = to;
        photon.depth = if down { 0.0 } else { self.thickness(to) };
    }

    /// Below all layers: what the ground takes is counted, what it returns goes on.
    fn meet_ground(&self, walk: &mut Walk<'_>, tally: &mut Tally<'_>) -> bool {
        let share = self.ground.reflectance();
        let photon = &mut walk.photon;
        if photon.scattered {
            tally.leave(photon.direction, photon.weight);
            tally.place(photon.aside.length(), false, photon.weight);
        }
        let taken = photon.weight * (1.0 - share);
        tally.count(Slot::Down, taken);
        if !photon.scattered {
            tally.count(Slot::DownUnscattered, taken);
        }
        photon.weight *= share;
        match self.ground {
            Ground::Black => return false,
            Ground::Mirror(_) => photon.direction.z = -photon.direction.z,
            Ground::Lambertian(_) => {
                let square = 1.0 - uniform(walk.generator);
                let sine = (1.0 - square).sqrt();
                let (x, y) = Turn::get().angle(walk.generator.next_u64() as u32);
                photon.direction = DVec3::new(sine * x, sine * y, -square.sqrt());
                photon.scattered = true;
            }
        }
        walk.survives()
    }

    /// Through a layer to one of its planes; false if the photon ends on the way.
    fn travel<const PLACED: bool>(&self, layer: usize, walk: &mut Walk<'_>, tally: &mut Tally<'_>) -> bool {
        let matter = &self.layers[layer];
        let exponential = Exponential::get();
        let turn = Turn::get();
        // Copies of their own stay in registers.
        let mut generator = walk.generator.clone();
        let Photon { depth: mut z, mut direction, mut flight, .. } = walk.photon;
        // Optical length sideways.
        let mut aside = DVec2::ZERO;
        let mut collisions = 0;
        // Optical length since the last account, and the length at which the next is due.
        let (mut path, mut due) = (0.0, walk.until_floor(matter.loss));
        let out = loop {
            let step = if matter.free_path.is_finite() { flight * matter.free_path } else { f64::INFINITY };
            let next = z + step * direction.z;
            if !(next >= 0.0 && next <= matter.thickness) {
                break true;
            }
            z = next;
            path += step;
            if PLACED {
                aside += direction.truncate() * step;
            }
            let bits = generator.next_u64();
            let mu = matter.phase.cosine(((bits >> 32) as f64 + 0.5) * (1.0 / 4_294_967_296.0));
            direction = scattered(direction, mu, turn.angle(bits as u32));
            flight = exponential.sample(&mut generator);
            collisions += 1;
            if path > due || collisions % LOOK == 0 {
                direction = direction.normalize();
                walk.absorb(layer, matter.loss * path, tally);
                path = 0.0;
                *walk.generator = generator;
                let goes_on = walk.survives();
                generator = walk.generator.clone();
                due = walk.until_floor(matter.loss);
                if !goes_on {
                    break false;
                }
                if walk.collisions + collisions > self.most_collisions {
                    tally.count(Slot::Lost, walk.photon.weight);
                    break false;
                }
            }
        };
        *walk.generator = generator;
        walk.collisions += collisions;
        walk.photon.scattered |= collisions > 0;
        tally.collisions += collisions;
        if !out {
            return false;
        }
        let (edge, room) = if direction.z > 0.0 { (matter.thickness, matter.thickness - z) } else { (0.0, z) };
        let length = if room > 0.0 { room / direction.z.abs() } else { 0.0 };
        walk.absorb(layer, matter.loss * (path + length), tally);
        if PLACED {
            // What is clear to the eye still has a height.
            let across = matter.height * direction.truncate();
            walk.photon.aside += if matter.thickness > 0.0 {
                (aside * matter.height + across * length) / matter.thickness
            } else {
                across / direction.z.abs()
            };
        }
        (walk.photon.depth, walk.photon.direction) = (edge, direction);
        // Where nothing scatters the length may be infinite, but none of the flight is used up.
        walk.photon.flight = if matter.albedo > 0.0 { (flight - matter.albedo * length).max(0.0) } else { flight };
        walk.survives()
    }
}

impl Walk<'_> {
    /// Leaves in a layer what is absorbed over a length of this absorption.
    fn absorb(&mut self, layer: usize, absorption: f64, tally: &mut Tally<'_>) {
        if absorption > 0.0 {
            tally.absorb(layer, self.photon.weight * -(-absorption).exp_m1());
            self.photon.weight *= (-absorption).exp();
        }
    }

    /// Optical length until the weight has sunk to where roulette is played.
    fn until_floor(&self, loss: f64) -> f64 {
        if loss > 0.0 { (self.photon.weight / self.floor).ln().max(0.0) / loss } else { f64::INFINITY }
    }

    /// Russian roulette for light photons.
    fn survives(&mut self) -> bool {
        if self.photon.weight >= self.floor {
            return true;
        }
        let revived = REVIVED * self.floor;
        let lives = uniform(self.generator) * revived < self.photon.weight;
        self.photon.weight = revived;
        lives
    }
}
