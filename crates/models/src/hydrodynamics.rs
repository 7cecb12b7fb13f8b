//! The interface between scenes and models of the flow.

use mesh::TetMesh;
use nalgebra::{DMatrix, Matrix6, Vector3};
use rigid::{ExternalLoad, State, StateVelocity};
use scene::Scene;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use stokes::Dofs;

use crate::error::ModelError;
use crate::rough_model::RoughModel;
use crate::solution::{FlowField, InstantaneousSolution, PointFlow};

/// Positions of the bodies: the state of the articulated set and the values of its joints.
#[derive(Clone, Copy, Debug)]
pub struct Configuration<'a> {
    /// Frames of the linkages and attitudes of the bodies, for [`rigid::Articulation::place`].
    pub state: &'a State,
    /// Value of each joint: the length of a slide in the scene's units, or an angle.
    /// Those of passive joints are part of the state, and their entries have no effect.
    pub shape: &'a [f64],
}

/// Input of a model: one configuration and one or several sets of joint rates.
///
/// ```
/// # let state = rigid::State { frames: vec![], attitudes: vec![], joints: vec![] };
/// use models::{Configuration, Query};
/// let rates = [vec![-4.0, 0.0]];
/// let configuration = Configuration { state: &state, shape: &[10.0, 10.0] };
/// let query = Query::new(configuration, &rates).without_estimates();
/// assert!(!query.estimates && query.accuracy.is_none());
/// ```
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Query<'a> {
    /// Positions of the bodies.
    pub configuration: Configuration<'a>,
    /// One set of rates per solution: the rate of change of each joint, in the scene's units.
    pub rates: &'a [Vec<f64>],
    /// Whether to estimate discretisation errors ([`InstantaneousSolution::mesh_error`]).
    pub estimates: bool,
    /// Relative discretisation error of velocities and forces to which the mesh is adapted; `None`
    /// for the usual mesh.
    pub accuracy: Option<f64>,
    /// Inertia of the bodies over an implicit time step, one entry per body of the scene.
    pub inertia: Option<&'a [BodyInertia]>,
    /// Forces on the passive joints in addition to those of their drives, in the scene's units and
    /// in the order of [`rigid::Articulation::passive_drives`]; none by default.
    pub joint_forces: Option<&'a [f64]>,
    /// Whether to compute stresslets where they cost an additional solve
    /// ([`InstantaneousSolution::stresslets`]).
    pub stresslets: bool,
}

/// Terms of an implicit time step for a body with mass, in the scene's units.
///
/// The momentum changes at the rate `dp/dt = D (U, ω) - L`, with the mass matrix over the time step
/// `D` and the known momentum over the time step `L`. In the equations `D` adds to the resistance
/// of the fluid and `L` to the external loads. Forces on the fluid contain neither, forces of
/// joints contain both.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyInertia {
    /// `D`, symmetric, in the laboratory axes.
    pub damping: Matrix6<f64>,
    /// `L`.
    pub load: ExternalLoad,
}

impl<'a> Query<'a> {
    /// A query with error estimates, on the usual mesh.
    pub fn new(configuration: Configuration<'a>, rates: &'a [Vec<f64>]) -> Self {
        Self {
            configuration,
            rates,
            estimates: true,
            accuracy: None,
            inertia: None,
            joint_forces: None,
            stresslets: false,
        }
    }

    /// The same query with the inertia of the bodies over an implicit time step.
    #[must_use]
    pub fn with_inertia(self, inertia: &'a [BodyInertia]) -> Self {
        Self {
            inertia: Some(inertia),
            ..self
        }
    }

    /// The same query with forces on the passive joints in addition to those of their drives.
    #[must_use]
    pub fn with_joint_forces(self, joint_forces: Option<&'a [f64]>) -> Self {
        Self {
            joint_forces,
            ..self
        }
    }

    /// The same query with the stresslets of the bodies.
    #[must_use]
    pub fn with_stresslets(self) -> Self {
        Self {
            stresslets: true,
            ..self
        }
    }

    /// The same query without error estimates.
    #[must_use]
    pub fn without_estimates(self) -> Self {
        self.with_estimates(false)
    }

    /// The same query with or without error estimates.
    #[must_use]
    pub fn with_estimates(self, estimates: bool) -> Self {
        Self { estimates, ..self }
    }

    /// The same query on a mesh that is adapted to the relative `accuracy`, if one is given.
    ///
    /// If the accuracy is not reached, the error bars of the solution are larger than it.
    #[must_use]
    pub fn with_accuracy(self, accuracy: Option<f64>) -> Self {
        Self { accuracy, ..self }
    }
}

