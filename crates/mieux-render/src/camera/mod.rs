//! A pinhole camera (frisvad2012, 4.2.1): everything is sharp.

use glam::DVec3;

use crate::geometry::Ray;

/// What can be wrong with a camera.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// Position, target or up-vector is not finite, or they do not span a view.
    #[error("a camera at {position:?} m looking at {target:?} m with {up:?} up has no view")]
    View {
        /// Where it stands, m.
        position: [f64; 3],
        /// Where it looks, m.
        target: [f64; 3],
        /// Its up-vector.
        up: [f64; 3],
    },
    /// The field of view must be above 0 and below 180 degrees.
    #[error("a vertical field of view of {degrees} degrees; it must be above 0 and below 180")]
    FieldOfView {
        /// The offending angle, degrees.
        degrees: f64,
    },
    /// Each side of the picture has 1 to 65535 pixels, and the whole at most 2^28.
    #[error("a picture of {width} x {height} pixels; each side has 1 to 65535, the whole at most 268435456")]
    Resolution {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
}

/// A pinhole camera; pixel (0, 0) is at the top left.
#[derive(Debug, Clone, PartialEq)]
pub struct Pinhole {
    position: DVec3,
    forward: DVec3,
    /// Half the picture's width and height in the plane at distance 1.
    right: DVec3,
    down: DVec3,
    resolution: [u32; 2],
}

impl Pinhole {
    /// A camera at `position` (m) looking at `target` (m), with the vertical field of view in degrees and the
    /// resolution in pixels (width, height).
    ///
    /// # Errors
    /// [`CameraError`] when these define no view.
    pub fn new(
        position: [f64; 3],
        target: [f64; 3],
        up: [f64; 3],
        vertical_field_of_view_degrees: f64,
        resolution: [u32; 2],
    ) -> Result<Self, CameraError> {
        let no_view = CameraError::View { position, target, up };
        let degrees = vertical_field_of_view_degrees;
        if !(degrees > 0.0 && degrees < 180.0) {
            return Err(CameraError::FieldOfView { degrees });
        }
        let [width, height] = resolution;
        let side = 1..=65_535;
        if !(side.contains(&width) && side.contains(&height) && u64::from(width) * u64::from(height) <= 1 << 28) {
            return Err(CameraError::Resolution { width, height });
        }
        let at = DVec3::from_array(position);
        let Some(forward) = (DVec3::from_array(target) - at).try_normalize() else { return Err(no_view) };
        let Some(right) = forward.cross(DVec3::from_array(up)).try_normalize() else { return Err(no_view) };
        if !at.is_finite() {
            return Err(no_view);
        }
        let half = (0.5 * degrees.to_radians()).tan();
        let aspect = f64::from(width) / f64::from(height);
        Ok(Self {
            position: at,
            forward,
            right: right * (half * aspect),
            down: forward.cross(right) * half,
            resolution,
        })
    }

    /// The same camera with the middle of its view moved across the picture by shares of its width (to the right) and height
    /// (down).
    pub fn shifted(mut self, [x, y]: [f64; 2]) -> Self {
        self.forward -= self.right * (2.0 * x) + self.down * (2.0 * y);
        self
    }

    /// Where it stands, m.
    pub fn position(&self) -> DVec3 {
        self.position
    }

    /// Width and height in pixels.
    pub fn resolution(&self) -> [u32; 2] {
        self.resolution
    }

    /// The ray through a point of the picture in pixels: (0, 0) is the top left corner of the top left pixel.
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let [width, height] = self.resolution.map(f64::from);
        let across = self.right * (2.0 * x / width - 1.0) + self.down * (2.0 * y / height - 1.0);
        Ray { origin: self.position, direction: (self.forward + across).normalize() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_of_the_picture() {
        let camera = Pinhole::new([0.0; 3], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], 90.0, [200, 100]).unwrap();
        let top_left = camera.ray(0.0, 0.0).direction;
        assert!((top_left - DVec3::new(-2.0, 1.0, 1.0).normalize()).length() < 1e-12, "{top_left}");
        assert!((camera.ray(100.0, 50.0).direction - DVec3::Y).length() < 1e-12);
        assert!(camera.ray(200.0, 100.0).direction.z < 0.0);
    }

    #[test]
    fn what_is_no_view_is_refused() {
        let up = [0.0, 0.0, 1.0];
        assert!(Pinhole::new([0.0; 3], [0.0; 3], up, 40.0, [4, 4]).is_err());
        assert!(Pinhole::new([0.0; 3], [0.0, 0.0, 1.0], up, 40.0, [4, 4]).is_err());
        assert!(Pinhole::new([f64::NAN; 3], [0.0, 1.0, 0.0], up, 40.0, [4, 4]).is_err());
        for fov in [0.0, 180.0, -1.0, f64::NAN] {
            assert!(Pinhole::new([0.0; 3], [0.0, 1.0, 0.0], up, fov, [4, 4]).is_err());
        }
        for resolution in [[0, 4], [4, 0], [70_000, 1], [65_535, 65_535]] {
            assert!(Pinhole::new([0.0; 3], [0.0, 1.0, 0.0], up, 40.0, resolution).is_err());
        }
    }
}
