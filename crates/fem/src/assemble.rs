//! Numeric phase of the assembly: one parallel kernel for every bilinear form.
//!
//! Matrices are assembled row by row: the row of a node collects the contributions of the cells
//! around the node in ascending order of the cells. Tasks therefore own disjoint rows, need no
//! locks, and the result does not depend on the number of threads.
//!
//! The data that all rows of a cell use is computed once per cell: a few numbers for an affine cell
//! of a form in closed form, otherwise the whole element matrix, by quadrature. Element matrices
//! are computed in batches of ascending cells, to bound the memory; each row then continues with
//! the first cell that it has not had yet.

use mesh::TetMesh;
use rayon::prelude::*;
use sprs::CsMatI;

use crate::geometry::{Affine, CellNodes, MapAt};
use crate::pattern::{Incidence, Pattern, ROWS_PER_TASK, split_rows};
use crate::point_values::PointValues;
use crate::quadrature::{CellPoint, degree_5};
use crate::quantity::Quantity;
use crate::{FemError, TaylorHood};

/// Memory per thread for the element matrices of a batch, which the cache of a core holds.
const BATCH_BYTES: usize = 1 << 20;

/// Number of element matrices per task: enough work to outweigh its start.
const MATRICES_PER_TASK: usize = 32;

/// A bilinear form whose element matrices have `R` rows and `C` columns.
pub(crate) trait Form<const R: usize, const C: usize>: Sync {
    /// Entry of the element matrix for a pair of shape functions.
    type Entry: Quantity;
    /// Data of an affine cell that all its rows use.
    type AffineData: Copy + Send + Sync;
    /// Whether the rows of affine cells follow from their data in closed form, without quadrature.
    const IS_CLOSED: bool = true;

    /// Computes the data of an affine cell that all its rows use.
    fn affine_data(&self, cell: usize, affine: &Affine) -> Self::AffineData;

    /// Row `local` of the element matrix of an affine cell.
    fn affine_row(data: &Self::AffineData, local: usize) -> [Self::Entry; C];

    /// Quadrature rule of cells without closed form.
    fn rule(&self, _is_affine: bool) -> &'static [CellPoint] {
        degree_5()
    }

    /// Adds the integrand at a quadrature point, times its weight, to the element matrix.
    fn add(&self, point: &PointValues<'_>, matrix: &mut [[Self::Entry; C]; R]);

    /// Completes or checks the element matrix after the last point.
    fn finish(
        &self,
        _cell: usize,
        _nodes: &CellNodes,
        _matrix: &mut [[Self::Entry; C]; R],
    ) -> Result<(), FemError> {
        Ok(())
    }
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

/// Data of a cell, computed before the rows are assembled.
enum Prepared<S> {
    Affine(S),
    /// Index into the list of the cells with element matrices.
    Matrix(usize),
}

/// Rows of one task, and how far they are assembled.
struct RowTask<'a, T> {
    first: usize,
    values: &'a mut [T],
    /// For each row, the number of its incidences that have been added; empty before the first.
    added: Vec<u32>,
    /// Lowest number of a cell that has not been added.
    next_cell: usize,
}

impl<T: Copy> RowTask<'_, T> {
    /// Calls `add(incidence, positions, row values)` for the incidences with cells below `end`.
    #[inline(always)]
    fn continue_to(
        &mut self,
        end: usize,
        (pattern, row_starts): (&Pattern, &[usize]),
        zero: T,
        mut add: impl FnMut(Incidence, &[u16; 10], &mut [T]),
    ) {
        let last = (self.first + ROWS_PER_TASK).min(row_starts.len() - 1);
        if self.added.is_empty() {
            // A fresh page of memory that is read before it is written is mapped twice, and the
            // second mapping interrupts all cores.
            self.values.fill(zero);
            self.added = vec![0; last - self.first];
        }
        self.next_cell = usize::MAX;
        for (row, added) in (self.first..last).zip(&mut self.added) {
            let values = &mut self.values[row_starts[row] - row_starts[self.first]..];
            let start = pattern.incidence_starts[row];
            let stop = pattern.incidence_starts[row + 1];
            let mut k = start + *added as usize;
            while k < stop {
                let incidence = pattern.incidences[k];
                if incidence.cell() >= end {
                    self.next_cell = self.next_cell.min(incidence.cell());
                    break;
                }
                add(incidence, &pattern.positions[k], values);
                k += 1;
            }
            *added = (k - start) as u32;
        }
    }
}

/// Assembled entries of a form.
type Values<const R: usize, const C: usize, F> =
    Vec<<<F as Form<R, C>>::Entry as Quantity>::Stored>;

