//! Greedy aggregation of strongly connected neighbourhoods.

use super::strength;
use crate::csr::{Rows, check_shape, positive_diagonal};
use crate::{Csr, LinalgError};

/// The aggregate of each node; `None` for a node without strong neighbours.
///
/// Nodes without an aggregate have no coarse correction: smoothing alone reduces their error.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Aggregates {
    /// Number of the aggregate of each node.
    pub of_node: Vec<Option<u32>>,
    /// Number of aggregates.
    pub count: usize,
}

impl Aggregates {
    /// Aggregates of the nodes of a symmetric scalar matrix.
    ///
    /// Neighbours with `a_ij^2 > strength^2 a_ii a_jj` and of the same `class` may be aggregated,
    /// see [`MultigridParams::strength`](crate::MultigridParams::strength). Deterministic; O(nnz).
    ///
    /// # Errors
    /// [`LinalgError::Shape`] unless the matrix is square with one class per row,
    /// [`LinalgError::NotPositive`] for a diagonal entry that is not positive.
    pub fn of_matrix(k: &Csr, class: &[u8], strength: f64) -> Result<Self, LinalgError> {
        check_shape("matrix to aggregate", k.shape(), (class.len(), class.len()))?;
        let diagonal = positive_diagonal("matrix to aggregate", k)?;
        Ok(standard(
            &strength::symmetric(k, &diagonal, strength),
            class,
        ))
    }
}

/// Aggregates nodes in three passes in their order (Vanek, Mandel, Brezina 1996, algorithm 2).
///
/// The first pass turns each neighbourhood without aggregated nodes into an aggregate. The second
/// pass adds remaining nodes to a neighbouring aggregate of the first pass. The third pass forms
/// aggregates of the nodes that are left. Only nodes of the same `class` are aggregated.
/// Deterministic; O(nnz).
pub(super) fn standard(strong: &Csr, class: &[u8]) -> Aggregates {
    let rows = Rows::of(strong);
    let n = strong.rows();
    let neighbours = |i: usize| {
        let all = rows.row(i).map(|(j, _)| j);
        all.filter(move |&j| class[j] == class[i])
    };
    let isolated = |i: usize| rows.indptr[i] == rows.indptr[i + 1];
    let mut of_node: Vec<Option<u32>> = vec![None; n];
    let mut count = 0u32;
    for i in 0..n {
        if isolated(i) || of_node[i].is_some() || neighbours(i).any(|j| of_node[j].is_some()) {
            continue;
        }
        of_node[i] = Some(count);
        neighbours(i).for_each(|j| of_node[j] = Some(count));
        count += 1;
    }
    let first_pass = of_node.clone();
    for i in 0..n {
        if of_node[i].is_none() {
            of_node[i] = neighbours(i).find_map(|j| first_pass[j]);
        }
    }
    for i in 0..n {
        if isolated(i) || of_node[i].is_some() {
            continue;
        }
        of_node[i] = Some(count);
        for j in neighbours(i) {
            of_node[j].get_or_insert(count);
        }
        count += 1;
    }
    Aggregates {
        of_node,
        count: count as usize,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_is_cut_into_threes() {
        let n = 9;
        let mut t = sprs::TriMatI::<f64, u32>::new((n + 1, n + 1));
        for i in 1..n {
            t.add_triplet(i, i - 1, -1.0);
            t.add_triplet(i - 1, i, -1.0);
        }
        let aggregates = standard(&t.to_csr(), &[0; 10]);
        // node 0 takes 1, node 3 takes 2 and 4, node 6 takes 5 and 7, node 8 joins; node 9 is
        // isolated
        let expected = [0, 0, 1, 1, 1, 2, 2, 2, 2].map(Some);
        assert_eq!(aggregates.of_node[..n], expected);
        assert_eq!(aggregates.of_node[n], None);
        assert_eq!(aggregates.count, 3);
    }
}
