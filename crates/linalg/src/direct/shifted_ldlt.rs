//! Direct solver for a sparse symmetric saddle-point system given as one matrix.

use super::factor::{Definiteness, Precision, SparseFactor};
use super::nested_dissection;
use crate::csr::{Rows, check_finite, check_shape, into_rows};
use crate::product::build_rows;
use crate::vector::{norm, rhs_norm};
use crate::{Csr, LinalgError};

/// Refinement steps after which a system counts as singular.
///
/// In a regular system each step gains seven digits.
const MAX_REFINEMENTS: usize = 12;

/// Relative true residual that every solution reaches; most are two digits better.
const MAX_RESIDUAL: f64 = 1e-11;

/// Direct solver for `A = [K B^T; B 0]` by factors of `A - diag(shift)`, and refinement.
///
/// `A` is symmetric and `K` positive definite.
///
/// With a positive shift on the rows of `B` the matrix is quasi-definite and has factors in any
/// elimination order (Vanderbei 1995). With a shift of `1e-8` times the diagonal of `B K^-1 B^T`
/// each refinement step on the true system gains seven digits, even if the dofs of the rows of `B`
/// are determined up to a constant only. Meant for a few ten thousand dofs in two dimensions, where
/// multigrid does not pay.
///
/// Cost: `N log N` memory and `N^1.5` time for elements in the plane.
pub struct ShiftedLdlt {
    matrix: Csr,
    factor: SparseFactor,
}

impl ShiftedLdlt {
    /// Orders and factorises `matrix`, which contains both triangles.
    ///
    /// `shift` has one number per dof, zero on the rows of `K`. `group[i]` is the number, from
    /// zero, of the group in which dof `i` is eliminated. A group consists of the dofs of one cell,
    /// edge or node, whose rows have the same pattern.
    ///
    /// # Errors
    /// [`LinalgError::Shape`], [`LinalgError::NotFinite`], [`LinalgError::Parameter`] for a group
    /// that is not below the number of dofs, [`LinalgError::Factorisation`] for a singular matrix
    /// or an unsymmetric pattern.
    pub fn factor(matrix: Csr, shift: &[f64], group: &[u32]) -> Result<Self, LinalgError> {
        let n = matrix.rows();
        check_shape("saddle-point matrix", matrix.shape(), (n, n))?;
        check_shape("shift", (shift.len(), 1), (n, 1))?;
        check_shape("groups of dofs", (group.len(), 1), (n, 1))?;
        check_finite("saddle-point matrix", matrix.data())?;
        check_finite("shift", shift)?;
        if let Some(&outside) = group.iter().find(|&&g| g as usize >= n) {
            return Err(LinalgError::Parameter {
                name: "group of a dof",
                value: outside.into(),
                range: "below the number of dofs",
            });
        }
        let matrix = into_rows(matrix);
        let rows = Rows::new(&matrix);
        let shifted = build_rows(n, n, |i, row| {
            for (j, v) in rows.row(i) {
                row.add(j, v);
            }
            row.add(i, -shift[i]);
        });
        let order = elimination_order(&matrix, group)?;
        let factor = SparseFactor::new(
            "saddle-point matrix",
            &shifted,
            &order,
            Definiteness::Quasi,
            Precision::Double,
            1,
        )?;
        Ok(Self { matrix, factor })
    }

    /// Number of nonzeros of the factor.
    pub fn nnz(&self) -> usize {
        self.factor.nnz()
    }

    /// Solves `A x = b` and returns the relative true residual.
    ///
    /// # Errors
    /// [`LinalgError::Shape`], [`LinalgError::NotFinite`], [`LinalgError::Parameter`] for a `b`
    /// whose squares overflow or underflow, [`LinalgError::Stagnated`] if refinement does not reach
    /// a residual of `1e-11`: the matrix is singular, and `b` is not in its range.
    pub fn solve(&mut self, b: &[f64], x: &mut [f64]) -> Result<f64, LinalgError> {
        let n = self.matrix.rows();
        check_shape("right-hand side", (b.len(), 1), (n, 1))?;
        check_shape("solution vector", (x.len(), 1), (n, 1))?;
        check_finite("right-hand side", b)?;
        x.fill(0.0);
        let Some(size) = rhs_norm(b, None)? else {
            return Ok(0.0);
        };
        let mut residual = b.to_vec();
        let mut best = f64::INFINITY;
        for step in 1..=MAX_REFINEMENTS {
            let mut correction = residual.clone();
            self.factor.solve_in_place(&mut correction);
            for (x, c) in x.iter_mut().zip(&correction) {
                *x += c;
            }
            self.residual(b, x, &mut residual);
            let left = norm(&residual) / size;
            // a reduction by less than a factor of two is rounding
            let stalls = left.is_nan() || left > 0.5 * best;
            best = left.min(best);
            if stalls || left == 0.0 || step == MAX_REFINEMENTS {
                break;
            }
        }
        if best <= MAX_RESIDUAL {
            return Ok(best);
        }
        Err(LinalgError::Stagnated {
            method: "direct solution with refinement",
            iterations: MAX_REFINEMENTS,
            true_rel_residual: best,
            target: MAX_RESIDUAL,
        })
    }

    fn residual(&self, b: &[f64], x: &[f64], r: &mut [f64]) {
        let rows = Rows::new(&self.matrix);
        for (i, r) in r.iter_mut().enumerate() {
            *r = b[i] - rows.row(i).map(|(j, v)| v * x[j]).sum::<f64>();
        }
    }
}

