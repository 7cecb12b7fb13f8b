//! The seam between a scene and the models that compute its flow.

use mesh::TetMesh;
use nalgebra::DMatrix;
use rigid::State;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use stokes::Dofs;

use crate::error::ModelError;
use crate::solution::{FlowField, InstantaneousSolution};

/// Where the bodies are: the state of the articulated set and the lengths of its links.
#[derive(Clone, Copy, Debug)]
pub struct Configuration<'a> {
    /// Frames of the linkages and attitudes of the bodies, as [`rigid::Articulation::place`] takes
    /// them.
    pub state: &'a State,
    /// Length of each link, in the scene's units.
    pub lengths: &'a [f64],
}

/// A question to a model: the solutions of one configuration for one or several sets of link rates.
///
/// ```
/// # let state = rigid::State { frames: vec![], attitudes: vec![] };
/// use models::{Configuration, Query};
/// let rates = [vec![-4.0, 0.0]];
/// let configuration = Configuration { state: &state, lengths: &[10.0, 10.0] };
/// let query = Query::new(configuration, &rates).without_estimates();
/// assert!(!query.estimates && query.accuracy.is_none());
/// ```
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Query<'a> {
    /// Where the bodies are.
    pub configuration: Configuration<'a>,
    /// One entry per solution, each with one rate of change per link, in the scene's units.
    pub rates: &'a [Vec<f64>],
    /// Whether discretisation errors are to be estimated ([`InstantaneousSolution::mesh_error`]).
    pub estimates: bool,
    /// Relative discretisation error of velocities and forces to which the mesh is to be adapted;
    /// none for the usual mesh.
    pub accuracy: Option<f64>,
}

impl<'a> Query<'a> {
    /// A question with error estimates, on the usual mesh.
    pub fn new(configuration: Configuration<'a>, rates: &'a [Vec<f64>]) -> Self {
        Self {
            configuration,
            rates,
            estimates: true,
            accuracy: None,
        }
    }

    /// The same without error estimates.
    #[must_use]
    pub fn without_estimates(self) -> Self {
        self.with_estimates(false)
    }

    /// The same with error estimates or without.
    #[must_use]
    pub fn with_estimates(self, estimates: bool) -> Self {
        Self { estimates, ..self }
    }

    /// The same on a mesh that is adapted until the estimated relative errors are at most
    /// `accuracy`, if one is given. A solution that misses it comes with its error bar.
    #[must_use]
    pub fn with_accuracy(self, accuracy: Option<f64>) -> Self {
        Self { accuracy, ..self }
    }
}

/// What later solutions of a model depend on besides the query, for checkpoints.
///
/// Only the model that made it knows its contents; anybody can store it.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(transparent)]
pub struct History(serde_json::Value);

impl History {
    /// A history with these contents.
    ///
    /// # Errors
    /// [`ModelError::History`] for contents that JSON cannot represent.
    pub fn new(contents: &impl Serialize) -> Result<Self, ModelError> {
        let value = serde_json::to_value(contents);
        Ok(Self(value.map_err(ModelError::history)?))
    }

    /// The contents.
    ///
    /// # Errors
    /// [`ModelError::History`] for the history of another model.
    pub fn contents<T: DeserializeOwned>(&self) -> Result<T, ModelError> {
        serde_json::from_value(self.0.clone()).map_err(ModelError::history)
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
/// A model is made for one scene and knows its bodies, loads, domain and fluid. It may store
/// anything that speeds up later solutions (meshes, factorisations, earlier solutions), but a
/// solution may depend on what was solved before only within the accuracy that it claims.
pub trait Hydrodynamics: Send {
    /// Name of the model: a value of the key `model.kind`.
    fn name(&self) -> &'static str;

    /// Velocities and forces for each entry of `query.rates`, in the scene's units.
    ///
    /// Work that depends on the configuration alone is done once; its time is counted for the first
    /// solution.
    ///
    /// # Errors
    /// No mesh, no convergence, a number that is not finite, as soon as one solution fails.
    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError>;

    /// The solution for one set of rates, with error estimates.
    ///
    /// # Errors
    /// As [`Hydrodynamics::solve`]; [`ModelError::NoSolution`] from a model that answers nothing.
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

    /// When the model estimates its discretisation errors.
    fn error_estimates(&self) -> ErrorEstimates {
        ErrorEstimates::Never
    }

    /// The grand resistance of the bodies with surfaces, links apart: `F = R U` with six entries
    /// per body, `(U, omega)` and `(F, T)`, in the scene's units. Its inverse is the mobility.
    ///
    /// # Errors
    /// As [`Hydrodynamics::solve`]; [`ModelError::Unsupported`] for models that do not offer it.
    fn resistance(&mut self, configuration: Configuration<'_>) -> Result<DMatrix<f64>, ModelError> {
        let _ = configuration;
        Err(ModelError::Unsupported {
            what: format!("the grand resistance by the model '{}'", self.name()),
            instead: "use model.kind = \"fem\"".to_owned(),
        })
    }

    /// The cost of one solution, found without solving where that is possible.
    ///
    /// # Errors
    /// As [`Hydrodynamics::solve`].
    fn cost(&mut self, configuration: Configuration<'_>) -> Result<Cost, ModelError>;

    /// The mesh of a configuration in the scene's units; none for models without a mesh.
    ///
    /// # Errors
    /// A configuration that cannot be meshed.
    fn mesh(&mut self, configuration: Configuration<'_>) -> Result<Option<TetMesh>, ModelError> {
        let _ = configuration;
        Ok(None)
    }

    /// The flow field of the last solution; none for models without a mesh.
    fn last_flow(&self) -> Option<FlowField> {
        None
    }

    /// The flow field of a configuration, on the model's mesh or on one generated for the purpose.
    ///
    /// # Errors
    /// As [`Hydrodynamics::solve`]; bodies around which no mesh can be generated.
    fn flow(
        &mut self,
        configuration: Configuration<'_>,
        rates: &[f64],
    ) -> Result<FlowField, ModelError> {
        self.solve_one(configuration, rates)?;
        self.last_flow().ok_or(ModelError::NoMesh)
    }

    /// What later solutions depend on besides the query.
    ///
    /// # Errors
    /// [`ModelError::History`].
    fn history(&self) -> Result<History, ModelError> {
        Ok(History::default())
    }

    /// Takes over a history: from here on every solution is bitwise that of the model that the
    /// history came from. Resets all state that is not part of the history, such as warm starts.
    ///
    /// # Errors
    /// A history that does not fit the model.
    fn restore(&mut self, history: &History) -> Result<(), ModelError> {
        let _ = history;
        Ok(())
    }
}

/// Predicted cost of one solution.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Size of the system.
    pub dofs: Dofs,
    /// Estimated seconds of assembly, set-up and solve, without the mesh.
    pub seconds: f64,
    /// Estimated peak memory in MiB.
    pub mib: f64,
}
