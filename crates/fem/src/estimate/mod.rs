//! Estimates of the discretisation error: the cubic part of the residual, and what straight facets cut off.

mod bubbles;
mod cell;
mod facet_geometry;
mod functional;
mod surplus;

pub use facet_geometry::{CurvedBoundary, FacetGeometry};
pub use functional::ErrorFunctional;
pub use surplus::{Surplus, SurplusSpace};
