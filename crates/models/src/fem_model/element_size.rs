//! Element sizes: on bodies, their growth with the distance, and in adapted meshes.

use mesh::{TET_EDGES, TetMesh};
use nalgebra::Vector3;
use scene::FemOptions;

/// Element size on the surface of a body relative to its radius, if the scene gives none.
const DEFAULT_SURFACE_SIZE: f64 = 0.4;

/// Largest growth of the element size with the distance; a larger one makes poor cells.
const MAX_GROWTH: f64 = 0.3;

/// Largest growth of the element size in coarse meshes with which others are compared: the largest
/// that the mesh generator accepts.
pub const MAX_COARSE_GROWTH: f64 = 0.6;

/// Growth of the element size in adapted meshes.
///
/// Where the flow is smooth, elements should become large within a short distance. This costs some
/// quality: a mean ratio of 0.87 instead of 0.89.
pub const ADAPTED_GROWTH: f64 = 0.4;

/// Factor on default element sizes for the coarsest mesh whose facets follow a sphere.
pub const COARSEST_FACTOR: f64 = 1.75;

/// Element size on the surface of a body with the given radius.
pub fn surface_size(options: &FemOptions, radius: f64) -> f64 {
    let factor = options.size_factor.unwrap_or(match options.target {
        None => 1.0,
        Some(_) => COARSEST_FACTOR,
    });
    factor
        * options
            .surface_size
            .unwrap_or(DEFAULT_SURFACE_SIZE * radius)
}

/// Growth of the element size with the distance, for elements of `size` radii on a body.
///
/// Around a sphere the third derivatives of the flow decrease as `r^-4`, so the error of quadratic
/// elements of size `h` is `∫ h^4 r^-8 r^2 dr`. For a given number of elements, `∫ h^-3 r^2 dr`, it
/// is smallest for `h = h_s r^(8/7)`: over one radius the size grows by 8/7 of the size on the
/// surface. A growth independent of `size` would leave an error that smaller surface elements do
/// not remove.
pub fn growth(size: f64) -> f64 {
    (8.0 / 7.0 * size).min(MAX_GROWTH)
}

/// Power of the element size with which the energy of the error of a cell decreases.
///
/// Four for the energy of quadratic elements, and three for the volume of the cell.
const QUADRATIC_ORDER: f64 = 7.0;

/// Power of the element size with which the error of a cell decreases after the correction, which
/// is that of cubic elements: six for their energy, and three for the volume of the cell.
const ORDER: f64 = 9.0;

/// Bounds on the change of sizes in one step: indicators on coarse meshes are inaccurate.
const SIZE_FACTOR_BOUNDS: [f64; 2] = [0.35, 2.0];

/// Error that sizes are chosen for, relative to the allowed error.
///
/// Generated edges are about a sixth longer than requested, which increases the error by
/// `(7 / 6)^6 = 2.5`: it will be 0.8 of the allowed error.
const TARGET: f64 = 0.32;

/// Positions and edge lengths for an adapted mesh, one per cell.
///
/// The indicators `η_c` are relative to the allowed error, so that their sum is to become one. Of
/// all meshes with the same number of cells, the one with equal indicators has the smallest error.
/// With `η_c ~ h_c^9`, the new sizes are
///
/// ```text
/// h_c (η / η_c)^(1/9),   η = (1 / sum_c η_c^(3/9))^(9/6)
/// ```
///
/// This `η` makes the sum one, because a cell is replaced by `(η_c / η)^(3/9)` cells.
pub fn adapted_sizes(mesh: &TetMesh, indicators: &[f64]) -> Vec<(Vector3<f64>, f64)> {
    let indicators = smoothed(mesh, indicators);
    let sum: f64 = indicators.iter().map(|s| s.powf(3.0 / ORDER)).sum();
    let equal = (TARGET / sum).powf(ORDER / (ORDER - 3.0));
    let [min_factor, max_factor] = SIZE_FACTOR_BOUNDS;
    mesh.cells()
        .iter()
        .zip(&indicators)
        .map(|(nodes, indicator)| {
            let at = |k: usize| mesh.points()[nodes[k] as usize];
            let centre = (at(0) + at(1) + at(2) + at(3)) / 4.0;
            let edges = TET_EDGES.iter().map(|&[i, j]| (at(i) - at(j)).norm());
            let size = edges.sum::<f64>() / 6.0;
            // Infinite for an indicator of zero, hence bounded.
            let factor = (equal / indicator).powf(1.0 / ORDER);
            (centre, size * factor.clamp(min_factor, max_factor))
        })
        .collect()
}

/// Distributes the error after the correction over the cells, from indicators of the energy of
/// quadratic elements.
///
/// The indicators are `η_c ~ h_c^7` and the remaining errors `~ h_c^9`, so the shares are
/// proportional to `η_c^(9/7)`.
pub fn distributed(error: f64, indicators: &[f64]) -> Vec<f64> {
    let powers = indicators
        .iter()
        .map(|indicator| indicator.abs().powf(ORDER / QUADRATIC_ORDER));
    let powers: Vec<f64> = powers.collect();
    let sum: f64 = powers.iter().sum();
    let factor = if sum > 0.0 { error / sum } else { 0.0 };
    powers.into_iter().map(|power| factor * power).collect()
}

/// Absolute indicators averaged over neighbours, since single cells may have small ones by chance.
fn smoothed(mesh: &TetMesh, indicators: &[f64]) -> Vec<f64> {
    let mut sums = vec![(0.0, 0u32); mesh.n_vertices()];
    for (nodes, indicator) in mesh.cells().iter().zip(indicators) {
        for &vertex in &nodes[..4] {
            let (sum, count) = &mut sums[vertex as usize];
            *sum += indicator.abs();
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
    fn equal_indicators_on_equal_cells_scale_all_sizes_by_one_factor() {
        let mesh = TetMesh::straight(LinearTets::cube(3)).unwrap();
        let cells = mesh.n_cells();
        // The error is twice the allowed one: sizes decrease by the sixth root of TARGET / 2.
        let indicators = vec![2.0 / cells as f64; cells];
        let factor = (TARGET / 2.0_f64).powf(1.0 / 6.0);
        for ((_, adapted), nodes) in adapted_sizes(&mesh, &indicators).iter().zip(mesh.cells()) {
            let at = |k: usize| mesh.points()[nodes[k] as usize];
            let size: f64 = TET_EDGES
                .iter()
                .map(|&[i, j]| (at(i) - at(j)).norm())
                .sum::<f64>()
                / 6.0;
            assert!((adapted / size - factor).abs() < 1e-12);
        }
    }

    #[test]
    fn cells_with_zero_indicators_grow_and_all_sizes_are_positive() {
        let mesh = TetMesh::straight(LinearTets::cube(2)).unwrap();
        let mut indicators = vec![0.0; mesh.n_cells()];
        indicators[0] = -1.0;
        let sizes = adapted_sizes(&mesh, &indicators);
        assert!(sizes.iter().all(|(_, h)| *h > 0.0 && h.is_finite()));
        assert!(sizes[0].1 < sizes[mesh.n_cells() - 1].1);
        let of_zero = adapted_sizes(&mesh, &vec![0.0; mesh.n_cells()]);
        assert!(of_zero.iter().all(|(_, h)| h.is_finite()));
    }
}
