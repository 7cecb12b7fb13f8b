//! Condensation on the bodies: the grand resistance and mobility matrices.

use nalgebra::DMatrix;

use crate::{Constrained, RigidError};

/// The linear law between velocities and forces of rigid bodies: $F = R\, U$, $U = R^{-1} F$.
///
/// Six entries a body, `(U, omega)` and `(F, T)` in the bodies' order; forces are those that bodies exert on the fluid.
/// Eliminating the flow and the pressure from the formulation P leaves `R` as Schur complement, so both matrices are symmetric
/// positive definite (Kim & Karrila 1991, chapter 5).
#[derive(Clone, Debug)]
pub struct GrandResistance {
    /// `R`, 6n x 6n.
    pub resistance: DMatrix<f64>,
    /// Its inverse.
    pub mobility: DMatrix<f64>,
    /// Largest difference of the mobility computed and its transpose, over its largest entry: what the tolerance of the
    /// solves left. Both matrices are symmetrised.
    pub asymmetry: f64,
}

impl GrandResistance {
    /// Condenses a system of formulation P ([`Independent`](crate::Independent)) with any solver of it.
    ///
    /// `solve(right, solution)` is called 6n times with unit loads on the bodies, `solution` being zero: the velocities it
    /// answers with are columns of the mobility.
    ///
    /// # Errors
    /// A system that is not of formulation P, what `solve` fails with, a mobility that is not positive definite.
    pub fn of<E: From<RigidError>>(
        independent: &Constrained,
        mut solve: impl FnMut(&[f64], &mut [f64]) -> Result<(), E>,
    ) -> Result<Self, E> {
        let velocities = independent.independent_velocities()?;
        let first = independent.system.border_range().start;
        let unknowns = independent.right.len();
        let mut mobility = DMatrix::zeros(velocities, velocities);
        for load in 0..velocities {
            let mut right = vec![0.0; unknowns];
            right[first + load] = 1.0;
            let mut solution = vec![0.0; unknowns];
            solve(&right, &mut solution)?;
            mobility
                .column_mut(load)
                .copy_from_slice(&solution[first..first + velocities]);
        }
        let difference = (&mobility - mobility.transpose()).amax();
        let asymmetry = difference / mobility.amax();
        let mobility = (&mobility + mobility.transpose()) / 2.0;
        let Some(factor) = mobility.clone().cholesky() else {
            return Err(RigidError::NotPositiveDefinite { asymmetry }.into());
        };
        let resistance = factor.inverse();
        Ok(Self {
            resistance,
            mobility,
            asymmetry,
        })
    }
}
