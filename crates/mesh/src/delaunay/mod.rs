//! Delaunay tetrahedralisation of a point set, with exact predicates.

mod hilbert;
mod predicates;
mod triangulation;

pub(crate) use hilbert::insertion_order;
pub(crate) use triangulation::delaunay;
