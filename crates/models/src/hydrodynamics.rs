//! The interface between scenes and models of the flow.

use mesh::TetMesh;
use nalgebra::{DMatrix, DVector, Vector3};
use rayon::prelude::*;
use rigid::StateVelocity;
use scene::Scene;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use stokes::Dofs;

use crate::error::ModelError;
use crate::flow_field::{FlowField, PointFlow};
use crate::neglected_terms::{NeglectedTerm, NeglectedTerms};
use crate::query::{Configuration, Query};
use crate::solution::InstantaneousSolution;

/// A model of the flow around the bodies of one scene.
///
/// A model is created for one scene and contains its bodies, loads, domain and fluid. It may keep
/// data that speed up later solutions (meshes, factorisations, earlier solutions). Solutions may
/// depend on such data only within their error bars.
///
/// `examples/own_model.rs` implements this trait for a model of one's own: only
/// [`scene`](Hydrodynamics::scene), [`name`](Hydrodynamics::name) and
/// [`solve`](Hydrodynamics::solve) are required.
///
/// A model that wraps another one implements [`inner`](Hydrodynamics::inner) and
/// [`inner_mut`](Hydrodynamics::inner_mut). All that it does not implement itself is then that of
/// the inner model: each default below asks it first, but for those that pass through `solve` of
/// the wrapper, and for [`duplicate`](Hydrodynamics::duplicate): only the wrapper can copy itself.
pub trait Hydrodynamics: Send {
    /// The scene that the model was created for.
    ///
    /// A simulation refuses a model of another flow problem ([`Scene::differing_key`]).
    fn scene(&self) -> &Scene;

    /// Name of the model; for models of this crate the value of the key `model.kind`.
    fn name(&self) -> &'static str;

    /// Velocities and forces for each entry of `query.rates`, in the scene's units.
    ///
    /// Work that depends only on the configuration is done once. Its time is counted for the first
    /// solution.
    ///
    /// # Errors
    /// The first error of any solution: no mesh, no convergence, a number that is not finite.
    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError>;

    /// What the model can do, and when. By default nothing, except that solutions are computed one
    /// by one.
    fn capabilities(&self) -> Capabilities {
        Capabilities {
            // The solutions of several queries pass through the wrapper one by one.
            solves_together: false,
            // So do random loads.
            fluctuates: false,
            ..(self.inner()).map_or_else(Capabilities::default, |inner| inner.capabilities())
        }
    }

    /// The model that this one wraps.
    fn inner(&self) -> Option<&dyn Hydrodynamics> {
        None
    }

    /// The model that this one wraps.
    fn inner_mut(&mut self) -> Option<&mut dyn Hydrodynamics> {
        None
    }

    /// The solution for one set of rates, with error estimates and its flow.
    ///
    /// # Errors
    /// Those of [`Hydrodynamics::solve`]; [`ModelError::NoSolution`] if it returns an empty list.
    fn solve_one(
        &mut self,
        configuration: Configuration<'_>,
        rates: &[f64],
    ) -> Result<InstantaneousSolution, ModelError> {
        let rates = [rates.to_vec()];
        let query = Query::new(configuration, &rates).with_flows(true);
        let mut solutions = self.solve(&query)?;
        solutions
            .pop()
            .ok_or(ModelError::NoSolution { model: self.name() })
    }

