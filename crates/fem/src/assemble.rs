//! Numeric phase: one parallel kernel for every form.
//!
//! Rows are gathered, not scattered: the row of a node collects the contributions of the cells around it in ascending
//! order, so tasks own disjoint rows, need no locks, and the result does not depend on how many threads there are.
//! What a cell has in common for all its rows is prepared once: a few numbers on an affine cell, the whole element
//! matrix on a curved one.

use mesh::TetMesh;
use rayon::prelude::*;
use sprs::CsMatI;

use crate::geometry::{Affine, CellNodes};
use crate::pattern::{ROWS_PER_TASK, split_rows};
use crate::{FemError, TaylorHood};

/// A bilinear form with `R` rows and `C` columns a cell.
pub(crate) trait Form<const R: usize, const C: usize>: Sync {
    /// What a pair of unknowns contributes.
    type Entry: Entry;
    /// What all rows of an affine cell share.
    type Shared: Copy + Send + Sync;

    /// The shared part of an affine cell.
    fn share(&self, cell: usize, affine: &Affine) -> Self::Shared;

    /// Row `local` of the element matrix of an affine cell.
    fn affine_row(shared: &Self::Shared, local: usize) -> [Self::Entry; C];

    /// The element matrix of a curved cell.
    fn curved(&self, cell: usize, nodes: &CellNodes) -> Result<[[Self::Entry; C]; R], FemError>;
}

/// The matrix of assembled values on a sparsity that others share.
pub(crate) fn on_pattern<T: Copy>(
    shape: (usize, usize),
    row_starts: &[usize],
    columns: &[u32],
    values: Vec<T>,
) -> CsMatI<T, u32, usize> {
    let (starts, columns) = rayon::join(
        || row_starts.to_vec(),
        // every thread touches its share of the copy's pages first
        || columns.par_iter().copied().collect(),
    );
    CsMatI::new(shape, starts, columns, values)
}

/// A matrix entry that contributions can be added to.
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

/// A prepared cell.
enum Prepared<S> {
    Affine(S),
    /// Index into the element matrices of the curved cells.
    Curved(usize),
}

impl TaylorHood {
    /// The values of `form` in the rows that `row_starts` describes.
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
                // A page of fresh memory that is read before it is written is mapped twice, the second time with all cores interrupted.
                values.fill(F::Entry::default());
                let first = task * ROWS_PER_TASK;
                let last = (first + ROWS_PER_TASK).min(row_starts.len() - 1);
                for row in first..last {
                    let start = row_starts[row] - row_starts[first];
                    let values = &mut values[start..];
                    for visit in self.pattern.first_visit[row]..self.pattern.first_visit[row + 1] {
                        let places = &self.pattern.places[visit];
                        let visit = self.pattern.visits[visit];
                        let contributions = match &prepared[visit.cell()] {
                            Prepared::Affine(shared) => F::affine_row(shared, visit.local()),
                            Prepared::Curved(index) => curved[*index][visit.local()],
                        };
                        for j in 0..C {
                            values[places[j] as usize].add(contributions[j]);
                        }
                    }
                }
            });
        Ok(values)
    }

    /// A matrix of quadratic elements.
    pub(crate) fn on_nodes<T: Copy>(&self, values: Vec<T>) -> CsMatI<T, u32, usize> {
        let shape = (self.n_points(), self.n_points());
        let pattern = &self.pattern;
        on_pattern(shape, &pattern.row_starts, &pattern.columns, values)
    }
}

/// Shared parts of the affine cells and element matrices of the curved ones.
type PreparedCells<const R: usize, const C: usize, F> = (
    Vec<Prepared<<F as Form<R, C>>::Shared>>,
    Vec<[[<F as Form<R, C>>::Entry; C]; R]>,
);

fn prepare<const R: usize, const C: usize, F: Form<R, C>>(
    mesh: &TetMesh,
    form: &F,
) -> Result<PreparedCells<R, C, F>, FemError> {
    let mut prepared: Vec<_> = (0..mesh.cells().len())
        .into_par_iter()
        .with_min_len(ROWS_PER_TASK)
        .map(|_| Prepared::Curved(0))
        .collect();
    // In place, for results are collected in lists that one thread joins. The lowest cell is named, whichever thread meets its own first.
    let refused = prepared
        .par_iter_mut()
        .with_min_len(ROWS_PER_TASK)
        .enumerate()
        .filter(|(cell, _)| mesh.is_affine(*cell))
        .filter_map(
            |(cell, prepared)| match Affine::new(cell, &mesh.cell_points(cell)) {
                Ok(affine) => {
                    *prepared = Prepared::Affine(form.share(cell, &affine));
                    None
                }
                Err(error) => Some((cell, error)),
            },
        )
        .min_by_key(|(cell, _)| *cell);
    if let Some((_, error)) = refused {
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
    // again, for the first error in the order of the cells
    let curved = curved.or_else(|_| curved_cells.iter().map(matrix).collect())?;
    Ok((prepared, curved))
}
