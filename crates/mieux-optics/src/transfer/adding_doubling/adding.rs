//! Layers, planes and the ground together, from the ground up.

use std::f64::consts::PI;

use pulp::Simd;

use super::algebra::eliminate;
use super::layer::{Slab, THINNEST};
use super::table::Table;
use crate::lanes::{LaneArray, MAX_LANES, Re};
use crate::transfer::Ground;
use crate::transfer::discrete_ordinates::matrix::{
    Matrix, add_scaled, dot, multiply, product, scale, symmetric_product_into,
};
use crate::transfer::discrete_ordinates::plan::Plan;

/// What all that lies below some level does to light: amplitudes of streams.
pub(super) struct Total<S: Simd> {
    /// Sent back up.
    reflection: Matrix<S>,
    /// Flux into the ground, or the half-space below, per amplitude of each stream.
    passing: Vec<Re<S>>,
    /// Of the streams at the level.
    roots: Vec<Re<S>>,
    /// The least pivot of each layer, from the top.
    least: Vec<LaneArray>,
}

impl<S: Simd> Total<S> {
    /// Of whole stacks, seen from above.
    #[inline(always)]
    pub fn of(simd: S, plans: &[&Plan; MAX_LANES], beams: &[f64]) -> Self {
        let first = plans[0];
        let mut tables = Vec::with_capacity(first.frame.media.len());
        for medium in 0..first.frame.media.len() {
            tables.push(Table::new(simd, plans, medium, beams));
        }
        let mut total = Self::ground(simd, plans, &tables[first.frame.below]);
        for j in (0..=first.layers.len()).rev() {
            let above = if j == 0 { first.frame.above } else { first.layers[j - 1].medium };
            if first.frame.planes[j].resistance.is_some() {
                total.cross(simd, plans, j, beams, &tables[above]);
            }
            if j > 0 {
                total.add(simd, plans, j - 1, &tables[above]);
            }
        }
        total.least.reverse();
        total
    }

    #[inline(always)]
    fn ground(simd: S, plans: &[&Plan; MAX_LANES], table: &Table<S>) -> Self {
        let zero = Re::splat(simd, 0.0);
        let n = table.len();
        let (mut mirror, mut diffuse) = ([0.0; MAX_LANES], [0.0; MAX_LANES]);
        for (lane, plan) in plans.iter().enumerate() {
            match plan.stack.ground {
                Ground::Black => {}
                Ground::Lambertian(share) => diffuse[lane] = share,
                Ground::Mirror(share) => mirror[lane] = share,
            }
        }
        let (mirror, diffuse) = (Re::load(simd, &mirror), Re::load(simd, &diffuse));
        let kept = Re::splat(simd, 2.0 * PI) * (Re::splat(simd, 1.0) - mirror - diffuse);
        let roots = table.roots.clone();
        let mixing = diffuse / dot(&roots, &roots, zero);
        let mut reflection = Matrix::zeros(simd, n, n);
        for i in 0..n {
            let factor = mixing * roots[i];
            add_scaled(reflection.row_mut(i), factor, &roots);
            reflection.data[i * n + i] = reflection.data[i * n + i] + mirror;
        }
        let mut passing = roots.clone();
        scale(&mut passing, kept);
        Self { reflection, passing, roots, least: Vec::new() }
    }

    /// A layer on top.
    #[inline(always)]
    fn add(&mut self, simd: S, plans: &[&Plan; MAX_LANES], layer: usize, table: &Table<S>) {
        let scaled = |lane: usize| &plans[lane].layers[layer];
        let clear = |lane: usize| scaled(lane).albedo == 0.0 || scaled(lane).thickness < THINNEST;
        if (0..MAX_LANES).all(clear) {
            self.least.push([1.0; MAX_LANES]);
            let mut passes = Vec::with_capacity(table.len());
            for cosine in &table.cosines {
                let cosines = cosine.lanes();
                let lanes: LaneArray = std::array::from_fn(|lane| (-scaled(lane).thickness / cosines[lane]).exp());
                passes.push(Re::load(simd, &lanes));
            }
            for i in 0..passes.len() {
                let factor = passes[i];
                scale(self.reflection.row_mut(i), factor);
                multiply(self.reflection.row_mut(i), &passes);
            }
            multiply(&mut self.passing, &passes);
            return;
        }
        let slab = Slab::new(simd, plans, layer, table);
        self.least.push(slab.least.lanes());
        let zero = Re::splat(simd, 0.0);
        let n = table.len();
        // Down at the plane below the layer: S a, with S = (1 - R R_below)^-1 T.
        let mut returned = product(simd, &slab.reflection, &self.reflection);
        scale(&mut returned.data, Re::splat(simd, -1.0));
        for i in 0..n {
            returned.data[i * n + i] = returned.data[i * n + i] + Re::splat(simd, 1.0);
        }
        let mut down = slab.transmission.clone();
        eliminate(&mut returned, &mut down, zero);
        self.pass(&down, zero);
        let up = product(simd, &self.reflection, &down);
        let mut transposed = Matrix::zeros(simd, n, n);
        for i in 0..n {
            for j in 0..n {
                transposed.data[j * n + i] = up.data[i * n + j];
            }
        }
        symmetric_product_into(&slab.transmission, &transposed, zero, &mut self.reflection);
        for (sum, own) in self.reflection.data.iter_mut().zip(&slab.reflection.data) {
            *sum = *sum + *own;
        }
    }

