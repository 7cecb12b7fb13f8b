//! Orderings and partitions of graphs by METIS; the only file with foreign calls.
#![allow(unsafe_code)]

use std::sync::{Mutex, PoisonError};

use metis_sys::{METIS_NodeND, METIS_PartGraphKway, idx_t, rstatus_et_METIS_OK};

use super::ordering::{check_undirected, failed};
use crate::LinalgError;
use crate::csr::check_shape;

/// Lock for all calls of METIS.
///
/// METIS uses the C library's `rand`, which has one sequence per process, and seeds it at the start
/// of a call. Concurrent calls would take numbers from the same sequence, and their orderings would
/// differ from run to run.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// An elimination order of the vertices of a graph: `order[k]` is the k-th vertex to eliminate.
///
/// `adjacency` lists the neighbours of each vertex in ascending order and without the vertex;
/// `weights` are the dofs that a vertex stands for. Nested dissection by METIS; without the
/// feature `metis` approximate minimum degree by faer.
///
/// # Errors
/// [`LinalgError::Factorisation`] for a graph that is not symmetric or too large, or lack of
/// memory.
pub(crate) fn nested_dissection(
    adjacency: &[Vec<u32>],
    weights: &[u32],
) -> Result<Vec<usize>, LinalgError> {
    Graph::new(adjacency, weights)?.nested_dissection()
}

/// An undirected graph in the format of METIS.
pub(crate) struct Graph {
    starts: Vec<idx_t>,
    neighbours: Vec<idx_t>,
    weights: Vec<idx_t>,
}

impl Graph {
    /// Converts a graph.
    ///
    /// `adjacency` lists the neighbours of each vertex in ascending order and without the vertex;
    /// `weights` are the numbers of dofs that the vertices represent.
    ///
    /// # Errors
    /// [`LinalgError::Factorisation`] if the graph is not symmetric or has over 2^31 edges.
    pub fn new(adjacency: &[Vec<u32>], weights: &[u32]) -> Result<Self, LinalgError> {
        let n = adjacency.len();
        assert_eq!(weights.len(), n);
        let edges: usize = adjacency.iter().map(Vec::len).sum();
        let too_large = |_| failed("the graph is too large for the 32-bit METIS".into());
        idx_t::try_from(n.max(edges)).map_err(too_large)?;
        // METIS trusts the graph to be undirected and writes out of bounds when it is not
        check_undirected(adjacency)?;
        let mut starts: Vec<idx_t> = Vec::with_capacity(n + 1);
        starts.push(0);
        let mut neighbours: Vec<idx_t> = Vec::with_capacity(edges);
        for list in adjacency {
            neighbours.extend(list.iter().map(|&j| j as idx_t));
            starts.push(neighbours.len() as idx_t);
        }
        Ok(Graph {
            starts,
            neighbours,
            weights: weights.iter().map(|&w| w as idx_t).collect(),
        })
    }

    fn vertices(&self) -> usize {
        self.weights.len()
    }

    /// A nested-dissection elimination order: `order[k]` is the k-th vertex to eliminate.
    ///
    /// Reference: Karypis, Kumar, SIAM J. Sci. Comput. 20 (1998).
    ///
    /// # Errors
    /// [`LinalgError::Factorisation`] if METIS lacks memory.
    pub fn nested_dissection(mut self) -> Result<Vec<usize>, LinalgError> {
        let n = self.vertices();
        // METIS recurses on empty separators of a graph without edges; any order suits it
        if self.neighbours.is_empty() {
            return Ok((0..n).collect());
        }
        let mut vertices = n as idx_t;
        let mut order = vec![0 as idx_t; n];
        let mut position = vec![0 as idx_t; n];
        let turn = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: `starts` has n + 1 ascending entries, the last of which is `neighbours.len()`.
        // Every neighbour is a vertex below n, and the graph is undirected (checked by `new`).
        // `weights`, `order` and `position` have n entries. Null options select the defaults. METIS
        // keeps no pointer.
        let status = unsafe {
            METIS_NodeND(
                &mut vertices,
                self.starts.as_mut_ptr(),
                self.neighbours.as_mut_ptr(),
                self.weights.as_mut_ptr(),
                std::ptr::null_mut(),
                order.as_mut_ptr(),
                position.as_mut_ptr(),
            )
        };
        drop(turn);
        check(status)?;
        Ok(order.into_iter().map(|i| i as usize).collect())
    }

