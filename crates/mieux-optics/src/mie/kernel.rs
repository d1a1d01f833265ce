//! What the series of a homogeneous sphere is made of, eight spheres abreast.
//!
//! With `psi = z j_n`, `chi = -z y_n` and `zeta = psi - i chi` of the host's size parameter `x`, and with `p` any multiple
//! of `psi_n(y)` inside the particle, the coefficients are `N / (N - i Y)` where
//!
//! - `N_b = psi_{n+1} p_n / m - psi_n p_{n+1} = M_n` for the magnetic one, and
//! - `N_a = M_{n+1} - (n + 1) kappa psi_n p_n` for the electric one, with `kappa = (1 - 1/m^2) / x`;
//! - `Y` is the same in `chi`.
//!
//! Since `M_{n-1} = M_{n+1} - (2n + 1) kappa psi_n p_n`, every numerator is a plain sum of products, each with the contrast
//! of the particle as a factor: what cancels between particle and host never appears. Nothing is divided but once per
//! order, for both coefficients; and as `p` may have any scale, no recurrence needs a division at all.
//! Source: eq 9-10 of `frisvad2007`, rearranged.

use pulp::Simd;

use super::host::{Fraction, Host};
use super::weights::Weight;
use crate::lanes::{Cx, LaneArray, Re, Wave};

/// Spheres abreast, in the numbers that the series is made of.
///
/// Aligned as registers are, and with it the stack where the series runs: registers that are put by there would else
/// straddle lines of the cache.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Group {
    /// Vacuum wave number times radius.
    pub k0r: LaneArray,
    pub host_re: LaneArray,
    pub host_im: LaneArray,
    pub particle_re: LaneArray,
    pub particle_im: LaneArray,
    /// Largest order that any of them needs.
    pub order: usize,
    /// Order from which downward recurrences start so that their start is forgotten at `order`: host, particle.
    pub start: [usize; 2],
    /// Smallest modulus of any size parameter, in the host or inside.
    pub smallest: f64,
}

/// The coefficients of one order, each divided by `exp(-2 i x)` when the host's waves are scaled.
#[derive(Clone, Copy)]
pub(super) struct Term<S: Simd> {
    pub a: Cx<S>,
    pub b: Cx<S>,
    /// `|a|^2 + |b|^2`.
    pub square: Re<S>,
    /// `Re a - |a|^2 + Re b - |b|^2`, free of cancellation; of no meaning when the host's waves are scaled.
    pub loss: Re<S>,
}

/// Derivatives of the coefficients of one order by the size parameters in the host and inside the particle, in this
/// order, divided as the coefficients are.
#[derive(Clone, Copy)]
pub(super) struct Slopes<S: Simd> {
    pub a: [Cx<S>; 2],
    pub b: [Cx<S>; 2],
}

/// Takes the coefficients, order by order from 1.
pub(super) trait Sink<S: Simd> {
    /// Whether derivatives are wanted; only the downward series gives them.
    const SLOPES: bool = false;
    /// Called before `take` with the derivatives of the same order.
    fn take_slopes(&mut self, _: Slopes<S>) {}
    fn take(&mut self, weight: &Weight, term: Term<S>);
    /// Called every few hundred orders: a place to add up partial sums.
    fn pause(&mut self) {}
}

/// What stays the same from order to order.
pub(super) struct Constants<S: Simd, H: Host<S>> {
    pub simd: S,
    pub x: H::Wave,
    pub inverse_x: H::Wave,
    pub y: Cx<S>,
    pub inverse_y: Cx<S>,
    pub inverse_m: Cx<S>,
    pub kappa: Cx<S>,
}

impl<S: Simd, H: Host<S>> Constants<S, H> {
    #[inline(always)]
    pub fn new(simd: S, group: &Group) -> Self {
        let load = |lanes| Re::load(simd, lanes);
        let k0r = load(&group.k0r);
        let host = Cx { re: load(&group.host_re), im: load(&group.host_im) };
        let particle = Cx { re: load(&group.particle_re), im: load(&group.particle_im) };
        let x = H::size_parameter(k0r, host);
        let y = k0r.times(particle);
        let (inverse_m, contrast) = contrast(host, particle);
        let inverse_x = x.recip();
        Self { simd, x, inverse_x, y, inverse_y: y.recip(), inverse_m, kappa: inverse_x.times(contrast) }
    }

    #[inline(always)]
    pub fn real(&self, value: f64) -> Re<S> {
        Re::splat(self.simd, value)
    }
}

/// `1 / m` and `1 - 1 / m^2` of a particle in a host.
#[inline(always)]
pub(super) fn contrast<S: Simd>(host: Cx<S>, particle: Cx<S>) -> (Cx<S>, Cx<S>) {
    let size = particle.norm_sqr().recip();
    let over = |z: Cx<S>| Cx { re: z.dot(particle) * size, im: z.cross(particle) * size };
    // 1 - 1/m^2 = e (2 - e) with e = 1 - 1/m, part by part so that neither loses digits to the other.
    let inverse_m = over(host);
    let e = over(particle - host);
    let contrast = Cx {
        re: e.im.mul_add(e.im, e.re * (e.re.same(2.0) - e.re)),
        im: e.re.same(-2.0) * inverse_m.re * inverse_m.im,
    };
    (inverse_m, contrast)
}

/// Both coefficients of one order, electric and magnetic, from one division.
#[inline(always)]
pub(super) fn divide<S: Simd>(a: Fraction<S>, b: Fraction<S>) -> Term<S> {
    let both = (a.below * b.below).recip();
    let (under_a, under_b) = (both * b.below, both * a.below);
    Term {
        a: a.over.scale(under_a),
        b: b.over.scale(under_b),
        square: a.square.mul_add(under_a, b.square * under_b),
        loss: a.loss.mul_add(under_a, b.loss * under_b),
    }
}
