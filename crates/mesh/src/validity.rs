//! Validity of cells: moving the nodes of a mesh without turning a cell inside out.

use std::sync::Arc;

use rayon::prelude::*;

use crate::jacobian::{scaled_jacobian_bound, scaled_jacobian_of_straight_tet};
use crate::tet_mesh::{Topology, check_finite};
use crate::{MeshError, TetMesh, Vec3};

/// Cells per parallel task; fixed, so that the result does not depend on the number of threads.
const CHUNK: usize = 1024;

impl TetMesh {
    /// Copy of the mesh with other node positions: `points[i]` is the new position of node `i`.
    ///
    /// The topology is shared, not copied. Cost: one Jacobian bound per curved cell, in parallel.
    ///
    /// # Errors
    /// [`MeshError::WrongLength`], [`MeshError::NotFinite`], and [`MeshError::InvertedCell`] with
    /// the worst cell if the motion turns any cell inside out.
    pub fn with_points(&self, points: Vec<Vec3>) -> Result<Self, MeshError> {
        if points.len() != self.n_points() {
            return Err(MeshError::WrongLength {
                what: "list of moved nodes".into(),
                expected: self.n_points(),
                found: points.len(),
            });
        }
        check_finite(&points)?;
        Self::checked(points, Arc::clone(&self.topology))
    }

    /// The mesh with these points and this topology, if every cell is valid.
    ///
    /// # Errors
    /// [`MeshError::InvertedCell`] with the worst cell.
    pub(crate) fn checked(points: Vec<Vec3>, topology: Arc<Topology>) -> Result<Self, MeshError> {
        let mesh = Self { points, topology };
        mesh.check_jacobians()?;
        Ok(mesh)
    }

    /// Scaled Jacobian of one cell: [`scaled_jacobian_bound`] of a curved cell.
    ///
    /// For a straight cell it is 1, or -1 if the cell is inverted, or 0 if it is flat.
    ///
    /// # Panics
    /// If there is no such cell, as indexing [`TetMesh::cells`] does.
    pub fn scaled_jacobian(&self, cell: usize) -> f64 {
        if self.is_affine(cell) {
            scaled_jacobian_of_straight_tet(self.cell_vertices(cell))
        } else {
            scaled_jacobian_bound(&self.cell_points(cell))
        }
    }

    /// Checks that the geometry map of every cell is one-to-one.
    ///
    /// # Errors
    /// [`MeshError::InvertedCell`] with the worst cell.
    fn check_jacobians(&self) -> Result<(), MeshError> {
        let worst: Vec<(f64, usize)> = (0..self.n_cells().div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                (chunk * CHUNK..self.n_cells().min((chunk + 1) * CHUNK))
                    .map(|cell| (self.scaled_jacobian(cell), cell))
                    .fold((f64::INFINITY, 0), smaller)
            })
            .collect();
        let (jacobian, cell) = worst.into_iter().fold((f64::INFINITY, 0), smaller);
        if jacobian > 0.0 {
            return Ok(());
        }
        let [a, b, c, d] = self.cell_vertices(cell);
        Err(MeshError::InvertedCell {
            cell,
            at: ((a + b + c + d) / 4.0).into(),
            jacobian,
        })
    }
}

/// The cell with the smaller Jacobian, or with one that overflowed to NaN.
fn smaller(a: (f64, usize), b: (f64, usize)) -> (f64, usize) {
    if b.0 < a.0 || b.0.is_nan() { b } else { a }
}
