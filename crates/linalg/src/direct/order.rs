//! Fill-reducing orderings by METIS, the one file with foreign calls.
#![allow(unsafe_code)]

use metis_sys::{METIS_NodeND, idx_t, rstatus_et_METIS_OK};

use crate::LinalgError;

/// A nested-dissection elimination order of an undirected graph: `order[k]` is the k-th vertex to eliminate.
///
/// `adjacency` holds the neighbours of each vertex, symmetric, without the vertex itself; `weights` the unknowns
/// a vertex stands for. Reference: Karypis, Kumar, SIAM J. Sci. Comput. 20 (1998).
///
/// # Errors
/// [`LinalgError::Factorisation`] when the graph has over 2^31 edges or METIS lacks memory.
pub(crate) fn nested_dissection(
    adjacency: &[Vec<u32>],
    weights: &[u32],
) -> Result<Vec<usize>, LinalgError> {
    let n = adjacency.len();
    let edges: usize = adjacency.iter().map(Vec::len).sum();
    let too_large = |_| failed("the graph is too large for the 32-bit METIS".into());
    let mut vertices = idx_t::try_from(n).map_err(too_large)?;
    idx_t::try_from(edges).map_err(too_large)?;
    // METIS recurses on empty separators of an edgeless graph; any order will do there
    if edges == 0 {
        return Ok((0..n).collect());
    }
    let mut starts: Vec<idx_t> = Vec::with_capacity(n + 1);
    starts.push(0);
    let mut neighbours: Vec<idx_t> = Vec::with_capacity(edges);
    for list in adjacency {
        neighbours.extend(list.iter().map(|&j| j as idx_t));
        starts.push(neighbours.len() as idx_t);
    }
    let mut weights: Vec<idx_t> = weights.iter().map(|&w| w as idx_t).collect();
    let mut order = vec![0 as idx_t; n];
    let mut position = vec![0 as idx_t; n];
    assert_eq!(weights.len(), n);
    // SAFETY: `starts` has n + 1 rising entries ending at `neighbours.len()`, every neighbour is a vertex below n,
    // `weights`, `order` and `position` have n entries; null options mean the defaults. METIS keeps no pointer.
    let status = unsafe {
        METIS_NodeND(
            &mut vertices,
            starts.as_mut_ptr(),
            neighbours.as_mut_ptr(),
            weights.as_mut_ptr(),
            std::ptr::null_mut(),
            order.as_mut_ptr(),
            position.as_mut_ptr(),
        )
    };
    if status != rstatus_et_METIS_OK {
        return Err(failed(format!("METIS returned status {status}")));
    }
    Ok(order.into_iter().map(|i| i as usize).collect())
}

fn failed(detail: String) -> LinalgError {
    LinalgError::Factorisation {
        what: "ordering of the unknowns",
        detail,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A separator of a path of 200 vertices is one vertex: it is eliminated last.
    #[test]
    fn the_last_vertex_separates_a_path() {
        let n = 200u32;
        let adjacency: Vec<Vec<u32>> = (0..n)
            .map(|i| {
                [i.wrapping_sub(1), i + 1]
                    .into_iter()
                    .filter(|&j| j < n)
                    .collect()
            })
            .collect();
        let order = nested_dissection(&adjacency, &vec![1; n as usize]).expect("an order");
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..n as usize).collect::<Vec<_>>());
        let last = order[n as usize - 1];
        assert!((60..140).contains(&last), "{last}");
    }

    #[test]
    fn an_edgeless_graph_is_no_error() {
        assert_eq!(
            nested_dissection(&[vec![], vec![]], &[1, 1]).expect("an order"),
            [0, 1]
        );
    }
}
