//! Densities over place: cells in bricks, those that are empty left out, with the most that each brick holds.

use glam::{DAffine3, DMat3, DVec3};

use crate::geometry::Ray;

/// Side of a brick, cells. Bricks are also the blocks of constant majorant.
const BRICK: usize = 8;
/// Cells of a brick.
const CELLS: usize = BRICK * BRICK * BRICK;
/// Stands for a brick of zeros.
const EMPTY: u32 = u32::MAX;

/// How values between the middles of cells are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Filter {
    /// Linear along each axis, constant beyond the outermost middles.
    #[default]
    Trilinear,
    /// The value of the cell.
    Nearest,
}

/// Where a grid lies: the corner (m) of its first cell, and the edges (m) of the whole along its three axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Corner of the first cell, m.
    pub corner: [f64; 3],
    /// Edges of the whole along its first, second and third axis, m.
    pub edges: [[f64; 3]; 3],
}

/// What can be wrong with a grid.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GridError {
    /// Each side has between 1 and 4096 cells, and the values are as many as the cells.
    #[error("a grid of {size:?} cells with {values} values; each side has 1 to 4096 cells, each cell one value")]
    Size {
        /// Cells along each axis.
        size: [usize; 3],
        /// How many values were given.
        values: usize,
    },
    /// A density is finite and not negative.
    #[error("the density of cell {cell:?} is {value}; densities are finite and not negative")]
    Value {
        /// Which cell.
        cell: [usize; 3],
        /// Its value.
        value: f32,
    },
    /// The edges must span a volume.
    #[error("a grid with the edges {edges:?} m has no volume")]
    Flat {
        /// The offending edges.
        edges: [[f64; 3]; 3],
    },
}

/// Densities in a box of cells, the first axis running fastest; nothing lies outside.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    size: [usize; 3],
    bricks: [usize; 3],
    /// First value of each brick, or [`EMPTY`].
    starts: Vec<u32>,
    values: Vec<f32>,
    /// The most that interpolation can find in each brick.
    most: Vec<f32>,
    filter: Filter,
    /// From places (m) to cells.
    to_cells: DAffine3,
}

impl Grid {
    /// Takes the numbers of cells along each axis, one value per cell (first axis fastest), how to interpolate, and where
    /// the box lies.
    ///
    /// # Errors
    /// [`GridError`].
    pub fn new(size: [usize; 3], values: &[f32], filter: Filter, placement: &Placement) -> Result<Self, GridError> {
        let count = size.iter().try_fold(1usize, |n, &s| n.checked_mul(s)).unwrap_or(0);
        if size.iter().any(|s| !(1..=4096).contains(s)) || count != values.len() {
            return Err(GridError::Size { size, values: values.len() });
        }
        let cell = |i: usize| [i % size[0], i / size[0] % size[1], i / (size[0] * size[1])];
        if let Some(i) = values.iter().position(|v| !(*v >= 0.0 && v.is_finite())) {
            return Err(GridError::Value { cell: cell(i), value: values[i] });
        }
        let edges = placement.edges.map(DVec3::from_array);
        let scaled: [DVec3; 3] = std::array::from_fn(|k| edges[k] / size[k] as f64);
        let to_world = DAffine3 {
            matrix3: DMat3::from_cols(scaled[0], scaled[1], scaled[2]),
            translation: DVec3::from_array(placement.corner),
        };
        let volume = edges[0].dot(edges[1].cross(edges[2])).abs();
        let to_cells = to_world.inverse();
        if !(volume > 0.0 && volume.is_finite() && to_cells.is_finite()) {
            return Err(GridError::Flat { edges: placement.edges });
        }
        let bricks = size.map(|s| s.div_ceil(BRICK));
        let mut grid = Self { size, bricks, starts: vec![], values: vec![], most: vec![], filter, to_cells };
        grid.fill(values);
        Ok(grid)
    }

