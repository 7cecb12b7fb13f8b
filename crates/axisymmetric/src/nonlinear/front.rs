//! Elimination of the leading dofs of a dense matrix, by matrix products.
//!
//! ```text
//! [A_ii A_io]       [L    0] [U    V]
//! [A_oi A_oo]  = P^T[W    I] [0    S]
//! ```
//!
//! with partial pivoting `P` in the rows of `A_ii`. Columns are halved recursively (Toledo 1997),
//! so that almost all operations are products of large blocks, which are faster than updates by
//! single columns.

use std::ops::Range;

use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut, DVector};

/// Number of columns that are eliminated one by one.
const FEW_COLUMNS: usize = 16;

/// The factors of the leading block `i` and of its coupling with the others `o`.
pub(super) struct Eliminated {
    /// `L` below the diagonal of ones and `U`, then `W`.
    columns: DMatrix<f64>,
    /// `V`.
    rows: DMatrix<f64>,
    /// The row that was exchanged with each row, in their order.
    pivots: Vec<usize>,
}

/// Eliminates the first `inner` dofs of a matrix; returns the factors and the Schur complement
/// `S = A_oo - A_oi A_ii^-1 A_io`. `None` if `A_ii` is singular or not finite.
pub(super) fn eliminate(
    mut matrix: DMatrix<f64>,
    inner: usize,
) -> Option<(Eliminated, DMatrix<f64>)> {
    let size = matrix.nrows();
    let mut pivots = Vec::with_capacity(inner);
    factor_columns(&mut matrix, 0..inner, inner, &mut pivots)?;
    update(&mut matrix, 0..inner, inner..size);
    let outer = size - inner;
    let rows = matrix.view((0, inner), (inner, outer)).into_owned();
    // numbers that are not finite reach the last rows and columns
    if rows.iter().any(|value| !value.is_finite()) {
        return None;
    }
    let schur = matrix.view((inner, inner), (outer, outer)).into_owned();
    let columns = matrix.remove_columns(inner, outer);
    let eliminated = Eliminated {
        columns,
        rows,
        pivots,
    };
    Some((eliminated, schur))
}

impl Eliminated {
    /// Replaces the values of the inner dofs by `L^-1 P` of them; returns `W` times that, which
    /// is to be subtracted from the values of the outer ones.
    pub fn forward(&self, values: &mut DVector<f64>) -> DVector<f64> {
        let inner = self.pivots.len();
        for (row, &pivot) in self.pivots.iter().enumerate() {
            values.swap_rows(row, pivot);
        }
        for k in 0..inner {
            let value = values[k];
            let mut below = values.rows_range_mut(k + 1..);
            below.axpy(
                -value,
                &self.columns.column(k).rows_range(k + 1..inner),
                1.0,
            );
        }
        self.columns.rows_range(inner..) * &*values
    }

    /// Replaces the values `y` of the inner dofs by `U^-1 (y - V x)` with the outer ones `x`.
    pub fn backward(&self, values: &mut DVector<f64>, outer: &DVector<f64>) {
        values.gemv(-1.0, &self.rows, outer, 1.0);
        for k in (0..self.pivots.len()).rev() {
            values[k] /= self.columns[(k, k)];
            let value = values[k];
            let mut above = values.rows_range_mut(..k);
            above.axpy(-value, &self.columns.column(k).rows_range(..k), 1.0);
        }
    }
}

/// Factorises some columns, to which those before have been applied, with pivots in the first
/// `inner` rows.
fn factor_columns(
    matrix: &mut DMatrix<f64>,
    columns: Range<usize>,
    inner: usize,
    pivots: &mut Vec<usize>,
) -> Option<()> {
    if columns.len() <= FEW_COLUMNS {
        for k in columns.clone() {
            let pivot = k + matrix.column(k).rows_range(k..inner).iamax();
            pivots.push(pivot);
            matrix.swap_rows(k, pivot);
            let diagonal = matrix[(k, k)];
            if diagonal == 0.0 || !diagonal.is_finite() {
                return None;
            }
            let (mut own, mut later) = matrix.columns_range_pair_mut(k..k + 1, k + 1..columns.end);
            let mut below = own.column_mut(0);
            let mut below = below.rows_range_mut(k + 1..);
            below /= diagonal;
            for mut column in later.column_iter_mut() {
                let factor = column[k];
                column.rows_range_mut(k + 1..).axpy(-factor, &below, 1.0);
            }
        }
        return Some(());
    }
    let middle = columns.start + columns.len() / 2;
    factor_columns(matrix, columns.start..middle, inner, pivots)?;
    update(matrix, columns.start..middle, middle..columns.end);
    factor_columns(matrix, middle..columns.end, inner, pivots)
}

