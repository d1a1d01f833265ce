//! What happened on the way.

use std::ops::AddAssign;

/// Counts over all paths.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Statistics {
    /// Paths started.
    pub paths: u64,
    /// Scattering events inside media.
    pub collisions: u64,
    /// Surfaces met.
    pub surfaces: u64,
    /// Paths given up: a cap on their length, or a leak through a mesh. They count as dark; should be next to none.
    pub lost: u64,
    /// Surfaces met from a side on which the ray should not have been, at edges; ignored one by one.
    pub inconsistencies: u64,
}

impl AddAssign for Statistics {
    fn add_assign(&mut self, other: Self) {
        self.paths += other.paths;
        self.collisions += other.collisions;
        self.surfaces += other.surfaces;
        self.lost += other.lost;
        self.inconsistencies += other.inconsistencies;
    }
}
