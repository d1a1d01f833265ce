//! A tumbler and the liquid in it.

use std::f64::consts::PI;

use super::{GeometryError, Mesh, ProfilePoint, revolution, shapes::positive};

/// A straight drinking glass standing on z = 0 about the z axis, with a thick base and a rounded rim.
///
/// | | |
/// |---|---|
/// | `outer_radius`, `height` | m, > 0 |
/// | `wall` | wall thickness, m, 0 < wall < outer_radius / 2 |
/// | `base` | thickness of the base, m, 0 < base < height / 2 |
/// | `segments` | facets around |
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrinkingGlass {
    /// Radius of the outside, m.
    pub outer_radius: f64,
    /// From the table to the rim, m.
    pub height: f64,
    /// Thickness of the wall, m.
    pub wall: f64,
    /// Thickness of the base, m.
    pub base: f64,
    /// Facets around the axis.
    pub segments: u32,
}

impl Default for DrinkingGlass {
    /// A quarter-litre tumbler: radius 33 mm, height 105 mm, wall 2 mm, base 7 mm.
    fn default() -> Self {
        Self { outer_radius: 0.033, height: 0.105, wall: 0.002, base: 0.007, segments: 96 }
    }
}

/// Longest stretch of the outline between two rings; keeps facets compact, so that the tree stays tight.
const RING_SPACING: f64 = 0.006;
/// Points in a quarter of a rounding.
const ARC: u32 = 6;

impl DrinkingGlass {
    /// A vial of 10 x 27 mm with a wall of 0.8 mm.
    pub fn vial() -> Self {
        Self { outer_radius: 0.005, height: 0.027, wall: 0.0008, base: 0.0012, ..Self::default() }
    }

    /// Inner radius of the wall, m.
    pub fn inner_radius(&self) -> f64 {
        self.outer_radius - self.wall
    }

    /// The closed mesh of the glass.
    ///
    /// # Errors
    /// [`GeometryError::Length`] for sizes outside the ranges of the type, [`GeometryError::Segments`].
    pub fn glass(&self) -> Result<Mesh, GeometryError> {
        self.check()?;
        let (outer, inner, rim) = (self.outer_radius, self.inner_radius(), 0.5 * self.wall);
        let foot = (0.3 * self.base).min(0.1 * outer);
        let corner = self.inner_corner();
        let mut outline = Outline::from(ProfilePoint::smooth(0.0, 0.0));
        outline.arc([outer - foot, foot], foot, -0.5 * PI, 0.0);
        outline.arc([outer - rim, self.height - rim], rim, 0.0, PI);
        outline.arc([inner - corner, self.base + corner], corner, 0.0, -0.5 * PI);
        outline.line_to(ProfilePoint::smooth(0.0, self.base));
        revolution(&outline.points, self.segments)
    }

    /// The liquid that fills the glass up to `level` (m above the table), as a closed mesh.
    ///
    /// Its sides and bottom lie half a wall inside the glass, so that a glass of higher priority decides where the two
    /// meet: exactly on the inner face of the glass, with no gap. Its top is flat and climbs the wall in a meniscus.
    ///
    /// # Errors
    /// [`GeometryError::Length`] for sizes outside the ranges of the type, or a level that does not stay between the
    /// base and the rim by a few millimetres.
    pub fn liquid(&self, level: f64) -> Result<Mesh, GeometryError> {
        self.check()?;
        let (inner, climb) = (self.inner_radius(), self.meniscus());
        let lowest = self.base + self.inner_corner();
        let highest = self.height - self.wall - 1.5 * climb;
        if !(level > lowest && level < highest) {
            let rule = "must stay above the rounded base and below the rim, with room for the meniscus";
            return Err(GeometryError::Length { what: "the level of the liquid", value: level, rule });
        }
        let overlap = 0.5 * self.wall.min(self.base);
        let corner = self.inner_corner() + overlap;
        let side = inner + overlap;
        let mut outline = Outline::from(ProfilePoint::smooth(0.0, self.base - overlap));
        outline.arc([side - corner, self.base - overlap + corner], corner, -0.5 * PI, 0.0);
        // The free surface starts inside the wall, where nobody sees its edge, and meets the wall rising.
        let top = |r: f64| level + climb * (-(inner - r) / (0.6 * climb)).exp().min(1.0);
        outline.line_to(ProfilePoint::crease(side, top(side)));
        for k in 0..16 {
            let r = inner - 4.0 * climb * f64::from(k).powi(2) / 225.0;
            outline.points.push(ProfilePoint::smooth(r, if k == 15 { level } else { top(r) }));
        }
        outline.line_to(ProfilePoint::smooth(0.0, level));
        revolution(&outline.points, self.segments)
    }

    fn check(&self) -> Result<(), GeometryError> {
        positive("the outer radius of the glass", self.outer_radius)?;
        positive("the height of the glass", self.height)?;
        positive("the wall of the glass", self.wall)?;
        positive("the base of the glass", self.base)?;
        let below = |what, value, limit: f64, rule| {
            if value < limit { Ok(()) } else { Err(GeometryError::Length { what, value, rule }) }
        };
        below("the wall of the glass", self.wall, 0.5 * self.outer_radius, "must be below half the radius")?;
        below("the base of the glass", self.base, 0.5 * self.height, "must be below half the height")?;
        below("the outer radius of the glass", self.outer_radius, 100.0, "must be below 100 m")?;
        below("the height of the glass", self.height, 100.0, "must be below 100 m")
    }

