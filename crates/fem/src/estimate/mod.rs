//! Error estimates: hierarchical surplus of the discretisation, geometry error of straight facets.

mod boundary_bubbles;
mod bubbles;
mod cell;
mod cubic;
mod cubic_cell;
mod cubic_tables;
mod facet_geometry;
mod surplus;
mod surplus_part;
mod varying_viscosity;

pub use boundary_bubbles::BoundaryBubbles;
pub use cubic::{CubicExtension, CubicFlow, CubicProduct};
pub use facet_geometry::{BoundaryFlow, CurvedBoundary, FacetFunctional, FacetGeometry};
pub use surplus::{Surplus, SurplusSpace};
pub use surplus_part::{OverProcesses, SurplusPart};
pub use varying_viscosity::{VaryingViscosity, ViscosityOfRate};