    /// The solutions of several queries, as by [`Hydrodynamics::solve`] for each; at once where the
    /// model gains by that ([`Capabilities::solves_together`]), by default with copies of it.
    ///
    /// Results do not depend on the number of threads.
    ///
    /// # Errors
    /// The first error of any query.
    fn solve_all(
        &mut self,
        queries: &[Query<'_>],
    ) -> Result<Vec<Vec<InstantaneousSolution>>, ModelError> {
        let copies: Option<Vec<_>> = match self.capabilities().solves_together {
            true => (queries.iter())
                .map(|query| Some((self.duplicate()?, query)))
                .collect(),
            false => None,
        };
        match copies {
            Some(copies) => {
                let solve =
                    |(mut model, query): (Box<dyn Hydrodynamics>, &Query<'_>)| model.solve(query);
                let solved: Vec<_> = copies.into_par_iter().map(solve).collect();
                // The first error in the order of the queries.
                solved.into_iter().collect()
            }
            None => queries.iter().map(|query| self.solve(query)).collect(),
        }
    }

    /// A copy of the model, to solve for several configurations in parallel.
    ///
    /// Solutions of the copy are bitwise those of the model. `None`, the default, for models whose
    /// solutions depend on earlier ones or fill all threads by themselves.
    fn duplicate(&self) -> Option<Box<dyn Hydrodynamics>> {
        None
    }

    /// Predicted cost of one solution, by default found by solving.
    ///
    /// # Errors
    /// Those of [`Hydrodynamics::solve`].
    fn cost(&mut self, configuration: Configuration<'_>) -> Result<PredictedCost, ModelError> {
        if let Some(inner) = self.inner_mut() {
            return inner.cost(configuration);
        }
        let rates = vec![0.0; configuration.shape.len()];
        Ok(PredictedCost::of_solution(
            &self.solve_one(configuration, &rates)?,
        ))
    }

    /// Seconds of one solution, where they are known without solving or meshing.
    fn predicted_seconds(&self, configuration: Configuration<'_>) -> Option<f64> {
        self.inner()?.predicted_seconds(configuration)
    }

    /// Mesh of a configuration in the scene's units; `None` for models without a mesh.
    ///
    /// # Errors
    /// A configuration that cannot be meshed.
    fn mesh(&mut self, configuration: Configuration<'_>) -> Result<Option<TetMesh>, ModelError> {
        match self.inner_mut() {
            Some(inner) => inner.mesh(configuration),
            None => Ok(None),
        }
    }

    /// The flow of configurations.
    ///
    /// # Errors
    /// [`ModelError::NoMesh`] for models that compute velocities and forces of bodies only.
    fn flows(&mut self) -> Result<&mut dyn Flows, ModelError> {
        self.inner_mut().ok_or(ModelError::NoMesh)?.flows()
    }

    /// The grand resistance matrices of configurations.
    ///
    /// # Errors
    /// [`ModelError::Unsupported`] for models that do not compute them.
    fn resistances(&mut self) -> Result<&mut dyn Resistances, ModelError> {
        let what = format!("the grand resistance by the model '{}'", self.name());
        let unsupported = ModelError::unsupported(what, "use model.kind = \"fem\"");
        self.inner_mut().ok_or(unsupported)?.resistances()
    }

    /// The random loads of thermal noise.
    ///
    /// # Errors
    /// [`ModelError::Unsupported`] for models without it ([`Capabilities::fluctuates`]).
    fn fluctuations(&mut self) -> Result<&mut dyn Fluctuations, ModelError> {
        let what = format!("thermal noise by the model '{}'", self.name());
        Err(ModelError::unsupported(what, SPHERES_FOR_NOISE))
    }

    /// What a neglected term would change about the velocities of configurations.
    ///
    /// # Errors
    /// [`ModelError::Unsupported`] for models that do not compute it.
    fn neglected(&mut self, term: NeglectedTerm) -> Result<&mut dyn NeglectedTerms, ModelError> {
        let (term_name, model) = (term.name(), self.name());
        let what = format!("the effect of {term_name} by the model '{model}'");
        let unsupported = ModelError::unsupported(what, "use model.kind = \"fem\"");
        self.inner_mut().ok_or(unsupported)?.neglected(term)
    }

    /// Velocities for a unit force on each passive joint, all else at rest and without loads.
    ///
    /// They are derivatives for the implicit integration of springs and affect its convergence, not
    /// its result. `None`, the default, if those of [`RoughModel`](crate::RoughModel) serve.
    ///
    /// # Errors
    /// A configuration for which they cannot be computed.
    fn joint_responses(
        &mut self,
        configuration: Configuration<'_>,
    ) -> Result<Option<Vec<StateVelocity>>, ModelError> {
        match self.inner_mut() {
            Some(inner) => inner.joint_responses(configuration),
            None => Ok(None),
        }
    }

    /// State that later solutions depend on, besides the query.
    ///
    /// # Errors
    /// [`ModelError::History`] for state that JSON cannot represent.
    fn history(&self) -> Result<History, ModelError> {
        (self.inner()).map_or(Ok(History::default()), |inner| inner.history())
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
        match self.inner_mut() {
            Some(inner) => inner.restore(history),
            None if history.is_empty() => Ok(()),
            None => Err(ModelError::History(
                "is not empty, but the model has none".to_owned(),
            )),
        }
    }
}

/// What a model can do, and when.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Capabilities {
    /// When the model estimates its discretisation errors.
    pub error_estimates: ErrorEstimates,
    /// Whether the model keeps its own error below its share of `model.tolerance`.
    ///
    /// If it does, the tolerance limits all error bars of a run together. Otherwise the model is a
    /// fixed approximation, or its mesh has a given size, and the tolerance limits the integration
    /// error alone.
    pub controls_error: bool,
    /// Whether each solution needs a mesh in space and a linear solve on it: seconds instead of
    /// milliseconds. Its flow is then known on this mesh.
    pub has_mesh: bool,
    /// Whether [`Hydrodynamics::solve_all`] gains by solving several queries at once.
    pub solves_together: bool,
    /// Whether the fluid of the model follows the viscosity law of the scene
    /// ([`scene::Rheology`]): velocities then depend on rates and loads nonlinearly.
    pub follows_rheology: bool,
    /// Whether surfaces deform as the scene says ([`Scene::deforms`]).
    pub deforms: bool,
    /// Whether the model has the random loads of thermal noise ([`Hydrodynamics::fluctuations`]).
    pub fluctuates: bool,
}

/// What has thermal noise, in the words of a remedy.
const SPHERES_FOR_NOISE: &str = "use spheres in unbounded fluid, in a ball, above a wall or in a \
                                 periodic box, with model.kind = \"rpy\", \"multipole\", \"oseen\" \
                                 or \"auto\"; or remove fluid.thermal_energy";

impl Capabilities {
    /// Refuses a scene with bodies that deform, if the model does not deform them.
    ///
    /// # Errors
    /// [`ModelError::Unsupported`] with the place of the body.
    pub fn check_deformations(&self, scene: &Scene, model: &str) -> Result<(), ModelError> {
        let mut bodies = scene.bodies().iter();
        match bodies.position(|body| body.deformation.is_some() && !self.deforms) {
            None => Ok(()),
            Some(number) => Err(ModelError::Unsupported {
                what: format!(
                    "{}: a body that deforms, by the model {model}",
                    scene.place(&format!("bodies[{number}]"))
                ),
                instead: "set model.kind = \"fem\" or \"auto\"".to_owned(),
            }),
        }
    }

