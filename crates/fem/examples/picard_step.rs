//! One Picard step of the Navier-Stokes equations in the unit cube, with a known solution.
//!
//! `-ν Δu + (w · ∇) u + ∇p = f`, `∇·u = 0`, linearised about a given flow `w`: here the interpolant
//! of the solution, whose error does not lower the orders. `u = (sin πy, sin πz, sin πx)` and
//! `p = x y z`; the velocity is prescribed on the boundary. Theory: the errors of the velocity are
//! of order 3 in L2 and 2 in H1, that of the pressure is at least of order 2 in L2.

use std::error::Error;
use std::f64::consts::PI;

use fem::nalgebra::{Matrix3, Vector3};
use fem::{
    DirichletCondition, TaylorHood, continuity_residual, field_error, interpolate, load_vector,
    momentum_residual, pressure_error,
};
use linalg::{
    BlockTriangular, Bordered, Csr, KrylovParams, Multigrid, MultigridParams, SaddleSystem, fgmres,
};
use mesh::{LinearTets, TetMesh};

mod orders;

const VISCOSITY: f64 = 0.1;

/// Exact velocity and its gradient.
fn velocity(x: Vector3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
    let cyclic = PI * Vector3::new(x.y, x.z, x.x);
    let slope = PI * cyclic.map(f64::cos);
    let gradient = Matrix3::new(
        0.0, slope.x, 0.0, //
        0.0, 0.0, slope.y, //
        slope.z, 0.0, 0.0,
    );
    (cyclic.map(f64::sin), gradient)
}

/// Exact pressure, up to a constant.
fn pressure(x: Vector3<f64>) -> f64 {
    x.x * x.y * x.z
}

fn force(x: Vector3<f64>) -> Vector3<f64> {
    let (u, gradient) = velocity(x);
    let pressure_gradient = Vector3::new(x.y * x.z, x.x * x.z, x.x * x.y);
    VISCOSITY * PI * PI * u + gradient * u + pressure_gradient
}

/// Errors of the velocity in L2 and H1 and of the pressure in L2, with `6 n^3` cells.
fn errors(n: u32) -> Result<[f64; 3], Box<dyn Error>> {
    let mesh = TetMesh::straight(LinearTets::cube(n))?;
    let space = TaylorHood::new(&mesh)?;
    let matrices = space.matrices(&mesh)?;
    let divergence = matrices.divergence;
    // The same matrix serves the three components: ∫ ν ∇u · ∇v + v w · ∇u, of degree 5.
    let mut u = interpolate::<_, 10>(&mesh, |x| velocity(x).0)?;
    let oseen = space.assemble(&mesh, 5, |point, matrix: &mut [[f64; 10]; 10]| {
        let w = point.value(&u);
        point.add(matrix, |v, u| {
            VISCOSITY * v.gradient.dot(&u.gradient) + v.value * w.dot(&u.gradient)
        });
    })?;

    // The lift of the boundary values moves to the right-hand side.
    let condition = DirichletCondition::on_boundary(&mesh);
    condition.lift(&mut u)?;
    let no_pressure = vec![0.0; mesh.n_vertices()];
    let image = momentum_residual(&oseen, &divergence, &u, &no_pressure)?;
    let mut rhs = condition.rhs(&load_vector(&mesh, force)?, &image)?;
    rhs.extend(continuity_residual(&divergence, &u)?.iter().map(|r| -r));

    // [A B^T; B 0] of the free nodes; Stokes flow of this viscosity preconditions it.
    let system = |matrix: &Csr| -> Result<_, Box<dyn Error>> {
        Ok(SaddleSystem::new(
            Bordered::scalar(condition.restrict_matrix(matrix, 1)?)?,
            condition.restrict_divergence(&divergence)?,
            Csr::zero((mesh.n_vertices(), 0)),
            None,
            matrices.pressure_mass.map(|m| m / VISCOSITY),
        )?)
    };
    let stokes = system(&matrices.stiffness.map(|k| VISCOSITY * k))?;
    let multigrid = Multigrid::new(stokes.velocity_block(), &MultigridParams::default())?;
    let mut preconditioner = BlockTriangular::new(&stokes, multigrid)?;
    let mut solution = vec![0.0; rhs.len()];
    let params = KrylovParams::default();
    fgmres(
        &system(&oseen)?,
        &mut preconditioner,
        &rhs,
        &mut solution,
        &params,
    )?;

    let (free, p) = solution.split_at(3 * condition.n_free());
    condition.expand(free, &mut u)?;
    let error = field_error(&mesh, &u, velocity)?;
    Ok([
        error.l2,
        error.h1_seminorm,
        pressure_error(&mesh, p, pressure)?,
    ])
}

/// Prints the errors and orders and checks the orders.
pub fn main() -> Result<(), Box<dyn Error>> {
    let names = ["velocity L2", "velocity H1", "pressure L2"];
    let order = orders::print_orders(names, &[3, 6, 12], errors)?;
    assert!((order[0] - 3.0).abs() < 0.2, "velocity in L2: {}", order[0]);
    assert!((order[1] - 2.0).abs() < 0.2, "velocity in H1: {}", order[1]);
    assert!(order[2] > 1.8, "pressure in L2: {}", order[2]);
    Ok(())
}
