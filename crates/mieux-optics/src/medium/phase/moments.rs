//! Legendre moments of the phase functions of media, without a table over angle between.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use super::members::Member;
use crate::integrate::gauss_legendre;
use crate::medium::scatterer::{mie_error, node_count};
use crate::medium::{Medium, MediumError};
use crate::mie::Directions;
use crate::phase::AngleGrid;

/// Spheres that are added up by themselves; fixed, so that results do not depend on the number of threads.
const BATCH: usize = 16;

/// Sizes of spheres that share a Gauss rule, largest over smallest.
const CLASS: f64 = 1.4;

/// Nodes of a Gauss rule that are gone through by themselves.
const NODES: usize = 64;

/// A Gauss rule over the cosine.
struct Rule {
    nodes: Vec<(f64, f64)>,
    directions: Directions,
}

/// The rules that were asked for; there are some thirty.
static RULES: Mutex<BTreeMap<usize, Arc<Rule>>> = Mutex::new(BTreeMap::new());

/// A rule of at least so many nodes, of numbers that grow by an eighth.
fn rule(least: usize) -> Arc<Rule> {
    let mut count = 8usize;
    while count < least {
        count += (count / 8).max(1);
    }
    let rules = || RULES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(found) = rules().get(&count) {
        return found.clone();
    }
    let nodes = gauss_legendre(count);
    let directions = Directions::new(nodes.iter().map(|(mu, _)| *mu));
    let made = Arc::new(Rule { nodes, directions });
    rules().entry(count).or_insert(made).clone()
}

/// All moments of the sum of scattering coefficients times phase functions; the first is that of scattering coefficients.
pub(super) fn of_all(medium: &Medium, members: &[Member]) -> Result<Vec<f64>, MediumError> {
    let mut order: Vec<&Member> = members.iter().collect();
    order.sort_by(|a, b| a.size.total_cmp(&b.size));
    let mut total = Vec::new();
    for class in classes(&order) {
        let terms = class.par_iter().map(|member| member.ball.coefficients().terms().len()).max().unwrap_or(1);
        // Phase functions are of twice the degree, and so are the polynomials they are multiplied with.
        let rule = rule(2 * terms + 1);
        let values = sum(medium, class, &rule.directions)?;
        let moments = project(&rule.nodes, &values, 2 * terms);
        total.resize(total.len().max(moments.len()), 0.0);
        total.iter_mut().zip(moments).for_each(|(total, moment)| *total += moment);
    }
    Ok(total)
}

/// Runs of ascending sizes that can share a rule.
fn classes<'a, 'b>(ascending: &'a [&'b Member]) -> Vec<&'a [&'b Member]> {
    let (mut classes, mut rest) = (Vec::new(), ascending);
    while let Some(first) = rest.first() {
        let most = CLASS * first.size + 4.0;
        let (class, after) = rest.split_at(rest.partition_point(|member| member.size <= most).max(1));
        classes.push(class);
        rest = after;
    }
    classes
}

/// Moments up to a degree of a function given at the nodes of a rule.
fn project(nodes: &[(f64, f64)], values: &[f64], max_degree: usize) -> Vec<f64> {
    let factors = factors(max_degree);
    let parts: Vec<Vec<f64>> = nodes
        .par_chunks(NODES)
        .zip(values.par_chunks(NODES))
        .map(|(nodes, values)| {
            let mut moments = vec![0.0; max_degree + 1];
            for ((mu, weight), value) in nodes.iter().zip(values) {
                let share = TAU * weight * value;
                let (mut before, mut here) = (0.0, 1.0);
                for (moment, [up, down]) in moments.iter_mut().zip(&factors) {
                    *moment += share * here;
                    (before, here) = (here, up * mu * here - down * before);
                }
            }
            moments
        })
        .collect();
    let mut moments = vec![0.0; max_degree + 1];
    for part in parts {
        moments.iter_mut().zip(part).for_each(|(moment, part)| *moment += part);
    }
    moments
}

/// `(2l + 1)/(l + 1)` and `l/(l + 1)` up to a degree.
fn factors(max_degree: usize) -> Vec<[f64; 2]> {
    (0..=max_degree)
        .map(|l| {
            let l = l as f64;
            [(2.0 * l + 1.0) / (l + 1.0), l / (l + 1.0)]
        })
        .collect()
}

/// The phase function of all its moments at angles (rad), its rounding not negative.
pub(super) fn values(moments: &[f64], angles: &[f64]) -> Vec<f64> {
    let factors = factors(moments.len());
    let scaled: Vec<f64> = moments.iter().enumerate().map(|(l, m)| (2 * l + 1) as f64 * m / (4.0 * PI)).collect();
    angles
        .par_iter()
        .map(|angle| {
            let mu = angle.cos();
            let (mut before, mut here, mut sum) = (0.0, 1.0, 0.0);
            for (moment, [up, down]) in scaled.iter().zip(&factors) {
                sum += moment * here;
                (before, here) = (here, up * mu * here - down * before);
            }
            sum.max(0.0)
        })
        .collect()
}