    /// Refuses a scene with thermal noise, if the model does not have it.
    ///
    /// # Errors
    /// [`ModelError::Unsupported`] with the place of the key.
    pub fn check_noise(&self, scene: &Scene, model: &str) -> Result<(), ModelError> {
        match scene.noise().is_some() && !self.fluctuates {
            false => Ok(()),
            true => Err(ModelError::unsupported(
                format!(
                    "{}: thermal noise by the model {model}",
                    scene.place("fluid.thermal_energy")
                ),
                SPHERES_FOR_NOISE,
            )),
        }
    }

    /// Refuses a scene whose viscosity law the model does not follow.
    ///
    /// # Errors
    /// [`ModelError::Unsupported`] with the place of the key.
    pub fn check_rheology(&self, scene: &Scene, model: &str) -> Result<(), ModelError> {
        match scene.viscosity_law().is_some() && !self.follows_rheology {
            false => Ok(()),
            true => Err(ModelError::Unsupported {
                what: format!(
                    "{}: a viscosity that depends on the shear rate, by the model {model}",
                    scene.place("fluid.law")
                ),
                instead: "set model.kind = \"fem\", or fluid.rheology = \"newtonian\"".to_owned(),
            }),
        }
    }
}

/// When a model estimates its discretisation errors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorEstimates {
    /// Never: it has no mesh, or the scene turns estimates off.
    #[default]
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

/// Models that know the flow around the bodies, not only their velocities and forces.
pub trait Flows {
    /// Flow field of a configuration, on the mesh of the model or on one generated for it.
    ///
    /// # Errors
    /// Those of [`Hydrodynamics::solve`]; bodies around which no mesh can be generated.
    fn flow(
        &mut self,
        configuration: Configuration<'_>,
        rates: &[f64],
    ) -> Result<FlowField, ModelError>;

