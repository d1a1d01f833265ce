//! Least squares of two numbers between bounds (`marquardt1963`), with the derivatives taken abreast with the value.

/// Where the search ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Minimum {
    pub at: [f64; 2],
    /// Root of the sum of squared residuals.
    pub residual: f64,
}

/// A point with its residuals and their derivatives by each number.
#[derive(Clone, Copy)]
struct Point {
    at: [f64; 2],
    residuals: [f64; 2],
    by: [[f64; 2]; 2],
}

impl Point {
    fn cost(&self) -> f64 {
        let sum = self.residuals.iter().map(|r| r * r).sum::<f64>();
        if sum.is_finite() { sum } else { f64::INFINITY }
    }
}

/// Steps at most, of which most searches need ten.
const MOST_STEPS: usize = 80;

/// Residuals beyond which nothing improves.
const EXACT: f64 = 1e-13;

/// Minimises the residuals, which `evaluate` gives for several points at once, from `start`, between `bounds`.
///
/// # Errors
/// Those of `evaluate`.
pub(super) fn minimise<E>(
    start: [f64; 2],
    bounds: [[f64; 2]; 2],
    mut evaluate: impl FnMut(&[[f64; 2]]) -> Result<Vec<[f64; 2]>, E>,
) -> Result<Minimum, E> {
    let clamp = |at: [f64; 2]| [0, 1].map(|i| at[i].clamp(bounds[i][0], bounds[i][1]));
    let mut point = |at: [f64; 2]| {
        // Inward, so that both sides of every difference exist.
        let steps = [0, 1].map(|i| if at[i] + STEP <= bounds[i][1] { STEP } else { -STEP });
        let values = evaluate(&[at, [at[0] + steps[0], at[1]], [at[0], at[1] + steps[1]]])?;
        let by = [0, 1].map(|i| [0, 1].map(|r| (values[i + 1][r] - values[0][r]) / steps[i]));
        Ok(Point { at, residuals: values[0], by })
    };
    let mut here = point(clamp(start))?;
    let mut damping = 1e-3;
    for _ in 0..MOST_STEPS {
        if here.cost().sqrt() < EXACT {
            break;
        }
        let next = clamp(step(&here, bounds, damping));
        let moved = (next[0] - here.at[0]).abs().max((next[1] - here.at[1]).abs());
        if moved < 1e-13 {
            break;
        }
        let there = point(next)?;
        if there.cost() < here.cost() {
            here = there;
            damping = f64::max(damping * 0.05, 1e-14);
        } else if damping > 1e10 {
            break;
        } else {
            damping = f64::max(damping * 8.0, 1e-8);
        }
    }
    Ok(Minimum { at: here.at, residual: here.cost().sqrt() })
}

/// Of the differences that stand for derivatives.
const STEP: f64 = 1e-6;

/// A damped Gauss-Newton step in the numbers that are not held at a bound.
fn step(point: &Point, bounds: [[f64; 2]; 2], damping: f64) -> [f64; 2] {
    let gradient = point.by.map(|by| by[0] * point.residuals[0] + by[1] * point.residuals[1]);
    let held = [0, 1].map(|i| {
        (point.at[i] <= bounds[i][0] && gradient[i] > 0.0) || (point.at[i] >= bounds[i][1] && gradient[i] < 0.0)
    });
    let square = |i: usize, j: usize| point.by[i][0] * point.by[j][0] + point.by[i][1] * point.by[j][1];
    let diagonal = [0, 1].map(|i| square(i, i) * (1.0 + damping) + 1e-300);
    let mut delta = match held {
        [true, true] => [0.0, 0.0],
        [true, false] => [0.0, -gradient[1] / diagonal[1]],
        [false, true] => [-gradient[0] / diagonal[0], 0.0],
        [false, false] => {
            let cross = square(0, 1);
            let determinant = diagonal[0] * diagonal[1] - cross * cross;
            if determinant > 0.0 {
                [
                    (cross * gradient[1] - diagonal[1] * gradient[0]) / determinant,
                    (cross * gradient[0] - diagonal[0] * gradient[1]) / determinant,
                ]
            } else {
                [-gradient[0] / diagonal[0], -gradient[1] / diagonal[1]]
            }
        }
    };
    for value in &mut delta {
        // All numbers are logarithms or alike: no more than a factor of some ten at once.
        *value = if value.is_finite() { value.clamp(-2.0, 2.0) } else { 0.0 };
    }
    [point.at[0] + delta[0], point.at[1] + delta[1]]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(start: [f64; 2], bounds: [[f64; 2]; 2], residuals: impl Fn([f64; 2]) -> [f64; 2]) -> Minimum {
        let all = |points: &[[f64; 2]]| Ok::<_, ()>(points.iter().map(|p| residuals(*p)).collect());
        minimise(start, bounds, all).unwrap()
    }

    #[test]
    fn finds_the_bottom_of_rosenbrocks_valley() {
        let found = run([-1.2, 1.0], [[-5.0, 5.0]; 2], |p| [10.0 * (p[1] - p[0] * p[0]), 1.0 - p[0]]);
        assert!((found.at[0] - 1.0).abs() < 1e-9 && (found.at[1] - 1.0).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn ends_at_a_bound_where_the_best_lies_beyond() {
        let found = run([0.5, 0.5], [[0.0, 1.0]; 2], |p| [p[0] + 1.0, p[1] - p[0] - 0.3]);
        assert!(found.at[0] == 0.0 && (found.at[1] - 0.3).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn what_is_not_finite_neither_hangs_nor_panics() {
        let found = run([0.5, 0.5], [[0.0, 1.0]; 2], |_| [f64::NAN, 0.0]);
        assert!(found.residual.is_infinite());
    }
}
