//! Models of the flow around swimmers, behind one trait.
//!
//! A model answers one question: for this configuration of the bodies and these rates of the links,
//! what are the velocities and the forces? Gaits, integration and output know models by
//! [`Hydrodynamics`] alone; any model of the flow can be used that implements it.
//!
//! | model | flow | cost of a solution |
//! |---|---|---|
//! | [`SpheresModel`] | spheres without a mesh: Oseen, Rotne-Prager-Yamakawa, multipole expansions | microseconds to milliseconds |
//! | [`AxisymmetricModel`] | bodies on one axis: elements of high order in the meridian plane | a tenth of a second |
//! | [`FemModel`] | everything else: Taylor-Hood elements in space | seconds |
//! | [`ShapeSpace`] | tables over the shapes of a free swimmer, made by one of the above | microseconds |
#![forbid(unsafe_code)]

mod axisymmetric_model;
mod error;
mod error_estimate;
mod fem_model;
mod hydrodynamics;
mod mesh_error;
mod mobility;
mod remesh;
mod scaled_scene;
mod shape_space;
mod solution;
mod spheres_model;
mod units;

pub use axisymmetric_model::AxisymmetricModel;
pub use error::ModelError;
pub use error_estimate::ErrorEstimate;
pub use fem_model::FemModel;
pub use hydrodynamics::{Configuration, Cost, ErrorEstimates, History, Hydrodynamics, Query};
pub use mesh_error::{AccumulatedError, MeshError};
pub use remesh::{NewMesh, Remesh};
pub use shape_space::{ShapeSpace, Tabulated};
pub use solution::{BodySolution, FlowField, InstantaneousSolution};
pub use spheres_model::{SphereModel, SpheresModel};
pub use stokes::{Checks, Dofs, Seconds, SolverReport};
