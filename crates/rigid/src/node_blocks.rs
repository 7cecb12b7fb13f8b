//! Blocks of finite-element matrices by the roles of their nodes: free nodes and rigid motions.

use linalg::{Csr, Csr3};
use nalgebra::{DMatrix, Matrix3, Vector3};
use rayon::prelude::*;
use sprs::{CsMatI, CsVecViewI};

use crate::NodeRole;

/// Marks a node that is not free.
pub(crate) const NOT_FREE: u32 = u32::MAX;

/// Products of matrices over all nodes with the rigid motions `P` of bodies.
pub(crate) struct NodeBlocks<'a> {
    pub roles: &'a [NodeRole],
    pub arms: &'a [Vector3<f64>],
    pub bodies: usize,
}

/// Weighted sum of rigid motions of one body: `sum_b w_b u_b = s U + ω × g`.
struct RigidSum {
    body: usize,
    weight: f64,
    moment: Vector3<f64>,
}

impl RigidSum {
    /// The sum of `body`, inserted as zero if there is none; sums stay sorted by body.
    fn of(sums: &mut Vec<RigidSum>, body: usize) -> &mut RigidSum {
        let place = sums
            .binary_search_by_key(&body, |s| s.body)
            .unwrap_or_else(|place| {
                let (weight, moment) = (0.0, Vector3::zeros());
                sums.insert(
                    place,
                    RigidSum {
                        body,
                        weight,
                        moment,
                    },
                );
                place
            });
        &mut sums[place]
    }
}

impl NodeBlocks<'_> {
    /// `A_IB P`: three rows for each of `rows`, six columns per body.
    pub fn border(&self, matrix: &Csr, rows: &[u32]) -> Csr {
        // most rows have no column on a body: flags of one byte per node stay in the cache while
        // the rows are searched
        let is_body = |role: &NodeRole| matches!(role, NodeRole::Body(_));
        let on_body: Vec<bool> = self.roles.iter().map(is_body).collect();
        from_groups(
            6 * self.bodies,
            rows.len(),
            |group, part: &mut Part<f64>| {
                let mut sums: Vec<RigidSum> = Vec::new();
                let meets_body = |view: &CsVecViewI<f64, u32>| {
                    view.indices()
                        .iter()
                        .any(|&column| on_body[column as usize])
                };
                let view = matrix.outer_view(rows[group] as usize);
                if let Some(view) = view.filter(meets_body) {
                    for (column, &value) in view.iter() {
                        let NodeRole::Body(body) = self.roles[column] else {
                            continue;
                        };
                        let sum = RigidSum::of(&mut sums, body as usize);
                        sum.weight += value;
                        sum.moment += value * self.arms[column];
                    }
                }
                for axis in 0..3 {
                    for sum in &sums {
                        // (ω × g)_a = ω_{a+1} g_{a+2} - ω_{a+2} g_{a+1}, indices modulo 3
                        let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
                        let mut entries = [
                            (axis, sum.weight),
                            (3 + next, sum.moment[last]),
                            (3 + last, -sum.moment[next]),
                        ];
                        entries.sort_by_key(|e| e.0);
                        for (column, value) in entries {
                            part.push(6 * sum.body + column, value);
                        }
                    }
                    part.end_row();
                }
            },
        )
    }

    /// `B_B P`: row `q` contains `(sum b, sum r × b)` for each body.
    pub fn rigid_divergence(&self, divergence: &Csr3) -> Csr {
        from_groups(
            6 * self.bodies,
            divergence.rows(),
            |row, part: &mut Part<f64>| {
                let mut sums: Vec<(usize, Vector3<f64>, Vector3<f64>)> = Vec::new();
                if let Some(view) = divergence.outer_view(row) {
                    for (column, &value) in view.iter() {
                        let NodeRole::Body(body) = self.roles[column] else {
                            continue;
                        };
                        let body = body as usize;
                        let place =
                            sums.binary_search_by_key(&body, |s| s.0)
                                .unwrap_or_else(|place| {
                                    sums.insert(place, (body, Vector3::zeros(), Vector3::zeros()));
                                    place
                                });
                        let b = Vector3::from(value);
                        sums[place].1 += b;
                        sums[place].2 += self.arms[column].cross(&b);
                    }
                }
                for (body, force, torque) in sums {
                    for (k, &value) in force.iter().chain(torque.iter()).enumerate() {
                        part.push(6 * body + k, value);
                    }
                }
                part.end_row();
            },
        )
    }

    /// `P^T K_BB P`, dense.
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

