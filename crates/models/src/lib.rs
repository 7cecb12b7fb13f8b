#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod accumulated_error;
mod axisymmetric_model;
mod discretisation_error;
mod error;
mod fem_model;
mod flow_field;
mod hydrodynamics;
mod linked_bodies;
mod neglected_terms;
mod query;
mod response;
mod rough_model;
mod scaled_scene;
mod shape_space;
mod solution;
mod spheres_model;
mod superposition;
mod surface_motion;
mod units;

pub use accumulated_error::{AccumulatedError, UncorrectedBars};
pub use axisymmetric_model::{AxialFlow, AxisymmetricModel, MovingAxis};
pub use discretisation_error::{DiscretisationError, Uncertainty};
pub use error::ModelError;
pub use fem_model::{FemModel, MeshOrigin, MovingMeshes, MovingScene};
pub use flow_field::{FlowField, PointFlow, SolutionFlow};
pub use hydrodynamics::{
    Capabilities, ErrorEstimates, Flows, Fluctuations, History, Hydrodynamics, PredictedCost,
    Resistances, SceneResistance,
};
pub use neglected_terms::{FirstOrderChange, NeglectedTerm, NeglectedTerms, PathPoint};
pub use query::{BodyInertia, Configuration, Query};
pub use response::{BodySolution, HoldingLoad, MeanFlow, Response};
pub use rough_model::RoughModel;
pub use shape_space::{
    Interpolant, LocalGeometry, ShapeGeometry, ShapeSpace, SolvedShapes, TablePart, Tabulated,
    chebyshev_node,
};
pub use solution::{ErrorEstimate, InstantaneousSolution, Lookup, NewMesh, Remesh, Stresslets};
pub use spheres_model::{SphereModel, SpheresModel};
pub use stokes::{Checks, Dofs, Seconds, SolverReport};
pub use superposition::Superposed;

// Types of these crates are part of the interface.
pub use mesh;
pub use mesher;
pub use nalgebra;
pub use rigid;
pub use scene;
pub use stokes;
