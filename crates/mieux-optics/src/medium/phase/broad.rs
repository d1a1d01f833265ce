//! Phase functions of sizes so many, or so large, that interference over angle averages out.

use std::f64::consts::PI;

use super::members::Member;
use super::{moments, rays};
use crate::integrate::gauss_legendre;
use crate::medium::scatterer::Ball;
use crate::medium::{Medium, MediumError};
use crate::phase::{AngleGrid, PhaseError, Tabulated};

/// Exponents of attenuation across spheres beyond which their rays are followed apart from those of others, largest over smallest.
const CLASS: f64 = 1.5;

/// An exponent of attenuation that makes no difference.
const CLEAR: f64 = 1e-3;

/// The mean phase function as a table whose `1 - g` is `lack`.
pub(super) fn table(
    medium: &Medium,
    wavelength: f64,
    members: &[Member],
    largest: f64,
    lack: f64,
) -> Result<Tabulated, MediumError> {
    let grid = AngleGrid::broad(largest)?;
    let host = medium.host().index(wavelength)?;
    let exact: Vec<Member> = members.iter().filter(|member| !member.rays).cloned().collect();
    let mut shares = vec![0.0; grid.len() - 1];
    if !exact.is_empty() {
        add_exact(&moments::of_all(medium, &exact)?, &grid, &mut shares);
    }
    for inclusion in 0..medium.inclusions().len() {
        let mut followed: Vec<(f64, &Member)> = Vec::new();
        for member in members.iter().filter(|member| member.rays && member.inclusion == inclusion) {
            if let Ball::Homogeneous(sphere) = &member.ball {
                followed.push((4.0 * member.size * sphere.index().im / host.norm(), member));
            }
        }
        followed.sort_by(|a, b| a.0.total_cmp(&b.0));
        for class in followed.chunk_by(|a, b| same_class(a.0) == same_class(b.0)) {
            add_rays(class, host.re, &grid, &mut shares);
        }
    }
    let values = at_angles(&shares, &grid);
    Ok(tilted(&grid, &values, lack)?)
}

fn same_class(attenuation: f64) -> i64 {
    (attenuation.max(CLEAR).ln() / CLASS.ln()).floor() as i64
}

/// Adds what spheres of about the same attenuation do.
fn add_rays(class: &[(f64, &Member)], host: f64, grid: &AngleGrid, shares: &mut [f64]) {
    let angles = grid.as_slice();
    let (mut light, mut exponent) = (0.0, 0.0);
    let mut diffracted = vec![0.0; shares.len()];
    for (attenuation, member) in class {
        light += member.scattering;
        exponent += member.scattering * attenuation;
        rays::diffracted(member.size, member.scattering, angles, &mut diffracted);
    }
    let Some(Ball::Homogeneous(sphere)) = class.first().map(|(_, member)| &member.ball) else { return };
    if light <= 0.0 {
        return;
    }
    let (followed, total) = rays::followed(sphere.index().re / host, exponent / light, angles);
    // As much as meets a sphere passes it by (`vandehulst1957`), of which absorption takes nothing.
    let share = 1.0 / (1.0 + total);
    for ((sum, past), through) in shares.iter_mut().zip(diffracted).zip(followed) {
        *sum += share * past + (1.0 - share) * light / total * through;
    }
}

/// Adds the integrals over bins of a function by its moments.
fn add_exact(moments: &[f64], grid: &AngleGrid, shares: &mut [f64]) {
    // Nodes enough for the finest oscillation there is.
    let mut rules: Vec<Vec<(f64, f64)>> = Vec::new();
    let (mut angles, mut weights) = (Vec::new(), Vec::new());
    for (bin, pair) in grid.as_slice().windows(2).enumerate() {
        let (middle, half) = (0.5 * (pair[0] + pair[1]), 0.5 * (pair[1] - pair[0]));
        let count = 3 + (0.7 * moments.len() as f64 * half) as usize;
        if rules.len() <= count {
            rules.resize(count + 1, Vec::new());
        }
        if rules[count].is_empty() {
            rules[count] = gauss_legendre(count);
        }
        for (x, weight) in &rules[count] {
            let theta: f64 = middle + half * x;
            angles.push(theta);
            weights.push((bin, 2.0 * PI * half * weight * theta.sin()));
        }
    }
    for (value, (bin, weight)) in moments::values(moments, &angles).into_iter().zip(weights) {
        shares[bin] += weight * value;
    }
}

/// Values at the angles of a grid from integrals over its bins.
fn at_angles(shares: &[f64], grid: &AngleGrid) -> Vec<f64> {
    let angles = grid.as_slice();
    let away = |theta: f64| 2.0 * (0.5 * theta).sin().powi(2);
    let mean = |k: usize| shares[k] / (2.0 * PI * (away(angles[k + 1]) - away(angles[k])));
    let middle = |k: usize| 0.5 * (angles[k] + angles[k + 1]);
    let last = shares.len() - 1;
    (0..angles.len())
        .map(|i| {
            if i == 0 || i > last {
                return mean(i.min(last));
            }
            let [near, far] = [mean(i - 1), mean(i)];
            let t = (angles[i] - middle(i - 1)) / (middle(i) - middle(i - 1));
            if near > 0.0 && far > 0.0 { near.powf(1.0 - t) * far.powf(t) } else { near * (1.0 - t) + far * t }
        })
        .collect()
}

/// The table of values times `exp(c (1 - cos))`, with the `c` that makes `1 - g` what it is to be.
pub(super) fn tilted(grid: &AngleGrid, values: &[f64], lack: f64) -> Result<Tabulated, PhaseError> {
    let with = |c: f64| {
        let factor = |theta: &f64| (c * 2.0 * (0.5 * theta).sin().powi(2)).exp();
        let tilted = values.iter().zip(grid.as_slice()).map(|(value, theta)| value * factor(theta)).collect();
        Tabulated::new(grid.as_slice().to_vec(), tilted)
    };
    let error = |table: &Tabulated| (table.one_minus_asymmetry() / lack).ln();
    let (mut before, mut table) = (0.0, with(0.0)?);
    let mut error_before = error(&table);
    let mut c = -0.1 * error_before;
    for _ in 0..30 {
        if error_before.abs() < 1e-12 {
            break;
        }
        table = with(c)?;
        let found = error(&table);
        let slope = (found - error_before) / (c - before);
        (before, error_before) = (c, found);
        if found.abs() < 1e-12 || slope.is_nan() || slope <= 0.0 {
            break;
        }
        c = (c - found / slope).clamp(c - 5.0, c + 5.0);
    }
    let reached = (table.one_minus_asymmetry() / lack - 1.0).abs();
    if reached < 1e-6 { Ok(table) } else { Err(PhaseError::Tolerance { reached, wanted: 1e-6 }) }
}
