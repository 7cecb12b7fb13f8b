//! Smoothed aggregation for matrices of 3 x 3 blocks with several near-null vectors.
//!
//! After Vanek, Mandel, Brezina (Computing 56, 1996), section 4: the tentative prolongation is an
//! orthonormal basis of the near-null vectors on each aggregate, whose coefficients are the
//! near-null vectors of the coarse level.

use super::{Aggregates, is_coarser, standard_aggregates, strong_connections};
use crate::Csr;
use crate::chebyshev::JacobiScaling;
use crate::csr::{Rows, diagonal};
use crate::product::{build_rows, multiply};
use crate::vector::{dot, norm};

/// Norm of a near-null vector on an aggregate, over its norm before orthogonalisation, below which
/// it depends on those before it: rounding leaves 1e-16, a rotation of two adjacent nodes 1e-3.
const DEPENDENT: f64 = 1e-8;

/// Vectors that the operator almost maps to zero, on groups of nodes that are aggregated together.
pub(crate) struct NearNullSpace {
    /// Number of vectors: 3 or 6.
    vectors: usize,
    /// Dofs of a group: 3 on the finest level, one per vector on the others.
    group: usize,
    /// The vectors, one row of them per dof.
    values: Vec<f64>,
}

impl NearNullSpace {
    /// The three translations of `nodes` nodes.
    pub fn translations(nodes: usize) -> Self {
        NearNullSpace {
            vectors: 3,
            group: 3,
            values: (0..9 * nodes)
                .map(|k| unit_entry(k % 9 / 3, k % 3))
                .collect(),
        }
    }

    /// The translations, and the rotations `e_k x (position - centre)`.
    pub fn rigid_motions(positions: &[[f64; 3]]) -> Self {
        let count = positions.len().max(1) as f64;
        let centre: [f64; 3] =
            std::array::from_fn(|d| positions.iter().map(|x| x[d]).sum::<f64>() / count);
        let mut values = Vec::with_capacity(18 * positions.len());
        for position in positions {
            let [x, y, z] = std::array::from_fn(|d| position[d] - centre[d]);
            let rotations = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]];
            for (d, rotation) in rotations.into_iter().enumerate() {
                values.extend((0..3).map(|c| unit_entry(d, c)));
                values.extend(rotation);
            }
        }
        NearNullSpace {
            vectors: 6,
            group: 3,
            values,
        }
    }

    fn of_dof(&self, dof: usize) -> &[f64] {
        &self.values[self.vectors * dof..self.vectors * (dof + 1)]
    }
}

fn unit_entry(row: usize, column: usize) -> f64 {
    f64::from(u8::from(row == column))
}

/// Prolongation from the next coarser level, three interleaved dofs per node, and the near-null
/// vectors there; `None` if aggregation no longer coarsens.
pub(crate) fn prolongation(
    k: &Csr,
    scaling: &JacobiScaling,
    near_null: &NearNullSpace,
    threshold: f64,
) -> Option<(Csr, NearNullSpace)> {
    let norms = group_norms(k, near_null.group);
    let strong = strong_connections(&norms, &diagonal(&norms), threshold);
    let aggregates = standard_aggregates(&strong, &vec![0; norms.rows()]);
    let coarse_dofs = near_null.vectors * aggregates.count;
    if !is_coarser(coarse_dofs, k.rows()) {
        return None;
    }
    let (tentative, coarse) = tentative(k, &aggregates, near_null);
    let product = multiply(k, &tentative);
    let (t, kt) = (Rows::new(&tentative), Rows::new(&product));
    let omega = scaling.prolongation_factor();
    let smoothed = build_rows(k.rows(), coarse_dofs, |i, row| {
        if t.indptr[i] == t.indptr[i + 1] {
            return;
        }
        for (j, value) in t.row(i) {
            row.add(j, value);
        }
        for (j, value) in kt.row(i) {
            row.add(j, -omega / scaling.diagonal[i] * value);
        }
    });
    Some((smoothed, coarse))
}

/// The Frobenius norms of the blocks of `group` dofs.
fn group_norms(k: &Csr, group: usize) -> Csr {
    let rows = Rows::new(k);
    let n = k.rows() / group;
    let squares = build_rows(n, n, |i, row| {
        for dof in group * i..group * (i + 1) {
            for (j, value) in rows.row(dof) {
                row.add(j / group, value * value);
            }
        }
    });
    squares.map(|square| square.sqrt())
}

