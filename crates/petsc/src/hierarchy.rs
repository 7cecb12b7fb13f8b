//! Levels of multigrid for velocities and border: linear elements, then smoothed aggregation.
//!
//! The steps are those of `linalg`, as products of PETSc matrices. The border dofs are part of
//! every level. One damped Jacobi step, with `D^-1` zero on the border, changes the tentative
//! prolongation `[T 0; 0 I]` of the bordered matrix `[K C; C^T M]` into
//! `[T - w D^-1 K T, -w D^-1 C; 0, I]`.

use std::ops::Range;

use linalg::{Aggregates, Csr, MultigridParams};

use crate::PetscError;
use crate::ffi::Int;
use crate::handles::{Matrix, Rows, Session};
use crate::numbering::Numbering;

/// Factor `w` of the Jacobi step on the tentative prolongation: `4 / (3 upper)`.
///
/// The eigenvalues of `D^-1 K` are at most `upper = 1` for the l1 diagonal (Gershgorin).
const DAMPING: f64 = 4.0 / 3.0;

/// Largest share of the dofs of a level that the next coarser level may have.
///
/// If coarsening reduces the dofs by less, factorising the finer level is cheaper.
const LEAST_COARSENING: f64 = 0.8;

/// Matrices of all levels and the prolongations between them, both finest first.
pub struct Hierarchy<'s> {
    pub levels: Vec<Level<'s>>,
    pub prolongations: Vec<Matrix<'s>>,
}

impl<'s> Hierarchy<'s> {
    /// Coarsens `matrix`, first with `prolongation` from linear elements, then by aggregation.
    ///
    /// `free_vertices` are the free vertices of this process in the order of their numbers.
    ///
    /// # Errors
    /// Those of PETSc; [`PetscError::TooLarge`].
    pub fn new(
        session: &'s Session,
        matrix: Matrix<'s>,
        prolongation: Matrix<'s>,
        numbering: &Numbering,
        free_vertices: &[u32],
    ) -> Result<Self, PetscError> {
        let components = free_vertices.iter();
        let mut components: Vec<u8> = components.map(|&v| numbering.components(v)).collect();
        let params = MultigridParams::default();
        let border = numbering.border_len();
        let mut coarse = matrix.galerkin(&prolongation)?;
        let mut hierarchy = Self {
            levels: vec![Level::new(session, matrix, border)?],
            prolongations: vec![prolongation],
        };
        loop {
            let level = Level::new(session, coarse, border)?;
            let size = level.matrix.size()?;
            if size <= 3 * params.coarsest_nodes + border {
                hierarchy.levels.push(level);
                return Ok(hierarchy);
            }
            let (tentative, next, columns) =
                level.tentative(session, &components, params.strength)?;
            let sizes = &mut [columns as f64];
            session.sum(sizes)?;
            if sizes[0] > LEAST_COARSENING * size as f64 {
                hierarchy.levels.push(level);
                return Ok(hierarchy);
            }
            let prolongation = level.smoothed(session, &tentative)?;
            coarse = level.matrix.galerkin(&prolongation)?;
            hierarchy.levels.push(level);
            hierarchy.prolongations.push(prolongation);
            components = next;
        }
    }
}

/// One multigrid level.
pub struct Level<'s> {
    pub matrix: Matrix<'s>,
    /// Diagonal of the smoother: `1 / sum_j |k_ij|` for velocities, zero for the border.
    pub inverse_diagonal: Vec<f64>,
    /// Numbers of the border dofs.
    border: Range<Int>,
}

impl<'s> Level<'s> {
    fn new(session: &'s Session, matrix: Matrix<'s>, border: usize) -> Result<Self, PetscError> {
        let rows = matrix.row_range()?;
        // The border comes last on the first process.
        let mut end = [if session.rank() == 0 {
            rows.end as f64
        } else {
            0.0
        }];
        session.sum(&mut end)?;
        let border = end[0] as Int - border as Int..end[0] as Int;
        let mut inverse_diagonal = Vec::with_capacity((rows.end - rows.start) as usize);
        let mut row = rows.start;
        matrix.for_each_row(|columns, values| {
            let of_velocities =
                (columns.iter().zip(values)).filter(|(column, _)| !border.contains(column));
            let sum: f64 = of_velocities.map(|(_, value)| value.abs()).sum();
            let is_border = border.contains(&row);
            inverse_diagonal.push(if is_border { 0.0 } else { sum.recip() });
            row += 1;
        })?;
        Ok(Self {
            matrix,
            inverse_diagonal,
            border,
        })
    }

