//! Linear equations that couple unknowns within a link of a chain, and each with itself in the next link.

/// `n` unknowns in every link. Symmetric and positive: a full block for each link (row by row), and between a link and the
/// next a diagonal.
pub(super) struct Chain {
    pub n: usize,
    pub blocks: Vec<Vec<f64>>,
    pub couplings: Vec<Vec<f64>>,
    pub right: Vec<Vec<f64>>,
}

/// The unknowns, and the diagonal of the inverse of the matrix.
pub(super) struct Solved {
    pub at: Vec<Vec<f64>>,
    pub variance: Vec<Vec<f64>>,
}

impl Chain {
    pub fn new(n: usize, links: usize) -> Self {
        Self {
            n,
            blocks: vec![vec![0.0; n * n]; links],
            couplings: vec![vec![0.0; n]; links.saturating_sub(1)],
            right: vec![vec![0.0; n]; links],
        }
    }

    /// Elimination from the first link to the last, and back. `None` when the matrix is not positive.
    pub fn solve(&self) -> Option<Solved> {
        let (n, links) = (self.n, self.blocks.len());
        let mut inverses: Vec<Vec<f64>> = Vec::with_capacity(links);
        let mut right = self.right.clone();
        for link in 0..links {
            let mut block = self.blocks[link].clone();
            if let Some(before) = link.checked_sub(1) {
                let (coupling, inverse) = (&self.couplings[before], &inverses[before]);
                for i in 0..n {
                    let row = &inverse[i * n..(i + 1) * n];
                    let mut moved = 0.0;
                    for j in 0..n {
                        block[i * n + j] -= coupling[i] * row[j] * coupling[j];
                        moved += row[j] * right[before][j];
                    }
                    right[link][i] -= coupling[i] * moved;
                }
            }
            inverses.push(inverse(&block, n)?);
        }
        let mut at = vec![vec![0.0; n]; links];
        let mut variance = vec![vec![0.0; n]; links];
        let mut covariance: Vec<f64> = Vec::new();
        for link in (0..links).rev() {
            let inverse = &inverses[link];
            let mut here = right[link].clone();
            let mut full = inverse.clone();
            if link + 1 < links {
                let coupling = &self.couplings[link];
                (0..n).for_each(|i| here[i] -= coupling[i] * at[link + 1][i]);
                // Inverse times coupling.
                let scaled: Vec<f64> = (0..n * n).map(|k| inverse[k] * coupling[k % n]).collect();
                let half = product(&scaled, &covariance, n);
                for i in 0..n {
                    for j in 0..n {
                        let row = &scaled[j * n..(j + 1) * n];
                        full[i * n + j] += half[i * n..(i + 1) * n].iter().zip(row).map(|(a, b)| a * b).sum::<f64>();
                    }
                }
            }
            for i in 0..n {
                at[link][i] = inverse[i * n..(i + 1) * n].iter().zip(&here).map(|(a, b)| a * b).sum();
                variance[link][i] = full[i * n + i];
            }
            covariance = full;
        }
        Some(Solved { at, variance })
    }
}

fn product(a: &[f64], b: &[f64], n: usize) -> Vec<f64> {
    let mut out = vec![0.0; n * n];
    for i in 0..n {
        for k in 0..n {
            let factor = a[i * n + k];
            let row = &b[k * n..(k + 1) * n];
            out[i * n..(i + 1) * n].iter_mut().zip(row).for_each(|(out, b)| *out += factor * b);
        }
    }
    out
}

/// Of a symmetric positive matrix, by Cholesky's factor.
fn inverse(a: &[f64], n: usize) -> Option<Vec<f64>> {
    let mut l = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..=i {
            let (before, rest) = l.split_at(i * n);
            let (row_i, row_j) =
                if i == j { (&rest[..j], &rest[..j]) } else { (&rest[..j], &before[j * n..j * n + j]) };
            let sum = a[i * n + j] - row_i.iter().zip(row_j).map(|(x, y)| x * y).sum::<f64>();
            if i == j {
                if !(sum > 0.0 && sum.is_finite()) {
                    return None;
                }
                l[i * n + i] = sum.sqrt();
            } else {
                l[i * n + j] = sum / l[j * n + j];
            }
        }
    }
    // The inverse of the factor, kept by columns of its transpose, then its square.
    let mut m = vec![0.0; n * n];
    for column in 0..n {
        m[column * n + column] = 1.0 / l[column * n + column];
        for i in column + 1..n {
            let sum: f64 = (column..i).map(|k| l[i * n + k] * m[column * n + k]).sum();
            m[column * n + i] = -sum / l[i * n + i];
        }
    }
    let mut out = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..=i {
            let sum: f64 = (i..n).map(|k| m[i * n + k] * m[j * n + k]).sum();
            (out[i * n + j], out[j * n + i]) = (sum, sum);
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_is_solved_as_the_whole_matrix_would_be() {
        let (n, links) = (3, 4);
        let mut chain = Chain::new(n, links);
        let mut whole = vec![0.0; (n * links) * (n * links)];
        let mut seed = 1u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed) / f64::from(u32::MAX) - 0.5
        };
        let size = n * links;
        let mut right = Vec::new();
        for link in 0..links {
            for i in 0..n {
                for j in 0..=i {
                    let value = random() + if i == j { 4.0 } else { 0.0 };
                    for (i, j) in [(i, j), (j, i)] {
                        chain.blocks[link][i * n + j] = value;
                        whole[(link * n + i) * size + link * n + j] = value;
                    }
                }
                chain.right[link][i] = random();
                right.push(chain.right[link][i]);
                if link + 1 < links {
                    let value = random();
                    chain.couplings[link][i] = value;
                    whole[(link * n + i) * size + (link + 1) * n + i] = value;
                    whole[((link + 1) * n + i) * size + link * n + i] = value;
                }
            }
        }
        let inverse = inverse(&whole, size).unwrap();
        let solved = chain.solve().unwrap();
        for i in 0..size {
            let expected: f64 = (0..size).map(|j| inverse[i * size + j] * right[j]).sum();
            assert!((solved.at[i / n][i % n] - expected).abs() < 1e-12);
            assert!((solved.variance[i / n][i % n] - inverse[i * size + i]).abs() < 1e-12);
            // And the inverse is one.
            for k in 0..size {
                let unit: f64 = (0..size).map(|j| whole[i * size + j] * inverse[j * size + k]).sum();
                assert!((unit - f64::from(u8::from(i == k))).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn what_is_not_positive_has_no_answer() {
        let mut chain = Chain::new(1, 2);
        chain.blocks[0][0] = 1.0;
        assert!(chain.solve().is_none());
    }
}
