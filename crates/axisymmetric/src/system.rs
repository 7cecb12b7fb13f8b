//! A linear system assembled from elements whose nodes on bodies move rigidly, and the forces that
//! the bodies exert.

use std::collections::BTreeMap;

use linalg::{Csr, ShiftedLdlt};
use nalgebra::DMatrix;

use crate::AxisymmetricError;
use crate::curve::BoundaryPart;

/// Element matrices and their degrees of freedom.
pub(crate) struct System {
    pub elements: Vec<Element>,
    /// Number of free degrees of freedom.
    pub n_dofs: usize,
    /// Shift subtracted from the diagonal before the factorisation.
    pub shift: Vec<f64>,
    /// Index of the mesh entity (vertex, edge or triangle) of each degree of freedom.
    pub group: Vec<u32>,
    /// Degrees of freedom on each boundary in the fluid.
    ///
    /// One component after the other, each with all nodes from left to right.
    pub traces: BTreeMap<BoundaryPart, Vec<Dof>>,
}

/// A resistance matrix with the size and the accuracy of its linear system.
pub(crate) struct Solution {
    pub resistance: DMatrix<f64>,
    pub n_dofs: usize,
    /// Largest true relative residual of a solve.
    pub residual: f64,
}

/// A symmetric element matrix over its degrees of freedom.
pub(crate) struct Element {
    pub dofs: Vec<Dof>,
    pub matrix: DMatrix<f64>,
}

/// The role of a velocity component or a pressure at a node.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Dof {
    /// Unknown of the linear system with this index.
    Free(u32),
    /// Prescribed zero.
    Constrained,
    /// Velocity of the body with this index.
    Body(usize),
}

impl System {
    /// Degrees of freedom on a boundary in the fluid; empty if the mesh has none of this kind.
    pub fn trace(&self, part: BoundaryPart) -> &[Dof] {
        self.traces.get(&part).map_or(&[], Vec::as_slice)
    }

    /// Forces that the bodies exert on the fluid, one column for each body moving at unit speed.
    ///
    /// A force is the residual of the momentum equation summed over a body's nodes (the consistent
    /// force); its error is the square of the velocity's error.
    ///
    /// # Errors
    /// [`AxisymmetricError::Linalg`] if the factorisation or its iterative refinement fails.
    pub fn resistance(&self, n_bodies: usize) -> Result<Solution, AxisymmetricError> {
        let mut solver = ShiftedLdlt::factor(self.matrix(), &self.shift, &self.group)?;
        let mut resistance = DMatrix::zeros(n_bodies, n_bodies);
        let mut largest_residual = 0.0_f64;
        let mut flow = vec![0.0; self.n_dofs];
        for body in 0..n_bodies {
            let mut rhs = vec![0.0; self.n_dofs];
            self.subtract_columns(body, 1.0, &mut rhs);
            largest_residual = largest_residual.max(solver.solve(&rhs, &mut flow)?);
            for element in &self.elements {
                element.forces(body, &flow, |on, force| resistance[(on, body)] += force);
            }
        }
        Ok(Solution {
            // symmetric up to the residual of the solves
            resistance: 0.5 * (&resistance + resistance.transpose()),
            n_dofs: self.n_dofs,
            residual: largest_residual,
        })
    }

    /// Values of the free degrees of freedom for these amplitudes of the prescribed velocities.
    ///
    /// # Errors
    /// Those of [`System::resistance`].
    pub fn flow(&self, amplitudes: &[f64]) -> Result<Vec<f64>, AxisymmetricError> {
        let mut solver = ShiftedLdlt::factor(self.matrix(), &self.shift, &self.group)?;
        let (mut rhs, mut flow) = (vec![0.0; self.n_dofs], vec![0.0; self.n_dofs]);
        for (body, amplitude) in amplitudes.iter().enumerate() {
            self.subtract_columns(body, *amplitude, &mut rhs);
        }
        solver.solve(&rhs, &mut flow)?;
        Ok(flow)
    }

    /// Subtracts the columns of a body, times an amplitude, from a right-hand side.
    fn subtract_columns(&self, body: usize, amplitude: f64, rhs: &mut [f64]) {
        for Element { dofs, matrix } in &self.elements {
            let columns = dofs.iter().zip(matrix.column_iter());
            for (_, column) in columns.filter(|(dof, _)| **dof == Dof::Body(body)) {
                for (dof, value) in dofs.iter().zip(column.iter()) {
                    if let Dof::Free(i) = *dof {
                        rhs[i as usize] -= amplitude * value;
                    }
                }
            }
        }
    }

