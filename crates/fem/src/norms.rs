//! Integrals over the fluid: dissipation, mean pressure, errors against an exact flow.

use mesh::{TetMesh, Vec3};
use nalgebra::Matrix3;

use crate::error::{FemError, check_array, check_vectors};
use crate::geometry::{CellNodes, MapAt};
use crate::load::velocity_gradient;
use crate::quadrature::{CellPoint, degree_2, degree_5, degree_6};
use crate::sum::sum_over;

/// Rate of dissipation `∫ 2 D(u):D(u)` at viscosity 1, with the symmetric gradient `D`.
///
/// The quadrature is that of the viscous matrix `V` of
/// [`TaylorHood::viscous_block`](crate::TaylorHood::viscous_block), so the result equals `u^T V u`
/// to rounding. Shapes: `velocity` `n_points`.
///
/// # Errors
/// A velocity of the wrong length or not finite; [`FemError::InvertedCell`].
pub fn dissipation(mesh: &TetMesh, velocity: &[Vec3]) -> Result<f64, FemError> {
    check_vectors("the velocity", velocity, mesh.n_points())?;
    let [dissipation] = sum_over(mesh.cells().len(), |cell| {
        let nodes = mesh.cell_points(cell);
        let rule = if mesh.is_affine(cell) {
            degree_2()
        } else {
            degree_5()
        };
        let mut sum = 0.0;
        for point in rule {
            let map = MapAt::new(cell, &nodes, point)?;
            let gradient = velocity_gradient(&mesh.cells()[cell], velocity, &map.gradients(point));
            // 2 D:D = (G + G^T):(G + G^T) / 2 for the velocity gradient G.
            sum += 0.5 * map.measure * (gradient + gradient.transpose()).norm_squared();
        }
        Ok([sum])
    })?;
    check_array("the dissipation", &[dissipation], 1)?;
    Ok(dissipation)
}

/// Power of the forces of a flow in the motion `test` of the boundary, at viscosity 1.
///
/// ```text
/// P = ∫ 2 D(u):D(v) - ∫ p ∇·v
/// ```
///
/// For a solution `u` without body force this is `∮ v · f dS` with the forces `f` of the boundary
/// on the fluid, and depends on `v` on the boundary only; its error is of the order of that of the
/// consistent forces. Shapes: `velocity` and `test` `n_points`, `pressure` `n_vertices`.
///
/// # Errors
/// Arrays of the wrong length or not finite; [`FemError::InvertedCell`].
pub fn power(
    mesh: &TetMesh,
    velocity: &[Vec3],
    pressure: &[f64],
    test: &[Vec3],
) -> Result<f64, FemError> {
    check_vectors("the velocity", velocity, mesh.n_points())?;
    check_array("the pressure", pressure, mesh.n_vertices())?;
    check_vectors("the test velocity", test, mesh.n_points())?;
    let [power] = sum_over(mesh.cells().len(), |cell| {
        let nodes = &mesh.cells()[cell];
        if nodes
            .iter()
            .all(|&node| test[node as usize] == Vec3::zeros())
        {
            return Ok([0.0]);
        }
        let positions = mesh.cell_points(cell);
        let mut sum = 0.0;
        for point in degree_5() {
            let map = MapAt::new(cell, &positions, point)?;
            let gradients = map.gradients(point);
            let [u, v] = [velocity, test].map(|field| velocity_gradient(nodes, field, &gradients));
            let terms = point.barycentric.iter().zip(nodes);
            let p: f64 = terms
                .map(|(l, &vertex)| l * pressure[vertex as usize])
                .sum();
            sum += map.measure * ((u + u.transpose()).dot(&v) - p * v.trace());
        }
        Ok([sum])
    })?;
    check_array("the power", &[power], 1)?;
    Ok(power)
}

/// Mean of the pressure over the fluid, `∫ p / |Ω|`.
///
/// Exact on quadratic cells. Shapes: `pressure` `n_vertices`.
///
/// # Errors
/// A pressure of the wrong length or not finite; [`FemError::InvertedCell`].
pub fn mean_pressure(mesh: &TetMesh, pressure: &[f64]) -> Result<f64, FemError> {
    pressure_mean_error(mesh, pressure, &|_| 0.0)
}

