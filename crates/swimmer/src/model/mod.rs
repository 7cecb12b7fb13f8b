//! The seam between a scene and whatever computes its flow.
//!
//! A model answers one question: with the bodies placed so and the links changing at these rates, how does
//! everything move and which forces act? Gaits, integration and output know models by [`Hydrodynamics`] alone.

mod axisymmetric;
mod choice;
mod error;
pub mod fem;
mod ladder;
mod mesh_error;
mod remesh;
mod scale;
mod scaled;
mod spheres;

use mesh::TetMesh;
use nalgebra::{DMatrix, Isometry3, Vector3};
use rigid::{State, StateVelocity};
use serde::{Deserialize, Serialize};

pub use axisymmetric::AxisymmetricModel;
pub use choice::{Choice, choose};
pub use error::ModelError;
pub use fem::FemModel;
pub use mesh_error::{Checks, Drift, MeshError};
pub use remesh::{NewMesh, Remesh};
pub use spheres::{SphereModel, SpheresModel};

/// A question to the fluid: where the bodies are and how the links' lengths change, in the scene's units.
#[derive(Clone, Copy, Debug)]
pub struct Placement<'a> {
    /// Frames of the linkages and attitudes of the bodies, as [`rigid::Articulation::place`] takes them.
    pub state: &'a State,
    /// Length of each link.
    pub lengths: &'a [f64],
    /// Rate of change of each length.
    pub rates: &'a [f64],
}

impl<'a> Placement<'a> {
    /// The placements of one shape whose links change at several rates.
    pub fn at_rates(
        state: &'a State,
        lengths: &'a [f64],
        rates: &'a [Vec<f64>],
    ) -> impl Iterator<Item = Self> + Clone {
        rates.iter().map(move |rates| Self {
            state,
            lengths,
            rates,
        })
    }
}

/// A model of the fluid around the bodies of one scene.
///
/// A model is made for one scene and knows its bodies, loads, domain and fluid. It may keep what helps with
/// the next instant (meshes, factors, earlier solutions), but an answer may depend on the history only
/// within the accuracy it claims.
pub trait Hydrodynamics {
    /// The model's name: a value of the key `model.kind`.
    fn name(&self) -> &'static str;