/// State of a model that its later solutions depend on, for checkpoints.
///
/// The contents are known only to the model that created them; any code can store them.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(transparent)]
pub struct History(serde_json::Value);

impl History {
    /// Creates a history with the given contents.
    ///
    /// # Errors
    /// [`ModelError::History`] for contents that JSON cannot represent.
    pub fn new(contents: &impl Serialize) -> Result<Self, ModelError> {
        let value = serde_json::to_value(contents);
        Ok(Self(value.map_err(ModelError::history)?))
    }

    /// Contents of the history.
    ///
    /// # Errors
    /// [`ModelError::History`] for a history of another type, such as that of another model.
    pub fn contents<T: DeserializeOwned>(&self) -> Result<T, ModelError> {
        serde_json::from_value(self.0.clone()).map_err(ModelError::history)
    }

    /// Whether there are no contents; checkpoints of version 0.1 write that as an empty list.
    pub fn is_empty(&self) -> bool {
        self.0.is_null() || self.0.as_array().is_some_and(Vec::is_empty)
    }
}

/// When a model estimates its discretisation errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorEstimates {
    /// Never: it has no mesh, or the scene turns estimates off.
    Never,
    /// When a query requests them.
    OnRequest,
    /// With every solution, requested or not.
    Always,
}

impl ErrorEstimates {
    /// Whether a solution has estimates, given whether the query requests them.
    pub fn given(self, requested: bool) -> bool {
        match self {
            Self::Never => false,
            Self::OnRequest => requested,
            Self::Always => true,
        }
    }
}

/// A model of the flow around the bodies of one scene.
///
/// A model is created for one scene and contains its bodies, loads, domain and fluid. It may keep
/// data that speed up later solutions (meshes, factorisations, earlier solutions). Solutions may
/// depend on such data only within their error bars.
///
/// `examples/own_model.rs` implements this trait for a model of one's own.
pub trait Hydrodynamics: Send {
    /// Name of the model; for models of this crate the value of the key `model.kind`.
    fn name(&self) -> &'static str;

    /// The scene that the model was created for.
    ///
    /// A simulation refuses a model of another flow problem ([`Scene::differing_key`]).
    fn scene(&self) -> &Scene;

    /// Velocities and forces for each entry of `query.rates`, in the scene's units.
    ///
    /// Work that depends only on the configuration is done once. Its time is counted for the first
    /// solution.
    ///
    /// # Errors
    /// The first error of any solution: no mesh, no convergence, a number that is not finite.
    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError>;

    /// The solution for one set of rates, with error estimates.
    ///
    /// # Errors
    /// Those of [`Hydrodynamics::solve`]; [`ModelError::NoSolution`] if it returns an empty list.
    fn solve_one(
        &mut self,
        configuration: Configuration<'_>,
        rates: &[f64],
    ) -> Result<InstantaneousSolution, ModelError> {
        let rates = [rates.to_vec()];
        let mut solutions = self.solve(&Query::new(configuration, &rates))?;
        solutions
            .pop()
            .ok_or(ModelError::NoSolution { model: self.name() })
    }