    /// The tentative prolongation `[T 0; 0 I]`, the components of its aggregates, and the number of
    /// its columns on this process.
    ///
    /// Each process aggregates its own nodes. Components that are prescribed at a node have no row.
    /// All nodes of an aggregate have the same free components.
    fn tentative(
        &self,
        session: &'s Session,
        components: &[u8],
        strength: f64,
    ) -> Result<(Matrix<'s>, Vec<u8>, usize), PetscError> {
        let scalar = self.own_scalar_matrix(components)?;
        let aggregates = Aggregates::from_matrix(&scalar, components, strength)?;
        let mut of_aggregate = vec![0; aggregates.count];
        for (aggregate, &bits) in aggregates.of_node.iter().zip(components) {
            if let Some(aggregate) = aggregate {
                of_aggregate[*aggregate as usize] = bits;
            }
        }
        let first_columns = first_rows(&of_aggregate);
        let velocities = first_columns[aggregates.count];
        let own_border = if session.rank() == 0 {
            self.border.len()
        } else {
            0
        };
        let columns = velocities + own_border;
        let first = session.before(columns)?;
        let mut rows = Rows::default();
        for (aggregate, &bits) in aggregates.of_node.iter().zip(components) {
            for axis in 0..bits.count_ones() as usize {
                if let Some(aggregate) = aggregate {
                    let column = first + first_columns[*aggregate as usize] + axis;
                    rows.push(column as Int, 1.0);
                }
                rows.end_row()?;
            }
        }
        for border in 0..own_border {
            rows.push((first + velocities + border) as Int, 1.0);
            rows.end_row()?;
        }
        let tentative = Matrix::from_rows(session, &rows, columns)?;
        Ok((tentative, of_aggregate, columns))
    }

    /// Scalar matrix of the nodes of this process, from the first component of each node.
    fn own_scalar_matrix(&self, components: &[u8]) -> Result<Csr, PetscError> {
        let first_rows = first_rows(components);
        let rows = self.matrix.row_range()?;
        let node_of = |column: Int| {
            let row = usize::try_from(column - rows.start).ok()?;
            let is_velocity = row < first_rows[components.len()];
            is_velocity.then(|| first_rows.partition_point(|&first| first <= row) - 1)
        };
        // A node without components has a positive diagonal and no neighbours.
        let mut own: Vec<Vec<(u32, f64)>> = (0..components.len() as u32)
            .map(|node| vec![(node, 1.0)])
            .collect();
        let is_first = |row: usize, node: usize| first_rows[node] == row;
        let mut row = rows.start;
        self.matrix.for_each_row(|columns, values| {
            let local = (row - rows.start) as usize;
            if let Some(node) = node_of(row).filter(|&node| is_first(local, node)) {
                let entries = columns.iter().zip(values);
                let entries = entries.filter_map(|(&j, &value)| Some((node_of(j)? as u32, value)));
                own[node] = entries.collect();
                own[node].sort_unstable_by_key(|(other, _)| *other);
                own[node].dedup_by_key(|(other, _)| *other);
            }
            row += 1;
        })?;
        let mut starts = vec![0];
        for entries in &own {
            starts.push(starts[starts.len() - 1] + entries.len());
        }
        let (columns, values) = own.into_iter().flatten().unzip();
        let n = components.len();
        Ok(Csr::new((n, n), starts, columns, values))
    }

    /// The smoothed prolongation `T - w D^-1 A T`.
    fn smoothed(
        &self,
        session: &'s Session,
        tentative: &Matrix<'s>,
    ) -> Result<Matrix<'s>, PetscError> {
        // Rows of the border stay empty: as zeros they would count as couplings of all nodes.
        let (mut step, mut outcome) = (Rows::default(), Ok(()));
        let mut inverse_diagonal = self.inverse_diagonal.iter();
        self.matrix.for_each_row(|columns, values| {
            let inverse = inverse_diagonal.next().copied().unwrap_or(0.0);
            if inverse != 0.0 {
                for (&column, &value) in columns.iter().zip(values) {
                    step.push(column, -DAMPING * inverse * value);
                }
            }
            if outcome.is_ok() {
                outcome = step.end_row();
            }
        })?;
        outcome?;
        let step = Matrix::from_rows(session, &step, self.inverse_diagonal.len())?;
        let mut prolongation = step.multiply(tentative)?;
        prolongation.add(tentative)?;
        Ok(prolongation)
    }
}

/// First row of each node with the given free components, followed by the number of rows.
fn first_rows(components: &[u8]) -> Vec<usize> {
    let mut rows = vec![0];
    for bits in components {
        rows.push(rows[rows.len() - 1] + bits.count_ones() as usize);
    }
    rows
}
