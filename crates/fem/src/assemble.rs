//! Numeric phase of the assembly: one parallel kernel for every bilinear form.
//!
//! Matrices are assembled row by row: the row of a node collects the contributions of the cells
//! around the node in ascending order of the cells. Tasks therefore own disjoint rows, need no
//! locks, and the result does not depend on the number of threads. The data that all rows of a
//! cell use is computed once per cell: a few numbers for an affine cell, the whole element matrix
//! for a curved one.

use mesh::TetMesh;
use rayon::prelude::*;
use sprs::CsMatI;

use crate::geometry::{Affine, CellNodes};
use crate::pattern::{ROWS_PER_TASK, split_rows};
use crate::{FemError, TaylorHood};

/// A bilinear form whose element matrices have `R` rows and `C` columns.
pub(crate) trait Form<const R: usize, const C: usize>: Sync {
    /// Entry of the element matrix for a pair of shape functions.
    type Entry: Entry;
    /// Data of an affine cell that all its rows use.
    type AffineData: Copy + Send + Sync;

    /// Computes the data of an affine cell that all its rows use.
    fn affine_data(&self, cell: usize, affine: &Affine) -> Self::AffineData;

    /// Row `local` of the element matrix of an affine cell.
    fn affine_row(data: &Self::AffineData, local: usize) -> [Self::Entry; C];

    /// Element matrix of a curved cell.
    fn curved(&self, cell: usize, nodes: &CellNodes) -> Result<[[Self::Entry; C]; R], FemError>;
}

/// Matrix of assembled values with a copy of the given sparsity pattern.
pub(crate) fn matrix_on_pattern<T: Copy>(
    shape: (usize, usize),
    row_starts: &[usize],
    columns: &[u32],
    values: Vec<T>,
) -> CsMatI<T, u32, usize> {
    let (starts, columns) = rayon::join(
        || row_starts.to_vec(),
        // In parallel, so that each thread is the first to touch its part of the pages of the copy.
        || columns.par_iter().copied().collect(),
    );
    CsMatI::new(shape, starts, columns, values)
}

/// A matrix entry to which the contributions of cells are added.
pub(crate) trait Entry: Copy + Default + Send + Sync {
    /// `self <- self + contribution`.
    fn add(&mut self, contribution: Self);
}

impl Entry for f64 {
    fn add(&mut self, contribution: Self) {
        *self += contribution;
    }
}

impl Entry for [f64; 3] {
    fn add(&mut self, contribution: Self) {
        for c in 0..3 {
            self[c] += contribution[c];
        }
    }
}

/// Data of a cell, computed before the rows are assembled.
enum Prepared<S> {
    Affine(S),
    /// Index into the list of the element matrices of the curved cells.
    Curved(usize),
}

impl TaylorHood {
    /// Values of `form` in the rows of the pattern that `row_starts` delimits.
    pub(crate) fn assemble<const R: usize, const C: usize, F: Form<R, C>>(
        &self,
        mesh: &TetMesh,
        row_starts: &[usize],
        form: &F,
    ) -> Result<Vec<F::Entry>, FemError> {
        self.check(mesh)?;
        let (prepared, curved) = prepare(mesh, form)?;
        let mut values = vec![F::Entry::default(); row_starts[row_starts.len() - 1]];
        split_rows(&mut values, row_starts)
            .into_par_iter()
            .enumerate()
            .for_each(|(task, values)| {
                // A fresh page of memory that is read before it is written is mapped twice, and
                // the second mapping interrupts all cores.
                values.fill(F::Entry::default());
                let first = task * ROWS_PER_TASK;
                let last = (first + ROWS_PER_TASK).min(row_starts.len() - 1);
                for row in first..last {
                    let start = row_starts[row] - row_starts[first];
                    let values = &mut values[start..];
                    for k in
                        self.pattern.incidence_starts[row]..self.pattern.incidence_starts[row + 1]
                    {
                        let positions = &self.pattern.positions[k];
                        let incidence = self.pattern.incidences[k];
                        let contributions = match &prepared[incidence.cell()] {
                            Prepared::Affine(data) => F::affine_row(data, incidence.local()),
                            Prepared::Curved(index) => curved[*index][incidence.local()],
                        };
                        for j in 0..C {
                            values[positions[j] as usize].add(contributions[j]);
                        }
                    }
                }
            });
        Ok(values)
    }

    /// Matrix on the quadratic elements with the given values.
    pub(crate) fn node_matrix<T: Copy>(&self, values: Vec<T>) -> CsMatI<T, u32, usize> {
        let shape = (self.n_points(), self.n_points());
        let pattern = &self.pattern;
        matrix_on_pattern(shape, &pattern.row_starts, &pattern.columns, values)
    }
}

/// Data of all cells, and the element matrices of the curved ones.
type PreparedCells<const R: usize, const C: usize, F> = (
    Vec<Prepared<<F as Form<R, C>>::AffineData>>,
    Vec<[[<F as Form<R, C>>::Entry; C]; R]>,
);

/// Prepares all cells in parallel.
fn prepare<const R: usize, const C: usize, F: Form<R, C>>(
    mesh: &TetMesh,
    form: &F,
) -> Result<PreparedCells<R, C, F>, FemError> {
    let mut prepared: Vec<_> = (0..mesh.cells().len())
        .into_par_iter()
        .with_min_len(ROWS_PER_TASK)
        .map(|_| Prepared::Curved(0))
        .collect();
    // In place, because one thread would have to join the lists of collected results. The error
    // names the invalid cell of the lowest number, for any number of threads.
    let first_error = prepared
        .par_iter_mut()
        .with_min_len(ROWS_PER_TASK)
        .enumerate()
        .filter(|(cell, _)| mesh.is_affine(*cell))
        .filter_map(
            |(cell, prepared)| match Affine::new(cell, &mesh.cell_points(cell)) {
                Ok(affine) => {
                    *prepared = Prepared::Affine(form.affine_data(cell, &affine));
                    None
                }
                Err(error) => Some((cell, error)),
            },
        )
        .min_by_key(|(cell, _)| *cell);
    if let Some((_, error)) = first_error {
        return Err(error);
    }
    let mut curved_cells = Vec::new();
    for (cell, prepared) in prepared.iter_mut().enumerate() {
        if let Prepared::Curved(index) = prepared {
            *index = curved_cells.len();
            curved_cells.push(cell);
        }
    }
    let matrix = |&cell: &usize| form.curved(cell, &mesh.cell_points(cell));
    let curved: Result<Vec<_>, _> = curved_cells.par_iter().map(matrix).collect();
    // If a cell is invalid, repeat in order: the error names the invalid cell of the lowest number.
    let curved = curved.or_else(|_| curved_cells.iter().map(matrix).collect())?;
    Ok((prepared, curved))
}
