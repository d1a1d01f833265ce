//! Measured sizes: densities at radii, or what was counted bin by bin.

use super::ParticleError;
use super::Weighting;
use super::smooth::Smooth;

/// Most panels that an integral begins with.
const MOST_PANELS: usize = 256;

/// Decades of `e` below the first radius that is not 0.
const DEPTH: f64 = 40.0;

/// Sizes from a table, in any weighting. The density is linear between the radii given, or constant over each bin.
#[derive(Debug, Clone, PartialEq)]
pub struct TabulatedSizes {
    weighting: Weighting,
    segments: Vec<Segment>,
}

/// Radii in m, densities in any unit.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Segment {
    radii: [f64; 2],
    densities: [f64; 2],
}

impl TabulatedSizes {
    /// From densities per unit of radius (in any unit, as they are normalised) at ascending radii (m), at least two, between
    /// which they are linear. There is nothing beyond the first and last.
    ///
    /// # Errors
    /// [`ParticleError::Table`] with the row (from 0), [`ParticleError::EmptyTable`], or [`ParticleError::Diverges`].
    pub fn from_density(weighting: Weighting, radii_m: &[f64], densities: &[f64]) -> Result<Self, ParticleError> {
        check_ascending(radii_m)?;
        check_values(densities)?;
        if radii_m.len() != densities.len() || radii_m.len() < 2 {
            return Err(ParticleError::TableLength { radii: radii_m.len(), values: densities.len(), bins: false });
        }
        let segments = radii_m.windows(2).zip(densities.windows(2));
        Self::checked(
            weighting,
            segments.map(|(r, d)| Segment { radii: [r[0], r[1]], densities: [d[0], d[1]] }).collect(),
        )
    }

    /// From what was counted (particles, surface, volume or intensity, in any unit) in each bin between ascending edges (m),
    /// of which there is one more; evenly spread over the radii of a bin.
    ///
    /// # Errors
    /// As for [`Self::from_density`].
    pub fn from_bins(weighting: Weighting, edges_m: &[f64], counts: &[f64]) -> Result<Self, ParticleError> {
        check_ascending(edges_m)?;
        check_values(counts)?;
        if edges_m.len() != counts.len() + 1 || counts.is_empty() {
            return Err(ParticleError::TableLength { radii: edges_m.len(), values: counts.len(), bins: true });
        }
        let segments = edges_m.windows(2).zip(counts).map(|(r, count)| {
            let density = count / (r[1] - r[0]);
            Segment { radii: [r[0], r[1]], densities: [density; 2] }
        });
        Self::checked(weighting, segments.collect())
    }

    fn checked(weighting: Weighting, segments: Vec<Segment>) -> Result<Self, ParticleError> {
        // Densities are in any unit; numbers stay in range relative to the largest share of volume.
        let volume = |s: &Segment| {
            let [from, to] = s.radii;
            0.5 * (s.densities[0] + s.densities[1]) * (to - from) * (0.5 * (from + to)).powf(3.0 - weighting.power())
        };
        let largest = segments.iter().map(volume).fold(0.0, f64::max);
        if !(largest > 0.0 && largest.is_finite()) {
            return Err(ParticleError::EmptyTable);
        }
        let scaled = segments.into_iter().map(|s| Segment { densities: s.densities.map(|d| d / largest), ..s });
        // What is empty at either end would only be integrated over.
        let mut segments: Vec<Segment> = scaled.skip_while(Segment::is_empty).collect();
        while segments.last().is_some_and(Segment::is_empty) {
            segments.pop();
        }
        let table = Self { weighting, segments };
        if table.knots(3.0, 3.0).is_some() { Ok(table) } else { Err(ParticleError::Diverges { power: 3.0 }) }
    }

    /// What the table counts.
    pub fn weighting(&self) -> Weighting {
        self.weighting
    }
}

impl Segment {
    fn is_empty(&self) -> bool {
        self.densities == [0.0; 2]
    }
}

impl Smooth for TabulatedSizes {
    fn measure(&self, u: f64) -> (f64, f64) {
        let radius = u.exp();
        let after = self.segments.partition_point(|s| s.radii[1] < radius);
        let Segment { radii, densities } = self.segments[after.min(self.segments.len() - 1)];
        let along = ((radius - radii[0]) / (radii[1] - radii[0])).clamp(0.0, 1.0);
        let density = densities[0] + along * (densities[1] - densities[0]);
        (radius, density * radius.powf(4.0 - self.weighting.power()))
    }

