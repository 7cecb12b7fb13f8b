//! Permeability of slender fluid domains.

use fem::StokesMatrices;
use linalg::{CsrOperator, KrylovParams, OMITTED, ScalarMultigrid, cg, submatrix};
use mesh::TetMesh;
use nalgebra::{Matrix3, Vector3};
use rigid::NodeRole;

use crate::StokesError;

/// Residual of the torsion function: a permeability with an error of a few per cent will do.
const TORSION_RTOL: f64 = 1e-2;

/// Rayleigh quotient below which a domain is slender. The mass matrix then approximates the Schur
/// complement poorly for smooth pressures, and a Laplacian with the permeability is added.
const MAX_SLENDER_QUOTIENT: f64 = 0.3;

/// Twice the permeability of the fluid at each cell, or `None` if the domain is not slender.
///
/// The torsion function `psi`, given at the vertices, solves `-Δ psi = 1` with `psi = 0` at walls
/// and bodies. In a channel of any cross-section, a unit pressure gradient drives the velocity
/// `psi` at viscosity 1, so that its mean is the permeability: `h^2 / 12` between walls at the
/// distance h. The result is `2 psi + h^2 / 12`, with linear elements for `psi`, and with the
/// smallest height `h` of the cell for what linear elements miss.
///
/// A domain is slender if, with this result `k`, the Rayleigh quotient `∫ k |∇q|^2 / ∫ q^2` of some
/// linear function `q` with zero mean is below [`MAX_SLENDER_QUOTIENT`]: an upper bound of the
/// smallest eigenvalue of the pressure's Schur complement against the mass matrix. Measured: 0.60
/// in a ball,
/// 0.38 in a cube, 0.006 in a box of 10 x 1 x 1.
pub fn permeability_of_channels(mesh: &TetMesh, torsion: &[f64]) -> Option<Vec<f64>> {
    let permeability: Vec<f64> = (0..mesh.n_cells())
        .map(|cell| {
            let vertices = &mesh.cells()[cell][..4];
            let sum: f64 = vertices.iter().map(|&v| torsion[v as usize]).sum();
            let height = smallest_height(mesh, cell);
            2.0 * (sum / 4.0) + height * height / 12.0
        })
        .collect();
    let is_slender = slenderness(mesh, &permeability) < MAX_SLENDER_QUOTIENT;
    is_slender.then_some(permeability)
}

/// The torsion function at the vertices, or `None` without walls and bodies.
///
/// # Errors
/// A solve that does not converge.
pub fn torsion(
    vertices: usize,
    roles: &[NodeRole],
    matrices: &StokesMatrices,
) -> Result<Option<Vec<f64>>, StokesError> {
    let is_free = |v: &u32| roles[*v as usize] == NodeRole::Free;
    let free: Vec<u32> = (0..vertices as u32).filter(is_free).collect();
    let mut torsion = vec![0.0; vertices];
    if free.len() == vertices {
        return Ok(None);
    }
    if free.is_empty() {
        return Ok(Some(torsion));
    }
    let mut numbers = vec![OMITTED; vertices];
    for (number, &vertex) in free.iter().enumerate() {
        numbers[vertex as usize] = number as u32;
    }
    let stiffness = CsrOperator::new(submatrix(
        &matrices.vertex_stiffness,
        &free,
        &numbers,
        free.len(),
    )?)?;
    let mut multigrid = ScalarMultigrid::new(&stiffness, &Default::default())?;
    let load: Vec<f64> = free
        .iter()
        .map(|&v| {
            matrices
                .pressure_mass
                .outer_view(v as usize)
                .map_or(0.0, |row| row.data().iter().sum())
        })
        .collect();
    let mut inner = vec![0.0; free.len()];
    let parameters = KrylovParams::default().with_rel_tol(TORSION_RTOL);
    cg(&stiffness, &mut multigrid, &load, &mut inner, &parameters)?;
    for (&vertex, value) in free.iter().zip(inner) {
        torsion[vertex as usize] = value.max(0.0);
    }
    Ok(Some(torsion))
}

/// Smallest distance of a vertex of the cell from the face opposite to it.
fn smallest_height(mesh: &TetMesh, cell: usize) -> f64 {
    let x = mesh.cell_vertices(cell);
    let face = |a: usize, b: usize, c: usize| (x[b] - x[a]).cross(&(x[c] - x[a])).norm();
    let largest = face(1, 2, 3)
        .max(face(0, 2, 3))
        .max(face(0, 1, 3))
        .max(face(0, 1, 2));
    (x[1] - x[0])
        .cross(&(x[2] - x[0]))
        .dot(&(x[3] - x[0]))
        .abs()
        / largest
}

/// The smallest Rayleigh quotient `∫ k |∇q|^2 / ∫ q^2` of the linear functions with zero mean.
///
/// Positions enter by the centroids of the cells.
fn slenderness(mesh: &TetMesh, permeability: &[f64]) -> f64 {
    let (mut volume, mut flux, mut first) = (0.0, 0.0, Vector3::zeros());
    let mut second = Matrix3::zeros();
    for (cell, k) in permeability.iter().enumerate() {
        let x: Vector3<f64> = mesh.cell_vertices(cell).iter().sum::<Vector3<f64>>() / 4.0;
        let v = mesh.cell_volume(cell);
        volume += v;
        flux += v * k;
        first += v * x;
        second += v * x * x.transpose();
    }
    let covariance = second - first * first.transpose() / volume;
    flux / covariance.symmetric_eigenvalues().max()
}
