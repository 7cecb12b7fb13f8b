//! The error estimate as a functional of the second flow: a load for an adjoint solution.

use mesh::{TetMesh, Vec3};

use super::bubbles::{PER_CELL, signs};
use super::cell::CellFlow;
use super::surplus::{Surplus, SurplusSpace};
use crate::FemError;
use crate::sum::accumulate_cells;

/// Estimate of `K(e_a, e_b)` as a functional of the flow `b`: `velocity · u_b + pressure · p_b`.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ErrorFunctional {
    /// Load at each node.
    pub velocity: Vec<Vec3>,
    /// Load at each vertex.
    pub pressure: Vec<f64>,
}

impl SurplusSpace {
    /// The functional `b -> K(e_a, e_b)` for the flow `a` whose surplus is given.
    ///
    /// As a load `w` it gives the errors of all velocities by one solve: if `b = A^-1 l_k` is the
    /// flow of a unit load on velocity `k`, then `K(e_a, e_b) = l_k · A^-1 w`.
    ///
    /// ```text
    /// w(u, p) = -∫ (∇v + δ I):∇u + ∫ p ∇·v
    /// δ = g_a - mean(g_a),   v = sum_i (r_a,i - ∫ δ ∇φ_i) φ_i / d_i
    /// ```
    ///
    /// in the notation of [`SurplusSpace`]; `w` is the transpose of [`Surplus::energy`].
    ///
    /// Cost: two passes over the cells. The same for any number of threads.
    ///
    /// # Errors
    /// A surplus or a mesh that does not belong to this space; an inverted cell.
    pub fn functional(
        &self,
        mesh: &TetMesh,
        surplus: &Surplus,
    ) -> Result<ErrorFunctional, FemError> {
        self.check(mesh)?;
        surplus.check_lengths(self.bubbles.len(), mesh.n_cells())?;
        let coefficients = self.coefficients(mesh, surplus)?;
        let mut functional = ErrorFunctional {
            velocity: vec![Vec3::zeros(); mesh.n_points()],
            pressure: vec![0.0; mesh.n_vertices()],
        };
        let cell_load = |cell: usize| {
            let nodes = &mesh.cells()[cell];
            let numbers = self.bubbles.of_cell(cell, nodes);
            let signs = signs(nodes);
            let bubbles: [Vec3; PER_CELL] =
                std::array::from_fn(|k| signs[k] * coefficients[numbers[k]]);
            CellFlow::at_rest(mesh, cell)?.functional(&bubbles, &surplus.divergence[cell])
        };
        accumulate_cells(mesh, cell_load, |cell, (velocity, pressure)| {
            let nodes = &mesh.cells()[cell];
            for (&node, value) in nodes.iter().zip(&velocity) {
                functional.velocity[node as usize] += value;
            }
            for (&vertex, value) in nodes.iter().zip(&pressure) {
                functional.pressure[vertex as usize] += value;
            }
        })?;
        Ok(functional)
    }

    /// Coefficients of the bubbles in `v`, zero on the boundary.
    fn coefficients(&self, mesh: &TetMesh, surplus: &Surplus) -> Result<Vec<Vec3>, FemError> {
        let (energies, sums) = self.bubble_sums(mesh, |cell| {
            let flow = CellFlow::at_rest(mesh, cell)?;
            let tested = flow.tested_with_bubble_gradients(&surplus.divergence[cell])?;
            Ok((flow.bubble_energies()?, tested))
        })?;
        let bubbles = surplus.coefficients.iter().zip(&energies).zip(&sums);
        Ok(bubbles
            .map(|((coefficient, energy), sum)| coefficient / energy.sqrt() - sum / *energy)
            .collect())
    }
}