/// The given rows of a matrix, in that order, and the columns that have a number, renumbered.
///
/// Takes the matrix by value, compressed by rows, and frees it as soon as the block is complete.
/// Cost: two passes over the rows.
pub(crate) fn block<T: Copy + Default + Send + Sync>(
    matrix: CsMatI<T, u32, usize>,
    rows: &[u32],
    number: &[u32],
    columns: usize,
) -> CsMatI<T, u32, usize> {
    let (from, old_columns, old_values) = (
        matrix.indptr().into_raw_storage(),
        matrix.indices(),
        matrix.data(),
    );
    let entries = |row: u32| from[row as usize]..from[row as usize + 1];
    let is_kept = |column: &u32| number[*column as usize] != NOT_FREE;
    let lengths: Vec<usize> = rows
        .par_iter()
        .map(|&row| {
            old_columns[entries(row)]
                .iter()
                .filter(|c| is_kept(c))
                .count()
        })
        .collect();
    let mut starts = Vec::with_capacity(rows.len() + 1);
    starts.push(0);
    let mut end = 0;
    for length in lengths {
        end += length;
        starts.push(end);
    }
    let (mut indices, mut values) = (vec![0; end], vec![T::default(); end]);
    let (mut later_indices, mut later_values) = (&mut indices[..], &mut values[..]);
    let mut tasks = Vec::with_capacity(rows.len().div_ceil(GROUPS_PER_TASK));
    for (task, rows) in rows.chunks(GROUPS_PER_TASK).enumerate() {
        let first = task * GROUPS_PER_TASK;
        let own = starts[first + rows.len()] - starts[first];
        let (indices, others) = later_indices.split_at_mut(own);
        later_indices = others;
        let (values, others) = later_values.split_at_mut(own);
        later_values = others;
        tasks.push((rows, indices, values));
    }
    tasks.into_par_iter().for_each_init(
        Vec::new,
        |sorted: &mut Vec<u64>, (rows, indices, values)| {
            let mut place = 0;
            for &row in rows {
                let old = entries(row);
                let (old_columns, old_values) = (&old_columns[old.clone()], &old_values[old]);
                // a column and its old position in one word, which is sorted several times as fast
                // as pairs of a column and a value
                sorted.clear();
                for (place, &column) in old_columns.iter().enumerate() {
                    let column = number[column as usize];
                    if column != NOT_FREE {
                        sorted.push(u64::from(column) << 32 | place as u64);
                    }
                }
                sorted.sort_unstable();
                for &word in sorted.iter() {
                    indices[place] = (word >> 32) as u32;
                    values[place] = old_values[word as u32 as usize];
                    place += 1;
                }
            }
        },
    );
    CsMatI::new((rows.len(), columns), starts, indices, values)
}

/// Number of row groups that one task builds.
const GROUPS_PER_TASK: usize = 4096;

/// Consecutive rows of a compressed matrix.
struct Part<T> {
    lengths: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<T>,
    /// Number of entries before the current row.
    before: usize,
}

impl<T> Part<T> {
    /// Appends an entry to the current row; columns ascend.
    fn push(&mut self, column: usize, value: T) {
        self.columns.push(column as u32);
        self.values.push(value);
    }

    fn end_row(&mut self) {
        self.lengths.push(self.columns.len() - self.before);
        self.before = self.columns.len();
    }
}

/// A compressed matrix from a closure that appends the rows of a group.
fn from_groups<T: Copy + Send + Sync>(
    columns: usize,
    groups: usize,
    group: impl Fn(usize, &mut Part<T>) + Sync,
) -> CsMatI<T, u32, usize> {
    let parts: Vec<Part<T>> = (0..groups.div_ceil(GROUPS_PER_TASK))
        .into_par_iter()
        .map(|task| {
            let mut part = Part {
                lengths: Vec::new(),
                columns: Vec::new(),
                values: Vec::new(),
                before: 0,
            };
            for g in task * GROUPS_PER_TASK..groups.min((task + 1) * GROUPS_PER_TASK) {
                group(g, &mut part);
            }
            part
        })
        .collect();
    let rows = parts.iter().map(|p| p.lengths.len()).sum();
    let entries = parts.iter().map(|p| p.columns.len()).sum();
    let mut pointers = Vec::with_capacity(rows + 1);
    let (mut indices, mut values) = (Vec::with_capacity(entries), Vec::with_capacity(entries));
    let mut end = 0;
    pointers.push(0);
    for part in parts {
        for length in part.lengths {
            end += length;
            pointers.push(end);
        }
        indices.extend(part.columns);
        values.extend(part.values);
    }
    // Rows are in order and their columns ascend by construction, so the structure is valid.
    CsMatI::new((rows, columns), pointers, indices, values)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows 2 and 0 of three, columns 2 and 1 renumbered as 0 and 1.
    #[test]
    fn a_block_is_renumbered_and_sorted() {
        let matrix = Csr::new(
            (3, 3),
            vec![0, 3, 4, 6],
            vec![0, 1, 2, 0, 1, 2],
            vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
        );
        let found = block(matrix, &[2, 0], &[NOT_FREE, 1, 0], 2);
        let expected = Csr::new(
            (2, 2),
            vec![0, 2, 4],
            vec![0, 1, 0, 1],
            vec![6.0, 5.0, 3.0, 2.0],
        );
        assert_eq!(found, expected);
    }

    /// A tridiagonal matrix in reversed order, over several tasks: each value encodes its position.
    #[test]
    fn long_blocks_are_split_into_tasks() {
        let n = 2 * GROUPS_PER_TASK + 100;
        let band = |i: usize| i.saturating_sub(1)..(i + 2).min(n);
        let mut starts = vec![0];
        (0..n).for_each(|i| starts.push(starts[i] + band(i).len()));
        let columns = (0..n).flat_map(band).map(|j| j as u32).collect();
        let values = (0..n)
            .flat_map(|i| band(i).map(move |j| (i * n + j) as f64))
            .collect();
        let matrix = Csr::new((n, n), starts, columns, values);
        let reversed: Vec<u32> = (0..n as u32).rev().collect();
        let found = block(matrix, &reversed, &reversed, n);
        for (i, row) in found.outer_iterator().enumerate() {
            let old = n - 1 - i;
            let expected = band(old).rev().map(|j| (n - 1 - j, (old * n + j) as f64));
            assert!(row.iter().map(|(j, &v)| (j, v)).eq(expected), "row {i}");
        }
    }
}
