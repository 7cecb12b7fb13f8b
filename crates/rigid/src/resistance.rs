//! Grand resistance and mobility matrices of bodies: the Schur complement of the flow.

use nalgebra::DMatrix;

use crate::{Constrained, RigidError};

/// The linear law between velocities and forces of rigid bodies: `F = R U`, `U = R^-1 F`.
///
/// Six entries per body, `(U, ω)` and `(F, T)`; forces are those that bodies exert on the fluid.
/// `R` is the Schur complement of formulation P after elimination of flow and pressure, so that
/// both matrices are symmetric positive definite (Kim & Karrila 1991, chapter 5).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct GrandResistance {
    /// `R`, 6n x 6n.
    pub resistance: DMatrix<f64>,
    /// Its inverse.
    pub mobility: DMatrix<f64>,
    /// Largest difference between the computed mobility and its transpose, over its largest entry.
    ///
    /// It measures the error of the solves. Both matrices are symmetrised.
    pub asymmetry: f64,
}

impl GrandResistance {
    /// Condenses a system of the formulation [`Independent`](crate::Independent) by 6n solves.
    ///
    /// `solve(rhs, solutions)` is called with unit loads on the bodies and zero solutions,
    /// `at_once` of the 6n at a time (at least one); the velocities that it computes are columns
    /// of the mobility. Memory: `at_once` right-hand sides and solutions.
    ///
    /// # Errors
    /// A system that is not of formulation P, an error of `solve`, a mobility that is not positive
    /// definite.
    pub fn new<E: From<RigidError>>(
        independent: &Constrained,
        at_once: usize,
        mut solve: impl FnMut(&[&[f64]], &mut [&mut [f64]]) -> Result<(), E>,
    ) -> Result<Self, E> {
        let velocities = independent.independent_velocities()?;
        let first = independent.border_range().start;
        let dofs = independent.dofs();
        let mut mobility = DMatrix::zeros(velocities, velocities);
        let mut load = 0;
        while load < velocities {
            let count = at_once.clamp(1, velocities - load);
            let [mut rhs, mut solutions] = [(); 2].map(|()| vec![vec![0.0; dofs]; count]);
            for (c, column) in rhs.iter_mut().enumerate() {
                column[first + load + c] = 1.0;
            }
            let rhs: Vec<&[f64]> = rhs.iter().map(Vec::as_slice).collect();
            let mut columns: Vec<_> = solutions.iter_mut().map(Vec::as_mut_slice).collect();
            solve(&rhs, &mut columns)?;
            for (c, solution) in solutions.iter().enumerate() {
                mobility
                    .column_mut(load + c)
                    .copy_from_slice(&solution[first..first + velocities]);
            }
            load += count;
        }
        let difference = (&mobility - mobility.transpose()).amax();
        // without bodies there is nothing to measure
        let asymmetry = match velocities {
            0 => 0.0,
            _ => difference / mobility.amax(),
        };
        let mobility = (&mobility + mobility.transpose()) / 2.0;
        let Some(factor) = mobility.clone().cholesky() else {
            return Err(RigidError::NotPositiveDefinite { asymmetry }.into());
        };
        let resistance = factor.inverse();
        if !resistance.iter().all(|entry| entry.is_finite()) {
            return Err(RigidError::NotPositiveDefinite { asymmetry }.into());
        }
        Ok(Self {
            resistance,
            mobility,
            asymmetry,
        })
    }
}
