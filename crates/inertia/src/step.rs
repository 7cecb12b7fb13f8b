//! Steps in time, and what is remembered of them.

use mesh::TetMesh;
use nalgebra::{Isometry3, Vector3, Vector6};
use rigid::{State, StateVelocity};
use stokes::Solution;

/// What is known at one time.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Deserialize, serde::Serialize))]
pub(crate) struct Level {
    pub time: f64,
    /// Positions of the nodes, and velocities of the fluid there.
    pub points: Vec<Vector3<f64>>,
    pub velocity: Vec<Vector3<f64>>,
    pub state: State,
    pub rate: StateVelocity,
    /// The step that led to the state.
    pub increment: Option<StateVelocity>,
    pub shape: Vec<f64>,
    pub generalised: Vec<f64>,
    /// Momentum and angular momentum of each body.
    pub momenta: Vec<Vector6<f64>>,
}

/// A step, before it is accepted.
pub struct Step {
    /// Time at its end.
    pub time: f64,
    /// Its length.
    pub length: f64,
    /// Poses of all bodies at its end.
    pub poses: Vec<Isometry3<f64>>,
    /// Estimated error of the velocities in this step, relative to the largest velocities so far:
    /// of the fluid in L2 and of the bodies; infinite if there are too few levels for an estimate.
    pub error: f64,
    /// Estimated error of the velocities of surfaces in this step; infinite as `error`.
    pub velocity_error: f64,
    /// Rates of change of `(U, ω)` of each body with a surface, by the difference formula.
    pub accelerations: Vec<Vector6<f64>>,
    /// Number of solves.
    pub solves: usize,
    /// The last of them: flow, velocities and forces, which include the inertia of the fluid.
    pub solved: Solution,
    /// Difference of the positions from those of the mesh, in body sizes.
    pub mesh_error: f64,
    pub(crate) mesh: TetMesh,
    pub(crate) level: Level,
}

impl Step {
    /// The mesh on which the step was solved.
    pub fn mesh(&self) -> &TetMesh {
        &self.mesh
    }

    /// The state of the bodies at its end.
    pub fn state(&self) -> &State {
        &self.level.state
    }

    /// Values of the joints at its end.
    pub fn shape(&self) -> &[f64] {
        &self.level.shape
    }

    /// The change of the state in this step; none before a first step.
    pub fn increment(&self) -> Option<&StateVelocity> {
        self.level.increment.as_ref()
    }
}

/// Numbers of an accepted step.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct StepReport {
    /// Time at its end.
    pub time: f64,
    /// `(U, ω)` of each body with a surface.
    pub bodies: Vec<f64>,
    /// `(F, T)` that each of them exerts on the fluid.
    pub forces: Vec<f64>,
    /// Estimated relative error of the velocities.
    pub error: f64,
    /// Number of solves.
    pub solves: usize,
    /// Iterations of the last one.
    pub iterations: usize,
}

impl StepReport {
    pub(crate) fn new(step: &Step) -> Self {
        Self {
            time: step.time,
            bodies: step.solved.flow.bodies.as_slice().to_vec(),
            forces: step.solved.flow.forces.as_slice().to_vec(),
            error: step.error,
            solves: step.solves,
            iterations: step.solved.solver.iterations,
        }
    }
}
