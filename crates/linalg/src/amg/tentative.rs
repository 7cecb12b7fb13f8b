//! Piecewise constant interpolation from aggregates.

use super::aggregate::Aggregates;
use crate::Csr;
use crate::product::build_rows;

/// The tentative prolongation `T`: one if a node belongs to an aggregate.
///
/// Constants are interpolated exactly.
pub(super) fn constant(aggregates: &Aggregates) -> Csr {
    build_rows(aggregates.of_node.len(), aggregates.count, |i, row| {
        if let Some(aggregate) = aggregates.of_node[i] {
            row.add(aggregate as usize, 1.0);
        }
    })
}
