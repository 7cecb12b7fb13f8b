//! Scalar diffusion problems with prescribed values: one matrix, many right-hand sides.

use linalg::{Bordered, Csr, KrylovParams, LinalgError, Multigrid, MultigridParams, cg};

/// The relative residual to which extensions are solved.
///
/// An extension need not be accurate, only smooth: any field with the right boundary values is a valid mesh
/// motion. 1e-8 keeps its error below that of the coordinates in f32 pictures and costs a few iterations.
const TOLERANCE: f64 = 1e-8;

/// Solves `K d = 0` at free vertices with `d` prescribed at the others.
pub(crate) struct DirichletSolver<'a> {
    stiffness: &'a Csr,
    free: Vec<usize>,
    /// `K` of the free vertices; none if every vertex is prescribed.
    system: Option<(Bordered, Multigrid)>,
}

impl<'a> DirichletSolver<'a> {
    pub fn new(stiffness: &'a Csr, prescribed: &[bool]) -> Result<Self, LinalgError> {
        let free: Vec<usize> = (0..stiffness.rows())
            .filter(|&vertex| !prescribed[vertex])
            .collect();
        if free.is_empty() {
            return Ok(Self {
                stiffness,
                free,
                system: None,
            });
        }
        let mut number = vec![u32::MAX; stiffness.rows()];
        for (index, &vertex) in free.iter().enumerate() {
            number[vertex] = index as u32;
        }
        let (mut pointers, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
        for &vertex in &free {
            let Some(row) = stiffness.outer_view(vertex) else {
                continue;
            };
            for (column, &value) in row.iter() {
                if number[column] != u32::MAX {
                    columns.push(number[column]);
                    values.push(value);
                }
            }
            pointers.push(columns.len());
        }
        let operator = Bordered::scalar(Csr::new(
            (free.len(), free.len()),
            pointers,
            columns,
            values,
        ))?;
        let multigrid = Multigrid::new(&operator, &MultigridParams::default())?;
        Ok(Self {
            stiffness,
            free,
            system: Some((operator, multigrid)),
        })
    }

    /// Extends each of `conditions`, values at all vertices of which the prescribed ones count.
    pub fn extend(&mut self, conditions: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, LinalgError> {
        let mut fields = conditions.to_vec();
        let Some((operator, multigrid)) = &mut self.system else {
            return Ok(fields);
        };
        let parameters = KrylovParams {
            rel_tol: TOLERANCE,
            ..KrylovParams::default()
        };
        for group in fields.chunks_mut(3) {
            for field in group.iter_mut() {
                self.free.iter().for_each(|&vertex| field[vertex] = 0.0);
            }
            let mut right = vec![0.0; 3 * self.free.len()];
            for (entry, &vertex) in right.chunks_exact_mut(3).zip(&self.free) {
                let Some(row) = self.stiffness.outer_view(vertex) else {
                    continue;
                };
                for (column, &value) in row.iter() {
                    for (component, field) in group.iter().enumerate() {
                        entry[component] -= value * field[column];
                    }
                }
            }
            let mut solution = vec![0.0; right.len()];
            cg(operator, multigrid, &right, &mut solution, &parameters)?;
            for (entry, &vertex) in solution.chunks_exact(3).zip(&self.free) {
                for (component, field) in group.iter_mut().enumerate() {
                    field[vertex] = entry[component];
                }
            }
        }
        Ok(fields)
    }
}