    /// Velocities and forces at one instant, in the scene's units.
    ///
    /// # Errors
    /// Whatever kept the model from an answer it can stand by: no mesh, no convergence, a number that is not finite.
    fn instant(&mut self, placement: &Placement<'_>) -> Result<Instant, ModelError>;

    /// The answers for several rates of the links at one shape, each as [`Hydrodynamics::instant`] gives it within the accuracy it claims.
    ///
    /// `rates` has one entry a question, each with one rate a link; `state` and `lengths` are those of a [`Placement`]. Models that do
    /// part of their work for the shape alone do that once, by a method of their own; it counts as time of the first answer. The flow
    /// of the last rates is the one that [`Hydrodynamics::flow`] has afterwards.
    ///
    /// # Errors
    /// As [`Hydrodynamics::instant`], as soon as one answer fails.
    fn instants(
        &mut self,
        state: &State,
        lengths: &[f64],
        rates: &[Vec<f64>],
    ) -> Result<Vec<Instant>, ModelError> {
        Placement::at_rates(state, lengths, rates)
            .map(|placement| self.instant(&placement))
            .collect()
    }

    /// As [`Hydrodynamics::instant`], on a mesh refined until the estimated relative errors of velocities and of forces by the mesh are at
    /// most `error`. An answer that misses it all the same comes with its error bar.
    ///
    /// # Errors
    /// As [`Hydrodynamics::instant`].
    fn instant_within(
        &mut self,
        placement: &Placement<'_>,
        _error: f64,
    ) -> Result<Instant, ModelError> {
        self.instant(placement)
    }

    /// Whether the next instants are to come with estimates of what the mesh gets wrong ([`Instant::mesh_error`]), for models
    /// that have a mesh: they come until something else is said. Returns whether they will.
    fn want_estimates(&mut self, _wanted: bool) -> bool {
        false
    }

    /// The grand resistance of the bodies with surfaces at one placement, links apart: $F = R\, U$ with six entries a body,
    /// `(U, omega)` and `(F, T)`, in the scene's units. Its inverse is the mobility.
    ///
    /// # Errors
    /// As [`Hydrodynamics::instant`]; [`ModelError::NotBuilt`] for models that do not offer it.
    fn resistance(&mut self, _placement: &Placement<'_>) -> Result<DMatrix<f64>, ModelError> {
        Err(ModelError::NotBuilt {
            what: format!("the grand resistance by the model '{}'", self.name()),
            instead: "use model.kind = \"fem\"".to_owned(),
        })
    }

    /// A leg begins: whatever answers depend on that [`Hydrodynamics::history`] does not carry is to be forgotten.
    fn begin_leg(&mut self) {}

    /// What later answers depend on besides the placement, for a checkpoint; nobody but the model knows its meaning.
    ///
    /// Asked for between legs, see [`Hydrodynamics::restore`].
    fn history(&self) -> Vec<Isometry3<f64>> {
        Vec::new()
    }

    /// Takes up a history, so that every answer from here on is bitwise that of the model it came from.
    ///
    /// # Errors
    /// A history that cannot be taken up.
    fn restore(&mut self, history: &[Isometry3<f64>]) -> Result<(), ModelError> {
        let _ = history;
        Ok(())
    }

    /// What one instant would cost, found without solving.
    ///
    /// # Errors
    /// As [`Hydrodynamics::instant`], up to the solve.
    fn cost(&mut self, placement: &Placement<'_>) -> Result<Cost, ModelError>;

    /// The mesh of a placement in the scene's units, for models that have one.
    ///
    /// # Errors
    /// As [`Hydrodynamics::instant`], up to the mesh.
    fn mesh(&mut self, _placement: &Placement<'_>) -> Result<Option<TetMesh>, ModelError> {
        Ok(None)
    }

    /// The flow of the last answered instant on its mesh, for models that have one.
    fn flow(&self) -> Option<Flow> {
        None
    }

    /// The flow at a placement for pictures: on the model's own mesh, or on one made around the bodies.
    ///
    /// # Errors
    /// As [`Hydrodynamics::instant`]; bodies that cannot be meshed around.
    fn picture(&mut self, placement: &Placement<'_>) -> Result<Flow, ModelError> {
        self.instant(placement)?;
        self.flow().ok_or(ModelError::NoMesh)
    }
}

/// The answer to a [`Placement`], in the scene's units.
#[derive(Clone, Debug)]
pub struct Instant {
    /// One entry a body of the scene, in its order; points have no force and no torque.
    pub bodies: Vec<BodyInstant>,
    /// One entry a link of the scene: the force of the arm on the body that its key `body` names; the opposite acts on `to`.
    pub link_forces: Vec<Vector3<f64>>,
    /// How the placement's state changes.
    pub motion: StateVelocity,
    /// Size of the system solved.
    pub dofs: Dofs,
    /// How it was solved.
    pub solver: SolverInfo,
    /// Where the time went.
    pub seconds: Seconds,
    /// Error bars of the velocities.
    pub error_estimate: ErrorEstimate,
    /// Errors by the mesh with their signs, where they were wanted.
    pub mesh_error: Option<MeshError>,
    /// Other ways to forces and power, where estimates were wanted.
    pub checks: Option<Checks>,
    /// Why the mesh was made anew for this instant; none if one was kept or moved.
    pub remeshed: Option<Remesh>,
}

impl Instant {
    /// Estimated errors by the mesh of the forces and of the velocities, over the largest force and the largest velocity; zero where
    /// nothing was estimated or nothing moves.
    pub fn relative_mesh_errors(&self) -> [f64; 2] {
        let largest = |of: fn(&BodyInstant) -> f64| self.bodies.iter().map(of).fold(0.0, f64::max);
        let over = |error: f64, size: f64| if size > 0.0 { error / size } else { 0.0 };
        [
            over(
                self.mesh_error.as_ref().map_or(0.0, MeshError::force),
                largest(|body| body.force.norm()),
            ),
            over(
                self.error_estimate.mesh.unwrap_or(0.0),
                largest(|body| body.velocity.norm()),
            ),
        ]
    }

    /// Refuses an answer with a number that is not finite, so that none ever leaves a model.
    ///
    /// # Errors
    /// [`ModelError::NotFinite`].
    pub fn check_finite(&self, model: &'static str) -> Result<(), ModelError> {
        let finite = |v: &Vector3<f64>| v.iter().all(|c| c.is_finite());
        let motion = &self.motion;
        let moves = motion
            .frames
            .iter()
            .all(|f| finite(&f.linear) && finite(&f.angular))
            && motion.spins.iter().all(finite);
        let loads = self.bodies.iter().all(|b| {
            [b.velocity, b.angular_velocity, b.force, b.torque]
                .iter()
                .all(finite)
        }) && self.link_forces.iter().all(finite);
        match (moves, loads) {
            (true, true) => Ok(()),
            (false, _) => Err(ModelError::NotFinite {
                model,
                what: "a velocity",
            }),
            (_, false) => Err(ModelError::NotFinite {
                model,
                what: "a body's velocity or force",
            }),
        }
    }
}

/// Motion and load of one body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct BodyInstant {
    /// Velocity of its centre.
    pub velocity: Vector3<f64>,
    /// Angular velocity.
    pub angular_velocity: Vector3<f64>,
    /// Force that the body exerts on the fluid.
    pub force: Vector3<f64>,
    /// Torque that the body exerts on the fluid, about its centre.
    pub torque: Vector3<f64>,
}

/// Numbers of unknowns; all zero for models without a mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Dofs {
    /// Free velocity components.
    pub velocity: usize,
    /// Pressures.
    pub pressure: usize,
    /// Everything: velocities, pressures, bodies, multipliers.
    pub total: usize,
}

