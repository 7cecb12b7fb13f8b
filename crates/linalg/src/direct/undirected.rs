//! Checks of the graph of a symmetric matrix.

use crate::LinalgError;

/// Refuses a graph with an edge in one direction only.
///
/// # Errors
/// [`LinalgError::Factorisation`] naming the edge.
pub(super) fn check_undirected(adjacency: &[Vec<u32>]) -> Result<(), LinalgError> {
    for (i, list) in adjacency.iter().enumerate() {
        let one_way = |&&j: &&u32| {
            let back = adjacency.get(j as usize);
            back.is_none_or(|list| list.binary_search(&(i as u32)).is_err())
        };
        if let Some(j) = list.iter().find(one_way) {
            return Err(failed(format!(
                "the pattern of the matrix has entry ({i}, {j}) but not ({j}, {i}); \
                 it must be symmetric"
            )));
        }
    }
    Ok(())
}

pub(super) fn failed(detail: String) -> LinalgError {
    LinalgError::Factorisation {
        what: "graph of the dofs",
        detail,
    }
}
