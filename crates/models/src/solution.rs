//! Solutions of models: motion and forces, their error bars, stresslets, reasons for new meshes.

use std::ops::{Deref, DerefMut};

use nalgebra::{Matrix3, UnitQuaternion};
use rigid::{JointLoad, StateVelocity};
use serde::{Deserialize, Serialize};
use stokes::{Checks, Dofs, Seconds, SolverReport};

use crate::discretisation_error::DiscretisationError;
use crate::flow_field::SolutionFlow;
use crate::response::{BodySolution, Response};

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
    /// Error bars of the angular velocities.
    pub angular_velocity_error: ErrorEstimate,
    /// Error bars of the forces on the fluid.
    pub force_error: ErrorEstimate,
    /// Error bars of the torques on the fluid, about the centres of the bodies.
    pub torque_error: ErrorEstimate,
    /// Error bars of the power of the bodies on the fluid.
    pub power_error: ErrorEstimate,
    /// Largest error of the power of the bodies of a linkage by the model, relative to the sum of
    /// the sizes of the powers of forces and torques on its bodies and of its deformation; none
    /// where that of the power of all is all that is known.
    pub linkage_power_error: Option<f64>,
    /// Error bars of the mean flow through a periodic box if the scene gives its pressure gradient,
    /// else of the mean pressure gradient.
    pub mean_flow_error: ErrorEstimate,
    /// The estimated discretisation error that was subtracted, if estimates were requested.
    pub mesh_error: Option<DiscretisationError>,
    /// The estimated error by the model, computed minus exact, where it has a sign: of expansions
    /// that are truncated. It is not subtracted; the error bars contain its size.
    pub model_error: Option<Response>,
    /// Comparison with independent computations, if estimates were requested.
    pub checks: Option<Checks>,
    /// Why this solution has a new mesh, or one moved by another method than before; `None` if a
    /// mesh was moved as before or not needed.
    pub remeshed: Option<Remesh>,
    /// The flow, for queries with [`Query::with_flows`](crate::Query::with_flows) to models that
    /// compute it on the way.
    pub flow: Option<SolutionFlow>,
    /// The table in which this solution was looked up; `None` for one that was solved for.
    pub lookup: Option<Lookup>,
}

/// The table over shapes in which a solution was looked up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lookup {
    /// Number of the table from zero, of those of a model.
    pub table: usize,
    /// Number of solves that the table is made of.
    pub solves: usize,
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
            angular_velocity_error: ErrorEstimate::default(),
            force_error: ErrorEstimate::default(),
            torque_error: ErrorEstimate::default(),
            power_error: ErrorEstimate::default(),
            linkage_power_error: None,
            mean_flow_error: ErrorEstimate::default(),
            mesh_error: None,
            model_error: None,
            checks: None,
            remeshed: None,
            flow: None,
            lookup: None,
        }
    }
}

impl InstantaneousSolution {
    /// Creates a solution from motion and forces, without error bars, sizes and times.
    ///
    /// Shapes: `bodies` one entry per body of the scene, `joint_loads` one entry per joint.
    pub fn new(
        bodies: Vec<BodySolution>,
        joint_loads: Vec<JointLoad>,
        motion: StateVelocity,
    ) -> Self {
        Self::from(Response {
            motion,
            bodies,
            joint_loads,
            holding: Vec::new(),
            mean_flow: None,
            slip_power: 0.0,
            amplitude_rates: Vec::new(),
        })
    }

    /// A solution by the elimination of the joints and the factorisation of a small matrix.
    pub(crate) fn solved_directly(response: Response, dofs: usize, residual: f64) -> Self {
        Self {
            dofs: Dofs {
                total: dofs,
                ..Dofs::default()
            },
            solver: SolverReport {
                formulation: "p-tilde".to_owned(),
                solver: "direct".to_owned(),
                iterations: 0,
                true_relative_residual: residual,
            },
            ..response.into()
        }
    }

    /// Subtracts an estimated discretisation error, and enters the error bars that remain.
    pub fn correct(&mut self, error: DiscretisationError) {
        self.response -= &error.response;
        self.set_mesh_error(error);
    }

