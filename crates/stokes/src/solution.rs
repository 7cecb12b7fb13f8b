//! A solution with its error estimate, size, solver report and computing times.

use rigid::{Constrained, FlowSolution, Formulation};
use serde::{Deserialize, Serialize};

use crate::checks::Checks;
use crate::estimate::Estimate;
use crate::surface_power::SurfacePowers;

/// First-order effect of the regularisation of a viscosity law.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Regularisation {
    /// Change of the flow if the law had none.
    pub change: FlowSolution,
    /// Power of the stress that it changes: the change of the dissipation at the same velocities of
    /// all surfaces.
    pub power: f64,
}

/// Solution for one drive, at viscosity 1.
#[non_exhaustive]
pub struct Solution {
    /// Velocities, forces and pressure; the pressure has zero mean over the fluid.
    pub flow: FlowSolution,
    /// Powers of slip and deformation on the fluid.
    pub powers: SurfacePowers,
    /// Estimated discretisation errors, if requested.
    pub estimate: Option<Estimate>,
    /// Comparison with independent computations of forces and power, if estimates were requested.
    pub checks: Option<Checks>,
    /// Effect of the regularisation of the viscosity law; none if it has none, if nothing moves, or
    /// if estimates were not requested.
    pub regularisation: Option<Regularisation>,
    /// Numbers of degrees of freedom.
    pub dofs: Dofs,
    /// How the linear system was solved.
    pub solver: SolverReport,
    /// Estimated relative error of the velocities due to the linear solve.
    pub algebraic_error: f64,
    /// Times of assembly, set-up, solve and estimate.
    pub seconds: Seconds,
}

/// Flows that were solved with one matrix, for [`Problem::solutions`](crate::Problem::solutions).
pub struct SolvedBatch {
    /// The flows, each with a pressure of zero mean.
    pub flows: Vec<FlowSolution>,
    /// How each flow was solved, and the estimated relative error of its velocities.
    pub reports: Vec<(SolverReport, f64)>,
    /// Estimated errors and checks of the flows; empty if they were not requested.
    pub estimates: Vec<(Estimate, Checks)>,
    /// Numbers of degrees of freedom.
    pub dofs: Dofs,
    /// Times of all flows together.
    pub seconds: Seconds,
}

/// Numbers of degrees of freedom; all zero for models without a mesh.
///
/// A model of one's own fills it with `..Dofs::default()`, also when it has more fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct Dofs {
    /// Velocity components of the free nodes.
    pub velocity: usize,
    /// Pressures.
    pub pressure: usize,
    /// Size of the system: velocities, pressures, bodies and multipliers.
    pub total: usize,
}

impl Dofs {
    /// Those of an assembled system.
    pub(crate) fn of(system: &Constrained) -> Self {
        Self {
            velocity: system.system.velocity_range().len(),
            pressure: system.system.pressure_range().len(),
            total: system.rhs.len(),
        }
    }
}

/// How the linear system of a solution was solved.
///
/// A model of one's own fills it with `..SolverReport::default()`, also when it has more fields.
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

impl SolverReport {
    /// The report of a solve in a formulation.
    pub fn new(
        formulation: &dyn Formulation,
        solver: String,
        iterations: usize,
        residual: f64,
    ) -> Self {
        Self {
            formulation: formulation.name().to_owned(),
            solver,
            iterations,
            true_relative_residual: residual,
        }
    }
}

/// Wall-clock seconds of the parts of one solution, or their sums over many.
///
/// A model of one's own fills it with `..Seconds::default()`, also when it has more fields.
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

impl Seconds {
    /// Times of `count` solutions with one matrix: the first one has those of assembly and set-up.
    pub(crate) fn shared(self, count: usize) -> impl Iterator<Item = Self> {
        let (solve, estimate) = (self.solve / count as f64, self.estimate / count as f64);
        (0..count).map(move |number| {
            let first = if number == 0 { self } else { Self::default() };
            Self {
                solve,
                estimate,
                total: first.assembly + first.setup + solve + estimate,
                ..first
            }
        })
    }
}