    fn fill(&mut self, values: &[f32]) {
        let [nx, ny, nz] = self.size;
        let value = |x: usize, y: usize, z: usize| values[(z.min(nz - 1) * ny + y.min(ny - 1)) * nx + x.min(nx - 1)];
        let [bx, by, bz] = self.bricks;
        // Interpolation reaches half a cell beyond a brick: one cell more on each side.
        let reach = usize::from(self.filter == Filter::Trilinear);
        for (k, j, i) in (0..bz).flat_map(|k| (0..by).flat_map(move |j| (0..bx).map(move |i| (k, j, i)))) {
            let low = [i, j, k].map(|b| b * BRICK);
            let mut brick = [0f32; CELLS];
            for (c, v) in brick.iter_mut().enumerate() {
                *v = value(low[0] + c % BRICK, low[1] + c / BRICK % BRICK, low[2] + c / (BRICK * BRICK));
            }
            let range = |k: usize| low[k].saturating_sub(reach)..(low[k] + BRICK + reach).min(self.size[k]);
            let mut most = 0f32;
            for z in range(2) {
                for y in range(1) {
                    let row = (z * ny + y) * nx;
                    most = values[row..row + nx][range(0)].iter().fold(most, |m, v| m.max(*v));
                }
            }
            self.most.push(most);
            if brick.iter().any(|v| *v > 0.0) {
                self.starts.push(self.values.len() as u32 / CELLS as u32);
                self.values.extend(brick);
            } else {
                self.starts.push(EMPTY);
            }
        }
    }

    /// Numbers of cells along each axis.
    pub fn size(&self) -> [usize; 3] {
        self.size
    }

    /// Whether another lies in the same place, cell on cell.
    pub(crate) fn lies_as(&self, other: &Self) -> bool {
        self.size == other.size && self.to_cells == other.to_cells
    }

    /// A ray in the units of the grid: a distance along it stays in metres.
    pub(crate) fn local_ray(&self, ray: &Ray) -> (DVec3, DVec3) {
        (self.to_cells.transform_point3(ray.origin), self.to_cells.transform_vector3(ray.direction))
    }

    #[inline]
    fn cell(&self, x: usize, y: usize, z: usize) -> f32 {
        let brick = (z / BRICK * self.bricks[1] + y / BRICK) * self.bricks[0] + x / BRICK;
        let start = self.starts[brick];
        if start == EMPTY {
            return 0.0;
        }
        self.values[start as usize * CELLS + (z % BRICK * BRICK + y % BRICK) * BRICK + x % BRICK]
    }

    /// The density at a place in the units of the grid; 0 outside.
    #[inline]
    pub(crate) fn at(&self, place: DVec3) -> f64 {
        let p = place.to_array();
        if (0..3).any(|k| !(p[k] >= 0.0 && p[k] <= self.size[k] as f64)) {
            return 0.0;
        }
        if self.filter == Filter::Nearest {
            let [x, y, z]: [usize; 3] = std::array::from_fn(|k| (p[k] as usize).min(self.size[k] - 1));
            return f64::from(self.cell(x, y, z));
        }
        let mut low = [0usize; 3];
        let mut high = [0usize; 3];
        let mut t = [0f64; 3];
        for k in 0..3 {
            let from_middle = (p[k] - 0.5).clamp(0.0, (self.size[k] - 1) as f64);
            low[k] = from_middle as usize;
            high[k] = (low[k] + 1).min(self.size[k] - 1);
            t[k] = from_middle - low[k] as f64;
        }
        let value = |x, y, z| f64::from(self.cell(x, y, z));
        let row = |y, z| value(low[0], y, z) * (1.0 - t[0]) + value(high[0], y, z) * t[0];
        let sheet = |z| row(low[1], z) * (1.0 - t[1]) + row(high[1], z) * t[1];
        sheet(low[2]) * (1.0 - t[2]) + sheet(high[2]) * t[2]
    }

    /// The most that [`Self::at`] gives anywhere in a block.
    #[inline]
    pub(crate) fn most(&self, block: usize) -> f64 {
        f64::from(self.most[block])
    }

