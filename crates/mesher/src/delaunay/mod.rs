//! Delaunay tetrahedralisation of a point set, with exact predicates.

mod carve;
mod circumcentre;
mod flips;
mod hilbert;
mod linked_tets;
mod predicates;
mod triangulation;

pub(crate) use carve::carve;
pub(crate) use circumcentre::circumcentre;
pub(crate) use flips::FlipRules;
pub(crate) use hilbert::insertion_order;
pub(crate) use linked_tets::LinkedTets;
pub(crate) use predicates::orientation;
pub(crate) use triangulation::delaunay;