/// How an instant was solved.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SolverInfo {
    /// Constraint formulation, a value of `fem.formulation`.
    pub formulation: String,
    /// Solver, a value of `fem.solver`.
    pub solver: String,
    /// Iterations taken.
    pub iterations: usize,
    /// `|b - A x| / |b|`, computed anew from the answer.
    pub true_relative_residual: f64,
}

/// Wall-clock seconds of the parts of one instant, or of many added up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Seconds {
    /// Making or moving the mesh.
    pub mesh: f64,
    /// Assembling matrices.
    pub assembly: f64,
    /// Setting up the solver.
    pub setup: f64,
    /// Solving.
    pub solve: f64,
    /// Estimating errors.
    pub estimate: f64,
    /// All of it.
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

/// Error bars by source, in the units of what they belong to; a source that nobody estimated is absent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct ErrorEstimate {
    /// Discretisation of the flow.
    pub mesh: Option<f64>,
    /// A finite container that stands for unbounded fluid.
    pub container: Option<f64>,
    /// What the model leaves out of Stokes flow.
    pub model: Option<f64>,
    /// The algebraic solve.
    pub algebraic: Option<f64>,
    /// Integration along the gait.
    pub integration: Option<f64>,
}

impl ErrorEstimate {
    /// The sources in the order of the fields, with their names.
    pub fn sources(&self) -> [(&'static str, Option<f64>); 5] {
        [
            ("mesh", self.mesh),
            ("container", self.container),
            ("model", self.model),
            ("algebraic", self.algebraic),
            ("integration", self.integration),
        ]
    }

    /// The sum of the estimated sources.
    pub fn total(&self) -> f64 {
        self.sources().iter().filter_map(|(_, e)| *e).sum()
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

/// A flow on the nodes of its mesh, in the scene's units.
#[derive(Clone, Debug)]
pub struct Flow {
    /// The mesh.
    pub mesh: TetMesh,
    /// Velocity at every node of the mesh.
    pub velocity: Vec<Vector3<f64>>,
    /// Pressure at every vertex of the mesh; empty for models that do not know it.
    pub pressure: Vec<f64>,
}

/// What an instant would cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Size of the system.
    pub dofs: Dofs,
    /// Estimated seconds of the solve with assembly and set-up, mesh apart.
    pub seconds: f64,
    /// Estimated peak memory.
    pub mib: f64,
}