    /// The part of each vertex, below `parts`.
    ///
    /// The parts have about equal weight and few edges between them; a part may be empty.
    /// Reference: Karypis, Kumar, J. Parallel Distrib. Comput. 48 (1998).
    ///
    /// # Errors
    /// [`LinalgError::Factorisation`] if METIS lacks memory.
    pub fn partition(mut self, parts: usize) -> Result<Vec<usize>, LinalgError> {
        let n = self.vertices();
        // METIS divides by zero if there is one part, or no edge
        if parts <= 1 || n <= parts || self.neighbours.is_empty() {
            return Ok((0..n).map(|i| i % parts.max(1)).collect());
        }
        let (mut vertices, mut constraints, mut cut) = (n as idx_t, 1, 0);
        let mut parts = parts as idx_t;
        let mut part = vec![0 as idx_t; n];
        let turn = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: the graph is as in `nested_dissection`. There is one weight per vertex, hence one
        // balance constraint. Null sizes, edge weights, targets, tolerances and options select the
        // defaults. `part` has n entries. METIS keeps no pointer.
        let status = unsafe {
            METIS_PartGraphKway(
                &mut vertices,
                &mut constraints,
                self.starts.as_mut_ptr(),
                self.neighbours.as_mut_ptr(),
                self.weights.as_mut_ptr(),
                std::ptr::null_mut(),
                std::ptr::null_mut(),
                &mut parts,
                std::ptr::null_mut(),
                std::ptr::null_mut(),
                std::ptr::null_mut(),
                &mut cut,
                part.as_mut_ptr(),
            )
        };
        drop(turn);
        check(status)?;
        Ok(part.into_iter().map(|p| p as usize).collect())
    }
}

/// Divides the vertices of a graph into parts of about equal weight with few edges between them.
///
/// The result is the part of each vertex, below `parts`; a part may be empty. `adjacency` lists the
/// neighbours of each vertex in ascending order and without the vertex. By METIS, the same on
/// every call: Karypis, Kumar, J. Parallel Distrib. Comput. 48 (1998).
///
/// # Errors
/// [`LinalgError::Shape`] unless there is one weight per vertex, [`LinalgError::Parameter`] for a
/// number of parts of zero or above 2^30, [`LinalgError::Factorisation`] for a graph that is not
/// symmetric or too large, or lack of memory.
pub fn partition(
    adjacency: &[Vec<u32>],
    weights: &[u32],
    parts: usize,
) -> Result<Vec<usize>, LinalgError> {
    let shape = |n| (n, 1);
    check_shape(
        "weights of a graph",
        shape(weights.len()),
        shape(adjacency.len()),
    )?;
    if !(1..=1 << 30).contains(&parts) {
        return Err(LinalgError::Parameter {
            name: "parts",
            value: parts as f64,
            range: "from 1 to 2^30",
        });
    }
    Graph::new(adjacency, weights)?.partition(parts)
}

fn check(status: i32) -> Result<(), LinalgError> {
    if status == rstatus_et_METIS_OK {
        return Ok(());
    }
    Err(failed(format!("METIS returned status {status}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nested_dissection(
        adjacency: &[Vec<u32>],
        weights: &[u32],
    ) -> Result<Vec<usize>, LinalgError> {
        Graph::new(adjacency, weights)?.nested_dissection()
    }

    fn path(n: u32) -> Vec<Vec<u32>> {
        let neighbours = |i: u32| [i.wrapping_sub(1), i + 1].into_iter().filter(|&j| j < n);
        (0..n).map(|i| neighbours(i).collect()).collect()
    }

    /// A path of 200 vertices has a separator of one vertex, which is eliminated last.
    #[test]
    fn the_last_vertex_separates_a_path() {
        let n = 200u32;
        let adjacency = path(n);
        let order = nested_dissection(&adjacency, &vec![1; n as usize]).expect("an order");
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..n as usize).collect::<Vec<_>>());
        let last = order[n as usize - 1];
        assert!((60..140).contains(&last), "{last}");
    }

    #[test]
    fn bug_orderings_differed_when_two_threads_called_metis() {
        // a triangulated grid has many ties, which METIS breaks at random
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

    /// Parts of a path are intervals: one edge is cut between neighbouring parts.
    #[test]
    fn a_path_is_cut_into_balanced_intervals() {
        let (n, parts) = (400, 4);
        let graph = Graph::new(&path(n), &vec![1; n as usize]).expect("a graph");
        let part = graph.partition(parts).expect("a partition");
        assert!(part.windows(2).filter(|p| p[0] != p[1]).count() <= 2 * parts);
        for i in 0..parts {
            let size = part.iter().filter(|&&p| p == i).count();
            // METIS allows 3 % by default
            assert!((97..=103).contains(&size), "{size}");
        }
    }

    #[test]
    fn more_parts_than_vertices_leave_some_empty() {
        for parts in [1, 5] {
            let graph = Graph::new(&path(3), &[1; 3]).expect("a graph");
            let part = graph.partition(parts).expect("a partition");
            assert!(part.iter().all(|&p| p < parts));
        }
    }

    #[test]
    fn an_edgeless_graph_is_no_error() {
        assert_eq!(
            nested_dissection(&[vec![], vec![]], &[1, 1]).expect("an order"),
            [0, 1]
        );
    }
}
