//! A rectangular window of light with soft edges.

use glam::DVec3;

use super::{LightError, dome::linear};

/// A rectangle of brightness in the plane that touches the sphere of directions at its centre.
///
/// Coordinates in that plane are tangents of angles: a half extent of 1 reaches 45 degrees from the centre. The
/// brightness is full inside and falls linearly to 0 over the outer share `edge` of each half extent.
#[derive(Debug, Clone, PartialEq)]
pub struct SoftBox {
    centre: DVec3,
    across: DVec3,
    up: DVec3,
    half: [f64; 2],
    edge: f64,
    brightness: f64,
}

impl SoftBox {
    /// A box around the direction `centre` (any length; towards the light), with half extents (tangents; horizontal,
    /// vertical), soft share `edge` in [0, 1] and full `brightness` >= 0.
    ///
    /// # Errors
    /// [`LightError`] for a value outside these ranges.
    pub fn new(centre: [f64; 3], half_extents: [f64; 2], edge: f64, brightness: f64) -> Result<Self, LightError> {
        let Some(c) = DVec3::from_array(centre).try_normalize() else {
            return Err(LightError::Direction { direction: centre });
        };
        for value in half_extents {
            if !(value > 0.0 && value.is_finite()) {
                return Err(LightError::Extent { what: "half extent", value, rule: "must be positive and finite" });
            }
        }
        if !(0.0..=1.0).contains(&edge) {
            return Err(LightError::Extent { what: "edge", value: edge, rule: "must lie between 0 and 1" });
        }
        if !(brightness >= 0.0 && brightness.is_finite()) {
            return Err(LightError::Brightness { what: "brightness of a soft box", value: brightness });
        }
        let across = DVec3::Z.cross(c).try_normalize().unwrap_or(DVec3::X);
        Ok(Self { centre: c, across, up: c.cross(across), half: half_extents, edge, brightness })
    }

    /// Profile of the brightness over the tangent plane, in [0, 1], and the cosine from the centre.
    fn profile(&self, direction: DVec3) -> (f64, f64) {
        let cosine = direction.dot(self.centre);
        if cosine <= 0.0 {
            return (0.0, cosine);
        }
        let at = [direction.dot(self.across) / cosine, direction.dot(self.up) / cosine];
        let edge = |k: usize| {
            let from_rim = 1.0 - at[k].abs() / self.half[k];
            if from_rim <= 0.0 { 0.0 } else { (from_rim / self.edge.max(1e-12)).min(1.0) }
        };
        (edge(0) * edge(1), cosine)
    }

    pub(super) fn value(&self, direction: DVec3) -> f64 {
        self.brightness * self.profile(direction).0
    }

    /// Integral of the profile over the tangent plane.
    fn flat_area(&self) -> f64 {
        self.half.iter().map(|h| 2.0 * h * (1.0 - 0.5 * self.edge)).product()
    }

    /// About the brightness integrated over the sphere; used as a weight, so it need not be exact.
    pub(super) fn power(&self) -> f64 {
        let spread = (1.0 + (self.half[0].powi(2) + self.half[1].powi(2)) / 3.0).powf(1.5);
        self.brightness * self.flat_area() / spread
    }

    /// Density of [`Self::sample`] per solid angle: the profile over the plane, turned into solid angle.
    pub(super) fn density(&self, direction: DVec3) -> f64 {
        let (profile, cosine) = self.profile(direction);
        if profile > 0.0 { profile / (self.flat_area() * cosine.powi(3)) } else { 0.0 }
    }

    /// A direction from two uniform numbers, in proportion to the profile over the plane.
    pub(super) fn sample(&self, xi: [f64; 2]) -> DVec3 {
        let coordinate = |k: usize| {
            let (side, u) = if xi[k] < 0.5 { (-1.0, 2.0 * xi[k]) } else { (1.0, 2.0 * xi[k] - 1.0) };
            let flat = (1.0 - self.edge) / (1.0 - 0.5 * self.edge);
            let from_centre = if u < flat {
                u / flat * (1.0 - self.edge)
            } else {
                1.0 - self.edge + self.edge * linear(1.0, 0.0, (u - flat) / (1.0 - flat))
            };
            side * self.half[k] * from_centre
        };
        (self.centre + self.across * coordinate(0) + self.up * coordinate(1)).normalize()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_inside_and_nothing_outside() {
        let light = SoftBox::new([2.0, 0.0, 0.0], [1.0, 0.5], 0.5, 3.0).unwrap();
        assert_eq!(light.value(DVec3::X), 3.0);
        assert_eq!(light.value(-DVec3::X), 0.0);
        assert_eq!(light.value(DVec3::new(1.0, 1.01, 0.0).normalize()), 0.0);
        assert!((light.value(DVec3::new(1.0, 0.75, 0.0).normalize()) - 1.5).abs() < 1e-9);
        assert!((light.value(DVec3::new(1.0, 0.0, 0.375).normalize()) - 1.5).abs() < 1e-9);
    }

    #[test]
    fn bad_boxes_are_refused() {
        assert!(SoftBox::new([0.0; 3], [1.0, 1.0], 0.1, 1.0).is_err());
        assert!(SoftBox::new([1.0; 3], [0.0, 1.0], 0.1, 1.0).is_err());
        assert!(SoftBox::new([1.0; 3], [1.0, 1.0], 1.1, 1.0).is_err());
        assert!(SoftBox::new([1.0; 3], [1.0, 1.0], 0.1, -1.0).is_err());
        assert!(SoftBox::new([1.0; 3], [1.0, 1.0], f64::NAN, 1.0).is_err());
    }
}
