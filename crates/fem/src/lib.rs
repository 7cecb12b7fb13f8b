#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod assemble;
mod dirichlet;
mod error;
mod estimate;
mod forms;
mod geometry;
mod load;
mod norms;
mod pattern;
mod quadrature;
mod residual;
mod space;
mod sum;
mod surface;
mod surface_velocity;
mod taylor_hood;

pub use dirichlet::DirichletCondition;
pub use error::FemError;
pub use estimate::{
    BoundaryBubbles, BoundaryFlow, CubicExtension, CubicFlow, CubicProduct, CurvedBoundary,
    FacetFunctional, FacetGeometry, OverProcesses, Surplus, SurplusPart, SurplusSpace,
};
pub use forms::{StokesMatrices, load_vector};
pub use load::{LoadOnFluid, consistent_load, stress_load};
pub use norms::{VelocityError, dissipation, mean_pressure, power, pressure_error, velocity_error};
pub use residual::{continuity_residual, momentum_residual};
pub use space::TaylorHood;
pub use surface::{SurfaceMeasures, surface_measures};
pub use surface_velocity::{NodalSurfaceVelocity, SurfaceVelocity, nodal_surface_velocity};

// Types of these crates are part of the interface.
pub use linalg;
pub use mesh;
pub use nalgebra;
pub use sprs;
