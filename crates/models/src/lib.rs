#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod axial_resistance;
mod axial_surfaces;
mod axisymmetric_model;
mod discretisation_error;
mod error;
mod error_estimate;
mod fem_model;
mod hydrodynamics;
mod mobility;
mod record;
mod remesh;
mod rough_model;
mod scaled_scene;
mod shape_space;
mod solution;
mod spheres_model;
mod stresslets;
mod superposition;
mod surface_motion;
mod units;

pub use axisymmetric_model::AxisymmetricModel;
pub use discretisation_error::{AccumulatedError, DiscretisationError, Uncertainty};
pub use error::ModelError;
pub use error_estimate::ErrorEstimate;
pub use fem_model::FemModel;
pub use hydrodynamics::{
    BodyInertia, Configuration, Cost, ErrorEstimates, History, Hydrodynamics, Query,
};
pub use remesh::{NewMesh, Remesh};
pub use rough_model::RoughModel;
pub use shape_space::{LocalGeometry, Part, ShapeGeometry, ShapeSpace, SolvedShapes, Tabulated};
pub use solution::{BodySolution, FlowField, InstantaneousSolution, PointFlow};
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
