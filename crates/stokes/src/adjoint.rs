//! Adjoint solutions: flows of unit loads, with the matrix of a problem.

use linalg::{KrylovParams, LinearOperator, Preconditioner};
use nalgebra::Vector3;

use crate::StokesError;
use crate::linear::solve_in_groups;

/// Relative residual to which adjoint solutions are computed: they weight indicators only.
pub const ADJOINT_RTOL: f64 = 1e-2;

/// Flows of the unit loads of the last estimates, from which the next adjoint solves start.
///
/// A solution of the wrong length is replaced by zero.
#[derive(Clone, Default)]
pub struct AdjointSolutions(pub Vec<Vec<f64>>);

impl AdjointSolutions {
    /// Solves for unit loads to the relative residual `rtol`, starting from previous solutions.
    pub fn solve(
        &mut self,
        system: &dyn LinearOperator,
        preconditioner: &mut dyn Preconditioner,
        rhs: &[Vec<f64>],
        rtol: f64,
    ) -> Result<(), StokesError> {
        let parameters = KrylovParams::default().with_rel_tol(rtol);
        self.0.resize(rhs.len(), Vec::new());
        let (rhs, mut solutions): (Vec<&[f64]>, Vec<&mut [f64]>) = rhs
            .iter()
            .zip(&mut self.0)
            .map(|(rhs, solution)| {
                if solution.len() != rhs.len() {
                    *solution = vec![0.0; rhs.len()];
                }
                (rhs.as_slice(), solution.as_mut_slice())
            })
            .unzip();
        solve_in_groups(system, preconditioner, &rhs, &mut solutions, &parameters)?;
        Ok(())
    }
}

/// Unit force on a linkage in the direction in which its root moves.
#[derive(Clone, Copy)]
pub struct UnitLoad {
    /// First of the three generalised velocities that the force is conjugate to.
    pub row: usize,
    /// Unit vector.
    pub direction: Vector3<f64>,
}

impl UnitLoad {
    /// The load for a linkage whose root has the linear velocity `velocity` in the rows from `row`.
    pub fn along(velocity: Vector3<f64>, row: usize) -> Self {
        // A body at rest has no direction of motion; any direction will do.
        let direction = velocity.try_normalize(0.0).unwrap_or_else(Vector3::x);
        // Opposite motions have the same uncertainty, so one adjoint solution serves both.
        let sign = direction[direction.iamax()].signum();
        Self {
            row,
            direction: sign * direction,
        }
    }

    /// Whether two loads are equal within the tolerance of adjoint solutions.
    pub fn is_close_to(&self, other: &Self) -> bool {
        self.row == other.row && (self.direction - other.direction).norm() <= ADJOINT_RTOL
    }
}

/// Loads without those that are close to an earlier one.
#[derive(Default)]
pub struct DistinctLoads(pub Vec<UnitLoad>);

impl DistinctLoads {
    /// Position of a load in the list, which it is appended to if none is close to it.
    pub fn position(&mut self, load: UnitLoad) -> usize {
        let known = self.0.iter().position(|known| known.is_close_to(&load));
        known.unwrap_or_else(|| {
            self.0.push(load);
            self.0.len() - 1
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opposite_motions_share_a_unit_load() {
        let mut loads = DistinctLoads::default();
        let velocity = Vector3::new(0.1, -2.0, 0.3);
        assert_eq!(loads.position(UnitLoad::along(velocity, 6)), 0);
        assert_eq!(loads.position(UnitLoad::along(-3.0 * velocity, 6)), 0);
        assert_eq!(loads.position(UnitLoad::along(velocity, 0)), 1);
        assert_eq!(loads.position(UnitLoad::along(Vector3::zeros(), 6)), 2);
        assert_eq!(loads.0[2].direction, Vector3::x());
    }
}