/// Elimination order of the dofs: nested dissection of the graph of groups.
///
/// The dofs of a group are ordered by number.
fn elimination_order(matrix: &Csr, group: &[u32]) -> Result<Vec<usize>, LinalgError> {
    let groups = group.iter().max().map_or(0, |&g| g as usize + 1);
    let mut members = vec![Vec::new(); groups];
    for (i, &g) in group.iter().enumerate() {
        members[g as usize].push(i);
    }
    let rows = Rows::new(matrix);
    let adjacency: Vec<Vec<u32>> = members
        .iter()
        .enumerate()
        .map(|(g, members)| {
            let met = members.iter().flat_map(|&i| rows.row(i));
            let mut list: Vec<u32> = met.map(|(j, _)| group[j]).collect();
            list.sort_unstable();
            list.dedup();
            list.retain(|&other| other as usize != g);
            list
        })
        .collect();
    let weights: Vec<u32> = members.iter().map(|m| m.len() as u32).collect();
    let order = nested_dissection(&adjacency, &weights)?;
    Ok(order.into_iter().flat_map(|g| members[g].clone()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of `n` dofs with `K = tridiag(-1, 2, -1)`, and a constraint on every fourth
    /// difference of neighbours.
    fn chain(n: usize, zero_sum: bool) -> (Csr, Vec<f64>, Vec<u32>) {
        let constraints = n / 4;
        let size = n + constraints;
        let matrix = build_rows(size, size, |i, row| {
            if i < n {
                row.add(i, 2.0);
                if i > 0 {
                    row.add(i - 1, -1.0);
                }
                if i + 1 < n {
                    row.add(i + 1, -1.0);
                }
                if i < 4 * constraints && i % 4 < 2 {
                    let sign = if i % 4 == 0 { 1.0 } else { -1.0 };
                    row.add(n + i / 4, sign);
                    if zero_sum {
                        // each constraint minus the next, cyclically: they sum to zero
                        row.add(n + (i / 4 + 1) % constraints, -sign);
                    }
                }
            } else {
                for k in 0..constraints {
                    for (offset, sign) in [(0, 1.0), (1, -1.0)] {
                        let column = 4 * k + offset;
                        if i - n == k {
                            row.add(column, sign);
                        }
                        if zero_sum && i - n == (k + 1) % constraints {
                            row.add(column, -sign);
                        }
                    }
                }
            }
        });
        let shift = (0..size).map(|i| if i < n { 0.0 } else { 1e-8 }).collect();
        let group = (0..size)
            .map(|i| if i < n { i / 4 } else { i - n } as u32)
            .collect();
        (matrix, shift, group)
    }

    #[test]
    fn solutions_fulfil_the_unshifted_system() {
        for zero_sum in [false, true] {
            let (matrix, shift, group) = chain(400, zero_sum);
            // a right-hand side in the range, also for dependent constraints
            let exact: Vec<f64> = (0..matrix.rows()).map(|i| (i as f64).sin()).collect();
            let rows = Rows::new(&matrix);
            let b: Vec<f64> = (0..matrix.rows())
                .map(|i| rows.row(i).map(|(j, v)| v * exact[j]).sum())
                .collect();
            let mut x = vec![0.0; b.len()];
            let mut solver = ShiftedLdlt::factor(matrix.clone(), &shift, &group).expect("sound");
            let residual = solver.solve(&b, &mut x).expect("compatible");
            assert!(residual < 1e-12 && solver.nnz() > 0);
            let worst = (0..400)
                .map(|i| (x[i] - exact[i]).abs())
                .fold(0.0, f64::max);
            assert!(worst < 1e-9, "{worst:e}");
        }
    }

    #[test]
    fn incompatible_systems_are_refused() {
        let (matrix, shift, group) = chain(400, true);
        let mut solver = ShiftedLdlt::factor(matrix, &shift, &group).expect("quasi-definite");
        let b: Vec<f64> = (0..500).map(|i| if i < 400 { 0.0 } else { 1.0 }).collect();
        let mut x = vec![0.0; 500];
        assert!(matches!(
            solver.solve(&b, &mut x),
            Err(LinalgError::Stagnated { .. })
        ));
        assert_eq!(solver.solve(&[0.0; 500], &mut x), Ok(0.0));
    }

    #[test]
    fn arrays_of_wrong_length_are_refused() {
        let (matrix, shift, group) = chain(8, false);
        assert!(ShiftedLdlt::factor(matrix.clone(), &shift[1..], &group).is_err());
        assert!(ShiftedLdlt::factor(matrix, &shift, &group[1..]).is_err());
    }

    #[test]
    fn bug_a_group_out_of_range_allocated_memory_for_all_groups_below_it() {
        let (matrix, shift, mut group) = chain(8, false);
        for outside in [10, u32::MAX] {
            group[3] = outside;
            let refused = ShiftedLdlt::factor(matrix.clone(), &shift, &group).map(|_| ());
            assert!(matches!(refused, Err(LinalgError::Parameter { .. })));
        }
    }

    #[test]
    fn bug_a_short_vector_ended_the_program() {
        let (matrix, shift, group) = chain(8, false);
        let mut solver = ShiftedLdlt::factor(matrix, &shift, &group).expect("sound");
        for (b, x) in [(9, 10), (10, 9), (0, 10), (11, 11)] {
            let refused = solver.solve(&vec![1.0; b], &mut vec![0.0; x]);
            assert!(matches!(refused, Err(LinalgError::Shape { .. })));
        }
    }
}