    /// Enters an error that was subtracted before, and the error bars that remain.
    pub(crate) fn set_mesh_error(&mut self, error: DiscretisationError) {
        self.error_estimate.mesh = Some(error.velocity_error_bar());
        self.angular_velocity_error.mesh = Some(error.angular_velocity_error_bar());
        self.force_error.mesh = Some(error.force_error_bar());
        self.torque_error.mesh = Some(error.torque_error_bar());
        self.mesh_error = Some(error);
        let removed = self.uncorrected_power() - self.power();
        let error = self.mesh_error.as_ref();
        self.power_error.mesh = error.map(|error| error.power_error_bar(removed));
    }

    /// Error bars of velocities, angular velocities, forces, torques and the power.
    pub fn error_bars_mut(&mut self) -> [&mut ErrorEstimate; 5] {
        [
            &mut self.error_estimate,
            &mut self.angular_velocity_error,
            &mut self.force_error,
            &mut self.torque_error,
            &mut self.power_error,
        ]
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
        if let Some(error) = &mut self.model_error {
            error.rotate(rotation);
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

/// Error bars of a quantity by source, in its units; `None` for a source that was not estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct ErrorEstimate {
    /// Discretisation on a mesh.
    pub mesh: Option<f64>,
    /// Truncation of the domain: a ball for unbounded fluid, a part of an infinite cylinder.
    pub container: Option<f64>,
    /// Approximation by the model: truncated expansions or interactions, interpolation in tables,
    /// superposition.
    pub model: Option<f64>,
    /// Residual of the linear solve.
    pub algebraic: Option<f64>,
    /// Time integration along the gait.
    pub integration: Option<f64>,
}

impl ErrorEstimate {
    /// The error bar of an approximation by a model alone.
    pub(crate) fn of_model(error: f64) -> Self {
        Self {
            model: Some(error),
            ..Self::default()
        }
    }

    /// Names and error bars of the sources, in the order of the fields.
    pub fn sources(&self) -> [(&'static str, Option<f64>); 5] {
        [
            ("mesh", self.mesh),
            ("container", self.container),
            ("model", self.model),
            ("algebraic", self.algebraic),
            ("integration", self.integration),
        ]
    }

    /// Sum of the estimated error bars; `None` if no source was estimated, which is not zero.
    pub fn estimated(&self) -> Option<f64> {
        let sum = |sum: Option<f64>, (_, bar): &(_, Option<f64>)| match (sum, bar) {
            (Some(sum), Some(bar)) => Some(sum + bar),
            (sum, bar) => sum.or(*bar),
        };
        self.sources().iter().fold(None, sum)
    }

    /// Sum of the estimated error bars, zero if no source was estimated.
    ///
    /// [`ErrorEstimate::estimated`] tells these two apart.
    pub fn total(&self) -> f64 {
        self.estimated().unwrap_or(0.0)
    }

    /// Adds `weight` times another estimate, source by source.
    pub fn accumulate(&mut self, weight: f64, other: &Self) {
        let add = |sum: &mut Option<f64>, term: Option<f64>| {
            if let Some(term) = term {
                *sum = Some(sum.unwrap_or(0.0) + weight * term);
            }
        };
        add(&mut self.mesh, other.mesh);
        add(&mut self.container, other.container);
        add(&mut self.model, other.model);
        add(&mut self.algebraic, other.algebraic);
        add(&mut self.integration, other.integration);
    }
}

/// Stresslets of the bodies of one solution, in the scene's units.
///
/// The stresslet of a body has the sign of Batchelor (1970): it is the symmetric first moment,
/// without trace, of the traction `σ n` of the fluid on the body. With the normal `n` out of the
/// body and positions `x` relative to its centre
///
/// ```text
/// S = ∮ [(σ n) x^T + x (σ n)^T] / 2 - I (x · σ n) / 3 - μ (u n^T + n u^T) dS
/// ```
///
/// A rigid sphere in the strain `E` has `20π/3 μ a^3 E` (Einstein 1906), a squirmer
/// `4π/3 μ a^2 B2 (3 e e^T - I)`: positive along its axis for pullers, negative for pushers. The
/// forces of solutions are those on the fluid, so the first moment of these forces is `-S` for
/// rigid surfaces. The flow of a force-free body is `-3 x (x · S x) / (8π μ r^5)` far from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Stresslets {
    /// One per body of the scene; zero for points.
    pub bodies: Vec<Matrix3<f64>>,
    /// Those before the estimated discretisation error was subtracted.
    pub uncorrected: Vec<Matrix3<f64>>,
    /// Error bar of the norms of the stresslets; `None` if it was not estimated.
    pub error: Option<f64>,
}

impl Stresslets {
    /// These corrected stresslets, with what was computed, the relative uncertainty of the
    /// correction and a lower bound of the uncertainty.
    #[must_use]
    pub(crate) fn correcting(self, computed: &Self, relative: f64, at_least: f64) -> Self {
        let changes = self.bodies.iter().zip(&computed.bodies);
        let largest = changes.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        Self {
            uncorrected: computed.bodies.clone(),
            error: Some(at_least.max(relative * largest)),
            ..self
        }
    }

    /// Norm of the largest stresslet.
    pub fn largest(&self) -> f64 {
        (self.bodies.iter()).map(Matrix3::norm).fold(0.0, f64::max)
    }

    /// Rotates all stresslets, for a configuration that is rotated as a whole.
    pub(crate) fn rotate(&mut self, rotation: &UnitQuaternion<f64>) {
        let rotation = rotation.to_rotation_matrix();
        for stresslet in self.bodies.iter_mut().chain(&mut self.uncorrected) {
            *stresslet = rotation.matrix() * *stresslet * rotation.matrix().transpose();
        }
    }
}

/// Why the mesh of a configuration was not obtained by moving an existing one as before.
///
/// A new mesh was generated, or the mesh of a file was moved by another method.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Remesh {
    /// There was no mesh before.
    First,
    /// A cell would have been inverted by the motion.
    Inverted,
    /// The smallest Jacobian of a curved cell, relative to the straight cell, was too small.
    Jacobian(f64),
    /// The smallest mean ratio of a cell was too small.
    Quality(f64),
    /// Cells in a gap were too long: their length relative to the width of the gap.
    Gap(f64),
    /// A body was too close to an end of the meshed part of a cylinder: their distance in radii.
    End(f64),
    /// The mesh of a file was moved by another method than before.
    Motion {
        /// Name of the method, a value of `fem.mesh_motion`.
        name: &'static str,
        /// The methods before, each with the reason why its mesh was too poor.
        tried: String,
    },
    /// The fluid between the walls of a file and the bodies was meshed again.
    InsideFile {
        /// The methods that moved the mesh of the file, each with the reason why it was too poor.
        tried: String,
    },
}

impl std::fmt::Display for Remesh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::First => write!(f, "first mesh"),
            Self::Inverted => write!(f, "a moved cell would be inverted"),
            Self::Jacobian(value) => write!(f, "smallest Jacobian of a moved cell {value:.3}"),
            Self::Quality(value) => write!(f, "smallest quality of a moved cell {value:.3}"),
            Self::Gap(ratio) => write!(
                f,
                "moved cells {ratio:.2} times as long as their gap is wide"
            ),
            Self::End(distance) => write!(
                f,
                "the meshed part of the cylinder ends {distance:.2} radii from a body"
            ),
            Self::Motion { name, tried } => {
                write!(f, "mesh of the file moved by {name} ({tried})")
            }
            Self::InsideFile { tried } => {
                write!(f, "meshed again inside the walls of the file ({tried})")
            }
        }
    }
}

/// A mesh that was generated during a run, or a change of the method that moves the mesh of a file.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct NewMesh {
    /// Time of the configuration that it was needed for.
    pub time: f64,
    /// Number of the phase, counted from one over all cycles.
    pub phase: usize,
    /// Why it was needed.
    pub reason: String,
}
