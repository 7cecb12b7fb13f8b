//! Where elements should be smaller: sizes from the cells' shares in an estimated error.

use mesh::{TET_EDGES, TetMesh};
use nalgebra::Vector3;

/// A cell's share in an error falls with this power of its size: the energy of quadratic elements with the fourth, the cell's
/// volume with the third.
const ORDER: f64 = 7.0;

/// The sizes of one round are trusted so far: shares on coarse meshes tell little of fine ones.
const LEAST_FACTOR: f64 = 0.35;
const LARGEST_FACTOR: f64 = 2.0;

/// Part of the allowed error that is aimed at. Generated edges are about a sixth longer than asked for, and the error 1.8 times what is
/// aimed at once sizes no longer change (spheres in a ball, targets of 1e-3 and 1e-4); so rounds end at 0.8 of the target.
const AIM: f64 = 0.45;

/// Wanted edge lengths at the centres of cells, so that the shares, which add up to the error over what is allowed, add up to one.
///
/// Of all meshes with so many cells the one with equal shares has the least error. With shares $\eta_c \propto h_c^7$ the sizes become
/// $h_c (\eta / \eta_c)^{1/7}$, and $\eta = (1 / \sum_c \eta_c^{3/7})^{7/4}$ makes the sum one, for a cell gives way to $(\eta_c / \eta)^{3/7}$ others.
pub fn wanted_sizes(mesh: &TetMesh, shares: &[f64]) -> Vec<(Vector3<f64>, f64)> {
    let shares = smoothed(mesh, shares);
    let sum: f64 = shares.iter().map(|s| s.powf(3.0 / ORDER)).sum();
    let equal = (AIM / sum).powf(ORDER / 4.0);
    mesh.cells()
        .iter()
        .zip(&shares)
        .map(|(nodes, share)| {
            let at = |k: usize| mesh.points()[nodes[k] as usize];
            let centre = (at(0) + at(1) + at(2) + at(3)) / 4.0;
            let edges = TET_EDGES.iter().map(|&[i, j]| (at(i) - at(j)).norm());
            let size = edges.sum::<f64>() / 6.0;
            let factor = (equal / share).powf(1.0 / ORDER);
            // a share of zero asks for nothing
            (centre, size * factor.clamp(LEAST_FACTOR, LARGEST_FACTOR))
        })
        .collect()
}

/// Absolute shares averaged over neighbours: single cells have small shares by accident.
fn smoothed(mesh: &TetMesh, shares: &[f64]) -> Vec<f64> {
    let mut sums = vec![(0.0, 0u32); mesh.n_vertices()];
    for (nodes, share) in mesh.cells().iter().zip(shares) {
        for &vertex in &nodes[..4] {
            let (sum, count) = &mut sums[vertex as usize];
            *sum += share.abs();
            *count += 1;
        }
    }
    mesh.cells()
        .iter()
        .map(|nodes| {
            let means = nodes[..4].iter().map(|&vertex| {
                let (sum, count) = sums[vertex as usize];
                sum / f64::from(count)
            });
            means.sum::<f64>() / 4.0
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh::LinearTets;

    #[test]
    fn equal_shares_on_equal_cells_scale_all_sizes_alike() {
        let mesh = TetMesh::straight(LinearTets::cube(3)).unwrap();
        let cells = mesh.n_cells();
        // The error is twice what is allowed, and part of that is aimed at: sizes fall by the fourth root.
        let shares = vec![2.0 / cells as f64; cells];
        let factor = (AIM / 2.0_f64).powf(0.25);
        for ((_, wanted), nodes) in wanted_sizes(&mesh, &shares).iter().zip(mesh.cells()) {
            let at = |k: usize| mesh.points()[nodes[k] as usize];
            let size: f64 = TET_EDGES
                .iter()
                .map(|&[i, j]| (at(i) - at(j)).norm())
                .sum::<f64>()
                / 6.0;
            assert!((wanted / size - factor).abs() < 1e-12);
        }
    }

    #[test]
    fn cells_without_a_share_grow_and_all_sizes_are_positive() {
        let mesh = TetMesh::straight(LinearTets::cube(2)).unwrap();
        let mut shares = vec![0.0; mesh.n_cells()];
        shares[0] = -1.0;
        let sizes = wanted_sizes(&mesh, &shares);
        assert!(sizes.iter().all(|(_, h)| *h > 0.0 && h.is_finite()));
        assert!(sizes[0].1 < sizes[mesh.n_cells() - 1].1);
        let nothing = wanted_sizes(&mesh, &vec![0.0; mesh.n_cells()]);
        assert!(nothing.iter().all(|(_, h)| h.is_finite()));
    }
}
