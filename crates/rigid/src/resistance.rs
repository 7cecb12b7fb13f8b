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
    /// `solve(rights, solutions)` is called with unit loads on the bodies, `at_once` of the 6n at a time (at least one), the solutions being zero:
    /// the velocities it answers with are columns of the mobility. `at_once` right-hand sides and solutions are held in memory.
    ///
    /// # Errors
    /// A system that is not of formulation P, what `solve` fails with, a mobility that is not positive definite.
    pub fn of<E: From<RigidError>>(
        independent: &Constrained,
        at_once: usize,
        mut solve: impl FnMut(&[&[f64]], &mut [&mut [f64]]) -> Result<(), E>,
    ) -> Result<Self, E> {
        let velocities = independent.independent_velocities()?;
        let first = independent.system.border_range().start;
        let unknowns = independent.rhs.len();
        let mut mobility = DMatrix::zeros(velocities, velocities);
        let mut load = 0;
        while load < velocities {
            let count = at_once.clamp(1, velocities - load);
            let [mut rights, mut solutions] = [(); 2].map(|()| vec![vec![0.0; unknowns]; count]);
            for (c, rhs) in rights.iter_mut().enumerate() {
                rhs[first + load + c] = 1.0;
            }
            let rights: Vec<&[f64]> = rights.iter().map(Vec::as_slice).collect();
            let mut columns: Vec<_> = solutions.iter_mut().map(Vec::as_mut_slice).collect();
            solve(&rights, &mut columns)?;
            for (c, solution) in solutions.iter().enumerate() {
                mobility
                    .column_mut(load + c)
                    .copy_from_slice(&solution[first..first + velocities]);
            }
            load += count;
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
