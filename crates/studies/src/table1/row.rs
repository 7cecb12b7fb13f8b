//! Cells of the table with their results.

use super::cell::Outcome;
use super::task::{Solver, Task};

/// A cell with its result.
pub struct Row {
    pub task: Task,
    pub outcome: Outcome,
}

/// Largest relative error of the forces: the tolerance of the validation for element size 0.6, the
/// coarsest here.
const FORCE_ERROR: f64 = 5e-2;

impl Row {
    /// Whether the solution is right, or MINRES has refused the formulation that is not symmetric.
    pub fn is_as_expected(&self) -> bool {
        match (&self.outcome, self.task.solver, self.task.formulation) {
            (Outcome::Failed(message), Solver::Minres, "direct-row") => {
                message.contains("symmetric")
            }
            (Outcome::Failed(_), ..) => false,
            (Outcome::Solved(_), Solver::Minres, "direct-row") => false,
            (Outcome::Solved(measured), ..) => {
                measured.residual <= self.task.solver.rtol() && measured.force_error <= FORCE_ERROR
            }
        }
    }
}