    /// What passes, seen from a level from which `down` leads here.
    #[inline(always)]
    fn pass(&mut self, down: &Matrix<S>, zero: Re<S>) {
        let mut passing = vec![zero; down.columns];
        for (i, share) in self.passing.iter().enumerate() {
            add_scaled(&mut passing, *share, down.row(i));
        }
        self.passing = passing;
    }

    /// A plane that refracts. Streams that exist on one side only are reflected totally there.
    #[inline(always)]
    fn cross(&mut self, simd: S, plans: &[&Plan; MAX_LANES], plane: usize, beams: &[f64], above: &Table<S>) {
        let (zero, one) = (Re::splat(simd, 0.0), Re::splat(simd, 1.0));
        let (below_count, above_count) = (self.reflection.columns, above.len());
        let common = below_count.min(above_count);
        let mut mirrors = vec![one; below_count.max(above_count)];
        for (i, mirror) in mirrors.iter_mut().enumerate().take(common) {
            let lanes: LaneArray = std::array::from_fn(|lane| {
                let plan = plans[lane];
                let sides = &plan.frame.planes[plane];
                match beams.get(i) {
                    Some(cosine) => sides.reflectance(*cosine, plan.frame.media[plan.frame.above].index),
                    // From 2 R / (1 - R).
                    None => sides.resistance.as_ref().map_or(0.0, |r| {
                        let resistance = r[i - beams.len()];
                        if resistance.is_finite() { resistance / (2.0 + resistance) } else { 1.0 }
                    }),
                }
            });
            *mirror = Re::load(simd, &lanes);
        }
        let mut returned = Matrix::zeros(simd, below_count, below_count);
        let mut down = Matrix::zeros(simd, below_count, above_count);
        for (i, mirror) in mirrors.iter().enumerate().take(below_count) {
            add_scaled(returned.row_mut(i), zero - *mirror, self.reflection.row(i));
            returned.data[i * below_count + i] = returned.data[i * below_count + i] + one;
            if i < common {
                down.data[i * above_count + i] = one - *mirror;
            }
        }
        eliminate(&mut returned, &mut down, zero);
        self.pass(&down, zero);
        let up = product(simd, &self.reflection, &down);
        let mut reflection = Matrix::zeros(simd, above_count, above_count);
        for (i, mirror) in mirrors.iter().enumerate().take(above_count) {
            if i < common {
                add_scaled(reflection.row_mut(i), one - *mirror, up.row(i));
            }
            reflection.data[i * above_count + i] = reflection.data[i * above_count + i] + *mirror;
        }
        self.reflection = reflection;
        self.roots = above.roots.clone();
    }

    /// The first layer whose moments are not of a phase function.
    #[inline(always)]
    pub fn unphysical(&self, lanes: usize) -> Option<usize> {
        self.least.iter().position(|least| !least[..lanes].iter().all(|least| *least > 0.0))
    }

    /// Shares sent back and passed of the light of one beam.
    #[inline(always)]
    pub fn of_beam(&self, simd: S, beam: usize) -> [LaneArray; 2] {
        let zero = Re::splat(simd, 0.0);
        let inverse = Re::splat(simd, 1.0 / (2.0 * PI)) / self.roots[beam];
        let mut up = zero;
        for (i, root) in self.roots.iter().enumerate() {
            up = root.mul_add(self.reflection.row(i)[beam], up);
        }
        [(up / self.roots[beam]).lanes(), (self.passing[beam] * inverse).lanes()]
    }

    /// The same of equal radiance from all directions.
    #[inline(always)]
    pub fn of_diffuse(&self, simd: S, beams: usize) -> [LaneArray; 2] {
        let zero = Re::splat(simd, 0.0);
        let mut falling = self.roots.clone();
        falling[..beams].fill(zero);
        let flux = dot(&falling, &falling, zero);
        let mut up = zero;
        for (i, root) in self.roots.iter().enumerate() {
            up = root.mul_add(dot(self.reflection.row(i), &falling, zero), up);
        }
        let passing = dot(&self.passing, &falling, zero) / Re::splat(simd, 2.0 * PI);
        [(up / flux).lanes(), (passing / flux).lanes()]
    }
}