    /// The matrix of the degrees of freedom on the boundary `part` and of the `prescribed`
    /// velocities of the body, after static condensation: all others are eliminated.
    ///
    /// Its last rows belong to the prescribed velocities. Rows of constrained degrees of freedom
    /// are zero.
    ///
    /// # Errors
    /// Those of [`System::resistance`].
    pub fn condensed(
        &self,
        part: BoundaryPart,
        prescribed: usize,
    ) -> Result<DMatrix<f64>, AxisymmetricError> {
        let kept = self.trace(part);
        // what remains is prescribed like the velocities of bodies, and its forces are wanted
        let mut roles: Vec<Option<Dof>> = vec![None; self.n_dofs];
        for (row, dof) in kept.iter().enumerate() {
            if let Dof::Free(i) = *dof {
                roles[i as usize] = Some(Dof::Body(row));
            }
        }
        let interior: Vec<usize> = (0..self.n_dofs).filter(|&i| roles[i].is_none()).collect();
        for (new, &i) in interior.iter().enumerate() {
            roles[i] = Some(Dof::Free(new as u32));
        }
        let role = |dof: &Dof| match *dof {
            Dof::Free(i) => roles[i as usize].unwrap_or(Dof::Constrained),
            Dof::Constrained => Dof::Constrained,
            Dof::Body(body) => Dof::Body(kept.len() + body),
        };
        let elements = self.elements.iter().map(|element| Element {
            dofs: element.dofs.iter().map(role).collect(),
            matrix: element.matrix.clone(),
        });
        let inner = Self {
            elements: elements.collect(),
            n_dofs: interior.len(),
            shift: interior.iter().map(|&i| self.shift[i]).collect(),
            group: numbered_consecutively(interior.iter().map(|&i| self.group[i]).collect()),
            traces: BTreeMap::new(),
        };
        Ok(inner.resistance(kept.len() + prescribed)?.resistance)
    }

    /// The assembled matrix of the free degrees of freedom.
    fn matrix(&self) -> Csr {
        let n = self.n_dofs;
        // elements and local indices at which each degree of freedom occurs
        let mut occurrences: Vec<Vec<(u32, u32)>> = vec![Vec::new(); n];
        for (e, element) in self.elements.iter().enumerate() {
            for (local, dof) in element.dofs.iter().enumerate() {
                if let Dof::Free(i) = dof {
                    occurrences[*i as usize].push((e as u32, local as u32));
                }
            }
        }
        let (mut starts, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
        let mut sums = vec![0.0; n];
        let mut last_row = vec![usize::MAX; n];
        for (i, occurrences) in occurrences.iter().enumerate() {
            let first = columns.len();
            for &(e, local) in occurrences {
                let element = &self.elements[e as usize];
                // the matrix is symmetric: its columns are its rows
                let row = element.matrix.column(local as usize);
                for (dof, value) in element.dofs.iter().zip(row.iter()) {
                    let Dof::Free(j) = *dof else { continue };
                    if last_row[j as usize] != i {
                        last_row[j as usize] = i;
                        sums[j as usize] = 0.0;
                        columns.push(j);
                    }
                    sums[j as usize] += value;
                }
            }
            columns[first..].sort_unstable();
            values.extend(columns[first..].iter().map(|&j| sums[j as usize]));
            starts.push(columns.len());
        }
        Csr::new((n, n), starts, columns, values)
    }
}

impl Element {
    /// Calls `add` with this element's share of the force of each body while body `moving` has unit
    /// speed.
    fn forces(&self, moving: usize, flow: &[f64], mut add: impl FnMut(usize, f64)) {
        for (local, dof) in self.dofs.iter().enumerate() {
            let Dof::Body(on) = *dof else { continue };
            let column = self.matrix.column(local);
            let sum: f64 = self
                .dofs
                .iter()
                .zip(column.iter())
                .map(|(dof, value)| match *dof {
                    Dof::Free(i) => value * flow[i as usize],
                    Dof::Body(body) if body == moving => *value,
                    Dof::Body(_) | Dof::Constrained => 0.0,
                })
                .sum();
            add(on, sum);
        }
    }
}

/// The Schur complement of a symmetric matrix after the elimination of the rows `inner`, in their
/// order and without pivots; `None` if a pivot is zero or not finite.
///
/// The block of the rows `inner` is positive definite, or has velocities before pressures, whose
/// pivots are then negative. The other rows keep their order.
pub(crate) fn condensed(matrix: &DMatrix<f64>, inner: &[usize]) -> Option<DMatrix<f64>> {
    let outer = (0..matrix.nrows()).filter(|i| inner.binary_search(i).is_err());
    let order: Vec<usize> = inner.iter().copied().chain(outer).collect();
    let size = order.len();
    let mut lower = DMatrix::from_fn(size, size, |i, j| matrix[(order[i], order[j])]);
    for k in 0..inner.len() {
        let (mut columns, mut later) = lower.columns_range_pair_mut(k..k + 1, k + 1..size);
        let column = columns.column_mut(0);
        let pivot = column[k];
        if pivot == 0.0 || !pivot.is_finite() {
            return None;
        }
        for (mut below, j) in later.column_iter_mut().zip(k + 1..) {
            // axial and radial velocities couple by pressures only
            if column[j] != 0.0 {
                let factor = column[j] / pivot;
                (below.rows_range_mut(j..)).axpy(-factor, &column.rows_range(j..), 1.0);
            }
        }
    }
    let first = inner.len();
    Some(DMatrix::from_fn(size - first, size - first, |i, j| {
        lower[(first + i.max(j), first + i.min(j))]
    }))
}

/// Renumbers groups from zero in order of first appearance, without unused numbers.
pub(crate) fn numbered_consecutively(group: Vec<u32>) -> Vec<u32> {
    let n_old = group.iter().max().map_or(0, |&g| g as usize + 1);
    let mut new = vec![None; n_old];
    let mut count = 0;
    group
        .into_iter()
        .map(|g| {
            *new[g as usize].get_or_insert_with(|| {
                count += 1;
                count - 1
            })
        })
        .collect()
}