    fn knots(&self, least: f64, _most: f64) -> Option<Vec<f64>> {
        let stride = self.segments.len().div_ceil(MOST_PANELS);
        let mut knots: Vec<f64> = self.segments.iter().step_by(stride).map(|s| s.radii[0].ln()).collect();
        knots.push(self.segments[self.segments.len() - 1].radii[1].ln());
        if knots[0] == f64::NEG_INFINITY {
            // Near 0 the density is constant, or rises in proportion.
            let rising = if self.segments[0].densities[0] == 0.0 { 1.0 } else { 0.0 };
            let slope = rising + 1.0 + least - self.weighting.power();
            if slope <= 0.0 {
                return None;
            }
            knots[0] = knots[1] - DEPTH / slope;
        }
        Some(knots)
    }
}

fn check_ascending(radii: &[f64]) -> Result<(), ParticleError> {
    let error = |row: usize, problem| Err(ParticleError::Table { row, value: radii[row], problem });
    for (row, radius) in radii.iter().enumerate() {
        if !(radius.is_finite() && *radius >= 0.0) {
            return error(row, "a radius must be finite and not negative");
        }
        if row > 0 && *radius <= radii[row - 1] {
            return error(row, "radii must ascend");
        }
    }
    Ok(())
}

fn check_values(values: &[f64]) -> Result<(), ParticleError> {
    match values.iter().position(|v| !(v.is_finite() && *v >= 0.0)) {
        None => Ok(()),
        Some(row) => Err(ParticleError::Table {
            row,
            value: values[row],
            problem: "a density or count must be finite and not negative",
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particle::{LogNormal, SizeDistribution};

    /// A log-normal written down finely is a log-normal.
    #[test]
    fn a_fine_table_is_what_it_was_taken_from() {
        let exact = SizeDistribution::LogNormal(LogNormal::from_median(Weighting::Number, 1e-6, 1.5).unwrap());
        let radii: Vec<f64> = (0..=600).map(|i| 1e-7 * 1e3f64.powf(f64::from(i) / 600.0)).collect();
        for weighting in [Weighting::Number, Weighting::Volume] {
            let densities: Vec<f64> = radii.iter().map(|r| exact.density(weighting, *r).unwrap()).collect();
            let table = TabulatedSizes::from_density(weighting, &radii, &densities).unwrap();
            let table = SizeDistribution::Tabulated(table);
            for (p, q) in [(1.0, 0.0), (3.0, 2.0), (4.0, 3.0), (6.0, 5.0)] {
                let (a, b) = (table.mean_radius(p, q).unwrap(), exact.mean_radius(p, q).unwrap());
                assert!((a / b - 1.0).abs() < 2e-3, "{weighting}: D[{p},{q}] {a:e} {b:e}");
            }
        }
    }

    #[test]
    fn bins_hold_what_they_count() {
        let table = TabulatedSizes::from_bins(Weighting::Number, &[0.0, 1.0, 2.0, 4.0], &[0.0, 3.0, 1.0]).unwrap();
        let sizes = SizeDistribution::Tabulated(table);
        assert!((sizes.mean_radius(1.0, 0.0).unwrap() - (3.0 * 1.5 + 3.0) / 4.0).abs() < 1e-9);
        assert!((sizes.quantile(Weighting::Number, 0.75).unwrap() - 2.0).abs() < 1e-5);
        let zero = TabulatedSizes::from_bins(Weighting::Number, &[0.0, 2.0], &[1.0]).unwrap();
        let mean = SizeDistribution::Tabulated(zero).mean_radius(1.0, 0.0).unwrap();
        assert!((mean - 1.0).abs() < 1e-8, "{mean}");
    }

    #[test]
    fn a_broken_table_is_refused_at_its_row() {
        let new = |r: &[f64], d: &[f64]| TabulatedSizes::from_density(Weighting::Number, r, d);
        assert!(matches!(new(&[1.0, 3.0, 2.0], &[1.0; 3]), Err(ParticleError::Table { row: 2, .. })));
        assert!(matches!(new(&[1.0, 2.0], &[1.0, -1.0]), Err(ParticleError::Table { row: 1, .. })));
        assert!(matches!(new(&[1.0, 2.0], &[0.0, 0.0]), Err(ParticleError::EmptyTable)));
        assert!(matches!(new(&[1.0], &[1.0]), Err(ParticleError::TableLength { .. })));
        assert!(matches!(new(&[f64::NAN, 1.0], &[1.0, 1.0]), Err(ParticleError::Table { row: 0, .. })));
        let bins = |e: &[f64], c: &[f64]| TabulatedSizes::from_bins(Weighting::Intensity, e, c);
        assert!(matches!(bins(&[1.0, 2.0], &[1.0, 1.0]), Err(ParticleError::TableLength { .. })));
        // Intensity down to no radius at all hides an infinite volume.
        assert!(matches!(bins(&[0.0, 2.0], &[1.0]), Err(ParticleError::Diverges { .. })));
    }
}
