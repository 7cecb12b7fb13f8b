//! Articulated micro-swimmers in Stokes flow: scenes, gaits, models, integration, output.
//!
//! A [`Scene`] says what there is, a [`model`] answers how it moves at one instant, an [`Integrator`] follows the gait, and
//! [`output`] writes the result. Any model of the flow can be used: it only has to implement [`model::Hydrodynamics`].
//!
//! ```
//! use swimmer::{Method, Scene, simulate};
//! # use swimmer::model::*;
//! # struct Anchor(Scene);
//! # impl Hydrodynamics for Anchor {
//! #     fn name(&self) -> &'static str { "anchor" }
//! #     fn instant(&mut self, p: &Placement) -> Result<Instant, ModelError> {
//! #         let set = &self.0.articulation;
//! #         let reduction = rigid::Reduction::of(set, &set.constraints(p.state, p.lengths, p.rates)?)?;
//! #         let q = reduction.velocities(&nalgebra::DVector::zeros(reduction.dofs()));
//! #         Ok(Instant { bodies: vec![Default::default(); 2], link_forces: Vec::new(), motion: set.state_velocity(q.as_slice())?, dofs: Default::default(),
//! #             solver: Default::default(), seconds: Default::default(), error_estimate: Default::default(), mesh_error: None,
//! #             checks: None, remeshed: None })
//! #     }
//! #     fn cost(&mut self, _: &Placement) -> Result<Cost, ModelError> { Ok(Cost::default()) }
//! # }
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
//! // A model for this example: the first body stands still. `model::choose(&scene)?.model` gives a real one.
//! let mut model = Anchor(scene.clone());
//! let outcome = simulate(&scene, &mut model, Method::Collocation, &mut ())?;
//! assert!((outcome.displacement[1].x + 5.0).abs() < 1e-12);
//! # Ok::<(), swimmer::SwimError>(())
//! ```
#![forbid(unsafe_code)]

pub mod checkpoint;
mod error;
mod integrate;
pub mod model;
pub mod output;
pub mod shape_space;
mod simulate;
mod target;

pub use checkpoint::Checkpoint;
pub use error::SwimError;
pub use integrate::{Integrator, LegResult, Method, PathPiece, Solved};
pub use output::Folder;
pub use scene::{self, Gait, Leg, Phase, Scene, SceneError, legs};
pub use simulate::{
    Interim, LegOutcome, Observer, Outcome, Sample, go_on, simulate, solve_start, start_picture,
    start_resistance,
};
pub use target::{Trial, size_factor_for_target};