    /// Radius of the rounding between the inner wall and the base.
    fn inner_corner(&self) -> f64 {
        (0.15 * self.inner_radius()).min(0.2 * self.height)
    }

    /// Height by which the liquid climbs the wall: about a millimetre for water and milk.
    fn meniscus(&self) -> f64 {
        (0.04 * self.inner_radius()).min(1.2e-3)
    }
}

/// An outline under construction.
struct Outline {
    points: Vec<ProfilePoint>,
}

impl Outline {
    fn from(start: ProfilePoint) -> Self {
        Self { points: vec![start] }
    }

    /// A straight stretch, divided into rings that are not too far apart.
    fn line_to(&mut self, end: ProfilePoint) {
        let start = self.points[self.points.len() - 1];
        let (dr, dz) = (end.r - start.r, end.z - start.z);
        let pieces = (dr.hypot(dz) / RING_SPACING).ceil().clamp(1.0, 100.0) as u32;
        for k in 1..pieces {
            let t = f64::from(k) / f64::from(pieces);
            self.points.push(ProfilePoint::smooth(start.r + t * dr, start.z + t * dz));
        }
        self.points.push(end);
    }

    /// A straight stretch to the start of a circular arc, then the arc; angles from the r axis, rising where the body is
    /// round and falling where it is hollow. The arc's own normals keep the straight stretches beside it flat: averaged
    /// ones would turn the wall below the rim into a lens.
    fn arc(&mut self, [r, z]: [f64; 2], radius: f64, from: f64, to: f64) {
        let pieces = ((to - from).abs() / (0.5 * PI) * f64::from(ARC)).round() as u32;
        for k in 0..=pieces {
            let (sin, cos) = (from + (to - from) * f64::from(k) / f64::from(pieces)).sin_cos();
            let outward = (to - from).signum();
            let normal = Some([outward * cos, outward * sin]);
            let point = ProfilePoint { normal, ..ProfilePoint::smooth(r + radius * cos, z + radius * sin) };
            if k == 0 { self.line_to(point) } else { self.points.push(point) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn glass_and_liquid_are_closed_and_have_sensible_volumes() {
        let glass = DrinkingGlass::default();
        let (body, liquid) = (glass.glass().unwrap(), glass.liquid(0.08).unwrap());
        assert!(body.is_closed() && liquid.is_closed());
        let solid = PI
            * (glass.outer_radius.powi(2) * glass.height - glass.inner_radius().powi(2) * (glass.height - glass.base));
        assert!((body.signed_volume() / solid - 1.0).abs() < 0.05, "{} {solid}", body.signed_volume());
        let filled = PI * (glass.inner_radius() + 0.001).powi(2) * (0.08 - glass.base + 0.001);
        assert!((liquid.signed_volume() / filled - 1.0).abs() < 0.03, "{} {filled}", liquid.signed_volume());
        assert!((body.bounds().1.z - glass.height).abs() < 1e-6 && body.bounds().0.z.abs() < 1e-9);
    }

    #[test]
    fn the_liquid_reaches_half_a_wall_into_the_glass() {
        let glass = DrinkingGlass::default();
        let bounds = glass.liquid(0.08).unwrap().bounds();
        assert!((bounds.1.x - (glass.inner_radius() + 0.5 * glass.wall)).abs() < 1e-6);
        assert!((bounds.0.z - (glass.base - 0.5 * glass.wall)).abs() < 1e-6);
    }

    /// The straight parts of the wall are flat to the eye as well, from the very end of the roundings.
    #[test]
    fn the_wall_has_level_normals() {
        let glass = DrinkingGlass::default();
        let mesh = glass.glass().unwrap();
        let (low, high) = (glass.base + glass.inner_corner() - 1e-7, glass.height - 0.5 * glass.wall + 1e-7);
        for (v, n) in mesh.vertices().iter().zip(mesh.normals().unwrap()) {
            let out = (v[0] * n[0] + v[1] * n[1]).signum();
            if (low..=high).contains(&f64::from(v[2])) {
                assert!(n[2].abs() < 1e-6, "{v:?} {n:?}");
                assert_eq!(out > 0.0, v[0].hypot(v[1]) > 0.032);
            }
        }
    }

    #[test]
    fn impossible_glasses_are_refused() {
        let glass = DrinkingGlass::default();
        for bad in [
            DrinkingGlass { wall: 0.02, ..glass },
            DrinkingGlass { wall: 0.0, ..glass },
            DrinkingGlass { base: 0.06, ..glass },
            DrinkingGlass { height: f64::NAN, ..glass },
            DrinkingGlass { outer_radius: -0.03, ..glass },
            DrinkingGlass { segments: 2, ..glass },
        ] {
            assert!(bad.glass().is_err(), "{bad:?}");
        }
        for level in [0.0, 0.007, 0.104, 0.2, f64::NAN] {
            assert!(glass.liquid(level).is_err(), "{level}");
        }
    }
}