/// Applies factorised columns to later ones.
fn update(matrix: &mut DMatrix<f64>, done: Range<usize>, later: Range<usize>) {
    let (factors, mut later) = matrix.columns_range_pair_mut(done.clone(), later);
    let (mut upper, mut lower) = later.rows_range_pair_mut(done.clone(), done.end..);
    solve_unit_lower(
        factors.rows_range(done.clone()).as_view(),
        upper.as_view_mut(),
    );
    lower.gemm(-1.0, &factors.rows_range(done.end..), &upper, 1.0);
}

/// Solves with a lower triangular matrix whose diagonal is one.
fn solve_unit_lower(factor: DMatrixView<f64>, mut rhs: DMatrixViewMut<f64>) {
    let size = factor.nrows();
    if size <= FEW_COLUMNS {
        for mut column in rhs.column_iter_mut() {
            for k in 0..size {
                let value = column[k];
                let below = factor.column(k);
                (column.rows_range_mut(k + 1..)).axpy(-value, &below.rows_range(k + 1..), 1.0);
            }
        }
        return;
    }
    let middle = size / 2;
    let (mut upper, mut lower) = rhs.rows_range_pair_mut(..middle, middle..);
    solve_unit_lower(factor.view((0, 0), (middle, middle)), upper.as_view_mut());
    let rest = size - middle;
    lower.gemm(-1.0, &factor.view((middle, 0), (rest, middle)), &upper, 1.0);
    solve_unit_lower(
        factor.view((middle, middle), (rest, rest)),
        lower.as_view_mut(),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix whose leading block has a zero diagonal, so that it needs pivots.
    fn sample(size: usize) -> DMatrix<f64> {
        DMatrix::from_fn(size, size, |i, j| match i == j {
            true => 0.0,
            false => ((7 * i + 3 * j + i * j) as f64).sin() + f64::from(u8::from(i == j + 1)),
        })
    }

    #[test]
    fn factors_solve_the_whole_system_and_leave_the_schur_complement() {
        for (size, inner) in [(1, 1), (7, 3), (40, 40), (90, 61)] {
            let matrix = match size {
                1 => DMatrix::identity(1, 1),
                _ => sample(size),
            };
            let (eliminated, schur) = eliminate(matrix.clone(), inner).expect("regular");
            let outer = size - inner;
            let [ii, io, oi, oo] = [
                ((0, 0), (inner, inner)),
                ((0, inner), (inner, outer)),
                ((inner, 0), (outer, inner)),
                ((inner, inner), (outer, outer)),
            ]
            .map(|(at, shape)| matrix.view(at, shape).into_owned());
            let exact = &oo - &oi * ii.lu().solve(&io).expect("regular");
            let largest = exact.iter().fold(1.0, |m: f64, v| m.max(v.abs()));
            assert!(outer == 0 || (&schur - &exact).amax() < 1e-10 * largest);
            let x = DVector::from_fn(size, |i, _| (i as f64).cos());
            let rhs = &matrix * &x;
            let mut values = rhs.rows(0, inner).into_owned();
            let change = eliminated.forward(&mut values);
            let known = x.rows(inner, outer).into_owned();
            if outer > 0 {
                let reduced = rhs.rows(inner, outer) - change - &schur * &known;
                assert!(reduced.amax() < 1e-10 * rhs.amax());
            }
            eliminated.backward(&mut values, &known);
            assert!((values - x.rows(0, inner)).amax() < 1e-9);
        }
    }

    #[test]
    fn singular_and_infinite_blocks_are_refused() {
        let mut matrix = sample(6);
        matrix.row_mut(1).copy_from_slice(&[0.0; 6]);
        assert!(eliminate(matrix, 3).is_none());
        let mut matrix = sample(40);
        matrix[(2, 5)] = f64::NAN;
        assert!(eliminate(matrix, 30).is_none());
    }
}