/// The first moments, normalised, where a structure factor is in play.
pub(super) fn of_packed(medium: &Medium, members: &[Member], max_degree: usize) -> Result<Vec<f64>, MediumError> {
    let terms = members.par_iter().map(|member| member.ball.coefficients().terms().len()).max().unwrap_or(1);
    let rule = rule(node_count(terms) + max_degree / 2);
    let all: Vec<&Member> = members.iter().collect();
    let moments = project(&rule.nodes, &sum(medium, &all, &rule.directions)?, max_degree);
    let whole = moments[0];
    Ok(moments.into_iter().map(|moment| moment / whole).collect())
}

/// The sum of scattering coefficients times phase functions, at the angles of a grid.
pub(super) fn packed_values(medium: &Medium, members: &[Member], grid: &AngleGrid) -> Result<Vec<f64>, MediumError> {
    let angles = grid.as_slice();
    let last = angles.len() - 1;
    // Graded grids are mirrored about 90 degrees; exact mirror images share their work.
    let cosine = |i: usize| if 2 * i > last { -angles[last - i].cos() } else { angles[i].cos() };
    let directions = Directions::new((0..=last).map(|i| if 2 * i == last { 0.0 } else { cosine(i) }));
    let all: Vec<&Member> = members.iter().collect();
    sum(medium, &all, &directions)
}

/// The sum of scattering coefficients times phase functions, in the order of `directions`.
fn sum(medium: &Medium, members: &[&Member], directions: &Directions) -> Result<Vec<f64>, MediumError> {
    let count = directions.cosines().len();
    let sums: Result<Vec<Vec<f64>>, MediumError> = members
        .par_chunks(BATCH)
        .map(|batch| {
            let mut sum = vec![0.0; count];
            for member in batch {
                let phase = member.ball.coefficients().phase_function(directions);
                let phase = phase.map_err(|source| mie_error(&medium.inclusions()[member.inclusion], source))?;
                match member.fluid {
                    None => sum.iter_mut().zip(phase).for_each(|(sum, p)| *sum += member.alone * p),
                    Some(fluid) => {
                        for ((sum, p), mu) in sum.iter_mut().zip(phase).zip(directions.cosines()) {
                            *sum += member.alone * p * fluid.at(member.size, *mu);
                        }
                    }
                }
            }
            Ok(sum)
        })
        .collect();
    let mut total = vec![0.0; count];
    for sum in sums? {
        total.iter_mut().zip(sum).for_each(|(total, s)| *total += s);
    }
    Ok(total)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{AIR, GREEN, droplet, milk};
    use crate::Complex64;
    use crate::medium::Medium;
    use crate::mie::{PlaneWave, Sphere};
    use crate::phase::PhaseFunction;
    use crate::substance::{Conditions, Substance};

    /// One size is one sphere, whose own expansion is another way.
    #[test]
    fn one_size_has_the_moments_of_its_sphere() {
        let medium = droplet(10e-6);
        let found = medium.legendre_moments_at(GREEN, 400, 1e-4).unwrap();
        let wave = PlaneWave::new(GREEN, Complex64::ONE).unwrap();
        let water = Substance::named("water", Conditions::default()).unwrap().index(GREEN).unwrap();
        let sphere = Sphere::new(wave, 5e-6, water).unwrap().coefficients().legendre_moments().unwrap();
        assert!(sphere.len() < 401);
        for (degree, moment) in found.iter().enumerate() {
            let exact = sphere.get(degree).copied().unwrap_or(0.0);
            assert!((moment - exact).abs() < 1e-11, "{degree}: {moment} {exact}");
        }
    }

    /// The table over angle, and the coefficients, go by other ways.
    #[test]
    fn milk_has_the_moments_of_its_table() {
        let medium = milk(3.5, 3.4);
        let found = medium.legendre_moments_at(GREEN, 64, 1e-5).unwrap();
        let lack = 1.0 - medium.optics_at(GREEN, 1e-5).unwrap().asymmetry;
        assert!(((1.0 - found[1]) / lack - 1.0).abs() < 1e-4, "{} {lack}", 1.0 - found[1]);
        let PhaseFunction::Tabulated(table) = medium.phase_at(GREEN, 1e-4).unwrap() else { panic!() };
        for (degree, (moment, of_table)) in found.iter().zip(table.legendre_moments(64)).enumerate() {
            assert!((moment - of_table).abs() < 2e-4, "{degree}: {moment} {of_table}");
        }
    }

    #[test]
    fn where_nothing_scatters_it_would_do_so_evenly() {
        let clear = Medium::new(AIR, vec![]).unwrap();
        assert_eq!(clear.legendre_moments_at(GREEN, 2, 1e-4).unwrap(), [1.0, 0.0, 0.0]);
        assert!(clear.legendre_moments_at(GREEN, 2, 0.0).is_err());
    }
}
