//! Bilinear forms, one per file, and all matrices of Stokes flow at once.

mod divergence;
mod mass;
mod stiffness;
mod vertex_elasticity;
mod vertex_stiffness;
mod viscous;

use linalg::{Csr, Csr3};
use mesh::TetMesh;

use crate::{FemError, TaylorHood};

/// Matrices of Stokes flow with viscosity 1 over all nodes, and those that multigrid needs.
#[derive(Clone, Debug)]
pub struct StokesMatrices {
    /// [`TaylorHood::stiffness`].
    pub stiffness: Csr,
    /// [`TaylorHood::divergence`].
    pub divergence: Csr3,
    /// [`TaylorHood::pressure_mass`].
    pub pressure_mass: Csr,
    /// [`TaylorHood::vertex_interpolation`].
    pub interpolation: Csr,
    /// [`TaylorHood::vertex_stiffness`].
    pub vertex_stiffness: Csr,
}

impl TaylorHood {
    /// Assembles all matrices concurrently.
    ///
    /// Each matrix ends with a copy that a single thread makes; meanwhile the other threads
    /// assemble. Cost: the sum of the costs of the matrices. The same for any number of threads.
    ///
    /// # Errors
    /// [`FemError::OtherMesh`], [`FemError::InvertedCell`].
    pub fn matrices(&self, mesh: &TetMesh) -> Result<StokesMatrices, FemError> {
        let ((stiffness, pressure_mass), (divergence, (vertex_stiffness, interpolation))) =
            rayon::join(
                || (self.stiffness(mesh), self.pressure_mass(mesh)),
                || {
                    let divergence = self.divergence(mesh);
                    let vertices = self.vertex_stiffness(mesh);
                    (divergence, (vertices, self.vertex_interpolation(mesh)))
                },
            );
        Ok(StokesMatrices {
            stiffness: stiffness?,
            divergence: divergence?,
            pressure_mass: pressure_mass?,
            interpolation: interpolation?,
            vertex_stiffness: vertex_stiffness?,
        })
    }
}
