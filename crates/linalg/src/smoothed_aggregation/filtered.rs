//! Aggregates and filtered matrix for varying coefficients and anisotropy.
//!
//! Strength is relative to the largest couplings of both nodes, not to their diagonal entries, and
//! only negative entries couple: in trilinear elements with a strong direction the entries across
//! it are positive or small, but not small compared with the diagonal.

use super::{Aggregates, standard_aggregates};
use crate::Csr;
use crate::csr::Rows;
use crate::product::build_rows;
use crate::vector::map_rows;

/// Sum of couplings over diagonal entry below which smoothing alone reduces the error of a node.
///
/// A Jacobi step then reduces it by the same ratio.
const MIN_COUPLING: f64 = 0.1;

/// Factor of the Jacobi step that smooths the prolongation.
///
/// The eigenvalues of the scaled filtered matrix are at most `upper = 2`, by Gershgorin's circles,
/// and `4 / (3 upper)` minimises the bound on the energy (Vanek, Mandel, Brezina 1996).
const SMOOTHING: f64 = 2.0 / 3.0;

/// Aggregates of nodes with `-k_ij > threshold (l_i l_j)^(1/2)`, `l_i = max_j -k_ij`.
///
/// A node without such connections stays outside if enough of its couplings lead to aggregates,
/// from which it can interpolate, or if its row is diagonally dominant. Otherwise it becomes an
/// aggregate of its own. Deterministic; O(nnz).
pub(super) fn aggregates(k: &Csr, class: &[u8], threshold: f64) -> Aggregates {
    let rows = Rows::new(k);
    let largest = largest_couplings(rows);
    let strong = build_rows(k.rows(), k.cols(), |i, row| {
        for (j, coupling) in couplings(rows, i) {
            if coupling > threshold * (largest[i] * largest[j]).sqrt() {
                row.add(j, coupling);
            }
        }
    });
    let mut aggregates = standard_aggregates(&strong, class);
    for i in 0..k.rows() {
        if aggregates.of_node[i].is_some() {
            continue;
        }
        let (mut all, mut known) = (0.0, 0.0);
        for (j, coupling) in couplings(rows, i) {
            all += coupling;
            if aggregates.of_node[j].is_some() && may_interpolate(class, i, j) {
                known += coupling;
            }
        }
        if known <= threshold * all && all >= MIN_COUPLING * rows.entry(i, i) {
            aggregates.of_node[i] = Some(aggregates.count as u32);
            aggregates.count += 1;
        }
    }
    aggregates
}

/// The filtered matrix `F` and the weights `W` of the prolongation `(I - W F) T`.
///
/// In the row of an aggregated node, couplings below `threshold` times the largest one, and
/// positive entries, are added to the diagonal: rows keep their sums, so that constants are
/// interpolated as by `K`. The row of any other node has its couplings to aggregated nodes, scaled
/// to the sum of all its couplings, and no diagonal: the node interpolates from its neighbours.
pub(super) fn matrix(
    k: &Csr,
    aggregates: &Aggregates,
    class: &[u8],
    threshold: f64,
) -> (Csr, Vec<f64>) {
    let rows = Rows::new(k);
    let largest = largest_couplings(rows);
    let aggregated = |i: usize| aggregates.of_node[i].is_some();
    let filtered = build_rows(k.rows(), k.cols(), |i, row| {
        if aggregated(i) {
            for (j, value) in rows.row(i) {
                let strong = -value >= threshold * largest[i] && may_interpolate(class, i, j);
                row.add(if strong { j } else { i }, value);
            }
            return;
        }
        let sources = || couplings(rows, i).filter(|&(j, _)| aggregated(j));
        let sources = || sources().filter(|&(j, _)| may_interpolate(class, i, j));
        let all: f64 = couplings(rows, i).map(|(_, coupling)| coupling).sum();
        let known: f64 = sources().map(|(_, coupling)| coupling).sum();
        for (j, coupling) in sources() {
            row.add(j, -coupling * (all / known));
        }
    });
    let f = Rows::new(&filtered);
    let weight = |i: usize| {
        let others: f64 = couplings(f, i).map(|(_, coupling)| coupling).sum();
        let (factor, diagonal) = if aggregated(i) {
            (SMOOTHING, f.entry(i, i))
        } else {
            (1.0, rows.entry(i, i))
        };
        // a row with a negative sum is scaled by its couplings
        let scale = diagonal.max(others);
        if scale > 0.0 { factor / scale } else { 0.0 }
    };
    let weights = map_rows(k.rows(), &weight);
    (filtered, weights)
}

/// The negative entries `-k_ij > 0` of row `i` with their columns.
fn couplings(rows: Rows<'_, f64>, i: usize) -> impl Iterator<Item = (usize, f64)> {
    rows.row(i)
        .filter(move |&(j, value)| j != i && value < 0.0)
        .map(|(j, value)| (j, -value))
}

/// The largest coupling of each row; zero if there is none.
fn largest_couplings(rows: Rows<'_, f64>) -> Vec<f64> {
    let largest = |i: usize| couplings(rows, i).fold(0.0, |m: f64, (_, c)| m.max(c));
    map_rows(rows.indptr.len() - 1, &largest)
}

/// Whether node `i` may interpolate from the aggregate of `j`, given their constrained components.
fn may_interpolate(class: &[u8], i: usize, j: usize) -> bool {
    class[i] & !class[j] == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Couplings 1, 1, 1e-4, 1e-4, 1, 1 along a chain of seven nodes: the middle one connects two
    /// aggregates.
    fn two_stiff_parts() -> Csr {
        let couplings = [1.0, 1.0, 1e-4, 1e-4, 1.0, 1.0];
        let mut t = sprs::TriMatI::<f64, u32>::new((7, 7));
        for (i, c) in couplings.into_iter().enumerate() {
            for (a, b, v) in [(i, i, c), (i + 1, i + 1, c), (i, i + 1, -c), (i + 1, i, -c)] {
                t.add_triplet(a, b, v);
            }
        }
        t.to_csr()
    }

    #[test]
    fn a_weak_node_between_stiff_parts_interpolates_from_both() {
        let k = two_stiff_parts();
        let found = aggregates(&k, &[0; 7], 0.3);
        let expected = [Some(0), Some(0), Some(0), None, Some(1), Some(1), Some(1)];
        assert_eq!((&found.of_node[..], found.count), (&expected[..], 2));
        let (f, weights) = matrix(&k, &found, &[0; 7], 0.3);
        let f = Rows::new(&f);
        // the middle node: half of either neighbour
        assert_eq!(f.row(3).collect::<Vec<_>>(), [(2, -1e-4), (4, -1e-4)]);
        assert_eq!(weights[3], 1.0 / 2e-4);
        // a stiff node forgets its weak neighbour, and its row still sums to zero
        assert_eq!(f.entry(2, 3), 0.0);
        approx::assert_abs_diff_eq!(f.entry(2, 1) + f.entry(2, 2), 0.0, epsilon = 1e-15);
    }

    #[test]
    fn a_diagonally_dominant_node_needs_no_aggregate() {
        let mut t = sprs::TriMatI::<f64, u32>::new((2, 2));
        for (a, b, v) in [(0, 0, 1.0), (1, 1, 1.0), (0, 1, 0.01), (1, 0, 0.01)] {
            t.add_triplet(a, b, v);
        }
        let found = aggregates(&t.to_csr(), &[0; 2], 0.3);
        assert_eq!((found.of_node, found.count), (vec![None, None], 0));
    }
}
