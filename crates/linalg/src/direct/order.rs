//! Fill-reducing orderings by METIS, the one file with foreign calls.
#![allow(unsafe_code)]

use std::sync::{Mutex, PoisonError};

use metis_sys::{METIS_NodeND, idx_t, rstatus_et_METIS_OK};

use crate::LinalgError;

/// METIS draws from the C library's `rand`, one sequence for the whole process, and seeds it at the start of a call: two
/// calls at once get each other's numbers, and other orderings each time.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// A nested-dissection elimination order of an undirected graph: `order[k]` is the k-th vertex to eliminate.
///
/// `adjacency` holds the neighbours of each vertex, rising and without the vertex itself; `weights` the unknowns
/// a vertex stands for. Reference: Karypis, Kumar, SIAM J. Sci. Comput. 20 (1998).
///
/// # Errors
/// [`LinalgError::Factorisation`] when the graph is not symmetric, has over 2^31 edges, or METIS lacks memory.
pub(crate) fn nested_dissection(
    adjacency: &[Vec<u32>],
    weights: &[u32],
) -> Result<Vec<usize>, LinalgError> {
    let n = adjacency.len();
    let edges: usize = adjacency.iter().map(Vec::len).sum();
    let too_large = |_| failed("the graph is too large for the 32-bit METIS".into());
    let mut vertices = idx_t::try_from(n).map_err(too_large)?;
    idx_t::try_from(edges).map_err(too_large)?;
    // METIS trusts the graph to be undirected and writes out of bounds when it is not
    for (i, list) in adjacency.iter().enumerate() {
        let one_way = |&&j: &&u32| adjacency[j as usize].binary_search(&(i as u32)).is_err();
        if let Some(j) = list.iter().find(one_way) {
            return Err(failed(format!(
                "the pattern of the matrix has entry ({i}, {j}) but not ({j}, {i}); it must be symmetric"
            )));
        }
    }
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
    let turn = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    // SAFETY: `starts` has n + 1 rising entries ending at `neighbours.len()`, every neighbour is a vertex below n and lists
    // its neighbour in turn (checked above),
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
    drop(turn);
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
    fn bug_orderings_differed_when_two_threads_called_metis() {
        // a triangulated grid: ties everywhere, which METIS breaks by chance
        let side = 60i64;
        let neighbours = |v: i64| {
            let (x, y) = (v % side, v / side);
            [(-1, -1), (0, -1), (-1, 0), (1, 0), (0, 1), (1, 1)]
                .map(|(dx, dy)| (x + dx, y + dy))
                .into_iter()
                .filter(|&(x, y)| (0..side).contains(&x) && (0..side).contains(&y))
                .map(|(x, y)| (y * side + x) as u32)
                .collect::<Vec<u32>>()
        };
        let graph: Vec<Vec<u32>> = (0..side * side).map(neighbours).collect();
        let weights = vec![1; graph.len()];
        let order = || nested_dissection(&graph, &weights).expect("an order");
        let alone = order();
        std::thread::scope(|scope| {
            let threads: Vec<_> = (0..4)
                .map(|_| scope.spawn(|| (0..8).all(|_| order() == alone)))
                .collect();
            for thread in threads {
                assert!(thread.join().expect("no panic"));
            }
        });
    }

    #[test]
    fn a_one_way_edge_is_refused_before_metis_sees_it() {
        let error = nested_dissection(&[vec![1], vec![]], &[1, 1]).expect_err("one way");
        assert!(matches!(error, LinalgError::Factorisation { .. }));
    }

    #[test]
    fn an_edgeless_graph_is_no_error() {
        assert_eq!(
            nested_dissection(&[vec![], vec![]], &[1, 1]).expect("an order"),
            [0, 1]
        );
    }
}
