#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod assemble;
mod dirichlet;
mod error;
mod estimate;
mod forms;
mod geometry;
mod integrals;
mod load;
mod nodal_field;
mod norms;
mod pattern;
mod point_values;
mod quadrature;
mod quantity;
mod residual;
mod space;
mod sum;
mod surface;
mod surface_velocity;
mod taylor_hood;
mod weak_form;

pub use dirichlet::DirichletCondition;
pub use error::FemError;
pub use estimate::{
    BoundaryBubbles, BoundaryFlow, CubicExtension, CubicFlow, CubicProduct, CurvedBoundary,
    FacetFunctional, FacetGeometry, OverProcesses, Surplus, SurplusPart, SurplusSpace,
    VaryingViscosity, ViscosityOfRate,
};
pub use forms::StokesMatrices;
pub use integrals::{assemble_facet_load, assemble_load, integrate, integrate_facets, load_vector};
pub use load::{LoadOnFluid, consistent_load, stress_load};
pub use nodal_field::{evaluate, interpolate, vertex_gradients};
pub use norms::{FieldError, dissipation, field_error, mean_pressure, power, pressure_error};
pub use point_values::{Basis, FacetValues, Lagrange, PointValues, Space};
pub use quantity::{Nodal, Quantity};
pub use residual::{continuity_residual, momentum_residual};
pub use space::TaylorHood;
pub use surface::{SurfaceMeasures, surface_measures};
pub use surface_velocity::{NodalSurfaceVelocity, SurfaceVelocity, nodal_surface_velocity};
pub use weak_form::interleaved;

// Types of these crates are part of the interface.
pub use linalg;
pub use mesh;
pub use nalgebra;
pub use sprs;
