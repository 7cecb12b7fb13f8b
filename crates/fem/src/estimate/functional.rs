//! The errors of all functionals at once: what an estimate does to any other flow, as a load on the mesh.

use mesh::{TetMesh, Vec3};

use super::bubbles::{PER_CELL, signs};
use super::cell::CellFlow;
use super::surplus::{Surplus, SurplusSpace, in_batches};
use crate::FemError;

/// The estimate of $K(e_a, e_b)$ as a functional of the flow `b`: `velocity . u_b + pressure . p_b`.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorFunctional {
    /// Three entries a node.
    pub velocity: Vec<f64>,
    /// One entry a vertex.
    pub pressure: Vec<f64>,
}

impl SurplusSpace {
    /// The functional $b \mapsto K(e_a, e_b)$ for the flow `a` of a surplus.
    ///
    /// Taken as a load, it moves bodies as `a`'s error does: with $b = A^{-1} l_k$ the flow of a unit load on the velocity `k`,
    /// $K(e_a, e_b) = l_k \cdot A^{-1} w$, so one solve for the load `w` serves all velocities `k`.
    ///
    /// With $\delta = g_a - \bar g_a$ and the bubbles' field $v = \sum_i (r_{a,i} - \int \delta \nabla\phi_i) \phi_i / d_i$ it is
    /// $w(u, p) = -\int (\nabla v + \delta 1) : \nabla u + \int p \nabla\cdot v$, the transpose of [`Surplus::energy`].
    ///
    /// Cost: two passes over the cells. The same for any number of threads.
    /// # Errors
    /// A surplus or a mesh that is not of this space, an inverted cell.
    pub fn functional(
        &self,
        mesh: &TetMesh,
        surplus: &Surplus,
    ) -> Result<ErrorFunctional, FemError> {
        self.check(mesh)?;
        surplus.check_length(self.bubbles.len())?;
        let field = self.field(mesh, surplus)?;
        let mut functional = ErrorFunctional {
            velocity: vec![0.0; 3 * mesh.n_points()],
            pressure: vec![0.0; mesh.n_vertices()],
        };
        let of_cell = |cell: usize| {
            let nodes = &mesh.cells()[cell];
            let numbers = self.bubbles.of_cell(cell, nodes);
            let signs = signs(nodes);
            let own: [Vec3; PER_CELL] = std::array::from_fn(|k| signs[k] * field[numbers[k]]);
            CellFlow::of_bubbles(mesh, cell)?.functional(&own, &surplus.divergence[cell])
        };
        in_batches(mesh, of_cell, |cell, (velocity, pressure)| {
            let nodes = &mesh.cells()[cell];
            for (&node, value) in nodes.iter().zip(&velocity) {
                for axis in 0..3 {
                    functional.velocity[3 * node as usize + axis] += value[axis];
                }
            }
            for (&vertex, value) in nodes.iter().zip(&pressure) {
                functional.pressure[vertex as usize] += value;
            }
        })?;
        Ok(functional)
    }

    /// Coefficients of `v`, zero on the boundary.
    fn field(&self, mesh: &TetMesh, surplus: &Surplus) -> Result<Vec<Vec3>, FemError> {
        let (energies, sums) = self.gathered(mesh, |cell| {
            let flow = CellFlow::of_bubbles(mesh, cell)?;
            let against = flow.against_gradients(&surplus.divergence[cell])?;
            Ok((flow.bubble_energies()?, against))
        })?;
        let parts = surplus.coefficients.iter().zip(&energies).zip(&sums);
        Ok(parts
            .map(|((own, energy), sum)| own / energy.sqrt() - sum / *energy)
            .collect())
    }
}