impl TaylorHood {
    /// Values of `form` in the rows of the pattern that `row_starts` delimits.
    pub(crate) fn assemble_form<const R: usize, const C: usize, F: Form<R, C>>(
        &self,
        mesh: &TetMesh,
        row_starts: &[usize],
        form: &F,
    ) -> Result<Values<R, C, F>, FemError> {
        self.check(mesh)?;
        let (prepared, cells) = prepare(mesh, form)?;
        let zero = F::Entry::stored_zero();
        let mut values = vec![zero; row_starts[row_starts.len() - 1]];
        let mut tasks: Vec<_> = split_rows(&mut values, row_starts)
            .into_iter()
            .enumerate()
            .map(|(task, values)| RowTask {
                first: task * ROWS_PER_TASK,
                values,
                added: Vec::new(),
                next_cell: 0,
            })
            .collect();
        let per_thread = BATCH_BYTES / size_of::<[[F::Entry; C]; R]>();
        let per_batch = (rayon::current_num_threads() * per_thread.max(1)).min(cells.len());
        let mut matrices = vec![[[F::Entry::zero(); C]; R]; per_batch];
        let mut first = 0;
        loop {
            let last = (first + per_batch).min(cells.len());
            compute_matrices(mesh, form, &cells[first..last], &mut matrices)?;
            let end = cells.get(last).map_or(usize::MAX, |&cell| cell as usize);
            let unfinished = tasks.par_iter_mut().filter(|task| task.next_cell < end);
            unfinished.for_each(|task| {
                let rows = (&self.pattern, row_starts);
                task.continue_to(end, rows, zero, |incidence, positions, values| {
                    let contributions = match &prepared[incidence.cell()] {
                        Prepared::Affine(data) => &F::affine_row(data, incidence.local()),
                        Prepared::Matrix(index) => &matrices[index - first][incidence.local()],
                    };
                    for j in 0..C {
                        contributions[j].add_to(&mut values[positions[j] as usize]);
                    }
                });
            });
            if last == cells.len() {
                return Ok(values);
            }
            first = last;
        }
    }

    /// Matrix on the quadratic elements with the given values.
    pub(crate) fn node_matrix<T: Copy>(&self, values: Vec<T>) -> CsMatI<T, u32, usize> {
        let shape = (self.n_points(), self.n_points());
        let pattern = &self.pattern;
        matrix_on_pattern(shape, &pattern.row_starts, &pattern.columns, values)
    }
}

/// Data of all cells, and the cells with element matrices in ascending order.
type PreparedCells<const R: usize, const C: usize, F> =
    (Vec<Prepared<<F as Form<R, C>>::AffineData>>, Vec<u32>);

/// Prepares all cells in parallel.
fn prepare<const R: usize, const C: usize, F: Form<R, C>>(
    mesh: &TetMesh,
    form: &F,
) -> Result<PreparedCells<R, C, F>, FemError> {
    let mut prepared: Vec<_> = (0..mesh.cells().len())
        .into_par_iter()
        .with_min_len(ROWS_PER_TASK)
        .map(|_| Prepared::Matrix(0))
        .collect();
    // In place, because one thread would have to join the lists of collected results. The error
    // names the invalid cell of the lowest number, for any number of threads.
    let first_error = prepared
        .par_iter_mut()
        .with_min_len(ROWS_PER_TASK)
        .enumerate()
        .filter(|(cell, _)| F::IS_CLOSED && mesh.is_affine(*cell))
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
    let mut cells = Vec::new();
    for (cell, prepared) in prepared.iter_mut().enumerate() {
        if let Prepared::Matrix(index) = prepared {
            *index = cells.len();
            cells.push(cell as u32);
        }
    }
    Ok((prepared, cells))
}

/// Computes the element matrices of `cells` in parallel.
///
/// The error names the invalid cell of the lowest number.
fn compute_matrices<const R: usize, const C: usize, F: Form<R, C>>(
    mesh: &TetMesh,
    form: &F,
    cells: &[u32],
    matrices: &mut [[[F::Entry; C]; R]],
) -> Result<(), FemError> {
    let numbered = matrices.par_iter_mut().zip(cells);
    let first_error = numbered
        .with_min_len(MATRICES_PER_TASK)
        .filter_map(|(matrix, &cell)| {
            let result = element_matrix(mesh, form, cell as usize, matrix);
            result.err().map(|error| (cell, error))
        })
        .min_by_key(|(cell, _)| *cell);
    first_error.map_or(Ok(()), |(_, error)| Err(error))
}

/// Element matrix of a cell by quadrature.
fn element_matrix<const R: usize, const C: usize, F: Form<R, C>>(
    mesh: &TetMesh,
    form: &F,
    cell: usize,
    matrix: &mut [[F::Entry; C]; R],
) -> Result<(), FemError> {
    let nodes = mesh.cell_points(cell);
    // The affine cells of forms in closed form have no element matrices.
    let affine = match !F::IS_CLOSED && mesh.is_affine(cell) {
        true => Some(Affine::new(cell, &nodes)?),
        false => None,
    };
    *matrix = [[F::Entry::zero(); C]; R];
    for point in form.rule(affine.is_some()) {
        let map = match &affine {
            Some(affine) => affine.map_at(point),
            None => MapAt::new(cell, &nodes, point)?,
        };
        form.add(&PointValues::new(mesh, cell, &nodes, point, map), matrix);
    }
    form.finish(cell, &nodes, matrix)
}
