//! A linear system assembled of elements, in which bodies move nodes together, and the forces that this takes.

use linalg::{Csr, ShiftedLdlt};
use nalgebra::DMatrix;

use crate::AxisymmetricError;

/// Elements and what their degrees of freedom are.
pub(crate) struct System {
    pub elements: Vec<Element>,
    pub unknowns: usize,
    /// Subtracted from the diagonal of the factors.
    pub shift: Vec<f64>,
    /// The vertex, edge or triangle of each unknown.
    pub group: Vec<u32>,
}

/// Resistance matrix and what it took.
pub(crate) struct Solution {
    pub resistance: DMatrix<f64>,
    pub unknowns: usize,
    pub residual: f64,
}

/// A symmetric matrix over some degrees of freedom.
pub(crate) struct Element {
    pub dofs: Vec<Dof>,
    pub matrix: DMatrix<f64>,
}

/// What a velocity component or a pressure at a node is.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Dof {
    Unknown(u32),
    /// Zero.
    Held,
    /// The velocity of a body.
    Body(usize),
}

impl System {
    /// Forces on the fluid, one column for each of `bodies` moving at unit speed: what the momentum equation at the nodes of a body
    /// leaves (the consistent force), in which errors are second order.
    ///
    /// # Errors
    /// A factorisation or refinement that fails.
    pub fn resistance(&self, bodies: usize) -> Result<Solution, AxisymmetricError> {
        let mut solver = ShiftedLdlt::factor(self.matrix(), &self.shift, &self.group)?;
        let mut resistance = DMatrix::zeros(bodies, bodies);
        let mut worst = 0.0_f64;
        let mut flow = vec![0.0; self.unknowns];
        for body in 0..bodies {
            let mut right = vec![0.0; self.unknowns];
            for element in &self.elements {
                element.rows_of(body, |dof, value| {
                    if let Dof::Unknown(i) = dof {
                        right[i as usize] -= value;
                    }
                });
            }
            worst = worst.max(solver.solve(&right, &mut flow)?);
            for element in &self.elements {
                element.forces(body, &flow, |on, force| resistance[(on, body)] += force);
            }
        }
        Ok(Solution {
            // symmetric up to the residual of the solve
            resistance: 0.5 * (&resistance + resistance.transpose()),
            unknowns: self.unknowns,
            residual: worst,
        })
    }

    /// The system of the unknowns.
    fn matrix(&self) -> Csr {
        let n = self.unknowns;
        let mut visits: Vec<Vec<(u32, u32)>> = vec![Vec::new(); n];
        for (e, element) in self.elements.iter().enumerate() {
            for (local, dof) in element.dofs.iter().enumerate() {
                if let Dof::Unknown(i) = dof {
                    visits[*i as usize].push((e as u32, local as u32));
                }
            }
        }
        let (mut starts, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
        let mut sums = vec![0.0; n];
        let mut met_by = vec![usize::MAX; n];
        for (i, visits) in visits.iter().enumerate() {
            let first = columns.len();
            for &(e, local) in visits {
                let element = &self.elements[e as usize];
                // symmetric: a column is a row
                let row = element.matrix.column(local as usize);
                for (dof, value) in element.dofs.iter().zip(row.iter()) {
                    let Dof::Unknown(j) = *dof else { continue };
                    if met_by[j as usize] != i {
                        met_by[j as usize] = i;
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
    /// Calls `add` with every row's sum over the columns of a body.
    fn rows_of(&self, body: usize, mut add: impl FnMut(Dof, f64)) {
        for (local, dof) in self.dofs.iter().enumerate() {
            if *dof == Dof::Body(body) {
                for (row, value) in self.dofs.iter().zip(self.matrix.column(local).iter()) {
                    add(*row, *value);
                }
            }
        }
    }

    /// Calls `add` with forces on bodies in the flow of one of them moving at unit speed.
    fn forces(&self, moving: usize, flow: &[f64], mut add: impl FnMut(usize, f64)) {
        for (local, dof) in self.dofs.iter().enumerate() {
            let Dof::Body(on) = *dof else { continue };
            let column = self.matrix.column(local);
            let sum: f64 = self
                .dofs
                .iter()
                .zip(column.iter())
                .map(|(dof, value)| match *dof {
                    Dof::Unknown(i) => value * flow[i as usize],
                    Dof::Body(body) if body == moving => *value,
                    Dof::Body(_) | Dof::Held => 0.0,
                })
                .sum();
            add(on, sum);
        }
    }
}

/// Group numbers without those that nothing is in.
pub(crate) fn without_gaps(group: Vec<u32>) -> Vec<u32> {
    let most = group.iter().max().map_or(0, |&g| g as usize + 1);
    let mut new = vec![None; most];
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
