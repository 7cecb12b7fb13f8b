#![forbid(unsafe_code)]
//! Taylor-Hood (P2-P1) finite elements on curved tetrahedra: assembly, functionals, norms.

mod assemble;
mod error;
mod forms;
mod geometry;
mod load;
mod norms;
mod pattern;
mod quadrature;
mod reference;
mod space;
mod sum;
mod surface;
mod validate;

pub use error::FemError;
pub use load::{Load, consistent_load, momentum_residual, stress_load};
pub use norms::{VelocityError, dissipation, mean_pressure, pressure_error, velocity_error};
pub use space::TaylorHood;
pub use surface::{SurfaceMeasures, surface_measures};
