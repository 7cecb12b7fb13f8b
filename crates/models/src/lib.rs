#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod accumulated_error;
mod axisymmetric_model;
mod discretisation_error;
mod error;
mod error_estimate;
mod fem_model;
mod flow_field;
mod hydrodynamics;
mod mobility;
mod query;
mod record;
mod remesh;
mod response;
mod rough_model;
mod scaled_scene;
mod shape_space;
mod solution;
mod spheres_model;
mod stresslets;
mod superposition;
mod surface_motion;
mod units;

pub use accumulated_error::AccumulatedError;
pub use axisymmetric_model::AxisymmetricModel;
pub use discretisation_error::{DiscretisationError, Uncertainty};
pub use error::ModelError;
pub use error_estimate::ErrorEstimate;
pub use fem_model::FemModel;
pub use flow_field::{FlowField, PointFlow, SolutionFlow};
pub use hydrodynamics::{
    Capabilities, Cost, ErrorEstimates, Flows, GrandResistance, History, Hydrodynamics, Resistances,
};
pub use query::{BodyInertia, Configuration, Query};
pub use remesh::{NewMesh, Remesh};
pub use response::{BodySolution, Response};
pub use rough_model::RoughModel;
pub use shape_space::{LocalGeometry, Part, ShapeGeometry, ShapeSpace, SolvedShapes, Tabulated};
pub use solution::InstantaneousSolution;
pub use spheres_model::{SphereModel, SpheresModel};
pub use stokes::{Checks, Dofs, Seconds, SolverReport};
pub use stresslets::Stresslets;
pub use superposition::Superposed;

// Types of these crates are part of the interface.
pub use mesh;
pub use mesher;
pub use nalgebra;
pub use rigid;
pub use scene;
pub use stokes;