    /// Goes through the blocks along a ray up to a length (m), in order: distances at which each is entered and left, and
    /// the block, or `None` outside the grid. Ends early when `visit` says so.
    pub(crate) fn blocks(&self, ray: &Ray, length: f64, mut visit: impl FnMut(f64, f64, Option<usize>) -> bool) {
        let (origin, direction) = self.local_ray(ray);
        let (o, d) = (origin.to_array(), direction.to_array());
        let (mut enter, mut leave) = (0f64, length);
        for k in 0..3 {
            let size = self.size[k] as f64;
            if d[k] == 0.0 {
                if !(o[k] >= 0.0 && o[k] <= size) {
                    leave = -1.0;
                }
                continue;
            }
            let (a, b) = (-o[k] / d[k], (size - o[k]) / d[k]);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        if leave <= enter {
            visit(0.0, length, None);
            return;
        }
        if enter > 0.0 && !visit(0.0, enter, None) {
            return;
        }
        if self.walk(o, d, enter, leave, &mut visit) && leave < length {
            visit(leave, length, None);
        }
    }

    /// Block by block between two distances (m) inside the grid.
    fn walk(
        &self,
        o: [f64; 3],
        d: [f64; 3],
        enter: f64,
        leave: f64,
        visit: &mut impl FnMut(f64, f64, Option<usize>) -> bool,
    ) -> bool {
        const SIDE: f64 = BRICK as f64;
        let mut block: [usize; 3] =
            std::array::from_fn(|k| (((o[k] + d[k] * enter) / SIDE).max(0.0) as usize).min(self.bricks[k] - 1));
        let wall = |k: usize, b: usize| {
            let at = if d[k] > 0.0 { (b + 1) as f64 } else { b as f64 };
            if d[k] == 0.0 { f64::INFINITY } else { (at * SIDE - o[k]) / d[k] }
        };
        let mut next: [f64; 3] = std::array::from_fn(|k| wall(k, block[k]));
        let mut at = enter;
        loop {
            let axis = if next[0] <= next[1] && next[0] <= next[2] {
                0
            } else if next[1] <= next[2] {
                1
            } else {
                2
            };
            let end = next[axis].clamp(at, leave);
            let index = (block[2] * self.bricks[1] + block[1]) * self.bricks[0] + block[0];
            if end > at && !visit(at, end, Some(index)) {
                return false;
            }
            at = end;
            if at >= leave {
                return true;
            }
            if d[axis] > 0.0 {
                if block[axis] + 1 == self.bricks[axis] {
                    return true;
                }
                block[axis] += 1;
            } else {
                if block[axis] == 0 {
                    return true;
                }
                block[axis] -= 1;
            }
            next[axis] = wall(axis, block[axis]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn ramp() -> Grid {
        let size = [19, 9, 12];
        let values: Vec<f32> =
            (0..size[0] * size[1] * size[2]).map(|i| if i % size[0] < 8 { 0.0 } else { (i % 7) as f32 }).collect();
        let placement =
            Placement { corner: [1.0, 2.0, 3.0], edges: [[0.0, 2.0, 0.0], [1.5, 0.0, 0.3], [0.0, 0.0, 1.0]] };
        Grid::new(size, &values, Filter::Trilinear, &placement).unwrap()
    }

    #[test]
    fn the_blocks_tile_the_ray_and_bound_what_is_in_them() {
        let grid = ramp();
        proptest!(|(from in prop::array::uniform3(-1.0..5.0f64), to in prop::array::uniform3(-1.0..5.0f64))| {
            let (from, to) = (DVec3::from_array(from), DVec3::from_array(to));
            let Some(direction) = (to - from).try_normalize() else { return Ok(()) };
            let (ray, length) = (Ray { origin: from, direction }, (to - from).length());
            let mut at = 0.0;
            let mut seen = 0.0;
            grid.blocks(&ray, length, |start, end, block| {
                assert!((start - at).abs() < 1e-9 && end >= start);
                at = end;
                for i in 0..5 {
                    let t = start + (end - start) * (f64::from(i) + 0.5) / 5.0;
                    let value = grid.at(grid.to_cells.transform_point3(ray.at(t)));
                    seen += value;
                    match block {
                        Some(b) => assert!(value <= grid.most(b) + 1e-6),
                        None => assert!(value == 0.0),
                    }
                }
                true
            });
            prop_assert!((at - length).abs() < 1e-9 * length.max(1.0), "{} {}", at, length);
            prop_assert!(seen >= 0.0);
        });
    }

    #[test]
    fn values_are_those_of_the_cells_at_their_middles() {
        let placement = Placement { corner: [0.0; 3], edges: [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]] };
        let values: Vec<f32> = (0..8).map(|v| v as f32).collect();
        let grid = Grid::new([2, 2, 2], &values, Filter::Trilinear, &placement).unwrap();
        assert_eq!(grid.at(DVec3::new(1.5, 0.5, 0.5)), 1.0);
        assert_eq!(grid.at(DVec3::new(1.0, 1.0, 1.0)), 3.5);
        assert_eq!(grid.at(DVec3::new(0.1, 0.1, 2.1)), 0.0);
        assert!(Grid::new([2, 2, 2], &values[1..], Filter::Nearest, &placement).is_err());
        let mut bad = values;
        bad[3] = f32::NAN;
        assert!(matches!(
            Grid::new([2, 2, 2], &bad, Filter::Nearest, &placement),
            Err(GridError::Value { cell: [1, 1, 0], .. })
        ));
    }
}
