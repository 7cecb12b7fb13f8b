//! Blocks of finite-element matrices by the roles of their nodes: free rows and columns, and rigid motions.

use linalg::{Csr, Csr3};
use nalgebra::{DMatrix, Matrix3, Vector3};
use rayon::prelude::*;

use crate::NodeRole;

/// Marks a node that is no unknown.
pub(crate) const NOT_FREE: u32 = u32::MAX;

/// Nodes sorted by role, to cut matrices over all nodes into blocks.
pub(crate) struct NodeBlocks<'a> {
    pub roles: &'a [NodeRole],
    pub arms: &'a [Vector3<f64>],
    pub free_number: &'a [u32],
    pub bodies: usize,
}

/// Weighted sum of rigid motions of one body: $\sum_b w_b u_b = s U + \omega \times g$.
struct RigidSum {
    body: usize,
    weight: f64,
    moment: Vector3<f64>,
}

impl NodeBlocks<'_> {
    /// The rows and columns of free nodes; columns at and past `columns` do not occur.
    pub fn free_block(&self, matrix: &Csr, rows: &[u32], columns: usize) -> Csr {
        from_rows(
            columns,
            rows.len(),
            |row, indices: &mut Vec<u32>, values: &mut Vec<f64>| {
                if let Some(view) = matrix.outer_view(rows[row] as usize) {
                    for (column, &value) in view.iter() {
                        let number = self.free_number[column];
                        if number != NOT_FREE {
                            indices.push(number);
                            values.push(value);
                        }
                    }
                }
            },
        )
    }

    pub fn free_columns(&self, matrix: &Csr3, columns: usize) -> Csr3 {
        from_rows(
            columns,
            matrix.rows(),
            |row, indices: &mut Vec<u32>, values: &mut Vec<[f64; 3]>| {
                if let Some(view) = matrix.outer_view(row) {
                    for (column, &value) in view.iter() {
                        let number = self.free_number[column];
                        if number != NOT_FREE {
                            indices.push(number);
                            values.push(value);
                        }
                    }
                }
            },
        )
    }

    /// `A_{IB} P`: three rows for each of `rows`, six columns a body.
    pub fn border(&self, matrix: &Csr, rows: &[u32]) -> Csr {
        from_rows(
            6 * self.bodies,
            3 * rows.len(),
            |row, indices: &mut Vec<u32>, values: &mut Vec<f64>| {
                let Some(view) = matrix.outer_view(rows[row / 3] as usize) else {
                    return;
                };
                let mut sums: Vec<RigidSum> = Vec::new();
                for (column, &value) in view.iter() {
                    let NodeRole::Body(body) = self.roles[column] else {
                        continue;
                    };
                    let body = body as usize;
                    let place =
                        sums.binary_search_by_key(&body, |s| s.body)
                            .unwrap_or_else(|place| {
                                sums.insert(
                                    place,
                                    RigidSum {
                                        body,
                                        weight: 0.0,
                                        moment: Vector3::zeros(),
                                    },
                                );
                                place
                            });
                    sums[place].weight += value;
                    sums[place].moment += value * self.arms[column];
                }
                let axis = row % 3;
                for sum in sums {
                    // (omega x g)_axis = omega_{a+1} g_{a+2} - omega_{a+2} g_{a+1}
                    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
                    let mut entries = [
                        (axis, sum.weight),
                        (3 + next, sum.moment[last]),
                        (3 + last, -sum.moment[next]),
                    ];
                    entries.sort_by_key(|e| e.0);
                    for (column, value) in entries {
                        indices.push((6 * sum.body + column) as u32);
                        values.push(value);
                    }
                }
            },
        )
    }

    /// `B_B P`: row `q` holds `(sum b, sum r x b)` for each body.
    pub fn rigid_divergence(&self, divergence: &Csr3) -> Csr {
        from_rows(
            6 * self.bodies,
            divergence.rows(),
            |row, indices: &mut Vec<u32>, values: &mut Vec<f64>| {
                let Some(view) = divergence.outer_view(row) else {
                    return;
                };
                let mut sums: Vec<(usize, Vector3<f64>, Vector3<f64>)> = Vec::new();
                for (column, &value) in view.iter() {
                    let NodeRole::Body(body) = self.roles[column] else {
                        continue;
                    };
                    let body = body as usize;
                    let place = sums
                        .binary_search_by_key(&body, |s| s.0)
                        .unwrap_or_else(|place| {
                            sums.insert(place, (body, Vector3::zeros(), Vector3::zeros()));
                            place
                        });
                    let b = Vector3::from(value);
                    sums[place].1 += b;
                    sums[place].2 += self.arms[column].cross(&b);
                }
                for (body, force, torque) in sums {
                    indices.extend((0..6).map(|k| (6 * body + k) as u32));
                    values.extend(force.iter().chain(torque.iter()));
                }
            },
        )
    }

    /// `P^T K_{BB} P`, dense.
    pub fn corner(&self, stiffness: &Csr) -> DMatrix<f64> {
        let mut corner = DMatrix::zeros(6 * self.bodies, 6 * self.bodies);
        for (row, role) in self.roles.iter().enumerate() {
            let (&NodeRole::Body(own), Some(view)) = (role, stiffness.outer_view(row)) else {
                continue;
            };
            let own_arm = self.arms[row].cross_matrix();
            for (column, &value) in view.iter() {
                let NodeRole::Body(other) = self.roles[column] else {
                    continue;
                };
                let other_arm = self.arms[column].cross_matrix();
                let (i, j) = (6 * own as usize, 6 * other as usize);
                let mut add = |r: usize, c: usize, block: Matrix3<f64>| {
                    let mut view = corner.fixed_view_mut::<3, 3>(r, c);
                    view += value * block;
                };
                add(i, j, Matrix3::identity());
                add(i, j + 3, -other_arm);
                add(i + 3, j, own_arm);
                add(i + 3, j + 3, -own_arm * other_arm);
            }
        }
        corner
    }
}

/// Rows of a compressed matrix that are built together by one task.
const ROWS_A_TASK: usize = 4096;

/// A compressed matrix from a closure that appends the columns (ascending) and values of a row.
fn from_rows<T: Copy + Send + Sync>(
    columns: usize,
    rows: usize,
    row: impl Fn(usize, &mut Vec<u32>, &mut Vec<T>) + Sync,
) -> sprs::CsMatI<T, u32, usize> {
    let parts: Vec<(Vec<usize>, Vec<u32>, Vec<T>)> = (0..rows.div_ceil(ROWS_A_TASK))
        .into_par_iter()
        .map(|task| {
            let (mut lengths, mut indices, mut values) = (Vec::new(), Vec::new(), Vec::new());
            for r in task * ROWS_A_TASK..rows.min((task + 1) * ROWS_A_TASK) {
                let before = indices.len();
                row(r, &mut indices, &mut values);
                lengths.push(indices.len() - before);
            }
            (lengths, indices, values)
        })
        .collect();
    let entries = parts.iter().map(|p| p.1.len()).sum();
    let mut pointers = Vec::with_capacity(rows + 1);
    let (mut indices, mut values) = (Vec::with_capacity(entries), Vec::with_capacity(entries));
    pointers.push(0);
    for (lengths, part_indices, part_values) in parts {
        for length in lengths {
            pointers.push(pointers[pointers.len() - 1] + length);
        }
        indices.extend(part_indices);
        values.extend(part_values);
    }
    // Rows come in order with ascending columns by construction, so the structure is valid.
    sprs::CsMatI::new((rows, columns), pointers, indices, values)
}
