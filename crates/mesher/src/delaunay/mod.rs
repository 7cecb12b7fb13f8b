//! Delaunay tetrahedralisation of a point set, with exact predicates.

mod carve;
mod hilbert;
mod linked_tets;
mod predicates;
mod tet_flips;
mod triangulation;

pub(crate) use carve::carve;
pub(crate) use hilbert::insertion_order;
pub(crate) use linked_tets::LinkedTets;
pub(crate) use predicates::{circumcentre, orientation};
pub(crate) use tet_flips::FlipRules;
pub(crate) use triangulation::delaunay;
