//! Error estimates: hierarchical surplus of the discretisation, geometry error of straight facets.

mod boundary_bubbles;
mod bubbles;
mod cell;
mod cubic;
mod cubic_cell;
mod cubic_power;
mod cubic_tables;
mod facet_geometry;
mod facet_power;
mod surplus;
mod surplus_part;

pub use boundary_bubbles::BoundaryBubbles;
pub use cubic::{CubicExtension, CubicProduct};
pub use cubic_power::CubicFlow;
pub use facet_geometry::{BoundaryFlow, CurvedBoundary, FacetFunctional, FacetGeometry};
pub use surplus::{Surplus, SurplusSpace};
pub use surplus_part::{OverProcesses, SurplusPart};
