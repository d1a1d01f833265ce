//! Where things stand: affine transforms of points written as columns.

/// A 4 by 4 matrix, row by row, that takes points written as columns `(x, y, z, 1)` from an object's frame to the world's.
/// Lengths are metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transform(pub [[f64; 4]; 4]);

impl Default for Transform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Transform {
    /// Leaves everything where it is.
    pub const IDENTITY: Self =
        Self([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]);

    /// Moves by a vector.
    pub fn translate(by: [f64; 3]) -> Self {
        let mut m = Self::IDENTITY;
        for (row, t) in m.0.iter_mut().zip(by) {
            row[3] = t;
        }
        m
    }

    /// Stretches along the axes.
    pub fn scale(by: [f64; 3]) -> Self {
        let mut m = Self::IDENTITY;
        for (i, s) in by.into_iter().enumerate() {
            m.0[i][i] = s;
        }
        m
    }

    /// Turns about an axis through the origin, counterclockwise when the axis points at the viewer; `None` for an axis of
    /// no length. The angle is in radians.
    pub fn rotate(axis: [f64; 3], angle: f64) -> Option<Self> {
        let [x, y, z] = normalise(axis)?;
        let (s, c) = angle.sin_cos();
        let k = 1.0 - c;
        Some(Self([
            [k * x * x + c, k * x * y - s * z, k * x * z + s * y, 0.0],
            [k * x * y + s * z, k * y * y + c, k * y * z - s * x, 0.0],
            [k * x * z - s * y, k * y * z + s * x, k * z * z + c, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ]))
    }

    /// The frame at `origin` whose +z looks at `target` and whose +y is as near `up` as may be; its +x then points to the
    /// left of what is seen. `None` where `origin` is `target` or `up` lies along the line of sight.
    pub fn look_at(origin: [f64; 3], target: [f64; 3], up: [f64; 3]) -> Option<Self> {
        let z = normalise(std::array::from_fn(|i| target[i] - origin[i]))?;
        let x = normalise(cross(up, z)).filter(|_| normalise(up).is_some_and(|up| norm(cross(up, z)) > 1e-9))?;
        let y = cross(z, x);
        let mut m = Self::IDENTITY;
        for i in 0..3 {
            m.0[i] = [x[i], y[i], z[i], origin[i]];
        }
        Some(m)
    }

    /// First `self`, then `next`.
    #[must_use]
    pub fn then(&self, next: &Self) -> Self {
        let mut m = [[0.0; 4]; 4];
        for (i, row) in m.iter_mut().enumerate() {
            for (j, cell) in row.iter_mut().enumerate() {
                *cell = (0..4).map(|k| next.0[i][k] * self.0[k][j]).sum();
            }
        }
        Self(m)
    }

    /// Where a point goes.
    pub fn point(&self, p: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| self.0[i][3] + (0..3).map(|k| self.0[i][k] * p[k]).sum::<f64>())
    }

    /// Where a direction goes; its length changes with the scale.
    pub fn vector(&self, v: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| (0..3).map(|k| self.0[i][k] * v[k]).sum())
    }

    /// By how much volumes grow; negative for a mirrored frame.
    pub fn determinant(&self) -> f64 {
        let column = |j: usize| [self.0[0][j], self.0[1][j], self.0[2][j]];
        dot(column(0), cross(column(1), column(2)))
    }

    /// Whether every number is finite, the last row is `0 0 0 1`, and no direction is flattened away.
    pub fn is_affine_and_invertible(&self) -> bool {
        let finite = self.0.iter().flatten().all(|v| v.is_finite());
        let d = self.determinant();
        finite && self.0[3] == [0.0, 0.0, 0.0, 1.0] && d.is_finite() && d != 0.0
    }
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn norm(v: [f64; 3]) -> f64 {
    dot(v, v).sqrt()
}

pub(crate) fn normalise(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = norm(v);
    (length.is_finite() && length > 0.0).then(|| v.map(|c| c / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: [f64; 3], b: [f64; 3]) -> bool {
        a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
    }

    #[test]
    fn steps_follow_each_other() {
        let both = Transform::scale([2.0, 2.0, 2.0]).then(&Transform::translate([1.0, 0.0, 0.0]));
        assert!(near(both.point([1.0, 1.0, 1.0]), [3.0, 2.0, 2.0]));
        assert!(near(both.vector([1.0, 1.0, 1.0]), [2.0, 2.0, 2.0]));
        assert!((both.determinant() - 8.0).abs() < 1e-12);
    }

    #[test]
    fn turning_is_counterclockwise() {
        let quarter = Transform::rotate([0.0, 0.0, 2.0], std::f64::consts::FRAC_PI_2).unwrap();
        assert!(near(quarter.point([1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]));
        assert!(Transform::rotate([0.0; 3], 1.0).is_none());
    }

    #[test]
    fn the_camera_looks_along_z_with_x_to_its_left() {
        let pose = Transform::look_at([0.0, 0.0, 5.0], [0.0; 3], [0.0, 1.0, 0.0]).unwrap();
        assert!(near(pose.vector([0.0, 0.0, 1.0]), [0.0, 0.0, -1.0]));
        assert!(near(pose.vector([0.0, 1.0, 0.0]), [0.0, 1.0, 0.0]));
        assert!(near(pose.vector([1.0, 0.0, 0.0]), [-1.0, 0.0, 0.0]));
        assert!((pose.determinant() - 1.0).abs() < 1e-12);
        assert!(Transform::look_at([0.0; 3], [0.0, 2.0, 0.0], [0.0, 1.0, 0.0]).is_none());
        assert!(Transform::look_at([1.0; 3], [1.0; 3], [0.0, 1.0, 0.0]).is_none());
    }
}
