//! Least squares without bounds, small and deterministic: Levenberg's and Marquardt's method (`marquardt1963`) with
//! finite differences.

/// The least-squares solution found.
pub(crate) struct Minimum<const N: usize> {
    pub at: [f64; N],
    /// Sum of the squared residuals.
    pub cost: f64,
}

/// Minimises the sum of squares of `residuals(parameters, out)`, from `start`. Ends when a step no longer helps, or
/// after 200 steps. A residual that is not finite makes a step fail.
pub(crate) fn minimise<const N: usize>(
    start: [f64; N],
    count: usize,
    mut residuals: impl FnMut(&[f64; N], &mut [f64]),
) -> Minimum<N> {
    let mut at = start;
    let mut here = vec![0.0; count];
    residuals(&at, &mut here);
    let mut cost = sum_of_squares(&here);
    let mut columns = vec![vec![0.0; count]; N];
    let mut trial = vec![0.0; count];
    let mut damping = 1e-2;
    for _ in 0..200 {
        for (j, column) in columns.iter_mut().enumerate() {
            let mut beside = at;
            let step = 1e-6 * (1.0 + at[j].abs());
            beside[j] += step;
            residuals(&beside, column);
            column.iter_mut().zip(&here).for_each(|(c, r)| *c = (*c - r) / step);
        }
        let (matrix, gradient) = normal_equations(&columns, &here);
        let before = cost;
        // Ever shorter, ever more downhill, until a step helps.
        while damping < 1e12 {
            let candidate = step_from(&at, &matrix, &gradient, damping);
            residuals(&candidate, &mut trial);
            let reached = sum_of_squares(&trial);
            if reached < cost {
                (at, cost) = (candidate, reached);
                std::mem::swap(&mut here, &mut trial);
                damping = (damping * 0.2).max(1e-12);
                break;
            }
            damping *= 4.0;
        }
        if before - cost <= 1e-9 * before || !cost.is_finite() {
            break;
        }
    }
    Minimum { at, cost }
}

fn sum_of_squares(residuals: &[f64]) -> f64 {
    let sum: f64 = residuals.iter().map(|r| r * r).sum();
    if sum.is_nan() { f64::INFINITY } else { sum }
}

fn normal_equations<const N: usize>(columns: &[Vec<f64>], residuals: &[f64]) -> ([[f64; N]; N], [f64; N]) {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let matrix = std::array::from_fn(|i| std::array::from_fn(|j| dot(&columns[i], &columns[j])));
    (matrix, std::array::from_fn(|i| dot(&columns[i], residuals)))
}

/// The damped Gauss-Newton step; by no more than 2 in any parameter, all of which are logarithms or alike.
fn step_from<const N: usize>(at: &[f64; N], matrix: &[[f64; N]; N], gradient: &[f64; N], damping: f64) -> [f64; N] {
    let mut damped = *matrix;
    for (i, row) in damped.iter_mut().enumerate() {
        row[i] += damping * row[i] + f64::MIN_POSITIVE;
    }
    let step = solve(damped, gradient.map(|g| -g));
    std::array::from_fn(|i| at[i] + if step[i].is_finite() { step[i].clamp(-2.0, 2.0) } else { 0.0 })
}

/// Gaussian elimination with the largest pivots.
fn solve<const N: usize>(mut a: [[f64; N]; N], mut b: [f64; N]) -> [f64; N] {
    for k in 0..N {
        let pivot = (k..N).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs())).unwrap_or(k);
        a.swap(k, pivot);
        b.swap(k, pivot);
        for i in k + 1..N {
            let factor = a[i][k] / a[k][k];
            let pivot_row = a[k];
            a[i].iter_mut().zip(pivot_row).skip(k).for_each(|(x, p)| *x -= factor * p);
            b[i] -= factor * b[k];
        }
    }
    for k in (0..N).rev() {
        let known: f64 = (k + 1..N).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - known) / a[k][k];
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_bottom_of_rosenbrocks_valley() {
        let minimum = minimise([-1.2, 1.0], 2, |p, r| {
            r[0] = 10.0 * (p[1] - p[0] * p[0]);
            r[1] = 1.0 - p[0];
        });
        assert!((minimum.at[0] - 1.0).abs() < 1e-6 && (minimum.at[1] - 1.0).abs() < 1e-6);
        assert!(minimum.cost < 1e-12);
    }

    #[test]
    fn a_curve_through_noiseless_points_is_recovered() {
        let points: Vec<f64> = (0..20).map(|i| f64::from(i) / 10.0).collect();
        let minimum = minimise([0.0, -0.3, -0.3], 20, |p, r| {
            for (r, x) in r.iter_mut().zip(&points) {
                *r = p[0] + p[1] * (p[2] * x).exp() - (1.5 - 0.7 * (-0.9 * x).exp());
            }
        });
        assert!(minimum.cost < 1e-14, "{}", minimum.cost);
    }

    #[test]
    fn what_is_not_finite_neither_hangs_nor_panics() {
        let minimum = minimise([1.0], 1, |_, r| r[0] = f64::NAN);
        assert!(minimum.cost.is_infinite() && minimum.at == [1.0]);
    }
}
