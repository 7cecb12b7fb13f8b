//! Full viscous form `∫ 2 D(u):D(v)`, the reference for the scalar stiffness matrix.

use linalg::Csr;
use mesh::{TetMesh, Vec3};
use nalgebra::Matrix3;

use crate::point_values::PointValues;
use crate::quadrature::{degree_2, degree_5};
use crate::weak_form::{ByQuadrature, interleaved_rows};
use crate::{FemError, TaylorHood};

impl TaylorHood {
    /// Full viscous matrix `∫ 2 D(u):D(v)` with the symmetric gradient `D`.
    ///
    /// For traction boundaries, and as a check of the scalar stiffness matrix. Block `(i, j)` is
    /// `∫ (∇N_i · ∇N_j) I + ∇N_j ∇N_i^T`; its rows are the components of the test function `N_i`.
    ///
    /// Shape: `3 n_points` × `3 n_points`, symmetric; dof `3 j + c` is component `c` at point `j`.
    /// Rigid motions are its null space, to rounding, on affine and on curved cells. The quadrature
    /// is that of [`TaylorHood::stiffness`]. Cost: nine times the memory of the scalar matrix,
    /// and as much temporary memory.
    ///
    /// # Errors
    /// [`FemError::OtherMesh`], [`FemError::InvertedCell`].
    pub fn viscous_block(&self, mesh: &TetMesh) -> Result<Csr, FemError> {
        let form = |point: &PointValues<'_>, matrix: &mut [[Matrix3<f64>; 10]; 10]| {
            let gradients = &point.quadratic_gradients();
            for (row, gradient) in matrix.iter_mut().zip(gradients) {
                let weighted = gradient * point.weight;
                for (entry, gradient) in row.iter_mut().zip(gradients) {
                    *entry += pair(&weighted, gradient);
                }
            }
        };
        let form = ByQuadrature::new(form, degree_2(), degree_5());
        let (starts, columns) = (&self.pattern.row_starts, &self.pattern.columns);
        let blocks = self.assemble_form(mesh, starts, &form)?;
        let shape = (3 * self.n_points(), 3 * self.n_points());
        Ok(interleaved_rows(shape, starts, columns, &blocks))
    }
}

/// `(a · b) I + b a^T`: block for a test function of gradient `a` and a trial function of gradient
/// `b`.
pub(super) fn pair(a: &Vec3, b: &Vec3) -> Matrix3<f64> {
    b * a.transpose() + Matrix3::from_diagonal_element(a.dot(b))
}
