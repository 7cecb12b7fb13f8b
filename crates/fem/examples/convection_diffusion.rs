//! Convection and diffusion in the unit cube, an unsymmetric scalar problem with a known solution.
//!
//! `-κ Δu + w · ∇u = f` with the divergence-free wind `w = (y, -x, 1)` and Péclet numbers `|w| / κ`
//! up to 35; `u = exp(k · x)` is prescribed on the boundary. Theory: order 3 in L2, 2 in H1.

use std::error::Error;

use fem::nalgebra::Vector3;
use fem::{DirichletCondition, TaylorHood, field_error, interpolate, load_vector};
use linalg::{CsrOperator, KrylovParams, MultigridParams, ScalarMultigrid, fgmres};
use mesh::{LinearTets, TetMesh};

mod orders;

const DIFFUSIVITY: f64 = 0.05;
const K: Vector3<f64> = Vector3::new(2.0, -1.0, 3.0);

fn wind(x: Vector3<f64>) -> Vector3<f64> {
    Vector3::new(x.y, -x.x, 1.0)
}

/// Exact solution and its gradient.
fn exact(x: Vector3<f64>) -> (f64, Vector3<f64>) {
    let u = K.dot(&x).exp();
    (u, u * K)
}

fn source(x: Vector3<f64>) -> f64 {
    (wind(x).dot(&K) - DIFFUSIVITY * K.norm_squared()) * exact(x).0
}

/// Errors in L2 and H1 with `6 n^3` cells.
fn errors(n: u32) -> Result<[f64; 2], Box<dyn Error>> {
    let mesh = TetMesh::straight(LinearTets::cube(n))?;
    let space = TaylorHood::new(&mesh)?;
    // v is the test and u the trial function; the integrand has degree 2 + 1 + 1.
    let matrix = space.assemble(&mesh, 4, |point, matrix: &mut [[f64; 10]; 10]| {
        let w = wind(point.position());
        point.add(matrix, |v, u| {
            DIFFUSIVITY * v.gradient.dot(&u.gradient) + v.value * w.dot(&u.gradient)
        });
    })?;
    let condition = DirichletCondition::on_boundary(&mesh);
    let mut u = interpolate::<_, 10>(&mesh, |x| exact(x).0)?;
    let (a, rhs) = condition.reduce(&matrix, &load_vector(&mesh, source)?, &u)?;

    // Multigrid needs a symmetric matrix: that of the diffusion preconditions the whole.
    let diffusion = space.stiffness(&mesh)?.map(|k| DIFFUSIVITY * k);
    let diffusion = CsrOperator::new(condition.restrict_matrix(&diffusion, 1)?)?;
    let mut multigrid = ScalarMultigrid::new(&diffusion, &MultigridParams::default())?;
    let (a, params) = (CsrOperator::new(a)?, KrylovParams::default());
    let mut solution = vec![0.0; rhs.len()];
    fgmres(&a, &mut multigrid, &rhs, &mut solution, &params)?;

    condition.expand(&solution, &mut u)?;
    let error = field_error(&mesh, &u, exact)?;
    Ok([error.l2, error.h1_seminorm])
}

/// Prints the errors and orders and checks the orders.
pub fn main() -> Result<(), Box<dyn Error>> {
    let [l2, h1] = orders::print_orders(["L2", "H1"], &[2, 4, 8], errors)?;
    assert!((l2 - 3.0).abs() < 0.2, "order in L2: {l2}");
    assert!((h1 - 2.0).abs() < 0.2, "order in H1: {h1}");
    Ok(())
}
