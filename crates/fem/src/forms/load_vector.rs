//! Load vector of a body force, `f_i = ∫ f N_i`.

use mesh::{TetMesh, Vec3};

use crate::error::{FemError, check_vectors};
use crate::geometry::MapAt;
use crate::norms::position;
use crate::quadrature::degree_6;
use crate::sum::accumulate_cells;

/// Load vector `f_i = ∫ f N_i` of a body force on the quadratic elements.
///
/// `force` returns the force per volume at a position. Quadrature: 24 points per cell, degree 6, so
/// a force of degree 4 is integrated exactly on affine cells. Shape of the result: `n_points`.
/// Bitwise the same for any number of threads.
///
/// # Errors
/// A force that is not finite; [`FemError::InvertedCell`].
pub fn load_vector(
    mesh: &TetMesh,
    force: impl Fn(Vec3) -> Vec3 + Sync,
) -> Result<Vec<Vec3>, FemError> {
    let cell_load = |cell: usize| {
        let positions = mesh.cell_points(cell);
        let mut load = [Vec3::zeros(); 10];
        for point in degree_6() {
            let measure = MapAt::new(cell, &positions, point)?.measure;
            let weighted = measure * force(position(&positions, point));
            for (value, shape) in load.iter_mut().zip(point.shape) {
                *value += shape * weighted;
            }
        }
        Ok(load)
    };
    let mut loads = vec![Vec3::zeros(); mesh.n_points()];
    accumulate_cells(mesh, cell_load, |cell, load| {
        for (&node, value) in mesh.cells()[cell].iter().zip(&load) {
            loads[node as usize] += value;
        }
    })?;
    check_vectors("the load vector", &loads, mesh.n_points())?;
    Ok(loads)
}
