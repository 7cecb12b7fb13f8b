//! Integrals over the fluid: dissipation, mean pressure, errors against exact fields.

use mesh::{TetMesh, Vec3};

use crate::error::{FemError, check_array, check_vectors};
use crate::integrals::sum_points;
use crate::nodal_field::check_nodal;
use crate::quadrature::{degree_2, degree_5, degree_6};
use crate::quantity::{Nodal, Quantity};

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
    let rule = |cell: usize| match mesh.is_affine(cell) {
        true => degree_2(),
        false => degree_5(),
    };
    sum_points(mesh, rule, |point| {
        let gradient = point.gradient(velocity);
        // 2 D:D = (G + G^T):(G + G^T) / 2 for the velocity gradient G.
        0.5 * point.weight * (gradient + gradient.transpose()).norm_squared()
    })
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
    let is_at_rest = |node: &u32| test[*node as usize] == Vec3::zeros();
    let rule = |cell: usize| match mesh.cells()[cell].iter().all(is_at_rest) {
        true => &[],
        false => degree_5(),
    };
    sum_points(mesh, rule, |point| {
        let [u, v] = [velocity, test].map(|field| point.gradient(field));
        let p = point.value(pressure);
        point.weight * ((u + u.transpose()).dot(&v) - p * v.trace())
    })
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

/// Error norms of a nodal field.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct FieldError {
    /// L2 norm of the error, `(∫ |u_h - u|^2)^(1/2)`.
    pub l2: f64,
    /// H1 seminorm of the error, `(∫ |∇u_h - ∇u|^2)^(1/2)`.
    pub h1_seminorm: f64,
}

/// Error norms of a field against the value and gradient `∂u_c/∂x_k` that `exact` returns.
///
/// Against zero they are the norms of the field. Quadrature: 24 points per cell, degree 6. Shapes:
/// `field` `n_points` (quadratic) or `n_vertices` (linear).
///
/// ```
/// use mesh::{LinearTets, TetMesh, Vec3};
/// let mesh = TetMesh::straight(LinearTets::cube(2))?;
/// let field = fem::interpolate::<_, 4>(&mesh, |x| x.x + 2.0 * x.y)?;
/// let error = fem::field_error(&mesh, &field, |x| (x.x, Vec3::x()))?;
/// // The error 2 y has the norms (4 / 3)^(1/2) and 2.
/// assert!((error.l2 - (4f64 / 3.0).sqrt()).abs() < 1e-13);
/// assert!((error.h1_seminorm - 2.0).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// A field of the wrong length or not finite; `exact` not finite; [`FemError::InvertedCell`].
pub fn field_error<T: Nodal>(
    mesh: &TetMesh,
    field: &[T],
    exact: impl Fn(Vec3) -> (T, T::Gradient) + Sync,
) -> Result<FieldError, FemError> {
    check_nodal(mesh, "the field", field)?;
    let [l2, h1] = sum_points(
        mesh,
        |_| degree_6(),
        |point| {
            let (u, exact_gradient) = exact(point.position());
            let mut difference = T::zero();
            difference.add_scaled(-1.0, &u);
            point.add_value(field, &mut difference);
            let mut gradient = point.gradient(field);
            gradient.add_scaled(-1.0, &exact_gradient);
            [difference.norm_squared(), gradient.norm_squared()].map(|square| point.weight * square)
        },
    )?;
    Ok(FieldError {
        l2: l2.sqrt(),
        h1_seminorm: h1.sqrt(),
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
    sum_points(
        mesh,
        |_| degree_6(),
        |point| {
            let difference = point.value(pressure) - exact(point.position());
            let weighted = point.weight * difference;
            [weighted * difference, weighted, point.weight]
        },
    )
}