/// Orthonormal near-null vectors on each aggregate, and their coefficients on the coarse level.
///
/// Dofs without off-diagonal nonzeros are left out. A vector that depends on those before it leaves
/// an empty column.
fn tentative(k: &Csr, aggregates: &Aggregates, near_null: &NearNullSpace) -> (Csr, NearNullSpace) {
    let (m, group) = (near_null.vectors, near_null.group);
    let rows = Rows::new(k);
    let coupled = |dof: usize| rows.row(dof).any(|(j, value)| j != dof && value != 0.0);
    let mut dofs = vec![Vec::new(); aggregates.count];
    for (node, aggregate) in aggregates.of_node.iter().enumerate() {
        if let Some(aggregate) = aggregate {
            let own = group * node..group * (node + 1);
            dofs[*aggregate as usize].extend(own.filter(|&dof| coupled(dof)));
        }
    }
    let mut entries = vec![0.0; m * k.rows()];
    let mut coefficients = vec![0.0; m * m * aggregates.count];
    for (dofs, r) in dofs.iter().zip(coefficients.chunks_exact_mut(m * m)) {
        let mut basis: Vec<Vec<f64>> = Vec::with_capacity(m);
        for c in 0..m {
            let mut v: Vec<f64> = dofs.iter().map(|&dof| near_null.of_dof(dof)[c]).collect();
            let before = norm(&v);
            // twice, so that nearly dependent vectors become orthogonal
            for _ in 0..2 {
                for (b, q) in basis.iter().enumerate() {
                    let product = dot(q, &v);
                    r[m * b + c] += product;
                    v.iter_mut().zip(q).for_each(|(v, q)| *v -= product * q);
                }
            }
            let rest = norm(&v);
            if rest > DEPENDENT * before {
                r[m * c + c] = rest;
                v.iter_mut().for_each(|v| *v /= rest);
            } else {
                v.fill(0.0);
            }
            basis.push(v);
        }
        for (at, &dof) in dofs.iter().enumerate() {
            for (c, q) in basis.iter().enumerate() {
                entries[m * dof + c] = q[at];
            }
        }
    }
    let matrix = build_rows(k.rows(), m * aggregates.count, |dof, row| {
        if let Some(aggregate) = aggregates.of_node[dof / group] {
            for c in 0..m {
                let value = entries[m * dof + c];
                if value != 0.0 {
                    row.add(m * aggregate as usize + c, value);
                }
            }
        }
    });
    let coarse = NearNullSpace {
        vectors: m,
        group: m,
        values: coefficients,
    };
    (matrix, coarse)
}

/// The matrix with the mean diagonal entry in its empty rows, those of empty columns of `P`.
///
/// Nothing is restricted to such dofs, so that they remain zero.
pub(crate) fn regularised(k: Csr) -> Csr {
    let found = diagonal(&k);
    let empty = |d: f64| d <= 0.0;
    if !found.iter().any(|&d| empty(d)) {
        return k;
    }
    let mean = found.iter().sum::<f64>() / found.len() as f64;
    let rows = Rows::new(&k);
    build_rows(k.rows(), k.cols(), |i, row| {
        for (j, value) in rows.row(i) {
            row.add(j, value);
        }
        if empty(found[i]) {
            row.add(i, mean);
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tentative prolongation reproduces the rigid motions from their coefficients, also where
    /// collinear nodes make a rotation dependent.
    #[test]
    fn rigid_motions_are_reproduced() {
        let positions = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [2.5, 0.0, 0.0],
            [4.0, 1.0, 0.0],
        ];
        let near_null = NearNullSpace::rigid_motions(&positions);
        let mut t = sprs::TriMatI::<f64, u32>::new((12, 12));
        (0..12).for_each(|i| (0..12).for_each(|j| t.add_triplet(i, j, 1.0)));
        let aggregates = Aggregates {
            of_node: vec![Some(0), Some(0), Some(0), Some(1)],
            count: 2,
        };
        let (matrix, coarse) = tentative(&t.to_csr(), &aggregates, &near_null);
        let rows = Rows::new(&matrix);
        for dof in 0..12 {
            for v in 0..6 {
                let found: f64 = rows.row(dof).map(|(j, p)| p * coarse.of_dof(j)[v]).sum();
                approx::assert_abs_diff_eq!(found, near_null.of_dof(dof)[v], epsilon = 1e-14);
            }
        }
        // three collinear nodes have five independent rigid motions, a single node three
        let used = |columns: std::ops::Range<usize>| {
            let filled = |c| (0..12).any(|i| rows.entry(i, c) != 0.0);
            columns.filter(|&c| filled(c)).count()
        };
        assert_eq!((used(0..6), used(6..12)), (5, 3));
    }
}
