//! Elimination orders with little fill.

#[cfg(not(feature = "metis"))]
use super::undirected::{check_undirected, failed};
use crate::LinalgError;

/// An elimination order of the vertices of a graph: `order[k]` is the k-th vertex to eliminate.
///
/// `adjacency` lists the neighbours of each vertex in ascending order and without the vertex;
/// `weights` are the dofs that a vertex stands for. Nested dissection by METIS with the feature
/// `metis`, else approximate minimum degree by faer, which ignores the weights.
///
/// # Errors
/// [`LinalgError::Factorisation`] for a graph that is not symmetric or too large, or lack of
/// memory.
#[cfg(feature = "metis")]
pub(crate) fn nested_dissection(
    adjacency: &[Vec<u32>],
    weights: &[u32],
) -> Result<Vec<usize>, LinalgError> {
    super::Graph::new(adjacency, weights)?.nested_dissection()
}

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