    /// Velocity and pressure at points, in their order; `None` for a point outside the fluid, or
    /// outside the mesh.
    ///
    /// # Errors
    /// Those of [`Flows::flow`].
    fn flow_at(
        &mut self,
        configuration: Configuration<'_>,
        rates: &[f64],
        points: &[Vector3<f64>],
    ) -> Result<Vec<Option<PointFlow>>, ModelError> {
        Ok(self.flow(configuration, rates)?.at(points))
    }
}

/// Models that compute grand resistance matrices.
pub trait Resistances {
    /// Grand resistance matrix of the bodies with surfaces, without their joints.
    ///
    /// # Errors
    /// Those of [`Hydrodynamics::solve`].
    fn resistance(
        &mut self,
        configuration: Configuration<'_>,
    ) -> Result<SceneResistance, ModelError>;
}

/// Models with thermal noise.
pub trait Fluctuations {
    /// Random loads conjugate to the generalised velocities ([`rigid::VelocityLayout`]), from the
    /// independent standard normal numbers that `normal` returns.
    ///
    /// With the linear map `K` from the velocities by which the state changes
    /// ([`rigid::Articulation::state_velocities`]) to those of the bodies, the grand resistance `R`
    /// and the coefficients `D` of dashpots, their covariance is
    ///
    /// ```text
    /// <Q Q^T> = power (K^T R K + D)
    /// ```
    ///
    /// (fluctuation and dissipation: Ermak & McCammon 1978, J. Chem. Phys. 69, 1352). The loads are
    /// those on these velocities; all other entries are zero. Loads of `power = 2 k_B T / dt`, an
    /// energy over a time, give displacements in a time `dt` of the covariance `2 k_B T N dt` with
    /// the mobility `N = (K^T R K + D)^-1`. Numbers are taken in a fixed order.
    ///
    /// # Errors
    /// Those of [`Hydrodynamics::solve`].
    fn random_loads(
        &mut self,
        configuration: Configuration<'_>,
        power: f64,
        normal: &mut dyn FnMut() -> f64,
    ) -> Result<DVector<f64>, ModelError>;
}

/// Grand resistance matrix of bodies, with its error bars.
#[derive(Clone, Debug)]
pub struct SceneResistance {
    /// `F = R U` in the scene's units, with six entries per body: `(U, ω)` and `(F, T)`. Its
    /// inverse is the grand mobility matrix.
    pub matrix: DMatrix<f64>,
    /// Error bars of the entries; `None` if they are not estimated.
    pub errors: Option<DMatrix<f64>>,
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

/// Predicted cost of one solution.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PredictedCost {
    /// Size of the system.
    pub dofs: Dofs,
    /// Estimated seconds for assembly, set-up and solve, without the mesh.
    pub seconds: f64,
    /// Estimated peak memory in MiB.
    pub mib: f64,
}

impl PredictedCost {
    /// The cost that a solution had, without its memory.
    pub(crate) fn of_solution(solution: &InstantaneousSolution) -> Self {
        Self {
            dofs: solution.dofs,
            seconds: solution.seconds.total,
            mib: 0.0,
        }
    }
}

impl InstantaneousSolution {
    /// Checks that the solution of a model has the bodies and linkages of its scene, and that all
    /// velocities and forces are finite.
    ///
    /// # Errors
    /// [`ModelError::WrongCount`], [`ModelError::NotFinite`].
    pub fn check(&self, model: &dyn Hydrodynamics) -> Result<(), ModelError> {
        let (scene, model) = (model.scene(), model.name());
        let (bodies, linkages) = (scene.bodies().len(), scene.articulation().linkages().len());
        for (what, found, expected) in [
            ("bodies", self.bodies.len(), bodies),
            ("angular velocities", self.motion.spins.len(), bodies),
            ("frames", self.motion.frames.len(), linkages),
        ] {
            if found != expected {
                return Err(ModelError::WrongCount {
                    model,
                    what,
                    found,
                    expected,
                });
            }
        }
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
        }) && (self.joint_loads.iter())
            .all(|load| finite(&load.force) && finite(&load.torque) && load.drive.is_finite());
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
