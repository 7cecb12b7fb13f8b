//! Graphs of symmetric matrices, and elimination orders by faer where METIS is missing.

use crate::LinalgError;

/// An elimination order of the vertices of a graph: `order[k]` is the k-th vertex to eliminate.
///
/// `adjacency` lists the neighbours of each vertex in ascending order and without the vertex;
/// `weights` are the dofs that a vertex stands for. Approximate minimum degree by faer, which
/// ignores the weights; with the feature `metis` nested dissection by METIS.
///
/// # Errors
/// [`LinalgError::Factorisation`] for a graph that is not symmetric or too large, or lack of
/// memory.
#[cfg(not(feature = "metis"))]
pub(crate) fn nested_dissection(
    adjacency: &[Vec<u32>],
    _weights: &[u32],
) -> Result<Vec<usize>, LinalgError> {
    use faer::dyn_stack::{MemBuffer, MemStack};
    use faer::sparse::SymbolicSparseColMatRef;
    use faer::sparse::linalg::amd;

    check_undirected(adjacency)?;
    let n = adjacency.len();
    let mut starts = vec![0];
    let mut neighbours = Vec::new();
    for list in adjacency {
        neighbours.extend(list.iter().map(|&j| j as usize));
        starts.push(neighbours.len());
    }
    let pattern = SymbolicSparseColMatRef::new_checked(n, n, &starts, None, &neighbours);
    let (mut order, mut inverse) = (vec![0; n], vec![0; n]);
    let need = amd::order_scratch::<usize>(n, neighbours.len());
    let mut memory = MemBuffer::try_new(need).map_err(|_| failed("out of memory".into()))?;
    let stack = MemStack::new(&mut memory);
    amd::order(&mut order, &mut inverse, pattern, Default::default(), stack)
        .map_err(|e| failed(e.to_string()))?;
    Ok(order)
}

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
