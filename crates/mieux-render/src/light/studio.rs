//! A photographer's studio: soft light all around, and soft boxes.

use glam::DVec3;

use super::{Dome, LightError, SoftBox};

/// A dome and any number of soft boxes; their brightness adds up.
#[derive(Debug, Clone, PartialEq)]
pub struct Studio {
    dome: Dome,
    boxes: Vec<SoftBox>,
    /// Cumulative chance of the boxes, then of the dome (1).
    chances: Vec<f64>,
}

impl Studio {
    /// The dome is sampled this much less often than its power: directions drawn from a diffuse surface find it well,
    /// and leave the boxes to be found here.
    const DOME_SHARE: f64 = 0.1;

    /// # Errors
    /// [`LightError::Brightness`] for a negative or infinite brightness, or if nothing shines.
    pub fn new(dome: Dome, boxes: Vec<SoftBox>) -> Result<Self, LightError> {
        dome.check()?;
        let powers: Vec<f64> = boxes.iter().map(SoftBox::power).chain([Self::DOME_SHARE * dome.power()]).collect();
        let total: f64 = powers.iter().sum();
        if !(total > 0.0 && total.is_finite()) {
            return Err(LightError::Brightness { what: "total brightness", value: total });
        }
        let mut sum = 0.0;
        let chances = powers
            .iter()
            .map(|p| {
                sum += p / total;
                sum
            })
            .collect();
        Ok(Self { dome, boxes, chances })
    }

    /// Brightness from a direction (a unit vector towards the light).
    pub fn value(&self, direction: DVec3) -> f64 {
        self.dome.value(direction) + self.boxes.iter().map(|b| b.value(direction)).sum::<f64>()
    }

    fn chance(&self, k: usize) -> f64 {
        self.chances[k] - if k > 0 { self.chances[k - 1] } else { 0.0 }
    }

    pub(super) fn density(&self, direction: DVec3) -> f64 {
        let boxes: f64 = self.boxes.iter().enumerate().map(|(k, b)| self.chance(k) * b.density(direction)).sum();
        boxes + self.chance(self.boxes.len()) * self.dome.value(direction) / self.dome.power().max(f64::MIN_POSITIVE)
    }

    /// Picks a light by its power with the first number, and uses what is left of it.
    pub(super) fn sample(&self, [u, v]: [f64; 2]) -> DVec3 {
        let last = self.boxes.len();
        let k = self.chances.iter().position(|&c| u < c).unwrap_or(last);
        let before = if k > 0 { self.chances[k - 1] } else { 0.0 };
        let left = ((u - before) / self.chance(k)).clamp(0.0, 1.0 - f64::EPSILON);
        if k < last { self.boxes[k].sample([left, v]) } else { self.dome.sample([left, v]) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn darkness_is_refused() {
        let dark = Dome { nadir: 0.0, horizon: 0.0, zenith: 0.0 };
        assert!(matches!(Studio::new(dark, vec![]), Err(LightError::Brightness { .. })));
        assert!(Studio::new(Dome { zenith: -1.0, ..dark }, vec![]).is_err());
        assert!(Studio::new(Dome { zenith: f64::NAN, ..dark }, vec![]).is_err());
        let lit = SoftBox::new([0.0, 0.0, 1.0], [1.0, 1.0], 0.0, 1.0).unwrap();
        let studio = Studio::new(dark, vec![lit]).unwrap();
        assert_eq!(studio.value(DVec3::Z), 1.0);
        assert!((studio.density(studio.sample([0.5, 0.5])) - 0.25).abs() < 1e-12);
    }
}
