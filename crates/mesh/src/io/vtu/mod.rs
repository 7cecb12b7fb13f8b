//! VTU files (ParaView's XML unstructured grids) with quadratic cells, and PVD time series of them.

mod grid;
mod pvd;
mod xml;

pub use grid::Vtu;
pub use pvd::Pvd;
pub use xml::VtuEncoding;
