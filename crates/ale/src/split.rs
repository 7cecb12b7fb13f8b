//! Free and prescribed vertices, and the systems that are left for the free ones.

use linalg::{Csr, KrylovParams, LinalgError, LinearOperator, Preconditioner, cg};
use mesh::Vec3;
use rayon::prelude::*;

/// The relative residual to which extensions are solved.
///
/// An extension need not be accurate, only smooth: any field with the right boundary values is a valid mesh
/// motion. 1e-8 keeps its error below that of the coordinates in f32 pictures and costs a few iterations.
const TOLERANCE: f64 = 1e-8;

/// Rows handled as one task.
const ROWS_PER_TASK: usize = 512;

/// The vertices whose displacement is sought.
pub(crate) struct Split {
    free: Vec<usize>,
    /// Number among the free vertices; `u32::MAX` where prescribed.
    number: Vec<u32>,
}

impl Split {
    pub fn new(prescribed: &[bool]) -> Self {
        let free: Vec<usize> = (0..prescribed.len()).filter(|&v| !prescribed[v]).collect();
        let mut number = vec![u32::MAX; prescribed.len()];
        for (index, &vertex) in free.iter().enumerate() {
            number[vertex] = index as u32;
        }
        Self { free, number }
    }

    /// Number of free vertices.
    pub fn len(&self) -> usize {
        self.free.len()
    }

    /// The rows and columns of the free vertices of a matrix with `components` rows a vertex.
    pub fn free_block(&self, matrix: &Csr, components: usize) -> Csr {
        let (mut starts, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
        let rows = self
            .free
            .iter()
            .flat_map(|v| (0..components).map(move |c| components * v + c));
        for row in rows {
            if let Some(row) = matrix.outer_view(row) {
                for (column, &value) in row.iter() {
                    let vertex = self.number[column / components];
                    if vertex != u32::MAX {
                        columns.push(components as u32 * vertex + (column % components) as u32);
                        values.push(value);
                    }
                }
            }
            starts.push(columns.len());
        }
        let n = components * self.free.len();
        Csr::new((n, n), starts, columns, values)
    }

    /// Three interleaved components a free vertex.
    pub fn gather(&self, field: &[Vec3]) -> Vec<f64> {
        self.free
            .iter()
            .flat_map(|&v| <[f64; 3]>::from(field[v]))
            .collect()
    }

    /// The reverse of [`Split::gather`]; prescribed vertices are left as they are.
    pub fn scatter(&self, values: &[f64], field: &mut [Vec3]) {
        for (value, &vertex) in values.as_chunks::<3>().0.iter().zip(&self.free) {
            field[vertex] = Vec3::from(*value);
        }
    }

    /// Extends fields by `A d = 0` at the free vertices: `apply` is `A` on all vertices, `operator` its free block.
    pub fn solve(
        &self,
        apply: &dyn Fn(&[Vec3]) -> Vec<Vec3>,
        operator: &dyn LinearOperator,
        preconditioner: &mut dyn Preconditioner,
        params: &KrylovParams,
        fields: &mut [Vec<Vec3>],
    ) -> Result<(), LinalgError> {
        for field in fields {
            self.scatter(&vec![0.0; 3 * self.len()], field);
            let mut right = self.gather(&apply(field));
            right.iter_mut().for_each(|value| *value = -*value);
            let mut solution = vec![0.0; right.len()];
            cg(operator, preconditioner, &right, &mut solution, params)?;
            self.scatter(&solution, field);
        }
        Ok(())
    }
}

/// When to stop, with so many iterations at most.
pub(crate) fn krylov(max_iterations: usize) -> KrylovParams {
    KrylovParams::default()
        .with_rel_tol(TOLERANCE)
        .with_max_iterations(max_iterations)
}

/// `K d` for a scalar matrix and three components. Rows are summed in the order of their columns, whatever the number of threads.
pub(crate) fn scalar_product(matrix: &Csr, d: &[Vec3]) -> Vec<Vec3> {
    let mut product = vec![Vec3::zeros(); matrix.rows()];
    product
        .par_iter_mut()
        .with_min_len(ROWS_PER_TASK)
        .enumerate()
        .for_each(|(row, sum)| {
            if let Some(row) = matrix.outer_view(row) {
                *sum = row.iter().map(|(column, &value)| value * d[column]).sum();
            }
        });
    product
}

/// `y = A x`, as [`scalar_product`].
pub(crate) fn product(matrix: &Csr, x: &[f64], y: &mut [f64]) {
    y.par_iter_mut()
        .with_min_len(ROWS_PER_TASK)
        .enumerate()
        .for_each(|(row, sum)| {
            if let Some(row) = matrix.outer_view(row) {
                *sum = row.iter().map(|(column, &value)| value * x[column]).sum();
            }
        });
}
