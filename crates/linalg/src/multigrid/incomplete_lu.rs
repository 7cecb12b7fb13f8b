//! The smoother of levels with convection: incomplete LU factors of a stabilised matrix.

use rayon::prelude::*;

use crate::constrained_dofs::ConstrainedDofs;
use crate::csr::{Csr, Csr32, Rows};
use crate::node_kernel::{NodeRows, Padded};
use crate::product::build_rows;
use crate::transpose::transpose;

/// Part of the artificial diffusion of first-order upwinding that the factorised matrix has.
///
/// GMRES iterations to 1e-8 for the velocity block of a sphere in a ball of ten radii, 10 115 nodes
/// and a Reynolds number of 50, cells with Peclet numbers up to 96, with parts of 0.03, 0.05, 0.07,
/// 0.1, 0.15, 0.25 and 1: none in 60, 17, 17, 18, 22, 32 and more than 60. Without it the factors
/// are unstable.
const UPWIND_PART: f64 = 0.1;

/// Least ratio of a pivot to the diagonal entry of its row; smaller ones are replaced by the entry.
const MIN_PIVOT_RATIO: f64 = 0.1;

/// Ratio of the skew-symmetric couplings of a row to its diagonal entry above which Jacobi steps
/// are no smoother.
const MAX_SKEW_RATIO: f64 = 0.2;

/// Whether the skew-symmetric part of a matrix is large in some row.
pub(super) fn convection_dominates(k: &Csr) -> bool {
    let transposed = transpose(k);
    let (rows, columns) = (Rows::new(k), Rows::new(&transposed));
    (0..k.rows()).into_par_iter().any(|i| {
        let skew: f64 = skew_row(rows, columns, i).map(|(_, n)| n.abs()).sum();
        skew > MAX_SKEW_RATIO * rows.entry(i, i)
    })
}

/// Columns and values of row `i` of `(A - A^T) / 2`, for matrices with symmetric pattern.
fn skew_row<'a>(
    rows: Rows<'a, f64>,
    columns: Rows<'a, f64>,
    i: usize,
) -> impl Iterator<Item = (usize, f64)> + 'a {
    let (above, mirrored) = (rows.row(i), columns.entries(i));
    above.enumerate().map(move |(place, (j, a))| {
        // the same place unless an entry is missing on one side
        let b = match mirrored.0.get(place) {
            Some(&column) if column as usize == j => mirrored.1[place],
            _ => columns.entry(i, j),
        };
        (j, 0.5 * (a - b))
    })
}

/// `K + θ D` with the artificial diffusion `D` of upwinding, `θ` = [`UPWIND_PART`].
///
/// With the skew-symmetric part `N` of `K`, `D_ij = -|N_ij|` for other nodes, and its rows sum to
/// zero. It vanishes for a symmetric matrix.
pub(super) fn stabilised(k: &Csr) -> Csr {
    let transposed = transpose(k);
    let (rows, columns) = (Rows::new(k), Rows::new(&transposed));
    build_rows(k.rows(), k.cols(), |i, row| {
        let mut diagonal = 0.0;
        for ((j, a), (_, skew)) in rows.row(i).zip(skew_row(rows, columns, i)) {
            let diffusion = UPWIND_PART * skew.abs();
            row.add(j, a - diffusion);
            diagonal += diffusion;
        }
        row.add(i, diagonal);
    })
}

/// Factors `L U` of a scalar matrix on its own pattern, for three components.
///
/// Nodes are eliminated in their order, those with constrained components after all others: a
/// component that is constrained then enters no pivot of a free one, and the factors serve all
/// three components. Serial, hence the same on any number of threads. Reference: Saad, Iterative
/// Methods for Sparse Linear Systems, 10.3.
pub(super) struct IncompleteLu {
    order: Vec<u32>,
    lower: Csr32,
    upper: Csr32,
    inverse_diagonal: Vec<f32>,
    constrained: ConstrainedDofs,
    /// Constrained components of each node; empty if there are none.
    bits: Vec<u8>,
}

