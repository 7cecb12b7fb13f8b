//! Solutions of models: motion and forces, with their error bars.

use std::ops::{Deref, DerefMut};

use nalgebra::{UnitQuaternion, Vector3};
use rigid::StateVelocity;
use stokes::{Checks, Dofs, Seconds, SolverReport};

use crate::discretisation_error::DiscretisationError;
use crate::error_estimate::ErrorEstimate;
use crate::flow_field::SolutionFlow;
use crate::remesh::Remesh;
use crate::response::{BodySolution, Response};
use crate::stresslets::Stresslets;

/// Solution for one configuration and one set of joint rates, in the scene's units.
///
/// It dereferences to its [`Response`], so that `solution.bodies` are the bodies of the response.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct InstantaneousSolution {
    /// Motion and loads of the bodies.
    pub response: Response,
    /// Stresslets of the bodies, with their error bar; `None` for models that do not compute them
    /// and, where they cost an additional solve, for queries without
    /// [`Query::with_stresslets`](crate::Query::with_stresslets).
    pub stresslets: Option<Stresslets>,
    /// Size of the linear system.
    pub dofs: Dofs,
    /// How the linear system was solved.
    pub solver: SolverReport,
    /// Computing times.
    pub seconds: Seconds,
    /// Error bars of the velocities.
    pub error_estimate: ErrorEstimate,
    /// Error bars of the forces on the fluid.
    pub force_error: ErrorEstimate,
    /// Error bars of the power of the bodies on the fluid.
    pub power_error: ErrorEstimate,
    /// The estimated discretisation error that was subtracted, if estimates were requested.
    pub mesh_error: Option<DiscretisationError>,
    /// Comparison with independent computations, if estimates were requested.
    pub checks: Option<Checks>,
    /// Why this solution has a new mesh, or one moved by another method than before; `None` if a
    /// mesh was moved as before or not needed.
    pub remeshed: Option<Remesh>,
    /// The flow, for queries with [`Query::with_flows`](crate::Query::with_flows) to models that
    /// compute it on the way.
    pub flow: Option<SolutionFlow>,
}

impl Deref for InstantaneousSolution {
    type Target = Response;
    fn deref(&self) -> &Response {
        &self.response
    }
}

impl DerefMut for InstantaneousSolution {
    fn deref_mut(&mut self) -> &mut Response {
        &mut self.response
    }
}

impl From<Response> for InstantaneousSolution {
    /// A solution without error bars, sizes and times.
    fn from(response: Response) -> Self {
        Self {
            response,
            stresslets: None,
            dofs: Dofs::default(),
            solver: SolverReport::default(),
            seconds: Seconds::default(),
            error_estimate: ErrorEstimate::default(),
            force_error: ErrorEstimate::default(),
            power_error: ErrorEstimate::default(),
            mesh_error: None,
            checks: None,
            remeshed: None,
            flow: None,
        }
    }
}

impl InstantaneousSolution {
    /// Creates a solution from motion and forces, without error bars, sizes and times.
    ///
    /// Shapes: `bodies` one entry per body of the scene, `joint_forces` one entry per joint.
    pub fn new(
        bodies: Vec<BodySolution>,
        joint_forces: Vec<Vector3<f64>>,
        motion: StateVelocity,
    ) -> Self {
        Self::from(Response {
            motion,
            bodies,
            joint_forces,
            slip_power: 0.0,
        })
    }

    /// Subtracts an estimated discretisation error, and enters the error bars that remain.
    pub fn correct(&mut self, error: DiscretisationError) {
        self.response -= &error.response;
        self.set_mesh_error(error);
    }

    /// Enters an error that was subtracted before, and the error bars that remain.
    pub(crate) fn set_mesh_error(&mut self, error: DiscretisationError) {
        self.error_estimate.mesh = Some(error.velocity_error_bar());
        self.force_error.mesh = Some(error.force_error_bar());
        self.mesh_error = Some(error);
        let removed = self.uncorrected_power() - self.power();
        let error = self.mesh_error.as_ref();
        self.power_error.mesh = error.map(|error| error.power_error_bar(removed));
    }

    /// Motion and loads as they were computed, before the correction.
    #[must_use]
    pub fn uncorrected(&self) -> Self {
        let mut computed = self.clone();
        if let Some(error) = computed.mesh_error.take() {
            computed.response += &error.response;
        }
        if let Some(stresslets) = &mut computed.stresslets {
            stresslets.bodies.clone_from(&stresslets.uncorrected);
        }
        computed
    }

    /// Power of the bodies on the fluid before the correction.
    pub fn uncorrected_power(&self) -> f64 {
        self.uncorrected().power()
    }

    /// Rotates all motions and loads, for a configuration that is rotated as a whole.
    ///
    /// The flow is not part of them.
    pub fn rotate(&mut self, rotation: &UnitQuaternion<f64>) {
        self.response.rotate(rotation);
        if let Some(stresslets) = &mut self.stresslets {
            stresslets.rotate(rotation);
        }
        if let Some(error) = &mut self.mesh_error {
            error.response.rotate(rotation);
        }
    }

    /// Relative error bars of the forces and of the velocities, for the discretisation.
    ///
    /// They are relative to the largest force and the largest velocity, and zero if nothing was
    /// estimated or nothing moves.
    pub fn relative_mesh_errors(&self) -> [f64; 2] {
        let largest = |of: fn(&BodySolution) -> f64| self.bodies.iter().map(of).fold(0.0, f64::max);
        let over = |error: f64, size: f64| if size > 0.0 { error / size } else { 0.0 };
        [
            over(
                self.force_error.mesh.unwrap_or(0.0),
                largest(|body| body.force.norm()),
            ),
            over(
                self.error_estimate.mesh.unwrap_or(0.0),
                largest(|body| body.velocity.norm()),
            ),
        ]
    }
}
