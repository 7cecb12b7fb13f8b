//! Scene files of rigid bodies and swimmers in Stokes flow.
//!
//! A scene names the fluid, its domain, the bodies, the links between them, a gait and the options
//! of the computation. It is read from TOML; every key is checked before any work starts, and every
//! error names the file, the line, the key and the remedy.
//!
//! ```
//! let scene = scene::Scene::parse(
//!     r#"
//!     domain = { kind = "ball", radius = 10 }
//!     [[bodies]]
//!     name = "ball"
//!     radius = 1
//!     position = [0, 0, 0]
//!     force = [1, 0, 0]
//!     "#,
//! )?;
//! assert_eq!(scene.bodies[0].name, "ball");
//! assert_eq!(scene.viscosity, 1.0);
//! # Ok::<(), scene::SceneError>(())
//! ```
#![forbid(unsafe_code)]

mod build;
mod clearance;
mod contact;
mod document;
mod error;
mod file;
mod gait;
pub mod keys;
mod scene;
mod shape;
mod symmetry;
mod words;
mod write;

pub use contact::{Contact, closest_contact};
pub use document::Document;
pub use error::SceneError;
pub use gait::{Gait, Leg, Phase, legs};
pub use scene::{Body, Domain, FemOptions, ModelOptions, Scene};
pub use shape::Shape;
pub use symmetry::Arrangement;
pub use words::{
    ArmsKind, DomainKind, EstimatesKind, FormulationKind, GeometryKind, MeshMotionKind, MirrorKind,
    ModelKind, ShapeKind, SolverKind,
};