/// Error norms of a velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct VelocityError {
    /// L2 norm of the error, `(∫ |u_h - u|^2)^(1/2)`.
    pub l2: f64,
    /// H1 seminorm of the error, `(∫ |∇u_h - ∇u|^2)^(1/2)`.
    pub h1_seminorm: f64,
}

/// Error norms of `velocity` against the velocity and gradient `∂u_c/∂x_k` that `exact` returns.
///
/// Quadrature: 24 points per cell, degree 6. Shapes: `velocity` `n_points`.
///
/// # Errors
/// A velocity of the wrong length or not finite; `exact` not finite; [`FemError::InvertedCell`].
pub fn velocity_error(
    mesh: &TetMesh,
    velocity: &[Vec3],
    exact: impl Fn(Vec3) -> (Vec3, Matrix3<f64>) + Sync,
) -> Result<VelocityError, FemError> {
    check_vectors("the velocity", velocity, mesh.n_points())?;
    let sums = sum_over(mesh.cells().len(), |cell| {
        let positions = mesh.cell_points(cell);
        let nodes = &mesh.cells()[cell];
        let mut sums = [0.0; 2];
        for point in degree_6() {
            let map = MapAt::new(cell, &positions, point)?;
            let (u, gradient) = exact(position(&positions, point));
            let mut difference = -u;
            for (&node, value) in nodes.iter().zip(point.shape) {
                difference += value * velocity[node as usize];
            }
            let gradient = velocity_gradient(nodes, velocity, &map.gradients(point)) - gradient;
            sums[0] += map.measure * difference.norm_squared();
            sums[1] += map.measure * gradient.norm_squared();
        }
        Ok(sums)
    })?;
    check_array("the velocity error", &sums, 2)?;
    Ok(VelocityError {
        l2: sums[0].sqrt(),
        h1_seminorm: sums[1].sqrt(),
    })
}

/// L2 error of `pressure` up to a constant, `min_c (∫ (p_h - p - c)^2)^(1/2)`.
///
/// The pressure of an enclosed flow is determined up to a constant, so the mean error is removed.
/// Quadrature: 24 points per cell, degree 6. Shapes: `pressure` `n_vertices`.
///
/// # Errors
/// A pressure of the wrong length or not finite; `exact` not finite; [`FemError::InvertedCell`].
pub fn pressure_error(
    mesh: &TetMesh,
    pressure: &[f64],
    exact: impl Fn(Vec3) -> f64 + Sync,
) -> Result<f64, FemError> {
    let mean = pressure_mean_error(mesh, pressure, &exact)?;
    let [squares, _, _] = pressure_moments(mesh, pressure, &|x| exact(x) + mean)?;
    check_array("the pressure error", &[squares], 1)?;
    Ok(squares.sqrt())
}

/// Mean of `p_h - p`.
fn pressure_mean_error(
    mesh: &TetMesh,
    pressure: &[f64],
    exact: &(impl Fn(Vec3) -> f64 + Sync),
) -> Result<f64, FemError> {
    check_array("the pressure", pressure, mesh.n_vertices())?;
    let [_, integral, volume] = pressure_moments(mesh, pressure, exact)?;
    let mean = [integral / volume];
    check_array("the mean of the pressure", &mean, 1)?;
    Ok(mean[0])
}

/// Integrals of `(p_h - p)^2`, of `p_h - p` and of 1.
fn pressure_moments(
    mesh: &TetMesh,
    pressure: &[f64],
    exact: &(impl Fn(Vec3) -> f64 + Sync),
) -> Result<[f64; 3], FemError> {
    sum_over(mesh.cells().len(), |cell| {
        let positions = mesh.cell_points(cell);
        let nodes = &mesh.cells()[cell];
        let mut moments = [0.0; 3];
        for point in degree_6() {
            let measure = MapAt::new(cell, &positions, point)?.measure;
            let p: f64 = (0..4)
                .map(|q| point.barycentric[q] * pressure[nodes[q] as usize])
                .sum();
            let difference = p - exact(position(&positions, point));
            moments[0] += measure * difference * difference;
            moments[1] += measure * difference;
            moments[2] += measure;
        }
        Ok(moments)
    })
}

/// Position of a quadrature point of a cell.
pub(crate) fn position(nodes: &CellNodes, point: &CellPoint) -> Vec3 {
    nodes
        .iter()
        .zip(point.shape)
        .map(|(x, value)| x * value)
        .sum()
}
