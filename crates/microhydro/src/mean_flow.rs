//! The mean flow past linked spheres whose total force on the fluid is given.

use nalgebra::{Cholesky, Const, DVector, Matrix3, OMatrix, U3, Vector3};

use crate::HydroError;

/// Three columns, one for each direction.
pub(crate) type FlowColumns = OMatrix<f64, nalgebra::Dyn, U3>;

/// Mean of the squares of a direction's multipliers, of all spheres, below which all spheres are
/// free to move along it: rounding, since a sphere that is held contributes one.
const NOTHING_HELD: f64 = 1e-20;

/// The equations for a uniform flow `u` past spheres whose total force `F` is given:
///
/// ```text
/// A λ + B u = r      B^T λ = c
/// ```
///
/// with the positive definite matrix `A` of the multipliers `λ` of [`LinkedSpheres`], the
/// multipliers `B` of a unit force on each sphere along each axis, and the part `c` of `F` that the
/// loads do not balance. Conjugate gradients for `λ` stay among the multipliers without total
/// force, if the preconditioner `G` does (Gould, Hribar & Nocedal 2001, SIAM J. Sci. Comput. 23,
/// 1376): it applies to residuals without their part `B u`, that with `B^T G^-1 (r - B u) = 0`.
///
/// [`LinkedSpheres`]: crate::LinkedSpheres
pub(crate) struct UnknownFlow {
    /// The total force.
    pub total: Vector3<f64>,
    /// `B`.
    columns: FlowColumns,
    /// `G^-1 B`.
    preconditioned: FlowColumns,
    /// `B^T G^-1 B`.
    factor: Cholesky<f64, Const<3>>,
}

impl UnknownFlow {
    /// The equations for these columns `B` and their products with the inverse preconditioner.
    ///
    /// # Errors
    /// [`HydroError::NothingHeld`] if all spheres are free to move along a direction.
    pub fn new(
        total: Vector3<f64>,
        columns: FlowColumns,
        preconditioned: FlowColumns,
        spheres: usize,
    ) -> Result<Self, HydroError> {
        let squares: Matrix3<f64> = columns.tr_mul(&columns) / spheres.max(1) as f64;
        if squares.symmetric_eigenvalues().min() < NOTHING_HELD {
            return Err(HydroError::NothingHeld);
        }
        let product: Matrix3<f64> = columns.tr_mul(&preconditioned);
        let factor = Cholesky::new(0.5 * (product + product.transpose()));
        Ok(Self {
            total,
            columns,
            preconditioned,
            factor: factor.ok_or(HydroError::NothingHeld)?,
        })
    }

    /// Changes multipliers such that `B^T λ = c`.
    pub fn balance(&self, multipliers: &mut DVector<f64>, c: &Vector3<f64>) {
        let missing = c - self.columns.tr_mul(multipliers);
        let change = &self.preconditioned * self.factor.solve(&missing);
        *multipliers += change;
    }

    /// The norm of `B u`.
    pub fn norm(&self, flow: &Vector3<f64>) -> f64 {
        (&self.columns * flow).norm()
    }

    /// The flow `u` of a residual, and the residual without `B u`.
    pub fn split(&self, residual: &mut DVector<f64>) -> Vector3<f64> {
        let flow: Vector3<f64> = self.factor.solve(&self.preconditioned.tr_mul(residual));
        *residual -= &self.columns * flow;
        flow
    }
}