    /// The solutions of several queries, as by [`Hydrodynamics::solve`] for each, at once if the
    /// model gains by that; `None`, the default, if it does not.
    ///
    /// Afterwards [`Hydrodynamics::last_flow`] refers to the last query, or to that selected by
    /// [`Hydrodynamics::select_flow`]. Results do not depend on the number of threads.
    ///
    /// # Errors
    /// The first error of any query.
    fn solve_together(
        &mut self,
        queries: &[Query<'_>],
    ) -> Result<Option<Vec<Vec<InstantaneousSolution>>>, ModelError> {
        let _ = queries;
        Ok(None)
    }

    /// Makes the flow of one query of [`Hydrodynamics::solve_together`] the
    /// [last flow](Hydrodynamics::last_flow); no effect by default.
    fn select_flow(&mut self, number: usize) {
        let _ = number;
    }

    /// When the model estimates its discretisation errors.
    fn error_estimates(&self) -> ErrorEstimates {
        ErrorEstimates::Never
    }

    /// Whether the model keeps its own error below its share of `model.tolerance`.
    ///
    /// If it does, the tolerance limits all error bars of a run together. Otherwise the model is a
    /// fixed approximation, or its mesh has a given size, and the tolerance limits the integration
    /// error alone.
    fn controls_error(&self) -> bool {
        false
    }

    /// A copy of the model, to solve for several configurations in parallel.
    ///
    /// Solutions of the copy are bitwise those of the model. `None`, the default, for models whose
    /// solutions depend on earlier ones or fill all threads by themselves.
    fn duplicate(&self) -> Option<Box<dyn Hydrodynamics>> {
        None
    }

    /// Grand resistance matrix of the bodies with surfaces, without their joints.
    ///
    /// `F = R U` in the scene's units, with six entries per body: `(U, ω)` and `(F, T)`. Its
    /// inverse is the grand mobility matrix.
    ///
    /// # Errors
    /// Those of [`Hydrodynamics::solve`]; [`ModelError::Unsupported`] by default.
    fn resistance(&mut self, configuration: Configuration<'_>) -> Result<DMatrix<f64>, ModelError> {
        let _ = configuration;
        Err(ModelError::Unsupported {
            what: format!("the grand resistance by the model '{}'", self.name()),
            instead: "use model.kind = \"fem\"".to_owned(),
        })
    }

    /// Error bars of the entries of [`Hydrodynamics::resistance`]; `None` if they are not
    /// estimated.
    ///
    /// # Errors
    /// Those of [`Hydrodynamics::resistance`].
    fn resistance_errors(
        &mut self,
        configuration: Configuration<'_>,
    ) -> Result<Option<DMatrix<f64>>, ModelError> {
        let _ = configuration;
        Ok(None)
    }

    /// Velocities for a unit force on each passive joint, all else at rest and without loads.
    ///
    /// They are derivatives for the implicit integration of springs and affect its convergence, not
    /// its result. By default they are those of spheres in unbounded fluid.
    ///
    /// # Errors
    /// A configuration for which they cannot be computed.
    fn joint_responses(
        &mut self,
        configuration: Configuration<'_>,
    ) -> Result<Vec<StateVelocity>, ModelError> {
        RoughModel::new(self.scene())?.joint_responses(configuration)
    }

    /// Predicted cost of one solution, without solving if the model can predict it.
    ///
    /// # Errors
    /// Those of [`Hydrodynamics::solve`].
    fn cost(&mut self, configuration: Configuration<'_>) -> Result<Cost, ModelError>;

    /// Mesh of a configuration in the scene's units; `None` for models without a mesh.
    ///
    /// # Errors
    /// A configuration that cannot be meshed.
    fn mesh(&mut self, configuration: Configuration<'_>) -> Result<Option<TetMesh>, ModelError> {
        let _ = configuration;
        Ok(None)
    }

    /// Flow field of the last solution; `None` for models without a mesh.
    fn last_flow(&self) -> Option<FlowField> {
        None
    }

    /// Flow field of a configuration, on the mesh of the model or on one generated for it.
    ///
    /// # Errors
    /// Those of [`Hydrodynamics::solve`]; bodies around which no mesh can be generated.
    fn flow(
        &mut self,
        configuration: Configuration<'_>,
        rates: &[f64],
    ) -> Result<FlowField, ModelError> {
        self.solve_one(configuration, rates)?;
        self.last_flow().ok_or(ModelError::NoMesh)
    }

    /// Velocity and pressure at points, in their order; `None` for a point outside the fluid, or
    /// outside the mesh.
    ///
    /// # Errors
    /// Those of [`Hydrodynamics::flow`].
    fn flow_at(
        &mut self,
        configuration: Configuration<'_>,
        rates: &[f64],
        points: &[Vector3<f64>],
    ) -> Result<Vec<Option<PointFlow>>, ModelError> {
        Ok(self.flow(configuration, rates)?.at(points))
    }

    /// State that later solutions depend on, besides the query.
    ///
    /// # Errors
    /// [`ModelError::History`] for state that JSON cannot represent.
    fn history(&self) -> Result<History, ModelError> {
        Ok(History::default())
    }

    /// Restores the state of a history.
    ///
    /// All later solutions are bitwise those of the model that the history was taken from. State
    /// that is not part of the history, such as warm starts, is reset.
    ///
    /// # Errors
    /// [`ModelError::History`] for a history that does not fit the model. A model without state of
    /// its own accepts only the empty history.
    fn restore(&mut self, history: &History) -> Result<(), ModelError> {
        match history.is_empty() {
            true => Ok(()),
            false => Err(ModelError::History(
                "is not empty, but the model has none".to_owned(),
            )),
        }
    }
}

/// Predicted cost of one solution.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Size of the system.
    pub dofs: Dofs,
    /// Estimated seconds for assembly, set-up and solve, without the mesh.
    pub seconds: f64,
    /// Estimated peak memory in MiB.
    pub mib: f64,
}