impl IncompleteLu {
    /// Factorises `unit` times a [`stabilised`] matrix.
    pub fn new(stable: &Csr, constrained: &ConstrainedDofs, unit: f64) -> Self {
        let n = stable.rows();
        let bits = constrained.bits(n);
        let mut order: Vec<u32> = (0..n as u32).collect();
        order.sort_by_key(|&node| bits[node as usize].count_ones());
        let mut place = vec![0; n];
        for (position, &node) in (0_u32..).zip(&order) {
            place[node as usize] = position;
        }
        let (indptr, columns) = (stable.indptr(), stable.indices());
        let starts = indptr.into_raw_storage();
        let mut values = stable.data().to_vec();
        let mut pivots = vec![0.0; n];
        // where the entries of the row that is eliminated are, one more than their index
        let mut at = vec![0; n];
        let mut before: Vec<(u32, usize)> = Vec::new();
        for &node in &order {
            let i = node as usize;
            let range = starts[i]..starts[i + 1];
            before.clear();
            let (mut diagonal, mut diagonal_at) = (1.0, None);
            for e in range.clone() {
                let j = columns[e] as usize;
                at[j] = e + 1;
                if place[j] < place[i] {
                    before.push((place[j], e));
                } else if i == j {
                    (diagonal, diagonal_at) = (values[e], Some(e));
                }
            }
            before.sort_unstable();
            for &(position, e) in &before {
                let k = order[position as usize] as usize;
                let factor = values[e] / pivots[k];
                values[e] = factor;
                for f in starts[k]..starts[k + 1] {
                    let j = columns[f] as usize;
                    if place[j] > position && at[j] > 0 {
                        values[at[j] - 1] -= factor * values[f];
                    }
                }
            }
            let pivot = diagonal_at.map_or(diagonal, |e| values[e]);
            pivots[i] = match pivot > MIN_PIVOT_RATIO * diagonal {
                true => pivot,
                false => diagonal,
            };
            for e in range {
                at[columns[e] as usize] = 0;
            }
        }
        let part = |is_lower: bool, unit: f64| {
            let mut indptr = Vec::with_capacity(n + 1);
            let (mut indices, mut data) = (Vec::new(), Vec::new());
            indptr.push(0);
            for i in 0..n {
                for e in starts[i]..starts[i + 1] {
                    let j = columns[e] as usize;
                    if i != j && (place[j] < place[i]) == is_lower {
                        indices.push(columns[e]);
                        data.push((values[e] * unit) as f32);
                    }
                }
                indptr.push(indices.len());
            }
            Csr32::new((n, n), indptr, indices, data)
        };
        Self {
            lower: part(true, 1.0),
            upper: part(false, unit),
            inverse_diagonal: pivots.iter().map(|d| (d * unit).recip() as f32).collect(),
            bits: match constrained.is_empty() {
                true => Vec::new(),
                false => bits,
            },
            constrained: constrained.clone(),
            order,
        }
    }

    /// Overwrites `x` with the solutions of `L U y = x`.
    pub fn solve<const S: usize>(&self, x: &mut [[Padded; S]]) {
        self.constrained.clear_columns(x);
        let (lower, upper) = (Rows::new(&self.lower), Rows::new(&self.upper));
        let clear = |i: usize, x: &mut [Padded; S]| {
            let Some(bits) = self.bits.get(i).filter(|&&bits| bits != 0) else {
                return;
            };
            for column in x {
                for (d, value) in column.iter_mut().enumerate() {
                    if bits >> d & 1 == 1 {
                        *value = 0.0;
                    }
                }
            }
        };
        for &node in &self.order {
            let i = node as usize;
            let sums = lower.padded_row(i, x);
            for (x, sums) in x[i].iter_mut().zip(sums) {
                for (x, sum) in x.iter_mut().zip(sums) {
                    *x -= sum;
                }
            }
            clear(i, &mut x[i]);
        }
        for &node in self.order.iter().rev() {
            let i = node as usize;
            let (sums, inverse) = (upper.padded_row(i, x), self.inverse_diagonal[i]);
            for (x, sums) in x[i].iter_mut().zip(sums) {
                for (x, sum) in x.iter_mut().zip(sums) {
                    *x = (*x - sum) * inverse;
                }
            }
            clear(i, &mut x[i]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Convection and diffusion on a line: the factors of a tridiagonal matrix are exact.
    fn line(n: usize, peclet: f64) -> Csr {
        let mut k = sprs::TriMatI::<f64, u32>::new((n, n));
        for i in 0..n {
            k.add_triplet(i, i, 2.0);
            if i > 0 {
                k.add_triplet(i, i - 1, -1.0 - peclet);
            }
            if i + 1 < n {
                k.add_triplet(i, i + 1, -1.0 + peclet);
            }
        }
        k.to_csr()
    }

    #[test]
    fn factors_of_a_tridiagonal_matrix_are_exact() {
        let (n, peclet) = (40, 3.0);
        let k = line(n, peclet);
        assert!(convection_dominates(&k) && !convection_dominates(&line(n, 0.1)));
        let stable = stabilised(&k);
        let constrained = ConstrainedDofs::new(n, &[(17, [false, true, false])]).unwrap();
        for constrained in [ConstrainedDofs::default(), constrained] {
            let factors = IncompleteLu::new(&stable, &constrained, 0.5);
            let mut x: Vec<[Padded; 1]> = (0..n)
                .map(|i| [[1.0, (i as f32).sin(), 0.5, 0.0]])
                .collect();
            constrained.clear_columns(&mut x);
            let exact = x.clone();
            let rows = Rows::new(&stable);
            let mut b: Vec<[Padded; 1]> = (0..n)
                .map(|i| {
                    let mut sum = [0.0; 4];
                    for (j, a) in rows.row(i) {
                        (0..4).for_each(|d| sum[d] += (0.5 * a) as f32 * x[j][0][d]);
                    }
                    [sum]
                })
                .collect();
            constrained.clear_columns(&mut b);
            factors.solve(&mut b);
            for (node, (b, x)) in b.iter().zip(&exact).enumerate() {
                // where node 17 is free, its elimination after 18 needs a place outside the pattern
                for d in (0..3).filter(|&d| constrained.is_empty() || d == 1) {
                    assert!((b[0][d] - x[0][d]).abs() < 2e-5, "{node} {d}");
                }
            }
        }
    }
}
