//! Bilinear forms, one per file, all matrices of Stokes flow at once, and the load vector.

mod divergence;
mod mass;
mod stiffness;
mod vertex_elasticity;
mod vertex_stiffness;
mod viscous;

use linalg::{Csr, Csr3};
use mesh::{TetMesh, Vec3};

use crate::TaylorHood;
use crate::error::{FemError, check_vectors};
use crate::geometry::MapAt;
use crate::norms::position;
use crate::quadrature::degree_6;
use crate::sum::accumulate_cells;

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

/// Load vector `f_i = ∫ f N_i` of a body force on the quadratic elements.
///
/// `force` returns the force per volume at a position. Quadrature: 24 points per cell, degree 6, so
/// a force of degree 4 is integrated exactly on affine cells. Shape of the result: `n_points`.
/// Bitwise the same for any number of threads.
///
/// # Errors
/// A force that is not finite; [`FemError::InvertedCell`].
pub fn load_vector(
    mesh: &TetMesh,
    force: impl Fn(Vec3) -> Vec3 + Sync,
) -> Result<Vec<Vec3>, FemError> {
    let cell_load = |cell: usize| {
        let positions = mesh.cell_points(cell);
        let mut load = [Vec3::zeros(); 10];
        for point in degree_6() {
            let measure = MapAt::new(cell, &positions, point)?.measure;
            let weighted = measure * force(position(&positions, point));
            for (value, shape) in load.iter_mut().zip(point.shape) {
                *value += shape * weighted;
            }
        }
        Ok(load)
    };
    let mut loads = vec![Vec3::zeros(); mesh.n_points()];
    accumulate_cells(mesh, cell_load, |cell, load| {
        for (&node, value) in mesh.cells()[cell].iter().zip(&load) {
            loads[node as usize] += value;
        }
    })?;
    check_vectors("the load vector", &loads, mesh.n_points())?;
    Ok(loads)
}
