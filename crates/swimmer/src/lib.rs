//! The swimmer simulator: gaits followed through models of the flow, with error bars.
//!
//! A [`Scene`] describes bodies, links and gait; a model of the flow ([`models::Hydrodynamics`])
//! gives velocities and forces; [`simulate`] integrates the gait; [`run`] does everything that the
//! command `swim run` does, from the choice of the model to the files.
//!
//! ```
//! use swimmer::models::{
//!     BodySolution, Configuration, Cost, Hydrodynamics, InstantaneousSolution, ModelError, Query,
//! };
//! use swimmer::{Method, Scene, simulate};
//!
//! /// A model of one's own: the first body stands still.
//! struct Anchor(Scene);
//!
//! impl Hydrodynamics for Anchor {
//!     fn name(&self) -> &'static str {
//!         "anchor"
//!     }
//!
//!     fn solve(&mut self, query: &Query) -> Result<Vec<InstantaneousSolution>, ModelError> {
//!         let (set, at) = (self.0.articulation(), query.configuration);
//!         let one = |rates: &Vec<f64>| {
//!             let constraints = set.constraints(at.state, at.lengths, rates)?;
//!             let reduction = rigid::Reduction::of(set, &constraints)?;
//!             let free = nalgebra::DVector::zeros(reduction.dofs());
//!             let motion = set.state_velocity(reduction.velocities(&free).as_slice())?;
//!             let bodies = vec![BodySolution::default(); 2];
//!             Ok(InstantaneousSolution::new(bodies, vec![Default::default()], motion))
//!         };
//!         query.rates.iter().map(one).collect()
//!     }
//!
//!     fn cost(&mut self, _: Configuration) -> Result<Cost, ModelError> {
//!         Ok(Cost::default())
//!     }
//! }
//!
//! let scene = Scene::parse(
//!     r#"
//!     bodies = [
//!         { name = "anchor", radius = 100, position = [0, 0, 0] },
//!         { name = "head", radius = 1, position = [110, 0, 0] },
//!     ]
//!     links = [{ name = "neck", body = "head", to = "anchor" }]
//!     gait.phases = [{ link = "neck", length = 105 }]
//!     "#,
//! )?;
//! // `choose(&scene)?.model` gives one of the models of this workspace.
//! let mut model = Anchor(scene.clone());
//! let outcome = simulate(&scene, &mut model, Method::Collocation, &mut ())?;
//! assert!((outcome.displacement[1].x + 5.0).abs() < 1e-12);
//! # Ok::<(), swimmer::SwimError>(())
//! ```
#![forbid(unsafe_code)]

pub mod checkpoint;
mod error;
mod integrate;
mod observer;
mod outcome;
pub mod output;
mod planning;
mod run;
mod simulate;
mod start;

pub use checkpoint::Checkpoint;
pub use error::SwimError;
pub use integrate::{Integrator, LegResult, LegSolution, Method, PathPiece};
pub use models;
pub use observer::Observer;
pub use outcome::{Interim, LegOutcome, Outcome, Sample};
pub use output::Folder;
pub use planning::{Choice, Trial, TrialObserver, choose, size_factor_for_target, with_tables};
pub use run::{Progress, Report, run};
pub use scene::{self, Gait, Leg, Phase, Scene, SceneError, legs};
pub use simulate::{continue_from, simulate};
pub use start::{solve_start, start_flow, start_resistance};
