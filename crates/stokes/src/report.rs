//! Size, solver report and computing times of a solution.

use serde::{Deserialize, Serialize};

/// Numbers of degrees of freedom; all zero for models without a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct Dofs {
    /// Velocity components of the free nodes.
    pub velocity: usize,
    /// Pressures.
    pub pressure: usize,
    /// Size of the system: velocities, pressures, bodies and multipliers.
    pub total: usize,
}

/// How the linear system of a solution was solved.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct SolverReport {
    /// Name of the constraint formulation.
    pub formulation: String,
    /// Name of the linear solver.
    pub solver: String,
    /// Number of iterations.
    pub iterations: usize,
    /// `|b - A x| / |b|`, recomputed from the solution.
    pub true_relative_residual: f64,
}

/// Wall-clock seconds of the parts of one solution, or their sums over many.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Seconds {
    /// Generating or moving the mesh.
    pub mesh: f64,
    /// Assembling the matrices.
    pub assembly: f64,
    /// Setting up the solver.
    pub setup: f64,
    /// Solving.
    pub solve: f64,
    /// Estimating errors.
    pub estimate: f64,
    /// All of them and the time between them.
    pub total: f64,
}

impl std::ops::AddAssign for Seconds {
    fn add_assign(&mut self, other: Self) {
        self.mesh += other.mesh;
        self.assembly += other.assembly;
        self.setup += other.setup;
        self.solve += other.solve;
        self.estimate += other.estimate;
        self.total += other.total;
    }
}
