//! Smoothed aggregation for a scalar matrix with a border.
//!
//! The steps are strength -> aggregates -> tentative prolongation -> smoothing, after Vanek,
//! Mandel, Brezina (Computing 56, 1996); the division into steps follows PyAMG. The near-null space
//! is the constants; border dofs are not aggregated. `filtered.rs` has the strength and the
//! smoothing for varying coefficients.

pub(crate) mod coupled;
mod filtered;

use crate::chebyshev::JacobiScaling;
use crate::csr::{Rows, check_shape, positive_diagonal};
use crate::product::build_rows;
use crate::{Bordered, Csr, LinalgError, Prolongation};

/// How smoothed aggregation finds strong connections and smooths the prolongation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Coarsening {
    /// Strong: `a_ij^2 > strength^2 a_ii a_jj`. The prolongation is smoothed by the whole matrix.
    ///
    /// For smooth coefficients and cells of moderate aspect ratio. It has the smallest coarse
    /// matrices, and suits any near-constant null space, whatever the signs of the entries (Vanek,
    /// Mandel, Brezina, Computing 56, 1996).
    Standard,
    /// Strong: `-a_ij > strength (l_i l_j)^(1/2)` with the largest coupling `l_i = max_j -a_ij`.
    ///
    /// For coefficients that jump or vary strongly, and for anisotropy; use
    /// [`MultigridParams::heterogeneous`](crate::MultigridParams::heterogeneous) or
    /// [`anisotropic`](crate::MultigridParams::anisotropic), whose strength fits. The prolongation
    /// is smoothed by a filtered matrix, with the weak connections of each row added to its
    /// diagonal. Nodes without strong connections are in no aggregate and interpolate from those of
    /// their neighbours, as the fine nodes of classical multigrid do (Ruge, Stueben 1987). Positive
    /// off-diagonal entries count as weak.
    Filtered,
}

/// Prolongation from the next coarser level, or `None` if aggregation no longer coarsens.
///
/// `diagonal` is that of `K` and `threshold` that of strong connections.
pub(crate) fn prolongation(
    fine: &Bordered,
    diagonal: &[f64],
    scaling: &JacobiScaling,
    coarsening: Coarsening,
    threshold: f64,
) -> Option<Prolongation> {
    let k = fine.stiffness();
    // nodes that are constrained in different components must not be aggregated
    let constrained = fine.constrained_dofs().bits(fine.nodes());
    let aggregates = match coarsening {
        Coarsening::Standard => {
            standard_aggregates(&strong_connections(k, diagonal, threshold), &constrained)
        }
        Coarsening::Filtered => filtered::aggregates(k, &constrained, threshold),
    };
    if !is_coarser(aggregates.count, k.rows()) {
        return None;
    }
    let tentative = tentative_prolongation(&aggregates);
    if coarsening == Coarsening::Filtered {
        let (matrix, weights) = filtered::matrix(k, &aggregates, &constrained, threshold);
        return Some(smoothed(fine, &matrix, &tentative, &constrained, |i| {
            weights[i]
        }));
    }
    let omega = scaling.prolongation_factor();
    Some(smoothed(fine, k, &tentative, &constrained, |i| {
        omega / scaling.diagonal[i]
    }))
}

/// Whether a level of `coarse` dofs is worth its cost below one of `fine` dofs.
///
/// Coarsening by less than a fifth of the dofs costs more than factorising the finer level.
fn is_coarser(coarse: usize, fine: usize) -> bool {
    coarse > 0 && 5 * coarse <= 4 * fine
}

/// The off-diagonal entries with `a_ij^2 > threshold^2 a_ii a_jj`, with their values.
fn strong_connections(k: &Csr, diagonal: &[f64], threshold: f64) -> Csr {
    let rows = Rows::new(k);
    let limit = threshold * threshold;
    build_rows(k.rows(), k.cols(), |i, row| {
        for (j, a) in rows.row(i) {
            if j != i && a * a > limit * diagonal[i] * diagonal[j] {
                row.add(j, a);
            }
        }
    })
}

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
    pub fn from_matrix(k: &Csr, class: &[u8], strength: f64) -> Result<Self, LinalgError> {
        check_shape("matrix to aggregate", k.shape(), (class.len(), class.len()))?;
        let diagonal = positive_diagonal("matrix to aggregate", k)?;
        Ok(standard_aggregates(
            &strong_connections(k, &diagonal, strength),
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
fn standard_aggregates(strong: &Csr, class: &[u8]) -> Aggregates {
    let rows = Rows::new(strong);
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

/// The tentative prolongation `T`: one if a node belongs to an aggregate.
///
/// Constants are interpolated exactly.
fn tentative_prolongation(aggregates: &Aggregates) -> Csr {
    build_rows(aggregates.of_node.len(), aggregates.count, |i, row| {
        if let Some(aggregate) = aggregates.of_node[i] {
            row.add(aggregate as usize, 1.0);
        }
    })
}

/// The smoothed prolongation `P = (I - W F) T`, with border columns `Q = -W C`.
///
/// Likewise `Q_l = -W C_l` if there is a left border. `F` is `K` or a filtered form of it, and
/// `W = weight(i)` a diagonal matrix. For `F = K` the weights are `w / d_i` with the diagonal `D`
/// of [`JacobiScaling`] and the factor `w` of [`JacobiScaling::prolongation_factor`].
///
/// The border columns result from the same Jacobi step on the tentative prolongation `[T 0; 0 I]`
/// of the bordered operator: a border dof moves the nodes around it.
///
/// A node interpolates only from aggregates that are constrained in every component in which the
/// node is constrained (bits of `constrained`). The weights of all other aggregates are added to
/// the weight of the node's own aggregate, so that constants are still interpolated exactly (a
/// filtered matrix, as for weak connections in Vanek, Mandel, Brezina 1996).
fn smoothed(
    fine: &Bordered,
    matrix: &Csr,
    tentative: &Csr,
    constrained: &[u8],
    weight: impl Fn(usize) -> f64 + Sync,
) -> Prolongation {
    let (k, t) = (Rows::new(matrix), Rows::new(tentative));
    let nodes = build_rows(fine.nodes(), tentative.cols(), |i, row| {
        for (aggregate, value) in t.row(i) {
            row.add(aggregate, value);
        }
        for (j, kij) in k.row(i) {
            let source = if constrained[i] & !constrained[j] == 0 {
                j
            } else {
                i
            };
            for (aggregate, value) in t.row(source) {
                row.add(aggregate, -weight(i) * kij * value);
            }
        }
    });
    let smoothed_border = |border: &Csr| {
        let c = Rows::new(border);
        build_rows(3 * fine.nodes(), fine.border_len(), |i, row| {
            for (col, value) in c.row(i) {
                row.add(col, -weight(i / 3) * value);
            }
        })
    };
    Prolongation::from_parts(
        nodes,
        smoothed_border(fine.border()),
        fine.border_left().map(smoothed_border),
    )
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
        let aggregates = standard_aggregates(&t.to_csr(), &[0; 10]);
        // node 0 takes 1, node 3 takes 2 and 4, node 6 takes 5 and 7, node 8 joins; node 9 is
        // isolated
        let expected = [0, 0, 1, 1, 1, 2, 2, 2, 2].map(Some);
        assert_eq!(aggregates.of_node[..n], expected);
        assert_eq!(aggregates.of_node[n], None);
        assert_eq!(aggregates.count, 3);
    }
}
